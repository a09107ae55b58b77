//! Expected figures: a mode's trials in fields drawn from what the room's measurements leave possible.

use super::drawn_trials::DrawnTrials;
use crate::metric::{METRICS, Metric, MetricValues, values_of_errors, values_of_spread};
use crate::plan::{Plan, each_trial};
use crate::run::{StudyError, check, is_rejected};
use crate::scenario::{InputTrial, Mode, Scenario};
use crate::statistics::percentile;
use crate::trial::Simulator;
use rayon::prelude::*;
use std::collections::BTreeSet;
use trackwright_field::gaussian::GaussianError;
use trackwright_task::{CancelToken, Cancelled};

/// Fields that are drawn.
pub const DRAWS: usize = 64;

/// Sensor poses at which a field is drawn: their covariance is factored, so that time grows with the
/// cube of them.
const MOST_POINTS: usize = 720;

/// Of the trials that are tried in drawn fields, the part with the largest errors in the room's own.
const EXTREME_PART: f64 = 0.25;

/// Intervals of drawn figures are widened by this on the logarithmic scale. The process has one
/// kernel and one covariance of components for the whole room; what it is wrong by from region to
/// region and from axis to axis is in no draw. Found in 24 rooms of an independent tracker (96 tools):
/// without it 70 to 80 % of the intervals hold, with it 92 to 98 %.
pub const WIDENING: f64 = 2.0;

/// Part of the drawn figures on each side of an interval.
const TAIL: f64 = 0.025;

const SEED: u64 = 20;

/// Of what sensors are off by themselves.
pub const SENSOR_SEED: u64 = 23;

/// Expected figures of a study, and 95 % intervals.
#[derive(Clone, Debug, PartialEq)]
pub struct Expected {
    /// Means over drawn fields, in the order of [`METRICS`], mm and degrees.
    pub figures: MetricValues,
    /// 95 % intervals, likewise.
    pub intervals: [[f64; 2]; METRICS.len()],
    /// In the room's own field, likewise.
    pub own: MetricValues,
    /// Part of the trials within the requirement's bound of a single tip error, where it has one.
    pub within: Option<ExpectedWithin>,
    /// Fields that were drawn.
    pub draws: usize,
    /// Trials that were tried in each.
    pub trials: usize,
    /// Sensor poses at which they were drawn.
    pub points: usize,
    /// Measurements that they are conditioned on.
    pub rows: usize,
}

/// How much of a study is to be expected within a bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExpectedWithin {
    pub limit_mm: f64,
    /// Mean over drawn fields, from 0 to 1.
    pub part: f64,
    /// 95 % interval, likewise.
    pub interval: [f64; 2],
}

/// Why there are no expected figures.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ExpectedError {
    #[error(
        "the environment {0:?} keeps no measurements to draw fields from; fit it again to know how \
         far its figures may be off"
    )]
    NoProcess(String),
    #[error("a body has markers, whose readings have no axis: drawn fields have one")]
    Markers,
    #[error(transparent)]
    Process(GaussianError),
    #[error(transparent)]
    Study(#[from] StudyError),
}

impl From<Cancelled> for ExpectedError {
    fn from(_: Cancelled) -> Self {
        Self::Study(StudyError::Cancelled)
    }
}

impl Expected {
    /// The expected value of a figure and its 95 % interval.
    pub fn of(&self, metric: Metric) -> (f64, [f64; 2]) {
        (self.figures[metric.index()], self.intervals[metric.index()])
    }

    /// The figure in the room's own field.
    pub fn own_of(&self, metric: Metric) -> f64 {
        self.own[metric.index()]
    }
}

/// The expected figures where the room has measurements to draw fields from; `None` elsewhere.
///
/// # Errors
/// [`Cancelled`].
pub fn expected_where_measured(
    scenario: &Scenario,
    mode: &Mode,
    cancel: &CancelToken,
) -> Result<Option<Expected>, Cancelled> {
    if scenario.environment.process.is_none() {
        return Ok(None);
    }
    match expected(scenario, mode, cancel) {
        Err(ExpectedError::Study(StudyError::Cancelled)) => Err(Cancelled),
        other => Ok(other.ok()),
    }
}

