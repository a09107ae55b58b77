//! Taking hold of a sensor and sliding it along its body.
//!
//! Picking selects the sensor; everything else happens on the core's surface in f64. How a drag
//! begins and ends is [`scene_drag`]'s.
//!
//! The sensor's axis stays as it is, and one on the axis of a body of revolution slides along that,
//! unless drags follow the surface.

use crate::document::requests::ActiveDrag;
use crate::document::selection::{Hovered, Selected, Selection};
use crate::scene::metal::MetalRoot;
use crate::scene::{BodyRoot, SensorMark};
use crate::shell::window::ViewportRect;
use crate::viewport::camera::Sight;
use crate::viewport::camera_gestures::Gesture;
use crate::viewport::fine_pointer::DragKeys;
use crate::viewport::gizmo::GizmoHandle;
use crate::viewport::picking::Targets;
use crate::viewport::scene_drag::{self, SceneDrag};
use crate::viewport::scene_menu::SceneMenu;
use crate::viewport::surfaces::Surfaces;
use crate::viewport::tool::SceneTool;
use bevy::ecs::system::SystemParam;
use bevy::picking::events::{Click, Out, Over, Pointer};
use bevy::picking::pointer::PointerButton;
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use bevy_egui::{EguiContexts, EguiPrimaryContextPass, egui};
use nalgebra::{Point3, Vector3};
use std::sync::Arc;
use trackwright_design::{BodyRole, Edit};
use trackwright_geometry::pose::Pose;
use trackwright_geometry::surface::{Ray, Surface};
use trackwright_geometry::surface_drag::{DragGuide, Grid, PlaneDrag, SurfaceDrag};
use trackwright_simulation::body::Sensor;

/// With Ctrl places are rounded to this.
const SNAP_MM: f64 = 1.0;

/// Hovering, selecting and dragging in the 3D view.
pub struct DragPlugin;

/// Whether the axis of a dragged sensor turns with the surface's normal; else it stays as it is. A
/// drag goes on as it began.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FollowsSurface(pub bool);

/// The sensor that is held.
pub struct HeldSensor {
    body: BodyRole,
    index: usize,
    start: Sensor,
    /// Those that are selected with it and go along.
    others: Vec<(usize, Sensor)>,
    tracker_from_body: Pose,
    on_surface: Option<(Arc<Surface>, SurfaceDrag)>,
    in_plane: PlaneDrag,
    long_axis: Vector3<f64>,
}

impl HeldSensor {
    /// The held sensor where it is now, and the others as it takes them along.
    fn edit(&self, sensor: Sensor, start: &Pose, now: &Pose) -> Edit {
        let (body, index) = (self.body, self.index);
        if self.others.is_empty() {
            return Edit::SetSensor { body, index, sensor };
        }
        let others = self.others.iter();
        let sensors = others
            .map(|(index, other)| (*index, other.carried(start, now)))
            .chain([(index, sensor)])
            .collect();
        Edit::SetSensors { body, sensors }
    }
}

impl Plugin for DragPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(scene_drag::plugin::<SensorMark>)
            .init_resource::<FollowsSurface>()
            .init_resource::<SceneMenu>()
            .add_observer(on_over.run_if(resource_equals(SceneTool::Select)))
            .add_observer(on_out)
            .add_observer(on_click.run_if(resource_equals(SceneTool::Select)))
            .add_observer(on_menu_click)
            .add_systems(
                EguiPrimaryContextPass,
                show_cursor.run_if(resource_equals(SceneTool::Select)),
            );
    }
}

/// What can be selected in the scene.
#[derive(SystemParam)]
struct Things<'w, 's> {
    sensors: Query<'w, 's, &'static SensorMark>,
    roots: Query<'w, 's, &'static BodyRoot>,
    metal: Query<'w, 's, &'static MetalRoot>,
}

impl Things<'_, '_> {
    /// What an entity under the pointer stands for.
    fn of(&self, entity: Entity) -> Option<Selected> {
        let sensor = self.sensors.get(entity).ok();
        sensor
            .map(|mark| Selected::Sensor(mark.body, mark.index))
            .or_else(|| Some(Selected::Body(self.roots.get(entity).ok()?.0)))
            .or_else(|| Some(Selected::Metal(self.metal.get(entity).ok()?.0)))
    }
}

