//! Handles in the scene: what a drag of one does to the design, and when there are none.

use super::app::{named, settle};
use super::hand::{Hand, SHAFT};
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

/// A hand with something selected.
fn hand_with(selected: Selected) -> Hand {
    let mut hand = Hand::new();
    hand.select(Some(selected));
    hand
}

fn gizmo(hand: &Hand) -> ShownGizmo {
    let document = &hand.resource::<OpenWorld>().0.document;
    let selection = hand.resource::<Selection>();
    let axes = hand.resource::<GizmoAxes>().0;
    gizmo_of(document.design(), document.view(), selection, axes).expect("a gizmo")
}

/// Where the pointer takes hold of a handle, in the window.
fn grip(hand: &Hand, handle: Handle) -> Vec2 {
    let rig = hand.resource::<OrbitRig>();
    let grip = gizmo(hand).gizmo.grip_px(handle, &rig.eye());
    let [x, y] = grip.expect("a handle within reach");
    hand.resource::<ViewportRect>().min + Vec2::new(x as f32, y as f32)
}

/// The direction on the screen in which an axis of the gizmo runs.
fn direction(hand: &Hand, axis: Axis) -> Vec2 {
    let rig = hand.resource::<OrbitRig>();
    let gizmo = gizmo(hand).gizmo;
    let project = |point: Point3<f64>| rig.camera.project(&point, rig.view_px).unwrap();
    let from = project(gizmo.pivot_mm());
    let to = project(gizmo.pivot_mm() + gizmo.axis(axis).into_inner() * 10.0);
    Vec2::new((to[0] - from[0]) as f32, (to[1] - from[1]) as f32).normalize()
}

/// The direction on the screen in which a ring is turned where it is taken hold of.
fn tangent(hand: &Hand, ring: Handle) -> Vec2 {
    let rig = hand.resource::<OrbitRig>();
    let [x, y] = rig.camera.project(&gizmo(hand).gizmo.pivot_mm(), rig.view_px).unwrap();
    let pivot = hand.resource::<ViewportRect>().min + Vec2::new(x as f32, y as f32);
    (grip(hand, ring) - pivot).perp().normalize()
}

fn drag(hand: &mut Hand, handle: Handle, by: Vec2) {
    let at = grip(hand, handle);
    hand.drag(at, by, PointerButton::Primary);
    hand.release(at + by, PointerButton::Primary);
}

/// Nothing behind a handle is picked through it.
fn lock_sensors(hand: &mut Hand) {
    let world = hand.app.world_mut();
    let document = &world.resource::<OpenWorld>().0.document;
    let mut view = document.view().clone();
    for (role, body) in document.design().bodies() {
        for sensor in &body.rigid.sensors {
            view.locked.toggle(Thing::sensor(role, &sensor.name));
        }
    }
    world.write_message(ViewRequest::Set(view));
    hand.app.update();
}

#[test]
fn the_x_arrow_moves_the_crf_with_the_tool() {
    let mut hand = hand_with(CRF);
    let before = hand.design();
    let arrow = Handle::arrow(Axis::X);
    let axis = gizmo(&hand).gizmo.axis(Axis::X).into_inner();
    let (at, by) = (grip(&hand, arrow), direction(&hand, Axis::X) * 40.0);
    let where_on_axis = |hand: &Hand, at: Vec2| {
        let rig = hand.resource::<OrbitRig>();
        let pixel = hand.resource::<ViewportRect>().pixel(at);
        let gizmo = gizmo(hand).gizmo;
        let ray = rig.camera.ray(pixel, rig.view_px);
        ray.nearest_on_line(&gizmo.pivot_mm(), &gizmo.axis(Axis::X)).unwrap()
    };
    let wanted_mm = where_on_axis(&hand, at + by) - where_on_axis(&hand, at);

    hand.drag(at, by, PointerButton::Primary);
    assert_eq!(hand.resource::<HoveredHandle>().0, Some(arrow));
    let readout = hand.resource::<DragReadout>().0.clone().unwrap();
    assert!(readout.text.starts_with('+') && readout.text.ends_with("\u{2009}mm"));
    hand.release(at + by, PointerButton::Primary);

    let (crf, was) = (hand.design().crf.unwrap(), before.crf.clone().unwrap());
    let moved = crf.tracker_from_crf.translation.vector - was.tracker_from_crf.translation.vector;
    assert!(moved.cross(&axis).norm() < 1e-9, "{moved}");
    // The window's pixels are f32, to 0.0001 of one.
    assert!((moved.dot(&axis) - wanted_mm).abs() < 1e-3, "{moved}");
    assert!(wanted_mm > 1.0);
    assert_eq!(crf.tracker_from_crf.rotation, was.tracker_from_crf.rotation);
    assert_eq!(hand.design().tool, before.tool);
    assert_eq!(hand.undo_label().as_deref(), Some("Move CRF"));
    assert_eq!(hand.resource::<DragReadout>().0, None);
    assert_eq!(hand.resource::<Selection>().primary(), Some(CRF));
    hand.request(EditRequest::Undo);
    assert_eq!(hand.design(), before);
    assert_eq!(hand.undo_label(), None);
}

