//! Studies: ideal rooms, what is free, what is outside, cancelling, and counts of work.

use crate::support::studies::{
    body, cancelled, default_design as built_in, default_in_polynomials, five, on_threads,
    one_direction, steps, study,
};
use nalgebra::{UnitQuaternion, Vector3};
use std::sync::Arc;
use trackwright_field::samples::MapKind;
use trackwright_field::{DistortionModel, Environment, OutsidePolicy};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_geometry::volume::Volume;
use trackwright_simulation::{
    CancelToken, InputTrial, Mode, Motion, Outcome, Scenario, ScenarioCrf, StudyError, Trial, run,
    simulate_pose,
};

/// Frames are fitted to some hundred mm with round-off of 1e-16: this leaves a factor of 100.
const EXACT_MM: f64 = 1e-11;

fn in_room(scenario: Scenario, model: DistortionModel) -> Scenario {
    let environment = Environment { model, ..(*scenario.environment).clone() };
    Scenario { environment: Arc::new(environment), ..scenario }
}

fn cube() -> Bounds {
    Volume::AuroraCube.bounds()
}

/// The same shift and turn everywhere.
fn uniform_room(error: [f64; 6]) -> DistortionModel {
    one_direction(1, cube(), vec![error; 8])
}

fn motion_study(scenario: &Scenario) -> Outcome {
    study(scenario, &Mode::Motion)
}

/// The same scenario without its CRF, the tool where it was.
fn without_crf(scenario: Scenario) -> Scenario {
    let tracker_from_crf = scenario.crf.as_ref().unwrap().tracker_from_crf;
    Scenario { crf_from_tool: tracker_from_crf * scenario.crf_from_tool, crf: None, ..scenario }
}

#[test]
fn an_ideal_room_has_no_error_wherever_the_crf_is() {
    let zero = DistortionModel::zero(cube(), MapKind::Distortion);
    let at_rest = in_room(built_in(), zero);
    let mut turned = at_rest.clone();
    turned.crf.as_mut().unwrap().tracker_from_crf *= pose_from_parts(
        Vector3::new(5.0, 0.0, 0.0),
        UnitQuaternion::from_euler_angles(0.3, -0.2, 1.0),
    );
    for scenario in [at_rest, turned] {
        let figures = motion_study(&scenario).room_field;
        assert!(figures.position_mm.max() < EXACT_MM, "{}", figures.position_mm.max());
        assert!(figures.angle_deg.max() < 1e-11, "{}", figures.angle_deg.max());
    }
}

#[test]
fn a_uniform_error_cancels_against_the_crf() {
    let room = uniform_room([3.0, -1.0, 2.0, 0.0, 0.0, 0.0]);
    let with_crf = in_room(built_in(), room);
    assert!(motion_study(&with_crf).room_field.position_mm.max() < EXACT_MM);
    let figures = motion_study(&without_crf(with_crf)).room_field;
    assert!((figures.position_mm.min() - 14_f64.sqrt()).abs() < 1e-9);
    assert!((figures.position_mm.max() - 14_f64.sqrt()).abs() < 1e-9);
}

#[test]
fn a_free_roll_has_a_determined_part() {
    let room = uniform_room([0.0, 0.0, 1.0, 0.02, 0.0, 0.0]);
    let scenario = in_room(built_in(), room);
    let on_a_line = Scenario {
        crf: None,
        crf_from_tool: Pose::translation(0.0, 0.0, -300.0),
        tool: body(vec![five([0.0, 0.0, 40.0], [0.0, 0.0, 1.0])], Some([5.0, 0.0, 0.0])),
        motion: None,
        ..scenario
    };
    let outcome = study(&on_a_line, &Mode::Single);
    let free = outcome.room_field.free_axis.unwrap();
    assert_eq!(free.free.body, "tool");
    let axis = Vector3::from(free.free.axis_in_body.unwrap());
    assert!(axis.cross(&Vector3::z()).norm() < 1e-12);
    let determined = outcome.room_field.position_mm_determined.unwrap();
    assert!(determined.max() <= outcome.room_field.position_mm.max());
    assert!(determined.max() > 0.5, "the shift along the axis stays: {}", determined.max());
}

