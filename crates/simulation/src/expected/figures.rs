//! Expected figures: a mode's trials in fields drawn from what the room leaves possible.

use super::drawn_trials::DrawnTrials;
use crate::metric::{METRICS, Metric, MetricValues, values_of_spread};
use crate::plan::Plan;
use crate::run::{Outcome, Prepared, StudyError, TrialErrors};
use crate::scenario::{InputTrial, Mode, Scenario};
use crate::spread::spread;
use crate::statistics::percentile;
use crate::tool_in_crf::ErrorVectors;
use rayon::prelude::*;
use std::collections::BTreeSet;
use trackwright_field::gaussian::GaussianError;
use trackwright_task::{CancelToken, Cancelled};

/// Fields that are drawn at [`MOST_POINTS`] sensor poses. At fewer poses there are as many more as cost no
/// more, up to the second: the fewer trials a figure is of, the more it differs from field to field, and the
/// more fields the ends of its interval need.
const DRAWS: [usize; 2] = [128, 512];

/// Sensor poses at which a field is drawn: so many that the figures follow a hand, some ten milliseconds on
/// two cores. In the same time, more fields at fewer poses make the ends of intervals steadier: along a way of
/// the built-in tools, 128 fields at 180 poses scatter by half as much as 64 at 360.
const MOST_POINTS: usize = 180;

/// Of the trials that are tried in drawn fields, the part with the largest errors in the room's own.
const EXTREME_PART: f64 = 0.25;

/// Intervals of drawn figures are widened by this on the logarithmic scale. The process has one
/// kernel and one covariance of components for the whole room; what it is wrong by from region to
/// region and from axis to axis is in no draw. Found in 24 rooms of an independent tracker (96 tools):
/// without it 70 to 80 % of the intervals hold, with it 92 to 98 %.
pub const WIDENING: f64 = 2.0;

/// Part of the drawn figures on each side of an interval, and how many standard deviations of a normal
/// distribution leave as much.
const TAIL: f64 = 0.025;
const HALF_WIDTH: f64 = 1.959_963_984_540_054;

const SEED: u64 = 20;

/// Tip errors in mm and angles in degrees that stand for what may be anything: larger than any bound.
const ANYTHING: [f64; 2] = [1e9, 1e9];

/// Ends of intervals beyond this are none.
const MOST: f64 = 1e6;

/// Expected figures of a study, and 95 % intervals.
#[derive(Clone, Debug, PartialEq)]
pub struct Expected {
    /// Medians of what the figures may be, in the order of [`METRICS`], mm and degrees.
    pub figures: MetricValues,
    /// 95 % intervals, likewise. Their ends are those of figures in which trials where the room states no
    /// field have no error, and any; the upper one is infinite where that is not bounded.
    pub intervals: [[f64; 2]; METRICS.len()],
    /// The same with the errors that are drawn where the room states no field: for maps, which go on there.
    pub continued: [[f64; 2]; METRICS.len()],
    /// By the room's model alone, likewise.
    pub own: MetricValues,
    /// Part of the trials within the requirement's bound of a single tip error, where it has one.
    pub within: Option<ExpectedWithin>,
    /// Fields that were drawn; none where the room's model alone is taken for the only one.
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
    pub metric: Metric,
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
    NothingDrawn(String),
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

    /// The figure by the room's model alone.
    pub fn own_of(&self, metric: Metric) -> f64 {
        self.own[metric.index()]
    }

    /// Those of the room's model alone, taken for the only one there is.
    pub(crate) fn assumed(prepared: &Prepared, outcome: &Outcome, errors: &TrialErrors) -> Self {
        let own = outcome.room_field.values();
        let all: Vec<usize> = (0..errors.errors.len()).collect();
        let trials =
            TriedTrials { is_known: known(errors, &all), is_spread: vec![true; all.len()] };
        let ends = trials.figures(&errors.errors).unwrap_or([own; 3]);
        let bound = prepared.single_bound();
        Self {
            figures: own,
            intervals: std::array::from_fn(|k| [ends[1][k], bounded(ends[2][k])]),
            continued: own.map(|value| [value; 2]),
            own,
            within: bound.map(|(metric, limit_mm)| {
                let [part, low, high] = trials.parts_within(&errors.errors, limit_mm);
                ExpectedWithin { metric, limit_mm, part, interval: [low, high] }
            }),
            draws: 0,
            trials: all.len(),
            points: 0,
            rows: 0,
        }
    }
}

