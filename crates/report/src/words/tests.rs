//! Statements hold for the numbers that they are about.

use super::*;
use nalgebra::{UnitQuaternion, Vector3};
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;
use trackwright_field::Environment;
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_simulation::Metric;
use trackwright_simulation::scenario::InputTrial;
use trackwright_simulation::{AxisRange, CancelToken, Motion, study};

fn scenario() -> Scenario {
    let world =
        trackwright_project::open_builtin_without_meshes(trackwright_project::DEFAULT_BUILTIN)
            .unwrap();
    trackwright_project::resolve(world.document.design(), &world.environment)
}

fn words(scenario: &Scenario, mode: &Mode) -> PlainWords {
    let study = study(scenario, mode, &CancelToken::default(), None).unwrap();
    plain_words(scenario, mode, &study)
}

/// The built-in pointer, whose shaft is z of its frame, turned so from the design's pose.
fn held(turn: UnitQuaternion<f64>, shift: [f64; 3]) -> WorstPose {
    let scenario = scenario();
    let own = scenario.crf_from_tool;
    let crf_from_tool: Pose =
        pose_from_parts(own.translation.vector + Vector3::from(shift), turn * own.rotation);
    let trial = InputTrial::at(crf_from_tool);
    let mode = Mode::Input(vec![trial].into());
    worst_pose(&scenario, &mode, &trial)
}

/// Where the design has the pointer's shaft, in the CRF, whose axes are the tracker's.
fn shaft() -> Vector3<f64> {
    scenario().crf_from_tool.rotation * Vector3::z()
}

fn to(direction: Vector3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::rotation_between(&shaft(), &direction).unwrap()
}

#[test]
fn the_headline_has_part_within_limit_and_worst() {
    let mut scenario = scenario();
    let mode = Mode::Motion;
    let found = study(&scenario, &mode, &CancelToken::default(), None).unwrap();
    // A limit that lies within the errors.
    let limit_mm = found.figures.get(Metric::TIP_MEDIAN).unwrap().value;
    scenario.requirement = Some(Requirement::at_most([(Metric::TIP_MAX, limit_mm)]));
    let study = study(&scenario, &mode, &CancelToken::default(), None).unwrap();
    let found = plain_words(&scenario, &mode, &study);
    let within = study.figures.within.unwrap();
    assert!((0.4..=0.6).contains(&within.part), "{within:?}");
    let [low, high] = within.interval.unwrap().map(percent);
    let part = (100.0 * within.part).floor();
    let part = format!("{part:.0}\u{2009}% of the positions within {limit_mm}\u{2009}mm");
    let expected = format!("{part} (95\u{2009}%: {low} to {high}); worst ");
    assert!(found.headline.starts_with(&expected), "{found:?}");
    let worst_mm = study.figures.get(Metric::TIP_MAX).unwrap().value;
    let (_, worst) = found.headline.split_once("; worst ").unwrap();
    let shown: f64 = worst.split('\u{2009}').next().unwrap().parse().unwrap();
    assert!((shown - worst_mm).abs() <= 0.05, "{worst} {worst_mm}");
    assert!(found.verdict.contains("tip error max is"), "{found:?}");
}

#[test]
fn rounding_crosses_no_limit() {
    assert_eq!(length(1.04, Some(1.0)), "1.04\u{2009}mm");
    assert_eq!(length(1.04, None), "1.0\u{2009}mm");
    assert_eq!(length(1.000_000_3, Some(1.0)), "1.0000003\u{2009}mm");
    assert_eq!(length(0.9999, Some(1.0)), "1.00\u{2009}mm");
    assert_eq!(length(1.25, Some(1.249)), "1.25\u{2009}mm");
    assert_eq!(length(f64::NAN, Some(1.0)), "no number");
    assert_eq!(part_of_positions(0.999, 3375), "More than 99\u{2009}% of the positions");
    assert_eq!(part_of_positions(0.946, 3375), "94\u{2009}% of the positions");
    assert_eq!(part_of_positions(1.0, 3375), "All 3,375 positions");
    assert_eq!(part_of_positions(0.001, 3375), "Less than 1\u{2009}% of the positions");
    assert_eq!(part_of_positions(0.0, 3375), "None of the 3,375 positions");
    assert_eq!(as_set(1.25, "mm"), "1.25\u{2009}mm");
}

#[test]
fn flat_and_upright_are_as_the_generator_sees() {
    let flat = held(to(Vector3::new(0.6, 0.8, 0.05)), [0.0; 3]);
    assert_eq!(flat.in_short().as_deref(), Some("held flat to the field generator"));
    // The volume is at negative z: a handle there leaves the tip next to the generator.
    let at = held(to(-Vector3::z()), [0.0; 3]);
    assert_eq!(at.in_short().as_deref(), Some("pointing straight at the field generator"));
    let away = held(to(Vector3::z()), [0.0; 3]);
    assert_eq!(away.in_short().as_deref(), Some("pointing straight away from the field generator"));
}

