//! Where a study's error comes from: which sensor contributes how much of it, and in which part of the
//! motion it is largest.
//!
//! With `e` the error of a trial and `e₋ₛ` the error of the same trial where the reading of sensor `s`
//! alone is exact and the body's frame is fitted again, sensor `s` contributes `e − e₋ₛ`. Its part is
//!
//! `cₛ = Σ e · (e − e₋ₛ) / Σ |e|²`,
//!
//! summed over the trials. A frame fit is linear in small errors, so that the contributions of all
//! sensors of tool and CRF add up to `e` and the parts to 1. A part is negative where a sensor's error
//! cancels others. `docs/methods/error-sources.md` has the derivation.

mod at_trial;

pub use at_trial::{TrialSource, source_words, trial_sources};

use super::body::{RigidBody, Sensor};
use super::frame_fit::{FrameFitter, Reading};
use super::metric::ErrorOf;
use super::motion::MotionGrid;
use super::plan::Plan;
use super::run::{StudyError, check};
use super::scenario::{InputTrial, Mode, Scenario};
use super::spread::spread;
use super::tool_in_crf::relative_error;
use super::tracker::{BodyTracker, TrackBuffers};
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;
use std::collections::BTreeSet;
use trackwright_field::OutsidePolicy;
use trackwright_geometry::pose::Pose;
use trackwright_geometry::rotation::log_quaternion;
use trackwright_result::with_separators;
use trackwright_task::CancelToken;

/// Most trials that are looked at: so many of a longer study, spread over it.
pub const MOST_TRIALS: usize = 4096;

/// Trials that one core computes before it looks whether anyone still wants them.
const CHUNK: usize = 64;

/// Part of the trials that counts as the worst.
const WORST_PART: f64 = 0.05;

/// Fewest trials of which a part is the worst.
const LEAST_TRIALS: usize = 20;

/// Part of the worst trials that has to lie between two values of an axis for the axis to be named.
const GATHERED_PART: f64 = 0.8;

/// What a study's error is made of, by the room's model alone.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorSources {
    /// Trials that were looked at.
    pub trials: usize,
    /// RMS over them, tip in mm and angle in degrees.
    rms: [f64; 2],
    /// The tool's, then the CRF's.
    pub sensors: Vec<SensorSource>,
    /// By tip error and by angle error; `None` where there is no range of motion, or few trials.
    worst: [Option<WorstTrials>; 2],
}

/// What one sensor contributes.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorSource {
    /// `tool` or `CRF`.
    pub body: &'static str,
    pub name: String,
    /// Of the mean square of the tip error and of the angle error.
    part: [f64; 2],
    /// RMS with its reading exact, mm and degrees.
    rms_without: [f64; 2],
}

/// Where in the range of motion the largest errors are.
#[derive(Clone, Debug, PartialEq)]
pub struct WorstTrials {
    /// How many they are.
    pub trials: usize,
    /// Axes along which most of them lie close together.
    pub ranges: Vec<AxisSpan>,
    /// How many of them lie within all of these.
    pub within: usize,
}

/// From one value of an axis of the motion to another: from the design's pose, mm or degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisSpan {
    pub axis: &'static str,
    pub from: f64,
    pub to: f64,
}

impl ErrorSources {
    /// RMS error over the trials, mm or degrees.
    pub fn rms(&self, of: ErrorOf) -> f64 {
        self.rms[place(of)]
    }

    /// The sensor that contributes most; `None` without any error.
    pub fn largest(&self, of: ErrorOf) -> Option<&SensorSource> {
        let part = |sensor: &&SensorSource| sensor.part(of);
        let each = self.sensors.iter().filter(|sensor| sensor.part(of) > 0.0);
        each.max_by(|a, b| part(a).total_cmp(&part(b)))
    }

    /// Where in the range of motion the largest errors are.
    pub fn worst(&self, of: ErrorOf) -> Option<&WorstTrials> {
        self.worst[place(of)].as_ref()
    }

    /// Why an error is as large as it is; each a sentence without a full stop, with this before units.
    pub fn words(&self, of: ErrorOf, space: &str) -> Vec<String> {
        let error = match of {
            ErrorOf::Position => "tip error",
            ErrorOf::Angle => "angle error",
        };
        let sensor = self.largest(of).map(|sensor| {
            let less = 100.0 * (1.0 - sensor.rms_without(of) / self.rms(of));
            let change = if less < 0.0 { "higher" } else { "lower" };
            format!(
                "Sensor {} of the {} carries {:.0}{space}% of the {error}: without its distortion the RMS is \
                 {:.0}{space}% {change}",
                sensor.name,
                sensor.body,
                100.0 * sensor.part(of),
                less.abs()
            )
        });
        let worst = self.worst(of).map(|worst| worst.words(space));
        sensor.into_iter().chain(worst).collect()
    }
}

