//! Singular values of a 3x3 matrix by one-sided Jacobi rotations.
//!
//! nalgebra computes `SVD` of a `Matrix3` from the eigenvectors of `MᵀM`, which loses small
//! singular values below 1e-8 of the largest. Which rotations a body's sensors leave free
//! depends on ratios of 1e-10, so they are found on the matrix itself: one-sided Jacobi keeps each to
//! high relative accuracy (Demmel & Veselić, SIAM J. Matrix Anal. Appl. 13(4), 1992).

use super::pose::quaternion_from_matrix;
use nalgebra::{Matrix3, Unit, UnitQuaternion, Vector3};

/// Sweeps until columns are orthogonal; three by three needs four or five.
const MAX_SWEEPS: usize = 30;

/// `M = U Λ Vᵀ` with singular values in descending order; `U` and `V` orthogonal, of either
/// handedness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Svd3 {
    pub u: Matrix3<f64>,
    pub singular_values: Vector3<f64>,
    pub v: Matrix3<f64>,
}

impl Svd3 {
    /// For a cross-covariance `Σ q q'ᵀ`: the rotation that takes the `q` nearest to the `q'`,
    /// `V diag(1, 1, det(V Uᵀ)) Uᵀ`. The sign keeps it a rotation where the plain product would
    /// be a reflection (Umeyama, IEEE PAMI 13(4), 1991).
    pub fn best_rotation(&self) -> UnitQuaternion<f64> {
        let sign = (self.v * self.u.transpose()).determinant().signum();
        let flip = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, sign));
        quaternion_from_matrix(&(self.v * flip * self.u.transpose()))
    }
}

/// Entries whose products of four neither overflow nor vanish: the rotations need the squares of
/// columns, and products of those.
const SAFE_SIZE: std::ops::Range<f64> = 1e-50..1e50;

/// Singular value decomposition of a finite matrix, of any rank and size.
///
/// ```
/// use nalgebra::{Matrix3, Vector3};
/// use trackwright_geometry::svd3::svd3;
///
/// let svd = svd3(&Matrix3::from_diagonal(&Vector3::new(1e-12, -3.0, 0.0)));
/// assert_eq!(svd.singular_values, Vector3::new(3.0, 1e-12, 0.0));
/// ```
pub fn svd3(matrix: &Matrix3<f64>) -> Svd3 {
    let size = matrix.amax();
    if SAFE_SIZE.contains(&size) || size == 0.0 || !size.is_finite() {
        return svd3_of_safe_size(matrix);
    }
    // A power of two changes no digit.
    let power = size.log2().floor().exp2();
    let mut svd = svd3_of_safe_size(&(matrix / power));
    svd.singular_values *= power;
    svd
}

fn svd3_of_safe_size(matrix: &Matrix3<f64>) -> Svd3 {
    let mut w = *matrix;
    let mut v = Matrix3::identity();
    for _ in 0..MAX_SWEEPS {
        let mut is_done = true;
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            is_done &= !orthogonalise(&mut w, &mut v, p, q);
        }
        if is_done {
            break;
        }
    }
    let norms = [0, 1, 2].map(|k| w.column(k).norm());
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| norms[b].total_cmp(&norms[a]));
    let singular_values = Vector3::from(order.map(|k| norms[k]));
    let v = Matrix3::from_columns(&order.map(|k| v.column(k).into_owned()));
    let u = complete_basis(order.map(|k| w.column(k).into_owned()), &singular_values);
    Svd3 { u, singular_values, v }
}

/// Rotates columns `p` and `q` until they are orthogonal; whether that was needed.
fn orthogonalise(w: &mut Matrix3<f64>, v: &mut Matrix3<f64>, p: usize, q: usize) -> bool {
    let (a, b) = (w.column(p).norm_squared(), w.column(q).norm_squared());
    let c = w.column(p).dot(&w.column(q));
    // The cosine of the angle between the columns is below rounding; squared, for want of a root.
    if c * c <= f64::EPSILON * f64::EPSILON * (a * b) {
        return false;
    }
    // The smaller root of t² + 2 ζ t - 1 for ζ = (b - a) / 2c, with one division.
    let (difference, twice) = (b - a, 2.0 * c);
    let root = (difference * difference + twice * twice).sqrt();
    let t = twice * 1.0_f64.copysign(difference) / (difference.abs() + root);
    let cosine = 1.0 / (1.0 + t * t).sqrt();
    let sine = cosine * t;
    for m in [w, v] {
        for row in 0..3 {
            let (x, y) = (m[(row, p)], m[(row, q)]);
            m[(row, p)] = cosine * x - sine * y;
            m[(row, q)] = sine * x + cosine * y;
        }
    }
    true
}

/// Unit columns of `U`; where a singular value is zero to rounding, any that complete the basis.
fn complete_basis(columns: [Vector3<f64>; 3], s: &Vector3<f64>) -> Matrix3<f64> {
    let cutoff = s[0] * f64::EPSILON;
    if s[0] <= 0.0 {
        return Matrix3::identity();
    }
    let u0 = columns[0] / s[0];
    let u1 = if s[1] > cutoff {
        // Orthogonal already to rounding; once more for tiny columns.
        let c = columns[1] / s[1];
        (c - u0 * u0.dot(&c)).normalize()
    } else {
        super::rotation::perpendicular(&Unit::new_normalize(u0)).into_inner()
    };
    let mut u2 = u0.cross(&u1);
    if s[2] > cutoff && u2.dot(&columns[2]) < 0.0 {
        u2 = -u2;
    }
    Matrix3::from_columns(&[u0, u1, u2])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rotation(x: f64, y: f64, z: f64) -> Matrix3<f64> {
        nalgebra::Rotation3::from_euler_angles(x, y, z).into_inner()
    }

    fn check(m: &Matrix3<f64>) -> Svd3 {
        let svd = svd3(m);
        let back = svd.u * Matrix3::from_diagonal(&svd.singular_values) * svd.v.transpose();
        assert!((back - m).norm() <= 1e-14 * m.norm(), "{back} {m}");
        for q in [svd.u, svd.v] {
            assert!((q * q.transpose() - Matrix3::identity()).norm() < 1e-13);
        }
        let s = svd.singular_values;
        assert!(s[0] >= s[1] && s[1] >= s[2] && s[2] >= 0.0);
        svd
    }

    #[test]
    fn graded_singular_values_keep_their_digits() {
        for small in [1.0, 1e-3, 1e-7, 1e-11] {
            let m = rotation(0.3, -1.0, 2.0)
                * Matrix3::from_diagonal(&Vector3::new(3.0, small, small * 0.1))
                * rotation(1.3, 0.4, -0.7);
            let s = check(&m).singular_values;
            // Forming `m` already loses eps * 3 of each.
            assert!((s[1] - small).abs() < 3e-15, "{s}");
            assert!((s[2] - small * 0.1).abs() < 3e-15, "{s}");
        }
    }

    #[test]
    fn low_ranks_have_orthogonal_factors() {
        let v = Vector3::new(1.0, -2.0, 0.5);
        check(&(v * v.transpose()));
        check(&(v * Vector3::x().transpose()));
        check(&Matrix3::zeros());
    }

    #[test]
    fn a_reflection_is_reproduced() {
        check(&Matrix3::from_diagonal(&Vector3::new(2.0, 1.0, -0.5)));
        check(&-rotation(0.1, 0.2, 0.3));
    }
}
