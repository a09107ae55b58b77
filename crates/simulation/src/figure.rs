//! What is known of a study's figures: each value that is to be expected, the interval that holds it with
//! 95 %, and what both rest on. Made here, and judged in [`judgement`](super::judgement); whoever shows a
//! figure takes it from here.

use super::expected::{Expected, ExpectedError, expected_of};
use super::judgement::{Judgement, judge};
use super::metric::{ErrorOf, METRICS, Metric};
use super::run::{Outcome, Prepared, StudyError, TrialErrors};
use serde::{Serialize, Serializer};
use std::fmt;
use trackwright_field::Environment;
use trackwright_result::with_separators;
use trackwright_task::CancelToken;

/// One figure of a study, in the metric's unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figure {
    pub metric: Metric,
    /// What is to be expected.
    pub value: f64,
    /// Ends of the 95 % interval; `None` where nothing bounds the figure on that side, which
    /// [`Figures::no_interval`] gives the reason of.
    pub low: Option<f64>,
    pub high: Option<f64>,
}

impl Figure {
    /// The value with so many decimals, without its unit.
    pub fn value_text(&self, decimals: usize) -> String {
        format!("{:.decimals$}", self.value)
    }

    /// The value with its unit: `0.44 mm`, `0.30°`.
    pub fn amount(&self, decimals: usize, space: &str) -> String {
        amount(self.metric, self.value, decimals, space)
    }

    /// Its 95 % interval without the unit: `0.40 to 0.61`, `at least 0.40`; `None` where nothing is known.
    pub fn interval_text(&self, decimals: usize) -> Option<String> {
        match (self.low, self.high) {
            (Some(low), Some(high)) => Some(format!("{low:.decimals$} to {high:.decimals$}")),
            (Some(low), None) => Some(format!("at least {low:.decimals$}")),
            (None, _) => None,
        }
    }

    /// Both in a line: `0.44 mm (95 %: 0.40 to 0.61)`, `0.44 mm (no interval)`.
    pub fn words(&self, decimals: usize, space: &str) -> String {
        let amount = self.amount(decimals, space);
        match self.interval_text(decimals) {
            Some(interval) => format!("{amount} (95{space}%: {interval})"),
            None => format!("{amount} (no interval)"),
        }
    }
}

/// A value of a metric with its unit; a degree sign follows its number closely.
pub(super) fn amount(metric: Metric, value: f64, decimals: usize, space: &str) -> String {
    let space = if metric.of == ErrorOf::Angle { "" } else { space };
    format!("{value:.decimals$}{space}{}", metric.unit())
}

/// What figures rest on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Basis {
    /// The measurements of the room.
    Measured,
    /// Measurements, and metal that was solved for.
    Metal,
    /// Metal that was solved for, in a room that nobody measured.
    Simulated,
    /// Sensors are where the room states no field, in some of the trials at least.
    Outside,
    /// A model of the field that states no measurements: it is taken for the field itself.
    Assumed,
}

impl Serialize for Basis {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.key())
    }
}

impl Basis {
    /// Of trials that are all where the room states its field.
    fn of(environment: &Environment) -> Self {
        let is_measured = environment.provenance.is_some() || environment.process.is_some();
        match (is_measured, environment.metal.is_some()) {
            (true, false) => Self::Measured,
            (true, true) => Self::Metal,
            (false, true) => Self::Simulated,
            (false, false) => Self::Assumed,
        }
    }

    /// What files have.
    pub fn key(self) -> &'static str {
        match self {
            Self::Measured => "measured",
            Self::Metal => "metal",
            Self::Simulated => "simulated",
            Self::Outside => "outside",
            Self::Assumed => "assumed",
        }
    }

    /// In a line, for a person.
    pub fn words(self) -> &'static str {
        match self {
            Self::Measured => "from the measurements of the room",
            Self::Metal => "from the measurements of the room and the metal that was solved for",
            Self::Simulated => "from the metal that was solved for; the room was not measured",
            Self::Outside => "partly or wholly where the room states no field",
            Self::Assumed => "the room states no measurements: its model is taken for the field",
        }
    }
}

/// Why figures have no interval, or one without an upper end.
#[derive(Clone, Debug, PartialEq)]
pub enum NoInterval {
    /// A sensor is where the room states no field, in so many trials of all; in so many of them in metal.
    Outside { trials: usize, in_metal: usize, of: usize },
    /// The model is taken for the field itself.
    Assumed,
    /// The room was measured and cannot state how far it may be off.
    NoneDrawn(ExpectedError),
}

