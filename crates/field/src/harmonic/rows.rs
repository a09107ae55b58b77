//! Measurements as linear equations in the coefficients of the harmonics, in mm.
//!
//! With `J = Q R` the signals' Jacobian at the measured pose and `W = R⁻¹ Qᵀ`, a measurement gives
//! `W (s(measured) − s(true)) = W (n · Σ a ∇Y(true))`, exact but for the part of the signals that
//! no pose can explain: 5 rows, or 6 of a sensor with three axes.

use super::solid_harmonics::{MAX_TERMS, gradients, terms};
use crate::generator::Generator;
use crate::generator::reading::{Orientation, ReadingError, for_rows};
use crate::samples::{Measurement, MeasurementContent};
use faer::Mat;
use nalgebra::{DMatrix, DVector, Point3, Unit, UnitQuaternion, Vector3};
use rayon::prelude::*;
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::pose::Pose;
use trackwright_task::{Cancelled, Task};

/// Part of a column of the signals' Jacobian that has to be independent of the columns before it;
/// as where readings are found, whose squares are compared.
const MIN_INDEPENDENT: f64 = 1e-6;

/// Measurements between two checks for a cancel.
const CHUNK: usize = 256;

/// What the rows have of the room and not of the generator.
pub(super) struct Harmonics {
    pub(super) center_mm: Point3<f64>,
    pub(super) scale_mm: f64,
    /// Terms a coil.
    pub(super) terms: usize,
    /// For each axis of the sensor `n·∇Y`, a measurement a row.
    pub(super) slopes: Vec<Mat<f64>>,
}

/// What the rows have of the generator: for each measurement its `W` and the left side above.
pub struct Maps {
    pub(super) coils: usize,
    pub(super) axes: usize,
    /// Rows a measurement.
    pub(super) dof: usize,
    /// `W`, measurement after measurement, each row by row; columns axis by axis, coil by coil.
    pub(super) maps: Vec<f64>,
    /// [`Self::dof`] a measurement.
    pub(super) right: Vec<f64>,
}

/// Why there is no solution.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SolveError {
    /// A measurement whose signals determine no pose.
    #[error("measurement {measurement} (counted from 0): {cause}")]
    Reading { measurement: usize, cause: ReadingError },
    /// The rows do not determine the coefficients and the ridge is too small to.
    #[error("the rows do not determine the coefficients")]
    NotDetermined,
    #[error("cancelled")]
    Cancelled,
}

impl From<Cancelled> for SolveError {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

impl Harmonics {
    /// About the middle of the box of the true positions, scaled by half its diagonal. A box
    /// without size has the scale 1 mm.
    pub(super) fn new(
        measurements: &[Measurement],
        content: MeasurementContent,
        degree: usize,
    ) -> Self {
        let positions =
            measurements.iter().map(|m| Point3::from(m.tracker_from_ideal.translation.vector));
        let (center_mm, scale_mm) = ball(positions);
        let terms = terms(degree);
        let axes = if content == MeasurementContent::SixDof { 3 } else { 1 };
        let mut slopes = vec![Mat::zeros(measurements.len(), terms); axes];
        let mut at = [Vector3::zeros(); MAX_TERMS];
        for (row, m) in measurements.iter().enumerate() {
            let ideal = &m.tracker_from_ideal;
            let x = (ideal.translation.vector - center_mm.coords) / scale_mm;
            gradients(degree, &x, &mut at);
            for (axis, slopes) in slopes.iter_mut().enumerate() {
                // A sensor with one axis has it along its z.
                let unit = Vector3::ith(if axes == 1 { 2 } else { axis }, 1.0);
                let n = ideal.rotation * unit;
                for (k, slope) in at[..terms].iter().enumerate() {
                    slopes[(row, k)] = n.dot(slope);
                }
            }
        }
        Self { center_mm, scale_mm, terms, slopes }
    }

