//! Trials charted over a design's range of motion.
use crate::support::studies::{default_design, steps, study};
use trackwright_simulation::profile::*;
use trackwright_simulation::{Metric, Mode, Motion, Scenario, Study};
use trackwright_task::CancelToken;

fn scenario() -> Scenario {
    let (x, z, ry) = (steps(40.0, 3.0), steps(20.0, 1.0), steps(30.0, 4.0));
    Scenario { motion: Some(Motion { x, z, ry, ..Motion::default() }), ..default_design() }
}

fn profiled(mode: &Mode) -> (Study, Profile) {
    let (outcome, profile) = study_profiled(&scenario(), mode, &CancelToken::default()).unwrap();
    (outcome, profile.unwrap())
}

#[test]
fn a_trial_s_error_is_that_of_its_pose_alone() {
    let scenario = scenario();
    let (_, profile) = profiled(&Mode::Motion);
    assert_eq!(profile.len(), 4 * 2 * 5);
    for trial in [0, 17, 39] {
        let pose = trial_pose(&scenario, &Mode::Motion, trial).unwrap();
        let alone = Mode::Input(vec![pose].into());
        let outcome = study(&scenario, &alone);
        let difference = outcome.room_field.position_mm.max() - profile.tip_error_mm[trial];
        // The whole grid shares blends of coefficients between poses.
        assert!(difference.abs() < 1e-12, "{difference:e}");
    }
    assert_eq!(trial_pose(&scenario, &Mode::Motion, 40), None);
}

#[test]
fn profiles_of_all_axes_agree_with_the_figures() {
    let (outcome, profile) = profiled(&Mode::Motion);
    let names: Vec<&str> = profile.axes.iter().map(|a| a.axis).collect();
    assert_eq!(names, ["x", "z", "ry", POSITION, ORIENTATION]);
    let of_all = outcome.room_field.position_mm;
    for axis in &profile.axes {
        let squares: f64 = axis.rms_mm.iter().map(|rms| rms * rms).sum();
        let rms = (squares / axis.values.len() as f64).sqrt();
        assert!((rms - of_all.rms()).abs() < 1e-12);
        let max = axis.max_mm.iter().copied().fold(0.0, f64::max);
        assert_eq!(max, of_all.max());
    }
    assert_eq!(profile.axes[2].values, [-30.0, -15.0, 0.0, 15.0, 30.0]);
}

#[test]
fn an_axis_s_profile_is_of_the_trials_with_its_value() {
    let scenario = scenario();
    let (_, profile) = profiled(&Mode::Motion);
    let x_mm = |trial| {
        let pose = trial_pose(&scenario, &Mode::Motion, trial).unwrap();
        pose.crf_from_tool.translation.x - scenario.crf_from_tool.translation.x
    };
    let axis = &profile.axes[0];
    for (k, value) in axis.values.iter().enumerate() {
        let own = (0..profile.len()).filter(|&t| (x_mm(t) - value).abs() < 1e-9);
        let largest = own.map(|t| profile.tip_error_mm[t]).fold(0.0, f64::max);
        assert_eq!(largest, axis.max_mm[k]);
        assert_eq!(profile.tip_error_mm[axis.worst_trial[k]], largest);
        assert!((x_mm(axis.worst_trial[k]) - value).abs() < 1e-9);
    }
}

#[test]
fn the_worst_trial_of_each_bar_lies_in_it() {
    let (outcome, profile) = profiled(&Mode::Motion);
    assert_eq!(profile.worst(), Some(outcome.room_field.worst.trial));
    let Histogram { width, counts } = profile.histogram();
    for (k, count) in counts.iter().enumerate() {
        let (from, to) = (k as f64 * width, (k + 1) as f64 * width);
        match profile.worst_between(from, to) {
            None => assert_eq!(*count, 0),
            Some(trial) => assert!((from..to).contains(&profile.tip_error_mm[trial])),
        }
    }
}

#[test]
fn positions_stand_each_for_all_orientations_there() {
    let (_, profile) = profiled(&Mode::Motion);
    let [.., position, orientation] = profile.axes.as_slice() else {
        panic!("{:?}", profile.axes);
    };
    assert_eq!((position.values.len(), orientation.values.len()), (8, 5));
    let there = &profile.tip_error_mm[10..15];
    assert_eq!(position.max_mm[2], there.iter().copied().fold(0.0, f64::max));
    let turned = profile.tip_error_mm.iter().skip(3).step_by(5);
    assert_eq!(orientation.max_mm[3], turned.copied().fold(0.0, f64::max));
}

#[test]
fn every_trial_is_in_one_bar_and_one_column() {
    let (outcome, profile) = profiled(&Mode::Motion);
    let histogram = profile.histogram();
    assert_eq!(histogram.counts.iter().sum::<usize>(), profile.len());
    assert!(histogram.counts.len() <= MAX_BARS + 1);
    let columns = profile.columns(7);
    assert!(columns.len() <= 7);
    let worst = columns.iter().max_by(|a, b| a.max_mm.total_cmp(&b.max_mm)).unwrap();
    assert_eq!(worst.worst_trial, outcome.room_field.worst.trial);
}

#[test]
fn the_cumulative_curve_ends_at_the_largest_error() {
    let (outcome, profile) = profiled(&Mode::Motion);
    let curve = profile.cumulative(16);
    assert_eq!(curve.last(), Some(&(outcome.room_field.position_mm.max(), 1.0)));
    assert!(curve.windows(2).all(|w| w[0].0 <= w[1].0 && w[0].1 <= w[1].1));
    let (median, half) = curve[8];
    assert!((profile.part_within(median) - half).abs() < 1e-12);
}

#[test]
fn a_single_pose_has_a_profile_of_one() {
    let (outcome, profile) = profiled(&Mode::Single);
    assert_eq!(profile.tip_error_mm, [outcome.room_field.position_mm.max()]);
    assert!(profile.axes.is_empty());
    assert_eq!(profile.cumulative(10).len(), 3);
}

#[test]
fn the_curve_along_the_shaft_is_that_of_other_tips() {
    let scenario = scenario();
    let (outcome, profile) = profiled(&Mode::Motion);
    let along = profile.along_shaft.unwrap();
    let at_tip_mm = along.rms_mm(0.0);
    assert!((at_tip_mm - outcome.room_field.value(Metric::TIP_RMS)).abs() < 1e-12);
    // The frame fits do not depend on the tip: a study of another point has the curve's value.
    let tip = scenario.tool.judged_tip_in_body();
    for part in [0.3, 0.8, 1.0] {
        let from_tip_mm = part * along.length_mm;
        let mut other = scenario.clone();
        other.tool.tip_in_body = Some(tip + along.axis_in_tool.as_ref() * from_tip_mm);
        let study = study(&other, &Mode::Motion);
        let difference = study.room_field.value(Metric::TIP_RMS) - along.rms_mm(from_tip_mm);
        assert!(difference.abs() < 1e-9, "{part}: {difference:e}");
    }
    let rearmost = along.sensors_mm.iter().copied().fold(0.0, f64::max);
    assert_eq!(along.length_mm, rearmost);
    let curve = along.curve(50);
    // The root of a square that is nowhere below zero is convex: it has one minimum.
    assert!(curve.windows(3).all(|w| w[0].1 + w[2].1 >= 2.0 * w[1].1 - 1e-12), "{curve:?}");
    assert_eq!((curve[0].0, curve[49].0), (0.0, along.length_mm));
}
