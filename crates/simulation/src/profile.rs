//! A study trial by trial: what a timeline, a histogram and the error along each axis are drawn
//! from.

use super::along_shaft::{AlongShaft, AlongShaftSums};
use super::motion::MotionGrid;
use super::plan::Plan;
use super::requirement::{Requirement, Within};
use super::run::{StudyError, is_rejected};
use super::scenario::{InputTrial, Mode, Scenario};
use super::study::{Study, study};
use trackwright_geometry::number::round_above;
use trackwright_task::CancelToken;

/// Most trials that are kept one by one: 16 MB of them. Longer studies have figures and no profile.
pub const MAX_PROFILED: usize = 1 << 20;

/// Most bars of a histogram.
pub const MAX_BARS: usize = 40;

/// All three translations as one axis: the positions in the order in which they are visited.
pub const POSITION: &str = "position";

/// All three turns as one axis: the orientations that are visited at each position.
pub const ORIENTATION: &str = "orientation";

/// The errors of every trial, in the order of the log.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    pub tip_error_mm: Vec<f64>,
    pub angle_error_deg: Vec<f64>,
    /// Along each axis of the range of motion that has more than one value; none for other modes.
    /// Where both positions and orientations are many, by each of them too.
    pub axes: Vec<AxisProfile>,
    /// The error along the tool's long axis; `None` of a tool without one.
    pub along_shaft: Option<AlongShaft>,
}

/// How the tip error goes with one axis of the range of motion, over all values of the others.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisProfile {
    /// `x` to `rz`, or one of [`POSITION`] and [`ORIENTATION`].
    pub axis: &'static str,
    /// Millimetres for x, y, z, degrees for rx, ry, rz, else numbers from 1.
    pub values: Vec<f64>,
    pub rms_mm: Vec<f64>,
    pub max_mm: Vec<f64>,
    /// The trial with the largest error of each value, the first of equals.
    pub worst_trial: Vec<usize>,
}

/// How many trials have which error.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    /// Of each bar; the first begins at zero.
    pub width: f64,
    pub counts: Vec<usize>,
}

/// Some trials that stand next to each other, as one column of a timeline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Column {
    pub first_trial: usize,
    pub min_mm: f64,
    pub max_mm: f64,
    /// The trial with the largest error.
    pub worst_trial: usize,
}

/// A study with its profile.
///
/// # Errors
/// Those of [`study`]. A study of more than [`MAX_PROFILED`] trials has no profile.
pub fn study_profiled(
    scenario: &Scenario,
    mode: &Mode,
    cancel: &CancelToken,
) -> Result<(Study, Option<Profile>), StudyError> {
    let grid = match mode {
        Mode::Motion => scenario.motion_grid()?,
        Mode::Single | Mode::Input(_) => None,
    };
    let trials = trial_count(scenario, mode).unwrap_or(1);
    if trials > MAX_PROFILED {
        return study(scenario, mode, cancel, None).map(|study| (study, None));
    }
    let mut tip_error_mm = Vec::with_capacity(trials);
    let mut angle_error_deg = Vec::with_capacity(trials);
    let mut along_shaft = AlongShaftSums::new(&scenario.tool);
    let mut log = |trial: &super::trial::Trial| {
        tip_error_mm.push(trial.tip_error_mm);
        angle_error_deg.push(trial.angle_error_deg);
        if let Some(sums) = along_shaft.as_mut().filter(|_| !is_rejected(trial, scenario.outside)) {
            sums.add(trial);
        }
    };
    let study = study(scenario, mode, cancel, Some(&mut log))?;
    let axes = grid.map_or_else(Vec::new, |grid| axes(&grid, &tip_error_mm));
    let along_shaft = along_shaft.and_then(AlongShaftSums::finish);
    let profile = Profile { tip_error_mm, angle_error_deg, axes, along_shaft };
    Ok((study, Some(profile)))
}