#[test]
fn a_crf_with_a_free_rotation_is_reported() {
    let mut scenario = in_room(built_in(), uniform_room([0.1; 6]));
    let line = [0.0, 20.0].map(|z| five([0.0, 0.0, z], [0.0, 0.0, 1.0]));
    scenario.crf = Some(ScenarioCrf {
        body: body(line.to_vec(), None),
        tracker_from_crf: Pose::translation(0.0, 0.0, -300.0),
    });
    let outcome = study(&scenario, &Mode::Single);
    assert_eq!(outcome.room_field.free_axis.unwrap().free.body, "crf");
    assert!(outcome.room_field.position_mm_determined.is_some());
}

#[test]
fn motion_equals_the_same_poses_as_input() {
    let scenario = Scenario {
        motion: Some(Motion { x: steps(10.0, 2.0), rz: steps(40.0, 4.0), ..Motion::default() }),
        ..built_in()
    };
    let grid = scenario.motion_grid().unwrap().unwrap();
    let crf = scenario.crf.as_ref().unwrap().tracker_from_crf;
    let rows: Vec<_> = (0..grid.trials())
        .map(|i| InputTrial {
            tracker_from_crf: (i % 2 == 0).then_some(crf),
            crf_from_tool: grid.pose(i),
        })
        .collect();
    let given = study(&scenario, &Mode::Input(rows.into()));
    assert_eq!(motion_study(&scenario).room_field, given.room_field);
}

#[test]
fn a_study_counts_its_evaluations() {
    let scenario = built_in();
    let (tool, crf) = (
        scenario.tool.sensors.len() as u64,
        scenario.crf.as_ref().unwrap().body.sensors.len() as u64,
    );
    let outcome = motion_study(&scenario);
    // The design's own pose, which shows what the sensors determine, and every trial's tool.
    let expected = (tool + crf) + outcome.room_field.trials as u64 * tool;
    assert_eq!(outcome.work.study_evaluations, expected);
    assert_eq!(outcome.work.slice_evaluations, 0);
    assert_eq!(outcome.work.crf_evaluations, crf);
    assert_eq!(outcome.work.crf_trackings, 1);
    let trials = outcome.room_field.trials as u64;
    assert_eq!(outcome.work.crf_reuses, trials);
    assert_eq!(outcome.work.frame_fits, 2 + trials);
}

#[test]
fn a_design_without_crf_has_none_of_its_cost() {
    let with_crf = built_in();
    let tool = with_crf.tool.sensors.len() as u64;
    let without = without_crf(with_crf);
    let outcome = motion_study(&without);
    let (work, trials) = (outcome.work, outcome.room_field.trials as u64);
    assert_eq!(work.study_evaluations, (1 + trials) * tool);
    assert_eq!(work.frame_fits, 1 + trials);
    let of_crf = (work.crf_evaluations, work.crf_trackings, work.crf_reuses);
    assert_eq!(of_crf, (0, 0, 0));
    let shown = simulate_pose(&without).work;
    assert_eq!((shown.pose_evaluations, shown.frame_fits), (tool, 1));
    assert_eq!((shown.crf_evaluations, shown.crf_trackings), (0, 0));
}

/// Input of some poses of the CRF, each for some trials.
fn input(crf_poses: &[Option<Pose>], trials_each: usize, crf_from_tool: Pose) -> Mode {
    let rows: Vec<_> = crf_poses
        .iter()
        .flat_map(|&tracker_from_crf| {
            (0..trials_each).map(move |i| InputTrial {
                tracker_from_crf,
                crf_from_tool: crf_from_tool * Pose::translation(0.1 * i as f64, 0.0, 0.0),
            })
        })
        .collect();
    Mode::Input(rows.into())
}

#[test]
fn a_crf_is_tracked_again_only_where_it_moves() {
    let scenario = built_in();
    let sensors = scenario.crf.as_ref().unwrap().body.sensors.len() as u64;
    let own = scenario.crf.as_ref().unwrap().tracker_from_crf;
    let moved = own * Pose::translation(5.0, 0.0, 0.0);
    let trackings = |poses: &[Option<Pose>]| {
        let mode = input(poses, 10, scenario.crf_from_tool);
        let work = study(&scenario, &mode).work;
        assert_eq!(work.crf_evaluations, work.crf_trackings * sensors);
        assert_eq!(work.crf_trackings + work.crf_reuses, 1 + 10 * poses.len() as u64);
        work.crf_trackings
    };
    assert_eq!(trackings(&[None, Some(own)]), 1);
    assert_eq!(trackings(&[None, Some(moved)]), 2);
    assert_eq!(trackings(&[Some(moved), None, Some(own * moved)]), 3);
}

