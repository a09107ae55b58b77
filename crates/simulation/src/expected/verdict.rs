//! Whether a requirement is met, as far as a room determines it.

use super::figures::Expected;
use crate::figures::{Figures, Unsettled};
use crate::metric::{ErrorOf, Metric};
use crate::requirement::Check;
use serde::Serialize;

/// What a study settles of a bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum BoundVerdict {
    /// The whole interval is within the bound.
    Met,
    /// The whole interval is beyond it.
    Missed,
    /// The bound lies in the interval, or the study leaves open more than the room does.
    CannotTell,
}

impl BoundVerdict {
    /// For a person.
    pub fn label(self) -> &'static str {
        match self {
            Self::Met => "met",
            Self::Missed => "missed",
            Self::CannotTell => "cannot tell",
        }
    }

    /// `None` where the room leaves it undetermined.
    pub fn is_met(self) -> Option<bool> {
        match self {
            Self::Met => Some(true),
            Self::Missed => Some(false),
            Self::CannotTell => None,
        }
    }
}

/// A bound of a requirement against what is known of its figure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct JudgedBound {
    #[serde(rename = "name")]
    pub metric: Metric,
    /// mm or degrees, as the figure is.
    pub limit: f64,
    /// The expected value; that of the room's own field where nothing more is known.
    pub value: f64,
    /// 95 % interval, where the room has one.
    pub interval: Option<[f64; 2]>,
    pub verdict: BoundVerdict,
    /// Why there is no verdict, where it is not the room.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unsettled: Option<Unsettled>,
}

impl JudgedBound {
    /// The verdict for a person, with its reason where it is undetermined.
    pub fn label(&self) -> String {
        match (self.verdict, &self.unsettled) {
            (BoundVerdict::CannotTell, Some(why)) => format!("cannot tell: {why}"),
            (BoundVerdict::CannotTell, None) => "cannot tell in this room".to_owned(),
            (verdict, _) => verdict.label().to_owned(),
        }
    }

    /// By how much a bound is missed, with this before the unit: `Not met: 0.44 mm, limit 0.30 mm, 0.14 mm
    /// over`; `None` where it is not missed. There are two decimals, and as many more as show that the
    /// figure is over.
    ///
    /// ```
    /// use trackwright_simulation::Metric;
    /// use trackwright_simulation::expected::judged_checks;
    /// use trackwright_simulation::requirement::Check;
    /// let check = Check { metric: Metric::TIP_RMS, value: 0.44, limit: 0.3, met: false };
    /// let bound = judged_checks(&[check], None, None)[0];
    /// assert_eq!(bound.missed_words(" ").unwrap(), "Not met: 0.44 mm, limit 0.30 mm, 0.14 mm over");
    /// ```
    pub fn missed_words(&self, space: &str) -> Option<String> {
        let over = self.over_words(space)?;
        let [value, limit] = [self.value, self.limit].map(|value| self.amount(value, space));
        Some(format!("Not met: {value}, limit {limit}, {over} over"))
    }

    /// By how much a figure is over its bound, with the same digits; `None` where it is not missed.
    pub fn over_words(&self, space: &str) -> Option<String> {
        let is_missed = self.verdict == BoundVerdict::Missed;
        is_missed.then(|| self.amount(self.value - self.limit, space))
    }

    fn amount(&self, value: f64, space: &str) -> String {
        let over = (self.value - self.limit).abs();
        let decimals = (LEAST_DECIMALS..MOST_DECIMALS)
            .find(|decimals| over >= 0.5 * 0.1_f64.powi(*decimals as i32))
            .unwrap_or(MOST_DECIMALS);
        let space = if self.metric.of == ErrorOf::Angle { "" } else { space };
        format!("{value:.decimals$}{space}{}", self.metric.unit())
    }
}

/// Decimals of a figure and its limit: where they are nearly equal there are more.
const LEAST_DECIMALS: usize = 2;
const MOST_DECIMALS: usize = 6;

/// Each bound, in the order of its checks: against the interval of its figure where there is one, else
/// against the figure of the room's own field. None is met that an undetermined rotation or a trial
/// that was left out may break.
pub fn judged(figures: &Figures, expected: Option<&Expected>) -> Vec<JudgedBound> {
    judged_checks(&figures.checks, figures.unsettled(), expected)
}

