//! What can be built, and what is reported where nothing can.

use super::cases::{CHANNEL_MM, coil, crf_problem, lumen, needle_problem, room};
use crate::{Constraint, Goal, Moves, OptimizeError, Optimized, Problem, Settings, optimize};
use nalgebra::{Point3, Vector3};
use trackwright_geometry::bounds::Bounds;
use trackwright_simulation::{
    CancelToken, Metric, Mounting, MountingAxis, MountingRegion, Requirement, Sensor, coil_gap_mm,
};
use trackwright_task::Task;

fn search(problem: &Problem) -> Result<Optimized, OptimizeError> {
    let settings = Settings { most_fits: 3_000_000, ..Settings::default() };
    optimize(problem, &settings, &CancelToken::default(), &Task::default(), &mut |_| ())
}

fn along_mm(found: &Optimized) -> Vec<f64> {
    let mut places: Vec<f64> =
        found.best.tool.sensors.iter().map(|sensor| sensor.position_in_body.z).collect();
    places.sort_by(f64::total_cmp);
    places
}

#[test]
fn a_channel_for_one_coil_does_not_take_two() {
    let mut problem = needle_problem(vec![room(1)], &[40.0, 100.0], 1);
    let points_mm = [60.0, 75.0].map(|z| Point3::new(0.0, 0.0, z)).to_vec();
    let short = MountingRegion::Channel { points_mm, radius_mm: None, axis: MountingAxis::Along };
    problem.tool.mounting.regions = vec![short];
    let error = search(&problem).unwrap_err();
    assert_eq!(error, OptimizeError::TooMany { body: "tool", sensors: 2 });
}

#[test]
fn a_channel_shorter_than_its_coil_has_no_place() {
    let mut problem = needle_problem(vec![room(1)], &[40.0, 100.0], 1);
    let points_mm = [60.0, 66.0].map(|z| Point3::new(0.0, 0.0, z)).to_vec();
    let short = MountingRegion::Channel { points_mm, radius_mm: None, axis: MountingAxis::Along };
    problem.tool.mounting.regions = vec![short];
    let error = search(&problem).unwrap_err();
    assert!(matches!(error, OptimizeError::NoPlace { tried: 0, .. }), "{error}");
}

#[test]
fn a_forbidden_box_moves_the_best_place() {
    let problem = needle_problem(vec![room(3)], &[40.0, 100.0], 3);
    let free = search(&problem).unwrap();
    let mut forbidden = problem.clone();
    let best = along_mm(&free);
    let low = Point3::new(-2.0, -2.0, best[0] - 3.0);
    let high = Point3::new(2.0, 2.0, best[0] + 3.0);
    forbidden.tool.mounting.keep_out = vec![Bounds { min_mm: low, max_mm: high }];
    let kept_off = search(&forbidden).unwrap();
    // Half a coil's length beside the box at the least.
    for z in along_mm(&kept_off) {
        assert!((z - best[0]).abs() >= 3.0 + 4.5 - 1e-6, "{z} mm, kept off {} mm", best[0]);
    }
    assert!(kept_off.best.objective >= free.best.objective * (1.0 - 1e-3));
}

#[test]
fn two_coils_that_want_one_place_keep_their_gap() {
    for least_gap_mm in [None, Some(0.5)] {
        let mut problem = needle_problem(vec![room(2)], &[40.0, 100.0], 2);
        problem.tool.mounting.least_gap_mm = least_gap_mm;
        // A channel in which both would be at the end next to the tip.
        let points_mm = [5.0, 45.0].map(|z| Point3::new(0.0, 0.0, z)).to_vec();
        let region =
            MountingRegion::Channel { points_mm, radius_mm: None, axis: MountingAxis::Along };
        problem.tool.mounting.regions = vec![region];
        let found = search(&problem).unwrap();
        let [one, other] = &found.best.tool.sensors[..] else { panic!("two sensors") };
        let gap_mm = coil_gap_mm(one, other).unwrap();
        assert!(gap_mm >= least_gap_mm.unwrap_or(9.0) - 1e-6, "{gap_mm} mm");
    }
}

