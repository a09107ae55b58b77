//! The camera: frames, views along axes, projections, and what the mouse and a trackpad do to it.

use super::app::{create_scene_app_with, settle};
use super::pointer::{SHAFT, SimulatedPointer};
use bevy::input::ButtonState;
use bevy::input::gestures::PinchGesture;
use bevy::input::mouse::{MouseButtonInput, MouseScrollUnit, MouseWheel};
use bevy::input::touch::TouchPhase;
use bevy::picking::pointer::{PointerAction, PointerButton};
use bevy::prelude::*;
use bevy::window::PrimaryWindow;
use bevy_egui::egui;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use nalgebra::Vector3;
use std::cell::RefCell;
use std::rc::Rc;
use trackwright_design::{BodyRole, Edit, MetalEdit, Thing, Things};
use trackwright_editor::document::requests::{EditRequest, OpenWorld, ViewRequest};
use trackwright_editor::document::selection::{Selected, Selection};
use trackwright_editor::scene::extent;
use trackwright_editor::shell::command_palette::{CommandPages, command_pages_ui};
use trackwright_editor::shell::commands::{CommandRegistry, CommandsPlugin, RunCommand};
use trackwright_editor::shell::mouse::MouseActions;
use trackwright_editor::shell::window::ViewportRect;
use trackwright_editor::viewport::camera::{MainCamera, OrbitRig};
use trackwright_editor::viewport::commands::{
    LOOK_FROM, SWITCH_PROJECTION, ViewportCommandsPlugin,
};
use trackwright_editor::viewport::view_axes::{ViewAxesAction, view_axes_ui};
use trackwright_geometry::orbit::{self, OrbitCamera};
use trackwright_metal::new_object::NewShape;

fn pointer() -> SimulatedPointer {
    let mut app = create_scene_app_with(|app| {
        app.add_plugins((CommandsPlugin, ViewportCommandsPlugin));
    });
    settle(&mut app);
    SimulatedPointer { app }
}

fn run(pointer: &mut SimulatedPointer, command: &'static str) {
    pointer.app.world_mut().write_message(RunCommand(command));
    while {
        pointer.app.update();
        pointer.resource::<OrbitRig>().is_gliding()
    } {}
    settle(&mut pointer.app);
}

fn camera(pointer: &SimulatedPointer) -> OrbitCamera {
    pointer.resource::<OrbitRig>().destination()
}

/// Half of the smaller side of the view, as a sphere's radius.
fn seen_mm(camera: &OrbitCamera) -> f64 {
    camera.view_height_mm() / 2.0
}

#[test]
fn all_is_framed_whatever_is_selected() {
    let mut pointer = pointer();
    pointer.select(Some(Selected::Sensor(BodyRole::Tool, SHAFT)));
    run(&mut pointer, "Frame selection");
    let near = camera(&pointer);
    run(&mut pointer, "Frame all");
    let all = camera(&pointer);
    let world = &pointer.resource::<OpenWorld>().0;
    let design = world.document.design();
    let sphere = extent::of_everything(world, design).unwrap();
    assert!((all.focus_mm - sphere.center_mm).norm() < 1e-9);
    assert!(seen_mm(&all) > sphere.radius_mm && seen_mm(&near) < sphere.radius_mm);
    // Bodies, anatomy and the volume; what is hidden takes no room.
    let mut world = world.clone();
    let mut view = world.document.view().clone();
    let mut with = |volume: bool, hidden: Things| {
        (view.layers.volume, view.hidden) = (volume, hidden);
        world.document.set_view(view.clone());
        extent::of_everything(&world, design).unwrap().radius_mm
    };
    let nothing = Things::default;
    let mut no_crf = nothing();
    no_crf.toggle(Thing::body(BodyRole::Crf));
    let [with_volume, without, tool] =
        [with(true, nothing()), with(false, nothing()), with(false, no_crf)];
    assert!(with_volume > without && without > tool, "{with_volume} {without} {tool}");
}

