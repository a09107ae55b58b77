//! Whether a requirement is met, as far as a study decides it. The one place that holds a figure against a
//! bound.

use super::figure::{Basis, Figure, Figures, NoInterval, amount};
use super::figures::{FreeRotation, RoomFieldFigures};
use super::metric::{ErrorOf, Metric};
use super::run::Prepared;
use serde::ser::SerializeStruct;
use serde::{Serialize, Serializer};
use std::fmt;
use trackwright_result::with_separators;

/// What a study decides of a bound, or of all.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// The whole interval is within the bound.
    Met,
    /// The bound lies in the interval, or the study leaves open more than the room does.
    CannotTell,
    /// The whole interval is beyond it.
    Missed,
}

impl Verdict {
    /// For a person.
    pub fn label(self) -> &'static str {
        match self {
            Self::Met => "met",
            Self::Missed => "missed",
            Self::CannotTell => "cannot tell",
        }
    }

    /// What files have.
    pub fn key(self) -> &'static str {
        match self {
            Self::Met => "met",
            Self::Missed => "missed",
            Self::CannotTell => "cannot_tell",
        }
    }

    /// Several as a whole: missed where any is, met where all are; `None` without any.
    pub fn of_all(verdicts: impl Iterator<Item = Self>) -> Option<Self> {
        verdicts.max()
    }
}

/// Why a bound is not decided.
#[derive(Clone, Debug, PartialEq)]
pub enum Undecided {
    /// The interval holds the limit.
    Interval,
    /// There is no interval, or none with an upper end.
    NoInterval(NoInterval),
    /// Figures take the true rotation of a body whose sensors do not determine it.
    FreeRotation(FreeRotation),
    /// Trials were left out of the figures.
    LeftOut { trials: usize, of: usize },
    /// One pose of a range of motion has no RMS and no percentile to be held against a bound.
    OnePose,
}

impl Undecided {
    /// Whether more measurements of the room may decide it.
    pub fn is_of_room(&self) -> bool {
        *self == Self::Interval
    }

    /// Whether the study leaves it open, whatever the room's field is.
    pub fn is_of_study(&self) -> bool {
        matches!(self, Self::FreeRotation(_) | Self::LeftOut { .. })
    }
}

impl Serialize for Verdict {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.key())
    }
}

impl Serialize for Undecided {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl fmt::Display for Undecided {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Interval => f.write_str("the interval holds the limit"),
            Self::NoInterval(why) => why.fmt(f),
            Self::FreeRotation(free) => {
                write!(f, "the {}'s rotation is not determined", free.free.body_name())
            }
            Self::LeftOut { trials, of } => write!(
                f,
                "{} of {} trials were left out",
                with_separators(*trials),
                with_separators(*of)
            ),
            Self::OnePose => {
                f.write_str("one pose is not judged against a limit over the range of motion")
            }
        }
    }
}

/// A bound of a requirement against what is known of its figure.
#[derive(Clone, Debug, PartialEq)]
pub struct JudgedBound {
    pub metric: Metric,
    /// mm or degrees, as the figure is.
    pub limit: f64,
    /// `None` where no trial is in the room's field.
    pub figure: Option<Figure>,
    pub verdict: Verdict,
    /// Why it is not decided.
    pub reason: Option<Undecided>,
}

/// A requirement against what is known of its figures.
#[derive(Clone, Debug, PartialEq)]
pub struct Judgement {
    pub verdict: Verdict,
    /// One a bound, at least one.
    pub bounds: Vec<JudgedBound>,
}

impl Judgement {
    /// The first bound that is missed, else the first that is not decided, else the first.
    pub fn first(&self) -> Option<&JudgedBound> {
        self.bounds.iter().find(|bound| bound.verdict == self.verdict)
    }

    /// Why it is not decided; `None` where it is.
    pub fn reason(&self) -> Option<&Undecided> {
        let reason = || self.bounds.iter().find_map(|bound| bound.reason.as_ref());
        if self.verdict == Verdict::CannotTell { reason() } else { None }
    }

    /// The bound on a figure.
    pub fn bound(&self, metric: Metric) -> Option<&JudgedBound> {
        self.bounds.iter().find(|bound| bound.metric == metric)
    }
}

impl Serialize for Judgement {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut out = serializer.serialize_struct("Judgement", 3)?;
        out.serialize_field("verdict", &self.verdict)?;
        out.serialize_field("reason", &self.reason())?;
        out.serialize_field("checks", &self.bounds)?;
        out.end()
    }
}

impl Serialize for JudgedBound {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let figure = self.figure.as_ref();
        let mut out = serializer.serialize_struct("JudgedBound", 7)?;
        out.serialize_field("figure", &self.metric)?;
        out.serialize_field("limit", &self.limit)?;
        out.serialize_field("value", &figure.map(|figure| figure.value))?;
        out.serialize_field("low", &figure.and_then(|figure| figure.low))?;
        out.serialize_field("high", &figure.and_then(|figure| figure.high))?;
        out.serialize_field("verdict", &self.verdict)?;
        out.serialize_field("reason", &self.reason)?;
        out.end()
    }
}

/// Decimals of a figure and its limit: where they are nearly equal there are more.
const LEAST_DECIMALS: usize = 2;
const MOST_DECIMALS: usize = 6;