/// Tries a mode's trials in drawn fields: some spread over them, and those with the largest errors
/// by the room's model alone. The result does not depend on the number of threads.
///
/// # Errors
/// See [`ExpectedError`].
pub fn expected(
    scenario: &Scenario,
    mode: &Mode,
    cancel: &CancelToken,
) -> Result<Expected, ExpectedError> {
    let prepared = Prepared::new(scenario, mode)?;
    prepared.states_uncertainty()?;
    let (outcome, errors) = prepared.run(cancel, None)?;
    expected_of(&prepared, &outcome, &errors, cancel)
}

/// The same of a study that was run.
///
/// # Errors
/// See [`ExpectedError`].
pub(crate) fn expected_of(
    prepared: &Prepared,
    outcome: &Outcome,
    errors: &TrialErrors,
    cancel: &CancelToken,
) -> Result<Expected, ExpectedError> {
    prepared.states_uncertainty()?;
    let Prepared { scenario, plan, simulator, .. } = prepared;
    let environment = &scenario.environment;
    let sensors = |body: &crate::body::RigidBody| body.sensors.len();
    let crf_moves =
        matches!(plan, Plan::Input(trials) if trials.iter().any(|t| t.tracker_from_crf.is_some()));
    let crf_sensors = scenario.crf.as_ref().map_or(0, |crf| sensors(&crf.body));
    let each = sensors(&scenario.tool) + if crf_moves { crf_sensors } else { 0 };
    let most = (MOST_POINTS.saturating_sub(crf_sensors) / each.max(1)).max(1);
    let (tried, is_spread) = tried(plan, errors, most);
    let numbers: Vec<usize> = tried.iter().map(|&place| errors.number(place)).collect();
    let trials: Vec<InputTrial> = numbers.iter().map(|&i| plan.trial(scenario, i)).collect();
    let count = trials.len();
    let drawn = DrawnTrials::new(simulator, environment, trials).ok_or(ExpectedError::Markers)?;
    let draws = draws_at(drawn.points().len());
    let fields = drawn.fields(draws, SEED).map_err(ExpectedError::Process)?;
    if cancel.is_cancelled() {
        return Err(StudyError::Cancelled.into());
    }
    let trials = TriedTrials { is_known: known(errors, &tried), is_spread };
    let bound = prepared.single_bound();
    let found: Option<Vec<([MetricValues; 3], [f64; 3])>> = (0..draws)
        .into_par_iter()
        .map(|draw| {
            let errors = match prepared.less {
                None => drawn.errors(&fields.errors(&drawn, draw)),
                Some(less) => {
                    let mut vectors = drawn.error_vectors(&fields.errors(&drawn, draw));
                    less(&numbers, &mut vectors);
                    vectors.iter().map(ErrorVectors::sizes).collect()
                }
            };
            let parts = bound.map_or([0.0; 3], |bound| trials.parts_within(&errors, bound.1));
            Some((trials.figures(&errors)?, parts))
        })
        .collect();
    let (figures, parts): (Vec<[MetricValues; 3]>, Vec<[f64; 3]>) =
        found.ok_or(StudyError::NoTrials)?.into_iter().unzip();
    let of_all = outcome.room_field.values();
    let [of_some, ..] = trials.figures(&errors.at(&tried)).ok_or(StudyError::NoTrials)?;
    // What the tried trials leave out of all, as far as the room's model alone has it: in squares, as what the
    // measurements leave open is added in squares and differs little from trial to trial.
    let whole: MetricValues = std::array::from_fn(|k| {
        let mean = figures.iter().map(|f| f[0][k]).sum::<f64>() / figures.len() as f64;
        let left_out = of_all[k] * of_all[k] - of_some[k] * of_some[k];
        match mean > 0.0 {
            true => (1.0 + left_out / (mean * mean))
                .max(0.0)
                .sqrt()
                .clamp(1.0 / MOST_SAMPLING, MOST_SAMPLING),
            false => 1.0,
        }
    });
    // What a process is wrong by is in no draw; what is not known of metal is in all of them.
    let widening = if environment.process.is_some() { WIDENING } else { 1.0 };
    let mut out = Expected {
        figures: [0.0; METRICS.len()],
        intervals: [[0.0; 2]; METRICS.len()],
        continued: [[0.0; 2]; METRICS.len()],
        own: of_all,
        within: bound.map(|(metric, limit_mm)| {
            let [(part, [low, high]), (_, [low_least, _]), (_, [_, high_most])] =
                [0, 1, 2].map(|k| widened_part(parts.iter().map(|p| p[k]).collect(), widening));
            // Where nothing is known all may be beyond the bound, or within it.
            let interval = [low.min(low_least), high.max(high_most)];
            ExpectedWithin { metric, limit_mm, part, interval }
        }),
        draws: figures.len(),
        trials: count,
        points: drawn.points().len(),
        rows: fields.rows(),
    };
    for k in 0..METRICS.len() {
        let column = |of: usize| -> (f64, [f64; 2]) {
            widened(figures.iter().map(|f| f[of][k] * whole[k]).collect(), widening)
        };
        (out.figures[k], out.continued[k]) = column(0);
        let ends = out.continued[k];
        out.intervals[k] = match trials.are_all_known() {
            true => ends,
            false => [column(1).1[0], bounded(column(2).1[1])],
        };
    }
    Ok(out)
}

