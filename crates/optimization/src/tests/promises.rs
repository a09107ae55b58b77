//! What every search keeps: order, seeds, threads, the start.

use super::cases::{crf_problem, needle_problem, room};
use crate::bodies::{Bodies, Movable, Slot};
use crate::verdict::crowded;
use crate::{BuiltError, Goal, Moves, Optimized, Problem, Settings, optimize};
use trackwright_simulation::{CancelToken, Metric, PlacedBody, Requirement, run};
use trackwright_task::Task;

fn search(problem: &Problem) -> Optimized {
    let settings = Settings { most_fits: 2_000_000, ..Settings::default() };
    optimize(problem, &settings, &CancelToken::default(), &Task::default(), &mut |_| ()).unwrap()
}

#[test]
fn the_result_does_not_depend_on_the_threads() {
    let problem = crf_problem(vec![room(11)], 11);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let found = pool.install(|| search(&problem));
        format!("{:?}{:?}{:?}", found.best, found.candidates, found.flatness)
    };
    assert_eq!(on(1), on(2));
}

#[test]
fn figures_are_those_of_a_study_to_the_bit() {
    let problem = needle_problem(vec![room(12)], &[40.0, 100.0], 12);
    let found = search(&problem);
    let mut scenario = problem.scenarios[0].clone();
    scenario.tool = found.best.tool.clone();
    let outcome = run(&scenario, &problem.mode, &CancelToken::default(), None).unwrap();
    assert_eq!(outcome.room_field, found.best.studies[0].room_field);
    assert_eq!(outcome.room_field.value(Metric::TIP_RMS), found.best.objective);
}

#[test]
fn what_is_best_already_stays() {
    let problem = needle_problem(vec![room(13)], &[40.0, 100.0], 13);
    let found = search(&problem);
    assert!(found.best.objective < found.start.objective);
    let mut best = problem.clone();
    best.scenarios[0].tool = found.best.tool.clone();
    let again = search(&best);
    assert!(again.best.objective <= found.best.objective);
    let less = (found.best.objective - again.best.objective) / found.best.objective;
    assert!(less < 1e-3, "{less}");
    // An exact room shows any gain; one of less than a thousandth is no reason for a change.
    assert!(!again.is_better);
}

#[test]
fn roughly_built_is_the_objective_so_stated() {
    let mut problem = needle_problem(vec![room(13)], &[40.0, 60.0], 13);
    problem.built = Some(BuiltError::default());
    let found = search(&problem);
    let rough = found.roughly_built.unwrap();
    assert!(found.is_better && rough.best > found.best.objective);
    problem.built = Some(BuiltError::rough(problem.built));
    assert_eq!(search(&problem).start.objective, rough.start);
    problem.scenarios[0].tool = found.best.tool;
    let stated = search(&problem);
    assert_eq!((stated.start.objective, stated.roughly_built), (rough.best, None));
}

#[test]
fn sensors_at_one_end_are_close_together() {
    let close = |places_mm: &[f64]| {
        let problem = needle_problem(vec![room(13)], places_mm, 13);
        let bodies = Bodies::of(&problem.scenarios[0]);
        let slots = [0, 1].map(|index| Slot { body: PlacedBody::Tool, index }).to_vec();
        crowded(&Movable::new(&problem, bodies.clone(), slots).unwrap(), &bodies)
    };
    assert_eq!(close(&[20.0, 120.0]), []);
    let [found] = &close(&[100.0, 120.0])[..] else { panic!() };
    assert_eq!((found.body, found.from_tip_mm), ("tool", Some([100.0, 120.0])));
    // Coils of 9 mm in a channel of 140 mm.
    assert!(
        (found.span_mm - 20.0).abs() < 1e-9 && (found.allowed_mm - 131.0).abs() < 0.1,
        "{found:?}"
    );
}

#[test]
fn each_answer_on_the_way_is_better_than_the_last() {
    let problem = crf_problem(vec![room(14)], 14);
    let mut seen = Vec::new();
    let settings = Settings { most_fits: 2_000_000, ..Settings::default() };
    let (enough, task) = (CancelToken::default(), Task::default());
    let found = optimize(&problem, &settings, &enough, &task, &mut |p| seen.push(p.best.objective))
        .unwrap();
    assert!(seen.windows(2).all(|pair| pair[1] < pair[0]), "{seen:?}");
    assert_eq!(seen.last(), Some(&found.best.objective));
}

#[test]
fn a_search_that_is_ended_keeps_its_best() {
    let problem = crf_problem(vec![room(15)], 15);
    let settings = Settings::default();
    let (enough, task) = (CancelToken::default(), Task::default());
    let ended = enough.clone();
    let found = optimize(&problem, &settings, &enough, &task, &mut |_| ended.cancel()).unwrap();
    assert!(found.is_stopped);
    assert!(found.best.objective < found.start.objective);
}

#[test]
fn every_figure_can_be_made_least() {
    let mut problem = needle_problem(vec![room(16)], &[40.0, 100.0], 16);
    for metric in [Metric::TIP_MAX, Metric::TIP_P95, Metric::ANGLE_RMS] {
        problem.goal = Goal::Figure(metric);
        let found = search(&problem);
        assert!(found.best.objective <= found.start.objective);
        assert_eq!(found.best.studies[0].room_field.value(metric), found.best.objective);
    }
}

#[test]
fn more_sensors_are_listed_where_they_are_better() {
    let mut problem = needle_problem(vec![room(17)], &[40.0, 100.0], 17);
    problem.moves = Moves { sensors: Some(1..=3), ..problem.moves };
    let found = search(&problem);
    assert!(!found.pareto.is_empty());
    let pairs = found.pareto.windows(2);
    for pair in pairs {
        assert!(pair[1].tool.sensors.len() > pair[0].tool.sensors.len());
        assert!(pair[1].objective < pair[0].objective);
    }
    // The fewest that meet a requirement are enough.
    let least = found.pareto[0].objective;
    problem.goal = Goal::Requirement(Requirement::at_most([(Metric::TIP_RMS, 1.01 * least)]));
    let found = search(&problem);
    assert_eq!(found.best.tool.sensors.len(), found.pareto[0].tool.sensors.len());
}

#[test]
fn the_optimum_is_as_flat_as_is_reported() {
    let problem = needle_problem(vec![room(18)], &[40.0, 100.0], 18);
    let found = search(&problem);
    for (number, flat) in found.flatness.iter().enumerate() {
        let Some(within_mm) = flat.within_mm else { continue };
        let at = |way_mm: f64| {
            let mut scenario = problem.scenarios[0].clone();
            scenario.tool = found.best.tool.clone();
            scenario.tool.sensors[number].position_in_body.z += way_mm;
            let outcome = run(&scenario, &problem.mode, &CancelToken::default(), None).unwrap();
            outcome.room_field.value(Metric::TIP_RMS) / found.best.objective
        };
        let worst = at(within_mm).max(at(-within_mm));
        assert!((worst - 1.05).abs() < 5e-3, "{number}: {worst} at {within_mm} mm");
    }
}

#[test]
fn a_search_that_is_ended_at_once_has_its_start() {
    let problem = needle_problem(vec![room(19)], &[40.0, 100.0], 19);
    let enough = CancelToken::default();
    enough.cancel();
    let task = Task::default();
    let found = optimize(&problem, &Settings::default(), &enough, &task, &mut |_| ()).unwrap();
    assert!(found.is_stopped && !found.is_better);
    assert!(found.best.objective <= found.start.objective);
}