#[test]
fn what_is_added_far_away_comes_into_view() {
    let mut pointer = pointer();
    run(&mut pointer, "Frame selection");
    let before = camera(&pointer);
    let edit = pointer.resource::<OpenWorld>().0.added_metal(NewShape::Plate.shape(), "plate");
    pointer.app.world_mut().write_message(EditRequest::Apply(edit));
    for _ in 0..3 {
        pointer.app.update();
    }
    while pointer.resource::<OrbitRig>().is_gliding() {
        pointer.app.update();
    }
    settle(&mut pointer.app);
    let now = camera(&pointer);
    let rig_px = pointer.resource::<OrbitRig>().view_px;
    let world = &pointer.resource::<OpenWorld>().0;
    let plate = Selection::of(Some(Selected::Metal(0)));
    let plate = extent::of_selection(world, world.document.design(), &plate).unwrap();
    assert!(!plate.is_seen_by(&before, rig_px), "{before:?} {plate:?}");
    assert!(plate.is_seen_by(&now, rig_px), "{now:?} {plate:?}");
    // Another edit leaves the camera alone.
    run(&mut pointer, "Frame selection");
    let near = camera(&pointer);
    let metal = MetalEdit::SetFrequency(4e3);
    pointer.app.world_mut().write_message(EditRequest::Apply(Edit::Metal(metal)));
    settle(&mut pointer.app);
    assert_eq!(camera(&pointer), near);
}

#[test]
fn a_command_looks_from_each_end_of_the_axes() {
    let mut pointer = pointer();
    for (end, command) in LOOK_FROM {
        run(&mut pointer, command.name);
        let back = camera(&pointer).tracker_from_camera().rotation * Vector3::z();
        assert!((back - end.unit().into_inner()).norm() < 1e-9, "{}", command.name);
    }
}

#[test]
fn the_renderer_follows_the_projection() {
    let mut pointer = pointer();
    run(&mut pointer, SWITCH_PROJECTION.name);
    let height_mm = camera(&pointer).view_height_mm();
    let world = pointer.app.world_mut();
    let mut cameras = world.query_filtered::<&Projection, With<MainCamera>>();
    let Projection::Orthographic(projection) = cameras.single(world).unwrap() else {
        panic!("still in perspective");
    };
    let bevy::camera::ScalingMode::FixedVertical { viewport_height } = projection.scaling_mode
    else {
        panic!("{:?}", projection.scaling_mode);
    };
    assert!((f64::from(viewport_height) - height_mm).abs() < 1e-3);
    let kept = pointer.resource::<OpenWorld>().0.document.view().camera.unwrap();
    assert!(kept.is_orthographic);
    run(&mut pointer, SWITCH_PROJECTION.name);
    assert_eq!(camera(&pointer).projection, orbit::Projection::Perspective);
}

#[test]
fn an_orthographic_view_picks_and_drags_sensors() {
    let mut pointer = pointer();
    run(&mut pointer, SWITCH_PROJECTION.name);
    let (at, along) = pointer.shaft();
    pointer.click(at);
    let selected = pointer.resource::<Selection>().primary();
    assert_eq!(selected, Some(Selected::Sensor(BodyRole::Tool, SHAFT)));
    let start = pointer.position_mm(SHAFT);
    // What a millimetre along the shaft is on the screen: the same everywhere.
    let px_per_mm = (pointer.pixel(&(start + Vector3::z())) - at).length();
    let by = along * 15.0;
    pointer.drag(at, by, PointerButton::Primary);
    pointer.release(at + by, PointerButton::Primary);
    let moved = pointer.position_mm(SHAFT) - start;
    let expected_mm = f64::from(15.0 / px_per_mm);
    assert!((moved.z - expected_mm).abs() < 0.1 * expected_mm, "{moved} {expected_mm}");
}

/// Moves the window's pointer and the one of picking.
fn point(pointer: &mut SimulatedPointer, at: Vec2) {
    let world = pointer.app.world_mut();
    let mut windows = world.query_filtered::<&mut Window, With<PrimaryWindow>>();
    windows.single_mut(world).unwrap().set_cursor_position(Some(at));
    pointer.move_to(at);
    pointer.app.update();
}

fn left(pointer: &mut SimulatedPointer, at: Vec2, state: ButtonState) {
    pointer.app.world_mut().write_message(MouseButtonInput {
        button: MouseButton::Left,
        state,
        window: Entity::PLACEHOLDER,
    });
    pointer.send(
        at,
        match state {
            ButtonState::Pressed => PointerAction::Press(PointerButton::Primary),
            ButtonState::Released => PointerAction::Release(PointerButton::Primary),
        },
    );
    pointer.app.update();
}

