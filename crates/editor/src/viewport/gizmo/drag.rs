//! Hovering a handle, and dragging what it belongs to: one undo step a drag.

use crate::document::requests::ActiveDrag;
use crate::document::selection::Selected;
use crate::schedule::EditorSystems;
use crate::viewport::camera::Sight;
use crate::viewport::drag_edits::DragEdits;
use crate::viewport::fine_pointer::{DEAD_ZONE_PX, DragKeys, FinePointer};
use crate::viewport::gizmo::{CurrentGizmo, GizmoHandle, HoveredHandle};
use bevy::ecs::system::SystemParam;
use bevy::picking::events::{Drag, DragEnd, DragStart, Out, Over, Pointer};
use bevy::picking::pointer::PointerButton;
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use bevy_egui::{EguiContexts, EguiPrimaryContextPass, egui};
use std::sync::Arc;
use trackwright_design::{BodyRole, Design, Edit};
use trackwright_geometry::gizmo::{Handle, HandleDrag, HandleKind};
use trackwright_geometry::movement::Movement;

/// The handle that is held.
#[derive(Resource, Default)]
pub struct HeldHandle(Option<Held>);

struct Held {
    target: Selected,
    handle: Handle,
    drag: HandleDrag,
    /// The design when it was taken hold of: every pose of the drag comes from there.
    start: Arc<Design>,
    pointer: FinePointer,
}

impl HeldHandle {
    pub fn handle(&self) -> Option<Handle> {
        self.0.as_ref().map(|held| held.handle)
    }
}

impl Held {
    fn edit(&self, movement: &Movement) -> Option<Edit> {
        match self.target {
            Selected::Body(role) => self.start.moved_body(role, movement),
            Selected::Sensor(role, index) => self.start.turned_sensor(role, index, movement),
            Selected::Tip(_) | Selected::Anatomy(_) => None,
        }
    }

    /// What undo calls it.
    fn label(&self) -> String {
        let verb = match self.handle.kind {
            HandleKind::Arrow => "Move",
            HandleKind::Ring => "Turn",
        };
        format!("{verb} {}", name_of(&self.start, self.target))
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
    }
}

pub(crate) fn plugin(app: &mut App) {
    app.init_resource::<HeldHandle>()
        .add_observer(on_over)
        .add_observer(on_out)
        .add_observer(on_drag_start)
        .add_observer(on_drag)
        .add_observer(on_drag_end)
        .add_systems(
            Update,
            let_go_on_escape
                .run_if(resource_exists::<ButtonInput<KeyCode>>)
                .in_set(EditorSystems::Input),
        )
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

fn on_drag_start(mut drag: On<Pointer<DragStart>>, handles: Query<&GizmoHandle>) {
    // The drag begins beyond the dead zone, in `on_drag`.
    if handles.contains(drag.entity) {
        drag.propagate(false);
    }
}

/// What a drag reads.
#[derive(SystemParam)]
struct Grip<'w> {
    sight: Sight<'w>,
    current: Res<'w, CurrentGizmo>,
    keys: DragKeys<'w>,
}

impl Grip<'_> {
    /// Takes hold of a handle with the pointer at `at`.
    fn take(&self, handle: Handle, at: Vec2) -> Option<Held> {
        let shown = self.current.0?;
        let world = &self.sight.world.as_ref()?.0;
        let ray = self.sight.ray(at)?;
        Some(Held {
            target: shown.target,
            handle,
            drag: HandleDrag::new(&shown.gizmo, handle, &ray, &self.sight.eye())?,
            start: world.document.shared_design(),
            pointer: FinePointer::new(at),
        })
    }

    /// What the held handle did, with the pointer at `at`.
    fn movement(&self, held: &mut Held, at: Vec2) -> Option<Movement> {
        let at = held.pointer.at(at, self.keys.is_fine());
        let movement = held.drag.movement_at(&self.sight.ray(at)?)?;
        Some(match self.keys.is_snapping() {
            true => movement.snapped(),
            false => movement,
        })
    }
}

fn on_drag(
    mut drag: On<Pointer<Drag>>,
    handles: Query<&GizmoHandle>,
    grip: Grip,
    mut held: ResMut<HeldHandle>,
    mut edits: DragEdits,
) {
    let Ok(GizmoHandle(handle)) = handles.get(drag.entity) else {
        return;
    };
    drag.propagate(false);
    let at = drag.pointer_location.position;
    if drag.button != PointerButton::Primary
        || drag.distance.length() < DEAD_ZONE_PX && !edits.is_active()
    {
        return;
    }
    if held.0.is_none() {
        // After Escape the button is still down: that drag is over.
        if edits.is_active() {
            return;
        }
        let Some(taken) = grip.take(*handle, at - drag.distance) else {
            return;
        };
        edits.begin(taken.label());
        held.0 = Some(taken);
    }
    let Some(held) = &mut held.bypass_change_detection().0 else {
        return;
    };
    let Some(movement) = grip.movement(held, at) else {
        return;
    };
    if let Some(edit) = held.edit(&movement) {
        edits.apply(edit, at, amount_text(&movement));
    }
}

fn on_drag_end(
    mut drag: On<Pointer<DragEnd>>,
    handles: Query<&GizmoHandle>,
    mut held: ResMut<HeldHandle>,
    mut edits: DragEdits,
) {
    if !handles.contains(drag.entity) || drag.button != PointerButton::Primary {
        return;
    }
    drag.propagate(false);
    edits.end(held.0.take().is_some());
}

fn let_go_on_escape(
    keys: Res<ButtonInput<KeyCode>>,
    mut held: ResMut<HeldHandle>,
    mut edits: DragEdits,
) {
    if keys.just_pressed(KeyCode::Escape) && held.bypass_change_detection().0.is_some() {
        held.0 = None;
        edits.cancel();
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
