//! A ball at what the turns of the range of motion are about. Dragged, it becomes a point of the tool,
//! or stays one of the CRF.

use super::motion::Shown;
use crate::document::selection::Selection;
use crate::palette;
use crate::viewport::ball_handle::{BallHandle, Balls, LARGE_PX};
use crate::viewport::camera::Sight;
use crate::viewport::fine_pointer::DragKeys;
use crate::viewport::scene_drag::SceneDrag;
use crate::widgets::basic::signed;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use nalgebra::{Point3, Vector3};
use trackwright_design::{BodyRole, Design, Edit};
use trackwright_geometry::pose::Pose;
use trackwright_scene::shapes::outline_of;
use trackwright_simulation::{Motion, Pivot, shaft_in_body};

const WORDS: &str =
    "Drag to set what the turns are about · Ctrl keeps it on the shaft · Esc takes it back";

/// The ball of the tool's pivot.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub struct PivotBall;

/// Where the pivot was, tracker frame.
pub struct HeldPivot {
    start_mm: Point3<f64>,
}

/// What a drag reads.
#[derive(SystemParam)]
pub struct Grip<'w> {
    sight: Sight<'w>,
    keys: DragKeys<'w>,
}

pub(super) fn place_pivot(shown: Shown, mut balls: Balls<PivotBall>) {
    let outline = shown.has_balls().then(|| shown.outline()).flatten();
    let wanted = outline
        .and_then(|outline| outline.pivot_mm)
        .map(|at_mm| (PivotBall, BallHandle { at_mm, radius_px: LARGE_PX }, WORDS.to_owned()));
    balls.place("pivot handle", |_| palette::MOTION, wanted, |a, b| a == b);
}

impl Grip<'_> {
    fn design(&self) -> Option<&Design> {
        Some(self.sight.world.as_ref()?.0.document.design())
    }

    /// Where the pointer has the pivot, tracker frame: in the plane of the view, or on the shaft.
    fn place(&self, held: &HeldPivot, at: Vec2) -> Option<Point3<f64>> {
        let ray = self.sight.ray(at)?;
        if self.keys.is_snapping() {
            let design = self.design()?;
            let body = &design.tool.body.rigid;
            let tracker_from_tool = design.tracker_from_body(BodyRole::Tool)?;
            let tip_mm = tracker_from_tool * body.judged_tip_in_body();
            let shaft = tracker_from_tool.rotation * shaft_in_body(body)?;
            let behind_mm = ray.nearest_on_line(&tip_mm, &shaft)?;
            return Some(tip_mm + *shaft * behind_mm);
        }
        let eye = self.sight.rig.camera.tracker_from_camera().rotation;
        ray.meets_plane(&held.start_mm, &(eye * -Vector3::z()))
    }
}

impl SceneDrag for PivotBall {
    type Held = HeldPivot;
    type Grip = Grip<'static>;

    fn take(&self, grip: &Grip, _: &Selection, _: Vec2) -> Option<HeldPivot> {
        let outline = outline_of(grip.design()?)?;
        Some(HeldPivot { start_mm: outline.pivot_mm? })
    }

    fn label(_: &HeldPivot) -> String {
        "Move pivot".to_owned()
    }

    fn edit(held: &mut HeldPivot, grip: &Grip, at: Vec2) -> Option<(Edit, String)> {
        let design = grip.design()?;
        let motion = design.motion?;
        let tracker_from_crf =
            design.tracker_from_body(BodyRole::Crf).unwrap_or_else(Pose::identity);
        let in_crf = tracker_from_crf.inverse() * grip.place(held, at)?;
        let pivot = motion.pivot.moved_to(&in_crf, &design.tool.crf_from_tool);
        let text = readout_text(&pivot);
        Some((Edit::SetMotion(Some(Motion { pivot, ..motion })), text))
    }
}

/// `pivot at +1.0, −2.5, +50.0 mm of the tool`.
fn readout_text(pivot: &Pivot) -> String {
    let frame = if matches!(pivot, Pivot::Reference(_)) { "CRF" } else { "tool" };
    let at = pivot.point().unwrap_or_default().map(|value| signed(value, 1));
    format!("pivot at {}\u{2009}mm of the {frame}", at.join(", "))
}
