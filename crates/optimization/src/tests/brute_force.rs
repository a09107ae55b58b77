//! Against brute force: every layout through a study of its own.

use super::cases::{CHANNEL_MM, COIL, crf_problem, needle_problem, room};
use crate::constraint::pair_fault;
use crate::{Problem, Settings, optimize};
use nalgebra::Point3;
use rayon::prelude::*;
use trackwright_field::random_models::Seeded;
use trackwright_simulation::{CancelToken, Metric, Scenario, Sensor, run};
use trackwright_task::Task;

/// Cases of each kind; their seeds are their numbers.
const CASES: u64 = 6;

/// Places along the needle.
const PLACES: usize = 60;

/// Places on the CRF's top, each way.
const CRF_PLACES: usize = 4;

/// Random starts of each case.
const STARTS: usize = 4;

/// How near to the least figure the answer has to be.
const NEAR: f64 = 0.01;

/// The larger of the rooms' figures as their own studies have them.
fn figure(problem: &Problem, change: impl Fn(&mut Scenario)) -> f64 {
    let each = problem.scenarios.iter().map(|scenario| {
        let mut scenario = scenario.clone();
        change(&mut scenario);
        let outcome = run(&scenario, &problem.mode, &CancelToken::default(), None).unwrap();
        outcome.room_field.value(Metric::TIP_RMS)
    });
    each.fold(0.0, f64::max)
}

fn found(problem: &Problem) -> f64 {
    let settings = Settings { most_fits: 8_000_000, ..Settings::default() };
    let enough = CancelToken::default();
    let task = Task::default();
    optimize(problem, &settings, &enough, &task, &mut |_| ()).unwrap().best.objective
}

/// What the search finds, which is as good as the least figure.
fn as_good_as_least((case, least): (u64, f64), problem: &Problem) -> f64 {
    let own = found(problem);
    assert!(own <= least * (1.0 + NEAR), "case {case}: {own} mm, least {least} mm");
    own
}

/// From random starts the answer is as good as the least figure as well, and that from the problem's
/// own. `random` gives the places of a start, `sensors` those of a scenario that have them.
fn assert_same_from_random_starts(
    (case, least): (u64, f64),
    problem: &Problem,
    own: f64,
    mut random: impl FnMut() -> Vec<Point3<f64>>,
    sensors: impl Fn(&mut Scenario) -> &mut [Sensor],
) {
    for start in 0..STARTS {
        let places = random();
        let mut other = problem.clone();
        for scenario in &mut other.scenarios {
            for (sensor, place) in sensors(scenario).iter_mut().zip(&places) {
                sensor.position_in_body = *place;
            }
        }
        let again = found(&other);
        assert!(
            again <= least * (1.0 + NEAR) && (again - own).abs() <= NEAR * least,
            "case {case}, start {start}: {again} mm, from its own {own} mm, least {least} mm"
        );
    }
}

#[test]
fn two_coils_of_a_needle_are_as_good_as_any_pair() {
    for seed in 0..CASES {
        // Every second case has two rooms.
        let rooms = (0..1 + seed % 2).map(|k| room(100 + 10 * seed + k)).collect();
        let problem = needle_problem(rooms, &[40.0, 100.0], seed);
        let half_mm = COIL.length_mm / 2.0;
        let [from, to] = [CHANNEL_MM[0] + half_mm, CHANNEL_MM[1] - half_mm];
        let place = |k: usize| from + (to - from) * k as f64 / (PLACES - 1) as f64;
        let pairs: Vec<[usize; 2]> =
            (0..PLACES).flat_map(|a| (a + 1..PLACES).map(move |b| [a, b])).collect();
        let least = pairs
            .into_par_iter()
            .filter(|[a, b]| place(*b) - place(*a) >= 2.0 * COIL.length_mm)
            .map(|pair| {
                figure(&problem, |scenario| {
                    for (sensor, k) in scenario.tool.sensors.iter_mut().zip(pair) {
                        sensor.position_in_body.z = place(k);
                    }
                })
            })
            .reduce(|| f64::INFINITY, f64::min);
        let mut seeded = Seeded::new(1000 + seed);
        let random = || {
            let start = |low: f64| Point3::new(0.0, 0.0, low + 45.0 * seeded.uniform());
            [10.0, 85.0].map(start).to_vec()
        };
        let case = (seed, least);
        let own = as_good_as_least(case, &problem);
        assert_same_from_random_starts(case, &problem, own, random, |s| &mut s.tool.sensors);
    }
}

