//! The compiled form of a harmonic model: its errors over a box, sampled and interpolated.

use super::HarmonicModel;
use crate::field::compiled::CompiledField;
use crate::field::compiled::even_harmonics::{self, MAX_FUNCTIONS, functions};
use crate::field::model::Coefficient;
use crate::geometry::bounds::Bounds;
use nalgebra::{DMatrix, Point3, Unit, Vector3};
use std::f64::consts::TAU;

/// Highest degree of the compiled form in the axis.
const AXIS_DEGREE: usize = 6;

/// Axes that a node's errors are taken at: rings of equal height over a half sphere, since an axis
/// turned round reads the same.
const RINGS: usize = 6;
const AXES_A_RING: usize = 10;

/// Length of a cell. The field of metal outside of the volume changes over longer ones.
const CELL_MM: f64 = 40.0;

impl HarmonicModel {
    /// The compiled form over a box. Where the tracker reports no reading, the error to first order
    /// stands for it, and none where there is none.
    pub fn compiled(&self, bounds: &Bounds) -> CompiledField {
        let axes = axes();
        let from_values = from_values(&axes);
        CompiledField::new(*bounds, CELL_MM, AXIS_DEGREE, |places| {
            places
                .iter()
                .map(|place| self.harmonics_at(place, &axes, &from_values))
                .collect()
        })
    }

    fn harmonics_at(
        &self,
        place: &Point3<f64>,
        axes: &[Unit<Vector3<f64>>],
        from_values: &DMatrix<f64>,
    ) -> Vec<Coefficient> {
        let mut values = DMatrix::zeros(axes.len(), 6);
        for (mut row, axis) in values.row_iter_mut().zip(axes) {
            let error = self
                .axis_error_at(place, axis)
                .or_else(|_| self.linear_axis_error_at(place, axis))
                .unwrap_or_default();
            for k in 0..3 {
                row[k] = error.position_mm[k];
                row[k + 3] = error.rotation_rad[k];
            }
        }
        let found = from_values * values;
        found
            .row_iter()
            .map(|row| std::array::from_fn(|c| row[c]))
            .collect()
    }
}

fn axes() -> Vec<Unit<Vector3<f64>>> {
    let ring = |i: usize| {
        let z = (i as f64 + 0.5) / RINGS as f64;
        let across = (1.0 - z * z).sqrt();
        (0..AXES_A_RING).map(move |k| {
            // Rings are turned against each other.
            let turn = TAU * (k as f64 + 0.5 * (i % 2) as f64) / AXES_A_RING as f64;
            Unit::new_normalize(Vector3::new(across * turn.cos(), across * turn.sin(), z))
        })
    };
    (0..RINGS).flat_map(ring).collect()
}

/// Least squares: coefficients of the even harmonics from values at axes.
fn from_values(axes: &[Unit<Vector3<f64>>]) -> DMatrix<f64> {
    let count = functions(AXIS_DEGREE);
    let mut basis = DMatrix::zeros(axes.len(), count);
    for (mut row, axis) in basis.row_iter_mut().zip(axes) {
        let mut values = [0.0; MAX_FUNCTIONS];
        even_harmonics::values(AXIS_DEGREE, axis, &mut values);
        for (entry, value) in row.iter_mut().zip(values) {
            *entry = value;
        }
    }
    let normal = basis.transpose() * &basis;
    // Sixty axes determine the 28 functions, so that the matrix is regular.
    let inverse = normal
        .try_inverse()
        .unwrap_or_else(|| DMatrix::zeros(count, count));
    inverse * basis.transpose()
}
