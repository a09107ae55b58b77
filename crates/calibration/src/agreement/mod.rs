//! The built tool against its design (step 6 of the paper's procedure): recorded errors of the tip
//! beside those that the study predicts for the very same poses, and how far the two agree.
//!
//! Recorded poses ([`RecordedPose`], or a pivoted tool) become rows of a measured and a predicted
//! error ([`paired_rows`], [`pivot_rows`]), and [`agreement()`] reports of the rows:
//!
//! - what part of the squared error is explained, `1 − Σ|m − p|² / Σ|m|²`: 1 for a perfect
//!   prediction, 0 for predicting no error at all, below that for one that does harm. Vectors are
//!   compared, not their lengths: two errors of one length in opposite directions do not agree, so
//!   no correlation of lengths is given;
//! - the slope `Σ m·p / Σ |p|²`, 1 where the prediction has the right size;
//! - the mean of the difference with its intervals (Student) and Hotelling's T² for a mean of zero
//!   (Hotelling, *Ann. Math. Stat.* 2, 1931);
//! - limits of agreement of the two lengths (Bland & Altman, *Stat. Methods Med. Res.* 8, 1999), the
//!   form in which two ways of measuring are compared in medicine;
//! - whether the difference is larger than the noise that the room states: the mean of
//!   `(m − p)ᵀ C⁻¹ (m − p)` against the quantiles of χ² (Bar-Shalom, Li & Kirubarajan, *Estimation
//!   with Applications to Tracking and Navigation*, 2001, 5.4).
//!
//! Poses next to each other are not independent: a hand moves slowly through a smooth field. What
//! that leaves of their number is estimated (`calibration/dependence.rs`), and intervals come from
//! resampling blocks of neighbours (`resampling.rs`).
//!
//! Where the recording itself decided a registration or a tip, it took up a part of the error.
//! `unknowns.rs` takes the same part out of the prediction.

mod frames;
pub mod judge;
pub mod noise;
mod recording;
pub mod resampling;
mod rows;
mod section;
mod unknowns;
mod verdict;

pub use crate::dependence::MIN_EFFECTIVE;
pub use frames::{APART_MM, CommonFrame, FrameMismatch, frame_mismatch};
pub use judge::{PivotedError, PivotedTool, agreement, pivoted_tool};
pub use recording::{BuiltRecording, RecordedFrame};
pub use rows::{AgreementRow, RecordedPose, paired_rows, pivot_rows, tip_in_crf};
pub use verdict::Verdict;

use serde::Serialize;
use trackwright_field::OutsidePolicy;
use trackwright_simulation::Statistics;
use trackwright_simulation::figure::Figures;
use trackwright_simulation::run::StudyError;
use trackwright_task::Cancelled;

/// Fewest poses that give a result: with fewer, an interval is wider than what it is about.
pub const MIN_POSES: usize = 10;

/// Poses closer together than this (RMS) are one pose: a still sensor scatters by some tenths.
pub const MIN_SPREAD_MM: f64 = 1.0;
pub const MIN_SPREAD_DEG: f64 = 1.0;

/// What was found with the help of the recording itself, and so fits it better than it should.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Unknowns {
    /// Nothing: the truth was known beforehand.
    #[default]
    None,
    /// How the reference tracker stands, and where its marker or the tip is on the tool.
    Registration,
    /// The point in which the tip rested, and the tip's place on the tool.
    Pivot,
}

/// How rows are judged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AgreementSettings {
    pub unknowns: Unknowns,
    /// For poses with a sensor outside the model's box; [`OutsidePolicy::Reject`] leaves them out.
    pub outside: OutsidePolicy,
    /// Whether poses count that lean on field which the samples do not support.
    pub keeps_unsupported: bool,
    /// Readings that each recorded pose is the mean of: its jitter is smaller by their root.
    pub averaged: f64,
    /// Standard deviation of the true tip, an axis.
    pub truth_std_mm: f64,
    pub resamples: usize,
    pub seed: u64,
}

impl AgreementSettings {
    /// The ends of a 95 % interval then lie on the 50th value from either side.
    pub const RESAMPLES: usize = 2000;
}

impl Default for AgreementSettings {
    fn default() -> Self {
        Self {
            unknowns: Unknowns::None,
            outside: OutsidePolicy::Reject,
            keeps_unsupported: true,
            averaged: 1.0,
            truth_std_mm: 0.0,
            resamples: Self::RESAMPLES,
            seed: 0,
        }
    }
}

/// Measured against predicted, row by row and as a whole.
#[derive(Clone, Debug, PartialEq)]
pub struct Agreement {
    /// All that were recorded, in order. Errors of those that count are without what the
    /// recording's own registration takes up.
    pub rows: Vec<AgreementRow>,
    pub summary: Summary,
    /// What is known of the predicted errors of the poses that count, likewise.
    pub figures: Figures,
}

