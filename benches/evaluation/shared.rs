//! Scenes that allow less work: one axis at many positions, and lattices.

use super::plain::Plain;
use super::scattered::poses;
use crate::model;
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use nalgebra::{Point3, Unit, Vector3};
use trackwright_field::{Batch, OutsidePolicy};

/// Points along each axis of the lattice.
const SIDE: usize = 40;

fn axis() -> Unit<Vector3<f64>> {
    Unit::new_normalize(Vector3::new(0.3, -0.7, 0.2))
}

fn coordinates() -> [Vec<f64>; 3] {
    let along = |min: f64| (0..SIDE).map(|i| min + 460.0 * i as f64 / SIDE as f64).collect();
    [along(-230.0), along(-230.0), along(-530.0)]
}

/// Coefficients blended once, positions anywhere; blending included.
#[divan::bench(args = [2, 4, 6])]
fn shared_axis_batch(bencher: Bencher, order: usize) {
    let model = model(order);
    let (positions, _) = poses();
    let (mut batch, mut out) = (Batch::default(), Vec::new());
    bencher.counter(ItemsCount::new(positions.len())).bench_local(|| {
        let at_axis = black_box(&model).at_axis(&axis());
        at_axis.evaluate_all(&mut batch, &positions, OutsidePolicy::Clamp, &mut out);
        black_box(&out);
    });
}

#[divan::bench(args = [2, 4, 6])]
fn blend_for_one_axis(bencher: Bencher, order: usize) {
    let model = model(order);
    bencher.bench_local(|| black_box(&model).at_axis(&axis()));
}

/// All points of a lattice of 40³, blending included.
#[divan::bench(args = [2, 4, 6], sample_count = 20)]
fn lattice_by_sum_factorisation(bencher: Bencher, order: usize) {
    let model = model(order);
    let [xs, ys, zs] = coordinates();
    let mut out = Vec::new();
    bencher.counter(ItemsCount::new(SIDE.pow(3))).bench_local(|| {
        let at_axis = black_box(&model).at_axis(&axis());
        at_axis.evaluate_lattice([&xs, &ys, &zs], OutsidePolicy::Clamp, &mut out);
        black_box(&out);
    });
}

#[divan::bench(args = [2, 4, 6], sample_count = 5)]
fn lattice_plain_loop(bencher: Bencher, order: usize) {
    let model = model(order);
    let plain = Plain::new(&model);
    let [xs, ys, zs] = coordinates();
    let axis = axis();
    bencher.counter(ItemsCount::new(SIDE.pow(3))).bench_local(|| {
        for &x in &xs {
            for &y in &ys {
                for &z in &zs {
                    black_box(plain.evaluate(&Point3::new(x, y, z), &axis));
                }
            }
        }
    });
}
