//! Equation (8): independent poses, one axis at many positions and lattices beside a plain loop over
//! single poses, and what this machine's cores can do at most.

mod plain;

use crate::{model, poses};
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use nalgebra::{Point3, Unit, Vector3};
use plain::Plain;
use pulp::{Arch, Simd, WithSimd};
use trackwright_field::OutsidePolicy;
use trackwright_field::batch::{Batch, Instructions};

const POSES: usize = 4096;

#[divan::bench(args = [2, 4, 6])]
fn scattered_plain_loop(bencher: Bencher, order: usize) {
    let model = model(order);
    let plain = Plain::new(&model);
    let poses = poses(POSES);
    bencher.counter(ItemsCount::new(POSES)).bench_local(|| {
        for (position, axis) in &poses {
            black_box(plain.evaluate(black_box(position), axis));
        }
    });
}

#[divan::bench(args = [2, 4, 6])]
fn scattered_single(bencher: Bencher, order: usize) {
    let model = model(order);
    let poses = poses(POSES);
    bencher.counter(ItemsCount::new(POSES)).bench_local(|| {
        for (position, axis) in &poses {
            black_box(model.evaluate(black_box(position), axis, OutsidePolicy::Clamp));
        }
    });
}

fn batch(bencher: Bencher, order: usize, instructions: Instructions) {
    let model = model(order);
    let (positions, axes): (Vec<_>, Vec<_>) = poses(POSES).into_iter().unzip();
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
    let positions: Vec<_> = poses(POSES).into_iter().map(|(position, _)| position).collect();
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

/// Independent chains of multiply-adds: enough to hide the latency of any core so far.
const CHAINS: usize = 12;
const STEPS: usize = 10_000;

struct Chains;

impl WithSimd for Chains {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let factor = simd.splat_f64s(black_box(0.999_999));
        let mut sums = [simd.splat_f64s(black_box(1.0)); CHAINS];
        for _ in 0..STEPS {
            for sum in &mut sums {
                *sum = simd.mul_add_e_f64s(*sum, factor, factor);
            }
        }
        sums.into_iter().map(|s| simd.reduce_sum_f64s(s)).sum()
    }
}

struct Lanes;

impl WithSimd for Lanes {
    type Output = usize;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> usize {
        S::F64_LANES
    }
}

/// Items are multiply-adds of two numbers: a billion a second are 2 GFLOP/s.
#[divan::bench(args = ["best", "AVX2"])]
fn peak_multiply_adds(bencher: Bencher, level: &str) {
    let arch = match (level, Arch::new()) {
        #[cfg(target_arch = "x86_64")]
        ("AVX2", arch) => pulp::x86::V3::try_new().map_or(arch, Arch::V3),
        (_, arch) => arch,
    };
    let lanes = arch.dispatch(Lanes);
    bencher.counter(ItemsCount::new(CHAINS * STEPS * lanes)).bench_local(|| arch.dispatch(Chains));
}
