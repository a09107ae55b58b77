//! Every reader of model validity has the same errors, whatever kind the room's model is of.

use crate::support::studies::{self, built_in_room, default_design, harmonics, slice_beyond_box};
use nalgebra::{Unit, UnitQuaternion, Vector3};
use std::sync::Arc;
use trackwright_calibration::room_model::RoomModel;
use trackwright_field::{Environment, FieldPoint, OutsidePolicy, Validity};
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_simulation::body_prediction::BodyPredictor;
use trackwright_simulation::slice_support::slice_support;
use trackwright_simulation::support::survey;
use trackwright_simulation::supported_region::supported_region;
use trackwright_simulation::{
    Mode, Quantity, RigidBody, Scenario, SensorOrientation, sample_slice,
};
use trackwright_task::{CancelToken, Task};

/// Of the built-in table's rows: more than the rows of one part of a process.
const EVERY: usize = 5;

/// Rooms without what only polynomials keep.
fn rooms() -> Vec<Arc<Environment>> {
    let kinds = [RoomModel::Kriging, harmonics()];
    let room = |model: &RoomModel| Arc::new(built_in_room(model, EVERY));
    let rooms: Vec<_> = kinds.iter().map(room).collect();
    assert!(rooms.iter().all(|room| room.fit_validity.is_none()));
    rooms
}

fn axis() -> Unit<Vector3<f64>> {
    Unit::new_normalize(Vector3::new(0.3, -0.5, 0.8))
}

fn stated(room: &Environment, points: &[FieldPoint]) -> Vec<Validity> {
    room.validity(points, OutsidePolicy::Clamp).unwrap().unwrap()
}

/// A 6-DOF sensor in its body's origin, where the tip is too.
fn one_sensor() -> RigidBody {
    let orientation = SensorOrientation::SixDof(UnitQuaternion::identity());
    studies::body(vec![studies::sensor([0.0; 3], orientation)], Some([0.0; 3]))
}

#[test]
fn slices_show_error_and_distance_of_each_reading() {
    for room in rooms() {
        let plan = slice_beyond_box(&room, [13, 11]);
        let scenario = Scenario { environment: Arc::clone(&room), ..default_design() };
        let [nu, nv] = plan.counts;
        let places = (0..nv).flat_map(|v| (0..nu).map(move |u| (u, v)));
        let point = |(u, v)| FieldPoint::new(plan.point_mm(u, v), axis());
        let expected = stated(&room, &places.map(point).collect::<Vec<_>>());
        let cancel = CancelToken::default();
        let slice =
            |quantity| sample_slice(&scenario, quantity, &plan, &cancel).unwrap().unwrap().values;
        let (errors_mm, distances_mm) =
            (slice(Quantity::StdErrorMm), slice(Quantity::SupportDistanceMm));
        let supported = slice_support(&scenario, Quantity::PositionErrorMm, &plan, &cancel);
        let supported = supported.unwrap().unwrap();
        for (i, at) in expected.iter().enumerate() {
            let found_mm = errors_mm[i];
            assert!((found_mm / at.position_error_mm - 1.0).abs() < 1e-9, "{found_mm} {at:?}");
            assert_eq!(distances_mm[i], at.distance_mm);
            assert_eq!(supported[i], at.is_supported, "{at:?}");
        }
        assert!(supported.contains(&true) && supported.contains(&false));
    }
}

#[test]
fn the_region_is_where_readings_are_supported() {
    for room in rooms() {
        let found = supported_region(&room, &axis(), 13, &Task::default()).unwrap();
        let own = *room.model.bounds();
        let count = 12;
        let middle = |i: usize| (i as f64 + 0.5) / count as f64;
        let places = (0..count * count * count).map(|i| {
            Vector3::new(middle(i % count), middle(i / count % count), middle(i / count / count))
        });
        let point = |unit: Vector3<f64>| {
            FieldPoint::new(own.min_mm + own.size_mm().component_mul(&unit), axis())
        };
        let expected = stated(&room, &places.map(point).collect::<Vec<_>>());
        let supported = expected.iter().filter(|at| at.is_supported).count();
        let part = supported as f64 / expected.len() as f64;
        // The surface is linear between points a twelfth of the box apart.
        assert!((found.fraction - part).abs() < 0.05, "{} {part}", found.fraction);
    }
}

#[test]
fn predictions_have_the_error_of_each_reading() {
    for room in rooms() {
        let at = pose_from_parts(
            room.model.bounds().center_mm().coords,
            UnitQuaternion::from_euler_angles(0.3, 0.2, 0.1),
        );
        let stated = stated(&room, &[FieldPoint::of_pose(&at)])[0];
        let body = one_sensor();
        let predictor = BodyPredictor::new(&body, 50.0, &room, OutsidePolicy::Clamp);
        let found = predictor.predict(&at).unwrap();
        let is_same = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-9;
        assert!(is_same(found.position_std_error_mm.unwrap(), stated.position_error_mm));
        assert!(is_same(found.angle_std_error_rad.unwrap(), stated.angle_error_rad.unwrap()));
        assert_eq!(found.is_valid, stated.is_supported);
        // The noise of a reading is added.
        assert!(found.tip_rms_mm.unwrap() > stated.position_error_mm);
        let scenario = Scenario {
            environment: Arc::clone(&room),
            tool: body,
            crf: None,
            crf_from_tool: at,
            ..default_design()
        };
        let found = survey(&scenario, &Mode::Single, &Task::default()).unwrap();
        assert!(is_same(found.std_error_mm.rms, stated.position_error_mm));
        assert_eq!(found.greatest_distance_mm, stated.distance_mm);
        let far = Pose::translation(5e3, 0.0, 0.0) * at;
        assert!(!predictor.predict(&far).unwrap().is_valid);
    }
}

#[test]
fn a_marker_is_as_uncertain_as_the_worst_axis() {
    for room in rooms() {
        let at = room.model.bounds().center_mm();
        let validity = room.model_validity(OutsidePolicy::Clamp).unwrap();
        let axes = [Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()];
        let each = validity.at(&axes.map(|axis| (at, Some(axis))));
        let worst_mm = each.iter().map(|at| at.position_error_mm).fold(0.0, f64::max);
        let marker = validity.at_sensor(&(at, None));
        assert!((marker.position_error_mm / worst_mm - 1.0).abs() < 1e-9);
        assert_eq!(marker.angle_error_rad, None);
    }
}
