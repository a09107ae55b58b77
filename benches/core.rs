//! Speed of the simulation core: `cargo bench --no-default-features --bench core`.
//!
//! What the figures were on one machine, and how to repeat them, is in `docs/developing/measurements.md`.

mod comparison;
mod compensation;
mod evaluation;
mod fitting;
mod kinds;
mod metal;
mod picking;
mod selection;
mod sweep;
mod uncertainty;
mod validity;

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use nalgebra::{Point3, Unit, Vector3};
use std::path::Path;
use std::sync::Arc;
use trackwright_field::fit::{FitSettings, fit};
use trackwright_field::random_models::Seeded;
use trackwright_field::samples::{MapKind, PoseError, Sample, SampleSet};
use trackwright_field::{DistortionModel, Environment};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::directions::DirectionSet;
use trackwright_geometry::volume::Volume;
use trackwright_simulation::{AxisRange, CancelToken, Mode, Motion, Scenario};

fn main() {
    divan::main();
}

fn bounds() -> Bounds {
    Bounds::from(([-230.0, -230.0, -530.0], [230.0, 230.0, -70.0]))
}

/// Anywhere in the box.
fn pose(seeded: &mut Seeded) -> (Point3<f64>, Unit<Vector3<f64>>) {
    (seeded.position(&bounds(), 0.0), Unit::new_normalize(seeded.normal_vector()))
}

fn poses(count: usize) -> Vec<(Point3<f64>, Unit<Vector3<f64>>)> {
    let mut seeded = Seeded::new(7);
    (0..count).map(|_| pose(&mut seeded)).collect()
}

/// A smooth error field at scattered poses: enough for timing, which does not depend on values.
fn samples(count: usize) -> SampleSet {
    let mut seeded = Seeded::new(1);
    let samples = (0..count)
        .map(|_| {
            let (position_mm, axis) = pose(&mut seeded);
            let p = position_mm.coords / 230.0;
            Sample::new(
                position_mm,
                axis,
                PoseError {
                    position_mm: Vector3::new(p.x * p.y, p.z.sin(), axis.x + p.y),
                    rotation_rad: Vector3::new(p.z, axis.y * p.x, p.x * p.x) * 0.01,
                },
            )
        })
        .collect();
    SampleSet { samples, has_rotations: true, ambiguous: 0 }
}

fn model(order: usize) -> DistortionModel {
    let settings = FitSettings::new(order, DirectionSet::Fourteen);
    fit(&samples(8000), &settings, Some(bounds())).expect("samples fit").model
}

/// The table of the built-in room.
fn built_in_samples() -> SampleSet {
    let table = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/environments/data/cube-fit.csv");
    let set =
        trackwright_project::Files::default().read_measurements(&table).expect("the built-in data");
    set.samples(MapKind::Distortion)
}

#[divan::bench(sample_count = 5)]
fn fit_built_in_order_2_42_orientations(bencher: Bencher) {
    let set = built_in_samples();
    let settings = FitSettings::new(2, DirectionSet::FortyTwo);
    bencher.bench_local(|| fit(black_box(&set), &settings, None));
}

/// The built-in design in a room of the given order with 14 orientations.
fn scenario(order: usize) -> Scenario {
    in_room(Environment {
        volume: Some(Volume::AuroraCube),
        ..Environment::of_model("bench", model(order))
    })
}

fn in_room(room: Environment) -> Scenario {
    let world = trackwright_project::open_builtin(trackwright_project::DEFAULT_BUILTIN)
        .expect("the built-in design");
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
            ..Motion::default()
        }),
        ..scenario(order)
    };
    bencher.counter(ItemsCount::new(1_000_000_usize)).bench_local(|| {
        trackwright_simulation::run(&scenario, &Mode::Motion, &CancelToken::default(), None)
    });
}
