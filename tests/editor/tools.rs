//! Tools of the scene: what a click does while one is active.

use super::app::{create_scene_app_with, named, settle, world};
use super::pointer::{SHAFT, SimulatedPointer};
use bevy::prelude::*;
use nalgebra::{Point3, Vector3};
use std::collections::HashSet;
use trackwright_design::{BodyRole, Design, Thing, View};
use trackwright_editor::document::commands::{CANCEL_DRAG, DocumentCommandsPlugin};
use trackwright_editor::document::requests::{EditRequest, OpenWorld, ViewRequest};
use trackwright_editor::document::selection::{Selected, Selection};
use trackwright_editor::shell::commands::{Command, CommandsPlugin, RunCommand};
use trackwright_editor::shell::window::PointerHint;
use trackwright_editor::viewport::commands::{
    ADD_SENSOR, ADD_SENSOR_BESIDE, FOLLOW_SURFACE, SET_TIP, ViewportCommandsPlugin,
};
use trackwright_editor::viewport::sensor_drag::FollowsSurface;
use trackwright_editor::viewport::surfaces::Surfaces;
use trackwright_editor::viewport::tool::SceneTool;

/// A pointer with an active tool.
fn pointer_with(tool: SceneTool) -> SimulatedPointer {
    let app = create_scene_app_with(|app| {
        app.add_plugins((CommandsPlugin, DocumentCommandsPlugin, ViewportCommandsPlugin));
    });
    let mut pointer = SimulatedPointer { app };
    settle(&mut pointer.app);
    run(
        &mut pointer,
        match tool {
            SceneTool::SetTip => SET_TIP,
            _ => ADD_SENSOR,
        },
    );
    pointer
}

fn run(pointer: &mut SimulatedPointer, command: Command) {
    pointer.app.world_mut().write_message(RunCommand(command.name));
    pointer.app.update();
}

fn sensors(design: &Design) -> usize {
    design.bodies().map(|(_, body)| body.rigid.sensors.len()).sum()
}

/// How far a point of the tool is from its surface.
fn off_surface_mm(pointer: &SimulatedPointer, point: &Point3<f64>) -> f64 {
    let surface = pointer.resource::<Surfaces>().of(BodyRole::Tool).unwrap();
    (surface.closest(point).position_mm - point).norm()
}

#[test]
fn a_command_makes_drags_follow_the_surface() {
    let mut pointer = pointer_with(SceneTool::AddSensor);
    for follows in [true, false] {
        run(&mut pointer, FOLLOW_SURFACE);
        assert_eq!(*pointer.resource::<FollowsSurface>(), FollowsSurface(follows));
    }
}

#[test]
fn a_surface_click_adds_a_selected_sensor() {
    let mut pointer = pointer_with(SceneTool::AddSensor);
    let before = pointer.design();
    let (at, _) = pointer.shaft();
    pointer.click(at);
    let after = pointer.design();
    assert_eq!(sensors(&after), sensors(&before) + 1);
    let all = &after.tool.body.rigid.sensors;
    let new = all.last().unwrap();
    let off_mm = off_surface_mm(&pointer, &new.position_in_body);
    assert!(off_mm < 1e-6, "{off_mm}");
    let beside_mm = new.position_in_body - pointer.position_mm(SHAFT);
    assert!(beside_mm.norm() < 3.0, "under the pointer: {beside_mm}");
    assert!(new.axis_in_body().unwrap().dot(&Vector3::z()).abs() > 0.999, "along the shaft");
    let names: HashSet<&String> = all.iter().map(|sensor| &sensor.name).collect();
    assert_eq!(names.len(), all.len());
    let selected = Some(Selected::Sensor(BodyRole::Tool, all.len() - 1));
    assert_eq!(pointer.resource::<Selection>().primary(), selected);
    assert_eq!(*pointer.resource::<SceneTool>(), SceneTool::Select);
    assert_eq!(pointer.undo_label(), Some(format!("Add sensor {}", new.name)));
    // The tool was put back: the next click adds none.
    pointer.click(at + Vec2::new(0.0, 30.0));
    assert_eq!(sensors(&pointer.design()), sensors(&before) + 1);
    pointer.request(EditRequest::Undo);
    assert_eq!(pointer.design(), before);
}

#[test]
fn shift_adds_sensors_until_escape() {
    let mut pointer = pointer_with(SceneTool::AddSensor);
    let before = pointer.design();
    let (at, along) = pointer.shaft();
    pointer.hold(KeyCode::ShiftLeft);
    pointer.click(at);
    pointer.click(at + along * 12.0);
    assert_eq!(sensors(&pointer.design()), sensors(&before) + 2);
    assert_eq!(*pointer.resource::<SceneTool>(), SceneTool::AddSensor);
    run(&mut pointer, CANCEL_DRAG);
    assert_eq!(*pointer.resource::<SceneTool>(), SceneTool::Select);
    pointer.click(at);
    assert_eq!(sensors(&pointer.design()), sensors(&before) + 2);
}

