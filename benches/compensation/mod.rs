//! Compensation by the inverse of a distortion map with 14 orientations.

use super::{model, poses};
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use nalgebra::{UnitQuaternion, Vector3};
use trackwright_field::inverse::{Inverse, undistort};
use trackwright_field::{DistortionModel, OutsidePolicy};
use trackwright_geometry::pose::Pose;
use trackwright_task::Task;

/// Poses as they are read in a room.
fn readings(model: &DistortionModel, count: usize) -> Vec<Pose> {
    poses(count)
        .into_iter()
        .map(|(position, axis)| {
            let turn = UnitQuaternion::rotation_between(&Vector3::z(), &axis).unwrap_or_default();
            let pose = Pose::from_parts(position.into(), turn);
            model.distort(&pose, OutsidePolicy::Clamp).0
        })
        .collect()
}

/// The inverse of the distortion map, made ready each time, on as many threads as the name states
/// (0 for all).
#[divan::bench(args = [2, 4, 6], consts = [1, 0], sample_count = 5)]
fn inverse<const THREADS: usize>(bencher: Bencher, order: usize) {
    const POSES: usize = 200_000;
    let model = model(order);
    let measured = readings(&model, POSES);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(THREADS).build().expect("threads");
    bencher.counter(ItemsCount::new(POSES)).bench_local(|| {
        pool.install(|| {
            undistort(&model, black_box(&measured), OutsidePolicy::Clamp, &Task::default())
        })
    });
}

/// The same by a plain loop: one pose at a time, fixed point, on one core.
#[divan::bench(args = [2, 4, 6], sample_count = 5)]
fn plain_loop(bencher: Bencher, order: usize) {
    const POSES: usize = 10_000;
    let model = model(order);
    let measured = readings(&model, POSES);
    bencher.counter(ItemsCount::new(POSES)).bench_local(|| {
        for reading in &measured {
            black_box(fixed_point(&model, black_box(reading)));
        }
    });
}

fn fixed_point(model: &DistortionModel, reading: &Pose) -> Option<Pose> {
    let mut pose = *reading;
    for _ in 0..50 {
        let axis = pose.rotation * Vector3::z_axis();
        let error =
            model.evaluate(&pose.translation.vector.into(), &axis, OutsidePolicy::Clamp).error;
        let next = Pose::from_parts(
            (reading.translation.vector - error.position_mm).into(),
            UnitQuaternion::from_scaled_axis(-error.rotation_rad) * reading.rotation,
        );
        let moved_mm = (next.translation.vector - pose.translation.vector).norm();
        let turned = next.rotation * Vector3::z() - axis.into_inner();
        pose = next;
        if moved_mm < 1e-11 && turned.norm() < 1e-14 {
            return Some(pose);
        }
    }
    None
}

/// What is done once a model: bounds of its slopes, cell by cell where they are needed.
#[divan::bench(args = [2, 4, 6], sample_count = 5)]
fn prepare(bencher: Bencher, order: usize) {
    let model = model(order);
    bencher.bench_local(|| Inverse::new(black_box(&model), OutsidePolicy::Clamp).is_one_to_one());
}

/// Value and derivatives by position and axis, one pose at a time.
#[divan::bench(args = [2, 4, 6])]
fn jacobian(bencher: Bencher, order: usize) {
    const POSES: usize = 1000;
    let model = model(order);
    let poses = poses(POSES);
    bencher.counter(ItemsCount::new(POSES)).bench_local(|| {
        for (position, axis) in &poses {
            black_box(model.evaluate_with_jacobian(position, axis, OutsidePolicy::Clamp));
        }
    });
}
