//! A ball at the tip that is selected. It is dragged over its body, and snaps as a click that sets
//! the tip does; with Alt it leaves the body and moves in the plane of the view.

use crate::document::requests::OpenWorld;
use crate::document::selection::{Selected, Selection};
use crate::document::shown::ShownDesign;
use crate::palette;
use crate::schedule::EditorSystems;
use crate::shell::window::{Presentation, Workspace};
use crate::viewport::ball_handle::{BallHandle, Balls, LARGE_PX};
use crate::viewport::camera::Sight;
use crate::viewport::fine_pointer::DragKeys;
use crate::viewport::scene_drag::{self, SceneDrag};
use crate::viewport::surfaces::Surfaces;
use crate::viewport::tool::SceneTool;
use crate::viewport::tool::aim::snap_on;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use nalgebra::{Point3, Vector3};
use trackwright_design::{BodyRole, Edit};
use trackwright_geometry::snap::SnapKind;

/// Shows the ball and drags the tip by it.
pub struct TipDragPlugin;

/// The ball of a body's tip.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub struct TipBall(pub BodyRole);

/// The tip that is held.
pub struct HeldTip {
    body: BodyRole,
    start_mm: Point3<f64>,
}

/// What a drag reads.
#[derive(SystemParam)]
pub struct Grip<'w> {
    sight: Sight<'w>,
    surfaces: Res<'w, Surfaces>,
    keys: DragKeys<'w>,
}

impl Plugin for TipDragPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(scene_drag::plugin::<TipBall>)
            .add_systems(Update, place_ball.run_if(is_due).in_set(EditorSystems::Draw));
    }
}

/// What decides whether there is a ball, and where.
#[derive(SystemParam)]
struct Shown<'w> {
    world: Option<Res<'w, OpenWorld>>,
    shown: Option<Res<'w, ShownDesign>>,
    selection: Res<'w, Selection>,
    workspace: Res<'w, Workspace>,
    tool: Res<'w, SceneTool>,
    presentation: Res<'w, Presentation>,
}

impl Shown<'_> {
    fn ball(&self) -> Option<(BodyRole, BallHandle)> {
        let Some(Selected::Tip(role)) = self.selection.primary() else {
            return None;
        };
        let (world, shown) = (self.world.as_ref()?, self.shown.as_ref()?);
        let view = world.0.document.view();
        let is_left_alone = [&view.hidden, &view.locked].iter().any(|own| own.has_body(role));
        // A trial is not what an edit would change, and a picture for a page has no handles.
        let is_edited = self.workspace.edits_design
            && *self.tool == SceneTool::Select
            && shown.trial.is_none()
            && self.presentation.panels;
        if is_left_alone || !is_edited {
            return None;
        }
        let tip = shown.design.body(role)?.rigid.tip_in_body?;
        let at_mm = shown.design.tracker_from_body(role)? * tip;
        Some((role, BallHandle { at_mm, radius_px: LARGE_PX }))
    }
}

fn is_due(on: Shown) -> bool {
    on.world.is_none_or(|world| world.is_changed())
        || on.shown.is_none_or(|shown| shown.is_changed())
        || on.selection.is_changed()
        || on.workspace.is_changed()
        || on.tool.is_changed()
        || on.presentation.is_changed()
}

fn place_ball(shown: Shown, mut balls: Balls<TipBall>) {
    let wanted = shown.ball().map(|(role, place)| {
        let words = format!(
            "Drag to move the tip of the {role} · snaps to corners and shaft ends · Alt frees \
             it · Shift moves finely · Esc takes it back"
        );
        (TipBall(role), place, words)
    });
    balls.place("tip handle", |_| palette::ERROR_VECTOR, wanted, |a, b| a == b);
}

impl Grip<'_> {
    /// Where the held tip is with the pointer at `at`, and what it snapped to.
    fn place(&self, held: &HeldTip, at: Vec2) -> Option<(Point3<f64>, Option<SnapKind>)> {
        let design = self.sight.design()?;
        let ray = self.sight.ray(at)?;
        let body_from_tracker = design.tracker_from_body(held.body)?.inverse();
        let in_body = ray.transformed_by(&body_from_tracker);
        if !self.keys.is_off() {
            let eye = self.sight.eye();
            if let Some(snap) = snap_on(design, &self.surfaces, &ray, &eye, held.body) {
                return Some((snap.at_mm, Some(snap.kind)));
            }
            if let Some(hit) = self.surfaces.of(held.body).and_then(|own| own.cast(&in_body)) {
                return Some((hit.position_mm, None));
            }
        }
        let eye_rotation = self.sight.rig.camera.tracker_from_camera().rotation;
        let forward = body_from_tracker.rotation * (eye_rotation * -Vector3::z());
        Some((in_body.meets_plane(&held.start_mm, &forward)?, None))
    }
}

impl SceneDrag for TipBall {
    type Held = HeldTip;
    type Grip = Grip<'static>;

    fn take(&self, grip: &Grip, _: &Selection, _: Vec2) -> Option<HeldTip> {
        let start_mm = grip.sight.design()?.body(self.0)?.rigid.tip_in_body?;
        Some(HeldTip { body: self.0, start_mm })
    }

    fn label(held: &HeldTip) -> String {
        format!("Move {} tip", held.body)
    }

    fn edit(held: &mut HeldTip, grip: &Grip, at: Vec2) -> Option<(Edit, String)> {
        let (tip, snap) = grip.place(held, at)?;
        let moved_mm = (tip - held.start_mm).norm();
        let moved = format!("moved {moved_mm:.2}\u{2009}mm");
        let text = match snap {
            Some(snap) => format!("{}   {moved}", snap.name()),
            None => moved,
        };
        Some((Edit::SetTip { body: held.body, tip_in_body: Some(tip) }, text))
    }
}
