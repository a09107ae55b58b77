//! Scales of what is drawn: magnification of errors and colour bars.

use bevy::prelude::*;
use trackwright_design::view::ColorMap;

/// The magnification of errors, ghost and vectors as drawn.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct ShownMagnification {
    pub times: f64,
    /// The ghost's turn would be too large and is drawn smaller.
    pub is_capped: bool,
}

/// The colour scale of the error map as drawn.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct ColorScale {
    pub map: ColorMap,
    pub max_mm: f64,
}

/// A colour bar in the legend.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorBar {
    pub label: String,
    pub unit: &'static str,
    pub map: ColorMap,
    /// Where the colours begin and end.
    pub min: f64,
    pub max: f64,
    /// The largest value there is, which may be beyond the end.
    pub largest: f64,
    /// Digits after the point of single values.
    pub decimals: usize,
    /// What the requirement says about such a value.
    pub limit: Option<f64>,
}
