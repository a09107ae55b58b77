//! Keys into commands.

use crate::schedule::EditorSystems;
use crate::shell::command_palette::CommandPages;
use crate::shell::commands::{CommandsSystems, RunCommand, command_of};
use crate::shell::dialogs::Dialogs;
use crate::shell::window::Workspace;
use crate::workspaces::design::row_page::RowPage;
use bevy::ecs::system::SystemParam;
use bevy::input::keyboard::{Key, KeyboardFocusLost, KeyboardInput};
use bevy::prelude::*;
use bevy_egui::input::EguiWantsInput;

/// Turns keys into commands, in [`EditorSystems::Input`]. Keys belong to a text field while one
/// is edited, and to a dialog while one is open.
pub struct ShortcutsPlugin;

impl Plugin for ShortcutsPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Dialogs>()
            .init_resource::<CommandPages>()
            .init_resource::<RowPage>()
            .init_resource::<Workspace>()
            .add_message::<KeyboardInput>()
            .add_message::<KeyboardFocusLost>()
            .add_message::<RunCommand>()
            .add_systems(Update, press_keys.in_set(EditorSystems::Input).before(CommandsSystems));
    }
}

/// The modifiers as they were at each key, and not as they are at the end of the frame: a quick
/// Ctrl+Z is pressed and let go within one.
#[derive(Default)]
struct Modifiers {
    control: bool,
    shift: bool,
}

impl Modifiers {
    fn follow(&mut self, input: &KeyboardInput) {
        let is_pressed = input.state.is_pressed();
        match input.logical_key {
            Key::Control => self.control = is_pressed,
            Key::Shift => self.shift = is_pressed,
            _ => {}
        }
    }
}

/// What keeps the keys to itself while it is open.
#[derive(SystemParam)]
struct OpenPages<'w> {
    dialogs: Res<'w, Dialogs>,
    commands: Res<'w, CommandPages>,
    row: Res<'w, RowPage>,
}

impl OpenPages<'_> {
    fn is_any(&self) -> bool {
        self.dialogs.current.is_some() || self.commands.is_any_open() || self.row.is_open
    }
}

fn press_keys(
    mut pressed: MessageReader<KeyboardInput>,
    mut lost: MessageReader<KeyboardFocusLost>,
    mut modifiers: Local<Modifiers>,
    egui: Option<Res<EguiWantsInput>>,
    pages: OpenPages,
    workspace: Res<Workspace>,
    mut commands: MessageWriter<RunCommand>,
) {
    if lost.read().last().is_some() {
        *modifiers = Modifiers::default();
    }
    let is_typing = egui.is_some_and(|egui| egui.wants_any_keyboard_input());
    let is_elsewhere = is_typing || pages.is_any();
    for input in pressed.read() {
        modifiers.follow(input);
        if is_elsewhere || !input.state.is_pressed() {
            continue;
        }
        let command = name(&input.logical_key)
            .and_then(|key| command_of(&key, modifiers.control, modifiers.shift, *workspace));
        if let Some(command) = command {
            commands.write(RunCommand(command));
        }
    }
}

/// As the table of commands has it.
fn name(key: &Key) -> Option<String> {
    Some(match key {
        Key::Character(text) => text.to_lowercase(),
        Key::Escape => "escape".to_owned(),
        Key::Space => "space".to_owned(),
        Key::ArrowLeft => "left".to_owned(),
        Key::ArrowRight => "right".to_owned(),
        Key::PageUp => "pageup".to_owned(),
        Key::PageDown => "pagedown".to_owned(),
        Key::Home => "home".to_owned(),
        Key::Delete => "delete".to_owned(),
        Key::F1 => "f1".to_owned(),
        Key::F5 => "f5".to_owned(),
        _ => return None,
    })
}