#[test]
fn control_moves_by_whole_millimetres() {
    let mut hand = hand_with(TOOL);
    let before = hand.design().tool.crf_from_tool;
    let by = direction(&hand, Axis::Y) * 37.0;
    hand.hold(KeyCode::ControlLeft);
    drag(&mut hand, Handle::arrow(Axis::Y), by);
    let after = hand.design().tool.crf_from_tool;
    let moved_mm = (after.translation.vector - before.translation.vector).norm();
    assert!(moved_mm > 0.5 && (moved_mm - moved_mm.round()).abs() < 1e-9, "{moved_mm}");
}

#[test]
fn control_turns_by_five_degrees_about_the_tip() {
    for selected in [CRF, TOOL] {
        let mut hand = hand_with(selected);
        let before = hand.design();
        let pivot_mm = gizmo(&hand).gizmo.pivot_mm();
        hand.hold(KeyCode::ControlLeft);
        let by = tangent(&hand, Handle::ring(Axis::Z)) * 35.0;
        drag(&mut hand, Handle::ring(Axis::Z), by);
        let Selected::Body(role) = selected else { unreachable!() };
        let after = hand.design();
        let [was, is] = [&before, &after].map(|design| design.tracker_from_body(role).unwrap());
        let steps = was.rotation.angle_to(&is.rotation).to_degrees() / 5.0;
        assert!(steps > 0.5 && (steps - steps.round()).abs() < 1e-6, "{steps}");
        assert!((gizmo(&hand).gizmo.pivot_mm() - pivot_mm).norm() < 1e-9);
        assert_eq!(hand.undo_label(), Some(format!("Turn {role}")));
        hand.request(EditRequest::Undo);
        assert_eq!(hand.design(), before);
    }
}

#[test]
fn tracker_axes_move_along_the_tracker() {
    let mut hand = hand_with(CRF);
    let turned = nalgebra::UnitQuaternion::from_euler_angles(0.4, -0.3, 0.8);
    let mut pose = hand.design().crf.unwrap().tracker_from_crf;
    pose.rotation = turned;
    hand.request(EditRequest::Apply(trackwright_design::Edit::SetCrfPose(pose)));
    hand.app.world_mut().resource_mut::<GizmoAxes>().0 = HandleAxes::Tracker;
    settle(&mut hand.app);
    let by = direction(&hand, Axis::Z) * 30.0;
    drag(&mut hand, Handle::arrow(Axis::Z), by);
    let after = hand.design().crf.unwrap().tracker_from_crf;
    let moved = after.translation.vector - pose.translation.vector;
    assert!(moved.z > 1.0 && moved.xy().norm() < 1e-9, "{moved}");
}

#[test]
fn two_rings_turn_a_sensor_in_place() {
    let mut hand = hand_with(Selected::Sensor(BodyRole::Tool, SHAFT));
    // Its own, whatever was chosen for bodies: another frame's could lie along its axis.
    hand.app.world_mut().resource_mut::<GizmoAxes>().0 = HandleAxes::Tracker;
    settle(&mut hand.app);
    assert_eq!(gizmo(&hand).gizmo.handles, Handle::RINGS_OF_AXIS);
    assert_eq!(gizmo(&hand).axes, HandleAxes::Own);
    assert_eq!(named(&mut hand.app, "gizmo handle"), 2);
    let sensor = |hand: &Hand| hand.design().tool.body.rigid.sensors[SHAFT].clone();
    let before = sensor(&hand);
    let by = tangent(&hand, Handle::ring(Axis::X)) * 30.0;
    drag(&mut hand, Handle::ring(Axis::X), by);
    let after = sensor(&hand);
    assert_eq!(after.position_in_body, before.position_in_body);
    assert!(after.axis_in_body().unwrap().angle(&before.axis_in_body().unwrap()) > 0.05);
    let label = Some(format!("Turn sensor {}", before.name));
    assert_eq!(hand.undo_label(), label);
}

