//! Contributions add up, a sensor without distortion has none, and the worst trials are where they are.

use super::*;
use crate::body::Sensor;
use crate::metric::Metric;
use crate::motion::{AxisRange, Motion};
use crate::run::run;
use crate::scenario::ScenarioCrf;
use crate::trial::simulate_pose;
use nalgebra::UnitQuaternion;
use std::sync::Arc;
use trackwright_field::random_models::{random_model, room};
use trackwright_field::samples::MapKind;
use trackwright_field::{DistortionModel, Environment};
use trackwright_geometry::directions::{DirectionSet, Weighting};

fn sensor(name: &str, at: [f64; 3]) -> Sensor {
    Sensor::six_dof(name, at, UnitQuaternion::identity())
}

fn scenario(model: DistortionModel) -> Scenario {
    let range = |reach: f64, step: f64| Some(AxisRange { min: -reach, max: reach, step });
    Scenario {
        environment: Arc::new(Environment::of_model("room", model)),
        tool: RigidBody {
            name: "probe".into(),
            tip_in_body: Some(Point3::new(0.0, 0.0, -80.0)),
            sensors: vec![
                sensor("front", [0.0, 5.0, 0.0]),
                sensor("rear", [0.0, -5.0, 60.0]),
                sensor("side", [20.0, 0.0, 40.0]),
            ],
        },
        crf: None,
        crf_from_tool: Pose::translation(0.0, 0.0, -300.0),
        motion: Some(Motion {
            x: range(60.0, 20.0),
            y: range(60.0, 20.0),
            rz: range(40.0, 20.0),
            ..Motion::default()
        }),
        orientation_weight_mm: 100.0,
        requirement: None,
        outside: OutsidePolicy::Clamp,
    }
}

fn sources(scenario: &Scenario, mode: &Mode) -> ErrorSources {
    error_sources(scenario, mode, &CancelToken::default()).unwrap()
}

/// Errors of every component that change from place to place, small enough to add up.
fn rough() -> DistortionModel {
    let directions = DirectionSet::One;
    random_model(2, directions, Weighting::Area, [0.1, 5e-4], 3)
}

/// An error along x that grows with y alone.
fn growing_with_y() -> DistortionModel {
    // Of the corners the second index is y's.
    let corner = |k: usize| [if k / 2 % 2 == 1 { 1.0 } else { 0.0 }, 0.0, 0.0, 0.0, 0.0, 0.0];
    DistortionModel::of_position(1, room(), (0..8).map(corner).collect()).unwrap()
}

/// With a CRF of two sensors.
fn with_crf() -> Scenario {
    let mut scenario = scenario(rough());
    let crf = RigidBody {
        name: "crf".into(),
        tip_in_body: None,
        sensors: vec![sensor("a", [30.0, 0.0, 0.0]), sensor("b", [-30.0, 10.0, 0.0])],
    };
    scenario.crf =
        Some(ScenarioCrf { body: crf, tracker_from_crf: Pose::translation(20.0, 0.0, -290.0) });
    scenario.crf_from_tool = Pose::translation(0.0, 10.0, 0.0);
    scenario
}

#[test]
fn contributions_of_all_sensors_add_up() {
    let scenario = with_crf();
    let found = sources(&scenario, &Mode::Motion);
    assert_eq!(found.sensors.len(), 5);
    for of in ErrorOf::ALL {
        let sum: f64 = found.sensors.iter().map(|sensor| sensor.part(of)).sum();
        assert!((sum - 1.0).abs() < 0.01, "{of:?} {sum}");
    }
    let study = run(&scenario, &Mode::Motion, &CancelToken::default(), None).unwrap();
    let rms_mm = study.room_field.value(Metric::TIP_RMS);
    assert!((found.rms(ErrorOf::Position) - rms_mm).abs() < 1e-9 * rms_mm);
}

#[test]
fn the_only_sensor_carries_all_of_the_error() {
    let mut scenario = scenario(rough());
    scenario.tool.sensors.truncate(1);
    let found = sources(&scenario, &Mode::Motion);
    let only = found.largest(ErrorOf::Position).unwrap();
    assert!((only.part(ErrorOf::Position) - 1.0).abs() < 1e-9);
    assert!(only.rms_without(ErrorOf::Position) < 1e-9);
    assert!(found.rms(ErrorOf::Position) > 0.01);
}

#[test]
fn a_room_without_error_has_no_source() {
    let found =
        sources(&scenario(DistortionModel::zero(room(), MapKind::Distortion)), &Mode::Motion);
    assert!(found.rms(ErrorOf::Position) < 1e-9);
    assert!(found.sensors.iter().all(|sensor| sensor.rms_without(ErrorOf::Position) < 1e-9));
}

