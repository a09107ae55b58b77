//! How far the tracker's jitter scatters the tip, and how far its distortion shifts it.
//!
//! [`first_order()`] is the formula, cheap enough for every step of a drag; [`check_first_order`]
//! says whether it holds; [`monte_carlo()`] is the answer without it; [`over_motion`] is the formula
//! at every pose of a range of motion.

mod check;
mod ellipsoid;
mod first_order;
mod monte_carlo;
mod motion;
mod still;

pub use check::{FirstOrderCheck, TOLERANCE, check_first_order};
pub use ellipsoid::{CHI_SQUARED_95_OF_3, Ellipsoid};
pub use first_order::{BiasCheck, DeterminedPart, TipUncertainty, first_order};
pub use monte_carlo::{Estimate, MAX_SAMPLES, MIN_SAMPLES, MonteCarlo, monte_carlo};
pub use motion::{MotionUncertainty, over_motion};

use super::motion::MotionError;
use trackwright_task::Cancelled;

/// Why there is no uncertainty to tell.
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
