//! Keys and what they do to the document.

use super::app::{create_app, design, request};
use bevy::input::ButtonState;
use bevy::input::keyboard::{Key, KeyboardInput};
use bevy::prelude::*;
use nalgebra::{Point3, Vector3};
use trackwright_design::{BodyRole, Edit};
use trackwright_editor::document::commands::DocumentCommandsPlugin;
use trackwright_editor::document::requests::{ActiveDrag, EditRequest, OpenWorld};
use trackwright_editor::document::selection::{Selected, Selection};
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