/// A drag of the left button with Alt held.
fn alt_drag(pointer: &mut SimulatedPointer, from: Vec2, by: Vec2) {
    pointer.hold(KeyCode::AltLeft);
    point(pointer, from);
    left(pointer, from, ButtonState::Pressed);
    for step in 1..=4 {
        point(pointer, from + by * step as f32 / 4.0);
    }
    left(pointer, from + by, ButtonState::Released);
    pointer.app.update();
}

/// A place of the view with nothing under it.
fn empty_place(pointer: &SimulatedPointer) -> Vec2 {
    pointer.resource::<ViewportRect>().min + Vec2::splat(30.0)
}

#[test]
fn alt_and_the_left_button_orbit() {
    let mut pointer = pointer();
    let selected = Some(Selected::Sensor(BodyRole::Tool, SHAFT));
    pointer.select(selected);
    let before = camera(&pointer);
    let from = empty_place(&pointer);
    alt_drag(&mut pointer, from, Vec2::new(80.0, 0.0));
    let mut expected = before;
    expected.orbit([80.0, 0.0], pointer.resource::<OrbitRig>().view_px);
    assert!((camera(&pointer).azimuth_rad - expected.azimuth_rad).abs() < 1e-9);
    assert_eq!(pointer.resource::<Selection>().primary(), selected, "it is no click");
    let kept = pointer.resource::<OpenWorld>().0.document.view().camera.unwrap();
    assert!((kept.azimuth_rad - expected.azimuth_rad).abs() < 1e-9);
}

#[test]
fn alt_over_a_sensor_is_the_sensors() {
    let mut pointer = pointer();
    let before = camera(&pointer);
    let start = pointer.position_mm(SHAFT);
    let (at, along) = pointer.shaft();
    alt_drag(&mut pointer, at, along * 20.0);
    assert_eq!(camera(&pointer), before);
    assert_ne!(pointer.position_mm(SHAFT), start);
}

fn scroll(pointer: &mut SimulatedPointer, unit: MouseScrollUnit, by: Vec2) {
    pointer.app.world_mut().write_message(MouseWheel {
        unit,
        x: by.x,
        y: by.y,
        window: Entity::PLACEHOLDER,
        phase: TouchPhase::Moved,
    });
    pointer.app.update();
}

#[test]
fn two_fingers_orbit_and_a_wheel_zooms() {
    let mut pointer = pointer();
    let at = empty_place(&pointer);
    point(&mut pointer, at);
    let before = camera(&pointer);
    scroll(&mut pointer, MouseScrollUnit::Pixel, Vec2::new(40.0, 0.0));
    let orbited = camera(&pointer);
    assert_ne!(orbited.azimuth_rad, before.azimuth_rad);
    assert_eq!(orbited.distance_mm, before.distance_mm);
    scroll(&mut pointer, MouseScrollUnit::Line, Vec2::new(0.0, 1.0));
    let nearer = camera(&pointer);
    assert_eq!(nearer.azimuth_rad, orbited.azimuth_rad);
    assert!(nearer.distance_mm < orbited.distance_mm);
    pointer.app.world_mut().write_message(PinchGesture(1.0));
    pointer.app.update();
    let pinched = camera(&pointer);
    assert!((pinched.distance_mm / nearer.distance_mm - 0.5).abs() < 0.01, "{pinched:?}");
    pointer.hold(KeyCode::ShiftLeft);
    scroll(&mut pointer, MouseScrollUnit::Pixel, Vec2::new(0.0, 30.0));
    let panned = camera(&pointer);
    assert_eq!(panned.azimuth_rad, pinched.azimuth_rad);
    assert!((panned.focus_mm - pinched.focus_mm).norm() > 1.0);
    pointer.hold(KeyCode::ControlLeft);
    scroll(&mut pointer, MouseScrollUnit::Pixel, Vec2::new(0.0, 40.0));
    assert!(camera(&pointer).distance_mm < panned.distance_mm);
}