/// How many trials a mode has; `None` where there is no range of motion, or none that can be
/// visited.
pub fn trial_count(scenario: &Scenario, mode: &Mode) -> Option<usize> {
    match mode {
        Mode::Single => Some(1),
        Mode::Motion => scenario.motion?.trials().ok(),
        Mode::Input(trials) => Some(trials.len()),
    }
}

/// How far a trial of the range of motion is from the design's own pose, along the axes that have
/// more than one value: mm for x, y, z, degrees for rx, ry, rz.
pub fn trial_offsets(scenario: &Scenario, mode: &Mode, trial: usize) -> Vec<(&'static str, f64)> {
    let (Mode::Motion, Ok(Some(grid))) = (mode, scenario.motion_grid()) else {
        return Vec::new();
    };
    let names = grid.motion().axes().map(|(name, _)| name);
    let offsets = names.into_iter().zip(grid.offsets(trial));
    offsets.zip(grid.counts()).filter_map(|(offset, count)| (count > 1).then_some(offset)).collect()
}

/// Where the tool is in one trial of a mode, with the CRF's pose where the trial brings its own;
/// `None` past the end or where there is no range of motion.
pub fn trial_pose(scenario: &Scenario, mode: &Mode, trial: usize) -> Option<InputTrial> {
    let plan = Plan::new(scenario, mode).ok()?;
    (trial < plan.len()).then(|| plan.trial(scenario, trial))
}

fn axes(grid: &MotionGrid, tip_error_mm: &[f64]) -> Vec<AxisProfile> {
    let counts = grid.counts();
    let mut run = tip_error_mm.len();
    let mut profiles = Vec::new();
    for (k, axis) in ["x", "y", "z", "rx", "ry", "rz"].into_iter().enumerate() {
        // Trials of one value of this axis stand in runs of so many.
        run /= counts[k].max(1);
        if counts[k] > 1 && run > 0 {
            profiles.push(axis_profile(axis, grid.axis_values(k), run, tip_error_mm));
        }
    }
    let orientations = grid.orientations();
    let positions = tip_error_mm.len() / orientations.max(1);
    if positions > 1 && orientations > 1 {
        let numbers = |count: usize| (1..=count).map(|k| k as f64).collect();
        profiles.extend([
            axis_profile(POSITION, numbers(positions), orientations, tip_error_mm),
            axis_profile(ORIENTATION, numbers(orientations), 1, tip_error_mm),
        ]);
    }
    profiles
}

/// Of an axis whose values take turns, each for a run of so many trials.
fn axis_profile(
    axis: &'static str,
    values: Vec<f64>,
    run: usize,
    tip_error_mm: &[f64],
) -> AxisProfile {
    let count = values.len();
    let mut squares = vec![0.0; count];
    let mut max_mm = vec![0.0_f64; count];
    // Each value's run in the first turn begins with a trial of its own.
    let mut worst_trial: Vec<usize> = (0..count).map(|at| at * run).collect();
    for (number, errors) in tip_error_mm.chunks(run).enumerate() {
        let at = number % count;
        for (k, &error) in errors.iter().enumerate() {
            squares[at] += error * error;
            if error > max_mm[at] {
                max_mm[at] = error;
                worst_trial[at] = number * run + k;
            }
        }
    }
    let each = (tip_error_mm.len() / count) as f64;
    AxisProfile {
        axis,
        values,
        rms_mm: squares.into_iter().map(|sum| (sum / each).sqrt()).collect(),
        max_mm,
        worst_trial,
    }
}

impl Profile {
    pub fn len(&self) -> usize {
        self.tip_error_mm.len()
    }

    pub fn is_empty(&self) -> bool {
        self.tip_error_mm.is_empty()
    }

    /// Tip errors in bars of 1, 2 or 5 times a power of ten, in millimetres.
    pub fn histogram(&self) -> Histogram {
        let largest = self.finite().fold(0.0, f64::max);
        let width = round_above(largest / MAX_BARS as f64);
        if width <= 0.0 || !width.is_finite() {
            return Histogram { width: 1.0, counts: vec![self.finite().count()] };
        }
        let bar = |error: f64| (error / width) as usize;
        let mut counts = vec![0; bar(largest) + 1];
        for error in self.finite() {
            counts[bar(error)] += 1;
        }
        Histogram { width, counts }
    }

