//! What a study's figures are to be expected to be, and how far off: the same trials in fields drawn
//! from what the room's measurements leave possible.
//!
//! The figures of the room's model alone are those of a mean field, which is smoother than the truth:
//! errors have squares, so that a mean over drawn fields is larger (`E|e|² = |E e|² + tr cov e`).

mod drawn_trials;
mod figures;
mod more_rows;

pub(super) use drawn_trials::DrawnTrials;
pub use figures::{Expected, ExpectedError, ExpectedWithin, expected};
pub(super) use figures::{WIDENING, expected_of};
pub use more_rows::{MoreMeasuring, more_measuring, most_times, shrinking};
