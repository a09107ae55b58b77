//! Frame fits, reflections, what is not determined, and first-order uncertainty.

use crate::support::close::assert_all_golden;
use crate::support::golden::{
    GOLDEN, axis, list, matrix, number, numbers, point, rotation, vector,
};
use crate::support::studies;
use nalgebra::{Point3, UnitQuaternion, Vector3};
use serde_json::Value;
use trackwright_geometry::pose::Pose;
use trackwright_simulation::frame_fit::{FrameFit, FrameFitter, Reading};
use trackwright_simulation::linear_fit::{SensorCovariance, point_covariance_mm2};
use trackwright_simulation::{Determination, RigidBody, Sensor, SensorOrientation};

fn sensor(case: &Value) -> Sensor {
    let orientation = match (case["dof"].as_u64(), &case["rotation"]) {
        (Some(6), turn) => SensorOrientation::SixDof(rotation(turn)),
        (_, Value::Null) => SensorOrientation::FiveDof(axis(&case["axis"])),
        (_, turn) => SensorOrientation::FiveDof(rotation(turn) * Vector3::z_axis()),
    };
    studies::sensor(numbers(&case["position"]), orientation)
}

fn body(case: &Value) -> RigidBody {
    studies::body(list(case, "sensors").iter().map(sensor).collect(), None)
}

#[track_caller]
fn assert_frame(fit: &FrameFit, case: &Value) {
    let found = fit.tracker_from_body.rotation.to_rotation_matrix();
    let expected = matrix(&case["rotation"]);
    let p = fit.tracker_from_body.translation.vector;
    assert_all_golden("rotation", found.matrix().as_slice(), expected.as_slice(), 1.0);
    assert_all_golden("translation", p.as_slice(), vector(&case["translation"]).as_slice(), 1.0);
}

#[test]
fn fitted_frames_and_singular_values_agree() {
    for case in list(&GOLDEN, "frame_fits") {
        let readings: Vec<_> = list(case, "measured")
            .iter()
            .map(|m| Reading {
                position_mm: point(&m["position"]),
                rotation: rotation(&m["rotation"]),
            })
            .collect();
        let weight = case["orientation_weight_mm"].as_f64().unwrap_or(100.0);
        let fit = FrameFitter::new(&body(case), weight).fit(&readings, &Pose::identity());
        assert_frame(&fit, case);
        assert_all_golden(
            "singular values",
            fit.singular_values_mm2.as_slice(),
            vector(&case["singular_values"]).as_slice(),
            1.0,
        );
    }
}

#[test]
fn planar_positions_never_give_a_reflection() {
    for case in list(&GOLDEN, "reflections") {
        let sensors = list(case, "position").iter();
        let sensors = sensors.map(|p| studies::five(numbers(p), [0.0, 0.0, 1.0]));
        let body = studies::body(sensors.collect(), None);
        let readings: Vec<_> = list(case, "measured")
            .iter()
            .map(|p| Reading { position_mm: point(p), rotation: UnitQuaternion::identity() })
            .collect();
        let fit = FrameFitter::new(&body, 0.0).fit(&readings, &Pose::identity());
        assert_frame(&fit, case);
    }
}

#[test]
fn what_sensors_leave_free_agrees() {
    for case in list(&GOLDEN, "undetermined") {
        let body = body(case);
        let readings: Vec<_> = body
            .sensors
            .iter()
            .map(|s| Reading {
                position_mm: s.position_in_body,
                rotation: s.orientation.any_rotation(),
            })
            .collect();
        let fit = FrameFitter::new(&body, 100.0).fit(&readings, &Pose::identity());
        let Determination::FreeAxis { axis_in_body } = fit.determination else {
            panic!("{:?}", fit.determination);
        };
        assert!(axis_in_body.cross(&vector(&case["free_axis"])).norm() < 1e-9);
    }
}

#[test]
fn first_order_covariances_of_the_tip_agree() {
    for case in list(&GOLDEN, "uncertainty") {
        let body = body(case);
        let covariance = SensorCovariance {
            position_mm2: matrix(&case["position_covariance_mm2"]),
            rotation_rad2: matrix(&case["rotation_covariance_rad2"]),
        };
        let tip: Point3<f64> = point(&case["tip"]);
        let found = point_covariance_mm2(
            &body,
            number(&case["orientation_weight_mm"]),
            &vec![covariance; body.sensors.len()],
            &tip,
        )
        .unwrap();
        assert_all_golden(
            "tip covariance",
            found.as_slice(),
            matrix(&case["tip_covariance_mm2"]).as_slice(),
            1e-6,
        );
    }
}
