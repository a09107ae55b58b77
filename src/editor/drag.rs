//! Taking hold of a sensor and sliding it along its body.
//!
//! Picking says which sensor; everything else happens on the core's surface in f64. A drag is
//! one undo step: `Begin`, an `Apply` for each move, `Commit`, or `Cancel` on Escape.

use super::camera::Sight;
use super::pick::Surfaces;
use super::scene::bodies::mesh_of;
use super::scene::{BodyRoot, SensorMark};
use super::state::{
    ActiveDrag, DragReadout, DragText, EditRequest, EditorSystems, Hovered, Selected, Selection,
    ViewportRect,
};
use crate::design::{BodyRole, Edit};
use crate::geometry::pose::Pose;
use crate::geometry::surface::{Ray, Surface};
use crate::geometry::surface_drag::{PlaneDrag, SurfaceDrag};
use crate::tracking::body::Sensor;
use bevy::ecs::system::SystemParam;
use bevy::picking::events::{Click, Drag, DragEnd, DragStart, Out, Over, Pointer};
use bevy::picking::pointer::PointerButton;
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use bevy_egui::{EguiContexts, EguiPrimaryContextPass, egui};
use nalgebra::{Point3, Vector3};
use std::sync::Arc;

/// A press that moves less than this is a click.
const DEAD_ZONE_PX: f32 = 3.0;

/// With Shift the pointer counts for this much.
const FINE: f32 = 0.1;

/// With Ctrl places are rounded to this.
const SNAP_MM: f64 = 1.0;

/// Hovering, selecting and dragging in the 3D view.
pub struct DragPlugin;

/// The sensor that is held.
#[derive(Resource, Default)]
pub struct HeldSensor(Option<Held>);

struct Held {
    body: BodyRole,
    index: usize,
    start: Sensor,
    tracker_from_body: Pose,
    on_surface: Option<(Arc<Surface>, SurfaceDrag)>,
    in_plane: PlaneDrag,
    long_axis: Vector3<f64>,
    pointer: FinePointer,
}

/// The pointer as it counts: slowed down while Shift is held, without a jump when it is pressed
/// or let go.
#[derive(Clone, Copy, Debug)]
struct FinePointer {
    is_fine: bool,
    /// Where the pointer and its effect were when that began.
    since: Vec2,
    effective: Vec2,
}

impl FinePointer {
    fn new(at: Vec2) -> Self {
        Self {
            is_fine: false,
            since: at,
            effective: at,
        }
    }

    fn at(&mut self, at: Vec2, is_fine: bool) -> Vec2 {
        if is_fine != self.is_fine {
            self.effective = self.effect_at(at);
            self.since = at;
            self.is_fine = is_fine;
        }
        self.effect_at(at)
    }

    fn effect_at(&self, at: Vec2) -> Vec2 {
        self.effective + (at - self.since) * if self.is_fine { FINE } else { 1.0 }
    }
}

impl Plugin for DragPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<HeldSensor>()
            .add_observer(on_over)
            .add_observer(on_out)
            .add_observer(on_click)
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
}

/// What an entity under the pointer stands for.
fn selected_by(
    entity: Entity,
    sensors: &Query<&SensorMark>,
    roots: &Query<&BodyRoot>,
) -> Option<Selected> {
    let sensor = sensors.get(entity).ok();
    sensor
        .map(|mark| Selected::Sensor(mark.body, mark.index))
        .or_else(|| roots.get(entity).ok().map(|root| Selected::Body(root.0)))
}

fn on_over(
    over: On<Pointer<Over>>,
    sensors: Query<&SensorMark>,
    roots: Query<&BodyRoot>,
    mut hovered: ResMut<Hovered>,
    mut redraws: MessageWriter<RequestRedraw>,
) {
    if let Some(selected) = selected_by(over.original_event_target(), &sensors, &roots) {
        hovered.set_if_neq(Hovered(Some(selected)));
        redraws.write(RequestRedraw);
    }
}

fn on_out(
    out: On<Pointer<Out>>,
    sensors: Query<&SensorMark>,
    roots: Query<&BodyRoot>,
    mut hovered: ResMut<Hovered>,
    mut redraws: MessageWriter<RequestRedraw>,
) {
    let left = selected_by(out.original_event_target(), &sensors, &roots);
    if left.is_some() && hovered.0 == left {
        hovered.0 = None;
        redraws.write(RequestRedraw);
    }
}