    pub(super) fn measurements(&self) -> usize {
        self.slopes[0].nrows()
    }
}

/// Middle of a box around points and half its diagonal.
fn ball(points: impl Iterator<Item = Point3<f64>>) -> (Point3<f64>, f64) {
    let Some(bounds) = Bounds::around(points) else {
        return (Point3::origin(), 1.0);
    };
    let half = 0.5 * bounds.diagonal_mm();
    (bounds.center_mm(), if half > 0.0 { half } else { 1.0 })
}

impl Maps {
    /// Of measurements with orientations.
    ///
    /// # Errors
    /// A measurement whose signals determine no pose, a cancel.
    pub fn new(
        task: &Task,
        generator: &Generator,
        measurements: &[Measurement],
        content: MeasurementContent,
    ) -> Result<Self, SolveError> {
        let is_six = content == MeasurementContent::SixDof;
        let (axes, dof) = if is_six { (3, 6) } else { (1, 5) };
        let coils = generator.coils.len();
        let chunks: Vec<_> = measurements
            .par_chunks(CHUNK)
            .enumerate()
            .map(|(chunk, part)| {
                task.step(0, 1)?;
                let mut maps = Vec::with_capacity(part.len() * dof * axes * coils);
                let mut right = Vec::with_capacity(part.len() * dof);
                for (k, m) in part.iter().enumerate() {
                    let out = (&mut maps, &mut right);
                    let result = if is_six {
                        push::<3, 3, 6, UnitQuaternion<f64>>(generator, m, |p| p.rotation, out)
                    } else {
                        push::<1, 2, 5, Unit<Vector3<f64>>>(generator, m, axis_of, out)
                    };
                    result.map_err(|cause| SolveError::Reading {
                        measurement: chunk * CHUNK + k,
                        cause,
                    })?;
                }
                Ok::<_, SolveError>((maps, right))
            })
            .collect();
        let mut all = Self {
            coils,
            axes,
            dof,
            maps: Vec::with_capacity(measurements.len() * dof * axes * coils),
            right: Vec::with_capacity(measurements.len() * dof),
        };
        // In order, so that the first measurement that is wrong is named.
        for chunk in chunks {
            let (maps, right) = chunk?;
            all.maps.extend(maps);
            all.right.extend(right);
        }
        Ok(all)
    }

    /// `W` of a measurement, row by row.
    #[inline]
    pub fn map(&self, measurement: usize) -> &[f64] {
        let len = self.dof * self.signals();
        &self.maps[measurement * len..][..len]
    }

    /// `W (s(measured) − s(true))` of a measurement, in mm: positions first, then rotations at the lever.
    #[inline]
    pub fn right(&self, measurement: usize) -> &[f64] {
        &self.right[measurement * self.dof..][..self.dof]
    }

    /// Rows of a measurement.
    #[inline]
    pub fn dof(&self) -> usize {
        self.dof
    }

    /// Signals of a measurement.
    #[inline]
    pub fn signals(&self) -> usize {
        self.axes * self.coils
    }
}

/// The axis of a sensor with one.
pub(super) fn axis_of(pose: &Pose) -> Unit<Vector3<f64>> {
    pose.rotation * Vector3::z_axis()
}

/// Appends `W` and `W (s(measured) − s(true))`.
fn push<const AXES: usize, const ROTATIONS: usize, const UNKNOWNS: usize, O>(
    generator: &Generator,
    m: &Measurement,
    orientation: impl Fn(&Pose) -> O,
    (maps, right): (&mut Vec<f64>, &mut Vec<f64>),
) -> Result<(), ReadingError>
where
    O: Orientation<AXES, ROTATIONS>,
{
    let coils = generator.coils.len();
    let mut jacobian = DMatrix::zeros(AXES * coils, UNKNOWNS);
    let mut gap = DVector::zeros(AXES * coils);
    let place = |pose: &Pose| Point3::from(pose.translation.vector);
    let measured = &m.tracker_from_measured;
    for_rows::<AXES, ROTATIONS, UNKNOWNS, O>(
        generator,
        &place(measured),
        &orientation(measured),
        |coil, axis, signal, row| {
            let at = axis * coils + coil;
            gap[at] = signal;
            for (column, value) in row.iter().enumerate() {
                jacobian[(at, column)] = *value;
            }
        },
    );
    let ideal = &m.tracker_from_ideal;
    let position = place(ideal);
    let axes = orientation(ideal).axes();
    for (coil, source) in generator.coils.iter().enumerate() {
        let field = source.field(&position);
        for (axis, n) in axes.iter().enumerate() {
            gap[axis * coils + coil] -= n.dot(&field);
        }
    }
    if !(jacobian.iter().all(|v| v.is_finite()) && gap.iter().all(|v| v.is_finite())) {
        return Err(ReadingError::NotFinite);
    }
    if AXES * coils < UNKNOWNS {
        return Err(ReadingError::RankLoss { column: AXES * coils, unknowns: UNKNOWNS });
    }
    let sizes: Vec<_> = jacobian.column_iter().map(|c| c.norm()).collect();
    let qr = jacobian.qr();
    let r = qr.r();
    for (column, size) in sizes.iter().enumerate() {
        if r[(column, column)].abs() <= MIN_INDEPENDENT * size {
            return Err(ReadingError::RankLoss { column, unknowns: UNKNOWNS });
        }
    }
    let map = r.solve_upper_triangular(&qr.q().transpose()).ok_or(ReadingError::NotFinite)?;
    maps.extend(map.transpose().iter());
    right.extend((map * gap).iter());
    Ok(())
}