/// Tries a mode's trials in drawn fields: some spread over them, and those with the largest errors
/// in the room's own field. The result does not depend on the number of threads.
///
/// # Errors
/// See [`ExpectedError`].
pub fn expected(
    scenario: &Scenario,
    mode: &Mode,
    cancel: &CancelToken,
) -> Result<Expected, ExpectedError> {
    let environment = &scenario.environment;
    let process = environment
        .process
        .as_ref()
        .ok_or_else(|| ExpectedError::NoProcess(environment.name.clone()))?;
    check(scenario)?;
    let plan = Plan::new(scenario, mode)?;
    let simulator = Simulator::new(scenario);
    let own = OwnErrors::of(&plan, &simulator, scenario, cancel)?;
    let sensors = |body: &crate::body::RigidBody| body.sensors.len();
    let crf_moves =
        matches!(&plan, Plan::Input(trials) if trials.iter().any(|t| t.tracker_from_crf.is_some()));
    let crf_sensors = scenario.crf.as_ref().map_or(0, |crf| sensors(&crf.body));
    let each = sensors(&scenario.tool) + if crf_moves { crf_sensors } else { 0 };
    let most = (MOST_POINTS.saturating_sub(crf_sensors) / each.max(1)).max(1);
    let tried = own.tried(most);
    let trials: Vec<InputTrial> =
        tried.iter().map(|&i| plan.trial(scenario, own.trials[i])).collect();
    let count = trials.len();
    let drawn = DrawnTrials::new(&simulator, trials).ok_or(ExpectedError::Markers)?;
    let posterior = process.posterior(drawn.points()).map_err(ExpectedError::Process)?;
    if cancel.is_cancelled() {
        return Err(StudyError::Cancelled.into());
    }
    let fields = posterior.draws(DRAWS, SEED);
    let spread: Vec<bool> = tried.iter().map(|i| own.is_spread(*i, most)).collect();
    let bound = scenario.requirement.as_ref();
    let limit_mm = bound.and_then(|bound| Some(bound.single_position_mm()?.1));
    let part_within = |errors: &[[f64; 2]], limit_mm: f64| -> f64 {
        let kept = errors.iter().zip(&spread).filter(|(_, spread)| **spread);
        let (within, all) = kept.fold((0, 0), |(within, all), ([tip_mm, _], _)| {
            (within + u32::from(*tip_mm <= limit_mm), all + 1)
        });
        f64::from(within) / f64::from(all.max(1))
    };
    let figures_of = |errors: &[[f64; 2]]| -> Option<MetricValues> {
        let kept = errors.iter().zip(&spread).filter(|(_, spread)| **spread);
        values_of_spread(kept.map(|(errors, _)| *errors), errors.iter().copied())
    };
    let sensors = drawn.sensor_errors(process, DRAWS, SENSOR_SEED);
    let found: Option<Vec<(MetricValues, f64)>> = fields
        .par_iter()
        .zip(&sensors)
        .map(|(field, own)| {
            let errors = drawn.errors(&drawn.field_errors(field, process.trend, own));
            let part = limit_mm.map_or(0.0, |limit_mm| part_within(&errors, limit_mm));
            Some((figures_of(&errors)?, part))
        })
        .collect();
    let (figures, mut parts): (Vec<MetricValues>, Vec<f64>) =
        found.ok_or(StudyError::NoTrials)?.into_iter().unzip();
    let some = own.at(&tried);
    let (of_some, of_all) = figures_of(&some).zip(own.figures()).ok_or(StudyError::NoTrials)?;
    // The figures of the tried trials in the room's own field against those of all trials.
    let whole: MetricValues = std::array::from_fn(|k| match of_some[k] > 0.0 {
        true => (of_all[k] / of_some[k]).clamp(1.0 / MOST_SAMPLING, MOST_SAMPLING),
        false => 1.0,
    });
    let mut out = Expected {
        figures: [0.0; METRICS.len()],
        intervals: [[0.0; 2]; METRICS.len()],
        own: of_all,
        within: limit_mm.map(|limit_mm| widened_part(&mut parts, limit_mm)),
        draws: figures.len(),
        trials: count,
        points: drawn.points().len(),
        rows: posterior.rows,
    };
    for k in 0..METRICS.len() {
        let mut column: Vec<f64> = figures.iter().map(|f| f[k] * whole[k]).collect();
        (out.figures[k], out.intervals[k]) = widened(&mut column);
    }
    Ok(out)
}

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

