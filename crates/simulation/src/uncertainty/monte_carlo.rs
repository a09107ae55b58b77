//! Monte Carlo of the tip at the design's pose: noise on every reading, both bodies refitted.
//!
//! Samples come in chunks of a fixed size, each with its own stream of one seeded generator, and
//! are summed chunk by chunk: the result is the same to the bit on any number of threads.

use super::error::{MAX_SAMPLES, MIN_SAMPLES, UncertaintyError};
use super::first_order::free_body;
use super::still::{FreeBody, Refit, Refitted, Still};
use crate::linear_fit::LinearFit;
use crate::metric::Statistics;
use crate::scenario::Scenario;
use crate::statistics::percentile;
use crate::work::Work;
use nalgebra::{Matrix3, Vector3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};
use trackwright_task::{Cancelled, Task};

/// Samples of one stream. Part of what a seed means: another size gives other samples.
const CHUNK: usize = 512;

/// A figure and its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    pub value: f64,
    pub std_error: f64,
}

/// How the tip scatters about where it truly is; CRF axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MonteCarlo {
    pub samples: usize,
    pub seed: u64,
    /// What distortion and jitter shift the tip by on average.
    pub mean_error_mm: Vector3<f64>,
    pub mean_std_error_mm: Vector3<f64>,
    /// About the mean.
    pub covariance_mm2: Matrix3<f64>,
    /// About the mean: what the jitter alone adds.
    pub rms_mm: Estimate,
    /// About the true tip: distortion and jitter together.
    pub total_rms_mm: Estimate,
    /// Distances from the true tip.
    pub tip_error_mm: Statistics,
    pub median_mm: Estimate,
    pub p95_mm: Estimate,
    /// Angles between the true and the simulated rotation.
    pub angle_deg: Statistics,
    pub mean_rotation_rad: Vector3<f64>,
    /// Of the rotation vector, about its mean.
    pub rotation_covariance_rad2: Matrix3<f64>,
    pub rotation_rms_rad: f64,
    /// Where a rotation is not determined: distances that it cannot change.
    pub determined_mm: Option<Statistics>,
    pub work: Work,
}

/// Reads the sensors `samples` times with the environment's jitter and refits both bodies.
///
/// Noise is normal: the same in all directions on positions, a rotation vector on orientations,
/// across the axis alone for a 5-DOF sensor; independent from sensor to sensor.
///
/// # Errors
/// See [`UncertaintyError`].
pub fn monte_carlo(
    scenario: &Scenario,
    samples: usize,
    seed: u64,
    task: &Task,
) -> Result<MonteCarlo, UncertaintyError> {
    if !(MIN_SAMPLES..=MAX_SAMPLES).contains(&samples) {
        return Err(UncertaintyError::Samples { found: samples });
    }
    let still = Still::new(scenario)?;
    let sampler = Sampler { refit: still.refit(), free: free(scenario), seed };
    let base = sampler.refit.without_noise();
    let mut distances = vec![Distances::default(); samples];
    let done = AtomicUsize::new(0);
    let chunks: Vec<Sums> = distances
        .par_chunks_mut(CHUNK)
        .enumerate()
        .map(|(index, room)| {
            let sums = sampler.chunk(index, &base, room, task)?;
            let done = done.fetch_add(room.len(), Ordering::Relaxed) + room.len();
            task.step(done, samples)?;
            Ok(sums)
        })
        .collect::<Result<_, Cancelled>>()?;
    let mut sums = Sums::default();
    for chunk in &chunks {
        sums.add(chunk);
    }
    let mut column = Vec::with_capacity(samples);
    let mut of = |value: fn(&Distances) -> f64| {
        column.clear();
        column.extend(distances.iter().map(value));
        let statistics = Statistics::of(&mut column)?;
        let std_errors = [0.5, 0.95].map(|p| percentile_std_error(&mut column, p));
        Some((statistics, std_errors))
    };
    let none = UncertaintyError::Samples { found: samples };
    let (tip_error_mm, [median_std_error, p95_std_error]) =
        of(|d| d.tip_error_mm).ok_or(none.clone())?;
    let (angle_deg, _) = of(|d| d.angle_rad.to_degrees()).ok_or(none)?;
    let determined_mm = match &sampler.free {
        None => None,
        Some(_) => of(|d| d.determined_mm).map(|(statistics, _)| statistics),
    };
    let n = samples as f64;
    let covariance_mm2 = covariance(&sums.tip_mm, &sums.tip_mm2, n);
    let rotation_covariance_rad2 = covariance(&sums.turn_rad, &sums.turn_rad2, n);
    let rms_mm = covariance_mm2.trace().max(0.0).sqrt();
    let estimate = |value, std_error| Estimate { value, std_error };
    Ok(MonteCarlo {
        samples,
        seed,
        mean_error_mm: base.tip_error_mm + sums.tip_mm / n,
        mean_std_error_mm: covariance_mm2.diagonal().map(|v| (v.max(0.0) / n).sqrt()),
        covariance_mm2,
        rms_mm: estimate(
            rms_mm,
            rms_std_error(rms_mm, sums.tip_mm2.trace() / n, sums.shift_mm4 / n, n),
        ),
        total_rms_mm: estimate(
            tip_error_mm.rms(),
            rms_std_error(tip_error_mm.rms(), sums.error_mm2 / n, sums.error_mm4 / n, n),
        ),
        tip_error_mm,
        median_mm: estimate(tip_error_mm.median(), median_std_error),
        p95_mm: estimate(tip_error_mm.p95(), p95_std_error),
        angle_deg,
        mean_rotation_rad: base.turn_rad + sums.turn_rad / n,
        rotation_covariance_rad2,
        rotation_rms_rad: rotation_covariance_rad2.trace().max(0.0).sqrt(),
        determined_mm,
        work: still.pose.work
            + Work { frame_fits: sampler.refit.fits() * (samples as u64 + 1), ..Work::default() },
    })
}

