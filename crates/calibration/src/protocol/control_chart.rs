//! Control charts of a figure over repeated runs: individuals and moving ranges with Shewhart's limits,
//! and which points are out of control.
//!
//! With `x̄` the mean and `m̄` the mean moving range of the runs that make the limits, and `d₂ = 2/√π` the
//! mean range of two normal numbers, `σ = m̄/d₂`; limits are `x̄ ± 3σ`, and for moving ranges
//! `m̄ (1 + 3 d₃/d₂)`, `d₃² = 2 − 4/π`. Montgomery, Introduction to Statistical Quality Control, chapters 5
//! and 6.

use serde::Serialize;
use std::f64::consts::PI;
use trackwright_simulation::statistics::Sample;

/// Fewest runs that make limits. Of fewer, the standard deviation is off by a third or more.
pub const MIN_FOR_LIMITS: usize = 8;

/// Which points count as out of control.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rules {
    /// The four of Western Electric, 1956: one beyond 3σ, two of three beyond 2σ on a side, four of five
    /// beyond σ on a side, eight in a row on a side.
    #[default]
    WesternElectric,
    /// The first of Nelson, 1984: one beyond 3σ.
    NelsonFirst,
}

/// Why a point is out of control.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signal {
    BeyondThreeSigma,
    TwoOfThreeBeyondTwoSigma,
    FourOfFiveBeyondOneSigma,
    EightOnOneSide,
    /// The change from the run before is too large.
    MovingRange,
}

/// Levels of both charts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Limits {
    pub mean: f64,
    pub sigma: f64,
    pub lower: f64,
    pub upper: f64,
    pub mean_range: f64,
    pub upper_range: f64,
}

/// The charts of one figure.
#[derive(Clone, Debug, PartialEq)]
pub struct ControlChart {
    pub values: Vec<f64>,
    /// From each run to the next, one fewer.
    pub moving_ranges: Vec<f64>,
    /// None of fewer than [`MIN_FOR_LIMITS`] runs.
    pub limits: Option<Limits>,
    /// Run and reason, in the order of the runs; several of one run are possible.
    pub signals: Vec<(usize, Signal)>,
}

/// Why there is no chart.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ControlChartError {
    #[error("found {0} runs, expected at least 2")]
    TooFewRuns(usize),
    #[error("limits from {0} runs, expected at least {MIN_FOR_LIMITS}")]
    TooFewForLimits(usize),
    #[error("limits from the first {baseline} runs, found {runs}")]
    BaselineTooLong { baseline: usize, runs: usize },
    #[error("run {0} is not finite")]
    NotFinite(usize),
}

impl Signal {
    /// For a person.
    pub fn label(self) -> &'static str {
        match self {
            Self::BeyondThreeSigma => "beyond 3 σ",
            Self::TwoOfThreeBeyondTwoSigma => "two of three beyond 2 σ on one side",
            Self::FourOfFiveBeyondOneSigma => "four of five beyond 1 σ on one side",
            Self::EightOnOneSide => "eight in a row on one side",
            Self::MovingRange => "change from the run before beyond its limit",
        }
    }
}

/// The charts of a figure. Limits are from the first `baseline` runs, or from all.
///
/// # Errors
/// See [`ControlChartError`]. Of too few runs without a baseline there is a chart without limits.
pub fn control_chart(
    values: &[f64],
    baseline: Option<usize>,
    rules: Rules,
) -> Result<ControlChart, ControlChartError> {
    let runs = values.len();
    if runs < 2 {
        return Err(ControlChartError::TooFewRuns(runs));
    }
    if let Some(run) = values.iter().position(|value| !value.is_finite()) {
        return Err(ControlChartError::NotFinite(run));
    }
    match baseline {
        Some(baseline) if baseline < MIN_FOR_LIMITS => {
            return Err(ControlChartError::TooFewForLimits(baseline));
        }
        Some(baseline) if baseline > runs => {
            return Err(ControlChartError::BaselineTooLong { baseline, runs });
        }
        _ => {}
    }
    let moving_ranges: Vec<f64> = values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    let of = baseline.unwrap_or(runs);
    let limits = (of >= MIN_FOR_LIMITS).then(|| limits(&values[..of], &moving_ranges[..of - 1]));
    let signals = match &limits {
        Some(limits) => signals(values, &moving_ranges, limits, rules),
        None => Vec::new(),
    };
    Ok(ControlChart { values: values.to_vec(), moving_ranges, limits, signals })
}

fn limits(values: &[f64], moving_ranges: &[f64]) -> Limits {
    // Exact for equal values, of which none may be beyond their mean.
    let mean_of = |all: &[f64]| Sample::new(&mut all.to_vec()).mean();
    let (mean, mean_range) = (mean_of(values), mean_of(moving_ranges));
    let mean_of_two = 2.0 / PI.sqrt();
    let spread_of_two = (2.0 - 4.0 / PI).sqrt();
    let sigma = mean_range / mean_of_two;
    Limits {
        mean,
        sigma,
        lower: mean - 3.0 * sigma,
        upper: mean + 3.0 * sigma,
        mean_range,
        upper_range: mean_range * (1.0 + 3.0 * spread_of_two / mean_of_two),
    }
}

