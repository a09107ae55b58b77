//! Keys and what they ask for, in one table.

use super::state::{ActiveDrag, EditRequest, EditorSystems, FileRequest, OpenWorld, ViewRequest};
use super::ui::dialogs::Dialogs;
use super::ui::top_bar::toggled_magnification;
use crate::geometry::orbit::Axis;
use bevy::input::keyboard::{Key, KeyboardFocusLost, KeyboardInput};
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use bevy_egui::input::EguiWantsInput;

/// Turns keys into requests, in [`EditorSystems::Input`]. Keys belong to a text field while one
/// is edited, and to a dialog while one is open.
pub struct ShortcutsPlugin;

/// What a key asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    Undo,
    Redo,
    Save,
    SaveAs,
    Open,
    /// Takes the drag back that is under way.
    CancelDrag,
    ToggleMagnification,
    FrameSelection,
    LookAlong(Axis),
}

/// A key with its modifiers.
struct Shortcut {
    key: &'static str,
    control: bool,
    shift: bool,
    command: Command,
}

const fn plain(key: &'static str, command: Command) -> Shortcut {
    Shortcut {
        key,
        control: false,
        shift: false,
        command,
    }
}

const fn control(key: &'static str, command: Command) -> Shortcut {
    Shortcut {
        control: true,
        ..plain(key, command)
    }
}

const fn control_shift(key: &'static str, command: Command) -> Shortcut {
    Shortcut {
        shift: true,
        ..control(key, command)
    }
}

const SHORTCUTS: [Shortcut; 12] = [
    control("z", Command::Undo),
    control_shift("z", Command::Redo),
    control("y", Command::Redo),
    control("s", Command::Save),
    control_shift("s", Command::SaveAs),
    control("o", Command::Open),
    plain("escape", Command::CancelDrag),
    plain("m", Command::ToggleMagnification),
    plain("f", Command::FrameSelection),
    plain("1", Command::LookAlong(Axis::X)),
    plain("3", Command::LookAlong(Axis::Y)),
    plain("7", Command::LookAlong(Axis::Z)),
];

/// The command of a key; keys are letters in lower case, digits, or `escape`.
pub fn command_of(key: &str, control: bool, shift: bool) -> Option<Command> {
    SHORTCUTS
        .iter()
        .find(|s| s.key == key && s.control == control && s.shift == shift)
        .map(|s| s.command)
}

impl Plugin for ShortcutsPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<ActiveDrag>()
            .init_resource::<Dialogs>()
            .add_message::<KeyboardInput>()
            .add_message::<KeyboardFocusLost>()
            .add_message::<EditRequest>()
            .add_message::<ViewRequest>()
            .add_message::<FileRequest>()
            .add_message::<RequestRedraw>()
            .add_systems(Update, press_keys.in_set(EditorSystems::Input));
    }
}

/// Where commands go.
#[derive(bevy::ecs::system::SystemParam)]
struct Asked<'w> {
    edits: MessageWriter<'w, EditRequest>,
    views: MessageWriter<'w, ViewRequest>,
    files: MessageWriter<'w, FileRequest>,
    redraw: MessageWriter<'w, RequestRedraw>,
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

fn press_keys(
    mut pressed: MessageReader<KeyboardInput>,
    mut lost: MessageReader<KeyboardFocusLost>,
    mut modifiers: Local<Modifiers>,
    egui: Option<Res<EguiWantsInput>>,
    dialogs: Res<Dialogs>,
    state: (Res<ActiveDrag>, Option<Res<OpenWorld>>),
    mut asked: Asked,
) {
    if lost.read().last().is_some() {
        *modifiers = Modifiers::default();
    }
    let is_typing = egui.is_some_and(|egui| egui.wants_any_keyboard_input());
    let is_elsewhere = is_typing || dialogs.current.is_some();
    let (drag, world) = state;
    for input in pressed.read() {
        modifiers.follow(input);
        if is_elsewhere || !input.state.is_pressed() {
            continue;
        }
        let key = match &input.logical_key {
            Key::Character(text) => text.to_lowercase(),
            Key::Escape => "escape".to_owned(),
            _ => continue,
        };
        if let Some(command) = command_of(&key, modifiers.control, modifiers.shift) {
            asked.run(command, drag.0, world.as_deref());
        }
    }
}

impl Asked<'_> {
    fn run(&mut self, command: Command, is_dragging: bool, world: Option<&OpenWorld>) {
        match command {
            Command::CancelDrag if is_dragging => {
                self.edits.write(EditRequest::Cancel);
            }
            Command::CancelDrag => return,
            // Nothing else happens in the middle of a drag.
            _ if is_dragging => return,
            Command::Undo => {
                self.edits.write(EditRequest::Undo);
            }
            Command::Redo => {
                self.edits.write(EditRequest::Redo);
            }
            Command::Save => {
                self.files.write(FileRequest::Save);
            }
            Command::SaveAs => {
                self.files.write(FileRequest::ShowSaveAs);
            }
            Command::Open => {
                self.files.write(FileRequest::ShowOpen);
            }
            Command::FrameSelection => {
                self.views.write(ViewRequest::FrameSelection);
            }
            Command::LookAlong(axis) => {
                self.views.write(ViewRequest::LookAlong(axis));
            }
            Command::ToggleMagnification => {
                if let Some(world) = world {
                    let view = toggled_magnification(world.0.document.view());
                    self.views.write(ViewRequest::Set(view));
                }
            }
        }
        self.redraw.write(RequestRedraw);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shift_tells_redo_from_undo() {
        assert_eq!(command_of("z", true, false), Some(Command::Undo));
        assert_eq!(command_of("z", true, true), Some(Command::Redo));
        assert_eq!(command_of("y", true, false), Some(Command::Redo));
        assert_eq!(command_of("z", false, false), None);
    }

    #[test]
    fn no_two_shortcuts_share_a_key() {
        for (i, a) in SHORTCUTS.iter().enumerate() {
            for b in &SHORTCUTS[i + 1..] {
                assert!(
                    (a.key, a.control, a.shift) != (b.key, b.control, b.shift),
                    "{}",
                    a.key
                );
            }
        }
    }
}
