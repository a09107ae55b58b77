//! The shell's own commands: panels, theme, size, and the pages of commands.

use crate::palette::Theme;
use crate::shell::command_palette::{self, CommandPages};
use crate::shell::commands::{AddCommand, Command, HELP, VIEW};
use crate::shell::egui_camera::EguiCamera;
use crate::shell::help;
use crate::shell::keys::Keys;
use crate::shell::preferences::InterfaceScale;
use crate::shell::window::PanelsShown;
use bevy::prelude::*;

const FOLD_LEFT: Command =
    Command::new(VIEW, 30, "Fold the outliner", "Shows or hides the panels at the left")
        .labelled(|now| toggle_label(now.panels.left, "outliner"));
const FOLD_RIGHT: Command =
    Command::new(VIEW, 31, "Fold the inspector", "Shows or hides the panels at the right")
        .labelled(|now| toggle_label(now.panels.right, "inspector"));
pub const SHOW_HISTORY: Command = Command::new(
    VIEW,
    32,
    "History",
    "Shows or hides the list of every step since the design was opened; a click goes there",
)
.labelled(|now| toggle_label(now.panels.history, "history"));
const SWITCH_THEME: Command = Command::new(
    VIEW,
    33,
    "Light or dark",
    "Dark for a dim room, light for daylight and for paper",
);
const LARGER: Command = Command::new(
    VIEW,
    34,
    "Larger interface",
    "Makes everything that is written larger, up to what leaves the window 960 × 600 points",
)
.keys(&[Keys::control("+"), Keys::control("="), Keys::control_shift("+")]);
const SMALLER: Command =
    Command::new(VIEW, 35, "Smaller interface", "Makes everything that is written smaller")
        .keys(&[Keys::control("-")]);
const PLAIN_SIZE: Command = Command::new(
    VIEW,
    36,
    "Interface at its own size",
    "Makes everything that is written as large as the program has it",
)
.keys(&[Keys::control("0")]);
const SHOW_PALETTE: Command =
    Command::new(HELP, 0, "All commands…", "Finds a command by a part of its name")
        .keys(&[Keys::control_shift("p"), Keys::control("k")]);
const SHOW_SHORTCUTS: Command = Command::new(
    HELP,
    1,
    "Keyboard and mouse…",
    "Lists every key and what the mouse does, with a field to search in",
)
.keys(&[Keys::plain("f1")]);

/// Registers the commands, and draws the pages of commands.
pub struct ShellCommandsPlugin;

impl Plugin for ShellCommandsPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins((command_palette::plugin, help::plugin))
            .add_command(FOLD_LEFT, |mut shown: ResMut<PanelsShown>| shown.left = !shown.left)
            .add_command(FOLD_RIGHT, |mut shown: ResMut<PanelsShown>| shown.right = !shown.right)
            .add_command(SHOW_HISTORY, |mut shown: ResMut<PanelsShown>| {
                shown.history = !shown.history;
                shown.left |= shown.history;
            })
            .add_command(SWITCH_THEME, |mut theme: ResMut<Theme>| {
                *theme = theme.other();
                theme.apply();
            })
            .add_command(LARGER, |scale: ResMut<InterfaceScale>, camera: Shown| {
                step(scale, camera, 1);
            })
            .add_command(SMALLER, |scale: ResMut<InterfaceScale>, camera: Shown| {
                step(scale, camera, -1);
            })
            .add_command(PLAIN_SIZE, |mut scale: ResMut<InterfaceScale>| {
                *scale = InterfaceScale::default();
            })
            .add_command(SHOW_PALETTE, |mut pages: ResMut<CommandPages>| pages.show_palette())
            .add_command(SHOW_SHORTCUTS, |mut pages: ResMut<CommandPages>| pages.show_shortcuts());
    }
}

/// The camera that shows the window, once there is one.
type Shown<'w, 's> = Option<Single<'w, 's, &'static Camera, With<EguiCamera>>>;

fn step(mut scale: ResMut<InterfaceScale>, camera: Shown, direction: i32) {
    let size_px = camera.and_then(|camera| camera.logical_target_size());
    scale.step_in_window(direction, size_px);
}

fn toggle_label(is_shown: bool, name: &str) -> String {
    format!("{} {name}", if is_shown { "Hide" } else { "Show" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_read_as_people_write_them() {
        assert_eq!(SHOW_PALETTE.shown_keys(), "Ctrl+Shift+P");
        assert_eq!(SHOW_SHORTCUTS.shown_keys(), "F1");
        assert_eq!(Keys::plain("escape").to_string(), "Esc");
    }
}
