//! What the room's model predicts for a body's pose.

use crate::support::studies;
use nalgebra::{UnitQuaternion, Vector3};
use trackwright_field::{Environment, OutsidePolicy};
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_simulation::body_prediction::*;
use trackwright_simulation::{RigidBody, SensorOrientation};

fn body(positions: &[[f64; 3]], tip: [f64; 3]) -> RigidBody {
    let orientation = SensorOrientation::SixDof(UnitQuaternion::identity());
    let sensors = positions.iter().map(|at| studies::sensor(*at, orientation));
    studies::body(sensors.collect(), Some(tip))
}

fn room() -> std::sync::Arc<Environment> {
    studies::default_in_polynomials().environment
}

fn middle(room: &Environment) -> Pose {
    let at = room.model.bounds().center_mm();
    pose_from_parts(at.coords, UnitQuaternion::from_euler_angles(0.3, 0.2, 0.1))
}

#[test]
fn a_sensor_at_the_tip_is_off_as_one_reading_is() {
    let room = room();
    let predictor =
        BodyPredictor::new(&body(&[[0.0; 3]], [0.0; 3]), 50.0, &room, OutsidePolicy::Reject);
    let pose = middle(&room);
    let found = predictor.predict(&pose).unwrap();
    let support = room.fit_validity.as_ref().unwrap();
    let axis = pose.rotation * Vector3::z_axis();
    let at = support.at(&room.model.bounds().center_mm(), &axis, OutsidePolicy::Reject);
    let stds = &support.parts().position_std_mm;
    let squares: f64 = stds.iter().map(|std| std.unwrap().powi(2)).sum();
    let noise = (squares / stds.len() as f64).sqrt();
    let std_error_mm = found.position_std_error_mm.unwrap();
    assert!((std_error_mm - at.position_std_error_mm).abs() < 1e-12);
    let expected = noise.hypot(at.position_std_error_mm);
    assert!((found.tip_rms_mm.unwrap() - expected).abs() < 1e-9 * expected);
    assert_eq!(found.is_valid, at.is_valid);
}

#[test]
fn tip_error_grows_with_lever_and_falls_with_sensors() {
    let room = room();
    let of = |positions: &[[f64; 3]], tip: [f64; 3]| {
        let body = body(positions, tip);
        let predictor = BodyPredictor::new(&body, 50.0, &room, OutsidePolicy::Clamp);
        predictor.predict(&middle(&room)).unwrap().tip_rms_mm.unwrap()
    };
    let one = of(&[[0.0; 3]], [0.0; 3]);
    let far = of(&[[0.0; 3]], [0.0, 0.0, 150.0]);
    let two = of(&[[-5.0, 0.0, 0.0], [5.0, 0.0, 0.0]], [0.0; 3]);
    assert!(far > 1.1 * one, "{far} {one}");
    // Two independent readings at almost the same place.
    assert!((two / one - 0.5_f64.sqrt()).abs() < 0.05, "{two} {one}");
}