impl SensorSource {
    /// Its part of the mean square error. All parts add up to 1, but for what is of second order.
    pub fn part(&self, of: ErrorOf) -> f64 {
        self.part[place(of)]
    }

    /// RMS error where its reading alone is exact, mm or degrees.
    pub fn rms_without(&self, of: ErrorOf) -> f64 {
        self.rms_without[place(of)]
    }
}

impl WorstTrials {
    /// One sentence without a full stop.
    pub fn words(&self, space: &str) -> String {
        let worst = format!("the worst {:.0}{space}% of the trials", 100.0 * WORST_PART);
        if self.ranges.is_empty() {
            return format!("{} lie all over the range of motion", capital(&worst));
        }
        let places: Vec<String> = self.ranges.iter().map(|span| span.words(space)).collect();
        let places = places.join(", ");
        match self.within == self.trials {
            true => format!("{} lie at {places} from the design's pose", capital(&worst)),
            false => format!(
                "{} of the {} trials that are {worst} lie at {places} from the design's pose",
                with_separators(self.within),
                with_separators(self.trials),
            ),
        }
    }
}

impl AxisSpan {
    fn words(&self, space: &str) -> String {
        let (what, unit) = match self.axis.strip_prefix('r') {
            Some(about) => (format!("rotations about {about} of"), "°".to_owned()),
            None => (self.axis.to_owned(), format!("{space}mm")),
        };
        let [from, to] = [self.from, self.to].map(|value| {
            // Round values as they were set: a step of a third has more digits than anybody reads.
            let text = format!("{value:.2}").replace('-', "−");
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        });
        match from == to {
            true => format!("{what} {from}{unit}"),
            false => format!("{what} {from}{unit} to {to}{unit}"),
        }
    }
}

fn capital(words: &str) -> String {
    super::figures::capitalised(words)
}

fn place(of: ErrorOf) -> usize {
    usize::from(of == ErrorOf::Angle)
}

/// Looks where the error of a mode's trials comes from. The result does not depend on the number of
/// threads.
///
/// # Errors
/// See [`StudyError`].
pub fn error_sources(
    scenario: &Scenario,
    mode: &Mode,
    cancel: &CancelToken,
) -> Result<ErrorSources, StudyError> {
    check(scenario)?;
    let plan = Plan::new(scenario, mode)?;
    let numbers: Vec<usize> = match plan.len() {
        all if all <= MOST_TRIALS => (0..all).collect(),
        all => spread(all, MOST_TRIALS).collect::<BTreeSet<_>>().into_iter().collect(),
    };
    let refits = Refits::new(scenario);
    let parts: Option<Vec<Sums>> = numbers
        .par_chunks(CHUNK)
        .map(|chunk| {
            let trials = chunk.iter().map(|&number| plan.trial(scenario, number)).collect();
            (!cancel.is_cancelled()).then(|| refits.sums(chunk, trials))
        })
        .collect();
    let mut all = Sums::new(refits.sensors());
    for part in parts.ok_or(StudyError::Cancelled)? {
        all.add(part);
    }
    let trials = all.errors.len();
    if trials == 0 {
        return Err(StudyError::AllRejected { trials: plan.len() });
    }
    let grid = match &plan {
        Plan::Motion(grid) => Some(&**grid),
        Plan::Single | Plan::Input(_) => None,
    };
    Ok(all.sources(scenario, grid))
}

/// Tip error in mm and rotation error in degrees of a trial, as vectors.
type Errors = [Vector3<f64>; 2];

/// A scenario made ready to be fitted with one reading exact at a time.
struct Refits<'a> {
    scenario: &'a Scenario,
    tool: BodyRefits<'a>,
    crf: Option<BodyRefits<'a>>,
    tip_in_tool: Point3<f64>,
}

impl<'a> Refits<'a> {
    fn new(scenario: &'a Scenario) -> Self {
        Self {
            scenario,
            tool: BodyRefits::new(&scenario.tool, scenario),
            crf: scenario.crf.as_ref().map(|crf| BodyRefits::new(&crf.body, scenario)),
            tip_in_tool: scenario.tool.judged_tip_in_body(),
        }
    }

    /// Sensors of both bodies.
    fn sensors(&self) -> usize {
        self.tool.sensors() + self.crf.as_ref().map_or(0, BodyRefits::sensors)
    }

