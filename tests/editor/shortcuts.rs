//! Keys and what they do to the document.

use super::app::{create_app, design, request};
use bevy::input::ButtonState;
use bevy::input::keyboard::{Key, KeyboardInput};
use bevy::prelude::*;
use trackwright_design::{BodyRole, Edit};
use trackwright_editor::document::commands::DocumentCommandsPlugin;
use trackwright_editor::document::requests::{ActiveDrag, EditRequest, OpenWorld};
use trackwright_editor::document::selection::Selection;
use trackwright_editor::shell::command_palette::CommandPages;
use trackwright_editor::shell::commands::CommandsPlugin;
use trackwright_editor::shell::dialogs::{Dialogs, ErrorDialog};
use trackwright_editor::shell::shell_commands::ShellCommandsPlugin;
use trackwright_editor::shell::shortcuts::ShortcutsPlugin;
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
