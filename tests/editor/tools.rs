//! Tools of the scene: what a click does while one is in hand.

use super::app::{create_scene_app_with, named, settle, world};
use super::hand::{Hand, SHAFT};
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
    ADD_SENSOR, ADD_SENSOR_BESIDE, SET_TIP, ViewportCommandsPlugin,
};
use trackwright_editor::viewport::surfaces::Surfaces;
use trackwright_editor::viewport::tool::SceneTool;

/// A hand with a tool in it.
fn hand_with(tool: SceneTool) -> Hand {
    let app = create_scene_app_with(|app| {
        app.add_plugins((CommandsPlugin, DocumentCommandsPlugin, ViewportCommandsPlugin));
    });
    let mut hand = Hand { app };
    settle(&mut hand.app);
    run(
        &mut hand,
        match tool {
            SceneTool::SetTip => SET_TIP,
            _ => ADD_SENSOR,
        },
    );
    hand
}

fn run(hand: &mut Hand, command: Command) {
    hand.app.world_mut().write_message(RunCommand(command.name));
    hand.app.update();
}

fn sensors(design: &Design) -> usize {
    design.bodies().map(|(_, body)| body.rigid.sensors.len()).sum()
}

/// How far a point of the tool is from its surface.
fn off_surface_mm(hand: &Hand, point: &Point3<f64>) -> f64 {
    let surface = hand.resource::<Surfaces>().of(BodyRole::Tool).unwrap();
    (surface.closest(point).position_mm - point).norm()
}

#[test]
fn a_surface_click_adds_a_selected_sensor() {
    let mut hand = hand_with(SceneTool::AddSensor);
    let before = hand.design();
    let (at, _) = hand.shaft();
    hand.click(at);
    let after = hand.design();
    assert_eq!(sensors(&after), sensors(&before) + 1);
    let all = &after.tool.body.rigid.sensors;
    let new = all.last().unwrap();
    let off_mm = off_surface_mm(&hand, &new.position_in_body);
    assert!(off_mm < 1e-6, "{off_mm}");
    let beside_mm = new.position_in_body - hand.position_mm(SHAFT);
    assert!(beside_mm.norm() < 3.0, "under the pointer: {beside_mm}");
    assert!(new.axis_in_body().unwrap().dot(&Vector3::z()).abs() > 0.999, "along the shaft");
    let names: HashSet<&String> = all.iter().map(|sensor| &sensor.name).collect();
    assert_eq!(names.len(), all.len());
    let selected = Some(Selected::Sensor(BodyRole::Tool, all.len() - 1));
    assert_eq!(hand.resource::<Selection>().primary(), selected);
    assert_eq!(*hand.resource::<SceneTool>(), SceneTool::Select);
    assert_eq!(hand.undo_label(), Some(format!("Add sensor {}", new.name)));
    // The tool was put back: the next click adds none.
    hand.click(at + Vec2::new(0.0, 30.0));
    assert_eq!(sensors(&hand.design()), sensors(&before) + 1);
    hand.request(EditRequest::Undo);
    assert_eq!(hand.design(), before);
}

#[test]
fn shift_adds_sensors_until_escape() {
    let mut hand = hand_with(SceneTool::AddSensor);
    let before = hand.design();
    let (at, along) = hand.shaft();
    hand.hold(KeyCode::ShiftLeft);
    hand.click(at);
    hand.click(at + along * 12.0);
    assert_eq!(sensors(&hand.design()), sensors(&before) + 2);
    assert_eq!(*hand.resource::<SceneTool>(), SceneTool::AddSensor);
    run(&mut hand, CANCEL_DRAG);
    assert_eq!(*hand.resource::<SceneTool>(), SceneTool::Select);
    hand.click(at);
    assert_eq!(sensors(&hand.design()), sensors(&before) + 2);
}

