//! Rotation vectors: logarithm, exponential, and the smallest rotation between two axes.
//!
//! A rotation vector (Rodrigues vector in the paper's sense, equation 1) is the unit axis times
//! the angle in radians. What other crates call once a pose is `#[inline]`.

use nalgebra::{Matrix3, Quaternion, Unit, UnitQuaternion, Vector3};

/// Below this angle the first terms of the series are exact to the last bit.
const SMALL_ANGLE_RAD: f64 = 1e-8;

/// Sine of the angle to ±axis below which two axes count as antipodal.
///
/// Round-off of a normalised axis is 1e-16; axes in tables carry nine digits. At 1e-12 the
/// perpendicular direction is noise in both cases.
const ANTIPODAL_SINE: f64 = 1e-12;

/// Rotation vector of a unit quaternion, angle in `[0, π]`.
///
/// ```
/// use nalgebra::Vector3;
/// use trackwright_geometry::rotation::{exp_vector, log_quaternion};
///
/// let vector = Vector3::new(0.1, -0.4, 3e-9);
/// assert!((log_quaternion(&exp_vector(&vector)) - vector).norm() < 1e-15);
/// ```
///
/// The angle comes from `atan2`, so it is accurate at both ends, near 0 and near π.
#[inline]
pub fn log_quaternion(rotation: &UnitQuaternion<f64>) -> Vector3<f64> {
    let q = rotation.quaternion();
    let (w, v) = if q.w < 0.0 { (-q.w, -q.imag()) } else { (q.w, q.imag()) };
    let sine = v.norm();
    if sine < SMALL_ANGLE_RAD {
        // 2 atan2(s, w) / s -> 2 / w
        return v * (2.0 / w);
    }
    v * (2.0 * sine.atan2(w) / sine)
}

/// Rotation vector of a rotation matrix, angle in `[0, π]`.
pub fn log_matrix(rotation: &Matrix3<f64>) -> Vector3<f64> {
    log_quaternion(&super::pose::quaternion_from_matrix(rotation))
}

/// The rotation of a rotation vector in radians.
///
/// nalgebra's exponential takes turns below 4e-16 rad for none; here they keep all digits.
#[inline]
pub fn exp_vector(vector: &Vector3<f64>) -> UnitQuaternion<f64> {
    let angle = vector.norm();
    let (sine, cosine) = (0.5 * angle).sin_cos();
    // sin(x / 2) / x -> 1 / 2
    let scale = if angle > 0.0 { sine / angle } else { 0.5 };
    UnitQuaternion::new_unchecked(Quaternion::from_parts(cosine, vector * scale))
}

/// Angle of a rotation in radians, `[0, π]`, accurate at both ends.
#[inline]
pub fn rotation_angle_rad(rotation: &UnitQuaternion<f64>) -> f64 {
    let q = rotation.quaternion();
    2.0 * q.imag().norm().atan2(q.w.abs())
}

/// The smallest rotation from one axis to another, as a rotation vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisRotation {
    /// Axis times angle, in radians.
    pub vector_rad: Vector3<f64>,
    /// The axes are opposite, so any perpendicular axis would do; one was chosen.
    pub is_ambiguous: bool,
}

/// Smallest rotation that takes `from` to `to` (the measurement error of a 5-DOF sensor).
///
/// The cross product is taken with what the axes differ by, which is exact where they are nearly
/// the same or nearly opposite; with the axes themselves it would cancel there.
#[inline]
pub fn axis_rotation(from: &Unit<Vector3<f64>>, to: &Unit<Vector3<f64>>) -> AxisRotation {
    let cosine = from.dot(to);
    let (a, b) = (from.as_ref(), to.as_ref());
    let cross = a.cross(&if cosine < 0.0 { b + a } else { b - a });
    let sine = cross.norm();
    if sine < ANTIPODAL_SINE && cosine < 0.0 {
        return AxisRotation {
            vector_rad: perpendicular(from).into_inner() * std::f64::consts::PI,
            is_ambiguous: true,
        };
    }
    let scale = if sine > 0.0 { sine.atan2(cosine) / sine } else { 0.0 };
    AxisRotation { vector_rad: cross * scale, is_ambiguous: false }
}

/// A unit vector perpendicular to `axis`, the same one each time.
#[inline]
pub fn perpendicular(axis: &Unit<Vector3<f64>>) -> Unit<Vector3<f64>> {
    let smallest = axis.iamin();
    let mut helper = Vector3::zeros();
    helper[smallest] = 1.0;
    Unit::new_normalize(axis.cross(&helper))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn axis() -> Unit<Vector3<f64>> {
        Unit::new_normalize(Vector3::new(0.3, -0.8, 0.52))
    }

    #[test]
    fn log_is_accurate_to_1e12_at_1e8_radians() {
        for angle in [1e-12, 1e-9, 1e-8, 3e-8, 1e-6, 1e-3, 1.0] {
            let vector = axis().into_inner() * angle;
            let back = log_matrix(&exp_vector(&vector).to_rotation_matrix().into_inner());
            assert!((back - vector).norm() <= 1e-12 * angle.max(1e-8), "{angle}");
        }
    }

    #[test]
    fn log_is_accurate_near_half_a_turn() {
        for gap in [0.0, 1e-14, 1e-9, 1e-4, 0.1] {
            let vector = axis().into_inner() * (PI - gap);
            let back = log_matrix(&exp_vector(&vector).to_rotation_matrix().into_inner());
            let error = (back - vector).norm().min((back + vector).norm());
            assert!(error < 1e-13, "{gap}: {error}");
        }
    }

    #[test]
    fn smallest_rotation_takes_one_axis_to_the_other() {
        let from = axis();
        let to = Unit::new_normalize(Vector3::new(-0.2, 0.1, 0.9));
        let turn = axis_rotation(&from, &to);
        assert!(
            (exp_vector(&turn.vector_rad) * from.into_inner() - to.into_inner()).norm() < 1e-15
        );
        assert!(turn.vector_rad.dot(&from).abs() < 1e-15);
    }

    #[test]
    fn opposite_axes_are_ambiguous() {
        let from = axis();
        let to = Unit::new_unchecked(-from.into_inner());
        let turn = axis_rotation(&from, &to);
        assert!(turn.is_ambiguous);
        assert!((turn.vector_rad.norm() - PI).abs() < 1e-15);
        assert!(turn.vector_rad.dot(&from).abs() < 1e-15);
    }

    #[test]
    fn equal_axes_need_no_rotation() {
        let turn = axis_rotation(&axis(), &axis());
        assert_eq!(turn.vector_rad, Vector3::zeros());
        assert!(!turn.is_ambiguous);
    }
}