fn on_over(
    over: On<Pointer<Over>>,
    things: Things,
    mut hovered: ResMut<Hovered>,
    mut redraws: MessageWriter<RequestRedraw>,
) {
    if let Some(selected) = things.of(over.original_event_target()) {
        hovered.set_if_neq(Hovered(Some(selected)));
        redraws.write(RequestRedraw);
    }
}

fn on_out(
    out: On<Pointer<Out>>,
    things: Things,
    mut hovered: ResMut<Hovered>,
    mut redraws: MessageWriter<RequestRedraw>,
) {
    let left = things.of(out.original_event_target());
    if left.is_some() && hovered.0 == left {
        hovered.0 = None;
        redraws.write(RequestRedraw);
    }
}

/// Held with a click they add to what is selected, or take away from it.
const ADD_KEYS: [KeyCode; 4] =
    [KeyCode::ControlLeft, KeyCode::ControlRight, KeyCode::ShiftLeft, KeyCode::ShiftRight];

/// What a click means.
#[derive(SystemParam)]
struct Clicks<'w> {
    view: Option<Res<'w, ViewportRect>>,
    keys: Option<Res<'w, ButtonInput<KeyCode>>>,
    drag: Res<'w, ActiveDrag>,
    camera: Option<Res<'w, Gesture>>,
}

impl Clicks<'_> {
    /// Whether it is one in the 3D view, and not the end of a drag of something or of the camera.
    fn counts(&self, at: Vec2) -> bool {
        let has_turned = self.camera.as_ref().is_some_and(|camera| camera.has_moved());
        self.view.as_ref().is_some_and(|view| view.contains(at)) && !self.drag.0 && !has_turned
    }

    fn adds(&self) -> bool {
        self.keys.as_ref().is_some_and(|keys| keys.any_pressed(ADD_KEYS))
    }
}

/// Handles are there to be dragged: a click goes through them to a sensor.
#[derive(SystemParam)]
struct Handles<'w, 's> {
    handles: Query<'w, 's, (), With<GizmoHandle>>,
    targets: Targets<'w, 's>,
    sight: Sight<'w>,
}

impl Handles<'_, '_> {
    fn seen_through(&self, target: Entity, at: Vec2) -> Entity {
        let behind = self.handles.contains(target).then(|| {
            let sensor = self.targets.sensor_under(&self.sight, at);
            sensor.unwrap_or(target)
        });
        behind.unwrap_or(target)
    }
}

/// A click selects what is under it; beside everything, nothing.
fn on_click(
    mut click: On<Pointer<Click>>,
    things: Things,
    windows: Query<&Window>,
    handles: Handles,
    clicks: Clicks,
    mut selection: ResMut<Selection>,
    mut redraws: MessageWriter<RequestRedraw>,
) {
    if click.button != PointerButton::Primary || !clicks.counts(click.pointer_location.position) {
        return;
    }
    let at = click.pointer_location.position;
    let target = handles.seen_through(click.original_event_target(), at);
    let selected = things.of(target);
    if selected.is_some() || windows.contains(target) {
        click.propagate(false);
        let mut after = selection.clone();
        match selected {
            Some(what) if clicks.adds() => after.toggle(what),
            _ => after = Selection::of(selected),
        }
        selection.set_if_neq(after);
        redraws.write(RequestRedraw);
    }
}

/// The other button shows what can be done to a sensor, and to those that are selected with it.
fn on_menu_click(
    mut click: On<Pointer<Click>>,
    sensors: Query<&SensorMark>,
    clicks: Clicks,
    mut selection: ResMut<Selection>,
    mut menu: ResMut<SceneMenu>,
    mut redraws: MessageWriter<RequestRedraw>,
) {
    let at = click.pointer_location.position;
    let Ok(mark) = sensors.get(click.entity) else {
        return;
    };
    if click.button != PointerButton::Secondary || !clicks.counts(at) {
        return;
    }
    click.propagate(false);
    let mut after = selection.clone();
    after.take(Selected::Sensor(mark.body, mark.index));
    selection.set_if_neq(after);
    menu.set_if_neq(SceneMenu(Some(at)));
    redraws.write(RequestRedraw);
}

/// What a drag reads.
#[derive(SystemParam)]
pub struct Grip<'w> {
    sight: Sight<'w>,
    tool: Res<'w, SceneTool>,
    surfaces: Res<'w, Surfaces>,
    follows: Res<'w, FollowsSurface>,
    keys: DragKeys<'w>,
}