#[test]
fn a_click_sets_the_tip_on_the_surface_in_one_step() {
    let mut hand = hand_with(SceneTool::SetTip);
    let before = hand.design();
    let (at, _) = hand.shaft();
    hand.click(at);
    let tip = hand.design().tool.body.rigid.tip_in_body.unwrap();
    assert!(off_surface_mm(&hand, &tip) < 1e-6);
    assert!((tip - hand.position_mm(SHAFT)).norm() < 3.0);
    assert_eq!(hand.undo_label().as_deref(), Some("Move tool tip"));
    let selected = Some(Selected::Tip(BodyRole::Tool));
    assert_eq!(hand.resource::<Selection>().primary(), selected);
    hand.request(EditRequest::Undo);
    assert_eq!(hand.design(), before);
}

#[test]
fn the_preview_shows_what_a_click_does() {
    let mut hand = hand_with(SceneTool::AddSensor);
    let before = hand.design();
    let (at, along) = hand.shaft();
    let hint = |hand: &Hand| hand.resource::<PointerHint>().0.clone().unwrap_or_default();
    hand.move_to(at);
    hand.app.update();
    assert_eq!(named(&mut hand.app, "tool preview"), 2);
    assert!(hint(&hand).starts_with("Click puts a sensor on the tool"));
    let beside = at + along.perp() * 80.0;
    hand.move_to(beside);
    hand.app.update();
    hand.app.update();
    assert_eq!(named(&mut hand.app, "tool preview"), 0);
    assert!(hint(&hand).contains("no body under the pointer"), "{}", hint(&hand));
    hand.click(beside);
    assert_eq!(hand.design(), before);

    let mut view = View::default();
    view.locked.toggle(Thing::Tool);
    hand.app.world_mut().write_message(ViewRequest::Set(view));
    run(&mut hand, ADD_SENSOR);
    settle(&mut hand.app);
    run(&mut hand, ADD_SENSOR);
    let (at, _) = hand.shaft();
    hand.click(at);
    assert!(hint(&hand).contains("the tool is locked"), "{}", hint(&hand));
    assert_eq!(hand.design(), before);
}

#[test]
fn without_a_mesh_no_click_is_possible() {
    let app = create_scene_app_with(|app| {
        app.insert_resource(OpenWorld(world())).insert_resource(SceneTool::AddSensor);
    });
    let mut hand = Hand { app };
    settle(&mut hand.app);
    let before = hand.design();
    let at = hand.pixel(&Point3::origin());
    hand.click(at);
    let hint = hand.resource::<PointerHint>().0.clone().unwrap();
    assert!(hint.contains("the tool has no mesh"), "{hint}");
    assert_eq!(hand.design(), before);
    assert_eq!(named(&mut hand.app, "tool preview"), 0);
}

#[test]
fn an_active_tool_stops_drags_and_handles() {
    let mut hand = hand_with(SceneTool::AddSensor);
    let before = hand.design();
    hand.select(Some(Selected::Body(BodyRole::Tool)));
    assert_eq!(named(&mut hand.app, "gizmo"), 0);
    let start = hand.position_mm(SHAFT);
    let (at, along) = hand.shaft();
    hand.drag(at, along * 15.0, bevy::picking::pointer::PointerButton::Primary);
    assert_eq!(hand.design(), before);
    assert_eq!(hand.position_mm(SHAFT), start);
}

#[test]
fn one_command_starts_and_stops_a_tool() {
    let mut hand = hand_with(SceneTool::SetTip);
    assert_eq!(*hand.resource::<SceneTool>(), SceneTool::SetTip);
    run(&mut hand, ADD_SENSOR);
    assert_eq!(*hand.resource::<SceneTool>(), SceneTool::AddSensor);
    run(&mut hand, ADD_SENSOR);
    assert_eq!(*hand.resource::<SceneTool>(), SceneTool::Select);
    let before = hand.design().crf.unwrap().body.rigid.sensors.len();
    hand.select(Some(Selected::Body(BodyRole::Crf)));
    run(&mut hand, ADD_SENSOR_BESIDE);
    let crf = hand.design().crf.unwrap();
    assert_eq!(crf.body.rigid.sensors.len(), before + 1);
}