#[test]
fn an_orbit_by_the_axes_is_kept_when_it_ends() {
    let mut pointer = pointer();
    let mut expected = camera(&pointer);
    expected.orbit([50.0, 0.0], pointer.resource::<OrbitRig>().view_px);
    let kept = |pointer: &SimulatedPointer| {
        let world = &pointer.resource::<OpenWorld>().0;
        world.document.view().camera.map(|camera| camera.azimuth_rad)
    };
    for request in [ViewRequest::Orbit([30.0, 0.0]), ViewRequest::Orbit([20.0, 0.0])] {
        pointer.app.world_mut().write_message(request);
        pointer.app.update();
    }
    assert!((camera(&pointer).azimuth_rad - expected.azimuth_rad).abs() < 1e-9);
    assert_ne!(kept(&pointer), Some(camera(&pointer).azimuth_rad));
    pointer.app.world_mut().write_message(ViewRequest::EndOrbit);
    pointer.app.update();
    pointer.app.update();
    assert_eq!(kept(&pointer), Some(camera(&pointer).azimuth_rad));
}

type AxesActions = Rc<RefCell<Vec<ViewAxesAction>>>;

fn axes(camera: OrbitCamera) -> (Harness<'static>, AxesActions) {
    let requests = AxesActions::default();
    let sink = Rc::clone(&requests);
    let size = egui::vec2(120.0, 120.0);
    let mut harness = Harness::builder().with_size(size).build_ui(move |ui| {
        sink.borrow_mut().extend(view_axes_ui(ui, &camera));
    });
    harness.run_steps(3);
    (harness, requests)
}

#[test]
fn each_end_of_the_axes_can_be_clicked() {
    for (_, command) in LOOK_FROM {
        let (mut harness, requests) = axes(OrbitRig::default().camera);
        harness.get_by_label(command.name).click();
        harness.run_steps(3);
        assert_eq!(*requests.borrow(), [ViewAxesAction::Run(command.name)]);
    }
    // Along an axis, its end leaves the middle free.
    let mut along = OrbitRig::default().camera;
    along.look_from(LOOK_FROM[0].0);
    let (mut harness, requests) = axes(along);
    assert!(harness.query_by_label(LOOK_FROM[0].1.name).is_none());
    harness.get_by_label(SWITCH_PROJECTION.name).click();
    harness.run_steps(3);
    assert_eq!(*requests.borrow(), [ViewAxesAction::Run(SWITCH_PROJECTION.name)]);
}

#[test]
fn a_drag_on_the_axes_orbits() {
    let (mut harness, requests) = axes(OrbitRig::default().camera);
    let from = harness.get_by_label("View from +Z").rect().center();
    harness.hover_at(from);
    harness.run_steps(1);
    harness.drag_at(from);
    harness.run_steps(1);
    harness.hover_at(from + egui::vec2(20.0, 0.0));
    harness.run_steps(1);
    harness.drop_at(from + egui::vec2(20.0, 0.0));
    harness.run_steps(3);
    let requests = requests.borrow();
    let orbited: f64 = requests
        .iter()
        .map(|action| match action {
            ViewAxesAction::Orbit([x, _]) => *x,
            _ => 0.0,
        })
        .sum();
    assert!(orbited > 10.0, "{requests:?}");
    assert_eq!(requests.last(), Some(&ViewAxesAction::EndOrbit));
}

#[test]
fn the_page_of_keys_lists_the_mouse() {
    let pointer = pointer();
    let mouse = pointer.resource::<MouseActions>().0.clone();
    let commands = pointer.resource::<CommandRegistry>().all().to_vec();
    let pages = RefCell::new(CommandPages::default());
    pages.borrow_mut().show_shortcuts();
    let mut harness = Harness::builder().with_size(egui::vec2(700.0, 2000.0)).build_ui(move |ui| {
        let mut pages = pages.borrow_mut();
        let _ = command_pages_ui(ui.ctx(), &mut pages, &commands, &mouse, |_| true);
    });
    harness.run_steps(3);
    assert!(harness.query_by_label("wheel").is_some());
}

#[test]
fn the_manual_lists_each_gesture_of_the_mouse() {
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/", "docs/reference/shortcuts.md");
    let page = std::fs::read_to_string(page).unwrap();
    for action in &pointer().resource::<MouseActions>().0 {
        let row = format!("| {} | {} |", action.gesture, action.effect);
        assert!(page.contains(&row), "no row {row}");
    }
}
