//! How many measurements a room would need for a bound to be decided.

use super::drawn_trials::DrawnTrials;
use super::figures::ExpectedError;
use crate::figure::Figure;
use crate::judgement::{JudgedBound, Undecided};
use crate::metric::Metric;
use crate::plan::Plan;
use crate::run::{StudyError, check};
use crate::scenario::{InputTrial, Mode, Scenario};
use crate::spread::spread;
use crate::trial::Simulator;
use nalgebra::{Point3, Unit, Vector3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardUniform, UnitSphere};
use trackwright_field::Environment;
use trackwright_field::FieldPoint;
use trackwright_field::gaussian::{GaussianField, Row};
use trackwright_geometry::bounds::Bounds;
use trackwright_result::with_separators;
use trackwright_task::CancelToken;

/// How many times as many measurements are tried.
const TIMES: [usize; 5] = [2, 4, 8, 16, 32];

/// Trials at whose sensors the field is looked at: the 400 measurements that a query is given then are
/// some 10 a sensor pose even where there are many more. Of many sensors some are looked at.
const TRIALS: usize = 12;
const MOST_POINTS: usize = 180;

const SEED: u64 = 22;

/// A bound that cannot be decided in this room.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MoreMeasuring {
    pub metric: Metric,
    /// Measurements with which it could be decided, if the figure is as expected; `None` where not even
    /// [`most_times`] times as many would do.
    pub measurements: Option<usize>,
}

impl MoreMeasuring {
    /// A sentence without its full stop.
    pub fn statement(&self) -> String {
        let name = self.metric.name();
        match self.measurements {
            Some(measurements) => format!(
                "requirement {name}: decided with about {} measurements spread as widely, if the figure stays",
                with_separators(measurements)
            ),
            None => format!(
                "requirement {name}: not decided even with {} times as many measurements, if the figure stays",
                most_times()
            ),
        }
    }
}

/// How many times as many measurements are tried at most.
pub fn most_times() -> usize {
    TIMES[TIMES.len() - 1]
}

/// The measurements that each open bound would need. The figure is taken to stay as it is
/// expected, and its interval to shrink, on the logarithmic scale, as the standard deviation of the field
/// at the sensors does: that depends on the measured poses, not on the readings there. Further measurements
/// are taken anywhere in the box of those that there are, turned any way.
///
/// # Errors
/// See [`ExpectedError`].
pub fn more_measuring(
    scenario: &Scenario,
    mode: &Mode,
    bounds: &[JudgedBound],
    cancel: &CancelToken,
) -> Result<Vec<MoreMeasuring>, ExpectedError> {
    let open: Vec<&JudgedBound> = bounds
        .iter()
        // No measurement settles what the study itself leaves open.
        .filter(|bound| bound.reason.as_ref().is_some_and(Undecided::is_of_room))
        .collect();
    if open.is_empty() || scenario.environment.process.is_none() {
        return Ok(Vec::new());
    }
    let shrinking = shrinking(scenario, mode, cancel)?;
    let each = open.into_iter().map(|bound| MoreMeasuring {
        metric: bound.metric,
        measurements: shrinking
            .iter()
            .find(|(_, part)| is_decided(bound, *part))
            .map(|(measurements, _)| *measurements),
    });
    Ok(each.collect())
}

/// Whether a bound would be decided by an interval so many times as wide.
fn is_decided(bound: &JudgedBound, part: f64) -> bool {
    let Some(Figure { value, low: Some(low), high: Some(high), .. }) = bound.figure else {
        return true;
    };
    let end = |end: f64| value * (end / value).powf(part);
    end(high) <= bound.limit || end(low) > bound.limit
}

/// Standard deviation of the field at the sensors, over that with the measurements that there are, by
/// the number of measurements.
pub fn shrinking(
    scenario: &Scenario,
    mode: &Mode,
    cancel: &CancelToken,
) -> Result<Vec<(usize, f64)>, ExpectedError> {
    let environment = &scenario.environment;
    let process = process_of(environment)?;
    check(scenario)?;
    let plan = Plan::new(scenario, mode)?;
    let simulator = Simulator::new(scenario);
    let some = plan.spread(TRIALS);
    let trials: Vec<InputTrial> = some.iter().map(|&i| plan.trial(scenario, i)).collect();
    let drawn = DrawnTrials::new(&simulator, environment, trials).ok_or(ExpectedError::Markers)?;
    let all = drawn.points();
    let points: Vec<FieldPoint> = match all.len() <= MOST_POINTS {
        true => all.to_vec(),
        false => spread(all.len(), MOST_POINTS).map(|i| all[i]).collect(),
    };
    let std_with = |rows: Vec<Row>| -> Result<f64, ExpectedError> {
        if cancel.is_cancelled() {
            return Err(StudyError::Cancelled.into());
        }
        let given = GaussianField { rows, ..process.clone() };
        let variances = given.unit_variances(&points).map_err(ExpectedError::Process)?;
        Ok((variances.iter().sum::<f64>() / variances.len() as f64).sqrt())
    };
    let now = std_with(process.rows.clone())?;
    let count = process.rows.len();
    let more = further(process, (most_times() - 1) * count);
    let mut found = Vec::with_capacity(TIMES.len());
    for times in TIMES {
        let rows = process.rows.iter().chain(&more[..(times - 1) * count]);
        let std = std_with(rows.copied().collect())?;
        let part = if now > 0.0 { (std / now).min(1.0) } else { 1.0 };
        found.push((times * process.measured_rows, part));
    }
    Ok(found)
}

fn process_of(environment: &Environment) -> Result<&GaussianField, ExpectedError> {
    let none = || ExpectedError::NothingDrawn(environment.name.clone());
    environment.process.as_deref().ok_or_else(none)
}

/// Measurements that nobody made yet; what they read does not matter.
fn further(process: &GaussianField, count: usize) -> Vec<Row> {
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let bounds = Bounds::around(process.rows.iter().map(|row| row.point.position_mm));
    let (min, size) = bounds.map_or_else(Default::default, |b| (b.min_mm.coords, b.size_mm()));
    let row = |_| {
        let place = Vector3::from_fn(|k, _| {
            let part: f64 = StandardUniform.sample(&mut random);
            min[k] + part * size[k]
        });
        let axis: [f64; 3] = UnitSphere.sample(&mut random);
        Row {
            point: FieldPoint::new(Point3::from(place), Unit::new_normalize(axis.into())),
            error: [0.0; 6],
            noise_factor: 1.0,
        }
    };
    (0..count).map(row).collect()
}
