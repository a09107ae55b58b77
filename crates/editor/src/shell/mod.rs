//! The window: bars, docked panels, commands, dialogs, status, preferences. It knows no workspace:
//! workspaces, panels and commands register.

pub mod command_palette;
pub mod commands;
pub mod dialogs;
pub mod drop_plate;
pub mod egui_camera;
pub mod explain_controls;
pub mod focus;
pub mod help;
pub mod keys;
pub mod layout;
pub mod mouse;
pub mod painted_text;
pub mod preferences;
pub mod registry;
pub mod requests;
pub mod shell_commands;
pub mod shortcuts;
pub mod status_bar;
pub mod system_dialog;
pub mod top_bar;
pub mod window;

use bevy::prelude::*;

/// The shell: what is drawn around the 3D view, and the shell's own commands.
pub struct ShellPlugin;

impl Plugin for ShellPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins((
            layout::LayoutPlugin,
            commands::CommandsPlugin,
            shell_commands::ShellCommandsPlugin,
            dialogs::plugin,
            drop_plate::plugin,
            focus::plugin,
        ));
    }
}
