//! The tip's error vector.

use super::{Arrow, Form, LegendLine, Shape, ShapeLayer, Shown};
use crate::arrow_style::ArrowStyle;
use crate::palette::ERROR_VECTOR;
use trackwright_design::view::Layer;

pub const LAYER: ShapeLayer = ShapeLayer {
    row: &Layer::TIP_ERROR,
    color: ERROR_VECTOR,
    shapes,
    legend: |_| Some(error_vectors()),
};

/// Of arrows from what is to what the tracker reports.
pub fn error_vectors() -> LegendLine {
    LegendLine::magnified("error vectors, two heads: longer than drawn", "how far off the tip is")
}

fn shapes(shown: &Shown) -> Vec<Shape> {
    let arrow = shown.tool().map(|tool| Arrow {
        from_mm: tool.tip_mm(),
        error_mm: tool.error_mm(),
        times: shown.times,
        style: ArrowStyle::OF_TIP,
    });
    arrow.map(|arrow| Shape::new("error of the tip", Form::Arrow(arrow))).into_iter().collect()
}
