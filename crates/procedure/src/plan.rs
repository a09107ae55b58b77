//! What the procedure's steps are computed from: a design in its rooms, every file read.

use super::decided::{DecidedRecording, DecidedStudies, RoomName};
use trackwright_calibration::agreement::Summary;
use trackwright_simulation::requirement::Requirement;
use trackwright_simulation::scenario::{CrfScenario, Scenario};

/// A design in its rooms, and what was decided.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Where the CRF is judged, `None` at its tip or origin; empty without a CRF.
    pub crf_targets: Vec<Option<String>>,
    /// Of the CRF's own study.
    pub crf_requirement: Option<Requirement>,
    /// Of the tool's.
    pub requirement: Option<Requirement>,
    /// The design's own first.
    pub rooms: Vec<Room>,
    pub recording: Option<Result<Recording, String>>,
    pub decided_crf: Option<DecidedStudies>,
    pub decided_tool: Option<DecidedStudies>,
    pub decided_built: Option<DecidedRecording>,
}

/// A room that a design is judged in.
#[derive(Clone, Debug)]
pub struct Room {
    pub name: RoomName,
    /// Looked at this once: what was decided is not held against it.
    pub is_for_now: bool,
    /// Or why it is not to be had.
    pub studies: Result<RoomStudies, String>,
}

/// A design's studies in a room.
#[derive(Clone, Debug)]
pub struct RoomStudies {
    /// One a target.
    pub crf: Vec<CrfScenario>,
    pub tool: Scenario,
}

/// A recording of the built tool that was held against its prediction.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// What would be decided on.
    pub found: DecidedRecording,
    pub summary: Summary,
}
