//! Slides: what a design shows to people who do not design it, saved with it and edited like it.

use super::view::View;
use serde::{Deserialize, Serialize};

/// One picture with words: how the scene is looked at, and its text.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Slide {
    pub title: String,
    /// A sentence or two below the picture.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub caption: String,
    /// Figures in plain words, from above.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub figures: Vec<SlideFigure>,
    /// Camera, layers, slice, magnification. Without a camera the one before it stays.
    pub view: View,
}

/// A figure of the design's study, stated in plain words.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum SlideFigure {
    /// The part of the poses whose tip error is within the requirement.
    WithinLimit,
    TypicalTipError,
    LargestTipError,
    TypicalAngleError,
}

impl SlideFigure {
    pub const ALL: [Self; 4] =
        [Self::WithinLimit, Self::TypicalTipError, Self::LargestTipError, Self::TypicalAngleError];

    /// What a list of them calls it.
    pub fn name(self) -> &'static str {
        match self {
            Self::WithinLimit => "positions within the limit",
            Self::TypicalTipError => "typical tip error",
            Self::LargestTipError => "largest tip error",
            Self::TypicalAngleError => "typical angle error",
        }
    }
}
