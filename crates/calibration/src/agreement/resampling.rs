//! Intervals of figures that are ratios of sums, by resampling blocks of neighbours: the stationary
//! bootstrap (Politis & Romano, *JASA* 89, 1994).
//!
//! Blocks begin anywhere and end by chance, with the mean length that `calibration/dependence.rs`
//! finds; the series is a ring. What is resampled are the sums that all figures are made of, so that
//! one pass serves them all.

use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;
use std::ops::AddAssign;
use trackwright_task::{Cancelled, Task};

/// Resamplings that share a stream of random numbers.
const CHUNK: usize = 50;

/// What the figures of measured `m` and predicted `p` are made of.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sums {
    pub count: f64,
    pub measured: Vector3<f64>,
    pub predicted: Vector3<f64>,
    pub measured_squares: f64,
    pub predicted_squares: f64,
    pub products: f64,
    /// Of measured minus predicted: from the other three it would cancel.
    pub residual_squares: f64,
}

impl Sums {
    /// The sums of one pose.
    pub fn of(measured: &Vector3<f64>, predicted: &Vector3<f64>) -> Self {
        Self {
            count: 1.0,
            measured: *measured,
            predicted: *predicted,
            measured_squares: measured.norm_squared(),
            predicted_squares: predicted.norm_squared(),
            products: measured.dot(predicted),
            residual_squares: (measured - predicted).norm_squared(),
        }
    }

    /// `1 − Σ|m − p|² / Σ|m|²`.
    pub fn explained(&self) -> Option<f64> {
        ratio(self.residual_squares, self.measured_squares).map(|left| 1.0 - left)
    }

    /// The same about the means of both.
    pub fn explained_of_variation(&self) -> Option<f64> {
        let about_mean = |squares: f64, sum: Vector3<f64>| {
            let rest = squares - sum.norm_squared() / self.count;
            // What is left of equal vectors is round-off.
            if rest > 1e-12 * squares { rest } else { 0.0 }
        };
        let left = about_mean(self.residual_squares, self.measured - self.predicted);
        let all = about_mean(self.measured_squares, self.measured);
        ratio(left, all).map(|left| 1.0 - left)
    }

    /// `Σ m·p / Σ|p|²`.
    pub fn slope(&self) -> Option<f64> {
        ratio(self.products, self.predicted_squares)
    }
}

fn ratio(above: f64, below: f64) -> Option<f64> {
    (below > 0.0).then(|| above / below).filter(|value| value.is_finite())
}

impl AddAssign<&Sums> for Sums {
    fn add_assign(&mut self, other: &Sums) {
        self.count += other.count;
        self.measured += other.measured;
        self.predicted += other.predicted;
        self.measured_squares += other.measured_squares;
        self.predicted_squares += other.predicted_squares;
        self.products += other.products;
        self.residual_squares += other.residual_squares;
    }
}

/// The sums of so many resamplings of a series; the same for one seed on any number of threads.
pub fn resampled(
    series: &[Sums],
    block: f64,
    resamples: usize,
    seed: u64,
    task: &Task,
) -> Result<Vec<Sums>, Cancelled> {
    let chunks = resamples.div_ceil(CHUNK);
    let made: Result<Vec<Vec<Sums>>, Cancelled> = (0..chunks)
        .into_par_iter()
        .map(|chunk| {
            task.step(0, 1)?;
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            random.set_stream(chunk as u64);
            let count = CHUNK.min(resamples - chunk * CHUNK);
            let each = (0..count).map(|_| one(series, block, &mut random));
            Ok(each.collect())
        })
        .collect();
    Ok(made?.concat())
}

fn one(series: &[Sums], block: f64, random: &mut ChaCha8Rng) -> Sums {
    let count = series.len();
    let mut sums = Sums::default();
    // Below this a block ends: one in `block` of all numbers.
    let end = (u64::MAX as f64 / block.max(1.0)) as u64;
    let mut at = 0;
    for drawn in 0..count {
        if drawn == 0 || random.next_u64() < end {
            // The high half of a product is even to 2⁻⁶⁴.
            at = ((u128::from(random.next_u64()) * count as u128) >> 64) as usize;
        } else {
            at = if at + 1 == count { 0 } else { at + 1 };
        }
        sums += &series[at];
    }
    sums
}

/// The 2.5 % and 97.5 % percentiles; `None` where fewer than half of the resamplings have a figure.
pub fn interval(resampled: &[Sums], figure: fn(&Sums) -> Option<f64>) -> Option<[f64; 2]> {
    let mut values: Vec<f64> = resampled.iter().filter_map(figure).collect();
    if values.is_empty() || 2 * values.len() < resampled.len() {
        return None;
    }
    let at = |values: &mut [f64], p| trackwright_simulation::statistics::percentile(values, p);
    Some([at(&mut values, 0.025), at(&mut values, 0.975)])
}
