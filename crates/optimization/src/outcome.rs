//! What a search has found, and the verdict on it.

use crate::constraint::Constraint;
use crate::crowding::Crowding;
use serde::Serialize;
use trackwright_geometry::pose::Pose;
use trackwright_simulation::comparison::Difference;
use trackwright_simulation::study::NoFigures;
use trackwright_simulation::{PlacedBody, RigidBody, Study, StudyError};
use trackwright_task::Cancelled;

/// A design's sensors and poses, and what its study comes to.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    pub tool: RigidBody,
    pub crf: Option<RigidBody>,
    /// `None` without a CRF.
    pub tracker_from_crf: Option<Pose>,
    pub crf_from_tool: Pose,
    /// What the search makes least, with jitter and building error: a ratio to the requirement, or a figure
    /// in its unit.
    pub objective: f64,
    /// Its study in each room.
    pub studies: Vec<Study>,
    /// Of the sensors, where they have one.
    pub cost: Option<f64>,
}

/// Where a search is.
#[derive(Clone, Debug)]
pub struct Progress<'a> {
    /// The best so far.
    pub best: &'a Layout,
    /// Layouts that were judged so far.
    pub evaluations: u64,
}

/// What a search comes to.
#[derive(Clone, Debug)]
pub struct Optimized {
    pub start: Layout,
    /// The layout with the least objective; the start where nothing is better.
    pub best: Layout,
    /// Whether the gain over the start is one that the rooms can tell: nothing is to be changed by
    /// itself where it is not.
    pub is_better: bool,
    /// Distinct good layouts, the best first.
    pub candidates: Vec<Layout>,
    /// The best layout of each number of sensors that was requested, fewest first; those alone that
    /// none with as few sensors, and as low a cost, is better than.
    pub pareto: Vec<Layout>,
    /// Layouts that were judged.
    pub evaluations: u64,
    /// Every layout of a grid was judged on which no allowed place is farther from one of its places
    /// than this; `None` where there were too many for that.
    pub certain_to_mm: Option<f64>,
    pub gain: Vec<RoomGain>,
    /// What the sensors come to when they are built less exactly than is stated; `None` without a gain, or where
    /// no less is stated.
    pub roughly_built: Option<RoughlyBuilt>,
    /// Bodies whose sensors are close together in the best layout.
    pub crowded: Vec<Crowding>,
    pub binding: Vec<Binding>,
    pub flatness: Vec<Flatness>,
    /// What the sensors of the best layout leave open, one statement each.
    pub undetermined: Vec<String>,
    /// Whether it was stopped before its end.
    pub is_stopped: bool,
    /// What is to be known of the result, one statement each.
    pub notes: Vec<String>,
}

impl Optimized {
    /// Whether anything is to be changed, for a person.
    pub fn verdict(&self) -> &'static str {
        match (self.is_better, self.gain.is_empty()) {
            (true, _) => "better than the start",
            (false, true) => "no layout is better than the start",
            (false, false) => {
                "not shown to be better than the start: the interval of the gain holds zero"
            }
        }
    }

    /// What a rougher workshop makes of start and best, for a person; `text` writes an objective.
    pub fn roughly_built_words(&self, text: impl Fn(f64) -> String) -> Option<String> {
        let RoughlyBuilt { position_mm, angle_deg, start, best } = self.roughly_built?;
        let [start, best] = [start, best].map(text);
        Some(format!(
            "Built within {position_mm} mm and {angle_deg}° it has {best}, the start {start}"
        ))
    }

    /// Of a search that was ended before it had judged a layout.
    pub(crate) fn of_start(start: Layout, evaluations: u64, notes: Vec<String>) -> Self {
        Self {
            best: start.clone(),
            is_better: false,
            candidates: Vec::new(),
            pareto: Vec::new(),
            evaluations,
            certain_to_mm: None,
            gain: Vec::new(),
            roughly_built: None,
            crowded: Vec::new(),
            binding: Vec::new(),
            flatness: Vec::new(),
            undetermined: Vec::new(),
            is_stopped: true,
            notes,
            start,
        }
    }
}

/// The best layout against the start in one room, in fields that the search did not see.
#[derive(Clone, Debug, PartialEq)]
pub struct RoomGain {
    /// The environment's name.
    pub room: String,
    /// One of each of [`METRICS`](trackwright_simulation::METRICS); empty where a study has no figures.
    pub differences: Vec<Difference>,
}

