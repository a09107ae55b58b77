//! The sphere of the requirement's radius around the tip, magnified like its error vector, which should
//! end inside.

use super::{Form, LegendLine, Look, Shape, ShapeLayer, Shown};
use crate::palette::REQUIREMENT;
use nalgebra::{Matrix3, Vector3};
use trackwright_design::view::Layer;

pub const LAYER: ShapeLayer =
    ShapeLayer { row: &Layer::REQUIREMENT, color: REQUIREMENT, shapes, legend };

/// A sphere with a larger radius than this share of the view's height would be a frame around
/// everything: the vector ends so deep inside it that it shows nothing.
const LARGEST_SHARE: f64 = 0.6;

/// The limit of a single tip error, mm.
fn limit_mm(shown: &Shown) -> Option<f64> {
    Some(shown.design.requirement?.single_position_mm()?.1)
}

fn shapes(shown: &Shown) -> Vec<Shape> {
    let (Some(limit_mm), Some(tool)) = (limit_mm(shown), shown.tool()) else {
        return Vec::new();
    };
    let center_mm = tool.tip_mm();
    let radius_mm = limit_mm * shown.times;
    if radius_mm / shown.eye.mm_per_px(&center_mm) >= LARGEST_SHARE * shown.eye.view_px[1] {
        return Vec::new();
    }
    let (turn, half_lengths_mm) = (Matrix3::identity(), Vector3::repeat(radius_mm));
    let form = Form::Ellipsoid { center_mm, turn, half_lengths_mm, look: Look::Outline };
    vec![Shape::new(format!("requirement of {limit_mm} mm at the tip"), form)]
}

fn legend(shown: &Shown) -> Option<LegendLine> {
    let words = format!("the tip may be {:.2}\u{2009}mm off", limit_mm(shown)?);
    Some(LegendLine::magnified(&words, &words))
}