fn free(scenario: &Scenario) -> Option<FreeBody> {
    let linear = |body| LinearFit::new(body, scenario.orientation_weight_mm);
    let crf = scenario.crf.as_ref().map(|c| linear(&c.body));
    free_body(&linear(&scenario.tool), crf.as_ref())
}

/// What every chunk is made with.
struct Sampler {
    refit: Refit,
    free: Option<FreeBody>,
    seed: u64,
}

/// One sample's distances from the truth.
#[derive(Clone, Copy, Debug, Default)]
struct Distances {
    tip_error_mm: f64,
    angle_rad: f64,
    /// Zero where nothing is free.
    determined_mm: f64,
}

impl Sampler {
    fn chunk(
        &self,
        index: usize,
        base: &Refitted,
        room: &mut [Distances],
        task: &Task,
    ) -> Result<Sums, Cancelled> {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(index as u64);
        let mut sums = Sums::default();
        let mut readings = Vec::new();
        for distances in room {
            // A sample of thousands of sensors takes a millisecond.
            if task.cancel.is_cancelled() {
                return Err(Cancelled);
            }
            let sample = self.refit.with_noise(|| StandardNormal.sample(&mut rng), &mut readings);
            sums.count(&sample, base);
            *distances = Distances {
                tip_error_mm: sample.tip_error_mm.norm(),
                angle_rad: sample.turn_rad.norm(),
                determined_mm: self
                    .free
                    .as_ref()
                    .map_or(0.0, |free| self.refit.determined_mm(free, &sample)),
            };
        }
        Ok(sums)
    }
}

/// Sums over samples of what is left after the errors without noise: small numbers, so that
/// squares lose nothing.
#[derive(Clone, Copy, Default)]
struct Sums {
    tip_mm: Vector3<f64>,
    tip_mm2: Matrix3<f64>,
    turn_rad: Vector3<f64>,
    turn_rad2: Matrix3<f64>,
    /// Of the fourth powers of the distance from the tip without noise, and from the true tip.
    shift_mm4: f64,
    error_mm4: f64,
    error_mm2: f64,
}

impl Sums {
    fn count(&mut self, sample: &Refitted, base: &Refitted) {
        let tip = sample.tip_error_mm - base.tip_error_mm;
        let turn = sample.turn_rad - base.turn_rad;
        self.tip_mm += tip;
        self.tip_mm2 += tip * tip.transpose();
        self.turn_rad += turn;
        self.turn_rad2 += turn * turn.transpose();
        self.shift_mm4 += tip.norm_squared().powi(2);
        let error_mm2 = sample.tip_error_mm.norm_squared();
        self.error_mm2 += error_mm2;
        self.error_mm4 += error_mm2 * error_mm2;
    }

    fn add(&mut self, other: &Self) {
        self.tip_mm += other.tip_mm;
        self.tip_mm2 += other.tip_mm2;
        self.turn_rad += other.turn_rad;
        self.turn_rad2 += other.turn_rad2;
        self.shift_mm4 += other.shift_mm4;
        self.error_mm4 += other.error_mm4;
        self.error_mm2 += other.error_mm2;
    }
}

/// Covariance about the mean from sums of `n` values and their products.
fn covariance(sum: &Vector3<f64>, products: &Matrix3<f64>, n: f64) -> Matrix3<f64> {
    (products - sum * sum.transpose() / n) / (n - 1.0)
}

/// Standard error of `√ mean(q)` from the mean squares of `q`: its derivative times that of the
/// mean.
fn rms_std_error(rms: f64, mean_square: f64, mean_fourth: f64, n: f64) -> f64 {
    if rms <= 0.0 {
        return 0.0;
    }
    let variance = (mean_fourth - mean_square * mean_square).max(0.0);
    (variance / n).sqrt() / (2.0 * rms)
}

/// Standard error of a percentile, from the order statistics one standard deviation of the
/// binomial count to either side; needs no density.
fn percentile_std_error(values: &mut [f64], p: f64) -> f64 {
    let off = (p * (1.0 - p) / values.len() as f64).sqrt();
    let low = percentile(values, (p - off).max(0.0));
    let high = percentile(values, (p + off).min(1.0));
    0.5 * (high - low)
}