/// A CRF of three coils in one or two rooms, and the least figure of any triple of a coarse grid.
fn crf_case(seed: u64) -> (Problem, f64) {
    // Every second case has two rooms.
    let rooms = (0..1 + seed % 2).map(|k| room(200 + 10 * seed + k)).collect();
    let problem = crf_problem(rooms, seed);
    let step_mm = 50.0 / (CRF_PLACES - 1) as f64;
    let places: Vec<[f64; 2]> = (0..CRF_PLACES * CRF_PLACES)
        .map(|k| [k % CRF_PLACES, k / CRF_PLACES].map(|k| -25.0 + step_mm * k as f64))
        .collect();
    let n = places.len();
    let triples: Vec<[usize; 3]> = (0..n)
        .flat_map(|a| (0..n).flat_map(move |b| (0..n).map(move |c| [a, b, c])))
        .filter(|[a, b, c]| a != b && b != c && a != c)
        .collect();
    let least = triples
        .into_par_iter()
        .filter_map(|triple| {
            let sensors: Vec<Sensor> = crf_sensors(&problem)
                .iter()
                .zip(triple)
                .map(|(sensor, k)| {
                    let [x, y] = places[k];
                    Sensor { position_in_body: [x, y, 0.0].into(), ..sensor.clone() }
                })
                .collect();
            if is_crowded(&sensors) {
                return None;
            }
            Some(figure(&problem, |scenario| {
                if let Some(crf) = &mut scenario.crf {
                    crf.body.sensors.clone_from(&sensors);
                }
            }))
        })
        .reduce(|| f64::INFINITY, f64::min);
    (problem, least)
}

fn crf_sensors(problem: &Problem) -> &[Sensor] {
    &problem.scenarios[0].crf.as_ref().unwrap().body.sensors
}

/// Whether two of a CRF's coils are nearer to each other than its least gap.
fn is_crowded(sensors: &[Sensor]) -> bool {
    let pairs = [[0, 1], [0, 2], [1, 2]];
    pairs.iter().any(|[a, b]| pair_fault(&sensors[*a], &sensors[*b], Some(3.0)).is_some())
}

#[test]
fn three_coils_of_a_crf_are_as_good_as_any_triple() {
    for seed in 0..CASES {
        let (problem, least) = crf_case(seed);
        as_good_as_least((seed, least), &problem);
    }
}

#[test]
#[ignore = "long: thirty searches"]
fn long_search_of_a_crf_is_the_same_from_any_start() {
    for seed in 0..CASES {
        let (problem, least) = crf_case(seed);
        let own = as_good_as_least((seed, least), &problem);
        // Anywhere on the top, beside each other.
        let mut seeded = Seeded::new(2000 + seed);
        let random = || loop {
            let place = |sensor: &Sensor| {
                let [x, y] = [0, 1].map(|_| 50.0 * seeded.uniform() - 25.0);
                Sensor { position_in_body: [x, y, 0.0].into(), ..sensor.clone() }
            };
            let sensors: Vec<Sensor> = crf_sensors(&problem).iter().map(place).collect();
            if !is_crowded(&sensors) {
                return sensors.iter().map(|sensor| sensor.position_in_body).collect();
            }
        };
        assert_same_from_random_starts((seed, least), &problem, own, random, |scenario| {
            &mut scenario.crf.as_mut().unwrap().body.sensors
        });
    }
}