#[test]
fn coils_keep_their_clearance_to_the_tip() {
    let mut problem = needle_problem(vec![room(4)], &[60.0, 110.0], 4);
    let free = search(&problem).unwrap();
    let nearest = along_mm(&free)[0] - 4.5;
    problem.tool.mounting.tip_clearance_mm = nearest + 8.0;
    let kept_off = search(&problem).unwrap();
    assert!(along_mm(&kept_off)[0] - 4.5 >= nearest + 8.0 - 1e-6);
}

#[test]
fn a_coil_stays_within_the_body_that_it_is_on() {
    let found = search(&crf_problem(vec![room(5)], 5)).unwrap();
    for sensor in &found.best.crf.as_ref().unwrap().sensors {
        let at = sensor.position_in_body;
        assert!(at.z.abs() < 1e-9 && at.x.abs() <= 25.0 && at.y.abs() <= 25.0, "{at}");
    }
}

#[test]
fn a_requirement_that_nothing_meets_is_still_neared() {
    let mut problem = needle_problem(vec![room(6)], &[60.0, 110.0], 6);
    problem.goal = Goal::Requirement(Requirement::at_most([(Metric::TIP_RMS, 1e-3)]));
    let found = search(&problem).unwrap();
    assert!(found.best.objective > 1.0 && found.best.objective <= found.start.objective);
}

#[test]
fn nothing_required_or_moved_is_refused() {
    let mut problem = needle_problem(vec![room(6)], &[60.0, 110.0], 6);
    problem.goal = Goal::Requirement(Requirement::default());
    assert_eq!(search(&problem).unwrap_err(), OptimizeError::NothingRequired);
    problem.goal = Goal::Figure(Metric::TIP_RMS);
    problem.moves = Moves::default();
    assert_eq!(search(&problem).unwrap_err(), OptimizeError::NothingMoves);
    problem.moves = Moves { crf: vec![0], ..Moves::default() };
    assert_eq!(search(&problem).unwrap_err(), OptimizeError::NoCrf);
    problem.moves = Moves { tool: vec![7], ..Moves::default() };
    let none = OptimizeError::NoSensor { body: "tool", sensor: 7, sensors: 2 };
    assert_eq!(search(&problem).unwrap_err(), none);
    problem.moves = Moves { tool: vec![0, 1], sensors: Some(0..=2), ..Moves::default() };
    let count = OptimizeError::Count { body: "tool", least: 0, most: 2, fixed: 0 };
    assert_eq!(search(&problem).unwrap_err(), count);
}

#[test]
fn a_determined_rotation_stays_determined() {
    // The tip is off the line of the coils: in line they would leave it free.
    let mut problem = needle_problem(vec![room(7)], &[60.0, 110.0], 7);
    let beside = coil("beside", [0.0, 12.0, 130.0], Vector3::x());
    for scenario in &mut problem.scenarios {
        scenario.tool.tip_in_body = Some(Point3::new(0.0, 20.0, 0.0));
        scenario.tool.sensors.push(beside.clone());
    }
    let points_mm = CHANNEL_MM.map(|z| Point3::new(0.0, 12.0, z)).to_vec();
    let region = MountingRegion::Channel { points_mm, radius_mm: None, axis: MountingAxis::AsItIs };
    problem.tool.mounting = Mounting { regions: vec![region], ..lumen() };
    problem.moves.tool = vec![2];
    let found = search(&problem).unwrap();
    assert!(found.undetermined.is_empty(), "{:?}", found.undetermined);
    let moved: &Sensor = &found.best.tool.sensors[2];
    assert_eq!(moved.axis_in_body(), beside.axis_in_body());
    assert!(!found.binding.iter().any(|b| b.constraint == Constraint::PoseBound));
}
