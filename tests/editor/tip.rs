//! The tip: a click and a drag snap it to points of its body, and a modifier frees it.

use super::app::{change_view, create_scene_app_with, named, settle};
use super::pointer::SimulatedPointer;
use bevy::picking::pointer::PointerButton;
use bevy::prelude::*;
use nalgebra::Point3;
use trackwright_design::{BodyRole, Thing};
use trackwright_editor::document::commands::{CANCEL_DRAG, DocumentCommandsPlugin};
use trackwright_editor::document::requests::EditRequest;
use trackwright_editor::document::selection::Selected;
use trackwright_editor::shell::commands::{CommandsPlugin, RunCommand};
use trackwright_editor::shell::window::DragReadout;
use trackwright_editor::viewport::commands::{SET_TIP, ViewportCommandsPlugin};
use trackwright_editor::viewport::surfaces::Surfaces;
use trackwright_editor::viewport::tip_drag::TipDragPlugin;
use trackwright_editor::viewport::tool::{SceneTool, ToolAim};
use trackwright_geometry::snap::SnapKind;

fn pointer() -> SimulatedPointer {
    let app = create_scene_app_with(|app| {
        app.add_plugins((
            CommandsPlugin,
            DocumentCommandsPlugin,
            ViewportCommandsPlugin,
            TipDragPlugin,
        ));
    });
    let mut pointer = SimulatedPointer { app };
    settle(&mut pointer.app);
    pointer
}

fn run(pointer: &mut SimulatedPointer, command: &'static str) {
    pointer.app.world_mut().write_message(RunCommand(command));
    pointer.app.update();
}

/// The end of the tool's shaft at its tip.
fn shaft_end(pointer: &SimulatedPointer) -> Point3<f64> {
    let points = pointer.resource::<Surfaces>().snap_points(BodyRole::Tool).unwrap();
    let tip = pointer.design().tool.body.rigid.tip_in_body.unwrap();
    let ends = points.iter().filter(|point| point.kind == SnapKind::ShaftEnd);
    let off = |at: &Point3<f64>| (at - tip).norm();
    ends.map(|point| point.at_mm).min_by(|a, b| off(a).total_cmp(&off(b))).unwrap()
}

fn tip(pointer: &SimulatedPointer) -> Point3<f64> {
    pointer.design().tool.body.rigid.tip_in_body.unwrap()
}

fn readout(pointer: &SimulatedPointer) -> String {
    let readout = pointer.resource::<DragReadout>();
    readout.0.as_ref().map(|readout| readout.text.clone()).unwrap_or_default()
}

#[test]
fn a_click_near_the_shaft_end_sets_the_tip_on_it() {
    let mut pointer = pointer();
    let before = pointer.design();
    let end = shaft_end(&pointer);
    run(&mut pointer, SET_TIP.name);
    let near = pointer.pixel(&end) + Vec2::new(5.0, 4.0);
    pointer.move_to(near);
    pointer.app.update();
    pointer.app.update();
    assert_eq!(pointer.resource::<ToolAim>().snap(), Some(SnapKind::ShaftEnd));
    assert_eq!(readout(&pointer), "shaft end");
    pointer.click(near);
    let off_mm = (tip(&pointer) - end).norm();
    assert!(off_mm < 1e-9, "{off_mm}");
    assert_eq!(readout(&pointer), "");
    pointer.request(EditRequest::Undo);
    assert_eq!(pointer.design(), before);
}

#[test]
fn alt_frees_the_tip_from_snapping() {
    let mut pointer = pointer();
    let end = shaft_end(&pointer);
    run(&mut pointer, SET_TIP.name);
    pointer.hold(KeyCode::AltLeft);
    let near = pointer.pixel(&end) + Vec2::new(5.0, 4.0);
    pointer.move_to(near);
    pointer.app.update();
    pointer.app.update();
    assert_eq!(pointer.resource::<ToolAim>().snap(), None);
    run(&mut pointer, CANCEL_DRAG.name);
    assert_eq!(*pointer.resource::<SceneTool>(), SceneTool::Select);
}

#[test]
fn the_selected_tip_is_dragged_to_the_shaft_end() {
    let mut pointer = pointer();
    assert_eq!(named(&mut pointer.app, "tip handle"), 0);
    let end = shaft_end(&pointer);
    let away = trackwright_design::Edit::SetTip {
        body: BodyRole::Tool,
        tip_in_body: Some(end + nalgebra::Vector3::new(0.0, 25.0, 0.0)),
    };
    pointer.request(EditRequest::Apply(away));
    pointer.select(Some(Selected::Tip(BodyRole::Tool)));
    assert_eq!(named(&mut pointer.app, "tip handle"), 1);
    let before = pointer.design();
    let from = pointer.pixel(&tip(&pointer));
    let to = pointer.pixel(&end) + Vec2::new(4.0, 3.0);
    pointer.drag(from, to - from, PointerButton::Primary);
    assert!(readout(&pointer).starts_with("shaft end"), "{}", readout(&pointer));
    pointer.release(to, PointerButton::Primary);
    let off_mm = (tip(&pointer) - end).norm();
    assert!(off_mm < 1e-9, "{off_mm}");
    assert_eq!(pointer.undo_label().as_deref(), Some("Move tool tip"));
    pointer.request(EditRequest::Undo);
    assert_eq!(pointer.design(), before);
    pointer.select(None);
    assert_eq!(named(&mut pointer.app, "tip handle"), 0);
}

#[test]
fn the_ball_of_the_tip_needs_a_free_body_and_no_tool() {
    let mut pointer = pointer();
    pointer.select(Some(Selected::Tip(BodyRole::Tool)));
    let balls = |pointer: &mut SimulatedPointer| named(&mut pointer.app, "tip handle");
    assert_eq!(balls(&mut pointer), 1);
    for expected in [0, 1] {
        change_view(&mut pointer.app, |view| view.locked.toggle(Thing::Tool));
        assert_eq!(balls(&mut pointer), expected);
    }
    for (tool, expected) in [(SceneTool::SetTip, 0), (SceneTool::Select, 1)] {
        *pointer.app.world_mut().resource_mut::<SceneTool>() = tool;
        settle(&mut pointer.app);
        assert_eq!(balls(&mut pointer), expected);
    }
}

#[test]
fn escape_takes_the_drag_of_the_tip_back() {
    let mut pointer = pointer();
    pointer.select(Some(Selected::Tip(BodyRole::Tool)));
    let before = pointer.design();
    let from = pointer.pixel(&tip(&pointer));
    pointer.drag(from, Vec2::new(40.0, 10.0), PointerButton::Primary);
    assert_ne!(pointer.design(), before);
    pointer.assert_escape_restores(&before, from + Vec2::new(50.0, 10.0));
}
