//! How far the tracker's jitter scatters the tip, and how far its distortion shifts it.
//!
//! [`first_order()`] is the formula, cheap enough for every step of a drag; [`check_first_order`]
//! shows whether it holds; [`monte_carlo()`] is the answer without it; [`over_motion`] is the
//! formula at every pose of a range of motion.

mod check;
mod ellipsoid;
mod error;
mod first_order;
mod monte_carlo;
mod motion;
mod report;
mod section;
mod still;

pub use check::{FirstOrderCheck, TOLERANCE, check_first_order};
pub use ellipsoid::{CHI_SQUARED_95_OF_3, Ellipsoid};
pub use error::{MAX_SAMPLES, MIN_SAMPLES, UncertaintyError};
pub use first_order::{BiasCheck, DeterminedPart, TipUncertainty, first_order};
pub use monte_carlo::{Estimate, MonteCarlo, monte_carlo};
pub use motion::{MotionUncertainty, over_motion};
pub use report::{DEFAULT_SAMPLES, Sampling, UncertaintyMethods, UncertaintyReport};