fn signals(
    values: &[f64],
    moving_ranges: &[f64],
    limits: &Limits,
    rules: Rules,
) -> Vec<(usize, Signal)> {
    // Whether so many of the last so many are beyond a level, the last one among them.
    let has_run = |run: usize, side: f64, sigmas: f64, least: usize, of: usize| {
        let is_beyond = |value: &f64| side * (value - limits.mean) > sigmas * limits.sigma;
        let first = (run + 1).saturating_sub(of);
        let last = &values[first..=run];
        is_beyond(&values[run]) && last.iter().filter(|value| is_beyond(value)).count() >= least
    };
    let sides = [1.0, -1.0];
    let mut found = Vec::new();
    for run in 0..values.len() {
        let either = |sigmas: f64, least: usize, of: usize| {
            sides.iter().any(|side| has_run(run, *side, sigmas, least, of))
        };
        if either(3.0, 1, 1) {
            found.push((run, Signal::BeyondThreeSigma));
        }
        if rules == Rules::WesternElectric {
            for (sigmas, least, of, signal) in [
                (2.0, 2, 3, Signal::TwoOfThreeBeyondTwoSigma),
                (1.0, 4, 5, Signal::FourOfFiveBeyondOneSigma),
                (0.0, 8, 8, Signal::EightOnOneSide),
            ] {
                if either(sigmas, least, of) {
                    found.push((run, signal));
                }
            }
        }
        if run > 0 && moving_ranges[run - 1] > limits.upper_range {
            found.push((run, Signal::MovingRange));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackwright_field::random_models::Seeded;

    fn chart(values: &[f64], baseline: Option<usize>) -> ControlChart {
        control_chart(values, baseline, Rules::WesternElectric).unwrap()
    }

    /// Viscosities of a paint primer: Montgomery, 6th edition, example 6.5.
    const VISCOSITY: [f64; 15] = [
        33.75, 33.05, 34.00, 33.81, 33.46, 34.02, 33.68, 33.27, 33.49, 33.20, 33.62, 33.00, 33.54,
        33.12, 33.84,
    ];

    #[test]
    fn limits_are_the_textbooks() {
        let found = chart(&VISCOSITY, None);
        let limits = found.limits.unwrap();
        // x̄ 33.52, m̄ 0.48, limits 34.80 and 32.24, of ranges 1.57, from rounded numbers.
        for (found, expected) in [
            (limits.mean, 33.52),
            (limits.mean_range, 0.48),
            (limits.upper, 34.80),
            (limits.lower, 32.24),
            (limits.upper_range, 1.57),
        ] {
            assert!((found - expected).abs() < 0.01, "{limits:?}");
        }
        assert_eq!(found.signals, []);
    }

    #[test]
    fn each_rule_finds_its_pattern() {
        // Eight runs whose mean is 0 and mean moving range 2/√π, so that σ is 1.
        let half = 1.0 / PI.sqrt();
        let steady: Vec<f64> = (0..8).map(|run| if run % 2 == 0 { half } else { -half }).collect();
        let after = |more: &[f64], rules: Rules| {
            let values = [&steady[..], more].concat();
            let found = control_chart(&values, Some(8), rules).unwrap();
            assert!((found.limits.unwrap().sigma - 1.0).abs() < 1e-12);
            found.signals
        };
        let western = |more: &[f64]| after(more, Rules::WesternElectric);
        assert_eq!(western(&[2.9, 0.1, -2.9, 0.1]), []);
        assert_eq!(western(&[3.1]), [(8, Signal::BeyondThreeSigma)]);
        assert_eq!(western(&[2.1, 0.1, 2.1]), [(10, Signal::TwoOfThreeBeyondTwoSigma)]);
        assert_eq!(western(&[2.1, -0.1, -2.1]), []);
        let four = [-1.1, -1.1, 0.1, -1.1, -1.1];
        assert_eq!(western(&four), [(12, Signal::FourOfFiveBeyondOneSigma)]);
        let eight = [0.1; 8];
        assert_eq!(western(&eight), [(15, Signal::EightOnOneSide)]);
        let nelson = |more: &[f64]| after(more, Rules::NelsonFirst);
        assert_eq!(nelson(&[2.1, 0.1, 2.1, -0.9]), []);
        // 5.9 is more than 3.27 times the mean range of 1.13.
        let jump = [2.9, -2.9];
        assert_eq!(nelson(&jump), [(9, Signal::MovingRange)]);
    }

    #[test]
    fn runs_in_control_are_seldom_marked() {
        let mut noise = Seeded::new(11);
        let values: Vec<f64> = (0..4000).map(|_| 5.0 + 0.2 * noise.normal()).collect();
        let found = control_chart(&values, None, Rules::NelsonFirst).unwrap();
        let limits = found.limits.unwrap();
        // The mean of 4,000 has a standard error of σ/63, the mean range one of 1 % of it.
        assert!((limits.mean - 5.0).abs() < 4.0 * 0.2 / 63.0, "{limits:?}");
        assert!((limits.sigma / 0.2 - 1.0).abs() < 0.05, "{limits:?}");
        let beyond = found.signals.iter().filter(|(_, why)| *why == Signal::BeyondThreeSigma);
        // 0.27 % of 4,000 are 10.8, with a standard deviation of 3.3.
        assert!((1..25).contains(&beyond.count()));
    }

    #[test]
    fn equal_runs_are_in_control() {
        let found = chart(&[0.1; 12], None);
        assert_eq!((found.limits.unwrap().sigma, found.signals.len()), (0.0, 0));
    }

    #[test]
    fn too_few_runs_make_no_limits() {
        let few = chart(&VISCOSITY[..7], None);
        assert_eq!((few.limits, few.signals.len()), (None, 0));
        for (values, baseline, expected) in [
            (&VISCOSITY[..1], None, "found 1 runs, expected at least 2"),
            (&VISCOSITY[..], Some(7), "limits from 7 runs, expected at least 8"),
            (&VISCOSITY[..9], Some(10), "limits from the first 10 runs, found 9"),
            (&[1.0, f64::NAN][..], None, "run 1 is not finite"),
        ] {
            let error = control_chart(values, baseline, Rules::NelsonFirst).unwrap_err();
            assert_eq!(error.to_string(), expected);
        }
    }
}
