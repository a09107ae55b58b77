//! Handles in the scene: what a drag of one does to the design, and when there are none.

use super::app::{named, settle};
use super::pointer::{SHAFT, SimulatedPointer};
use bevy::picking::pointer::PointerButton;
use bevy::prelude::*;
use nalgebra::Point3;
use trackwright_design::{BodyRole, HandleAxes, Thing, Things, View};
use trackwright_editor::document::requests::{ActiveDrag, EditRequest, OpenWorld, ViewRequest};
use trackwright_editor::document::selection::{Selected, Selection};
use trackwright_editor::shell::window::{DragReadout, PointerHint, ViewportRect};
use trackwright_editor::viewport::camera::OrbitRig;
use trackwright_editor::viewport::gizmo::{GizmoAxes, HoveredHandle, ShownGizmo, gizmo_of};
use trackwright_editor::workspaces;
use trackwright_geometry::gizmo::Handle;
use trackwright_geometry::orbit::Axis;

const CRF: Selected = Selected::Body(BodyRole::Crf);
const TOOL: Selected = Selected::Body(BodyRole::Tool);

/// A pointer, and something selected.
fn pointer_with(selected: Selected) -> SimulatedPointer {
    let mut pointer = SimulatedPointer::new();
    pointer.select(Some(selected));
    pointer
}

fn gizmo(pointer: &SimulatedPointer) -> ShownGizmo {
    let document = &pointer.resource::<OpenWorld>().0.document;
    let selection = pointer.resource::<Selection>();
    let axes = pointer.resource::<GizmoAxes>().0;
    gizmo_of(document.design(), document.view(), selection, axes).expect("a gizmo")
}

/// Where the pointer takes hold of a handle, in the window.
fn grip(pointer: &SimulatedPointer, handle: Handle) -> Vec2 {
    let rig = pointer.resource::<OrbitRig>();
    let grip = gizmo(pointer).gizmo.grip_px(handle, &rig.eye());
    let [x, y] = grip.expect("a handle within reach");
    pointer.resource::<ViewportRect>().min + Vec2::new(x as f32, y as f32)
}

/// The direction on the screen in which an axis of the gizmo runs.
fn direction(pointer: &SimulatedPointer, axis: Axis) -> Vec2 {
    let rig = pointer.resource::<OrbitRig>();
    let gizmo = gizmo(pointer).gizmo;
    let project = |point: Point3<f64>| rig.camera.project(&point, rig.view_px).unwrap();
    let from = project(gizmo.pivot_mm());
    let to = project(gizmo.pivot_mm() + gizmo.axis(axis).into_inner() * 10.0);
    Vec2::new((to[0] - from[0]) as f32, (to[1] - from[1]) as f32).normalize()
}

/// The direction on the screen in which a ring is turned where it is taken hold of.
fn tangent(pointer: &SimulatedPointer, ring: Handle) -> Vec2 {
    let rig = pointer.resource::<OrbitRig>();
    let [x, y] = rig.camera.project(&gizmo(pointer).gizmo.pivot_mm(), rig.view_px).unwrap();
    let pivot = pointer.resource::<ViewportRect>().min + Vec2::new(x as f32, y as f32);
    (grip(pointer, ring) - pivot).perp().normalize()
}

fn drag(pointer: &mut SimulatedPointer, handle: Handle, by: Vec2) {
    let at = grip(pointer, handle);
    pointer.drag(at, by, PointerButton::Primary);
    pointer.release(at + by, PointerButton::Primary);
}

/// Nothing behind a handle is picked through it.
fn lock_sensors(pointer: &mut SimulatedPointer) {
    let world = pointer.app.world_mut();
    let document = &world.resource::<OpenWorld>().0.document;
    let mut view = document.view().clone();
    for (role, body) in document.design().bodies() {
        for sensor in &body.rigid.sensors {
            view.locked.toggle(Thing::sensor(role, &sensor.name));
        }
    }
    world.write_message(ViewRequest::Set(view));
    pointer.app.update();
}

