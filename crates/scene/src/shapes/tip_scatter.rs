//! The ellipsoid that holds 95 % of where the tracker's jitter puts the tip, around the ghost's.

use super::{Form, LegendLine, Look, Shape, ShapeLayer, Shown};
use crate::palette::SCATTER;
use nalgebra::{Matrix3, Vector3};
use trackwright_design::view::Layer;

pub const LAYER: ShapeLayer =
    ShapeLayer { row: &Layer::TIP_SCATTER, color: SCATTER, shapes, legend };

const WORDS: &str = "95 % of the tip's jitter";

fn shapes(shown: &Shown) -> Vec<Shape> {
    let (Some(scatter), Some(tool)) = (shown.scatter, shown.tool()) else {
        return Vec::new();
    };
    let tracker_from_crf = shown.tracker_from_crf();
    let axes_mm = scatter.ellipsoid.semi_axes_in_crf_mm.map(|axis| tracker_from_crf * axis);
    // A sphere of no size has no axes.
    let unit = |k: usize| axes_mm[k].try_normalize(0.0);
    let turn = match (unit(0), unit(1)) {
        (Some(a), Some(b)) => Matrix3::from_columns(&[a, b, a.cross(&b)]),
        _ => Matrix3::identity(),
    };
    let form = Form::Ellipsoid {
        center_mm: tool.tip_mm() + tool.error_mm() * shown.times,
        turn,
        half_lengths_mm: Vector3::from(axes_mm.map(|axis| axis.norm())) * shown.times,
        look: Look::Veil,
    };
    let figures = vec![("rms_mm", scatter.rms_mm)];
    vec![Shape { figures, ..Shape::new("95 % of where jitter puts the tip", form) }]
}

fn legend(shown: &Shown) -> Option<LegendLine> {
    shown.scatter.map(|_| LegendLine::magnified(WORDS, WORDS))
}