/// How many fields are drawn at so many sensor poses.
fn draws_at(points: usize) -> usize {
    let [least, most] = DRAWS;
    (least * (MOST_POINTS / points.max(1))).clamp(least, most)
}

/// An end of an interval that means something.
fn bounded(end: f64) -> f64 {
    if end > MOST { f64::INFINITY } else { end }
}

fn known(errors: &TrialErrors, places: &[usize]) -> Vec<bool> {
    places.iter().map(|place| errors.is_known(*place)).collect()
}

/// Trials that stand for a study.
struct TriedTrials {
    /// Whether the room states its field at each.
    is_known: Vec<bool>,
    /// Whether each is one of those that are spread over all; the others count for extremes alone.
    is_spread: Vec<bool>,
}

impl TriedTrials {
    fn are_all_known(&self) -> bool {
        self.is_known.iter().all(|is_known| *is_known)
    }

    /// The errors as they are, and with none and with any where the room states no field.
    fn each(&self, errors: &[[f64; 2]]) -> [Vec<[f64; 2]>; 3] {
        let with = |other: Option<[f64; 2]>| -> Vec<[f64; 2]> {
            let each = errors.iter().zip(&self.is_known);
            each.map(|(error, is_known)| other.filter(|_| !is_known).unwrap_or(*error)).collect()
        };
        [with(None), with(Some([0.0; 2])), with(Some(ANYTHING))]
    }

    /// The figures of errors as they are, with none and with any where the room states no field.
    fn figures(&self, errors: &[[f64; 2]]) -> Option<[MetricValues; 3]> {
        let figures = |errors: &[[f64; 2]]| {
            let kept = errors.iter().zip(&self.is_spread).filter(|(_, is_spread)| **is_spread);
            values_of_spread(kept.map(|(errors, _)| *errors), errors.iter().copied())
        };
        if self.are_all_known() {
            return Some([figures(errors)?; 3]);
        }
        let [own, least, most] = self.each(errors);
        Some([figures(&own)?, figures(&least)?, figures(&most)?])
    }