/// A click selects what is under it; beside everything, nothing.
fn on_click(
    mut click: On<Pointer<Click>>,
    sensors: Query<&SensorMark>,
    roots: Query<&BodyRoot>,
    windows: Query<&Window>,
    view: Option<Res<ViewportRect>>,
    mut selection: ResMut<Selection>,
    mut redraws: MessageWriter<RequestRedraw>,
) {
    let in_view = view.is_some_and(|view| view.contains(click.pointer_location.position));
    if click.button != PointerButton::Primary || !in_view {
        return;
    }
    let target = click.original_event_target();
    let selected = selected_by(target, &sensors, &roots);
    if selected.is_some() || windows.contains(target) {
        click.propagate(false);
        selection.set_if_neq(Selection(selected));
        redraws.write(RequestRedraw);
    }
}

fn on_drag_start(mut drag: On<Pointer<DragStart>>, sensors: Query<&SensorMark>) {
    // The drag begins beyond the dead zone, in `on_drag`.
    if sensors.contains(drag.entity) {
        drag.propagate(false);
    }
}

/// What a drag reads.
#[derive(SystemParam)]
struct Grip<'w> {
    sight: Sight<'w>,
    surfaces: Res<'w, Surfaces>,
    keys: Option<Res<'w, ButtonInput<KeyCode>>>,
}

impl Grip<'_> {
    fn is_held(&self, either: [KeyCode; 2]) -> bool {
        self.keys
            .as_ref()
            .is_some_and(|keys| keys.any_pressed(either))
    }

    /// The ray under a place in the window, in a body's frame.
    fn ray(&self, at: Vec2, tracker_from_body: &Pose) -> Option<Ray> {
        let ray = self.sight.ray(at)?;
        Some(ray.transformed_by(&tracker_from_body.inverse()))
    }

    /// Takes hold of a sensor with the pointer at `at`.
    fn take(&self, mark: &SensorMark, at: Vec2) -> Option<Held> {
        let world = &self.sight.world.as_ref()?.0;
        // Where the body is shown; the sensor moves within its body, so what is edited is the same.
        let design = self.sight.design()?;
        let start = design
            .body(mark.body)?
            .rigid
            .sensors
            .get(mark.index)?
            .clone();
        let tracker_from_body = design.tracker_from_body(mark.body)?;
        let ray = self.ray(at, &tracker_from_body)?;
        let pose = start.body_from_sensor();
        let long_axis = mesh_of(world, mark.body).map_or_else(Vector3::z, |mesh| mesh.long_axis());
        let on_surface = self.surfaces.of(mark.body).map(|surface| {
            let grabbed = surface.under(&ray, &start.position_in_body);
            (
                Arc::clone(surface),
                SurfaceDrag::new(pose, &grabbed, long_axis),
            )
        });
        let forward = self.sight.rig.camera.tracker_from_camera().rotation * -Vector3::z_axis();
        Some(Held {
            body: mark.body,
            index: mark.index,
            in_plane: PlaneDrag::new(pose, &ray, tracker_from_body.rotation.inverse() * forward),
            start,
            tracker_from_body,
            on_surface,
            long_axis,
            pointer: FinePointer::new(at),
        })
    }

    /// Where the held sensor is with the pointer at `at`.
    fn pose(&self, held: &mut Held, at: Vec2) -> Option<Pose> {
        let is_fine = self.is_held([KeyCode::ShiftLeft, KeyCode::ShiftRight]);
        let snap_mm = self
            .is_held([KeyCode::ControlLeft, KeyCode::ControlRight])
            .then_some(SNAP_MM);
        let is_off = self.is_held([KeyCode::AltLeft, KeyCode::AltRight]);
        let at = held.pointer.at(at, is_fine);
        let ray = self.ray(at, &held.tracker_from_body)?;
        match &mut held.on_surface {
            Some((surface, drag)) if !is_off => {
                let near = drag.start_body_from_sensor().translation.vector;
                Some(drag.pose_at(&surface.under(&ray, &Point3::from(near)), snap_mm))
            }
            _ => held.in_plane.pose_at(&ray, snap_mm),
        }
    }
}

/// What others see of a drag.
#[derive(SystemParam)]
struct ShownDrag<'w> {
    active: ResMut<'w, ActiveDrag>,
    readout: ResMut<'w, DragReadout>,
    selection: ResMut<'w, Selection>,
}

