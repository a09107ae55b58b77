//! Independent positions and axes: the study's case.

use super::plain::Plain;
use crate::{Uniform, model};
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use nalgebra::{Point3, Unit, Vector3};
use trackwright_field::OutsidePolicy;
use trackwright_field::batch::{Batch, Instructions};

const POSES: usize = 4096;

pub fn poses() -> (Vec<Point3<f64>>, Vec<Unit<Vector3<f64>>>) {
    let mut uniform = Uniform(7);
    (0..POSES).map(|_| (uniform.position(), uniform.axis())).unzip()
}

#[divan::bench(args = [2, 4, 6])]
fn scattered_plain_loop(bencher: Bencher, order: usize) {
    let model = model(order);
    let plain = Plain::new(&model);
    let (positions, axes) = poses();
    bencher.counter(ItemsCount::new(POSES)).bench_local(|| {
        for (position, axis) in positions.iter().zip(&axes) {
            black_box(plain.evaluate(black_box(position), axis));
        }
    });
}

#[divan::bench(args = [2, 4, 6])]
fn scattered_single(bencher: Bencher, order: usize) {
    let model = model(order);
    let (positions, axes) = poses();
    bencher.counter(ItemsCount::new(POSES)).bench_local(|| {
        for (position, axis) in positions.iter().zip(&axes) {
            black_box(model.evaluate(black_box(position), axis, OutsidePolicy::Clamp));
        }
    });
}

fn batch(bencher: Bencher, order: usize, instructions: Instructions) {
    let model = model(order);
    let (positions, axes) = poses();
    let mut batch = Batch::with_instructions(instructions);
    let mut out = Vec::new();
    bencher.counter(ItemsCount::new(POSES)).bench_local(|| {
        let outside = OutsidePolicy::Clamp;
        batch.evaluate(&model, black_box(&positions), &axes, outside, &mut out);
        black_box(&out);
    });
}

#[divan::bench(args = [2, 4, 6])]
fn scattered_batch(bencher: Bencher, order: usize) {
    batch(bencher, order, Instructions::Best);
}

#[divan::bench(args = [2, 4, 6])]
fn scattered_batch_avx2(bencher: Bencher, order: usize) {
    batch(bencher, order, Instructions::Avx2);
}

#[divan::bench(args = [2, 4, 6])]
fn scattered_batch_portable(bencher: Bencher, order: usize) {
    batch(bencher, order, Instructions::Portable);
}
