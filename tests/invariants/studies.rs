//! Studies: ideal rooms, what is free, what is outside, cancelling, and counts of work.

use nalgebra::{Point3, Unit, UnitQuaternion, Vector3};
use std::sync::Arc;
use trackwright::field::samples::MapKind;
use trackwright::field::{DistortionModel, Environment, OutsidePolicy};
use trackwright::geometry::bounds::Bounds;
use trackwright::geometry::directions::{DirectionSet, Weighting};
use trackwright::geometry::pose::{Pose, pose_from_parts};
use trackwright::geometry::volume::Volume;
use trackwright::store;
use trackwright::study::{
    self, AxisRange, CancelToken, InputTrial, Mode, Motion, Scenario, ScenarioCrf, StudyError,
};
use trackwright::tracking::{RigidBody, Sensor, SensorOrientation};

/// Frames are fitted to some hundred mm with round-off of 1e-16: this leaves a factor of 100.
const EXACT_MM: f64 = 1e-11;

fn built_in() -> Scenario {
    let world = store::open_builtin(store::DEFAULT_BUILTIN).unwrap();
    store::resolve(world.document.design(), &world.environment)
}

fn in_room(scenario: Scenario, model: DistortionModel) -> Scenario {
    let environment = Environment {
        model,
        ..(*scenario.environment).clone()
    };
    Scenario {
        environment: Arc::new(environment),
        ..scenario
    }
}

fn cube() -> Bounds {
    Volume::AuroraCube.bounds()
}

/// The same shift and turn everywhere.
fn uniform_room(error: [f64; 6]) -> DistortionModel {
    DistortionModel::new(
        1,
        DirectionSet::One,
        Weighting::Area,
        MapKind::Distortion,
        cube(),
        vec![error; 8],
    )
    .unwrap()
}

fn motion_study(scenario: &Scenario) -> study::Outcome {
    study::run(scenario, &Mode::Motion, &CancelToken::default(), None).unwrap()
}

fn five(name: &str, z_mm: f64, axis: [f64; 3]) -> Sensor {
    Sensor {
        name: name.into(),
        position_in_body: Point3::new(0.0, 0.0, z_mm),
        orientation: SensorOrientation::FiveDof(Unit::new_normalize(axis.into())),
        coil: None,
    }
}

#[test]
fn an_ideal_room_has_no_error() {
    let scenario = built_in();
    let zero = DistortionModel::zero(cube(), MapKind::Distortion);
    let figures = motion_study(&in_room(scenario, zero)).figures;
    assert!(
        figures.position_mm.max < EXACT_MM,
        "{}",
        figures.position_mm.max
    );
    assert!(figures.angle_deg.max < 1e-11, "{}", figures.angle_deg.max);
}

#[test]
fn an_error_that_is_the_same_everywhere_cancels_against_the_crf_and_not_without() {
    let room = uniform_room([3.0, -1.0, 2.0, 0.0, 0.0, 0.0]);
    let with_crf = in_room(built_in(), room);
    assert!(motion_study(&with_crf).figures.position_mm.max < EXACT_MM);
    let tracker_from_crf = with_crf.crf.as_ref().unwrap().tracker_from_crf;
    let without = Scenario {
        crf_from_tool: tracker_from_crf * with_crf.crf_from_tool,
        crf: None,
        ..with_crf
    };
    let figures = motion_study(&without).figures;
    assert!((figures.position_mm.min - 14_f64.sqrt()).abs() < 1e-9);
    assert!((figures.position_mm.max - 14_f64.sqrt()).abs() < 1e-9);
}

#[test]
fn where_the_roll_is_free_the_determined_part_stands_beside_the_error() {
    let room = uniform_room([0.0, 0.0, 1.0, 0.02, 0.0, 0.0]);
    let scenario = in_room(built_in(), room);
    let on_a_line = Scenario {
        crf: None,
        crf_from_tool: Pose::translation(0.0, 0.0, -300.0),
        tool: RigidBody {
            name: "needle".into(),
            tip_in_body: Some(Point3::new(5.0, 0.0, 0.0)),
            sensors: vec![five("a", 40.0, [0.0, 0.0, 1.0])],
        },
        motion: None,
        ..scenario
    };
    let outcome = study::run(&on_a_line, &Mode::Single, &CancelToken::default(), None).unwrap();
    let free = outcome.figures.free_axis.unwrap();
    assert_eq!(free.body, "tool");
    let axis = Vector3::from(free.axis_in_body.unwrap());
    assert!(axis.cross(&Vector3::z()).norm() < 1e-12);
    let determined = outcome.figures.position_mm_determined.unwrap();
    assert!(determined.max <= outcome.figures.position_mm.max);
    assert!(
        determined.max > 0.5,
        "the shift along the axis stays: {}",
        determined.max
    );
}