fn on_drag(
    mut drag: On<Pointer<Drag>>,
    sensors: Query<&SensorMark>,
    grip: Grip,
    mut shown: ShownDrag,
    mut held: ResMut<HeldSensor>,
    mut edits: MessageWriter<EditRequest>,
) {
    let Ok(mark) = sensors.get(drag.entity) else {
        return;
    };
    drag.propagate(false);
    let at = drag.pointer_location.position;
    if drag.button != PointerButton::Primary
        || drag.distance.length() < DEAD_ZONE_PX && !shown.active.0
    {
        return;
    }
    if held.0.is_none() {
        // After Escape the button is still down: that drag is over.
        if shown.active.0 {
            return;
        }
        let Some(taken) = grip.take(mark, at - drag.distance) else {
            return;
        };
        edits.write(EditRequest::Begin(format!(
            "Move sensor {}",
            taken.start.name
        )));
        let selected = Selected::Sensor(mark.body, mark.index);
        shown.selection.set_if_neq(Selection(Some(selected)));
        shown.active.set_if_neq(ActiveDrag(true));
        held.0 = Some(taken);
    }
    let Some(held) = &mut held.0 else { return };
    let Some(pose) = grip.pose(held, at) else {
        return;
    };
    let sensor = held.start.moved(&held.start.body_from_sensor(), &pose);
    shown.readout.set_if_neq(DragReadout(Some(DragText {
        at,
        text: readout_text(held, &sensor),
    })));
    edits.write(EditRequest::Apply(Edit::SetSensor {
        body: held.body,
        index: held.index,
        sensor,
    }));
}

fn on_drag_end(
    mut drag: On<Pointer<DragEnd>>,
    sensors: Query<&SensorMark>,
    mut held: ResMut<HeldSensor>,
    mut active: ResMut<ActiveDrag>,
    mut readout: ResMut<DragReadout>,
    mut edits: MessageWriter<EditRequest>,
) {
    if !sensors.contains(drag.entity) || drag.button != PointerButton::Primary {
        return;
    }
    drag.propagate(false);
    if held.0.take().is_some() {
        edits.write(EditRequest::Commit);
    }
    active.set_if_neq(ActiveDrag(false));
    readout.set_if_neq(DragReadout(None));
}

fn let_go_on_escape(
    keys: Res<ButtonInput<KeyCode>>,
    mut held: ResMut<HeldSensor>,
    mut readout: ResMut<DragReadout>,
    mut edits: MessageWriter<EditRequest>,
) {
    if keys.just_pressed(KeyCode::Escape) && held.0.take().is_some() {
        edits.write(EditRequest::Cancel);
        readout.set_if_neq(DragReadout(None));
    }
}

/// Where the sensor is along its body, and how far that is from where it was.
fn readout_text(held: &Held, sensor: &Sensor) -> String {
    let along = |sensor: &Sensor| sensor.position_in_body.coords.dot(&held.long_axis);
    let moved_mm = (sensor.position_in_body - held.start.position_in_body).norm();
    format!(
        "{:.2}\u{2009}mm along   moved {:.2}\u{2009}mm",
        along(sensor),
        moved_mm
    )
    .replace('-', "\u{2212}")
}

/// A hand over what can be dragged.
fn show_cursor(
    mut contexts: EguiContexts,
    hovered: Res<Hovered>,
    active: Res<ActiveDrag>,
) -> Result {
    let icon = match hovered.0 {
        _ if active.0 => egui::CursorIcon::Grabbing,
        Some(Selected::Sensor(..)) => egui::CursorIcon::Grab,
        Some(_) => egui::CursorIcon::PointingHand,
        None => return Ok(()),
    };
    contexts.ctx_mut()?.set_cursor_icon(icon);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shift_slows_the_pointer_down_without_a_jump() {
        let mut pointer = FinePointer::new(Vec2::ZERO);
        assert_eq!(
            pointer.at(Vec2::new(10.0, 0.0), false),
            Vec2::new(10.0, 0.0)
        );
        assert_eq!(pointer.at(Vec2::new(10.0, 0.0), true), Vec2::new(10.0, 0.0));
        assert_eq!(pointer.at(Vec2::new(20.0, 0.0), true), Vec2::new(11.0, 0.0));
        assert_eq!(
            pointer.at(Vec2::new(30.0, 0.0), false),
            Vec2::new(12.0, 0.0)
        );
        assert_eq!(
            pointer.at(Vec2::new(31.0, 0.0), false),
            Vec2::new(13.0, 0.0)
        );
    }
}
