//! Keys and what they do to the document.

use super::app::{create_app, design, request};
use bevy::input::ButtonState;
use bevy::input::keyboard::{Key, KeyboardInput};
use bevy::prelude::*;
use nalgebra::{Point3, Vector3};
use trackwright_design::{BodyRole, Design, Edit};
use trackwright_editor::document::commands::DocumentCommandsPlugin;
use trackwright_editor::document::requests::{ActiveDrag, EditRequest, FileRequest, OpenWorld};
use trackwright_editor::document::selection::{Selected, Selection};
use trackwright_editor::document::state::Notice;
use trackwright_editor::shell::command_palette::CommandPages;
use trackwright_editor::shell::commands::CommandsPlugin;
use trackwright_editor::shell::dialogs::{Dialogs, ErrorDialog};
use trackwright_editor::shell::shell_commands::ShellCommandsPlugin;
use trackwright_editor::shell::shortcuts::ShortcutsPlugin;
use trackwright_editor::viewport::camera::OrbitRig;
use trackwright_editor::viewport::commands::ViewportCommandsPlugin;
use trackwright_editor::workspaces::design::row_page::{self, RowPage};
use trackwright_geometry::pose::Pose;

fn key(app: &mut App, key: &Key, state: ButtonState) {
    app.world_mut().write_message(KeyboardInput {
        key_code: KeyCode::KeyA,
        logical_key: key.clone(),
        state,
        text: None,
        repeat: false,
        window: Entity::PLACEHOLDER,
    });
}

/// A chord that is pressed and let go between two frames.
fn chord(app: &mut App, keys: &[Key]) {
    for k in keys {
        key(app, k, ButtonState::Pressed);
    }
    for k in keys.iter().rev() {
        key(app, k, ButtonState::Released);
    }
    app.update();
}

fn edited_app() -> App {
    let mut app = create_app();
    app.add_plugins((
        ShortcutsPlugin,
        CommandsPlugin,
        ShellCommandsPlugin,
        DocumentCommandsPlugin,
        ViewportCommandsPlugin,
        row_page::plugin,
    ));
    request(&mut app, EditRequest::Apply(Edit::SetToolPose(Pose::translation(9.0, 0.0, 30.0))));
    app.update();
    app
}

fn is_as_it_was(app: &App) -> bool {
    *app.world().resource::<OpenWorld>().0.document.design() == design()
}

#[test]
fn control_z_undoes_and_shift_redoes() {
    let mut app = edited_app();
    assert!(!is_as_it_was(&app));
    let z = Key::Character("z".into());
    chord(&mut app, &[Key::Control, z]);
    assert!(is_as_it_was(&app));
    let z = Key::Character("Z".into());
    chord(&mut app, &[Key::Control, Key::Shift, z]);
    assert!(!is_as_it_was(&app));
}

fn sensor_mm(app: &App, index: usize) -> Point3<f64> {
    let design = app.world().resource::<OpenWorld>().0.document.design();
    design.tool.body.rigid.sensors[index].position_in_body
}

#[test]
fn arrows_nudge_sensors_on_the_screen() {
    let mut app = edited_app();
    app.init_resource::<OrbitRig>();
    let camera = app.world().resource::<OrbitRig>().camera.tracker_from_camera().rotation;
    let tracker_from_tool = {
        let design = app.world().resource::<OpenWorld>().0.document.design();
        design.tracker_from_body(BodyRole::Tool).unwrap().rotation
    };
    let own = sensor_mm(&app, 0);
    // Without a selection they move nothing.
    chord(&mut app, &[Key::ArrowRight]);
    assert_eq!(sensor_mm(&app, 0), own);
    let first = Selected::Sensor(BodyRole::Tool, 0);
    *app.world_mut().resource_mut::<Selection>() = Selection::of(Some(first));
    let arrows = [
        (Key::ArrowRight, Vector3::x()),
        (Key::ArrowLeft, -Vector3::x()),
        (Key::ArrowUp, Vector3::y()),
        (Key::ArrowDown, -Vector3::y()),
    ];
    for (arrow, on_screen) in arrows {
        for (keys, step_mm) in [(vec![arrow.clone()], 1.0), (vec![Key::Shift, arrow], 0.1)] {
            let before = sensor_mm(&app, 0);
            chord(&mut app, &keys);
            app.update();
            let moved_mm = sensor_mm(&app, 0) - before;
            assert!((moved_mm.amax() - step_mm).abs() < 1e-9, "{moved_mm}");
            assert!((moved_mm.norm() - step_mm).abs() < 1e-9, "{moved_mm}");
            // At least as far in the arrow's direction as one axis of three has to point.
            let along_mm = (camera.inverse() * (tracker_from_tool * moved_mm)).dot(&on_screen);
            assert!(along_mm > 0.57 * step_mm, "{along_mm}");
        }
    }
    assert!((sensor_mm(&app, 0) - own).norm() < 1e-9);
    // Several move together, in one step.
    let mut both = Selection::of(Some(first));
    both.toggle(Selected::Sensor(BodyRole::Tool, 1));
    *app.world_mut().resource_mut::<Selection>() = both;
    let before = [0, 1].map(|index| sensor_mm(&app, index));
    chord(&mut app, &[Key::ArrowRight]);
    app.update();
    let moved = [0, 1].map(|index| sensor_mm(&app, index) - before[index]);
    assert!((moved[0] - moved[1]).norm() < 1e-12 && moved[0].norm() > 0.99, "{moved:?}");
    request(&mut app, EditRequest::Undo);
    app.update();
    assert_eq!([0, 1].map(|index| sensor_mm(&app, index)), before);
}

