//! Expected figures as the command line, the window and the report write them.

use super::Expected;
use crate::metric::Metric;

/// One expected figure for a person.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExpectedRow {
    pub metric: Metric,
    /// With as many digits as the figures of the room's own field have.
    pub value: String,
    pub low: String,
    pub high: String,
}

impl ExpectedRow {
    pub fn label(&self) -> String {
        format!("expected {}", self.metric.label())
    }

    /// Its 95 % interval.
    pub fn interval_words(&self) -> String {
        format!("(95 %: {} to {})", self.low, self.high)
    }
}

/// The figures that a requirement can be about.
pub fn expected_rows(expected: &Expected) -> Vec<ExpectedRow> {
    let each = Metric::bounded().map(|metric| {
        let (value, [low, high]) = expected.of(metric);
        let [value, low, high] = [value, low, high].map(|v| format!("{v:.4}"));
        ExpectedRow { metric, value, low, high }
    });
    each.collect()
}
