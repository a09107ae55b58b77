//! Why samples are not sent on, and how many were.

use crate::codec::StatusCode;
use std::collections::BTreeMap;

/// Why a sample is not sent on, or a tool is not good.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, thiserror::Error)]
pub enum Reason {
    #[error("the tracker does not stand by it")]
    NotTracked,
    #[error("its numbers are no pose")]
    NoPose,
    #[error("it has no orientation")]
    NoOrientation,
    #[error("its samples are late")]
    Late,
    #[error("its timestamps are ahead of those before")]
    Early,
    #[error("a later one came before it")]
    OutOfOrder,
    #[error("it is the last one once more")]
    Repeated,
    #[error("it is in another frame than the tracker's")]
    OtherFrame,
    #[error("it is outside the box that the room was measured in")]
    OutsideModel,
    #[error("the room's map folds there")]
    Folded,
    #[error("more than one pose would be measured like it")]
    Ambiguous,
    #[error("no pose was found that would be measured like it")]
    NotConverged,
    #[error("it is in the room's metal, where nothing is read")]
    InMetal,
    #[error("too many tools were named before it")]
    TooManyTools,
    #[error("its name is empty or no text")]
    NoName,
    #[error("no sample came in time")]
    Stale,
    #[error("the tracker's server is not there")]
    LinkLost,
    #[error("the session ends")]
    SessionEnds,
}

impl Reason {
    /// The reason in one word of 20 letters at most, as a STATUS message has it.
    pub fn name(self) -> &'static str {
        match self {
            Self::NotTracked => "NOT_TRACKED",
            Self::NoPose => "NO_POSE",
            Self::NoOrientation => "NO_ORIENTATION",
            Self::Late => "LATE",
            Self::Early => "EARLY",
            Self::OutOfOrder => "OUT_OF_ORDER",
            Self::Repeated => "REPEATED",
            Self::OtherFrame => "OTHER_FRAME",
            Self::OutsideModel => "OUTSIDE_MODEL",
            Self::Folded => "FOLDED",
            Self::Ambiguous => "AMBIGUOUS",
            Self::NotConverged => "NOT_CONVERGED",
            Self::InMetal => "IN_METAL",
            Self::TooManyTools => "TOO_MANY_TOOLS",
            Self::NoName => "NO_NAME",
            Self::Stale => "STALE",
            Self::LinkLost => "LINK_LOST",
            Self::SessionEnds => "SESSION_ENDS",
        }
    }

    pub(super) fn status(self) -> StatusCode {
        match self {
            Self::Stale | Self::Late | Self::Early => StatusCode::TIME_OUT,
            Self::NotTracked | Self::LinkLost => StatusCode::NOT_PRESENT,
            _ => StatusCode::NOT_READY,
        }
    }

    /// Whether it speaks of one sample only: the tool is as good as it was until it is stale.
    pub(super) fn is_of_the_sample(self) -> bool {
        matches!(self, Self::Late | Self::Early | Self::OutOfOrder | Self::Repeated)
    }
}

/// Whether a tool is good.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ToolState {
    Good,
    NotGood(Reason),
}

/// What a relay has done. Poses are either sent or dropped.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RelayCounts {
    /// Of any known type.
    pub messages: u64,
    /// Samples of tools in them; a message of tracking data has several.
    pub poses: u64,
    pub sent: u64,
    /// Of those sent: ambiguous ones, of which the tool can have come to one pose only.
    pub followed: u64,
    pub dropped: BTreeMap<Reason, u64>,
    /// How often a tool's clock was taken to have been set.
    pub clock_jumps: u64,
    /// How often a good tool became one that no sample came of in time.
    pub went_stale: u64,
}
