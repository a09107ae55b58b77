//! What this machine's cores can do at most, to say the share of it that is used.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use pulp::{Arch, Simd, WithSimd};

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
