//! What has no tolerances, and sensors, studies and tools that are special.

use super::*;
use crate::support::studies::cancelled;

#[test]
fn sheets_without_tolerances_state_the_reason() {
    let good = built_in("pointer-on-head");
    let reason = |scenario: &Scenario| {
        let sheet = sheet_of(scenario);
        assert_eq!(sheet.bodies.len(), 2);
        assert!(sheet.bodies.iter().all(|b| b.together.is_none()));
        let check = check_built(scenario, &sheet, 10, 0, &Task::default());
        assert_eq!(check, Ok(None));
        sheet.no_tolerances.unwrap()
    };
    for requirement in [None, Some(Requirement::default())] {
        let none = Scenario { requirement, ..good.clone() };
        assert!(reason(&none).contains("states no requirement"));
    }
    let missed = Scenario { requirement: Some(at_most_mm(0.01)), ..good.clone() };
    let text = reason(&missed);
    assert!(text.contains("position_max is") && text.contains("0.01"), "{text}");
    let mut outside = good.clone();
    outside.outside = OutsidePolicy::Reject;
    outside.crf_from_tool = Pose::translation(5000.0, 0.0, 0.0);
    let text = reason(&outside);
    assert!(text.contains("all 3375 trials were left out"), "{text}");
    let mut bare = good.clone();
    bare.tool.sensors.clear();
    assert!(reason(&bare).contains("has no sensors"));
    let mut many = good.clone();
    let one = many.tool.sensors[0].clone();
    many.tool.sensors.extend(vec![one; MAX_SENSORS]);
    many.motion = None;
    many.requirement = Some(at_most_mm(1e6));
    assert!(reason(&many).contains("expected at most 64"));
    let mut endless = good;
    endless.tool.sensors[0].position_in_body.x = 1e300;
    reason(&endless);
}

#[test]
fn a_requirement_just_met_leaves_no_tolerance() {
    let mut scenario = built_in("pointer-on-head");
    scenario.motion = None;
    scenario.requirement = Some(all_bounds());
    let drawn = sheet_of(&scenario).as_drawn;
    scenario.requirement = Some(at_most_mm(drawn[2].value));
    let sheet = sheet_of(&scenario);
    assert_eq!(sheet.no_tolerances, None);
    let nothing = Tolerance::None { none: NoTolerance::NothingLeft };
    let alone = sheet.bodies[0].sensors[0].alone.as_ref().unwrap();
    assert_eq!(alone.position_mm, nothing);
    assert_eq!(sheet.bodies[1].together.as_ref().unwrap().position_mm, nothing);
}

#[test]
fn markers_and_unweighted_angles_have_no_angle_limit() {
    let places = [[0.0, 0.0, 0.0], [60.0, 0.0, 0.0], [0.0, 50.0, 90.0]];
    let markers = places.map(marker);
    let sheet = sheet_of(&ideal(markers.to_vec(), at_most_mm(0.5)));
    for sensor in &sheet.bodies[0].sensors {
        let alone = sensor.alone.as_ref().unwrap();
        assert!(alone.position_mm.value() > 0.1);
        let none = NoTolerance::NoAxis;
        assert_eq!(alone.angle_deg, Tolerance::None { none });
    }
    let coils = places.map(|p| five(p, [0.3, 0.2, 1.0]));
    let mut unweighted = ideal(coils.to_vec(), at_most_mm(0.5));
    unweighted.orientation_weight_mm = 0.0;
    let sheet = sheet_of(&unweighted);
    let [_, angle] = alone_of(&sheet);
    assert_eq!((angle.value, angle.limited_by), (MAX_ANGLE_DEG, None));
    // Three points are as good as three coils whose axes count for nothing.
    let together = sheet.bodies[0].together.as_ref().unwrap();
    assert!(together.position_mm.value() > 0.1);
}

