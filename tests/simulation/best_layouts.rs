//! The search for the best places against every triple of places on the head CRF, each through a study
//! of its own.

use nalgebra::Point3;
use rayon::prelude::*;
use std::sync::Arc;
use trackwright_design::BodyRole;
use trackwright_field::Environment;
use trackwright_field::random_models::random_model;
use trackwright_geometry::directions::{DirectionSet, Weighting};
use trackwright_optimization::{Goal, Moves, OverRooms, Settings, optimize};
use trackwright_project::{open_builtin, placement_problem};
use trackwright_simulation::{
    AxisRule, CancelToken, Metric, MountingRegion, Scenario, Sensor, coil_fits, coil_gap_mm, run,
};
use trackwright_task::Task;

/// Distance of the places on the CRF.
const STEP_MM: f64 = 8.0;

/// How near to the least figure the answer has to be.
const NEAR: f64 = 0.01;

#[test]
fn the_head_crf_is_as_good_as_any_triple() {
    let world = open_builtin("pointer-on-head").unwrap();
    let model = random_model(2, DirectionSet::Fourteen, Weighting::Area, [1.5, 0.01], 77);
    let other = Arc::new(Environment::of_model("other", model));
    // What the measurements leave open is no part of a figure that is computed anew.
    let own = Environment { process: None, ..Environment::clone(&world.environment) };
    let rooms = [Arc::new(own), other];
    for room in rooms {
        let moves = Moves { crf: vec![0, 1, 2], ..Moves::default() };
        let goal = Goal::Figure(Metric::TIP_RMS);
        let problem = placement_problem(&world, &[room], moves, goal, OverRooms::Worst);
        let crf = problem.crf.as_ref().unwrap();
        let surface = crf.surface.as_deref().unwrap();
        let [MountingRegion::Surface { boxes, .. }] = &crf.mounting.regions[..] else {
            panic!("{:?}", crf.mounting.regions)
        };
        assert!(world.mesh(BodyRole::Crf).is_some());
        let scenario = &problem.scenarios[0];
        let sensors = &scenario.crf.as_ref().unwrap().body.sensors;
        // Each sensor at each place, as the region turns it there.
        let steps = || (-2..=2).map(|k| STEP_MM * f64::from(k));
        let places: Vec<[Sensor; 3]> = steps()
            .flat_map(|x| steps().map(move |y| surface.closest(&Point3::new(x, y, -30.0))))
            .filter(|at| boxes.iter().any(|own| own.contains(&at.position_mm)))
            .map(|at| [0, 1, 2].map(|k| AxisRule::Tangent.placed(&sensors[k], &at)))
            .collect();
        let is_free = |sensor: &Sensor| {
            let kept = crf.mounting.keep_out.iter();
            let points = trackwright_simulation::coil_points(sensor);
            coil_fits(sensor, std::iter::empty(), Some(surface))
                && !kept.into_iter().any(|own| points.iter().any(|point| own.contains(point)))
        };
        let allowed: Vec<[bool; 3]> =
            places.par_iter().map(|at| [0, 1, 2].map(|k| is_free(&at[k]))).collect();
        let n = places.len();
        let all = (0..n * n * n).map(|index| [index % n, index / n % n, index / n / n]);
        let triples: Vec<[usize; 3]> = all
            .filter(|triple| (0..3).all(|k| allowed[triple[k]][k]))
            .filter(|[a, b, c]| {
                let [a, b, c] = [&places[*a][0], &places[*b][1], &places[*c][2]];
                [(a, b), (a, c), (b, c)]
                    .iter()
                    .all(|(one, other)| coil_gap_mm(one, other).is_some_and(|gap_mm| gap_mm >= 9.0))
            })
            .collect();
        assert!(triples.len() > 20, "{} triples of {n} places", triples.len());
        let figure = |triple: &[usize; 3]| {
            let mut own: Scenario = scenario.clone();
            let crf = own.crf.as_mut().unwrap();
            for (k, place) in triple.iter().enumerate() {
                crf.body.sensors[k] = places[*place][k].clone();
            }
            let outcome = run(&own, &problem.mode, &CancelToken::default(), None).unwrap();
            outcome.room_field.value(Metric::TIP_RMS)
        };
        let least = triples.par_iter().map(figure).reduce(|| f64::INFINITY, f64::min);
        let settings = Settings { most_fits: 6_000_000, ..Settings::default() };
        let (enough, task) = (CancelToken::default(), Task::default());
        let found = optimize(&problem, &settings, &enough, &task, &mut |_| ()).unwrap();
        let best = found.best.objective;
        assert!(best <= least * (1.0 + NEAR), "{best} mm, least {least} mm of {}", triples.len());
    }
}
