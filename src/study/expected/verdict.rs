//! Whether a requirement is met, as far as a room can tell.

use super::Expected;
use crate::study::comparison::REQUIRED;
use crate::study::requirement::Requirement;
use serde::Serialize;

/// What a 95 % interval says of a bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum BoundVerdict {
    /// The whole interval is within the bound.
    Met,
    /// The whole interval is beyond it.
    Missed,
    /// The bound lies in the interval.
    CannotTell,
}

impl BoundVerdict {
    /// For a person.
    pub fn label(self) -> &'static str {
        match self {
            Self::Met => "met",
            Self::Missed => "missed",
            Self::CannotTell => "cannot tell in this room",
        }
    }
}

/// Each bound of a requirement by its name in a design file, in their order.
pub fn requirement_verdict(
    requirement: &Requirement,
    expected: &Expected,
) -> Vec<(&'static str, BoundVerdict)> {
    let bounds = requirement.bounds().into_iter().zip(REQUIRED);
    let each = bounds.filter_map(|((name, limit), figure)| {
        let (_, [low, high]) = expected.of(figure)?;
        let limit = limit?;
        let verdict = if high <= limit {
            BoundVerdict::Met
        } else if low > limit {
            BoundVerdict::Missed
        } else {
            BoundVerdict::CannotTell
        };
        Some((name, verdict))
    });
    each.collect()
}

/// The requirement as a whole: missed where any bound is, met where all are; `None` without bounds.
pub fn verdict_of(bounds: &[(&'static str, BoundVerdict)]) -> Option<BoundVerdict> {
    if bounds.is_empty() {
        return None;
    }
    let any = |verdict| bounds.iter().any(|(_, other)| *other == verdict);
    Some(if any(BoundVerdict::Missed) {
        BoundVerdict::Missed
    } else if any(BoundVerdict::CannotTell) {
        BoundVerdict::CannotTell
    } else {
        BoundVerdict::Met
    })
}