impl JudgedBound {
    /// The verdict for a person, with its reason where it is not decided.
    pub fn label(&self) -> String {
        match &self.reason {
            Some(why) => format!("{}: {why}", self.verdict.label()),
            None => self.verdict.label().to_owned(),
        }
    }

    /// The verdict with figure and limit: `met: 0.44 mm (95 %: 0.40 to 0.61), limit 1 mm`.
    pub fn words(&self, decimals: usize, space: &str) -> String {
        let figure = self.figure.map(|figure| figure.words(decimals, space));
        let figure = figure.map_or_else(String::new, |figure| format!("{figure}, "));
        let over = self.over_words(space).map_or_else(String::new, |over| format!(", {over} over"));
        let before = if self.verdict == Verdict::CannotTell { "; " } else { ": " };
        let unit = self.metric.unit();
        let space = if self.metric.of == ErrorOf::Angle { "" } else { space };
        format!("{}{before}{figure}limit {}{space}{unit}{over}", self.label(), self.limit)
    }

    /// By how much a bound is missed, with this before the unit: `missed: 0.44 mm, limit 0.30 mm, 0.14 mm
    /// over`; `None` where it is not missed. There are two decimals, and as many more as show that the
    /// figure is over.
    pub fn missed_words(&self, space: &str) -> Option<String> {
        let over = self.over_words(space)?;
        let [value, limit] = [self.figure?.value, self.limit].map(|v| self.amount(v, space));
        Some(format!("missed: {value}, limit {limit}, {over} over"))
    }

    /// By how much a figure is over its bound, with the same digits; `None` where it is not missed.
    pub fn over_words(&self, space: &str) -> Option<String> {
        let is_missed = self.verdict == Verdict::Missed;
        is_missed.then_some(self.amount(self.figure?.value - self.limit, space))
    }

    fn amount(&self, value: f64, space: &str) -> String {
        let over = self.figure.map_or(0.0, |figure| (figure.value - self.limit).abs());
        let decimals = (LEAST_DECIMALS..MOST_DECIMALS)
            .find(|decimals| over >= 0.5 * 0.1_f64.powi(*decimals as i32))
            .unwrap_or(MOST_DECIMALS);
        amount(self.metric, value, decimals, space)
    }
}

/// Holds each bound against the interval of its figure. None is met that an undetermined rotation, a trial
/// that was left out, or a sensor where the room states no field may break.
pub(super) fn judge(
    prepared: &Prepared,
    room_field: &RoomFieldFigures,
    figures: &Figures,
) -> Option<Judgement> {
    let requirement = prepared.scenario.requirement.as_ref()?;
    let unsettled = unsettled(room_field);
    let each = requirement.bounds().map(|(metric, limit)| {
        let figure = figures.get(metric).copied();
        let (verdict, reason) = match prepared.scenario.judges(prepared.mode, metric) {
            true => judged(metric, limit, figures, unsettled.as_ref()),
            false => (Verdict::CannotTell, Some(Undecided::OnePose)),
        };
        JudgedBound { metric, limit, figure, verdict, reason }
    });
    let bounds: Vec<JudgedBound> = each.collect();
    let verdict = Verdict::of_all(bounds.iter().map(|bound| bound.verdict))?;
    Some(Judgement { verdict, bounds })
}

fn judged(
    metric: Metric,
    limit: f64,
    figures: &Figures,
    unsettled: Option<&(Undecided, f64)>,
) -> (Verdict, Option<Undecided>) {
    let no_interval = || figures.no_interval.clone().map(Undecided::NoInterval);
    let Some(figure) = figures.get(metric) else {
        return (Verdict::CannotTell, no_interval());
    };
    // A model that is taken for the field itself leaves nothing open.
    let is_exact = figures.basis == Basis::Assumed;
    let end = |end: Option<f64>| if is_exact { Some(figure.value) } else { end };
    let (low, high) = (end(figure.low), end(figure.high));
    let is_met = high.is_some_and(|high| high <= limit);
    if low.is_some_and(|low| low > limit) {
        return (Verdict::Missed, None);
    }
    // An angle error has no bound but half a turn.
    let may_break = |most_mm: f64| {
        metric.of == ErrorOf::Angle || high.is_none_or(|high| high + most_mm > limit)
    };
    if let Some((why, _)) = unsettled.filter(|(_, most_mm)| may_break(*most_mm)) {
        return (Verdict::CannotTell, Some(why.clone()));
    }
    match is_met {
        true => (Verdict::Met, None),
        false => {
            let has_interval = low.is_some() && high.is_some();
            let why = if has_interval { None } else { no_interval() };
            (Verdict::CannotTell, Some(why.unwrap_or(Undecided::Interval)))
        }
    }
}

/// Why figures within their bounds do not show that the requirement is met, and the most that a tip error
/// may be larger than they state, mm.
pub(super) fn unsettled(room_field: &RoomFieldFigures) -> Option<(Undecided, f64)> {
    let free = room_field.free_axis.filter(FreeRotation::reaches_tip);
    let left_out = || {
        let of = Undecided::LeftOut { trials: room_field.rejected, of: room_field.trials };
        (room_field.rejected > 0).then_some((of, f64::INFINITY))
    };
    free.map(|free| (Undecided::FreeRotation(free), 2.0 * free.reach_mm)).or_else(left_out)
}