#[test]
fn the_x_arrow_moves_the_crf_with_the_tool() {
    let mut pointer = pointer_with(CRF);
    let before = pointer.design();
    let arrow = Handle::arrow(Axis::X);
    let axis = gizmo(&pointer).gizmo.axis(Axis::X).into_inner();
    let (at, by) = (grip(&pointer, arrow), direction(&pointer, Axis::X) * 40.0);
    let where_on_axis = |pointer: &SimulatedPointer, at: Vec2| {
        let rig = pointer.resource::<OrbitRig>();
        let pixel = pointer.resource::<ViewportRect>().pixel(at);
        let gizmo = gizmo(pointer).gizmo;
        let ray = rig.camera.ray(pixel, rig.view_px);
        ray.nearest_on_line(&gizmo.pivot_mm(), &gizmo.axis(Axis::X)).unwrap()
    };
    let wanted_mm = where_on_axis(&pointer, at + by) - where_on_axis(&pointer, at);

    pointer.drag(at, by, PointerButton::Primary);
    assert_eq!(pointer.resource::<HoveredHandle>().0, Some(arrow));
    let readout = pointer.resource::<DragReadout>().0.clone().unwrap();
    assert!(readout.text.starts_with('+') && readout.text.ends_with("\u{2009}mm"));
    pointer.release(at + by, PointerButton::Primary);

    let (crf, was) = (pointer.design().crf.unwrap(), before.crf.clone().unwrap());
    let moved = crf.tracker_from_crf.translation.vector - was.tracker_from_crf.translation.vector;
    assert!(moved.cross(&axis).norm() < 1e-9, "{moved}");
    // The window's pixels are f32, to 0.0001 of one.
    assert!((moved.dot(&axis) - wanted_mm).abs() < 1e-3, "{moved}");
    assert!(wanted_mm > 1.0);
    assert_eq!(crf.tracker_from_crf.rotation, was.tracker_from_crf.rotation);
    assert_eq!(pointer.design().tool, before.tool);
    assert_eq!(pointer.undo_label().as_deref(), Some("Move CRF"));
    assert_eq!(pointer.resource::<DragReadout>().0, None);
    assert_eq!(pointer.resource::<Selection>().primary(), Some(CRF));
    pointer.request(EditRequest::Undo);
    assert_eq!(pointer.design(), before);
    assert_eq!(pointer.undo_label(), None);
}

#[test]
fn control_moves_by_whole_millimetres() {
    let mut pointer = pointer_with(TOOL);
    let before = pointer.design().tool.crf_from_tool;
    let by = direction(&pointer, Axis::Y) * 37.0;
    pointer.hold(KeyCode::ControlLeft);
    drag(&mut pointer, Handle::arrow(Axis::Y), by);
    let after = pointer.design().tool.crf_from_tool;
    let moved_mm = (after.translation.vector - before.translation.vector).norm();
    assert!(moved_mm > 0.5 && (moved_mm - moved_mm.round()).abs() < 1e-9, "{moved_mm}");
}

#[test]
fn control_turns_by_five_degrees_about_the_tip() {
    for selected in [CRF, TOOL] {
        let mut pointer = pointer_with(selected);
        let before = pointer.design();
        let pivot_mm = gizmo(&pointer).gizmo.pivot_mm();
        pointer.hold(KeyCode::ControlLeft);
        let by = tangent(&pointer, Handle::ring(Axis::Z)) * 35.0;
        drag(&mut pointer, Handle::ring(Axis::Z), by);
        let Selected::Body(role) = selected else { unreachable!() };
        let after = pointer.design();
        let [was, is] = [&before, &after].map(|design| design.tracker_from_body(role).unwrap());
        let steps = was.rotation.angle_to(&is.rotation).to_degrees() / 5.0;
        assert!(steps > 0.5 && (steps - steps.round()).abs() < 1e-6, "{steps}");
        assert!((gizmo(&pointer).gizmo.pivot_mm() - pivot_mm).norm() < 1e-9);
        assert_eq!(pointer.undo_label(), Some(format!("Turn {role}")));
        pointer.request(EditRequest::Undo);
        assert_eq!(pointer.design(), before);
    }
}

#[test]
fn tracker_axes_move_along_the_tracker() {
    let mut pointer = pointer_with(CRF);
    let turned = nalgebra::UnitQuaternion::from_euler_angles(0.4, -0.3, 0.8);
    let mut pose = pointer.design().crf.unwrap().tracker_from_crf;
    pose.rotation = turned;
    pointer.request(EditRequest::Apply(trackwright_design::Edit::SetCrfPose(pose)));
    pointer.app.world_mut().resource_mut::<GizmoAxes>().0 = HandleAxes::Tracker;
    settle(&mut pointer.app);
    let by = direction(&pointer, Axis::Z) * 30.0;
    drag(&mut pointer, Handle::arrow(Axis::Z), by);
    let after = pointer.design().crf.unwrap().tracker_from_crf;
    let moved = after.translation.vector - pose.translation.vector;
    assert!(moved.z > 1.0 && moved.xy().norm() < 1e-9, "{moved}");
}

#[test]
fn two_rings_turn_a_sensor_in_place() {
    let mut pointer = pointer_with(Selected::Sensor(BodyRole::Tool, SHAFT));
    // Its own, whatever was chosen for bodies: another frame's could lie along its axis.
    pointer.app.world_mut().resource_mut::<GizmoAxes>().0 = HandleAxes::Tracker;
    settle(&mut pointer.app);
    assert_eq!(gizmo(&pointer).gizmo.handles, Handle::RINGS_OF_AXIS);
    assert_eq!(gizmo(&pointer).axes, HandleAxes::Own);
    assert_eq!(named(&mut pointer.app, "gizmo handle"), 2);
    let sensor =
        |pointer: &SimulatedPointer| pointer.design().tool.body.rigid.sensors[SHAFT].clone();
    let before = sensor(&pointer);
    let by = tangent(&pointer, Handle::ring(Axis::X)) * 30.0;
    drag(&mut pointer, Handle::ring(Axis::X), by);
    let after = sensor(&pointer);
    assert_eq!(after.position_in_body, before.position_in_body);
    assert!(after.axis_in_body().unwrap().angle(&before.axis_in_body().unwrap()) > 0.05);
    let label = Some(format!("Turn sensor {}", before.name));
    assert_eq!(pointer.undo_label(), label);
}