#[test]
fn tool_sensors_decide_before_crf_sensors_whose_rotation_is_reported_free() {
    let mut scenario = in_room(built_in(), uniform_room([0.1; 6]));
    let line = vec![
        five("a", 0.0, [0.0, 0.0, 1.0]),
        five("b", 20.0, [0.0, 0.0, 1.0]),
    ];
    scenario.crf = Some(ScenarioCrf {
        body: RigidBody {
            name: "rod".into(),
            tip_in_body: None,
            sensors: line,
        },
        tracker_from_crf: Pose::translation(0.0, 0.0, -300.0),
    });
    let outcome = study::run(&scenario, &Mode::Single, &CancelToken::default(), None).unwrap();
    assert_eq!(outcome.figures.free_axis.unwrap().body, "crf");
    assert!(outcome.figures.position_mm_determined.is_some());
}

#[test]
fn motion_about_a_pose_equals_the_same_poses_as_input() {
    let scenario = Scenario {
        motion: Some(Motion {
            x: Some(AxisRange {
                min: -10.0,
                max: 10.0,
                step: 10.0,
            }),
            rz: Some(AxisRange {
                min: -40.0,
                max: 40.0,
                step: 20.0,
            }),
            ..Motion::default()
        }),
        ..built_in()
    };
    let grid = scenario
        .motion
        .unwrap()
        .grid(&scenario.crf_from_tool)
        .unwrap();
    let crf = scenario.crf.as_ref().unwrap().tracker_from_crf;
    let rows: Vec<_> = (0..grid.trials())
        .map(|i| InputTrial {
            tracker_from_crf: (i % 2 == 0).then_some(crf),
            crf_from_tool: grid.pose(i),
        })
        .collect();
    let cancel = CancelToken::default();
    let moved = study::run(&scenario, &Mode::Motion, &cancel, None).unwrap();
    let given = study::run(&scenario, &Mode::Input(rows.into()), &cancel, None).unwrap();
    assert_eq!(moved.figures, given.figures);
}

#[test]
fn a_study_counts_its_evaluations_and_tracks_a_fixed_crf_once() {
    let scenario = built_in();
    let (tool, crf) = (
        scenario.tool.sensors.len() as u64,
        scenario.crf.as_ref().unwrap().body.sensors.len() as u64,
    );
    let outcome = motion_study(&scenario);
    // The design's own pose, which says what the sensors determine, and every trial's tool.
    let expected = (tool + crf) + outcome.figures.trials as u64 * tool;
    assert_eq!(outcome.work.study_evaluations, expected);
    assert_eq!(outcome.work.slice_evaluations, 0);
}

#[test]
fn sensors_outside_the_box_and_out_of_the_volume_are_counted_apart() {
    let small = Bounds::from(([-10.0, -10.0, -310.0], [10.0, 10.0, -290.0]));
    let scenario = in_room(
        built_in(),
        DistortionModel::zero(small, MapKind::Distortion),
    );
    let figures = motion_study(&scenario).figures;
    assert_eq!(figures.outside, figures.trials);
    assert_eq!(figures.out_of_volume, 0);
    let rejecting = Scenario {
        outside: OutsidePolicy::Reject,
        ..scenario
    };
    assert_eq!(
        study::run(&rejecting, &Mode::Motion, &CancelToken::default(), None),
        Err(StudyError::AllRejected {
            trials: figures.trials
        })
    );
}

#[test]
fn a_cancelled_study_has_no_outcome() {
    let cancel = CancelToken::default();
    cancel.cancel();
    assert_eq!(
        study::run(&built_in(), &Mode::Motion, &cancel, None),
        Err(StudyError::Cancelled)
    );
}

#[test]
fn what_the_scene_shows_is_the_single_trial() {
    let scenario = built_in();
    let shown = study::look(&scenario);
    let outcome = study::run(&scenario, &Mode::Single, &CancelToken::default(), None).unwrap();
    assert_eq!(shown.trial.tip_error_mm, outcome.figures.position_mm.rms);
    assert_eq!(shown.tool.sensors.len(), scenario.tool.sensors.len());
    assert_eq!(shown.work.pose_evaluations, 6);
}

#[test]
fn turning_tool_and_crf_together_with_the_room_at_rest_changes_no_exact_result() {
    let zero = DistortionModel::zero(cube(), MapKind::Distortion);
    let mut scenario = in_room(built_in(), zero);
    if let Some(crf) = &mut scenario.crf {
        crf.tracker_from_crf *= pose_from_parts(
            Vector3::new(5.0, 0.0, 0.0),
            UnitQuaternion::from_euler_angles(0.3, -0.2, 1.0),
        );
    }
    assert!(motion_study(&scenario).figures.position_mm.max < EXACT_MM);
}
