//! The bar at the top: menus, the program's and the file's name.

use crate::document::requests::{Axis, FileRequest};
use crate::palette;
use crate::palette::ThemedColor;
use crate::shell::PanelAction;
use crate::shell::commands::Command;
use crate::shell::window::Workspace;
use crate::viewport::tool::SceneTool;
use crate::widgets::basic::quiet_ui;
use crate::workspaces::design::sensor_ui::{IsAvailable, item_ui, sensor_menu_ui};
use bevy_egui::egui::{self, Align, Button, Layout, RichText, Ui, vec2};
use trackwright_design::BodyRole;
use trackwright_design::view::{Magnification, View};
use trackwright_project::RecentDesign;

const TAB_WIDTH: f32 = 62.0;

/// What the bar shows.
pub struct TopBarView<'a> {
    /// The file's name, or the built-in design's.
    pub file: &'a str,
    pub is_dirty: bool,
    pub undo_label: Option<&'a str>,
    pub redo_label: Option<&'a str>,
    pub builtins: &'a [&'a str],
    pub recent: &'a [RecentDesign],
    pub view: &'a View,
    pub workspace: Workspace,
    pub is_left_shown: bool,
    pub is_right_shown: bool,
    pub is_history_shown: bool,
    pub is_available: IsAvailable<'a>,
}

/// Draws the bar.
pub fn top_bar_ui(ui: &mut Ui, bar: &TopBarView) -> Vec<PanelAction> {
    let mut actions = Vec::new();
    ui.horizontal_centered(|ui| {
        ui.add_space(4.0);
        ui.label(RichText::new("trackwright").strong().color(palette::TEXT_STRONG.color32()));
        ui.add_space(6.0);
        egui::MenuBar::new().ui(ui, |ui| {
            ui.menu_button("File", |ui| file_menu(ui, bar, &mut actions));
            ui.menu_button("Edit", |ui| {
                menu_ui(ui, bar, &mut actions, &EDIT_MENU);
                ui.separator();
                sensor_menu_ui(ui, bar.is_available, &mut actions);
            });
            ui.menu_button("View", |ui| menu_ui(ui, bar, &mut actions, &VIEW_MENU));
            ui.menu_button("Help", |ui| {
                let help: &[Command] = &[Command::ShowPalette, Command::ShowShortcuts];
                menu_ui(ui, bar, &mut actions, &[help]);
            });
            ui.add_space(14.0);
            ui.label(RichText::new(bar.file).color(palette::TEXT.color32()));
            if bar.is_dirty {
                quiet_ui(ui, "not saved");
            }
        });
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.add_space(8.0);
            for workspace in Workspace::ALL.into_iter().rev() {
                tab_ui(ui, workspace, bar.workspace, &mut actions);
            }
        });
    });
    actions
}

fn tab_ui(ui: &mut Ui, tab: Workspace, shown: Workspace, actions: &mut Vec<PanelAction>) {
    let command = Command::ShowWorkspace(tab);
    let info = command.info();
    let keys = info.keys.first().map(ToString::to_string);
    let about = format!("{} ({})", info.about, keys.unwrap_or_default());
    let tab_button = Button::selectable(tab == shown, tab.name()).min_size(vec2(TAB_WIDTH, 24.0));
    if ui.add(tab_button).on_hover_text(about).clicked() && tab != shown {
        actions.push(PanelAction::Run(command));
    }
}

/// An entry of a menu with the name, the key and the purpose that the table of commands has.
fn command_ui(ui: &mut Ui, command: Command, bar: &TopBarView, actions: &mut Vec<PanelAction>) {
    let name = match command {
        Command::Undo => labelled("Undo", bar.undo_label),
        Command::Redo => labelled("Redo", bar.redo_label),
        Command::ToggleLeft => fold(bar.is_left_shown, "outliner"),
        Command::ToggleRight => fold(bar.is_right_shown, "inspector"),
        Command::ToggleHistory => fold(bar.is_history_shown, "history"),
        Command::ToggleMagnification if bar.view.magnification == Magnification::Times(1.0) => {
            "Magnify errors".to_owned()
        }
        _ => command.info().name.to_owned(),
    };
    let is_enabled = match command {
        Command::Undo => bar.undo_label.is_some(),
        Command::Redo => bar.redo_label.is_some(),
        _ => (bar.is_available)(command),
    };
    if item_ui(ui, &name, command, is_enabled).clicked() {
        actions.push(PanelAction::Run(command));
    }
}

fn labelled(verb: &str, label: Option<&str>) -> String {
    match label {
        Some(label) => format!("{verb} {}", lower_first(label)),
        None => verb.to_owned(),
    }
}

fn fold(is_shown: bool, name: &str) -> String {
    format!("{} {name}", if is_shown { "Hide" } else { "Show" })
}

fn menu_ui(ui: &mut Ui, bar: &TopBarView, actions: &mut Vec<PanelAction>, parts: &[&[Command]]) {
    for (number, part) in parts.iter().enumerate() {
        if number > 0 {
            ui.separator();
        }
        for command in *part {
            command_ui(ui, *command, bar, actions);
        }
    }
}

fn file_menu(ui: &mut Ui, bar: &TopBarView, actions: &mut Vec<PanelAction>) {
    menu_ui(
        ui,
        bar,
        actions,
        &[
            &[Command::New, Command::Open, Command::Save, Command::SaveAs],
            &[
                Command::OpenBody(BodyRole::Tool),
                Command::OpenBody(BodyRole::Crf),
                Command::SaveBody,
            ],
            &[Command::LoadMesh, Command::AddAnatomy],
            &[Command::Report],
        ],
    );
    if !bar.recent.is_empty() {
        ui.separator();
        quiet_ui(ui, "Recent");
        for design in bar.recent {
            let name = design.file.file_name().unwrap_or_default().to_string_lossy();
            let response = ui
                .add_enabled(!design.is_missing, Button::new(name))
                .on_hover_text(design.file.display().to_string())
                .on_disabled_hover_text(format!("{} is gone", design.file.display()));
            if response.clicked() {
                ui.close();
                actions.push(PanelAction::File(FileRequest::Open(design.file.clone())));
            }
        }
    }
    ui.separator();
    quiet_ui(ui, "Built-in designs");
    for name in bar.builtins {
        if ui.button(*name).clicked() {
            ui.close();
            let open = FileRequest::OpenBuiltIn((*name).to_owned());
            actions.push(PanelAction::File(open));
        }
    }
    ui.separator();
    command_ui(ui, Command::Quit, bar, actions);
}

/// Before what is done to the selected sensors.
const EDIT_MENU: [&[Command]; 2] = [
    &[Command::Undo, Command::Redo],
    &[
        Command::Tool(SceneTool::AddSensor),
        Command::AddSensorBeside,
        Command::Tool(SceneTool::SetTip),
    ],
];

const VIEW_MENU: [&[Command]; 4] = [
    &[
        Command::FrameSelection,
        Command::LookAlong(Axis::X),
        Command::LookAlong(Axis::Y),
        Command::LookAlong(Axis::Z),
    ],
    &[Command::ToggleMagnification, Command::ToggleGizmoAxes],
    &[Command::ShowPrecision],
    &[
        Command::ToggleLeft,
        Command::ToggleRight,
        Command::ToggleHistory,
        Command::ToggleTheme,
        Command::LargerInterface,
        Command::SmallerInterface,
        Command::PlainInterface,
    ],
];

fn lower_first(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or_else(String::new, |first| first.to_lowercase().chain(chars).collect())
}
