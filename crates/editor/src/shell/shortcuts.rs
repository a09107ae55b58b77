//! Keys into commands.

use crate::schedule::EditorSystems;
use crate::shell::command_palette::CommandPages;
use crate::shell::commands::{CommandRegistry, CommandsSystems, RunCommand};
use crate::shell::dialogs::Dialogs;
use crate::shell::window::Workspace;
use bevy::ecs::system::SystemParam;
use bevy::input::keyboard::{Key, KeyboardFocusLost, KeyboardInput};
use bevy::prelude::*;
use bevy_egui::input::EguiWantsInput;

/// Turns keys into commands, in [`EditorSystems::Input`]. Keys belong to a text field while one
/// is edited, and to a dialog while one is open.
pub struct ShortcutsPlugin;

impl Plugin for ShortcutsPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<KeysHeld>()
            .add_message::<KeyboardInput>()
            .add_message::<KeyboardFocusLost>()
            .add_message::<RunCommand>()
            .add_systems(
                Update,
                press_keys
                    .in_set(ShortcutsSystems)
                    .in_set(EditorSystems::Input)
                    .before(CommandsSystems),
            );
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

/// Whether a page that is open keeps the keys to itself in this frame; set by its owner before
/// [`ShortcutsSystems`].
#[derive(Resource, Debug, Default)]
pub struct KeysHeld(pub bool);

/// When keys are turned into commands.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ShortcutsSystems;

/// What keeps the keys to itself.
#[derive(SystemParam)]
struct OpenPages<'w> {
    dialogs: Option<Res<'w, Dialogs>>,
    pages: Option<Res<'w, CommandPages>>,
    held: ResMut<'w, KeysHeld>,
}

impl OpenPages<'_> {
    fn take(&mut self) -> bool {
        let is_held = std::mem::take(&mut self.held.bypass_change_detection().0);
        let has_dialog = self.dialogs.as_ref().is_some_and(|dialogs| dialogs.current.is_some());
        is_held || has_dialog || self.pages.as_ref().is_some_and(|pages| pages.is_any_open())
    }
}

fn press_keys(
    (mut pressed, mut lost): (MessageReader<KeyboardInput>, MessageReader<KeyboardFocusLost>),
    mut modifiers: Local<Modifiers>,
    egui: Option<Res<EguiWantsInput>>,
    mut pages: OpenPages,
    registry: Option<Res<CommandRegistry>>,
    workspace: Res<Workspace>,
    mut commands: MessageWriter<RunCommand>,
) {
    if lost.read().last().is_some() {
        *modifiers = Modifiers::default();
    }
    let is_typing = egui.is_some_and(|egui| egui.wants_any_keyboard_input());
    let is_elsewhere = pages.take() || is_typing;
    for input in pressed.read() {
        modifiers.follow(input);
        if is_elsewhere || !input.state.is_pressed() {
            continue;
        }
        let Modifiers { control, shift } = *modifiers;
        let command = name(&input.logical_key)
            .and_then(|key| registry.as_ref()?.of_key(&key, control, shift, *workspace));
        if let Some(command) = command {
            commands.write(RunCommand(command.name));
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
        Key::ArrowUp => "up".to_owned(),
        Key::ArrowDown => "down".to_owned(),
        Key::PageUp => "pageup".to_owned(),
        Key::PageDown => "pagedown".to_owned(),
        Key::Home => "home".to_owned(),
        Key::Delete => "delete".to_owned(),
        Key::F1 => "f1".to_owned(),
        Key::F5 => "f5".to_owned(),
        _ => return None,
    })
}