/// The same of checks by themselves.
pub fn judged_checks(
    checks: &[Check],
    unsettled: Option<Unsettled>,
    expected: Option<&Expected>,
) -> Vec<JudgedBound> {
    let each = checks.iter().map(|check| {
        let metric = check.metric;
        let found = expected.map(|expected| expected.of(metric));
        let verdict = match found {
            Some((_, [_, high])) if high <= check.limit => BoundVerdict::Met,
            Some((_, [low, _])) if low > check.limit => BoundVerdict::Missed,
            Some(_) => BoundVerdict::CannotTell,
            None if check.met => BoundVerdict::Met,
            None => BoundVerdict::Missed,
        };
        let highest = found.map_or(check.value, |(_, [_, high])| high);
        // An angle error has no bound but half a turn.
        let unsettled = unsettled.filter(|why| {
            verdict != BoundVerdict::Missed
                && (metric.of == ErrorOf::Angle || highest + why.most_mm() > check.limit)
        });
        let verdict = match unsettled {
            None => verdict,
            Some(_) => BoundVerdict::CannotTell,
        };
        JudgedBound {
            metric,
            limit: check.limit,
            value: found.map_or(check.value, |(value, _)| value),
            interval: found.map(|(_, interval)| interval),
            verdict,
            unsettled,
        }
    });
    each.collect()
}

/// A requirement and the figures of the room's own field, for a program.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RequirementFigures {
    /// `None` where it is undetermined.
    pub met: Option<bool>,
    pub checks: Vec<SettledCheck>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unsettled: Option<Unsettled>,
}

/// One bound of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SettledCheck {
    #[serde(rename = "name")]
    pub metric: Metric,
    pub value: f64,
    pub limit: f64,
    pub met: Option<bool>,
}

/// The requirement of a study in the room's own field; `None` without one.
pub fn requirement_figures(figures: &Figures) -> Option<RequirementFigures> {
    let bounds = judged(figures, None);
    Some(RequirementFigures {
        met: verdict_of(&bounds)?.is_met(),
        unsettled: bounds.iter().find_map(|bound| bound.unsettled),
        checks: bounds
            .iter()
            .map(|bound| SettledCheck {
                metric: bound.metric,
                value: bound.value,
                limit: bound.limit,
                met: bound.verdict.is_met(),
            })
            .collect(),
    })
}

/// Several as a whole: missed where any is, met where all are; `None` without any.
pub fn verdict_of_all(verdicts: impl Iterator<Item = BoundVerdict>) -> Option<BoundVerdict> {
    let weight = |verdict: &BoundVerdict| match verdict {
        BoundVerdict::Met => 0,
        BoundVerdict::CannotTell => 1,
        BoundVerdict::Missed => 2,
    };
    verdicts.max_by_key(weight)
}

/// A requirement as a whole; `None` without bounds.
pub fn verdict_of(bounds: &[JudgedBound]) -> Option<BoundVerdict> {
    verdict_of_all(bounds.iter().map(|bound| bound.verdict))
}

/// The same of a study.
pub fn study_verdict(figures: &Figures, expected: Option<&Expected>) -> Option<BoundVerdict> {
    verdict_of(&judged(figures, expected))
}

/// The one figure that counts: the first bound that is missed, else the first that is undetermined,
/// else the first, else the RMS of the tip error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Headline {
    pub metric: Metric,
    /// Expected where the room has it, else of its own field; mm or degrees.
    pub value: f64,
    /// 95 % interval, where the room has one.
    pub interval: Option<[f64; 2]>,
    /// The bound on it.
    pub bound: Option<JudgedBound>,
}

/// The one figure that counts.
pub fn headline(figures: &Figures, expected: Option<&Expected>) -> Headline {
    let bounds = judged(figures, expected);
    let of = |verdict| bounds.iter().find(|bound| bound.verdict == verdict);
    let first = of(BoundVerdict::Missed)
        .or_else(|| of(BoundVerdict::CannotTell))
        .or_else(|| bounds.first());
    if let Some(bound) = first {
        return Headline {
            metric: bound.metric,
            value: bound.value,
            interval: bound.interval,
            bound: Some(*bound),
        };
    }
    let metric = Metric::TIP_RMS;
    let found = expected.map(|expected| expected.of(metric));
    Headline {
        metric,
        value: found.map_or(figures.value(metric), |(value, _)| value),
        interval: found.map(|(_, interval)| interval),
        bound: None,
    }
}