#[test]
fn escape_leaves_the_design_to_the_bit_and_lets_go() {
    let mut pointer = pointer_with(CRF);
    let before = pointer.design();
    let at = grip(&pointer, Handle::arrow(Axis::X));
    let by = direction(&pointer, Axis::X) * 50.0;
    pointer.drag(at, by, PointerButton::Primary);
    assert_ne!(pointer.design(), before);
    assert_eq!(*pointer.resource::<ActiveDrag>(), ActiveDrag(true));
    pointer.assert_escape_restores(&before, at + by * 2.0);
    assert_eq!(*pointer.resource::<ActiveDrag>(), ActiveDrag(false));
}

#[test]
fn a_click_on_a_handle_changes_nothing() {
    let mut pointer = pointer_with(CRF);
    let before = pointer.design();
    lock_sensors(&mut pointer);
    let at = grip(&pointer, Handle::ring(Axis::Z));
    pointer.move_to(at);
    pointer.app.update();
    let hint = pointer.resource::<PointerHint>().0.clone().unwrap();
    assert!(hint.starts_with("Drag to turn the CRF about its z"), "{hint}");
    pointer.click(at);
    assert_eq!(pointer.resource::<Selection>().primary(), Some(CRF));
    assert_eq!(pointer.design(), before);
    pointer.select(None);
    assert_eq!(pointer.resource::<HoveredHandle>().0, None);
    assert_eq!(pointer.resource::<PointerHint>().0, None);
}

#[test]
fn a_click_passes_a_handle_to_the_sensor() {
    let mut pointer = pointer_with(Selected::Sensor(BodyRole::Tool, SHAFT));
    let ring = Handle::ring(Axis::X);
    // The other sensors stand along the shaft: one is brought under the ring.
    let at = grip(&pointer, ring);
    let mut sensor = pointer.design().tool.body.rigid.sensors[SHAFT + 1].clone();
    sensor.position_in_body = {
        let rig = pointer.resource::<OrbitRig>();
        let pixel = pointer.resource::<ViewportRect>().pixel(at);
        let ray = rig.camera.ray(pixel, rig.view_px);
        let tracker_from_tool = pointer.design().tracker_from_body(BodyRole::Tool).unwrap();
        tracker_from_tool.inverse() * ray.at(rig.camera.distance_mm)
    };
    pointer.request(EditRequest::Apply(trackwright_design::Edit::SetSensor {
        body: BodyRole::Tool,
        index: SHAFT + 1,
        sensor,
    }));
    settle(&mut pointer.app);
    pointer.move_to(at);
    pointer.app.update();
    assert_eq!(pointer.resource::<HoveredHandle>().0, Some(ring));
    pointer.click(at);
    let behind = Selected::Sensor(BodyRole::Tool, SHAFT + 1);
    assert_eq!(pointer.resource::<Selection>().primary(), Some(behind));
}

fn entities(pointer: &mut SimulatedPointer) -> [usize; 2] {
    ["gizmo", "gizmo handle"].map(|name| named(&mut pointer.app, name))
}

#[test]
fn the_gizmo_needs_a_movable_selection() {
    let mut pointer = SimulatedPointer::new();
    assert_eq!(entities(&mut pointer), [0, 0]);
    pointer.select(Some(CRF));
    assert_eq!(entities(&mut pointer), [1, 6]);
    pointer.select(Some(Selected::Tip(BodyRole::Tool)));
    assert_eq!(entities(&mut pointer), [0, 0]);
    pointer.select(Some(TOOL));
    assert_eq!(entities(&mut pointer), [1, 6]);
    // Trials are shown, not moved.
    pointer.app.world_mut().insert_resource(workspaces::study::WORKSPACE);
    settle(&mut pointer.app);
    assert_eq!(entities(&mut pointer), [0, 0]);
    pointer.app.world_mut().insert_resource(workspaces::design::WORKSPACE);
    settle(&mut pointer.app);
    assert_eq!(entities(&mut pointer), [1, 6]);
}

#[test]
fn what_is_hidden_or_locked_has_no_gizmo() {
    type ThingsOf = fn(&mut View) -> &mut Things;
    let things: [ThingsOf; 2] = [|view| &mut view.hidden, |view| &mut view.locked];
    for things_of in things {
        let mut pointer = pointer_with(CRF);
        let mut view = View::default();
        things_of(&mut view).toggle(Thing::Crf);
        pointer.app.world_mut().write_message(ViewRequest::Set(view));
        settle(&mut pointer.app);
        assert_eq!(entities(&mut pointer), [0, 0]);
        pointer.select(Some(TOOL));
        assert_eq!(entities(&mut pointer), [1, 6]);
    }
}
