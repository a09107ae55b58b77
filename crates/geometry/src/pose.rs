//! Rigid poses, and their seven-number form in files and tables.

use crate::rotation::{exp_vector, log_quaternion, rotation_angle_rad};
use nalgebra::{Isometry3, Matrix3, Quaternion, Rotation3, Translation3, UnitQuaternion, Vector3};

/// A rigid pose `target_from_source`: `x_target = R x_source + p`, lengths in millimetres.
pub type Pose = Isometry3<f64>;

/// Shortest quaternion or axis that still has a direction.
pub const MIN_NORM: f64 = 1e-12;

/// A pose from a position in millimetres and a unit quaternion, scalar first.
#[inline]
pub fn pose_from_parts(position_mm: Vector3<f64>, rotation: UnitQuaternion<f64>) -> Pose {
    Isometry3::from_parts(Translation3::from(position_mm), rotation)
}

/// A pose from `[x, y, z, qw, qx, qy, qz]`; `None` where the quaternion has no direction.
pub fn pose_from_array(values: [f64; 7]) -> Option<Pose> {
    let [x, y, z, qw, qx, qy, qz] = values;
    let rotation = quaternion_from_array([qw, qx, qy, qz])?;
    Some(pose_from_parts(Vector3::new(x, y, z), rotation))
}

/// `[x, y, z, qw, qx, qy, qz]` of a pose, scalar first and never negative.
pub fn pose_to_array(pose: &Pose) -> [f64; 7] {
    let p = pose.translation.vector;
    let [qw, qx, qy, qz] = quaternion_to_array(&pose.rotation);
    [p.x, p.y, p.z, qw, qx, qy, qz]
}

/// The unit quaternion along `[w, x, y, z]`; `None` where that has no length or an endless one.
pub fn quaternion_from_array([w, x, y, z]: [f64; 4]) -> Option<UnitQuaternion<f64>> {
    if ![w, x, y, z].iter().all(|v| v.is_finite()) {
        return None;
    }
    UnitQuaternion::try_new(Quaternion::new(w, x, y, z), MIN_NORM)
}

/// `[w, x, y, z]` with `w >= 0`: of the two quaternions of a rotation, the one that files hold.
pub fn quaternion_to_array(rotation: &UnitQuaternion<f64>) -> [f64; 4] {
    let q = rotation.quaternion();
    // Adding zero turns a negative zero into a plain one.
    let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
    [sign * q.w + 0.0, sign * q.i + 0.0, sign * q.j + 0.0, sign * q.k + 0.0]
}

/// The quaternion of a rotation matrix.
pub fn quaternion_from_matrix(rotation: &Matrix3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*rotation))
}

/// Distance and angle between two poses, mm and radians.
pub fn distances(a: &Pose, b: &Pose) -> (f64, f64) {
    (
        (a.translation.vector - b.translation.vector).norm(),
        rotation_angle_rad(&(a.rotation.inverse() * b.rotation)),
    )
}

/// The pose a part of the way from one to another, or beyond either: straight in position and at constant
/// speed in rotation (slerp).
pub fn interpolated(from: &Pose, to: &Pose, part: f64) -> Pose {
    let turn = log_quaternion(&(from.rotation.inverse() * to.rotation));
    pose_from_parts(
        from.translation.vector.lerp(&to.translation.vector, part),
        from.rotation * exp_vector(&(turn * part)),
    )
}

/// Whether all numbers of a pose are finite.
pub fn is_finite(pose: &Pose) -> bool {
    pose.translation.vector.iter().chain(pose.rotation.coords.iter()).all(|v| v.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pose_arrays_round_trip() {
        let values = [1.0, -2.0, 3.0, -0.5, 0.5, -0.5, 0.5];
        let pose = pose_from_array(values).unwrap();
        let back = pose_to_array(&pose);
        assert_eq!(back, [1.0, -2.0, 3.0, 0.5, -0.5, 0.5, -0.5]);
    }

    #[test]
    fn a_quaternion_of_length_zero_is_no_pose() {
        assert!(pose_from_array([0.0; 7]).is_none());
    }
}