#[test]
fn a_click_sets_the_tip_on_the_surface_in_one_step() {
    let mut pointer = pointer_with(SceneTool::SetTip);
    let before = pointer.design();
    let (at, _) = pointer.shaft();
    pointer.click(at);
    let tip = pointer.design().tool.body.rigid.tip_in_body.unwrap();
    assert!(off_surface_mm(&pointer, &tip) < 1e-6);
    assert!((tip - pointer.position_mm(SHAFT)).norm() < 3.0);
    assert_eq!(pointer.undo_label().as_deref(), Some("Move tool tip"));
    let selected = Some(Selected::Tip(BodyRole::Tool));
    assert_eq!(pointer.resource::<Selection>().primary(), selected);
    pointer.request(EditRequest::Undo);
    assert_eq!(pointer.design(), before);
}

#[test]
fn the_preview_shows_what_a_click_does() {
    let mut pointer = pointer_with(SceneTool::AddSensor);
    let before = pointer.design();
    let (at, along) = pointer.shaft();
    let hint = |pointer: &SimulatedPointer| {
        pointer.resource::<PointerHint>().0.clone().unwrap_or_default()
    };
    pointer.move_to(at);
    pointer.app.update();
    assert_eq!(named(&mut pointer.app, "tool preview"), 2);
    assert!(hint(&pointer).starts_with("Click puts a sensor on the tool"));
    let beside = at + along.perp() * 80.0;
    pointer.move_to(beside);
    pointer.app.update();
    pointer.app.update();
    assert_eq!(named(&mut pointer.app, "tool preview"), 0);
    assert!(hint(&pointer).contains("no body under the pointer"), "{}", hint(&pointer));
    pointer.click(beside);
    assert_eq!(pointer.design(), before);

    let mut view = View::default();
    view.locked.toggle(Thing::Tool);
    pointer.app.world_mut().write_message(ViewRequest::Set(view));
    run(&mut pointer, ADD_SENSOR);
    settle(&mut pointer.app);
    run(&mut pointer, ADD_SENSOR);
    let (at, _) = pointer.shaft();
    pointer.click(at);
    assert!(hint(&pointer).contains("the tool is locked"), "{}", hint(&pointer));
    assert_eq!(pointer.design(), before);
}

#[test]
fn without_a_mesh_no_click_is_possible() {
    let app = create_scene_app_with(|app| {
        app.insert_resource(OpenWorld(world())).insert_resource(SceneTool::AddSensor);
    });
    let mut pointer = SimulatedPointer { app };
    settle(&mut pointer.app);
    let before = pointer.design();
    let at = pointer.pixel(&Point3::origin());
    pointer.click(at);
    let hint = pointer.resource::<PointerHint>().0.clone().unwrap();
    assert!(hint.contains("the tool has no mesh"), "{hint}");
    assert_eq!(pointer.design(), before);
    assert_eq!(named(&mut pointer.app, "tool preview"), 0);
}

#[test]
fn an_active_tool_stops_drags_and_handles() {
    let mut pointer = pointer_with(SceneTool::AddSensor);
    let before = pointer.design();
    pointer.select(Some(Selected::Body(BodyRole::Tool)));
    assert_eq!(named(&mut pointer.app, "gizmo"), 0);
    let start = pointer.position_mm(SHAFT);
    let (at, along) = pointer.shaft();
    pointer.drag(at, along * 15.0, bevy::picking::pointer::PointerButton::Primary);
    assert_eq!(pointer.design(), before);
    assert_eq!(pointer.position_mm(SHAFT), start);
}

#[test]
fn one_command_starts_and_stops_a_tool() {
    let mut pointer = pointer_with(SceneTool::SetTip);
    assert_eq!(*pointer.resource::<SceneTool>(), SceneTool::SetTip);
    run(&mut pointer, ADD_SENSOR);
    assert_eq!(*pointer.resource::<SceneTool>(), SceneTool::AddSensor);
    run(&mut pointer, ADD_SENSOR);
    assert_eq!(*pointer.resource::<SceneTool>(), SceneTool::Select);
    let before = pointer.design().crf.unwrap().body.rigid.sensors.len();
    pointer.select(Some(Selected::Body(BodyRole::Crf)));
    run(&mut pointer, ADD_SENSOR_BESIDE);
    let crf = pointer.design().crf.unwrap();
    assert_eq!(crf.body.rigid.sensors.len(), before + 1);
}
