//! Why a study has no outcome.

use super::motion::MotionError;

/// Why a study has no outcome.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StudyError {
    #[error("cancelled")]
    Cancelled,
    #[error("the design has no range of motion")]
    NoMotion,
    #[error(transparent)]
    Motion(#[from] MotionError),
    #[error("no poses to simulate")]
    NoTrials,
    #[error("all {trials} trials were left out: each has a sensor outside the model's box")]
    AllRejected { trials: usize },
    #[error("{body} has no sensors")]
    NoSensors { body: String },
}
