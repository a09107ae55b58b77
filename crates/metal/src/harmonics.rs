//! The metal's disturbance in a box as harmonic functions: sampled, fitted, and compared with itself at
//! other places.

use crate::cells::{NearMetal, Part};
use faer::Mat;
use nalgebra::{Unit, Vector3};
use std::sync::Arc;
use trackwright_field::generator::reading::{LEVER_MM, axis_error};
use trackwright_field::harmonic::HarmonicModel;
use trackwright_field::harmonic::solid_harmonics::{MAX_DEGREE, gradients, terms};
use trackwright_field::samples::PoseError;
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::directions::DirectionSet;

/// Largest difference of what a sensor is reported at by the harmonics and by the metal itself, in mm of
/// position and of rotation at [`LEVER_MM`].
pub const TOLERANCE_MM: f64 = 0.01;

/// What is reached at the places that are compared: others are up to twice as far off.
const REACHED_MM: f64 = TOLERANCE_MM / 2.0;

/// Degrees that are tried; the first that is near enough is taken.
const DEGREES: [usize; 2] = [6, MAX_DEGREE];

/// Places that are fitted to: 3 equations each, three and a half times the unknowns of the highest degree.
const FITTED: usize = 140;

/// Other places, each with 13 axes.
const COMPARED: usize = 12;

/// Where a box is sampled, and the equations of that: the same for all boxes of its proportions, whatever
/// metal is around them.
#[derive(Clone, Debug)]
pub(crate) struct Sampling {
    size_mm: Vector3<f64>,
    /// In the unit cube.
    fitted: Vec<Vector3<f64>>,
    compared: Vec<Vector3<f64>>,
    axes: Vec<Unit<Vector3<f64>>>,
    /// Of the matrix of the highest degree; a lower one has its first columns.
    q: Mat<f64>,
    r: Mat<f64>,
}

impl Sampling {
    /// For boxes of some proportions.
    pub fn new(size_mm: &Vector3<f64>) -> Self {
        let fitted = places(FITTED, 0.5);
        let columns = terms(MAX_DEGREE);
        let rows: Vec<Vec<Vector3<f64>>> = fitted
            .iter()
            .map(|unit| {
                let mut slopes = vec![Vector3::zeros(); columns];
                let x = (unit - Vector3::repeat(0.5)).component_mul(size_mm) * 2.0 / size_mm.norm();
                gradients(MAX_DEGREE, &x, &mut slopes);
                slopes
            })
            .collect();
        let matrix = Mat::from_fn(3 * fitted.len(), columns, |i, j| rows[i / 3][j][i % 3]);
        let qr = matrix.qr();
        Self {
            size_mm: *size_mm,
            fitted,
            compared: places(COMPARED, 0.0),
            // An axis turned round has the same error.
            axes: DirectionSet::TwentySix.up_to_sign().copied().collect(),
            q: qr.compute_thin_Q(),
            r: qr.thin_R().to_owned(),
        }
    }

    pub fn size_mm(&self) -> &Vector3<f64> {
        &self.size_mm
    }

    /// Harmonics of the least degree that is near enough to the field of all but some bodies in a box of these
    /// proportions, sampled by what makes it in a larger one; `None` where none is, and where such metal is in
    /// the box.
    pub fn fit(
        &self,
        bounds: &Bounds,
        field: &impl NearMetal,
        near: &[usize],
        by: &Part,
    ) -> Option<Arc<HarmonicModel>> {
        let at = |unit: &Vector3<f64>| bounds.min_mm + bounds.size_mm().component_mul(unit);
        let sampled = |unit: &Vector3<f64>| by.disturbance_without(field, near, &at(unit));
        let sampled: Vec<_> = self.fitted.iter().map(sampled).collect::<Option<_>>()?;
        let coils = field.generator().coils.len();
        let right = Mat::from_fn(3 * sampled.len(), coils, |i, c| sampled[i / 3][c][i % 3]);
        let projected = self.q.transpose() * &right;
        let exact = |unit: &Vector3<f64>| field.disturbance_without(near, &at(unit));
        let exact: Vec<_> = self.compared.iter().map(exact).collect::<Option<_>>()?;
        // What is read depends on the near metal as well. In it nothing is read.
        let beside: Vec<_> =
            self.compared.iter().map(|unit| field.disturbance_of(near, &at(unit))).collect();
        DEGREES.into_iter().find_map(|degree| {
            let model = HarmonicModel::new(
                field.generator().clone(),
                bounds.center_mm(),
                bounds.size_mm().norm() / 2.0,
                degree,
                self.solved(&projected, terms(degree)),
            );
            // Coefficients that are not finite are of a field that is not.
            let model = model.ok()?;
            let mut found = vec![Vector3::zeros(); coils];
            let each = self.compared.iter().zip(&exact).zip(&beside);
            let is_near = each.into_iter().all(|((unit, exact), beside)| {
                let Some(beside) = beside else { return true };
                let place = at(unit);
                model.disturbance(&place, &mut found);
                let [found, exact] = [&found, exact].map(|far| sum(far, beside));
                self.axes.iter().all(|axis| {
                    let of =
                        |fields: &[_]| axis_error(field.generator(), &place, axis, fields).ok();
                    difference_mm(of(&found), of(&exact)) <= REACHED_MM
                })
            });
            is_near.then(|| Arc::new(model))
        })
    }

    /// Least squares of the first columns, coil after coil.
    fn solved(&self, projected: &Mat<f64>, columns: usize) -> Vec<f64> {
        let mut all = Vec::with_capacity(columns * projected.ncols());
        for coil in 0..projected.ncols() {
            let mut x: Vec<f64> = (0..columns).map(|k| projected[(k, coil)]).collect();
            for k in (0..columns).rev() {
                let known: f64 = (k + 1..columns).map(|j| self.r[(k, j)] * x[j]).sum();
                x[k] = (x[k] - known) / self.r[(k, k)];
            }
            all.append(&mut x);
        }
        all
    }
}

/// Places spread over the unit cube, denser towards its faces, where a field varies most; `shift` gives
/// others.
///
/// The sequence of Roberts: multiples of the powers of the inverse root of `x⁴ = x + 1`.
fn places(count: usize, shift: f64) -> Vec<Vector3<f64>> {
    const STEP: [f64; 3] =
        [0.819_172_513_396_164_4, 0.671_043_606_703_789_1, 0.549_700_477_901_970_3];
    let place = |k: usize| {
        Vector3::from_fn(|axis, _| {
            let even = (shift + STEP[axis] * (k + 1) as f64).fract();
            0.5 - 0.5 * (std::f64::consts::PI * even).cos()
        })
    };
    (0..count).map(place).collect()
}

fn sum(one: &[Vector3<f64>], other: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    one.iter().zip(other).map(|(one, other)| one + other).collect()
}

/// Infinite where one of both is reported and the other not.
fn difference_mm(found: Option<PoseError>, exact: Option<PoseError>) -> f64 {
    match (found, exact) {
        (Some(found), Some(exact)) => {
            let turned = (found.rotation_rad - exact.rotation_rad).norm();
            (found.position_mm - exact.position_mm).norm().max(turned * LEVER_MM)
        }
        (None, None) => 0.0,
        _ => f64::INFINITY,
    }
}
