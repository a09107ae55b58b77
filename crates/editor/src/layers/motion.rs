//! Balls in the scene that drag the ends of the range of motion; its lines are a layer of
//! [shapes](super::shapes).
//!
//! Where balls are, and what a drag makes of the motion, is the core's
//! ([`trackwright_simulation::motion_outline`]). Balls are there while nothing is selected, which is when the
//! panel beside the scene shows the motion's numbers; not in the Field workspace, which is about the
//! room; and not while a trial is shown, which has the tool elsewhere.

use super::pivot_ball::{PivotBall, place_pivot};
use crate::document::requests::OpenWorld;
use crate::document::selection::Selection;
use crate::document::shown::ShownDesign;
use crate::palette;
use crate::schedule::EditorSystems;
use crate::shell::window::{Presentation, Workspace};
use crate::viewport::ball_handle::{BallHandle, Balls, SMALL_PX};
use crate::viewport::camera::Sight;
use crate::viewport::fine_pointer::DragKeys;
use crate::viewport::scene_drag::{self, SceneDrag};
use crate::widgets::basic::{THIN_SPACE, counted, signed};
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use trackwright_design::Edit;
use trackwright_scene::shapes::outline_of;
use trackwright_simulation::Motion;
use trackwright_simulation::motion_outline::{HeldEnd, MotionHandle, MotionOutline, RangeEnd};

/// With Ctrl ends are rounded to this.
const ROUND_MM: f64 = 1.0;
const ROUND_DEG: f64 = 5.0;

/// Draws the balls while the layer is on and the design has a motion.
pub struct MotionPlugin;

/// A ball that drags one end of an axis.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub struct MotionBall(pub MotionHandle);

/// What a drag reads.
#[derive(SystemParam)]
pub struct Grip<'w> {
    sight: Sight<'w>,
    keys: DragKeys<'w>,
}

impl Plugin for MotionPlugin {
    fn build(&self, app: &mut App) {
        let place = (place_balls, place_pivot).run_if(is_due).in_set(EditorSystems::Draw);
        app.add_plugins((scene_drag::plugin::<MotionBall>, scene_drag::plugin::<PivotBall>))
            .add_systems(Update, place);
    }
}

/// What balls are placed by.
#[derive(SystemParam)]
pub(super) struct Shown<'w> {
    world: Option<Res<'w, OpenWorld>>,
    design: Option<Res<'w, ShownDesign>>,
    selection: Res<'w, Selection>,
    presentation: Res<'w, Presentation>,
    workspace: Res<'w, Workspace>,
}

impl Shown<'_> {
    /// `None` while the layer is off, and where there is no motion that can be visited.
    pub(super) fn outline(&self) -> Option<MotionOutline> {
        let document = &self.world.as_ref()?.0.document;
        // It is where the design has the bodies, not where a tracker has them.
        if self.workspace.shows_live {
            return None;
        }
        match document.view().layers.motion {
            true => outline_of(document.design()),
            false => None,
        }
    }

    pub(super) fn has_balls(&self) -> bool {
        self.presentation.window
            && self.workspace.edits_design
            && self.selection.primary().is_none()
            && self.design.as_ref().is_none_or(|shown| shown.trial.is_none())
    }
}

fn is_due(shown: Shown) -> bool {
    let is_changed = |world: &Res<OpenWorld>| world.is_changed();
    shown.world.as_ref().is_some_and(is_changed)
        || shown.design.as_ref().is_some_and(|design| design.is_changed())
        || shown.selection.is_changed()
        || shown.workspace.is_changed()
}

/// One a handle.
fn place_balls(shown: Shown, mut balls: Balls<MotionBall>) {
    let outline = shown.has_balls().then(|| shown.outline()).flatten();
    let wanted = outline.unwrap_or_default().handles.into_iter().map(|handle| {
        let place = BallHandle { at_mm: handle.at_mm, radius_px: SMALL_PX };
        (MotionBall(handle), place, words(&handle))
    });
    let is_same = |a: &MotionBall, b: &MotionBall| (a.0.axis, a.0.end) == (b.0.axis, b.0.end);
    balls.place("motion handle", |_| palette::MOTION, wanted, is_same);
}

impl SceneDrag for MotionBall {
    type Held = HeldEnd;
    type Grip = Grip<'static>;

    fn take(&self, grip: &Grip, _: &Selection, at: Vec2) -> Option<HeldEnd> {
        let motion = grip.sight.world.as_ref()?.0.document.design().motion?;
        self.0.take(&motion, &grip.sight.ray(at)?)
    }

    fn label(_: &HeldEnd) -> String {
        "Set range of motion".to_owned()
    }

    fn edit(held: &mut HeldEnd, grip: &Grip, at: Vec2) -> Option<(Edit, String)> {
        let round_to = match held.handle().axis {
            0..3 => ROUND_MM,
            _ => ROUND_DEG,
        };
        let round_to = grip.keys.is_snapping().then_some(round_to);
        let motion = held.motion_at(&grip.sight.ray(at)?, round_to)?;
        let text = readout_text(held.handle(), &motion);
        Some((Edit::SetMotion(Some(motion)), text))
    }
}

/// What dragging its ball does.
fn words(handle: &MotionHandle) -> String {
    let (name, _) = Motion::default().axes()[handle.axis];
    let (verb, step) = match handle.axis {
        0..3 => ("shift", format!("{ROUND_MM:.0}\u{2009}mm")),
        _ => ("turn", format!("{ROUND_DEG:.0}°")),
    };
    let end = match handle.end {
        RangeEnd::Min => "begins",
        RangeEnd::Max => "ends",
    };
    format!("Drag to set where the {verb} {name} {end} · Ctrl rounds to {step} · Esc takes it back")
}

/// `x to +45 mm   375 poses`.
fn readout_text(handle: &MotionHandle, motion: &Motion) -> String {
    let (name, range) = motion.axes()[handle.axis];
    let Some(range) = range else {
        return name.to_owned();
    };
    let value = handle.end.of(&range);
    let decimals = if value.fract() == 0.0 { 0 } else { 1 };
    let value = signed(value, decimals);
    let unit = match handle.axis {
        0..3 => format!("{THIN_SPACE}mm"),
        _ => "°".to_owned(),
    };
    let end = match handle.end {
        RangeEnd::Min => "from",
        RangeEnd::Max => "to",
    };
    let poses = match motion.trials() {
        Ok(trials) => counted(trials, "pose", "poses"),
        // The document reports why it refuses.
        Err(_) => "too many poses".to_owned(),
    };
    format!("{name} {end} {value}{unit}   {poses}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Point3, Vector3};
    use trackwright_simulation::AxisRange;
    use trackwright_simulation::motion_outline::HandlePath;

    #[test]
    fn a_handle_readout_names_axis_end_unit_and_poses() {
        let range = |min, max, step| Some(AxisRange { min, max, step });
        let motion =
            Motion { x: range(-50.0, 45.0, 5.0), rz: range(-22.5, 0.0, 22.5), ..Motion::default() };
        let text = |axis, end| {
            let handle = MotionHandle {
                axis,
                end,
                at_mm: Point3::origin(),
                path: HandlePath::Line(Vector3::x_axis()),
            };
            readout_text(&handle, &motion)
        };
        assert_eq!(text(0, RangeEnd::Max), "x to +45\u{2009}mm   40 poses");
        assert_eq!(text(5, RangeEnd::Min), "rz from \u{2212}22.5°   40 poses");
    }
}
