//! The pose of a body that a tracker would report is corrected to the body's true pose.

use crate::support::studies::built_in;
use nalgebra::{Point3, Vector3};
use trackwright_field::compensation::{Compensated, Compensator, Method};
use trackwright_field::inverse::InverseState;
use trackwright_field::samples::MapKind;
use trackwright_field::{DistortionModel, Environment, OutsidePolicy};
use trackwright_geometry::directions::{DirectionSet, Weighting};
use trackwright_geometry::pose::{Pose, pose_from_array};
use trackwright_simulation::body_compensation::*;
use trackwright_simulation::{RigidBody, Scenario, Sensor, SensorOrientation, simulate_pose};
use trackwright_task::Task;

fn compensated(
    scenario: &Scenario,
    body: &RigidBody,
    measured: &Pose,
    method: Method,
) -> Compensated {
    let environment = &*scenario.environment;
    let weight_mm = scenario.orientation_weight_mm;
    let compensator =
        BodyCompensator::new(body.clone(), weight_mm, environment, scenario.outside, method);
    let sensors = Compensator::new(&environment.model, scenario.outside, method);
    compensator.compensate(measured, &sensors)
}

fn apart(a: &Pose, b: &Pose) -> (f64, f64) {
    let mm = (a.translation.vector - b.translation.vector).norm();
    (mm, a.rotation.angle_to(&b.rotation))
}

#[test]
fn compensation_inverts_the_simulated_body_pose() {
    let mut at_origin_mm: f64 = 0.0;
    for name in ["pointer-on-head", "shaver-on-head"] {
        let scenario = built_in(name);
        let detail = simulate_pose(&scenario);
        let crf = (scenario.crf.as_ref()).map(|crf| (&crf.body, detail.crf.as_ref().unwrap()));
        for (body, seen) in [(&scenario.tool, &detail.tool)].into_iter().chain(crf) {
            let measured = seen.tracker_from_body_fitted;
            let found = compensated(&scenario, body, &measured, Method::Inverse);
            assert_eq!(found.state, InverseState::Converged, "{}", body.name);
            // A tolerance on the readings, and a field whose error changes by far less than itself.
            let (mm, rad) = apart(&found.pose.unwrap(), &seen.tracker_from_body);
            assert!(mm < 1e-5 && rad < 1e-8, "{}: {mm} mm, {rad} rad", body.name);

            // As if the frame's origin were a sensor.
            let environment = &scenario.environment;
            let single = Compensator::new(&environment.model, scenario.outside, Method::Inverse);
            let single = single.compensate(&[measured], &Task::default()).unwrap()[0];
            if let Some(pose) = single.pose {
                at_origin_mm = at_origin_mm.max(apart(&pose, &seen.tracker_from_body).0);
            }
        }
    }
    // Why bodies are not compensated as if they were sensors at their origins.
    assert!(at_origin_mm > 0.1, "{at_origin_mm} mm");
}

#[test]
fn markers_and_single_coils_keep_their_positions() {
    let mut scenario = built_in("pointer-on-head");
    let template = scenario.tool.sensors[0].clone();
    let at = |x: f64, y: f64, orientation| Sensor {
        position_in_body: Point3::new(x, y, 10.0),
        orientation,
        ..template.clone()
    };
    use SensorOrientation::{FiveDof, Marker};
    for sensors in [
        vec![at(0.0, 0.0, Marker), at(40.0, 0.0, Marker), at(0.0, 50.0, Marker)],
        vec![at(5.0, -3.0, FiveDof(Vector3::y_axis()))],
    ] {
        scenario.tool.sensors = sensors;
        let seen = simulate_pose(&scenario).tool;
        let measured = seen.tracker_from_body_fitted;
        let found = compensated(&scenario, &scenario.tool, &measured, Method::Inverse);
        // A coil's roll is not measured: the reported one is kept.
        for sensor in &scenario.tool.sensors {
            let sensor_mm = |pose: &Pose| pose * sensor.position_in_body;
            let mm = (sensor_mm(&found.pose.unwrap()) - sensor_mm(&seen.tracker_from_body)).norm();
            assert!(mm < 1e-5, "{mm} mm");
        }
    }
}

/// A room that measures everything 2 mm too far along x; as a correction map it takes 2 mm off.
fn shifted(map: MapKind) -> Environment {
    let bounds = trackwright_geometry::bounds::Bounds::from((
        [-200.0, -200.0, -500.0],
        [200.0, 200.0, -100.0],
    ));
    let coefficients = vec![[2.0, 0.0, 0.0, 0.0, 0.0, 0.0]; 8];
    let one = (DirectionSet::One, Weighting::Area);
    Environment {
        model: DistortionModel::new(1, one.0, one.1, map, bounds, coefficients).unwrap(),
        ..(*built_in("pointer-on-head").environment).clone()
    }
}

#[test]
fn every_method_removes_a_constant_error() {
    let mut scenario = built_in("pointer-on-head");
    let measured = pose_from_array([12.0, -20.0, -300.0, 0.8, 0.0, 0.6, 0.0]).unwrap();
    for (map, method) in [
        (MapKind::Distortion, Method::Inverse),
        (MapKind::Distortion, Method::Shortcut),
        (MapKind::Correction, Method::Correction),
    ] {
        scenario.environment = shifted(map).into();
        scenario.outside = OutsidePolicy::Reject;
        let found = compensated(&scenario, &scenario.tool, &measured, method);
        let off = found.pose.unwrap().translation.vector
            - (measured.translation.vector - Vector3::x() * 2.0);
        assert!(off.norm() < 1e-6, "{method:?}: {off}");

        // One sensor outside the box is enough.
        let mut far = measured;
        far.translation.vector.x = 199.0;
        let found = compensated(&scenario, &scenario.tool, &far, method);
        assert_eq!((found.pose, found.is_inside), (None, false), "{method:?}");
        assert_eq!(found.state, InverseState::Rejected, "{method:?}");
    }
}

#[test]
fn numbers_that_are_none_are_refused() {
    let scenario = built_in("pointer-on-head");
    for bad in [f64::NAN, f64::INFINITY] {
        let mut measured = scenario.crf_from_tool;
        measured.translation.vector.y = bad;
        let found = compensated(&scenario, &scenario.tool, &measured, Method::Inverse);
        assert_eq!(found.pose, None, "{bad}");
    }
}