impl Grip<'_> {
    /// The ray under a place in the window, in a body's frame.
    fn ray(&self, at: Vec2, tracker_from_body: &Pose) -> Option<Ray> {
        let ray = self.sight.ray(at)?;
        Some(ray.transformed_by(&tracker_from_body.inverse()))
    }

    /// Where the held sensor is with the pointer at `at`.
    fn pose(&self, held: &mut HeldSensor, at: Vec2) -> Option<Pose> {
        let snap_mm = self.keys.is_snapping().then_some(SNAP_MM);
        let ray = self.ray(at, &held.tracker_from_body)?;
        match &mut held.on_surface {
            Some((surface, drag)) if !self.keys.is_off() => {
                let near = drag.start_body_from_sensor().translation.vector;
                let hit = surface.under(&ray, &Point3::from(near));
                let grid = snap_mm.map(|step_mm| Grid::at(surface, &hit, step_mm));
                Some(drag.pose_at(&hit, grid))
            }
            _ => held.in_plane.pose_at(&ray, snap_mm),
        }
    }
}

impl SceneDrag for SensorMark {
    type Held = HeldSensor;
    type Grip = Grip<'static>;

    fn take(&self, grip: &Grip, selection: &Selection, at: Vec2) -> Option<HeldSensor> {
        if *grip.tool != SceneTool::Select {
            return None;
        }
        let world = &grip.sight.world.as_ref()?.0;
        // Where the body is shown; the sensor moves within its body, so what is edited is the same.
        let design = grip.sight.design()?;
        let sensors = &design.body(self.body)?.rigid.sensors;
        let start = sensors.get(self.index)?.clone();
        let others = match selection.sensors() {
            Some((body, indices)) if body == self.body && indices.contains(&self.index) => indices
                .into_iter()
                .filter(|index| *index != self.index)
                .filter_map(|index| Some((index, sensors.get(index)?.clone())))
                .collect(),
            _ => Vec::new(),
        };
        let tracker_from_body = design.tracker_from_body(self.body)?;
        let ray = grip.ray(at, &tracker_from_body)?;
        let pose = start.body_from_sensor();
        let long_axis = world.mesh(self.body).map_or_else(Vector3::z, |mesh| mesh.long_axis());
        let surface = match grip.follows.0 {
            true => grip.surfaces.smooth_of(self.body),
            false => grip.surfaces.of(self.body),
        };
        let guide = DragGuide {
            long_axis,
            axis: surface.and_then(|surface| surface.revolution_axis(&long_axis)),
            follows_surface: grip.follows.0,
        };
        let on_surface = surface.map(|surface| {
            let grabbed = surface.under(&ray, &start.position_in_body);
            (Arc::clone(surface), SurfaceDrag::new(pose, &grabbed, &guide))
        });
        let forward = grip.sight.rig.camera.tracker_from_camera().rotation * -Vector3::z_axis();
        Some(HeldSensor {
            body: self.body,
            index: self.index,
            others,
            in_plane: PlaneDrag::new(pose, &ray, tracker_from_body.rotation.inverse() * forward),
            start,
            tracker_from_body,
            on_surface,
            long_axis: guide.axis.map_or(long_axis, |axis| axis.direction.into_inner()),
        })
    }

    fn selected(&self) -> Option<Selected> {
        Some(Selected::Sensor(self.body, self.index))
    }

    fn label(held: &HeldSensor) -> String {
        match held.others.len() {
            0 => format!("Move sensor {}", held.start.name),
            others => format!("Move {} sensors", others + 1),
        }
    }

    fn edit(held: &mut HeldSensor, grip: &Grip, at: Vec2) -> Option<(Edit, String)> {
        let pose = grip.pose(held, at)?;
        let start = held.start.body_from_sensor();
        let sensor = held.start.moved(&start, &pose);
        let text = readout_text(held, &sensor);
        Some((held.edit(sensor, &start, &pose), text))
    }
}

/// Where the sensor is along its body, and how far that is from where it was.
fn readout_text(held: &HeldSensor, sensor: &Sensor) -> String {
    let along = |sensor: &Sensor| sensor.position_in_body.coords.dot(&held.long_axis);
    let moved_mm = (sensor.position_in_body - held.start.position_in_body).norm();
    format!("{:.2}\u{2009}mm along   moved {:.2}\u{2009}mm", along(sensor), moved_mm)
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
