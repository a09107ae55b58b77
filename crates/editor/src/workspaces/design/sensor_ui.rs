//! What can be done to the selected sensors, as a menu and as buttons.

use crate::shell::PanelAction;
use crate::shell::commands::Command;
use crate::viewport::sensor_commands::{SENSOR_MENU, SensorCommand};
use crate::widgets::basic::section_ui;
use bevy_egui::egui::{self, Button, Response, Ui};
use trackwright_design::MirrorPlane;

/// Wide enough for the longest name with its key.
const MENU_WIDTH: f32 = 220.0;

/// Whether a command can be chosen now.
pub type IsAvailable<'a> = &'a dyn Fn(Command) -> bool;

/// An entry of a menu, with the key and the purpose that the table of commands has.
pub fn item_ui(ui: &mut Ui, text: &str, command: Command, is_enabled: bool) -> Response {
    ui.set_min_width(MENU_WIDTH);
    let info = command.info();
    let keys = info.keys.first().map(ToString::to_string);
    let button = Button::new(text).shortcut_text(keys.unwrap_or_default());
    let response = ui.add_enabled(is_enabled, button).on_hover_text(info.about);
    if response.clicked() {
        ui.close();
    }
    response
}

/// Every command for sensors, what cannot be done now greyed.
pub fn sensor_menu_ui(ui: &mut Ui, is_available: IsAvailable<'_>, actions: &mut Vec<PanelAction>) {
    for (number, part) in SENSOR_MENU.iter().enumerate() {
        if number > 0 {
            ui.separator();
        }
        for command in *part {
            if item_ui(ui, command.info().name, *command, is_available(*command)).clicked() {
                actions.push(PanelAction::Run(*command));
            }
        }
    }
}

/// The same as buttons, with names that fit the inspector; what a sensor measures is chosen above.
pub fn sensor_buttons_ui(
    ui: &mut Ui,
    is_available: IsAvailable<'_>,
    actions: &mut Vec<PanelAction>,
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
    });
}

fn button_ui(
    ui: &mut Ui,
    text: &str,
    command: SensorCommand,
    is_available: IsAvailable<'_>,
    actions: &mut Vec<PanelAction>,
) {
    let command = Command::Sensors(command);
    let info = command.info();
    let button = ui.add_enabled(is_available(command), Button::new(text)).on_hover_text(info.about);
    // Short names say the same twice: the whole one is for people who cannot see the row.
    ui.ctx().accesskit_node_builder(button.id, |node| {
        node.set_label(info.name.to_owned());
    });
    if button.clicked() {
        actions.push(PanelAction::Run(command));
    }
}