#[test]
fn nothing_is_undone_in_the_middle_of_a_drag() {
    let mut app = edited_app();
    app.world_mut().resource_mut::<ActiveDrag>().0 = true;
    chord(&mut app, &[Key::Control, Key::Character("z".into())]);
    assert!(!is_as_it_was(&app));
}

#[test]
fn a_dialog_keeps_the_keys_to_itself() {
    let mut app = edited_app();
    let error = std::io::Error::other("no");
    app.world_mut().resource_mut::<Dialogs>().show(ErrorDialog::new("Sorry", &error));
    chord(&mut app, &[Key::Control, Key::Character("z".into())]);
    assert!(!is_as_it_was(&app));
}

#[test]
fn the_palette_keeps_the_keys_to_itself() {
    let mut app = edited_app();
    let p = Key::Character("P".into());
    chord(&mut app, &[Key::Control, Key::Shift, p]);
    assert!(app.world().resource::<CommandPages>().is_any_open());
    chord(&mut app, &[Key::Control, Key::Character("z".into())]);
    assert!(!is_as_it_was(&app));
}

fn tool_sensors(app: &App) -> usize {
    let design = app.world().resource::<OpenWorld>().0.document.design();
    design.tool.body.rigid.sensors.len()
}

#[test]
fn control_d_copies_and_delete_removes() {
    let mut app = edited_app();
    let shaft = Selection::of_sensors(BodyRole::Tool, [0]);
    *app.world_mut().resource_mut::<Selection>() = shaft;
    chord(&mut app, &[Key::Control, Key::Character("d".into())]);
    assert_eq!(tool_sensors(&app), 3);
    chord(&mut app, &[Key::Delete]);
    assert_eq!(tool_sensors(&app), 2);
    // The body is selected now, which cannot be deleted.
    chord(&mut app, &[Key::Delete]);
    assert_eq!(tool_sensors(&app), 2);
}

#[test]
fn the_page_of_a_row_keeps_the_keys_to_itself() {
    let mut app = edited_app();
    let shaft = Selection::of_sensors(BodyRole::Tool, [0]);
    *app.world_mut().resource_mut::<Selection>() = shaft;
    app.world_mut().resource_mut::<RowPage>().is_open = true;
    chord(&mut app, &[Key::Delete]);
    assert_eq!(tool_sensors(&app), 2);
}

fn select(app: &mut App, selection: Selection) {
    *app.world_mut().resource_mut::<Selection>() = selection;
    app.update();
}

/// Keys that are pressed one after the other, all between two frames.
fn type_quickly(app: &mut App, keys: &str) {
    for typed in keys.chars() {
        let pressed = match typed {
            '\n' => Key::Enter,
            '\u{1b}' => Key::Escape,
            '\u{8}' => Key::Backspace,
            typed => Key::Character(typed.to_string().into()),
        };
        key(app, &pressed, ButtonState::Pressed);
        key(app, &pressed, ButtonState::Released);
    }
    for _ in 0..4 {
        app.update();
    }
}

fn open_design(app: &App) -> &Design {
    app.world().resource::<OpenWorld>().0.document.design()
}

