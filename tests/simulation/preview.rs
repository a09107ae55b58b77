//! A preview of few trials against the whole study.

use crate::support::studies::{default_design, steps, study};
use std::collections::HashSet;
use trackwright_simulation::preview::*;
use trackwright_simulation::{Mode, Motion, Scenario};

fn scenario(count: f64) -> Scenario {
    let [shift, turn] = [40.0, 30.0].map(|reach| steps(reach, count));
    let motion = Motion { x: shift, y: shift, z: shift, rx: turn, rz: turn, ..Motion::default() };
    Scenario { motion: Some(motion), ..default_design() }
}

#[test]
fn a_short_range_of_motion_needs_no_preview() {
    assert!(preview(&scenario(2.0)).is_none());
    let still = Scenario { motion: None, ..scenario(2.0) };
    assert!(preview(&still).is_none());
}

#[test]
fn a_preview_is_within_1_percent_of_the_whole_study() {
    let scenario = scenario(7.0);
    let preview = preview(&scenario).unwrap();
    assert_eq!(preview.whole_trials, 8_usize.pow(5));
    let rms = |mode| study(&scenario, mode).room_field.position_mm.rms();
    let (part, whole) = (rms(&preview.mode), rms(&Mode::Motion));
    assert!((part - whole).abs() < 0.01 * whole, "{part} {whole}");
}

#[test]
fn preview_poses_are_grid_poses_and_rarely_repeat() {
    let scenario = scenario(7.0);
    let grid = scenario.motion_grid().unwrap().unwrap();
    let key = |pose: &trackwright_geometry::pose::Pose| {
        trackwright_geometry::pose::pose_to_array(pose).map(|v| (v * 1e6).round() as i64)
    };
    let all: HashSet<_> = (0..grid.trials()).map(|i| key(&grid.pose(i))).collect();
    let some = spread(&grid, 512, SHIFT);
    let found: HashSet<_> = some.iter().map(|t| key(&t.crf_from_tool)).collect();
    assert!(found.is_subset(&all));
    assert!(found.len() > 500, "{}", found.len());
}
