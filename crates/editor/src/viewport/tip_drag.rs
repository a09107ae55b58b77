//! A ball at the tip that is selected. It is dragged over its body, and snaps as a click that sets
//! the tip does; with Alt it leaves the body and moves in the plane of the view.

use crate::document::requests::OpenWorld;
use crate::document::selection::{Selected, Selection};
use crate::document::shown::ShownDesign;
use crate::palette;
use crate::scene::materials::glow::GlowMaterial;
use crate::scene::shapes::GlyphShapes;
use crate::schedule::EditorSystems;
use crate::shell::window::{Presentation, Workspace};
use crate::viewport::ball_handle::{self, BallHandle};
use crate::viewport::camera::Sight;
use crate::viewport::drag_edits::DragEdits;
use crate::viewport::fine_pointer::{DEAD_ZONE_PX, DragKeys, FinePointer};
use crate::viewport::surfaces::Surfaces;
use crate::viewport::tool::SceneTool;
use crate::viewport::tool::aim::snap_on;
use bevy::ecs::system::SystemParam;
use bevy::picking::events::{Drag, DragEnd, DragStart, Pointer};
use bevy::picking::pointer::PointerButton;
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
#[derive(Resource, Default)]
struct HeldTip(Option<Held>);

struct Held {
    body: BodyRole,
    start_mm: Point3<f64>,
    pointer: FinePointer,
}

impl Plugin for TipDragPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<HeldTip>()
            .add_observer(on_drag_start)
            .add_observer(on_drag)
            .add_observer(on_drag_end)
            .add_systems(
                Update,
                let_go_on_escape
                    .run_if(resource_exists::<ButtonInput<KeyCode>>)
                    .in_set(EditorSystems::Input),
            )
            .add_systems(Update, place_ball.in_set(EditorSystems::Draw));
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
        Some((role, BallHandle { at_mm, radius_px: ball_handle::LARGE_PX }))
    }
}

fn place_ball(
    mut commands: Commands,
    shown: Shown,
    mut drawn: Query<(Entity, &TipBall, &mut BallHandle)>,
    shapes: Option<Res<GlyphShapes>>,
    mut materials: ResMut<Assets<GlowMaterial>>,
) {
    let mut wanted = shown.ball();
    for (entity, ball, mut handle) in &mut drawn {
        match wanted {
            Some((role, place)) if role == ball.0 => {
                handle.set_if_neq(place);
                wanted = None;
            }
            _ => commands.entity(entity).despawn(),
        }
    }
    let (Some((role, place)), Some(shapes)) = (wanted, shapes) else {
        return;
    };
    let words = format!(
        "Drag to move the tip of the {role} · snaps to corners and shaft ends · Alt frees it · \
         Shift moves finely · Esc takes it back"
    );
    let material = materials.add(ball_handle::material(palette::ERROR_VECTOR));
    commands.spawn((
        Name::new("tip handle"),
        TipBall(role),
        ball_handle::ball(place, words, &shapes, material),
    ));
}

fn on_drag_start(mut drag: On<Pointer<DragStart>>, balls: Query<(), With<TipBall>>) {
    // The drag begins beyond the dead zone, in `on_drag`.
    if balls.contains(drag.entity) {
        drag.propagate(false);
    }
}

/// What a drag reads.
#[derive(SystemParam)]
struct Grip<'w> {
    sight: Sight<'w>,
    surfaces: Res<'w, Surfaces>,
    keys: DragKeys<'w>,
}

impl Grip<'_> {
    fn take(&self, body: BodyRole, at: Vec2) -> Option<Held> {
        let start_mm = self.sight.design()?.body(body)?.rigid.tip_in_body?;
        Some(Held { body, start_mm, pointer: FinePointer::new(at) })
    }

    /// Where the held tip is with the pointer at `at`, and what it snapped to.
    fn place(&self, held: &mut Held, at: Vec2) -> Option<(Point3<f64>, Option<SnapKind>)> {
        let at = held.pointer.at(at, self.keys.is_fine());
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

fn on_drag(
    mut drag: On<Pointer<Drag>>,
    balls: Query<&TipBall>,
    grip: Grip,
    mut held: ResMut<HeldTip>,
    mut edits: DragEdits,
) {
    let Ok(TipBall(body)) = balls.get(drag.entity) else {
        return;
    };
    drag.propagate(false);
    let at = drag.pointer_location.position;
    let is_short = drag.distance.length() < DEAD_ZONE_PX && !edits.is_active();
    if drag.button != PointerButton::Primary || is_short {
        return;
    }
    if held.0.is_none() {
        // After Escape the button is still down: that drag is over.
        if edits.is_active() {
            return;
        }
        let Some(taken) = grip.take(*body, at - drag.distance) else {
            return;
        };
        edits.begin(format!("Move {body} tip"));
        held.0 = Some(taken);
    }
    let Some(held) = &mut held.0 else { return };
    let Some((tip, snap)) = grip.place(held, at) else {
        return;
    };
    let moved_mm = (tip - held.start_mm).norm();
    let moved = format!("moved {moved_mm:.2}\u{2009}mm");
    let text = snap.map_or_else(|| moved.clone(), |snap| format!("{}   {moved}", snap.name()));
    edits.apply(Edit::SetTip { body: *body, tip_in_body: Some(tip) }, at, text);
}

fn on_drag_end(
    mut drag: On<Pointer<DragEnd>>,
    balls: Query<(), With<TipBall>>,
    mut held: ResMut<HeldTip>,
    mut edits: DragEdits,
) {
    if !balls.contains(drag.entity) || drag.button != PointerButton::Primary {
        return;
    }
    drag.propagate(false);
    edits.end(held.0.take().is_some());
}

fn let_go_on_escape(
    keys: Res<ButtonInput<KeyCode>>,
    mut held: ResMut<HeldTip>,
    mut edits: DragEdits,
) {
    if keys.just_pressed(KeyCode::Escape) && held.0.take().is_some() {
        edits.cancel();
    }
}
