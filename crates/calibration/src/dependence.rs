//! The effective number of poses of a recording, and how long blocks of neighbours have to be.
//!
//! Block lengths are those of Politis & White (*Econometric Reviews* 23, 2004) for the stationary
//! bootstrap, as corrected by Patton, Politis & White (28, 2009), with the autocovariance of a vector
//! taken as its trace, `R(k) = Σ rᵢ·rᵢ₊ₖ / n`, which no choice of axes changes. The same flat-top
//! window gives the long-run variance, and with it the effective number of poses.

use nalgebra::{DMatrix, Vector3};

/// Fewest independent readings for intervals: with eight, Student's quantile is within a fifth of
/// the normal one, and Hotelling's test of three components needs five.
pub const MIN_EFFECTIVE: f64 = 8.0;

/// A correlation below this many times `√(log₁₀ n / n)` counts as none (Politis & White's `c`).
const INSIGNIFICANT: f64 = 2.0;

/// What neighbours in a series have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dependence {
    /// Mean length of the blocks to be resampled, at least 1.
    pub block: f64,
    /// Variance of the mean times `n`, over the variance: how many neighbours count as one.
    pub inflation: f64,
}

impl Dependence {
    /// Of vectors in the order in which they were recorded.
    pub fn of(series: &[Vector3<f64>]) -> Self {
        Self::of_columns(&DMatrix::from_fn(3, series.len(), |row, k| series[k][row]))
    }

    /// Of vectors of any length, a column each.
    pub fn of_columns(series: &DMatrix<f64>) -> Self {
        let independent = Self { block: 1.0, inflation: 1.0 };
        let count = series.ncols();
        // Of fewer there are no five lags in a row.
        if count < 6 {
            return independent;
        }
        let n = count as f64;
        let mean = series.column_sum() / n;
        let mut centred = series.clone();
        for mut column in centred.column_iter_mut() {
            column -= &mean;
        }
        // Columns follow each other in memory.
        let (values, rows) = (centred.as_slice(), series.nrows());
        let covariance = |lag: usize| -> f64 {
            let pairs = values.iter().zip(&values[rows * lag..]);
            pairs.map(|(a, b)| a * b).sum::<f64>() / n
        };
        let variance = covariance(0);
        // Also where something overflowed.
        if variance.is_nan() || variance <= 0.0 || variance.is_infinite() {
            return independent;
        }
        let run = 5.0_f64.max(n.log10().sqrt().ceil()) as usize;
        let farthest = (n.sqrt().ceil() as usize + run).min(count - 1);
        let bound = INSIGNIFICANT * (n.log10() / n).sqrt();
        let correlations: Vec<f64> = (1..=farthest).map(|k| covariance(k) / variance).collect();
        // The first lag of `run` in a row without correlation; else the last that has one.
        let quiet = (0..=farthest.saturating_sub(run))
            .find(|&first| correlations[first..first + run].iter().all(|r| r.abs() < bound));
        let last = match quiet {
            Some(first) => first + 1,
            None => correlations.iter().rposition(|r| r.abs() > bound).map_or(1, |k| k + 1),
        };
        let reach = (2 * last).min(farthest);
        let (mut weighted, mut long_run) = (0.0, 1.0);
        for (k, r) in (1..=reach).zip(&correlations) {
            let part = k as f64 / reach as f64;
            let window = if part <= 0.5 { 1.0 } else { 2.0 * (1.0 - part) };
            weighted += 2.0 * window * k as f64 * r;
            long_run += 2.0 * window * r;
        }
        let most = (3.0 * n.sqrt()).min(n / 3.0).ceil().max(1.0);
        let block = match long_run > 0.0 {
            true => (weighted.powi(2) / long_run.powi(2)).cbrt() * n.cbrt(),
            // A window that cuts a slow oscillation may leave nothing: the longest blocks then.
            false => most,
        };
        Self { block: block.clamp(1.0, most), inflation: long_run.max(1.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackwright_field::random_models::Seeded;

    /// A series that a short program of anyone's can make again.
    fn smoothed(count: usize) -> Vec<Vector3<f64>> {
        let mut state = 0.0;
        (0..count)
            .map(|i| {
                let i = i as f64;
                state = 0.7 * state + (1.93 * i * i).sin();
                Vector3::new(0.0, state, 0.0)
            })
            .collect()
    }

    #[test]
    fn blocks_are_as_long_as_another_program_has_them() {
        for (count, expected) in ARCH {
            let found = Dependence::of(&smoothed(count)).block;
            assert!((found / expected - 1.0).abs() < 1e-9, "{count}: {found} {expected}");
        }
    }

    /// `optimal_block_length(x)["stationary"]` of Python's `arch` 8.0.0 for `smoothed`.
    const ARCH: [(usize, f64); 3] =
        [(120, 6.163041557040422), (500, 14.121226450919256), (2000, 25.495274340047597)];

    #[test]
    fn autoregression_has_its_effective_size() {
        let mut random = Seeded::new(2);
        let a = 0.8;
        let mut state = Vector3::zeros();
        let series: Vec<_> = (0..20_000)
            .map(|_| {
                state = state * a + random.normal_vector();
                state
            })
            .collect();
        // (1 + a) / (1 − a); the window reaches some 50 lags, so the estimate is good to
        // √(2 · 50 / 20,000 / 3) = 4 %: three of these.
        let found = Dependence::of(&series).inflation;
        assert!((found / 9.0 - 1.0).abs() < 0.12, "{found}");
    }

    #[test]
    fn white_noise_is_independent() {
        let mut random = Seeded::new(3);
        let series: Vec<_> = (0..2000).map(|_| random.normal_vector()).collect();
        let found = Dependence::of(&series);
        assert!(found.inflation < 1.2 && found.block < 5.0, "{found:?}");
        let constant = Dependence::of(&[Vector3::new(1.0, 2.0, 3.0); 50]);
        assert_eq!((constant.block, constant.inflation), (1.0, 1.0));
        for count in 0..12 {
            let few = Dependence::of(&smoothed(count));
            assert!(few.inflation >= 1.0 && few.block >= 1.0, "{count}: {few:?}");
        }
        let nan = Dependence::of(&[Vector3::repeat(f64::NAN); 50]);
        assert_eq!((nan.block, nan.inflation), (1.0, 1.0));
    }
}