#[test]
fn the_worst_trials_are_where_the_field_is_worst() {
    let found = sources(&scenario(growing_with_y()), &Mode::Motion);
    let worst = found.worst(ErrorOf::Position).unwrap();
    assert_eq!(worst.trials, 13);
    let y = worst.ranges.iter().find(|span| span.axis == "y").unwrap();
    assert_eq!([y.from, y.to], [60.0, 60.0]);
    let x = worst.ranges.iter().find(|span| span.axis == "x");
    assert_eq!(x, None, "the field is the same along x");
    let words = worst.words(" ");
    assert!(words.contains("y 60 mm") && words.contains("worst 5 % of the trials"), "{words}");
}

#[test]
fn few_trials_have_no_worst_part() {
    let found = sources(&scenario(growing_with_y()), &Mode::Single);
    assert_eq!((found.trials, found.worst(ErrorOf::Position)), (1, None));
    assert_eq!(found.words(ErrorOf::Position, " ").len(), 1);
}

#[test]
fn words_state_part_rms_and_range() {
    let span = |axis, from, to| AxisSpan { axis, from, to };
    let worst = WorstTrials {
        trials: 20,
        ranges: vec![span("y", 120.0, 150.0), span("rx", 40.0, 60.0)],
        within: 20,
    };
    assert_eq!(
        worst.words(" "),
        "The worst 5 % of the trials lie at y 120 mm to 150 mm, rotations about x of 40° to 60° \
         from the design's pose"
    );
}

/// The scenario's own pose, and the sum of all contributions there.
fn at_own_pose(scenario: &Scenario) -> (f64, f64, Vec<TrialSource>) {
    let found = trial_sources(scenario, InputTrial::at(scenario.crf_from_tool));
    let sum_mm = found.iter().map(|source| source.along_tip_error_mm).sum();
    (simulate_pose(scenario).trial.tip_error_mm, sum_mm, found)
}

#[test]
fn contributions_at_a_trial_add_up_to_its_error() {
    let scenario = with_crf();
    let (error_mm, sum_mm, found) = at_own_pose(&scenario);
    let names: Vec<_> = found.iter().map(|source| (source.body, source.name.as_str())).collect();
    let expected =
        [("tool", "front"), ("tool", "rear"), ("tool", "side"), ("CRF", "a"), ("CRF", "b")];
    assert_eq!(names, expected);
    assert!(error_mm > 1e-3 && (sum_mm - error_mm).abs() < 0.01 * error_mm, "{error_mm} {sum_mm}");
    let mut alone = self::scenario(rough());
    alone.tool.sensors.truncate(1);
    let (error_mm, sum_mm, found) = at_own_pose(&alone);
    assert!(found.len() == 1 && error_mm > 1e-3);
    assert!((sum_mm - error_mm).abs() < 1e-9, "the only sensor has all of it");
}

#[test]
fn contributions_are_those_of_the_single_study() {
    let scenario = with_crf();
    let study = sources(&scenario, &Mode::Single);
    let (error_mm, _, found) = at_own_pose(&scenario);
    for (source, at_trial) in study.sensors.iter().zip(found) {
        let part_mm = source.part(ErrorOf::Position) * error_mm;
        assert!((part_mm - at_trial.along_tip_error_mm).abs() < 1e-9, "{at_trial:?} {part_mm}");
    }
}

#[test]
fn a_trial_without_sensors_has_no_contributions() {
    let mut bare = scenario(rough());
    bare.tool.sensors.clear();
    assert_eq!(trial_sources(&bare, InputTrial::at(bare.crf_from_tool)), []);
}

#[test]
fn contributions_in_words_are_sorted_and_add_up() {
    let source = |body, name: &str, along_tip_error_mm| TrialSource {
        body,
        name: name.to_owned(),
        along_tip_error_mm,
    };
    let all = [
        source("tool", "front", 0.1201),
        source("tool", "rear", -0.314),
        source("CRF", "a", 0.05),
        source("CRF", "b", -0.004),
    ];
    let words = |most| source_words(&all, most, " ");
    assert_eq!(words(4), ["rear −0.31 mm", "front 0.12 mm", "CRF a 0.05 mm", "CRF b 0.00 mm"]);
    assert_eq!(words(3), words(4), "one alone is named");
    assert_eq!(words(2), ["rear −0.31 mm", "front 0.12 mm", "2 others 0.05 mm"]);
}
