//! Given poses of tool and CRF that are out of the room, or far from the design's own, where a mistake in them
//! explains that.

use super::{MIN_ROWS, SignedAxes, Suspicion, named_axes, on_axes, signed_axes};
use nalgebra::{Point3, Vector3};
use std::fmt;
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_simulation::{InputTrial, RigidBody, Scenario};

/// Parts of the trials that are in the room as they are read, at most, and without the mistake, at least.
const MOST_INSIDE: f64 = 0.1;
const LEAST_INSIDE: f64 = 0.9;

/// Poses are elsewhere where they are so far from the design's own, and so many times as far as without the mistake.
const FAR_MM: f64 = 100.0;
const NEARER: f64 = 5.0;

/// Trials that are looked at, evenly from the table.
const MOST_TRIALS: usize = 512;

/// Lengths in mm of the units that a column may be in.
const UNITS: [(f64, &str); 3] = [(1000.0, "metres"), (10.0, "centimetres"), (25.4, "inches")];

/// What columns of given poses may have instead of what they are read as.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum InputMistake {
    /// Positions of the CRF, of the tool, or of both, in mm times a factor.
    Unit { of: Columns, factor: f64, units: &'static str },
    /// The tool's poses are in the tracker frame.
    ToolInTracker,
    /// The CRF's columns have the tool's poses, and the tool's the CRF's.
    Exchanged,
    /// Poses of these columns are those of their frame in the body.
    Inverted(Columns),
    /// The CRF's axes, or the tool's, are others.
    Axes(Columns, SignedAxes),
}

/// Columns of given poses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Columns {
    Crf,
    Tool,
    Both,
}

impl Columns {
    fn changed(self, trial: &InputTrial, change: impl Fn(&Pose) -> Pose) -> InputTrial {
        InputTrial {
            tracker_from_crf: match self {
                Self::Tool => trial.tracker_from_crf,
                _ => trial.tracker_from_crf.as_ref().map(&change),
            },
            crf_from_tool: match self {
                Self::Crf => trial.crf_from_tool,
                _ => change(&trial.crf_from_tool),
            },
        }
    }
}

impl InputMistake {
    /// Of two that explain as many trials the one with poses nearer to the design's own is named.
    fn all(has_crf: bool) -> impl Iterator<Item = Self> {
        let sides: &[Columns] =
            if has_crf { &[Columns::Both, Columns::Crf, Columns::Tool] } else { &[Columns::Tool] };
        let units = sides
            .iter()
            .flat_map(|&of| UNITS.map(|(factor, units)| Self::Unit { of, factor, units }));
        let frames = has_crf.then_some([Self::ToolInTracker, Self::Exchanged]);
        let inverted = sides.iter().map(|&of| Self::Inverted(of));
        let one = sides.iter().filter(|of| sides.len() == 1 || **of != Columns::Both);
        let axes = one.flat_map(|&of| signed_axes().rev().map(move |axes| Self::Axes(of, axes)));
        units.chain(frames.into_iter().flatten()).chain(inverted).chain(axes)
    }

    /// The trial without the mistake.
    fn undone(&self, trial: &InputTrial) -> InputTrial {
        let moved = |pose: &Pose, place: &dyn Fn(&Vector3<f64>) -> Vector3<f64>| {
            pose_from_parts(place(&pose.translation.vector), pose.rotation)
        };
        match self {
            Self::Unit { of, factor, .. } => {
                of.changed(trial, |pose| moved(pose, &|at| at * *factor))
            }
            Self::Inverted(of) => of.changed(trial, Pose::inverse),
            Self::Axes(of, axes) => of.changed(trial, |pose| moved(pose, &|at| on_axes(axes, at))),
            Self::ToolInTracker => match trial.tracker_from_crf {
                Some(crf) => {
                    InputTrial { crf_from_tool: crf.inverse() * trial.crf_from_tool, ..*trial }
                }
                None => *trial,
            },
            Self::Exchanged => match trial.tracker_from_crf {
                Some(crf) => {
                    InputTrial { tracker_from_crf: Some(trial.crf_from_tool), crf_from_tool: crf }
                }
                None => *trial,
            },
        }
    }
}

