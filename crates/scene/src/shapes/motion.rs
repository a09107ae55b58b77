//! The range of motion: the box that its shifts take the tip through, and the fans of its turns.

use super::{Form, LegendLine, Shape, ShapeLayer, Shown};
use crate::palette::MOTION;
use nalgebra::Point3;
use trackwright_design::view::Layer;
use trackwright_design::{BodyRole, Design};
use trackwright_geometry::pose::Pose;
use trackwright_simulation::motion_outline::{MotionOutline, motion_outline};

pub const LAYER: ShapeLayer = ShapeLayer { row: &Layer::MOTION, color: MOTION, shapes, legend };

const LINE_ALPHA: f64 = 0.65;
const MARK_ALPHA: f64 = 0.45;
const STEM_ALPHA: f64 = 0.35;

/// `None` where there is no motion, or one that cannot be visited.
pub fn outline_of(design: &Design) -> Option<MotionOutline> {
    let tracker_from_crf = design.tracker_from_body(BodyRole::Crf).unwrap_or_else(Pose::identity);
    let tool = &design.tool;
    let motion = design.motion.as_ref()?;
    motion_outline(motion, &tool.body.rigid, &tool.crf_from_tool, &tracker_from_crf).ok()
}

/// It is where the design has the bodies, not where a tracker has them.
fn outline(shown: &Shown) -> Option<MotionOutline> {
    (!shown.is_live).then(|| outline_of(shown.design)).flatten()
}

fn shapes(shown: &Shown) -> Vec<Shape> {
    let Some(outline) = outline(shown) else {
        return Vec::new();
    };
    let strips = |pairs: Vec<[Point3<f64>; 2]>| pairs.into_iter().map(|pair| pair.to_vec());
    let (arcs, spokes): (Vec<_>, Vec<_>) =
        outline.fans.into_iter().map(|fan| (fan.arc, fan.spokes)).unzip();
    let edges = strips(outline.edges).chain(arcs).collect();
    let marks = strips(outline.marks).chain(strips(spokes.concat())).collect();
    let lines = [
        ("range of motion", edges, LINE_ALPHA),
        ("trials of the motion", marks, MARK_ALPHA),
        ("motion beyond its last trial", outline.stems, STEM_ALPHA),
    ];
    let lines = lines.into_iter();
    lines.map(|(name, strips, alpha)| Shape::new(name, Form::Lines { strips, alpha })).collect()
}

fn legend(shown: &Shown) -> Option<LegendLine> {
    let words = "range of motion";
    outline(shown).map(|_| LegendLine {
        words: words.to_owned(),
        plain_words: words.to_owned(),
        is_magnified: false,
    })
}