impl fmt::Display for NoInterval {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Outside { trials, in_metal, of } => {
                let [trials, metal, of] = [*trials, *in_metal, *of].map(with_separators);
                match in_metal {
                    0 => write!(
                        f,
                        "in {trials} of {of} trials a sensor is outside the measured region or the tracker's volume"
                    ),
                    _ if metal == trials => {
                        write!(
                            f,
                            "in {trials} of {of} trials a sensor is in metal, where it has no reading"
                        )
                    }
                    _ => write!(
                        f,
                        "in {trials} of {of} trials a sensor is outside the measured region or the tracker's \
                         volume, or in metal ({metal} in metal)"
                    ),
                }
            }
            Self::Assumed => f.write_str(Basis::Assumed.words()),
            Self::NoneDrawn(why) => why.fmt(f),
        }
    }
}

/// How much of a study is within the bound that each trial is held against.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartWithin {
    pub metric: Metric,
    pub limit_mm: f64,
    /// What is to be expected, from 0 to 1.
    pub part: f64,
    /// 95 % interval, likewise.
    pub interval: Option<[f64; 2]>,
}

/// What the drawn fields of a study were.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DrawnFields {
    pub draws: usize,
    /// Trials that were tried in each.
    pub trials: usize,
    /// Sensor poses at which they were drawn.
    pub points: usize,
    /// Measurements that they are conditioned on.
    pub rows: usize,
}

/// All that is known of a study's figures.
#[derive(Clone, Debug, PartialEq)]
pub struct Figures {
    pub basis: Basis,
    /// One each of [`METRICS`]; none where no trial is in the room's field.
    pub all: Vec<Figure>,
    /// Why there is no interval, where there is none.
    pub no_interval: Option<NoInterval>,
    pub within: Option<PartWithin>,
    /// The requirement as far as it is decided; `None` without one.
    pub requirement: Option<Judgement>,
    pub drawn: Option<DrawnFields>,
}

impl Figures {
    /// What is known of a study that was run.
    ///
    /// # Errors
    /// [`StudyError::Cancelled`].
    pub(super) fn of(
        prepared: &Prepared,
        outcome: &Outcome,
        errors: &TrialErrors,
        cancel: &CancelToken,
    ) -> Result<Self, StudyError> {
        let (room_field, environment) = (&outcome.room_field, &prepared.scenario.environment);
        let outside = NoInterval::Outside {
            trials: room_field.without_field,
            in_metal: room_field.in_metal,
            of: room_field.trials,
        };
        let is_all = |places: &[u32]| places.len() == errors.errors.len();
        let is_outside = !errors.without_field.is_empty();
        let basis = match is_outside || room_field.without_field > 0 {
            true => Basis::Outside,
            false => Basis::of(environment),
        };
        let (all, no_interval, within, drawn) = if is_all(&errors.without_field) {
            (Vec::new(), Some(outside), None, None)
        } else {
            let (known, why_none) = match expected_of(prepared, outcome, errors, cancel) {
                Ok(known) => (known, None),
                Err(ExpectedError::Study(error)) => return Err(error),
                Err(ExpectedError::NothingDrawn(_)) if Basis::of(environment) == Basis::Assumed => {
                    (Expected::assumed(prepared, outcome, errors), Some(NoInterval::Assumed))
                }
                Err(why) => {
                    let own = Expected::assumed(prepared, outcome, errors);
                    (own, Some(NoInterval::NoneDrawn(why)))
                }
            };
            let is_known = !matches!(why_none, Some(NoInterval::NoneDrawn(_)));
            let why_none = if is_outside && is_known { Some(outside) } else { why_none };
            let has_interval = is_known && why_none != Some(NoInterval::Assumed);
            let figure = |metric: Metric| {
                let (value, [low, high]) = known.of(metric);
                Figure {
                    metric,
                    value,
                    low: has_interval.then_some(low),
                    high: Some(high).filter(|high| has_interval && high.is_finite()),
                }
            };
            let within = known.within.map(|within| PartWithin {
                metric: within.metric,
                limit_mm: within.limit_mm,
                part: within.part,
                interval: has_interval.then_some(within.interval),
            });
            let drawn = (known.draws > 0).then_some(DrawnFields {
                draws: known.draws,
                trials: known.trials,
                points: known.points,
                rows: known.rows,
            });
            (METRICS.map(figure).to_vec(), why_none, within, drawn)
        };
        let mut figures = Self { basis, all, no_interval, within, requirement: None, drawn };
        figures.requirement = judge(prepared, room_field, &figures);
        Ok(figures)
    }

    /// A figure; `None` where no trial is in the room's field.
    pub fn get(&self, metric: Metric) -> Option<&Figure> {
        self.all.get(metric.index())
    }

    /// Those that a requirement can be about.
    pub fn bounded(&self) -> impl Iterator<Item = &Figure> {
        Metric::bounded().filter_map(|metric| self.get(metric))
    }

    /// The one figure that counts: that of the first bound that is missed, else of the first that is not
    /// decided, else of the first, else the RMS of the tip error.
    pub fn headline(&self) -> Option<&Figure> {
        let first = self.requirement.as_ref().and_then(Judgement::first);
        self.get(first.map_or(Metric::TIP_RMS, |bound| bound.metric))
    }
}
