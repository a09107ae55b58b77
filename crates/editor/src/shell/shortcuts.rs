//! Keys into commands.

use crate::schedule::EditorSystems;
use crate::shell::command_palette::CommandPages;
use crate::shell::commands::{CommandRegistry, CommandsSystems, RunCommand};
use crate::shell::dialogs::Dialogs;
use crate::shell::window::Workspace;
use bevy::ecs::system::SystemParam;
use bevy::input::keyboard::{Key, KeyboardFocusLost, KeyboardInput};
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use bevy_egui::input::EguiWantsInput;
use std::collections::VecDeque;

/// Turns keys into commands, in [`EditorSystems::Input`]. Keys belong to a text field while one
/// is edited, and to a dialog while one is open.
pub struct ShortcutsPlugin;

impl Plugin for ShortcutsPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<KeysHeld>()
            .init_resource::<KeysTaken>()
            .init_resource::<KeyboardFocus>()
            .add_message::<TakenKey>()
            .add_message::<RequestRedraw>()
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
#[derive(Clone, Copy, Default)]
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

/// What the keyboard is with, as of the last frame that was drawn.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum KeyboardFocus {
    /// Every key may be a command's.
    #[default]
    Commands,
    /// A button or a row, which has the keys that push it and that lead away from it.
    Widget,
    /// A field, in which keys are text.
    Text,
}

impl KeyboardFocus {
    fn has(self, key: &Key) -> bool {
        match self {
            Self::Commands => false,
            Self::Widget => matches!(
                key,
                Key::Enter
                    | Key::Space
                    | Key::Escape
                    | Key::ArrowLeft
                    | Key::ArrowRight
                    | Key::ArrowUp
                    | Key::ArrowDown
            ),
            Self::Text => true,
        }
    }
}

/// Whether keys are [taken](TakenKey) instead of commands being run; set by who takes them.
#[derive(Resource, Debug, Default)]
pub struct KeysTaken(pub bool);

/// A key that was pressed while keys are taken.
#[derive(Message, Clone, Debug, PartialEq, Eq)]
pub struct TakenKey(pub Key);

/// When keys are turned into commands.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ShortcutsSystems;

/// What keeps the keys to itself.
#[derive(SystemParam)]
struct OpenPages<'w> {
    dialogs: Option<Res<'w, Dialogs>>,
    pages: Option<ResMut<'w, CommandPages>>,
    held: ResMut<'w, KeysHeld>,
}

impl OpenPages<'_> {
    fn take(&mut self) -> bool {
        let is_held = std::mem::take(&mut self.held.bypass_change_detection().0);
        let has_dialog = self.dialogs.as_ref().is_some_and(|dialogs| dialogs.current.is_some());
        is_held || has_dialog || self.pages.as_ref().is_some_and(|pages| pages.is_any_open())
    }

    /// A key of an earlier frame than that in which a page could have it.
    fn type_late(&mut self, key: &Key) {
        if let Some(pages) = &mut self.pages {
            pages.bypass_change_detection().type_key(key);
        }
    }
}

/// Keys are taken in the order in which they were pressed, however many a frame brings: those after one
/// that opens something wait for the next frame, and are for what was opened.
fn press_keys(
    (mut pressed, mut lost): (MessageReader<KeyboardInput>, MessageReader<KeyboardFocusLost>),
    (mut modifiers, mut waiting): (Local<Modifiers>, Local<VecDeque<(Key, Modifiers)>>),
    (egui, focus): (Option<Res<EguiWantsInput>>, Res<KeyboardFocus>),
    mut pages: OpenPages,
    taken: Res<KeysTaken>,
    (registry, workspace): (Option<Res<CommandRegistry>>, Res<Workspace>),
    (mut commands, mut keys, mut redraw): (
        MessageWriter<RunCommand>,
        MessageWriter<TakenKey>,
        MessageWriter<RequestRedraw>,
    ),
) {
    if lost.read().last().is_some() {
        *modifiers = Modifiers::default();
    }
    let late = waiting.len();
    for input in pressed.read() {
        modifiers.follow(input);
        if input.state.is_pressed() {
            waiting.push_back((input.logical_key.clone(), *modifiers));
        }
    }
    let is_egui = egui.is_some_and(|egui| egui.wants_any_keyboard_input());
    let focus = match (is_egui, *focus) {
        (false, _) => KeyboardFocus::Commands,
        (true, KeyboardFocus::Widget) => KeyboardFocus::Widget,
        (true, _) => KeyboardFocus::Text,
    };
    let is_held = pages.take();
    let mut number = 0;
    while let Some((key, Modifiers { control, shift })) = waiting.pop_front() {
        number += 1;
        if is_held || focus.has(&key) {
            if number <= late && !control {
                pages.type_late(&key);
            }
            continue;
        }
        if taken.0 {
            let is_last = matches!(key, Key::Enter | Key::Escape);
            keys.write(TakenKey(key));
            if is_last {
                break;
            }
            continue;
        }
        let command =
            name(&key).and_then(|key| registry.as_ref()?.of_key(&key, control, shift, *workspace));
        if let Some(command) = command {
            commands.write(RunCommand(command.name));
            if command.opens_something() {
                break;
            }
        }
    }
    if !waiting.is_empty() {
        redraw.write(RequestRedraw);
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
