//! A plate of 1,000 triangles that a hand moves, beside the built-in pointer: from the move to what is
//! shown.

use divan::{Bencher, black_box};
use nalgebra::Vector3;
use std::sync::Arc;
use trackwright_field::generator::Generator;
use trackwright_field::samples::MapKind;
use trackwright_field::{DistortionModel, Environment};
use trackwright_geometry::pose::Pose;
use trackwright_geometry::volume::Volume;
use trackwright_metal::furnished::{Furnished, Furnisher};
use trackwright_metal::setup::{
    DEFAULT_TRIANGLES, MaterialTolerance, MetalObject, ObjectMaterial, ObjectShape, RoomMetal,
};
use trackwright_project::{open_builtin_without_meshes, resolve};
use trackwright_scene::slice_plan;
use trackwright_simulation::slice::sample_slice;
use trackwright_simulation::{CancelToken, Mode, Quantity, Scenario, study};
use trackwright_task::Task;

/// The plate beside the volume, and within it.
const PLACES_MM: [f64; 2] = [300.0, 180.0];

fn bare() -> Arc<Environment> {
    let volume = Volume::AuroraCube;
    let model = DistortionModel::zero(volume.bounds(), MapKind::Distortion);
    Arc::new(Environment { volume: Some(volume), ..Environment::of_model("bench", model) })
}

fn plate(x_mm: f64) -> RoomMetal {
    let turn = Vector3::y() * std::f64::consts::FRAC_PI_2;
    let plate = MetalObject {
        name: "plate".to_owned(),
        shape: ObjectShape::Cuboid { size_mm: Vector3::new(200.0, 200.0, 10.0) },
        material: ObjectMaterial::Named("aluminium"),
        tracker_from_object: Pose::new(Vector3::new(x_mm, 0.0, -250.0), turn),
        most_triangles: DEFAULT_TRIANGLES,
        tolerance: MaterialTolerance::default(),
    };
    RoomMetal { objects: vec![plate], ..RoomMetal::empty(Generator::planar_nine()) }
}

/// Measures what is shown of the room after each move, the solution included.
fn moved(bencher: Bencher, x_mm: f64, shown: impl Fn(&Scenario) + Sync) {
    let world = open_builtin_without_meshes("pointer-on-head").unwrap();
    let (bare, mut furnisher) = (bare(), Furnisher::default());
    let mut step = 0.0;
    bencher.bench_local(|| {
        step += 0.1;
        let room = plate(x_mm + step % 5.0);
        let Furnished { environment, .. } =
            furnisher.furnish(&bare, &room, &Task::default()).unwrap();
        shown(&resolve(world.document.design(), &environment));
    });
}

#[divan::bench(args = PLACES_MM)]
fn moved_plate(bencher: Bencher, x_mm: f64) {
    moved(bencher, x_mm, |scenario| {
        black_box(scenario);
    });
}

#[divan::bench(args = PLACES_MM)]
fn moved_plate_and_pose(bencher: Bencher, x_mm: f64) {
    moved(bencher, x_mm, |scenario| {
        black_box(study(scenario, &Mode::Single, &CancelToken::default(), None).unwrap());
    });
}

#[divan::bench(args = PLACES_MM)]
fn moved_plate_and_slice(bencher: Bencher, x_mm: f64) {
    let world = open_builtin_without_meshes("pointer-on-head").unwrap();
    let plan = slice_plan(&bare(), &world.document.view().slice);
    moved(bencher, x_mm, move |scenario| {
        let quantity = Quantity::PositionErrorMm;
        black_box(sample_slice(scenario, quantity, &plan, &CancelToken::default()).unwrap());
    });
}

#[divan::bench(args = PLACES_MM)]
fn moved_plate_and_study(bencher: Bencher, x_mm: f64) {
    moved(bencher, x_mm, |scenario| {
        black_box(study(scenario, &Mode::Motion, &CancelToken::default(), None).unwrap());
    });
}