/// Most that a sample of the trials is taken to be off from all of them.
const MOST_SAMPLING: f64 = 2.0;

/// The mean and the widened interval of a figure's drawn values.
fn widened(drawn: &mut [f64]) -> (f64, [f64; 2]) {
    let mean = drawn.iter().sum::<f64>() / drawn.len() as f64;
    if mean <= 0.0 {
        return (0.0, [0.0; 2]);
    }
    let end = |quantile: f64| mean * (quantile / mean).max(0.0).powf(WIDENING);
    let (low, high) = (percentile(drawn, TAIL), percentile(drawn, 1.0 - TAIL));
    (mean, [end(low).min(mean), end(high).max(mean)])
}

/// The mean and the widened interval of a drawn part of the trials.
fn widened_part(drawn: &mut [f64], limit_mm: f64) -> ExpectedWithin {
    let part = drawn.iter().sum::<f64>() / drawn.len().max(1) as f64;
    let end = |quantile: f64| (part + WIDENING * (quantile - part)).clamp(0.0, 1.0);
    ExpectedWithin {
        limit_mm,
        part,
        interval: [end(percentile(drawn, TAIL)), end(percentile(drawn, 1.0 - TAIL))],
    }
}

/// The errors of every trial in the room's own field; trials that are left out are not among them.
struct OwnErrors {
    /// Their numbers.
    trials: Vec<usize>,
    errors: Vec<[f64; 2]>,
}

impl OwnErrors {
    fn of(
        plan: &Plan,
        simulator: &Simulator,
        scenario: &Scenario,
        cancel: &CancelToken,
    ) -> Result<Self, StudyError> {
        let (mut trials, mut errors) = (Vec::new(), Vec::new());
        each_trial(plan, simulator, cancel, |index, trial| {
            if !is_rejected(trial, scenario.outside) {
                trials.push(index);
                errors.push([trial.tip_error_mm, trial.angle_error_deg]);
            }
        })?;
        if trials.is_empty() {
            return Err(StudyError::AllRejected { trials: plan.len() });
        }
        Ok(Self { trials, errors })
    }

    fn figures(&self) -> Option<MetricValues> {
        values_of_errors(self.errors.iter().copied())
    }

    fn at(&self, places: &[usize]) -> Vec<[f64; 2]> {
        places.iter().map(|&i| self.errors[i]).collect()
    }

    /// Places of at most `most` trials, in order: all, or some spread over them and the extremes.
    fn tried(&self, most: usize) -> Vec<usize> {
        let count = self.trials.len();
        if count <= most {
            return (0..count).collect();
        }
        let extremes = (EXTREME_PART * most as f64) as usize;
        let mut tried: BTreeSet<usize> = spread(count, most - extremes).collect();
        for component in 0..2 {
            let mut order: Vec<usize> = (0..count).collect();
            order.sort_unstable_by(|a, b| {
                let value = |i: &usize| self.errors[*i][component];
                value(b).total_cmp(&value(a)).then(a.cmp(b))
            });
            tried.extend(order.into_iter().take(extremes / 2));
        }
        tried.into_iter().collect()
    }

    /// Whether a trial is one of those that are spread over all.
    fn is_spread(&self, place: usize, most: usize) -> bool {
        let count = self.trials.len();
        let extremes = (EXTREME_PART * most as f64) as usize;
        count <= most || spread(count, most - extremes).any(|other| other == place)
    }
}

/// `some` of `count` places, spread by the golden ratio: in a grid no axis is missed, as it would be
/// by steps that are a multiple of the axis's own.
pub fn spread(count: usize, some: usize) -> impl Iterator<Item = usize> {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    (0..some.max(1)).map(move |k| {
        let part = ((k as f64 + 0.5) * GOLDEN).fract();
        ((part * count as f64) as usize).min(count - 1)
    })
}
