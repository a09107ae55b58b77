//! What a slice may show: the field's error, what it does to the tool, the model validity.

use super::requirement::Requirement;
use serde::{Deserialize, Serialize};

/// A quantity at each point of a slice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Quantity {
    /// Length of the position error (6).
    #[default]
    PositionErrorMm,
    /// Angle of the orientation error (7).
    OrientationErrorDeg,
    /// Tip error of this tool: turned as the design has it, its tip at the point, the CRF where
    /// the design has it; without a CRF in the tracker frame. It is the study's own trial.
    TipErrorMm,
    /// How many mm the position error changes a mm of the way, in the direction in which it
    /// changes most: the spectral norm of the derivative of the position error by the position.
    /// Unlike the Frobenius norm it is a bound that some direction reaches, whatever the others do.
    GradientMmPerMm,
    /// Predicted standard error of the field's position; NaN where it is not determined.
    StdErrorMm,
    /// Distance to the nearest sample; NaN where an orientation has none.
    SupportDistanceMm,
}

impl Quantity {
    pub const ALL: [Self; 6] = [
        Self::PositionErrorMm,
        Self::OrientationErrorDeg,
        Self::TipErrorMm,
        Self::GradientMmPerMm,
        Self::StdErrorMm,
        Self::SupportDistanceMm,
    ];

    /// For a legend.
    pub fn label(self) -> &'static str {
        match self {
            Self::PositionErrorMm => "position error",
            Self::OrientationErrorDeg => "orientation error",
            Self::TipErrorMm => "tip error of this tool",
            Self::GradientMmPerMm => "gradient of the position error",
            Self::StdErrorMm => "standard error of the field",
            Self::SupportDistanceMm => "distance to the nearest sample",
        }
    }

    /// What its values are in.
    pub fn unit(self) -> &'static str {
        match self {
            Self::OrientationErrorDeg => "°",
            Self::GradientMmPerMm => "mm/mm",
            Self::PositionErrorMm
            | Self::TipErrorMm
            | Self::StdErrorMm
            | Self::SupportDistanceMm => "mm",
        }
    }

    /// Digits after the point that a person is shown.
    pub fn decimals(self) -> usize {
        match self {
            Self::GradientMmPerMm => 4,
            Self::SupportDistanceMm => 1,
            _ => 2,
        }
    }

    /// The requirement's limit for its value at one place, if there is one.
    pub fn limit(self, requirement: &Requirement) -> Option<f64> {
        let (_, limit_mm) = requirement.single_position_mm()?;
        (self == Self::TipErrorMm).then_some(limit_mm)
    }

    /// Whether it depends on the design: tool, CRF and their poses. Any other is the room's alone,
    /// and stays as it is when the tool moves.
    pub fn needs_tool(self) -> bool {
        self == Self::TipErrorMm
    }

    /// Whether only a room that keeps model validity has it.
    pub fn needs_support(self) -> bool {
        matches!(self, Self::StdErrorMm | Self::SupportDistanceMm)
    }
}
