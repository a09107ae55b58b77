//! What the tracker's jitter does to the tip: to first order, by Monte Carlo, and by a plain loop.

use super::scenario;
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use nalgebra::UnitQuaternion;
use std::sync::Arc;
use trackwright_field::Environment;
use trackwright_field::environment::Jitter;
use trackwright_field::random_models::Seeded;
use trackwright_geometry::pose::Pose;
use trackwright_simulation::frame_fit::{FrameFitter, Reading};
use trackwright_simulation::uncertainty::{
    first_order as to_first_order, monte_carlo as by_sampling,
};
use trackwright_simulation::{RigidBody, Scenario};
use trackwright_task::Task;

const SAMPLES: usize = 10_000;
const JITTER_MM: f64 = 0.1;
const JITTER_RAD: f64 = 0.002;

/// The built-in design in a room of order 4 whose tracker jitters.
fn jittering() -> Scenario {
    let quiet = scenario(4);
    let room = Environment {
        jitter: Some(Jitter::uniform(JITTER_MM, JITTER_RAD)),
        ..Environment::clone(&quiet.environment)
    };
    Scenario { environment: Arc::new(room), ..quiet }
}

#[divan::bench]
fn first_order(bencher: Bencher) {
    let scenario = jittering();
    bencher.bench_local(|| to_first_order(black_box(&scenario)));
}

/// 10,000 readings of tool and CRF, on as many threads as the name states (0 for all).
#[divan::bench(consts = [1, 0], sample_count = 10)]
fn monte_carlo<const THREADS: usize>(bencher: Bencher) {
    let scenario = jittering();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(THREADS).build().expect("threads");
    bencher.counter(ItemsCount::new(SAMPLES)).bench_local(|| {
        pool.install(|| by_sampling(black_box(&scenario), SAMPLES, 1, &Task::default()))
    });
}

/// The same readings and fits one after the other, without any of the statistics.
#[divan::bench(sample_count = 10)]
fn plain_loop(bencher: Bencher) {
    let scenario = jittering();
    let crf = scenario.crf.as_ref().expect("the built-in design's CRF");
    let tracker_from_tool = crf.tracker_from_crf * scenario.crf_from_tool;
    let weight_mm = scenario.orientation_weight_mm;
    let bodies = [
        Still::new(&scenario.tool, tracker_from_tool, weight_mm),
        Still::new(&crf.body, crf.tracker_from_crf, weight_mm),
    ];
    let tip = scenario.tool.judged_tip_in_body();
    bencher.counter(ItemsCount::new(SAMPLES)).bench_local(|| {
        let mut random = Seeded::new(1);
        for _ in 0..SAMPLES {
            let [tool, crf] = [0, 1].map(|k| bodies[k].read(&mut random));
            black_box(crf.inverse() * tool * tip);
        }
    });
}

/// A body that stands still and is read again and again.
struct Still {
    fitter: FrameFitter,
    readings: Vec<Reading>,
    tracker_from_body: Pose,
}

impl Still {
    fn new(body: &RigidBody, tracker_from_body: Pose, weight_mm: f64) -> Self {
        let readings = body.sensors.iter().map(|sensor| Reading {
            position_mm: tracker_from_body * sensor.position_in_body,
            rotation: tracker_from_body.rotation * sensor.orientation.any_rotation(),
        });
        Self {
            fitter: FrameFitter::new(body, weight_mm),
            readings: readings.collect(),
            tracker_from_body,
        }
    }

    fn read(&self, random: &mut Seeded) -> Pose {
        let readings: Vec<Reading> = self
            .readings
            .iter()
            .map(|reading| {
                let moved = random.normal_vector() * JITTER_MM;
                let turned = random.normal_vector() * JITTER_RAD;
                Reading {
                    position_mm: reading.position_mm + moved,
                    rotation: UnitQuaternion::from_scaled_axis(turned) * reading.rotation,
                }
            })
            .collect();
        self.fitter.fit(&readings, &self.tracker_from_body).tracker_from_body
    }
}