    fn sums(&self, numbers: &[usize], trials: Vec<InputTrial>) -> Sums {
        let mut buffers = TrackBuffers::default();
        let own_crf = self.scenario.crf.as_ref().map(|crf| crf.tracker_from_crf);
        let tracker_from_crf = |trial: &InputTrial| {
            own_crf.map(|own| trial.tracker_from_crf.unwrap_or(own)).unwrap_or_else(Pose::identity)
        };
        let crf_poses: Vec<Pose> = trials.iter().map(tracker_from_crf).collect();
        let tool_poses: Vec<Pose> =
            crf_poses.iter().zip(&trials).map(|(crf, trial)| crf * trial.crf_from_tool).collect();
        let tool = self.tool.fits(&mut buffers, &tool_poses);
        // A CRF that stands still is fitted once.
        let stands = crf_poses.windows(2).all(|pair| pair[0] == pair[1]);
        let crf_poses = if stands { &crf_poses[..1] } else { &crf_poses[..] };
        let crf = self.crf.as_ref().map(|crf| crf.fits(&mut buffers, crf_poses));
        let mut sums = Sums::new(self.sensors());
        for (k, trial) in trials.iter().enumerate() {
            let tool = &tool[k];
            let crf = crf.as_ref().map(|fits| &fits[if stands { 0 } else { k }]);
            let is_inside = tool.is_inside && crf.is_none_or(|crf| crf.is_inside);
            if self.scenario.outside == OutsidePolicy::Reject && !is_inside {
                continue;
            }
            let crf_fit = crf.map_or_else(Pose::identity, |crf| crf.all);
            let errors = self.errors(trial, &crf_fit, &tool.all);
            let of_tool = tool.without.iter().map(|tool| self.errors(trial, &crf_fit, tool));
            let of_crf = crf.into_iter().flat_map(|crf| &crf.without);
            let of_crf = of_crf.map(|crf| self.errors(trial, crf, &tool.all));
            sums.add_trial(numbers[k], &errors, of_tool.chain(of_crf));
        }
        sums
    }

    fn errors(
        &self,
        trial: &InputTrial,
        tracker_from_crf: &Pose,
        tracker_from_tool: &Pose,
    ) -> Errors {
        let simulated = tracker_from_crf.inverse() * tracker_from_tool;
        let error = relative_error(&trial.crf_from_tool, &simulated, &self.tip_in_tool);
        let turn = simulated.rotation * trial.crf_from_tool.rotation.inverse();
        [error.tip_error_in_crf_mm, log_quaternion(&turn).map(f64::to_degrees)]
    }
}

/// One body of it.
struct BodyRefits<'a> {
    body: &'a RigidBody,
    tracker: BodyTracker<'a>,
    fitter: FrameFitter,
}

/// A body's frame at one pose.
struct Fits {
    /// With all readings distorted.
    all: Pose,
    /// With the reading of each sensor in turn exact.
    without: Vec<Pose>,
    is_inside: bool,
}

impl<'a> BodyRefits<'a> {
    fn new(body: &'a RigidBody, scenario: &'a Scenario) -> Self {
        Self {
            body,
            tracker: BodyTracker::new(body, scenario),
            fitter: FrameFitter::new(body, scenario.orientation_weight_mm),
        }
    }

    fn sensors(&self) -> usize {
        self.body.sensors.len()
    }

    fn fits(&self, buffers: &mut TrackBuffers, tracker_from_body: &[Pose]) -> Vec<Fits> {
        let count = tracker_from_body.len();
        let mut read = Vec::with_capacity(count * self.sensors());
        self.tracker.read_all(buffers, tracker_from_body, 1, &mut read);
        let mut readings: Vec<Reading> = Vec::with_capacity(self.sensors());
        let each = tracker_from_body.iter().enumerate().map(|(k, pose)| {
            // Sensor by sensor, the poses of each in order.
            let of_pose = || read.iter().skip(k).step_by(count);
            readings.clear();
            readings.extend(of_pose().map(|(reading, _)| *reading));
            let fit = |readings: &[Reading]| self.fitter.fit(readings, pose).tracker_from_body;
            let all = fit(&readings);
            let without = (0..self.sensors()).map(|sensor| {
                let exact = pose * self.body.sensors[sensor].body_from_sensor();
                let exact = Reading {
                    position_mm: exact.translation.vector.into(),
                    rotation: exact.rotation,
                };
                let distorted = std::mem::replace(&mut readings[sensor], exact);
                let found = fit(&readings);
                readings[sensor] = distorted;
                found
            });
            let without = without.collect();
            Fits { all, without, is_inside: of_pose().all(|(_, is_inside)| *is_inside) }
        });
        each.collect()
    }
}

/// Sums over trials, and what each of them is off.
struct Sums {
    /// Numbers of the trials in the study.
    numbers: Vec<usize>,
    /// Sizes of their errors.
    errors: Vec<[f64; 2]>,
    /// `Σ |e|²`.
    squares: [f64; 2],
    /// Of each sensor `Σ e · (e − e₋ₛ)` and `Σ |e₋ₛ|²`.
    sensors: Vec<[[f64; 2]; 2]>,
}

