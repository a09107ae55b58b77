//! A square loop of wire: the field of four straight segments by Biot–Savart.

use nalgebra::{Matrix3, Point3, Unit, Vector3};
use trackwright_geometry::rotation::perpendicular;

/// A loop with a current that gives it a unit moment along its normal.
pub(super) struct SquareLoop {
    pub(super) corners_mm: [Point3<f64>; 4],
    /// One over the area.
    scale: f64,
}

impl SquareLoop {
    pub(super) fn new(center_mm: &Point3<f64>, normal: &Unit<Vector3<f64>>, side_mm: f64) -> Self {
        let u = perpendicular(normal).into_inner() * (0.5 * side_mm);
        let v = normal.cross(&u);
        Self {
            corners_mm: [u + v, v - u, -u - v, u - v].map(|corner| center_mm + corner),
            scale: 1.0 / (side_mm * side_mm),
        }
    }

    /// Field and gradient `∂B_i/∂p_j`; not finite on the wire.
    pub(super) fn field_and_gradient(&self, p: &Point3<f64>) -> (Vector3<f64>, Matrix3<f64>) {
        let mut sum = (Vector3::zeros(), Matrix3::zeros());
        for k in 0..4 {
            let [a, b] = [k, (k + 1) % 4].map(|k| p - self.corners_mm[k]);
            let (field, gradient) = segment(&a, &b);
            sum.0 += field;
            sum.1 += gradient;
        }
        (sum.0 * self.scale, sum.1 * self.scale)
    }
}

/// Field of a segment from `p − a` to `p − b`, in units of µ₀ I / 4π, and its gradient:
/// `B = a × b g`, `g = (|a| + |b|) / (|a| |b| (|a| |b| + a·b))`.
///
/// `a × b` changes by `δ × (b − a)`; `g` through the logarithms of its factors.
fn segment(a: &Vector3<f64>, b: &Vector3<f64>) -> (Vector3<f64>, Matrix3<f64>) {
    let (a_norm, b_norm) = (a.norm(), b.norm());
    let (a_unit, b_unit) = (a / a_norm, b / b_norm);
    let product = a_norm * b_norm;
    let inner = product + a.dot(b);
    let g = (a_norm + b_norm) / (product * inner);
    let log_slope = (a_unit + b_unit) / (a_norm + b_norm)
        - a_unit / a_norm
        - b_unit / b_norm
        - (a_unit * b_norm + b_unit * a_norm + a + b) / inner;
    let cross = a.cross(b);
    let gradient = (cross * log_slope.transpose() + (a - b).cross_matrix()) * g;
    (cross * g, gradient)
}
