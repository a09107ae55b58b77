//! Hovering a handle, and dragging what it belongs to: one undo step a drag.

use crate::document::requests::ActiveDrag;
use crate::document::selection::{Selected, Selection};
use crate::viewport::camera::Sight;
use crate::viewport::fine_pointer::DragKeys;
use crate::viewport::gizmo::{CurrentGizmo, GizmoHandle, HoveredHandle};
use crate::viewport::scene_drag::{self, Dragged, SceneDrag};
use bevy::ecs::system::SystemParam;
use bevy::picking::events::{Out, Over, Pointer};
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use bevy_egui::{EguiContexts, EguiPrimaryContextPass, egui};
use std::sync::Arc;
use trackwright_design::{BodyRole, Design, Edit};
use trackwright_geometry::gizmo::{Handle, HandleDrag, HandleKind};
use trackwright_geometry::movement::Movement;

/// The handle that is held.
pub type HeldHandle = Dragged<GizmoHandle>;

/// A handle and what it moves.
pub struct HeldGizmo {
    target: Selected,
    handle: Handle,
    drag: HandleDrag,
    /// The design when it was taken hold of: every pose of the drag comes from there.
    start: Arc<Design>,
}

/// What a drag reads.
#[derive(SystemParam)]
pub struct Grip<'w> {
    sight: Sight<'w>,
    current: Res<'w, CurrentGizmo>,
    keys: DragKeys<'w>,
}

impl HeldHandle {
    pub fn handle(&self) -> Option<Handle> {
        self.get().map(|held| held.handle)
    }

    /// What it moves.
    pub fn target(&self) -> Option<Selected> {
        self.get().map(|held| held.target)
    }
}

impl SceneDrag for GizmoHandle {
    type Held = HeldGizmo;
    type Grip = Grip<'static>;

    fn take(&self, grip: &Grip, _: &Selection, at: Vec2) -> Option<HeldGizmo> {
        let shown = grip.current.0?;
        let world = &grip.sight.world.as_ref()?.0;
        let ray = grip.sight.ray(at)?;
        Some(HeldGizmo {
            target: shown.target,
            handle: self.0,
            drag: HandleDrag::new(&shown.gizmo, self.0, &ray, &grip.sight.eye())?,
            start: world.document.shared_design(),
        })
    }

    fn label(held: &HeldGizmo) -> String {
        let verb = match held.handle.kind {
            HandleKind::Arrow => "Move",
            HandleKind::Ring => "Turn",
        };
        format!("{verb} {}", name_of(&held.start, held.target))
    }

    fn edit(held: &mut HeldGizmo, grip: &Grip, at: Vec2) -> Option<(Edit, String)> {
        let mut movement = held.drag.movement_at(&grip.sight.ray(at)?)?;
        if grip.keys.is_snapping() {
            movement = movement.snapped();
        }
        let edit = match held.target {
            Selected::Body(role) => held.start.moved_body(role, &movement),
            Selected::Sensor(role, index) => held.start.turned_sensor(role, index, &movement),
            Selected::Metal(index) => held.start.moved_metal(index, &movement),
            Selected::Tip(_) | Selected::Anatomy(_) => None,
        };
        Some((edit?, amount_text(&movement)))
    }
}

/// What a person calls it within a sentence, without an article.
pub fn name_of(design: &Design, target: Selected) -> String {
    let sensor = |role: BodyRole, index: usize| {
        let sensor = design.body(role)?.rigid.sensors.get(index)?;
        Some(format!("sensor {}", sensor.name))
    };
    match target {
        Selected::Body(role) => role.name().to_owned(),
        Selected::Sensor(role, index) => sensor(role, index).unwrap_or_else(|| "sensor".to_owned()),
        Selected::Tip(role) => format!("{role} tip"),
        Selected::Anatomy(index) => {
            let anatomy = design.anatomy.get(index);
            anatomy.map_or_else(|| "anatomy".to_owned(), |a| format!("anatomy {}", a.name))
        }
        Selected::Metal(index) => {
            let object = design.metal_object(index);
            object.map_or_else(|| "metal object".to_owned(), |object| object.name.clone())
        }
    }
}

pub(crate) fn plugin(app: &mut App) {
    app.add_plugins(scene_drag::plugin::<GizmoHandle>)
        .add_observer(on_over)
        .add_observer(on_out)
        .add_systems(EguiPrimaryContextPass, show_cursor);
}

fn on_over(
    over: On<Pointer<Over>>,
    handles: Query<&GizmoHandle>,
    mut hovered: ResMut<HoveredHandle>,
    mut redraws: MessageWriter<RequestRedraw>,
) {
    if let Ok(GizmoHandle(handle)) = handles.get(over.original_event_target()) {
        hovered.set_if_neq(HoveredHandle(Some(*handle)));
        redraws.write(RequestRedraw);
    }
}

fn on_out(
    out: On<Pointer<Out>>,
    handles: Query<&GizmoHandle>,
    mut hovered: ResMut<HoveredHandle>,
    mut redraws: MessageWriter<RequestRedraw>,
) {
    if let Ok(GizmoHandle(handle)) = handles.get(out.original_event_target())
        && hovered.0 == Some(*handle)
    {
        hovered.0 = None;
        redraws.write(RequestRedraw);
    }
}

/// `+12.00 mm` or `−15.0°`.
fn amount_text(movement: &Movement) -> String {
    // Adding zero turns a negative zero into a plain one.
    let rounded = |value: f64, per: f64| (value * per).round() / per + 0.0;
    match movement {
        Movement::Slide { by_mm, .. } => format!("{:+.2}\u{2009}mm", rounded(*by_mm, 100.0)),
        Movement::Turn { by_rad, .. } => format!("{:+.1}°", rounded(by_rad.to_degrees(), 10.0)),
    }
    .replace('-', "\u{2212}")
}

/// A hand over a handle.
fn show_cursor(
    mut contexts: EguiContexts,
    hovered: Res<HoveredHandle>,
    active: Res<ActiveDrag>,
) -> Result {
    if hovered.0.is_some() && !active.0 {
        contexts.ctx_mut()?.set_cursor_icon(egui::CursorIcon::Grab);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Point3, Vector3};

    #[test]
    fn amounts_have_signs_units_and_no_negative_zero() {
        let slide = |by_mm| amount_text(&Movement::Slide { direction: Vector3::x_axis(), by_mm });
        let turn = |by_rad| {
            amount_text(&Movement::Turn {
                axis: Vector3::x_axis(),
                pivot_mm: Point3::origin(),
                by_rad,
            })
        };
        assert_eq!(slide(12.0), "+12.00\u{2009}mm");
        assert_eq!(slide(-0.001), "+0.00\u{2009}mm");
        assert_eq!(turn(15_f64.to_radians()), "+15.0°");
        assert_eq!(turn(-0.5), "\u{2212}28.6°");
    }
}