#[test]
fn typed_numbers_move_and_turn_exactly() {
    let mut app = edited_app();
    select(&mut app, Selection::of_sensors(BodyRole::Tool, [0]));
    let before = open_design(&app).clone();
    let own = sensor_mm(&app, 0);
    for (keys, moved) in [
        ("gx12.5\n", Vector3::new(12.5, 0.0, 0.0)),
        ("gy-3\n", Vector3::new(0.0, -3.0, 0.0)),
        // A number first, a minus after it, one digit too many, another axis.
        ("g45\u{8}x-z\n", Vector3::new(0.0, 0.0, -4.0)),
        ("g,25x\n", Vector3::new(0.25, 0.0, 0.0)),
    ] {
        type_quickly(&mut app, keys);
        assert_eq!(sensor_mm(&app, 0), own + moved, "{keys:?}");
        assert!(!app.world().resource::<ActiveDrag>().0);
        request(&mut app, EditRequest::Undo);
        app.update();
        assert_eq!(*open_design(&app), before, "one step");
    }
    // In the tracker's axes, by the axis a second time.
    type_quickly(&mut app, "gyy7\n");
    let design = open_design(&app);
    let rotation = design.tracker_from_body(BodyRole::Tool).unwrap().rotation;
    let moved = rotation * (sensor_mm(&app, 0) - own);
    assert!((moved - Vector3::new(0.0, 7.0, 0.0)).norm() < 1e-12, "{moved}");

    select(&mut app, Selection::of(Some(Selected::Body(BodyRole::Tool))));
    let tip = |design: &Design| {
        let tracker_from_tool = design.tracker_from_body(BodyRole::Tool).unwrap();
        (
            tracker_from_tool * design.tool.body.rigid.judged_tip_in_body(),
            tracker_from_tool.rotation,
        )
    };
    let (tip_before, turn_before) = tip(open_design(&app));
    type_quickly(&mut app, "rzz90\n");
    let (tip_after, turn_after) = tip(open_design(&app));
    assert!((tip_after - tip_before).norm() < 1e-10, "a tool is turned about its tip");
    let turn = turn_after * turn_before.inverse();
    assert!((turn.angle() - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    assert!((turn.axis().unwrap().into_inner() - Vector3::z()).norm() < 1e-9);
}

#[test]
fn a_typed_move_ends_without_a_trace() {
    let mut app = edited_app();
    let before = open_design(&app).clone();
    // Nothing is selected: no mode begins, and the status line states what is missing.
    type_quickly(&mut app, "gx");
    assert!(
        matches!(app.world().resource::<Notice>(), Notice::Refused(why) if why.contains("move"))
    );
    assert!(!app.world().resource::<ActiveDrag>().0);
    select(&mut app, Selection::of_sensors(BodyRole::Tool, [0, 1]));
    type_quickly(&mut app, "gx5");
    assert_ne!(*open_design(&app), before);
    assert!(app.world().resource::<ActiveDrag>().0);
    type_quickly(&mut app, "\u{1b}");
    assert_eq!(*open_design(&app), before);
    assert_eq!(app.world().resource::<OpenWorld>().0.document.undo_label(), Some("Move tool"));
    // Another selection keeps what was typed, as a step of its own.
    type_quickly(&mut app, "gx5");
    select(&mut app, Selection::of(Some(Selected::Body(BodyRole::Tool))));
    assert!(!app.world().resource::<ActiveDrag>().0);
    let label = app.world().resource::<OpenWorld>().0.document.undo_label();
    assert_eq!(label, Some("Move 2 sensors"));
    // Another design has nothing of it.
    type_quickly(&mut app, "gx5");
    app.world_mut().write_message(FileRequest::Discard(Box::new(FileRequest::OpenBuiltIn(
        "endoscope".to_owned(),
    ))));
    app.update();
    type_quickly(&mut app, "7\n");
    assert!(!app.world().resource::<ActiveDrag>().0);
    assert!(!app.world().resource::<OpenWorld>().0.document.is_dirty());
}

#[test]
fn keys_after_one_that_opens_are_no_commands() {
    // The palette's shortcut with a name and Enter, all within one slow frame.
    let mut app = edited_app();
    select(&mut app, Selection::of_sensors(BodyRole::Tool, [0]));
    let before = open_design(&app).clone();
    key(&mut app, &Key::Control, ButtonState::Pressed);
    key(&mut app, &Key::Character("k".into()), ButtonState::Pressed);
    key(&mut app, &Key::Control, ButtonState::Released);
    for letter in ["a", "t", "n"] {
        key(&mut app, &Key::Character(letter.into()), ButtonState::Pressed);
    }
    key(&mut app, &Key::Delete, ButtonState::Pressed);
    app.update();
    app.update();
    assert_eq!(app.world().resource::<CommandPages>().text(), "atn");
    assert_eq!(*open_design(&app), before);
    // Commands that open nothing all run in the frame that brings them.
    let mut app = edited_app();
    request(&mut app, EditRequest::Apply(Edit::SetToolPose(Pose::translation(1.0, 0.0, 30.0))));
    app.update();
    for state in [ButtonState::Pressed, ButtonState::Released].repeat(2) {
        key(&mut app, &Key::Control, ButtonState::Pressed);
        key(&mut app, &Key::Character("z".into()), state);
    }
    app.update();
    assert!(is_as_it_was(&app));
}
