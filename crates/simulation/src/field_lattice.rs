//! The room's error on a lattice, as other programs take it: displacements, x fastest.

use super::arrows::coordinates_mm;
use super::metric::Statistics;
use nalgebra::{Point3, Unit, Vector3};
use rayon::prelude::*;
use trackwright_field::compensation::{Compensator, Method};
use trackwright_field::model::Evaluation;
use trackwright_field::samples::{MapKind, PoseError};
use trackwright_field::{AxisModel, DistortionModel, OutsidePolicy};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_geometry::rotation::{axis_rotation, exp_vector, log_quaternion};
use trackwright_result::{Section, count, data, mm, text, vector};
use trackwright_task::{CancelToken, Cancelled, Task};

/// Most points of a lattice: some 2 GB while it is made, and a cube of 256 on a side.
pub const MAX_POINTS: usize = 1 << 24;

/// Layers across z that one core does before it looks whether anyone still wants them.
const SLAB: usize = 2;

/// Readings that are inverted between two reports of progress.
const READINGS: usize = 1 << 16;

/// A side that is so much longer than whole steps, as a part of a step, is round-off.
const WHOLE_STEPS: f64 = 1e-9;

/// Which sensor is imagined at each point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FieldSensor {
    /// One along this axis, tracker frame.
    Along(Unit<Vector3<f64>>),
    /// One along each of the model's basis orientations: the mean of their errors.
    MeanOfBasis,
}

/// What is displaced from where to where.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Displacement {
    /// Measured minus true position, at the true one.
    Error,
    /// True minus measured position, at the measured one.
    Correction,
}

/// Where to sample, and what.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldPlan {
    pub sensor: FieldSensor,
    pub displacement: Displacement,
    /// What the lattice spans, tracker frame.
    pub bounds: Bounds,
    /// Points along x, y and z; one alone is in the middle.
    pub counts: [usize; 3],
    /// Requested along each axis; that of the lattice where there is one point.
    pub spacing_mm: [f64; 3],
    pub outside: OutsidePolicy,
}

/// Displacements on a lattice, x fastest and z slowest.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldLattice {
    pub plan: FieldPlan,
    /// Tracker frame, mm; NaN where there is no answer.
    pub displacement_mm: Vec<Vector3<f64>>,
    /// The angle of the rotation that goes with it; `None` for a room without orientations.
    pub angle_rad: Option<Vec<f64>>,
    /// Whether the model was evaluated outside its box.
    pub is_outside: Vec<bool>,
}

/// Why a field cannot be sampled.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FieldLatticeError {
    #[error(
        "the lattice would have {} points, expected at most {MAX_POINTS}; a spacing of {fitting_mm} mm would fit",
        in_figures(*points)
    )]
    TooManyPoints { points: f64, fitting_mm: f64 },
    #[error(
        "found a correction map, which gives the error at the measured position; expected a distortion map for the \
         error at the true one"
    )]
    NeedsDistortionMap,
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Counts beyond 2⁵³ are no counts any more.
fn in_figures(points: f64) -> String {
    match points < 1e15 {
        true => format!("{points:.0}"),
        false => format!("{points:.1e}"),
    }
}

impl FieldPlan {
    /// A lattice that begins and ends with the box, its steps as long as whole ones can be without
    /// being longer than requested. Spacings are above zero, the box is no box upside down.
    ///
    /// # Errors
    /// [`FieldLatticeError::TooManyPoints`].
    pub fn spanning(
        bounds: Bounds,
        spacing_mm: [f64; 3],
        sensor: FieldSensor,
        displacement: Displacement,
        outside: OutsidePolicy,
    ) -> Result<Self, FieldLatticeError> {
        let size = bounds.size_mm();
        let counts =
            [0, 1, 2].map(|k| (size[k] / spacing_mm[k] - WHOLE_STEPS).ceil().max(0.0) + 1.0);
        let points: f64 = counts.iter().product();
        // Also where something is not finite.
        if points.is_nan() || points > MAX_POINTS as f64 {
            let coarser = (points / MAX_POINTS as f64).cbrt();
            let largest = spacing_mm.iter().copied().fold(0.0, f64::max);
            return Err(FieldLatticeError::TooManyPoints {
                points,
                // A point more on each side than whole steps, so a little on top.
                fitting_mm: (largest * coarser * 1.01 * 100.0).ceil() / 100.0,
            });
        }
        Ok(Self {
            sensor,
            displacement,
            bounds,
            counts: counts.map(|count| count as usize),
            spacing_mm,
            outside,
        })
    }

    /// What the lattice's steps are.
    pub fn step_mm(&self) -> [f64; 3] {
        let size = self.bounds.size_mm();
        [0, 1, 2].map(|k| match self.counts[k] {
            1 => self.spacing_mm[k],
            count => size[k] / (count - 1) as f64,
        })
    }

