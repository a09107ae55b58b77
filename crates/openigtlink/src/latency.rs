//! How long messages stay here: a histogram of fixed size.

use hdrhistogram::Histogram;
use std::time::Duration;

/// Longer ones count as this: a minute, in nanoseconds.
const LONGEST_NS: u64 = 60_000_000_000;

/// Times from the read off one socket to the write into another, to two digits, in some 60 kB.
///
/// ```
/// use std::time::Duration;
/// let mut latencies = trackwright_openigtlink::latency::Latencies::default();
/// for ms in [1, 2, 3] {
///     latencies.record(Duration::from_millis(ms));
/// }
/// let summary = latencies.summary();
/// assert_eq!(summary.count, 3);
/// assert!((summary.median_s - 2e-3).abs() < 2e-5);
/// ```
#[derive(Clone, Debug)]
pub struct Latencies(Option<Histogram<u64>>);

/// What a histogram of times comes to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LatencySummary {
    pub count: u64,
    pub median_s: f64,
    pub p99_s: f64,
    pub max_s: f64,
}

impl Default for Latencies {
    fn default() -> Self {
        // Only bounds that contradict each other are refused.
        Self(Histogram::new_with_bounds(100, LONGEST_NS, 2).ok())
    }
}

impl Latencies {
    /// Adds a time.
    pub fn record(&mut self, latency: Duration) {
        let ns = u64::try_from(latency.as_nanos()).unwrap_or(LONGEST_NS);
        if let Some(histogram) = &mut self.0 {
            histogram.saturating_record(ns);
        }
    }

    /// Quantiles of all times.
    pub fn summary(&self) -> LatencySummary {
        let Some(histogram) = &self.0 else {
            return LatencySummary::default();
        };
        let seconds = |ns: u64| ns as f64 * 1e-9;
        LatencySummary {
            count: histogram.len(),
            median_s: seconds(histogram.value_at_quantile(0.5)),
            p99_s: seconds(histogram.value_at_quantile(0.99)),
            max_s: seconds(histogram.max()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_right_to_a_hundredth() {
        let mut latencies = Latencies::default();
        for us in 1..=10_000 {
            latencies.record(Duration::from_micros(us));
        }
        let found = latencies.summary();
        assert_eq!(found.count, 10_000);
        assert!((found.median_s / 5e-3 - 1.0).abs() < 0.01, "{found:?}");
        assert!((found.p99_s / 9.9e-3 - 1.0).abs() < 0.01, "{found:?}");
        assert!((found.max_s / 10e-3 - 1.0).abs() < 0.01, "{found:?}");
        latencies.record(Duration::MAX);
        latencies.record(Duration::ZERO);
        assert_eq!(latencies.summary().count, 10_002);
        assert!((latencies.summary().max_s / 60.0 - 1.0).abs() < 0.01);
    }
}
