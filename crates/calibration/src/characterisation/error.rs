//! Why recordings do not characterise a room, and why a pair of them is not used.

use crate::hand_eye::HandEyeError;
use crate::time_alignment::AlignmentError;
use trackwright_simulation::recording::ToolChoiceError;
use trackwright_task::Cancelled;

/// Why a pair is not used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PairProblem {
    #[error("the reference tracker has no good sample")]
    NoReference,
    #[error("the EM tracker has no good sample of any sensor")]
    NoSensor,
    #[error("the body moved while it should have stood still")]
    Moved,
    #[error("the {0} has neither times nor frame numbers that all good samples have")]
    NoClock(&'static str),
    #[error("{0}")]
    Alignment(#[from] AlignmentError),
    #[error("no sample lies between two of the reference's that are near enough")]
    NoOverlap,
    #[error("all its readings are too far from where they should be")]
    AllTooFar,
}

#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CharacterisationError {
    #[error("found no sensor with {wanted:?} in its name, expected one of {}", .names.join("; "))]
    NoSuchSensor { wanted: String, names: Vec<String> },
    #[error(
        "sensor {0} has no roll in any sample: a 5-DOF sensor, and only 6-DOF ones can be characterised; name \
         those"
    )]
    FiveDof(String),
    #[error("pair {} of recordings: reference: {cause}", pair + 1)]
    ReferenceTool { pair: usize, cause: ToolChoiceError },
    #[error("none of {pairs} pairs of recordings can be used; the first: {first}")]
    NoPairs { pairs: usize, first: PairProblem },
    #[error(transparent)]
    HandEye(#[from] HandEyeError),
    #[error(
        "sensor {name}: all its readings are more than {max_mm} mm or {max_deg:.0}° from where the others put it; \
         do the files belong together?"
    )]
    AllTooFar { name: String, max_mm: f64, max_deg: f64 },
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