#[test]
fn a_single_coil_leaves_a_rotation_free() {
    let mut scenario = ideal(vec![five([0.0, 0.0, 80.0], [0.0, 0.0, 1.0])], at_most_mm(1.05));
    scenario.tool.tip_in_body = None;
    let sheet = sheet_of(&scenario);
    assert_eq!(sheet.free_axis.unwrap().free.body, "tool");
    assert_eq!(sheet.bodies[0].tip_in_body_mm, None);
    assert_eq!(sheet.bodies[0].sensors[0].position_from_tip_mm, Some([0.0, 0.0, 80.0]));
    let [position, angle] = alone_of(&sheet);
    assert_eq!(position.value, 1.0);
    let exact_deg = 2.0 * (1.05 / 160.0_f64).asin().to_degrees();
    assert!((angle.simulated - exact_deg).abs() < 2e-3 * exact_deg);
}

#[test]
fn a_tilt_about_the_coils_own_axis_is_no_error() {
    let scenario = ideal(vec![five([0.0, 0.0, 80.0], [0.0, 0.6, 0.8])], at_most_mm(1.0));
    let study = BuiltStudy::new(&scenario, at_most_mm(1.0)).unwrap();
    let first_order = FirstOrder::new(&study, &[scenario.crf_from_tool]);
    let angle = &first_order.blocks[1];
    assert_eq!(angle.kind, trackwright_simulation::ErrorOf::Angle);
    let axis = Unit::new_normalize(Vector3::new(0.0, 0.6, 0.8));
    let across = perpendicular(&axis).into_inner();
    assert!((angle.unit_along(&(across + axis.into_inner() * 5.0)) - across).norm() < 1e-12);
    assert!(angle.unit_along(&axis).dot(&axis).abs() < 1e-12);
}

#[test]
fn a_long_study_is_checked_on_8192_of_its_poses() {
    let mut scenario = ideal(vec![six([0.0, 0.0, 100.0])], at_most_mm(0.705));
    let range = Some(AxisRange { min: -10.0, max: 10.0, step: 0.5 });
    scenario.motion = Some(Motion { x: range, y: range, rx: range, ..Motion::default() });
    let sheet = sheet_of(&scenario);
    assert_eq!((sheet.poses, sheet.study_poses), (8192, 41 * 41 * 41));
    assert_eq!(alone_of(&sheet)[0].value, 0.7);
    assert_eq!(manufacturing_sheet(&scenario, &cancelled()), Err(Cancelled));
}

#[test]
fn build_errors_are_the_same_in_the_tool_at_all_poses() {
    let coils = vec![
        five([0.0, 3.0, 70.0], [0.0, 0.2, 1.0]),
        five([4.0, 0.0, 110.0], [1.0, 0.0, 0.3]),
        six([0.0, -5.0, 140.0]),
    ];
    let mut scenario = ideal(coils, at_most_mm(1.0));
    scenario.motion = turning(40.0);
    let study = BuiltStudy::new(&scenario, at_most_mm(1.0)).unwrap();
    let mut errors = BuildErrors::none(&scenario);
    for (k, error) in errors.tool.iter_mut().enumerate() {
        let k = k as f64;
        error.position_mm = Vector3::new(0.5 - k, 0.3 * k, 1.0);
        error.rotation_rad = Vector3::new(0.05, -0.04 * k, 0.02 + 0.01 * k);
    }
    let mut buffers = BuiltBuffers::default();
    let cancel = Task::default().cancel;
    study.simulate(&mut buffers, &errors, &cancel).unwrap();
    let own: Vec<Pose> = study
        .crf_from_tool()
        .zip(&buffers.simulated)
        .map(|((pose, _), simulated)| pose.inverse() * simulated)
        .collect();
    assert!(own.len() == 27 && own[0].translation.vector.norm() > 0.5);
    for other in &own {
        let apart_mm = (other.translation.vector - own[0].translation.vector).norm();
        assert!(apart_mm < 1e-10 && other.rotation.angle_to(&own[0].rotation) < 1e-7);
    }
}
