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
    /// Percentiles interpolate linearly between order statistics, at `(n - 1) p`. One value that
    /// is not a number makes all figures that.
    pub fn of(values: &mut [f64]) -> Option<Self> {
        if values.is_empty() {
            return None;
        }
        if values.iter().any(|v| v.is_nan()) {
            return Some(Self::not_a_number());
        }
        let n = values.len() as f64;
        let rough = pairwise_sum(values, &|v| v) / n;
        // Once more from there: equal values have exactly their own mean, and no deviation.
        let mean = rough + pairwise_sum(values, &|v| v - rough) / n;
        let min = values.iter().copied().fold(f64::INFINITY, f64::min);
        let max = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let unit = unit_of_squares(min.abs().max(max.abs()));
        let root_mean_square =
            |from: f64| (pairwise_sum(values, &|v| ((v - from) / unit).powi(2)) / n).sqrt() * unit;
        let (rms, std) = (root_mean_square(0.0), root_mean_square(mean));
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

    fn not_a_number() -> Self {
        let [rms, mean, std, min, median, p95, max] = [f64::NAN; 7];
        Self { rms, mean, std, min, median, p95, max }
    }
}

/// What values are divided by before they are squared: 1, or a power of two where their squares
/// would leave the range of numbers.
fn unit_of_squares(largest: f64) -> f64 {
    if (1e-120..1e120).contains(&largest) || largest == 0.0 || largest.is_infinite() {
        1.0
    } else {
        largest.log2().floor().exp2()
    }
}

/// The `p`-th quantile, `0 <= p <= 1`, of at least one value; reorders them.
pub fn percentile(values: &mut [f64], p: f64) -> f64 {
    let place = (values.len() - 1) as f64 * p;
    let below = place.floor() as usize;
    let (_, &mut low, above) = values.select_nth_unstable_by(below, f64::total_cmp);
    let high = above.iter().copied().min_by(f64::total_cmp).unwrap_or(low);
    let part = place - below as f64;
    // Nothing of an infinite neighbour is nothing.
    if part == 0.0 { low } else { low + (high - low) * part }
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
    fn one_value_that_is_no_number_makes_all_figures_that() {
        let s = Statistics::of(&mut [1.0, f64::NAN, 2.0]).unwrap();
        assert!([s.rms, s.mean, s.std, s.min, s.median, s.p95, s.max].iter().all(|v| v.is_nan()));
    }

    #[test]
    fn equal_values_have_no_deviation() {
        let s = Statistics::of(&mut [0.1; 1000]).unwrap();
        assert_eq!((s.mean, s.std), (0.1, 0.0));
    }

    #[test]
    fn no_values_have_no_statistics() {
        assert!(Statistics::of(&mut []).is_none());
    }
}