#[test]
fn tilt_and_twist_compose_the_turn() {
    let along = nalgebra::Unit::new_normalize(shaft());
    let across = nalgebra::Unit::new_normalize(shaft().cross(&Vector3::x()));
    for (tilt_deg, twist_deg) in [(0.0, 30.0), (20.0, 0.0), (35.0, -50.0), (60.0, 170.0)] {
        let twist = UnitQuaternion::from_axis_angle(&along, f64::to_radians(twist_deg));
        let tilt = UnitQuaternion::from_axis_angle(&across, f64::to_radians(tilt_deg));
        let found = held(tilt * twist, [0.0; 3]);
        assert!((found.tilt_deg - tilt_deg).abs() < 1e-6, "{found:?}");
        assert!((found.twist_deg - twist_deg).abs() < 1e-6, "{found:?}");
    }
    let both = held(
        UnitQuaternion::from_axis_angle(&across, 0.4)
            * UnitQuaternion::from_axis_angle(&along, 0.5),
        [0.0; 3],
    );
    let text = both.in_full();
    assert!(text.contains("tilted by 23°"), "{text}");
    assert!(text.contains("turned by 29° about its shaft"), "{text}");
    let none = held(UnitQuaternion::identity(), [0.0; 3]);
    assert_eq!(none.in_short().as_deref(), Some("held as in the design"));
}

#[test]
fn farther_and_aside_are_from_the_generator() {
    let found = held(UnitQuaternion::identity(), [3.0, 4.0, -20.0]);
    assert!((found.farther_mm - 20.0).abs() < 1e-9 && (found.aside_mm - 5.0).abs() < 1e-9);
    let text = found.in_full();
    assert_eq!(
        text,
        "with the tool 20\u{2009}mm farther from the field generator and 5\u{2009}mm aside"
    );
    let nearer = held(UnitQuaternion::identity(), [0.0, 0.0, 7.0]).in_full();
    assert_eq!(nearer, "with the tool 7\u{2009}mm nearer to the field generator");
}

#[test]
fn a_study_without_turns_names_no_posture() {
    let mut scenario = scenario();
    scenario.motion = Some(Motion {
        z: Some(AxisRange { min: -40.0, max: 40.0, step: 40.0 }),
        ..Motion::default()
    });
    scenario.environment = bare(&scenario);
    let found = words(&scenario, &Mode::Motion);
    assert!(!found.headline.contains("held"), "{found:?}");
    assert!(found.headline.contains("the field generator"), "{found:?}");
}

/// The room's model without what it rests on.
fn bare(scenario: &Scenario) -> Arc<Environment> {
    Arc::new(Environment::of_model("bare", scenario.environment.model.clone()))
}

#[test]
fn one_position_is_one_distance_and_has_no_worst() {
    let found = words(&scenario(), &Mode::Single);
    assert!(found.headline.starts_with("The tip is 0."), "{found:?}");
    assert_eq!(found.worst, None);
}

#[test]
fn one_pose_of_many_is_not_judged_by_an_rms() {
    let mut scenario = scenario();
    scenario.requirement = Some(Requirement::at_most([(Metric::TIP_RMS, 1e-3)]));
    let of = |scenario: &Scenario, mode| words(scenario, mode).verdict;
    assert!(of(&scenario, &Mode::Single).starts_with("One pose is not judged"));
    assert!(of(&scenario, &Mode::Motion).starts_with("The requirement is missed"));
    scenario.requirement = Some(Requirement::at_most([(Metric::TIP_MAX, 1e-3)]));
    assert!(of(&scenario, &Mode::Single).starts_with("The requirement is missed"));
    // A design that does not move is judged where it is.
    scenario.requirement = Some(Requirement::at_most([(Metric::TIP_RMS, 1e-3)]));
    scenario.motion = None;
    assert!(of(&scenario, &Mode::Single).starts_with("The requirement is missed"));
}

#[test]
fn a_missed_bound_states_by_how_much() {
    let mut scenario = scenario();
    let found = study(&scenario, &Mode::Motion, &CancelToken::default(), None).unwrap();
    let rms_mm = found.figures.get(Metric::TIP_RMS).unwrap().value;
    let limit_mm = (50.0 * rms_mm).floor() / 100.0;
    scenario.requirement = Some(Requirement::at_most([(Metric::TIP_RMS, limit_mm)]));
    let verdict = words(&scenario, &Mode::Motion).verdict;
    let over = format!("which is {:.2}\u{2009}mm less", rms_mm - limit_mm);
    assert!(verdict.contains(&over), "{verdict} {over}");
}

#[test]
fn a_plate_of_sensors_has_no_shaft() {
    let mut scenario = scenario();
    scenario.tool.tip_in_body = None;
    for (sensor, place) in
        scenario.tool.sensors.iter_mut().zip([[9.0, 0.0, 0.0], [-9.0, 5.0, 0.0], [0.0, -5.0, 0.0]])
    {
        sensor.position_in_body = place.into();
    }
    let turn = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), FRAC_PI_2);
    let trial = InputTrial::at(pose_from_parts(
        scenario.crf_from_tool.translation.vector,
        turn * scenario.crf_from_tool.rotation,
    ));
    let found = worst_pose(&scenario, &Mode::Input(vec![trial].into()), &trial);
    assert_eq!(found.shaft_elevation_deg, None);
    assert_eq!(found.in_short().as_deref(), Some("turned by 90°"));
}

#[test]
fn limitations_of_a_study_are_stated() {
    let mut scenario = scenario();
    scenario.motion = None;
    scenario.crf_from_tool.translation.vector.z -= 5000.0;
    scenario.requirement = None;
    let found = words(&scenario, &Mode::Single);
    assert_eq!(found.verdict, "No requirement is set.");
    let all = found.cautions.join(" ");
    assert!(all.contains("outside the part of the room"), "{all}");
    assert!(all.contains("outside the volume"), "{all}");
}