impl Sums {
    fn new(sensors: usize) -> Self {
        Self {
            numbers: Vec::new(),
            errors: Vec::new(),
            squares: [0.0; 2],
            sensors: vec![[[0.0; 2]; 2]; sensors],
        }
    }

    fn add_trial(&mut self, number: usize, e: &Errors, without: impl Iterator<Item = Errors>) {
        self.numbers.push(number);
        self.errors.push(e.map(|error| error.norm()));
        for (sum, error) in self.squares.iter_mut().zip(e) {
            *sum += error.norm_squared();
        }
        for (sums, without) in self.sensors.iter_mut().zip(without) {
            for (of, (error, without)) in e.iter().zip(without).enumerate() {
                sums[0][of] += error.dot(&(error - without));
                sums[1][of] += without.norm_squared();
            }
        }
    }

    fn add(&mut self, other: Self) {
        self.numbers.extend(other.numbers);
        self.errors.extend(other.errors);
        let add = |sums: &mut [f64; 2], more: [f64; 2]| {
            *sums = [sums[0] + more[0], sums[1] + more[1]];
        };
        add(&mut self.squares, other.squares);
        for (sums, more) in self.sensors.iter_mut().zip(other.sensors) {
            add(&mut sums[0], more[0]);
            add(&mut sums[1], more[1]);
        }
    }

    fn sources(self, scenario: &Scenario, grid: Option<&MotionGrid>) -> ErrorSources {
        let trials = self.errors.len();
        let rms = |squares: [f64; 2]| squares.map(|sum| (sum / trials as f64).sqrt());
        let sensors = named_sensors(scenario).zip(&self.sensors).map(
            |((body, sensor), [product, without])| {
                let part = |of: usize| match self.squares[of] > 0.0 {
                    true => product[of] / self.squares[of],
                    false => 0.0,
                };
                SensorSource {
                    body,
                    name: sensor.name.clone(),
                    part: [part(0), part(1)],
                    rms_without: rms(*without),
                }
            },
        );
        let worst = |of: usize| grid.and_then(|grid| self.worst_trials(grid, of));
        ErrorSources {
            trials,
            rms: rms(self.squares),
            sensors: sensors.collect(),
            worst: [worst(0), worst(1)],
        }
    }

    fn worst_trials(&self, grid: &MotionGrid, of: usize) -> Option<WorstTrials> {
        let all = self.errors.len();
        if all < LEAST_TRIALS {
            return None;
        }
        let count = (WORST_PART * all as f64).ceil() as usize;
        let mut order: Vec<usize> = (0..all).collect();
        order.sort_by(|a, b| self.errors[*b][of].total_cmp(&self.errors[*a][of]));
        let places: Vec<[usize; 6]> =
            order[..count].iter().map(|&k| grid.indices(self.numbers[k])).collect();
        let spans: Vec<(usize, [usize; 2])> = (0..6)
            .filter_map(|axis| Some((axis, gathered(&places, axis, grid.counts()[axis])?)))
            .collect();
        let is_within = |place: &&[usize; 6]| {
            spans.iter().all(|(axis, [first, last])| (*first..=*last).contains(&place[*axis]))
        };
        let ranges = spans.iter().map(|(axis, [first, last])| {
            let values = grid.axis_values(*axis);
            AxisSpan { axis: AXES[*axis], from: values[*first], to: values[*last] }
        });
        Some(WorstTrials {
            trials: count,
            within: places.iter().filter(is_within).count(),
            ranges: ranges.collect(),
        })
    }
}

/// The tool's sensors, then the CRF's, each with its body.
fn named_sensors(scenario: &Scenario) -> impl Iterator<Item = (&'static str, &Sensor)> {
    let tool = scenario.tool.sensors.iter().map(|sensor| ("tool", sensor));
    let crf = scenario.crf.iter().flat_map(|crf| &crf.body.sensors);
    tool.chain(crf.map(|sensor| ("CRF", sensor)))
}

/// In the order of a grid.
const AXES: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];

/// The first of the fewest neighbouring values of an axis that hold most of the trials; `None` where
/// these are more than half of its values.
fn gathered(places: &[[usize; 6]], axis: usize, values: usize) -> Option<[usize; 2]> {
    let mut held = vec![0_usize; values];
    for place in places {
        held[place[axis]] += 1;
    }
    let least = (GATHERED_PART * places.len() as f64).ceil() as usize;
    (1..=values / 2).find_map(|width| {
        let first = (0..=values - width)
            .rev()
            .max_by_key(|&first| held[first..first + width].iter().sum::<usize>())?;
        let trials: usize = held[first..first + width].iter().sum();
        (trials >= least).then_some([first, first + width - 1])
    })
}

#[cfg(test)]
mod tests;
