//! How much errors are magnified to be seen, and the pose of a magnified ghost.

use super::pose::Pose;
use super::rotation::{exp_vector, log_quaternion};
use nalgebra::{Point3, Translation3, Vector3};

pub use super::number::round_below;

/// Share of the view's height that the tip vector should span: the middle, on a logarithmic
/// scale, of the 5 to 15 % in which it can be read without hiding the tool.
const AIMED_SHARE: f64 = 0.087;

/// The farthest that a ghost turns; beyond it a tool no longer reads as the same tool.
pub const MAX_GHOST_TURN_RAD: f64 = 20.0 * std::f64::consts::PI / 180.0;

/// 1, 2 or 5 times a power of ten such that `error_mm` spans 5 to 15 % of the view's height;
/// 1 where there is nothing to magnify.
pub fn automatic_magnification(error_mm: f64, view_height_mm: f64) -> f64 {
    let wanted = AIMED_SHARE * view_height_mm / error_mm;
    if !(wanted.is_finite() && wanted > 0.0) {
        return 1.0;
    }
    let decade = wanted.log10().floor() as i32;
    let distance = |m: &f64| (m / wanted).ln().abs();
    [(1.0, decade), (2.0, decade), (5.0, decade), (1.0, decade + 1)]
        .map(|(digit, exponent)| {
            // Powers below one as quotients, so that a half is 0.5 to the bit.
            if exponent < 0 { digit / 10f64.powi(-exponent) } else { digit * 10f64.powi(exponent) }
        })
        .into_iter()
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))
        .unwrap_or(1.0)
}

/// A body where magnified errors would put it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ghost {
    pub world_from_body: Pose,
    /// The turn would have been more than [`MAX_GHOST_TURN_RAD`].
    pub is_capped: bool,
}

/// The measured pose, its difference from the true one magnified.
///
/// The tip moves by `times` its error; the turn is `exp(times · log(R̂ Rᵀ))`, capped.
pub fn magnified_ghost(
    world_from_body: &Pose,
    world_from_body_measured: &Pose,
    tip_in_body: &Point3<f64>,
    times: f64,
) -> Ghost {
    let tip = world_from_body * tip_in_body;
    let tip_ghost = tip + (world_from_body_measured * tip_in_body - tip) * times;
    let turn = world_from_body_measured.rotation * world_from_body.rotation.inverse();
    let (vector_rad, is_capped) = capped(log_quaternion(&turn) * times);
    let rotation = exp_vector(&vector_rad) * world_from_body.rotation;
    Ghost {
        world_from_body: Pose::from_parts(
            Translation3::from(tip_ghost.coords - rotation * tip_in_body.coords),
            rotation,
        ),
        is_capped,
    }
}

fn capped(vector_rad: Vector3<f64>) -> (Vector3<f64>, bool) {
    let angle = vector_rad.norm();
    if angle > MAX_GHOST_TURN_RAD {
        (vector_rad * (MAX_GHOST_TURN_RAD / angle), true)
    } else {
        (vector_rad, false)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pose::pose_from_parts;
    use crate::rotation::rotation_angle_rad;
    use nalgebra::UnitQuaternion;

    #[test]
    fn the_vector_spans_5_to_15_percent() {
        for i in 0..4000 {
            let error_mm = 10f64.powf(-4.0 + f64::from(i) * 0.002);
            let m = automatic_magnification(error_mm, 400.0);
            let share = m * error_mm / 400.0;
            assert!((0.05..=0.15).contains(&share), "{error_mm}: {m} gives {share}");
            let digit = m / 10f64.powf(m.log10().floor());
            assert!([1.0, 2.0, 5.0, 10.0].iter().any(|d| (digit - d).abs() < 1e-9), "{m}");
        }
    }

    #[test]
    fn no_error_is_not_magnified() {
        assert_eq!(automatic_magnification(0.0, 400.0), 1.0);
        assert_eq!(automatic_magnification(f64::NAN, 400.0), 1.0);
        assert_eq!(automatic_magnification(0.5, 0.0), 1.0);
    }

    fn poses(turn_rad: f64) -> (Pose, Pose, Point3<f64>) {
        let rotation = UnitQuaternion::from_euler_angles(0.4, -0.2, 1.0);
        let truth = pose_from_parts(Vector3::new(10.0, -20.0, -300.0), rotation);
        let turn = UnitQuaternion::from_scaled_axis(Vector3::new(0.6, 0.0, 0.8) * turn_rad);
        let measured = pose_from_parts(Vector3::new(10.2, -20.1, -299.7), turn * rotation);
        (truth, measured, Point3::new(0.0, 0.0, -150.0))
    }

    #[test]
    fn ghosts_grow_with_the_magnification() {
        let (truth, measured, tip) = poses(0.003);
        let once = magnified_ghost(&truth, &measured, &tip, 1.0);
        assert!((once.world_from_body * tip - measured * tip).norm() < 1e-9);
        assert!(once.world_from_body.rotation.angle_to(&measured.rotation) < 1e-9);
        let many = magnified_ghost(&truth, &measured, &tip, 50.0);
        let error = measured * tip - truth * tip;
        assert!((many.world_from_body * tip - (truth * tip + error * 50.0)).norm() < 1e-9);
        let turn = many.world_from_body.rotation * truth.rotation.inverse();
        assert!((rotation_angle_rad(&turn) - 0.15).abs() < 1e-9);
        assert!(!many.is_capped);
    }

    #[test]
    fn a_ghost_turns_20_degrees_at_most_and_is_marked() {
        let (truth, measured, tip) = poses(0.01);
        let ghost = magnified_ghost(&truth, &measured, &tip, 50.0);
        let turn = ghost.world_from_body.rotation * truth.rotation.inverse();
        assert!((rotation_angle_rad(&turn) - MAX_GHOST_TURN_RAD).abs() < 1e-9);
        assert!(ghost.is_capped);
    }
}