    /// What the numbers are, in words for whoever opens the file.
    pub fn meaning(&self) -> String {
        let what = match self.displacement {
            Displacement::Error => "measured minus true position, at the true position",
            Displacement::Correction => "true minus measured position, at the measured position",
        };
        let sensor = match self.sensor {
            FieldSensor::Along(axis) => {
                format!("sensor along ({}, {}, {})", axis.x, axis.y, axis.z)
            }
            FieldSensor::MeanOfBasis => "mean over the model's basis orientations".to_owned(),
        };
        format!("{what}, mm; {sensor} in the tracker frame")
    }
}

impl FieldLattice {
    /// Where each displacement begins, tracker frame, with its index; x fastest.
    pub fn points(&self) -> impl Iterator<Item = Point3<f64>> {
        let [xs, ys, zs] = coordinates_mm(&self.plan.bounds, self.plan.counts);
        zs.into_iter().flat_map(move |z| {
            let xs = xs.clone();
            let row = move |y: f64| xs.clone().into_iter().map(move |x| Point3::new(x, y, z));
            ys.clone().into_iter().flat_map(row)
        })
    }

    /// Lengths of all displacements that there are.
    pub fn lengths_mm(&self) -> Vec<f64> {
        let lengths = self.displacement_mm.iter().map(Vector3::norm);
        lengths.filter(|length| length.is_finite()).collect()
    }

    /// Points without an answer.
    pub fn missing(&self) -> usize {
        self.displacement_mm.len() - self.lengths_mm().len()
    }

    /// What was sampled, and how large it is.
    pub fn section(&self) -> Section {
        let plan = &self.plan;
        let [nx, ny, nz] = plan.counts;
        let (min, max): ([f64; 3], [f64; 3]) = plan.bounds.into();
        let outside = self.is_outside.iter().filter(|is| **is).count();
        let displacement = match plan.displacement {
            Displacement::Error => "error",
            Displacement::Correction => "correction",
        };
        let sizes = Statistics::of(&mut self.lengths_mm()).map(|size| {
            [
                mm("displacement_mm.rms", "displacement, RMS", size.rms()),
                data("displacement_mm.p95", size.p95()),
                mm("displacement_mm.max", "displacement, largest", size.max()),
            ]
        });
        Section::of([
            text("", "points", format!("{nx} x {ny} x {nz}")),
            data("points", self.displacement_mm.len()),
            data("counts", plan.counts),
            vector("spacing_mm", "step", plan.step_mm(), 3, "mm"),
            vector("", "from", min, 3, "mm"),
            vector("", "to", max, 3, "mm"),
            data("box", [min, max]),
            data("displacement", displacement),
            count("outside", "outside the model's box", outside),
            count("missing", "without an answer", self.missing()),
            data("displacement_mm", ()),
        ])
        .with_all(sizes.into_iter().flatten())
        .with(plan.meaning())
    }
}

/// The displacements of a plan.
///
/// # Errors
/// See [`FieldLatticeError`].
pub fn sample_field(
    model: &DistortionModel,
    plan: &FieldPlan,
    task: &Task,
) -> Result<FieldLattice, FieldLatticeError> {
    let axes = match &plan.sensor {
        FieldSensor::Along(axis) => std::slice::from_ref(axis),
        FieldSensor::MeanOfBasis => model.directions().directions(),
    };
    let sampled = match (plan.displacement, model.map()) {
        (Displacement::Error, MapKind::Correction) => {
            return Err(FieldLatticeError::NeedsDistortionMap);
        }
        (Displacement::Error, MapKind::Distortion) => errors(model, plan, axes, task)?,
        (Displacement::Correction, _) => corrections(model, plan, axes, task)?,
    };
    let has_angles = model.coefficients().iter().any(|[_, _, _, turn @ ..]| *turn != [0.0; 3]);
    let angles = || sampled.iter().map(|at| at.error.rotation_rad.norm()).collect();
    Ok(FieldLattice {
        plan: *plan,
        angle_rad: has_angles.then(angles),
        displacement_mm: sampled.iter().map(|at| at.error.position_mm).collect(),
        is_outside: sampled.iter().map(|at| !at.is_inside).collect(),
    })
}