/// The whole.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    pub poses: usize,
    pub used: usize,
    /// Left out: a sensor outside the model's box.
    pub outside: usize,
    /// Poses without model validity; `None` where the room does not state it.
    pub unsupported: Option<usize>,
    pub unknowns: Unknowns,
    pub position_mm: Compared,
    /// Of the rotation vectors; `None` of a pivoted tool, whose true turns nobody knows.
    pub angle_deg: Option<Compared>,
    /// Effective number of independent poses among the used ones.
    pub effective: f64,
    /// Mean length of the blocks that were resampled.
    pub block: f64,
    pub noise: Option<NoiseCheck>,
    /// RMS of the tip for the room's own misfit, independent from sensor to sensor.
    pub room_misfit_rms_mm: Option<f64>,
    pub verdict: Verdict,
    pub statement: String,
}

/// Measured and predicted vectors of one kind, in its unit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Compared {
    pub measured: Statistics,
    pub predicted: Statistics,
    /// Of measured minus predicted.
    pub residual: Statistics,
    /// Part of the squared error; `None` where nothing was measured but zero.
    pub explained: Option<Interval>,
    /// The same of what changes from pose to pose, without the means of both.
    pub explained_of_variation: Option<Interval>,
    /// What the prediction has to be multiplied by to fit best.
    pub slope: Option<Interval>,
    /// `None` where a registration of the recording took the mean.
    pub bias: Option<Bias>,
    pub lengths: Option<LimitsOfAgreement>,
}

/// A figure with its 95 % interval, which is `None` where too few poses are independent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Interval {
    pub value: f64,
    pub low: Option<f64>,
    pub high: Option<f64>,
}

/// The mean of measured minus predicted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bias {
    pub mean: [f64; 3],
    /// Half the 95 % interval of each component by itself.
    pub half_width: Option<[f64; 3]>,
    /// Of Hotelling's test for a mean of zero.
    pub p: Option<f64>,
}

/// Bland and Altman: length of the measured minus that of the predicted error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LimitsOfAgreement {
    pub bias: Interval,
    /// `bias ∓ 1.96` standard deviations.
    pub lower: Interval,
    pub upper: Interval,
}

/// The difference against the noise that the room states.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct NoiseCheck {
    /// RMS that the noise alone would give.
    pub rms_mm: f64,
    /// Includes the jitter of the tracker, the standard error of the field.
    pub has_jitter: bool,
    pub has_field_error: bool,
    /// Mean of the normalised squares of measured minus predicted, over three: 1 is expected.
    pub normalised: f64,
    /// The same of the measured error by itself, in units of jitter and truth alone: the field's
    /// error is the prediction's. `None` where the room states no jitter.
    pub normalised_measured: Option<f64>,
    /// Where 95 % of such means lie; `None` where too few poses are independent.
    pub accepted: Option<[f64; 2]>,
}

impl NoiseCheck {
    /// The difference is no larger than the noise.
    pub fn is_only_noise(&self) -> Option<bool> {
        self.accepted.map(|[_, high]| self.normalised <= high)
    }

    /// There was nothing but noise to predict.
    pub fn has_nothing_to_explain(&self) -> Option<bool> {
        let [_, high] = self.accepted?;
        self.normalised_measured.map(|measured| measured <= high)
    }
}

#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AgreementError {
    #[error(
        "{used} of {poses} poses can be used ({outside} have a sensor outside the room's box, {unsupported} are left \
         out as not supported), expected at least {MIN_POSES}"
    )]
    TooFew { poses: usize, used: usize, outside: usize, unsupported: usize },
    #[error(
        "all {poses} poses are the same: the tip scatters by {spread_mm:.2} mm RMS and the tool turns by \
         {spread_deg:.2}°, expected at least {MIN_SPREAD_MM} mm or {MIN_SPREAD_DEG}°; record the tool all over where \
         it will be used"
    )]
    OnePose { poses: usize, spread_mm: f64, spread_deg: f64 },
    #[error("pose {0} holds what is no number")]
    NotFinite(usize),
    #[error(
        "the sensors of {body} leave its rotation free, so that the tip of the built tool is nowhere in particular; \
         there is nothing to compare"
    )]
    FreeRotation { body: String },
    #[error("the room has no model validity, so nothing can be left out by it")]
    NoSupport,
    #[error(
        "{found} is no number of readings, standard deviation or count of resamplings: {name}, expected {expected}"
    )]
    Setting { name: &'static str, found: f64, expected: &'static str },
    #[error(transparent)]
    Study(#[from] StudyError),
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
