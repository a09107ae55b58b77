//! What can be done to the selected sensors, as a menu and as buttons.

use crate::shell::commands::Command;
use crate::shell::top_bar::item_ui;
use crate::viewport::commands::{FOLLOW_SURFACE, SENSOR_COMMANDS};
use crate::viewport::sensor_commands::SensorCommand;
use crate::widgets::basic::section_ui;
use crate::widgets::tooltip::Explain;
use crate::workspaces::design::actions::DesignAction;
use bevy_egui::egui::{self, Button, Ui};
use trackwright_design::MirrorPlane;

/// Whether a command can be chosen now.
pub type IsAvailable<'a> = &'a dyn Fn(&Command) -> bool;

/// Every command for sensors, what cannot be done now greyed.
pub fn sensor_menu_ui(ui: &mut Ui, is_available: IsAvailable<'_>, actions: &mut Vec<DesignAction>) {
    let mut before = SENSOR_COMMANDS[0].1.order / 10;
    for (_, command) in &SENSOR_COMMANDS {
        if command.order / 10 != before {
            ui.separator();
        }
        before = command.order / 10;
        if item_ui(ui, command.name, command, is_available(command)).clicked() {
            actions.push(DesignAction::Run(command.name));
        }
    }
}

/// The same as buttons, with names that fit the inspector; what a sensor measures is chosen above.
pub fn sensor_buttons_ui(
    ui: &mut Ui,
    is_available: IsAvailable<'_>,
    actions: &mut Vec<DesignAction>,
) {
    use SensorCommand::{AlongNormal, AlongShaft, Duplicate, Mirror, MirrorCopy, Remove, Row};
    const PLANES: [(&str, MirrorPlane); 3] =
        [("x = 0", MirrorPlane::X), ("y = 0", MirrorPlane::Y), ("z = 0", MirrorPlane::Z)];
    let mirrors = |command: fn(MirrorPlane) -> SensorCommand| {
        PLANES.map(|(name, plane)| (name, command(plane)))
    };
    section_ui(ui, "Arrange");
    let rows: [(&str, &[(&str, SensorCommand)]); 4] = [
        ("", &[("Duplicate", Duplicate), ("Row…", Row), ("Delete", Remove)]),
        ("mirror", &mirrors(Mirror)),
        ("mirror copy", &mirrors(MirrorCopy)),
        ("axis", &[("along normal", AlongNormal), ("along shaft", AlongShaft)]),
    ];
    egui::Grid::new("arrange").num_columns(2).spacing([10.0, 4.0]).show(ui, |ui| {
        for (name, commands) in rows {
            ui.label(name);
            ui.horizontal(|ui| {
                for (text, command) in commands {
                    button_ui(ui, text, *command, is_available, actions);
                }
            });
            ui.end_row();
        }
        ui.label("drag");
        command_button_ui(ui, "follow the surface", &FOLLOW_SURFACE, is_available, actions);
        ui.end_row();
    });
}

fn button_ui(
    ui: &mut Ui,
    text: &str,
    command: SensorCommand,
    is_available: IsAvailable<'_>,
    actions: &mut Vec<DesignAction>,
) {
    command_button_ui(ui, text, command.command(), is_available, actions);
}

fn command_button_ui(
    ui: &mut Ui,
    text: &str,
    command: &Command,
    is_available: IsAvailable<'_>,
    actions: &mut Vec<DesignAction>,
) {
    let button = ui.add_enabled(is_available(command), Button::new(text));
    let button = button.explained(command.tooltip());
    // Short names are ambiguous: the whole one is for people who cannot see the row.
    ui.ctx().accesskit_node_builder(button.id, |node| {
        node.set_label(command.name.to_owned());
    });
    if button.clicked() {
        actions.push(DesignAction::Run(command.name));
    }
}
