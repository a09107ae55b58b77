//! Why there is no uncertainty.

use crate::motion::MotionError;
use trackwright_task::Cancelled;

/// Fewest samples: a covariance in three dimensions needs more than three.
pub const MIN_SAMPLES: usize = 10;

/// Most samples: 320 MB of distances.
pub const MAX_SAMPLES: usize = 10_000_000;

/// Why there is no uncertainty to report.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum UncertaintyError {
    #[error("the environment {environment:?} states no jitter")]
    NoJitter { environment: String },
    #[error("{name} is {found}, expected {expected}")]
    Jitter { name: &'static str, found: f64, expected: &'static str },
    #[error("{body} has no sensors")]
    NoSensors { body: String },
    #[error("the pose is left out: {sensors} sensors are outside the model's box")]
    Outside { sensors: usize },
    #[error(
        "the jitter of sensor {sensor:?} of {body} is too large to compute with: \
         {position_mm:e} mm, {angle_rad:e} rad"
    )]
    TooLarge { body: String, sensor: String, position_mm: f64, angle_rad: f64 },
    #[error("{found} samples, expected {MIN_SAMPLES} to {MAX_SAMPLES}")]
    Samples { found: usize },
    #[error("the design has no range of motion")]
    NoMotion,
    #[error(transparent)]
    Motion(#[from] MotionError),
    #[error("all {trials} poses were left out: each has a sensor outside the model's box")]
    AllRejected { trials: usize },
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