#[test]
fn escape_leaves_the_design_to_the_bit_and_lets_go() {
    let mut hand = hand_with(CRF);
    let before = hand.design();
    let at = grip(&hand, Handle::arrow(Axis::X));
    let by = direction(&hand, Axis::X) * 50.0;
    hand.drag(at, by, PointerButton::Primary);
    assert_ne!(hand.design(), before);
    assert_eq!(*hand.resource::<ActiveDrag>(), ActiveDrag(true));
    hand.escape();
    assert_eq!(hand.design(), before);
    hand.move_to(at + by * 2.0);
    hand.app.update();
    hand.release(at + by * 2.0, PointerButton::Primary);
    assert_eq!(hand.design(), before);
    assert_eq!(hand.undo_label(), None);
    assert_eq!(*hand.resource::<ActiveDrag>(), ActiveDrag(false));
}

#[test]
fn a_click_on_a_handle_changes_nothing() {
    let mut hand = hand_with(CRF);
    let before = hand.design();
    lock_sensors(&mut hand);
    let at = grip(&hand, Handle::ring(Axis::Z));
    hand.move_to(at);
    hand.app.update();
    let hint = hand.resource::<PointerHint>().0.clone().unwrap();
    assert!(hint.starts_with("Drag to turn the CRF about its z"), "{hint}");
    hand.click(at);
    assert_eq!(hand.resource::<Selection>().primary(), Some(CRF));
    assert_eq!(hand.design(), before);
    hand.select(None);
    assert_eq!(hand.resource::<HoveredHandle>().0, None);
    assert_eq!(hand.resource::<PointerHint>().0, None);
}

#[test]
fn a_click_passes_a_handle_to_the_sensor() {
    let mut hand = hand_with(Selected::Sensor(BodyRole::Tool, SHAFT));
    let ring = Handle::ring(Axis::X);
    // The other sensors stand along the shaft: one is brought under the ring.
    let at = grip(&hand, ring);
    let mut sensor = hand.design().tool.body.rigid.sensors[SHAFT + 1].clone();
    sensor.position_in_body = {
        let rig = hand.resource::<OrbitRig>();
        let pixel = hand.resource::<ViewportRect>().pixel(at);
        let ray = rig.camera.ray(pixel, rig.view_px);
        let tracker_from_tool = hand.design().tracker_from_body(BodyRole::Tool).unwrap();
        tracker_from_tool.inverse() * ray.at(rig.camera.distance_mm)
    };
    hand.request(EditRequest::Apply(trackwright_design::Edit::SetSensor {
        body: BodyRole::Tool,
        index: SHAFT + 1,
        sensor,
    }));
    settle(&mut hand.app);
    hand.move_to(at);
    hand.app.update();
    assert_eq!(hand.resource::<HoveredHandle>().0, Some(ring));
    hand.click(at);
    let behind = Selected::Sensor(BodyRole::Tool, SHAFT + 1);
    assert_eq!(hand.resource::<Selection>().primary(), Some(behind));
}

fn entities(hand: &mut Hand) -> [usize; 2] {
    ["gizmo", "gizmo handle"].map(|name| named(&mut hand.app, name))
}

#[test]
fn the_gizmo_needs_a_movable_selection() {
    let mut hand = Hand::new();
    assert_eq!(entities(&mut hand), [0, 0]);
    hand.select(Some(CRF));
    assert_eq!(entities(&mut hand), [1, 6]);
    hand.select(Some(Selected::Tip(BodyRole::Tool)));
    assert_eq!(entities(&mut hand), [0, 0]);
    hand.select(Some(TOOL));
    assert_eq!(entities(&mut hand), [1, 6]);
    // Trials are looked at, not moved.
    hand.app.world_mut().insert_resource(workspaces::study::WORKSPACE);
    settle(&mut hand.app);
    assert_eq!(entities(&mut hand), [0, 0]);
    hand.app.world_mut().insert_resource(workspaces::design::WORKSPACE);
    settle(&mut hand.app);
    assert_eq!(entities(&mut hand), [1, 6]);
}

#[test]
fn what_is_hidden_or_locked_has_no_gizmo() {
    type ThingsOf = fn(&mut View) -> &mut Things;
    let things: [ThingsOf; 2] = [|view| &mut view.hidden, |view| &mut view.locked];
    for things_of in things {
        let mut hand = hand_with(CRF);
        let mut view = View::default();
        things_of(&mut view).toggle(Thing::Crf);
        hand.app.world_mut().write_message(ViewRequest::Set(view));
        settle(&mut hand.app);
        assert_eq!(entities(&mut hand), [0, 0]);
        hand.select(Some(TOOL));
        assert_eq!(entities(&mut hand), [1, 6]);
    }
}