/// Five positions a side, and turns about two axes.
fn shared_orientations(scenario: &Scenario, turns: bool) -> Scenario {
    Scenario {
        motion: Some(Motion {
            x: steps(40.0, 4.0),
            y: steps(40.0, 4.0),
            z: steps(30.0, 4.0),
            rx: steps(20.0, 2.0).filter(|_| turns),
            rz: steps(35.0, 6.0).filter(|_| turns),
            ..Motion::default()
        }),
        ..scenario.clone()
    }
}

#[test]
fn shared_orientations_blend_coefficients_once() {
    let scenario = default_in_polynomials();
    let sensors = scenario.tool.sensors.len() as u64;
    for (turns, orientations) in [(false, 1), (true, 21)] {
        let scenario = shared_orientations(&scenario, turns);
        let outcome = motion_study(&scenario);
        let trials = outcome.room_field.trials as u64;
        assert_eq!(trials, 125 * orientations);
        assert_eq!(outcome.work.coefficient_blends, orientations * sensors);
        assert_eq!(outcome.work.blended_evaluations, trials * sensors);
    }
}

#[test]
fn grouped_poses_come_back_in_their_order() {
    let scenario = shared_orientations(&default_in_polynomials(), true);
    let grid = scenario.motion_grid().unwrap().unwrap();
    let rows: Vec<_> = (0..grid.trials()).map(|i| InputTrial::at(grid.pose(i))).collect();
    let cancel = CancelToken::default();
    let logged = |mode: &Mode| {
        let mut trials = Vec::new();
        let mut log = |trial: &Trial| trials.push(*trial);
        let outcome = run(&scenario, mode, &cancel, Some(&mut log)).unwrap();
        (outcome, trials)
    };
    let (grouped, moved) = logged(&Mode::Motion);
    let (scattered, given) = logged(&Mode::Input(rows.into()));
    assert!(grouped.work.blended_evaluations > 0);
    assert_eq!(scattered.work.blended_evaluations, 0);
    assert_eq!(moved.len(), given.len());
    for (a, b) in moved.iter().zip(&given) {
        assert_eq!(a.crf_from_tool, b.crf_from_tool);
        assert_eq!((a.outside, a.out_of_volume), (b.outside, b.out_of_volume));
        // Sums in another order, of coefficients of some mm.
        let difference = a.tip_error_in_crf_mm - b.tip_error_in_crf_mm;
        assert!(difference.norm() < EXACT_MM, "{difference}");
    }
}

#[test]
fn a_study_does_not_depend_on_threads() {
    for scenario in [built_in(), shared_orientations(&built_in(), true)] {
        let on = |threads| on_threads(threads, || motion_study(&scenario));
        let one = on(1);
        for threads in [2, 3, 7] {
            assert_eq!(one, on(threads));
        }
    }
}

#[test]
fn outside_box_and_volume_are_counted_apart() {
    let small = Bounds::from(([-10.0, -10.0, -310.0], [10.0, 10.0, -290.0]));
    let scenario = in_room(built_in(), DistortionModel::zero(small, MapKind::Distortion));
    let figures = motion_study(&scenario).room_field;
    assert_eq!(figures.outside, figures.trials);
    assert_eq!(figures.out_of_volume, 0);
    let rejecting = Scenario { outside: OutsidePolicy::Reject, ..scenario };
    let found = run(&rejecting, &Mode::Motion, &CancelToken::default(), None);
    assert_eq!(found, Err(StudyError::AllRejected { trials: figures.trials }));
}

#[test]
fn a_cancelled_study_has_no_outcome() {
    let stopped = run(&built_in(), &Mode::Motion, &cancelled().cancel, None);
    assert_eq!(stopped, Err(StudyError::Cancelled));
}

#[test]
fn what_the_scene_shows_is_the_single_trial() {
    let scenario = built_in();
    let shown = simulate_pose(&scenario);
    let outcome = study(&scenario, &Mode::Single);
    assert_eq!(shown.trial.tip_error_mm, outcome.room_field.position_mm.rms());
    assert_eq!(shown.tool.sensors.len(), scenario.tool.sensors.len());
    assert_eq!(shown.work.pose_evaluations, 6);
}