/// By sum factorisation, some layers at a time.
fn errors(
    model: &DistortionModel,
    plan: &FieldPlan,
    axes: &[Unit<Vector3<f64>>],
    task: &Task,
) -> Result<Vec<Evaluation>, Cancelled> {
    let models: Vec<AxisModel> = axes.iter().map(|axis| model.at_axis(axis)).collect();
    let [xs, ys, zs] = coordinates_mm(&plan.bounds, plan.counts);
    let layers: Vec<Vec<Evaluation>> = zs
        .par_chunks(SLAB)
        .enumerate()
        .map_init(MeanErrors::default, |buffers, (slab, some)| {
            task.step(slab * SLAB, zs.len())?;
            let means = buffers
                .of(&models, [&xs, &ys, some], plan.outside, &task.cancel)
                .ok_or(Cancelled)?;
            let (ny, nz) = (ys.len(), some.len());
            let mut turned = Vec::with_capacity(means.len());
            for z in 0..nz {
                for y in 0..ny {
                    let row = (0..xs.len()).map(|x| means[(x * ny + y) * nz + z]);
                    turned.extend(row.map(|at| kept(at, plan.outside)));
                }
            }
            Ok(turned)
        })
        .collect::<Result<_, Cancelled>>()?;
    Ok(layers.concat())
}

/// A rejected point has no error.
fn kept(at: Evaluation, outside: OutsidePolicy) -> Evaluation {
    match at.is_inside || outside != OutsidePolicy::Reject {
        true => at,
        false => nothing(),
    }
}

fn nothing() -> Evaluation {
    Evaluation {
        error: PoseError {
            position_mm: Vector3::repeat(f64::NAN),
            rotation_rad: Vector3::repeat(f64::NAN),
        },
        is_inside: false,
    }
}

/// True minus measured at every point, as a [`Compensator`] finds it.
fn corrections(
    model: &DistortionModel,
    plan: &FieldPlan,
    axes: &[Unit<Vector3<f64>>],
    task: &Task,
) -> Result<Vec<Evaluation>, Cancelled> {
    let compensator = Compensator::new(model, plan.outside, Method::of(model.map()));
    let rotations: Vec<_> = axes
        .iter()
        .map(|axis| exp_vector(&axis_rotation(&Vector3::z_axis(), axis).vector_rad))
        .collect();
    let [xs, ys, zs] = coordinates_mm(&plan.bounds, plan.counts);
    let (nx, ny) = (xs.len(), ys.len());
    let all = nx * ny * zs.len();
    let quiet = Task::cancelled_by(task.cancel.clone());
    let mut corrections = Vec::with_capacity(all);
    for start in (0..all).step_by(READINGS) {
        task.step(start, all)?;
        let some = start..(start + READINGS).min(all);
        let mut sums = vec![zero(); some.len()];
        for turn in &rotations {
            let measured: Vec<Pose> = some
                .clone()
                .map(|i| Vector3::new(xs[i % nx], ys[i / nx % ny], zs[i / (nx * ny)]))
                .map(|at| pose_from_parts(at, *turn))
                .collect();
            let found = compensator.compensate(&measured, &quiet)?;
            for ((sum, found), read) in sums.iter_mut().zip(found).zip(&measured) {
                add(sum, &found.pose.map_or_else(nothing, |pose| moved(read, &pose)));
                sum.is_inside &= found.is_inside;
            }
        }
        for sum in &mut sums {
            sum.error.position_mm /= rotations.len() as f64;
            sum.error.rotation_rad /= rotations.len() as f64;
        }
        corrections.append(&mut sums);
    }
    Ok(corrections)
}

/// What takes one pose to another.
fn moved(from: &Pose, to: &Pose) -> Evaluation {
    Evaluation {
        error: PoseError {
            position_mm: to.translation.vector - from.translation.vector,
            rotation_rad: log_quaternion(&from.rotation.rotation_to(&to.rotation)),
        },
        is_inside: true,
    }
}

fn zero() -> Evaluation {
    Evaluation { error: PoseError::default(), is_inside: true }
}

fn add(sum: &mut Evaluation, at: &Evaluation) {
    sum.error.position_mm += at.error.position_mm;
    sum.error.rotation_rad += at.error.rotation_rad;
}

/// Means over several sensors on a lattice, with the buffers for them.
#[derive(Default)]
pub(super) struct MeanErrors {
    evaluations: Vec<Evaluation>,
    means: Vec<Evaluation>,
}

impl MeanErrors {
    /// The mean error of some models at every point, x slowest and z fastest; `None` when cancelled.
    pub(super) fn of(
        &mut self,
        models: &[AxisModel],
        coordinates_mm: [&[f64]; 3],
        outside: OutsidePolicy,
        cancel: &CancelToken,
    ) -> Option<&[Evaluation]> {
        self.means.clear();
        let points = coordinates_mm.iter().map(|c| c.len()).product();
        self.means.resize(points, zero());
        for model in models {
            if cancel.is_cancelled() {
                return None;
            }
            model.evaluate_lattice(coordinates_mm, outside, &mut self.evaluations);
            for (sum, at) in self.means.iter_mut().zip(&self.evaluations) {
                add(sum, at);
                sum.is_inside = at.is_inside;
            }
        }
        for sum in &mut self.means {
            sum.error.position_mm /= models.len() as f64;
            sum.error.rotation_rad /= models.len() as f64;
        }
        Some(&self.means)
    }
}
