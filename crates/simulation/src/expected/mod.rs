//! What a study's figures are to be expected to be, and how far off: the same trials in fields drawn
//! from what the room's measurements leave possible.
//!
//! The figures of the room's own field are those of a mean field, which is smoother than the truth:
//! errors have squares, so that a mean over drawn fields is larger (`E|e|² = |E e|² + tr cov e`).

mod drawn_trials;
mod figures;
mod more_rows;
mod verdict;

pub(super) use drawn_trials::{DrawnTrials, SensorErrors};
pub use figures::{
    DRAWS, Expected, ExpectedError, ExpectedRow, ExpectedWithin, expected, expected_rows,
    expected_where_measured, spread,
};
pub(super) use figures::{SENSOR_SEED, WIDENING};
pub use more_rows::{MoreMeasuring, more_measuring, most_times, shrinking};
pub use verdict::{
    BoundVerdict, Headline, JudgedBound, RequirementFigures, headline, judged, judged_checks,
    requirement_figures, study_verdict, verdict_of, verdict_of_all,
};
