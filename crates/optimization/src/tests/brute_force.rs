//! Against brute force: every layout through a study of its own.

use super::cases::{CHANNEL_MM, COIL, crf_problem, needle_problem, room};
use crate::constraint::pair_fault;
use crate::{Problem, Settings, optimize};
use rayon::prelude::*;
use trackwright_field::random_models::Seeded;
use trackwright_simulation::{CancelToken, Metric, Sensor, run};
use trackwright_task::Task;

/// Cases of each kind; their seeds are their numbers.
const CASES: u64 = 6;

/// Places along the needle.
const PLACES: usize = 60;

/// Places on the CRF's top, each way.
const CRF_PLACES: usize = 4;

/// How near to the least figure the answer has to be.
const NEAR: f64 = 0.01;

/// The larger of the rooms' figures as their own studies have them.
fn figure(problem: &Problem, change: impl Fn(&mut trackwright_simulation::Scenario)) -> f64 {
    let each = problem.scenarios.iter().map(|scenario| {
        let mut scenario = scenario.clone();
        change(&mut scenario);
        let outcome = run(&scenario, &problem.mode, &CancelToken::default(), None).unwrap();
        outcome.figures.value(Metric::TIP_RMS)
    });
    each.fold(0.0, f64::max)
}

fn found(problem: &Problem) -> f64 {
    let settings = Settings { most_fits: 8_000_000, ..Settings::default() };
    let enough = CancelToken::default();
    let task = Task::default();
    optimize(problem, &settings, &enough, &task, &mut |_| ()).unwrap().best.objective
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
        let found = found(&problem);
        assert!(found <= least * (1.0 + NEAR), "case {seed}: {found} mm, least {least} mm");
        // From four other starts the same.
        let mut seeded = Seeded::new(1000 + seed);
        for _ in 0..4 {
            let start = |low: f64| low + 45.0 * seeded.uniform();
            let starts = [10.0, 85.0].map(start);
            let mut other = problem.clone();
            for scenario in &mut other.scenarios {
                for (sensor, z) in scenario.tool.sensors.iter_mut().zip(starts) {
                    sensor.position_in_body.z = z;
                }
            }
            let again = self::found(&other);
            assert!(
                (again - found).abs() <= NEAR * least,
                "case {seed}: {again} mm and {found} mm"
            );
        }
    }
}

#[test]
fn three_coils_of_a_crf_are_as_good_as_any_triple() {
    for seed in 0..CASES {
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
                let crf = &problem.scenarios[0].crf.as_ref()?.body;
                let sensors: Vec<Sensor> = crf
                    .sensors
                    .iter()
                    .zip(triple)
                    .map(|(sensor, k)| {
                        let [x, y] = places[k];
                        Sensor { position_in_body: [x, y, 0.0].into(), ..sensor.clone() }
                    })
                    .collect();
                let is_near =
                    |a: usize, b: usize| pair_fault(&sensors[a], &sensors[b], Some(3.0)).is_some();
                if is_near(0, 1) || is_near(0, 2) || is_near(1, 2) {
                    return None;
                }
                Some(figure(&problem, |scenario| {
                    if let Some(crf) = &mut scenario.crf {
                        crf.body.sensors.clone_from(&sensors);
                    }
                }))
            })
            .reduce(|| f64::INFINITY, f64::min);
        let found = found(&problem);
        assert!(found <= least * (1.0 + NEAR), "case {seed}: {found} mm, least {least} mm");
    }
}