    /// Which part of the trials has at most which tip error, at `points` errors from the least to
    /// the largest; evenly spread over the trials.
    pub fn cumulative(&self, points: usize) -> Vec<(f64, f64)> {
        let mut sorted: Vec<f64> = self.finite().collect();
        sorted.sort_unstable_by(f64::total_cmp);
        let n = sorted.len();
        let points = points.clamp(2, n.max(2));
        let at = |k: usize| (k * n).div_ceil(points).clamp(1, n.max(1));
        let mut curve = Vec::with_capacity(points + 1);
        if let Some(least) = sorted.first() {
            curve.push((*least, 0.0));
            curve.extend((1..=points).map(|k| (sorted[at(k) - 1], at(k) as f64 / n as f64)));
        }
        curve
    }

    /// Which part of the trials keeps to a tip error.
    pub fn part_within(&self, limit_mm: f64) -> f64 {
        let within = self.tip_error_mm.iter().filter(|e| **e <= limit_mm);
        within.count() as f64 / self.len().max(1) as f64
    }

    /// The trials in at most so many columns, for a timeline of so many pixels.
    pub fn columns(&self, most: usize) -> Vec<Column> {
        let each = self.len().div_ceil(most.max(1)).max(1);
        let column = |(number, errors): (usize, &[f64])| {
            let mut column = Column {
                first_trial: number * each,
                min_mm: f64::INFINITY,
                max_mm: f64::NEG_INFINITY,
                worst_trial: number * each,
            };
            for (k, &error) in errors.iter().enumerate() {
                column.min_mm = column.min_mm.min(error);
                if error > column.max_mm {
                    column.max_mm = error;
                    column.worst_trial = number * each + k;
                }
            }
            column
        };
        self.tip_error_mm.chunks(each).enumerate().map(column).collect()
    }

    /// The trial with the largest tip error from `from_mm` up to, and not with, `to_mm`.
    pub fn worst_between(&self, from_mm: f64, to_mm: f64) -> Option<usize> {
        let errors = self.tip_error_mm.iter().copied().enumerate();
        errors
            .filter(|(_, error)| (from_mm..to_mm).contains(error))
            .reduce(|a, b| if b.1 > a.1 { b } else { a })
            .map(|(trial, _)| trial)
    }

    /// The trial with the largest tip error, the first of equals.
    pub fn worst(&self) -> Option<usize> {
        self.worst_between(0.0, f64::INFINITY)
    }

    fn finite(&self) -> impl Iterator<Item = f64> + '_ {
        self.tip_error_mm.iter().copied().filter(|e| e.is_finite())
    }
}

/// Points of the cumulative curve: more than a chart in a panel has pixels.
const CURVE_POINTS: usize = 400;

/// A profile with its histogram, its cumulative curve, and how it keeps to the requirement.
#[derive(Clone, Debug, PartialEq)]
pub struct ChartedProfile {
    pub profile: Profile,
    pub histogram: Histogram,
    /// Tip errors in millimetres, and the part of the trials that has at most so much.
    pub cumulative: Vec<(f64, f64)>,
    pub within: Option<Within>,
    /// The trial with the largest tip error.
    pub worst_trial: Option<usize>,
}

impl ChartedProfile {
    pub fn new(profile: Profile, requirement: Option<&Requirement>) -> Self {
        Self {
            histogram: profile.histogram(),
            cumulative: profile.cumulative(CURVE_POINTS),
            within: requirement.and_then(|r| Within::of(&profile.tip_error_mm, r)),
            worst_trial: profile.worst(),
            profile,
        }
    }

    /// The trial with the largest tip error of a bar of the histogram.
    pub fn worst_of_bar(&self, bar: usize) -> Option<usize> {
        let width = self.histogram.width;
        self.profile.worst_between(bar as f64 * width, (bar + 1) as f64 * width)
    }
}