/// Start and best with [`BuiltError::rough`](crate::BuiltError::rough).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RoughlyBuilt {
    pub position_mm: f64,
    pub angle_deg: f64,
    /// As [`Layout::objective`].
    pub start: f64,
    pub best: f64,
}

/// A constraint without which a better layout was near.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Binding {
    /// `tool` or `crf`.
    pub body: &'static str,
    pub sensor: String,
    #[serde(flatten)]
    pub constraint: Constraint,
}

/// How far one sensor may be from its best place.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Flatness {
    /// `tool` or `crf`.
    pub body: &'static str,
    pub sensor: String,
    /// The least way, in the direction that matters most, that makes the objective 5 % larger.
    /// `None` where no way within the regions does.
    pub within_mm: Option<f64>,
}

/// Its key in files.
pub(crate) fn body_key(body: PlacedBody) -> &'static str {
    match body {
        PlacedBody::Tool => "tool",
        PlacedBody::Crf => "crf",
    }
}

/// Most sensors that move: the work grows with the square of their number and of their places, and no
/// tracker reads as many.
pub(crate) const MAX_MOVING: usize = 32;

/// Why nothing was searched.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum OptimizeError {
    #[error("nothing is required of the design, and no figure is named that is to be made least")]
    NothingRequired,
    #[error(transparent)]
    NoFigures(#[from] NoFigures),
    #[error("nothing may move")]
    NothingMoves,
    #[error("{found} sensors are to move, expected at most {MAX_MOVING}")]
    TooManyMove { found: usize },
    #[error("no room to search in")]
    NoRoom,
    #[error("the {body} has {sensors} sensors, number {sensor} is none of them")]
    NoSensor { body: &'static str, sensor: usize, sensors: usize },
    #[error("the design has no CRF whose sensors could move")]
    NoCrf,
    #[error("the {body} has neither a mesh nor mounting regions that its sensors could be put at")]
    NoRegion { body: &'static str },
    #[error(
        "no place of the {body} holds the coil of {sensor}: {}", places_words(*.tried, .most_common)
    )]
    NoPlace {
        body: &'static str,
        sensor: String,
        /// Places of its mounting regions that were looked at.
        tried: usize,
        /// What stands in the way at most of them.
        most_common: Option<Constraint>,
    },
    #[error("the {body}'s regions do not hold {sensors} sensors beside each other")]
    TooMany { body: &'static str, sensors: usize },
    #[error("{least} to {most} sensors of the {body}, of which {fixed} do not move")]
    Count { body: &'static str, least: usize, most: usize, fixed: usize },
    #[error(
        "a bound on how far a pose is moved or a sensor is built off is {found}, expected {expected}"
    )]
    Bounds { found: f64, expected: &'static str },
    #[error(
        "the anatomy {anatomy:?} has a crf_patch and no surface that it could be of: expected a mesh \
         that can be read"
    )]
    NoPatchSurface { anatomy: String },
    #[error(
        "no point of the surface of the anatomy {anatomy:?} is in its crf_patch: the nearest corner is \
         {off_mm:.1} mm away"
    )]
    EmptyPatch { anatomy: String, off_mm: f64 },
    #[error(
        "the CRF does not stand on the crf_patch of the anatomy {anatomy:?}: the point of the surface \
         that is nearest to the CRF is ({}) mm in the mesh's frame, {off_mm:.1} mm beside the patch",
        foot_mm.map(|own| format!("{own:.1}")).join(", ")
    )]
    BesidePatch { anatomy: String, foot_mm: [f64; 3], off_mm: f64 },
    #[error(
        "found a crf_patch on the anatomy {}, expected one at most",
        anatomy.iter().map(|name| format!("{name:?}")).collect::<Vec<_>>().join(" and ")
    )]
    SeveralPatches { anatomy: Vec<String> },
    #[error(transparent)]
    Study(#[from] StudyError),
}

impl From<Cancelled> for OptimizeError {
    fn from(_: Cancelled) -> Self {
        Self::Study(StudyError::Cancelled)
    }
}

fn places_words(tried: usize, most_common: &Option<Constraint>) -> String {
    match (tried, most_common) {
        (0, _) => "its mounting regions are shorter than the coil".to_owned(),
        (_, None) => format!("{tried} places of its mounting regions were tried"),
        (_, Some(constraint)) => {
            let words = constraint.words();
            format!("{tried} places of its mounting regions were tried; at most of them it {words}")
        }
    }
}