    /// Parts of the trials within a bound, likewise, the least before the most.
    fn parts_within(&self, errors: &[[f64; 2]], limit_mm: f64) -> [f64; 3] {
        let part = |errors: &[[f64; 2]]| {
            let kept = errors.iter().zip(&self.is_spread).filter(|(_, is_spread)| **is_spread);
            let (within, all) = kept.fold((0, 0), |(within, all), ([tip_mm, _], _)| {
                (within + u32::from(*tip_mm <= limit_mm), all + 1)
            });
            f64::from(within) / f64::from(all.max(1))
        };
        if self.are_all_known() {
            return [part(errors); 3];
        }
        let [own, least, most] = self.each(errors);
        // Errors of any size are beyond the bound.
        [part(&own), part(&most), part(&least)]
    }
}

impl Prepared<'_> {
    /// # Errors
    /// [`ExpectedError::NothingDrawn`] in a room that states nothing to draw fields from.
    fn states_uncertainty(&self) -> Result<(), ExpectedError> {
        let environment = &self.scenario.environment;
        match environment.states_uncertainty() {
            true => Ok(()),
            false => Err(ExpectedError::NothingDrawn(environment.name.clone())),
        }
    }

    /// What the tip error of a single trial is held against.
    fn single_bound(&self) -> Option<(Metric, f64)> {
        self.scenario.requirement.as_ref()?.single_position_mm()
    }
}

/// Drawn values below this part of their mean count as so much of it in its logarithm.
const LEAST_PART: f64 = 1e-3;

/// Most that a sample of the trials is taken to be off from all of them.
const MOST_SAMPLING: f64 = 2.0;

/// The value and the widened interval of a figure's drawn values. Squares of errors are right on the average,
/// so that the mean of the drawn values stays as it is when their spread is widened; the value is the median of
/// the log-normal distribution that then results, which the true figure is as likely above as below. The ends
/// have a standard deviation on each side of the median: a percentile of antithetic pairs would rest on the one
/// or two pairs that happen to be the largest.
fn widened(mut drawn: Vec<f64>, widening: f64) -> (f64, [f64; 2]) {
    let count = drawn.len() as f64;
    let mean = drawn.iter().sum::<f64>() / count;
    if mean <= 0.0 {
        return (0.0, [0.0; 2]);
    }
    let log_mean = drawn.iter().map(|v| (v / mean).max(LEAST_PART).ln()).sum::<f64>() / count;
    let value = mean * (log_mean * widening * widening).exp();
    let median = percentile(&mut drawn, 0.5);
    let logs = drawn.iter().map(|value| (value / median).ln());
    let (below, above): (Vec<f64>, Vec<f64>) = logs.partition(|log| *log < 0.0);
    let std = |logs: &[f64]| {
        let squares: f64 = logs.iter().map(|log| log * log).sum();
        (squares / logs.len().max(1) as f64).sqrt()
    };
    let end = |std: f64| mean * (median / mean * (HALF_WIDTH * std).exp()).powf(widening);
    (value, [end(-std(&below)).min(value), end(std(&above)).max(value)])
}

/// The mean and the widened interval of a drawn part of the trials.
fn widened_part(mut drawn: Vec<f64>, widening: f64) -> (f64, [f64; 2]) {
    let part = drawn.iter().sum::<f64>() / drawn.len().max(1) as f64;
    let end = |quantile: f64| (part + widening * (quantile - part)).clamp(0.0, 1.0);
    (part, [end(percentile(&mut drawn, TAIL)), end(percentile(&mut drawn, 1.0 - TAIL))])
}

/// Places of at most `most` trials, in order, and whether each is one of those that are spread over all:
/// all trials, or some spread over them and the extremes.
fn tried(plan: &Plan, errors: &TrialErrors, most: usize) -> (Vec<usize>, Vec<bool>) {
    let count = errors.errors.len();
    if count <= most {
        return ((0..count).collect(), vec![true; count]);
    }
    let extremes = (EXTREME_PART * most as f64) as usize;
    let spread: BTreeSet<usize> = match errors.are_all() {
        true => plan.spread(most - extremes).into_iter().collect(),
        false => spread(count, most - extremes).collect(),
    };
    let mut tried = spread.clone();
    for component in 0..2 {
        tried.extend(errors.largest(component, extremes / 2));
    }
    let places: Vec<usize> = tried.into_iter().collect();
    let is_spread = places.iter().map(|place| spread.contains(place)).collect();
    (places, is_spread)
}
