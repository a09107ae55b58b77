//! Summary statistics of a study's trials.

use serde::Serialize;

/// The figures of one quantity over all trials, in its own unit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Statistics {
    pub rms: f64,
    pub mean: f64,
    /// Population standard deviation.
    pub std: f64,
    pub min: f64,
    pub median: f64,
    pub p95: f64,
    pub max: f64,
}

impl Statistics {
    /// The figures of the values, which are reordered; `None` without any.
    ///
    /// Sums run in the order given, so the same values in the same order give the same bits.
    /// Percentiles interpolate linearly between order statistics, at `(n - 1) p`.
    pub fn of(values: &mut [f64]) -> Option<Self> {
        if values.is_empty() {
            return None;
        }
        let n = values.len() as f64;
        let mean = pairwise_sum(values, &|v| v) / n;
        let rms = (pairwise_sum(values, &|v| v * v) / n).sqrt();
        let std = (pairwise_sum(values, &|v| (v - mean) * (v - mean)) / n).sqrt();
        let min = values.iter().copied().fold(f64::INFINITY, f64::min);
        let max = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        Some(Self {
            rms,
            mean,
            std,
            min,
            median: percentile(values, 0.5),
            p95: percentile(values, 0.95),
            max,
        })
    }
}

/// The `p`-th quantile, `0 <= p <= 1`, of at least one value; reorders them.
pub fn percentile(values: &mut [f64], p: f64) -> f64 {
    let place = (values.len() - 1) as f64 * p;
    let below = place.floor() as usize;
    let (_, &mut low, above) = values.select_nth_unstable_by(below, f64::total_cmp);
    let high = above.iter().copied().min_by(f64::total_cmp).unwrap_or(low);
    low + (high - low) * (place - below as f64)
}

/// Pairwise summation: error grows with the logarithm of the count.
fn pairwise_sum(values: &[f64], of: &impl Fn(f64) -> f64) -> f64 {
    if values.len() <= 128 {
        return values.iter().map(|&v| of(v)).sum();
    }
    let (left, right) = values.split_at(values.len() / 2);
    pairwise_sum(left, of) + pairwise_sum(right, of)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_of_one_to_four_are_the_textbook_ones() {
        let s = Statistics::of(&mut [4.0, 1.0, 3.0, 2.0]).unwrap();
        assert_eq!((s.mean, s.min, s.max, s.median), (2.5, 1.0, 4.0, 2.5));
        assert!((s.rms - 7.5_f64.sqrt()).abs() < 1e-15);
        assert!((s.std - 1.25_f64.sqrt()).abs() < 1e-15);
        assert!((s.p95 - 3.85).abs() < 1e-15);
    }

    #[test]
    fn one_value_is_its_own_statistics() {
        let s = Statistics::of(&mut [2.0]).unwrap();
        assert_eq!((s.rms, s.std, s.median, s.p95), (2.0, 0.0, 2.0, 2.0));
    }

    #[test]
    fn no_values_have_no_statistics() {
        assert!(Statistics::of(&mut []).is_none());
    }
}