/// Suspicions about poses of a design's tool and CRF by its room.
pub fn of_input(trials: &[InputTrial], scenario: &Scenario) -> Option<Suspicion> {
    let rows: Vec<InputTrial> = trials
        .iter()
        .step_by(trials.len().div_ceil(MOST_TRIALS).max(1))
        .map(|trial| InputTrial {
            tracker_from_crf: trial
                .tracker_from_crf
                .or(scenario.crf.as_ref().map(|c| c.tracker_from_crf)),
            ..*trial
        })
        .collect();
    let inside =
        |trials: &[InputTrial]| trials.iter().filter(|trial| is_inside(trial, scenario)).count();
    let count = rows.len() as f64;
    let from_own_mm = |trials: &[InputTrial]| {
        trials.iter().map(|trial| from_own_mm(trial, scenario)).sum::<f64>() / count
    };
    let (as_read, as_read_mm) = (inside(&rows), from_own_mm(&rows));
    let is_out = as_read as f64 <= MOST_INSIDE * count;
    if rows.len() < MIN_ROWS || !(is_out || as_read_mm > FAR_MM) {
        return None;
    }
    let has_crf = trials.iter().any(|trial| trial.tracker_from_crf.is_some());
    let mut best: Option<(InputMistake, usize, f64)> = None;
    for mistake in InputMistake::all(has_crf) {
        let undone: Vec<InputTrial> = rows.iter().map(|trial| mistake.undone(trial)).collect();
        let (count, apart_mm) = (inside(&undone), from_own_mm(&undone));
        if best.is_none_or(|(_, most, least)| (count, least) > (most, apart_mm)) {
            best = Some((mistake, count, apart_mm));
        }
    }
    let (mistake, inside_without, without_mm) = best?;
    let is_near = as_read_mm > NEARER * without_mm;
    (inside_without as f64 >= LEAST_INSIDE * count && (is_out || is_near)).then_some(
        Suspicion::Input {
            rows: rows.len(),
            inside: [as_read, inside_without],
            from_own_mm: [as_read_mm, without_mm],
            mistake,
        },
    )
}

/// How far the poses are from the design's own.
fn from_own_mm(trial: &InputTrial, scenario: &Scenario) -> f64 {
    let tip = scenario.tool.judged_tip_in_body();
    let tracker_from_crf = trial.tracker_from_crf.unwrap_or_else(Pose::identity);
    let [is, own] = [
        (tracker_from_crf, trial.crf_from_tool),
        (scenario.tracker_from_crf(), scenario.crf_from_tool),
    ]
    .map(|(crf, tool)| [crf * Point3::origin(), crf * tool * tip]);
    is.iter().zip(&own).map(|(is, own)| (is - own).norm()).sum()
}

fn is_inside(trial: &InputTrial, scenario: &Scenario) -> bool {
    let room = scenario.environment.model.bounds();
    let has_all = |body: &RigidBody, tracker_from_body: &Pose| {
        body.sensors
            .iter()
            .all(|sensor| room.contains(&(tracker_from_body * sensor.position_in_body)))
    };
    let tracker_from_crf = trial.tracker_from_crf.unwrap_or_else(Pose::identity);
    has_all(&scenario.tool, &(tracker_from_crf * trial.crf_from_tool))
        && scenario.crf.as_ref().is_none_or(|crf| has_all(&crf.body, &tracker_from_crf))
}

impl fmt::Display for InputMistake {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let of = |of: &Columns| match of {
            Columns::Crf => "the CRF's",
            Columns::Tool => "the tool's",
            Columns::Both => "the CRF's and the tool's",
        };
        match self {
            Self::Unit { of: columns, units, .. } => {
                write!(f, "{} positions are in {units}: are they?", of(columns))
            }
            Self::ToolInTracker => f.write_str(
                "the tool's poses are in the tracker frame, expected the CRF frame: are they?",
            ),
            Self::Exchanged => {
                f.write_str("the CRF's columns have the tool's poses: are the columns exchanged?")
            }
            Self::Inverted(columns) => {
                write!(f, "{} poses are inverted: are they?", of(columns))
            }
            Self::Axes(columns, axes) => {
                let whose = format!("{} ", of(columns));
                write!(f, "{}: are axes taken for others?", named_axes(axes, &whose, "its "))
            }
        }
    }
}
