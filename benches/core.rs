//! Speed of the simulation core: `cargo bench --no-default-features --bench core`.
//!
//! What the figures were on one machine, and how to repeat them, is in `docs/developing/measurements.md`.

mod comparison;
mod compensation;
mod evaluation;
mod fitting;
mod kinds;
mod picking;
mod selection;
mod support;
mod uncertainty;

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use nalgebra::{Point3, Unit, Vector3};
use std::path::Path;
use std::sync::Arc;
use trackwright_field::fit::{FitSettings, fit};
use trackwright_field::samples::{MapKind, PoseError, Sample, SampleSet};
use trackwright_field::{DistortionModel, Environment, OutsidePolicy};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::directions::DirectionSet;
use trackwright_geometry::volume::Volume;
use trackwright_simulation::{AxisRange, CancelToken, Mode, Motion, Scenario};

fn main() {
    divan::main();
}

/// Uniform numbers below 1, the same each time (a linear congruential sequence).
struct Uniform(u64);

impl Uniform {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn position(&mut self) -> Point3<f64> {
        Point3::new(
            460.0 * self.next() - 230.0,
            460.0 * self.next() - 230.0,
            -70.0 - 460.0 * self.next(),
        )
    }

    fn axis(&mut self) -> Unit<Vector3<f64>> {
        Unit::new_normalize(Vector3::from_fn(|_, _| self.next() + self.next() + self.next() - 1.5))
    }
}

fn bounds() -> Bounds {
    Bounds::from(([-230.0, -230.0, -530.0], [230.0, 230.0, -70.0]))
}

/// A smooth error field at scattered poses: enough for timing, which does not depend on values.
fn samples(count: usize) -> SampleSet {
    let mut uniform = Uniform(1);
    let samples = (0..count)
        .map(|_| {
            let (position_mm, axis) = (uniform.position(), uniform.axis());
            let p = position_mm.coords / 230.0;
            Sample {
                position_mm,
                axis,
                error: PoseError {
                    position_mm: Vector3::new(p.x * p.y, p.z.sin(), axis.x + p.y),
                    rotation_rad: Vector3::new(p.z, axis.y * p.x, p.x * p.x) * 0.01,
                },
            }
        })
        .collect();
    SampleSet { samples, has_rotations: true, ambiguous: 0 }
}

fn model(order: usize) -> DistortionModel {
    let settings = FitSettings::new(order, DirectionSet::Fourteen);
    fit(&samples(8000), &settings, Some(bounds())).expect("samples fit").model
}

/// One evaluation of equation (8), triangle search and weights included, on one core.
#[divan::bench(args = [2, 4, 6])]
fn field_evaluation_14_orientations(bencher: Bencher, order: usize) {
    const POSES: usize = 1000;
    let model = model(order);
    let mut uniform = Uniform(7);
    let poses: Vec<_> = (0..POSES).map(|_| (uniform.position(), uniform.axis())).collect();
    bencher.counter(ItemsCount::new(POSES)).bench_local(|| {
        for (position, axis) in &poses {
            black_box(model.evaluate(black_box(position), axis, OutsidePolicy::Clamp));
        }
    });
}

#[divan::bench(args = [1_025, 100_000], sample_count = 5)]
fn fit_order_4_14_orientations(bencher: Bencher, count: usize) {
    let set = samples(count);
    let settings = FitSettings::new(4, DirectionSet::Fourteen);
    bencher.counter(ItemsCount::new(count)).bench_local(|| fit(black_box(&set), &settings, None));
}

#[divan::bench(sample_count = 5)]
fn fit_built_in_order_2_42_orientations(bencher: Bencher) {
    let table = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/environments/data/cube-fit.csv");
    let set = trackwright_project::Files::default()
        .read_measurements(&table)
        .expect("the built-in data")
        .samples(MapKind::Distortion);
    let settings = FitSettings::new(2, DirectionSet::FortyTwo);
    bencher.bench_local(|| fit(black_box(&set), &settings, None));
}

/// The built-in design in a room of the given order with 14 orientations.
fn scenario(order: usize) -> Scenario {
    let world = trackwright_project::open_builtin(trackwright_project::DEFAULT_BUILTIN)
        .expect("the built-in design");
    let room = Environment {
        name: "bench".into(),
        model: model(order),
        volume: Some(Volume::AuroraCube),
        jitter: None,
        provenance: None,
        fit_validity: None,
        process: None,
    };
    trackwright_project::resolve(world.document.design(), &Arc::new(room))
}

/// All cores.
#[divan::bench(args = [2, 4, 6])]
fn study_of_3375_poses(bencher: Bencher, order: usize) {
    let scenario = scenario(order);
    bencher.counter(ItemsCount::new(3375_usize)).bench_local(|| {
        trackwright_simulation::run(&scenario, &Mode::Motion, &CancelToken::default(), None)
    });
}

#[divan::bench(args = [4], sample_count = 3)]
fn study_of_1000000_poses(bencher: Bencher, order: usize) {
    let ten = |reach: f64| Some(AxisRange { min: -reach, max: reach - 0.1, step: reach / 5.0 });
    let scenario = Scenario {
        motion: Some(Motion {
            x: ten(50.0),
            y: ten(50.0),
            z: ten(50.0),
            rx: ten(30.0),
            ry: ten(30.0),
            rz: ten(30.0),
        }),
        ..scenario(order)
    };
    bencher.counter(ItemsCount::new(1_000_000_usize)).bench_local(|| {
        trackwright_simulation::run(&scenario, &Mode::Motion, &CancelToken::default(), None)
    });
}
