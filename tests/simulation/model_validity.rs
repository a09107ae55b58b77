//! Every reader of model validity has the same errors, whatever kind the room's model is of.

use crate::support::studies::{
    self, built_in_room, default_design, default_in_polynomials, harmonics, slice_beyond_box,
};
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

/// Rooms of models that are no polynomials.
fn computed_rooms() -> [Arc<Environment>; 2] {
    let rooms = [RoomModel::Kriging, harmonics()];
    let rooms = rooms.map(|model| Arc::new(built_in_room(&model, EVERY)));
    assert!(rooms.iter().all(|room| room.fit_validity.is_none()));
    rooms
}

/// Rooms of all kinds of models; of polynomials with the whole table.
fn rooms() -> Vec<Arc<Environment>> {
    computed_rooms().into_iter().chain([default_in_polynomials().environment]).collect()
}

fn axis() -> Unit<Vector3<f64>> {
    Unit::new_normalize(Vector3::new(0.3, -0.5, 0.8))
}

#[derive(Clone, Copy, Debug)]
struct Stated {
    error_mm: f64,
    error_rad: f64,
    is_supported: bool,
    distance_mm: f64,
}

/// What is known of readings: of polynomials the standard error of their fit.
fn stated(room: &Environment, points: &[FieldPoint]) -> Vec<Stated> {
    let of = |at: Validity| {
        let of_reading = (at.position_error_mm, at.angle_error_rad);
        let of_fit = at.fit.map(|fit| (fit.position_std_error_mm, fit.angle_std_error_rad));
        let (error_mm, error_rad) = of_fit.unwrap_or(of_reading);
        let (is_supported, distance_mm) = (at.is_supported, at.distance_mm);
        Stated { error_mm, error_rad: error_rad.unwrap(), is_supported, distance_mm }
    };
    room.validity(points, OutsidePolicy::Clamp).unwrap().unwrap().into_iter().map(of).collect()
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
        let slice = |quantity| sample_slice(&scenario, quantity, &plan, &cancel).unwrap().unwrap();
        let error = slice(Quantity::PositionErrorMm);
        let (std_error, distance) =
            (slice(Quantity::StdErrorMm), slice(Quantity::SupportDistanceMm));
        assert!(std_error.p95 > 0.0 && std_error.p95 <= std_error.max);
        let supported = slice_support(&scenario, Quantity::PositionErrorMm, &plan, &cancel);
        let supported = supported.unwrap().unwrap();
        for (i, at) in expected.iter().enumerate() {
            let found_mm = std_error.values[i];
            assert!((found_mm / at.error_mm - 1.0).abs() < 1e-9, "{found_mm} {at:?}");
            assert_eq!(distance.values[i], at.distance_mm);
            assert_eq!(supported[i], at.is_supported, "{at:?}");
            assert_eq!([std_error.is_inside[i], distance.is_inside[i]], [error.is_inside[i]; 2]);
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
        assert!((0.05..=1.0).contains(&found.fraction), "{}", found.fraction);
        assert_eq!(found.evaluations, 13 * 13 * 13);
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
        assert!(is_same(found.position_std_error_mm.unwrap(), stated.error_mm));
        assert!(is_same(found.angle_std_error_rad.unwrap(), stated.error_rad));
        assert_eq!(found.is_valid, stated.is_supported);
        // The noise of a reading is added.
        assert!(found.tip_rms_mm.unwrap() > stated.error_mm);
        let scenario = Scenario {
            environment: Arc::clone(&room),
            tool: body,
            crf: None,
            crf_from_tool: at,
            ..default_design()
        };
        let found = survey(&scenario, &Mode::Single, &Task::default()).unwrap();
        assert!(is_same(found.std_error_mm.rms, stated.error_mm));
        assert_eq!(found.greatest_distance_mm, stated.distance_mm);
        let far = Pose::translation(5e3, 0.0, 0.0) * at;
        assert!(!predictor.predict(&far).unwrap().is_valid);
    }
}

#[test]
fn a_marker_is_as_uncertain_as_the_worst_axis() {
    for room in computed_rooms() {
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

#[test]
fn leverage_on_the_surface_is_the_samples_maximum() {
    let room = default_in_polynomials().environment;
    let found = supported_region(&room, &axis(), 33, &Task::default()).unwrap();
    let support = room.fit_validity.as_ref().unwrap();
    let positions = &found.surface.positions_mm;
    assert!(positions.len() > 100, "{}", positions.len());
    let mut shares: Vec<f64> = positions
        .iter()
        .map(|at| support.leverage_share(&room.model.bounds().clamp(at), &found.axis))
        .collect();
    shares.sort_by(f64::total_cmp);
    // Linear between points of the lattice, while leverage grows with a power.
    let (low, high) = (shares[shares.len() / 20], shares[shares.len() * 19 / 20]);
    assert!(low > 0.8 && high < 1.1, "{low} {high}");
}

#[test]
fn a_room_without_validity_states_nothing() {
    let mut scenario = default_in_polynomials();
    let room = Arc::make_mut(&mut scenario.environment);
    (room.fit_validity, room.process) = (None, None);
    let room = &scenario.environment;
    let task = Task::default();
    let of_survey = survey(&scenario, &Mode::Single, &task).unwrap_err().to_string();
    let of_region = supported_region(room, &axis(), 9, &task).unwrap_err().to_string();
    for error in [of_survey, of_region] {
        assert!(error.contains("\"Operating table\" has no model validity"), "{error}");
    }
    let plan = slice_beyond_box(room, [13, 11]);
    let cancel = CancelToken::default();
    assert_eq!(slice_support(&scenario, Quantity::TipErrorMm, &plan, &cancel), Ok(None));
    assert_eq!(sample_slice(&scenario, Quantity::StdErrorMm, &plan, &cancel), Ok(None));
    let body = one_sensor();
    let predictor = BodyPredictor::new(&body, 50.0, room, OutsidePolicy::Clamp);
    let middle = room.model.bounds().center_mm().coords;
    let at = pose_from_parts(middle, UnitQuaternion::identity());
    assert_eq!(predictor.predict(&at), None);
}
