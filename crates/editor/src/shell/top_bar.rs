//! The bar at the top: menus, the file's name, the workspaces' tabs.

use crate::document::file_names::file_name;
use crate::document::recent::RecentDesigns;
use crate::document::requests::FileRequest;
use crate::palette;
use crate::palette::ThemedColor;
use crate::shell::commands::{
    Availability, Command, CommandRegistry, EDIT, FILE, Group, HELP, RunCommand, Situation, VIEW,
};
use crate::shell::registry::Workspaces;
use crate::shell::requests::Requests;
use crate::shell::window::Workspace;
use crate::widgets::basic::quiet_ui;
use bevy::prelude::*;
use bevy_egui::egui::{self, Align, Button, Layout, Response, RichText, Ui, vec2};
use trackwright_project::RecentDesign;

const TAB_WIDTH: f32 = 62.0;

/// Wide enough for the longest name with its key.
const MENU_WIDTH: f32 = 220.0;

/// What the bar shows.
pub struct TopBarView<'a> {
    /// The file's name, or the built-in design's.
    pub file: &'a str,
    pub is_dirty: bool,
    pub builtins: &'a [&'a str],
    pub recent: &'a [RecentDesign],
    pub workspaces: &'a [Workspace],
    pub commands: &'a [Command],
    pub situation: Situation<'a>,
}

/// What a person requested in the bar.
#[derive(Clone, Debug, PartialEq)]
pub enum TopBarAction {
    Run(&'static str),
    File(FileRequest),
}

/// Draws the bar, and writes what is requested there.
pub(crate) fn top_bar(
    mut ui: InMut<Ui>,
    available: Availability,
    commands: Res<CommandRegistry>,
    workspaces: Res<Workspaces>,
    recent: Option<Res<RecentDesigns>>,
    mut run: Requests<RunCommand>,
    mut files: Requests<FileRequest>,
) {
    let situation = available.situation();
    let Some(document) = situation.document() else { return };
    let builtins: Vec<&str> = trackwright_project::builtin_names().collect();
    let view = TopBarView {
        file: &file_name(document.origin()),
        is_dirty: document.is_dirty(),
        builtins: &builtins,
        recent: recent.as_ref().map_or(&[], |recent| &recent.designs),
        workspaces: &workspaces.0,
        commands: commands.all(),
        situation,
    };
    for action in top_bar_ui(&mut ui, &view) {
        match action {
            TopBarAction::Run(command) => run.write(RunCommand(command)),
            TopBarAction::File(request) => files.write(request),
        }
    }
}

/// Draws the bar.
pub fn top_bar_ui(ui: &mut Ui, bar: &TopBarView) -> Vec<TopBarAction> {
    let mut actions = Vec::new();
    ui.horizontal_centered(|ui| {
        ui.add_space(4.0);
        ui.label(RichText::new("trackwright").strong().color(palette::TEXT_STRONG.color32()));
        ui.add_space(6.0);
        egui::MenuBar::new().ui(ui, |ui| {
            for group in [FILE, EDIT, VIEW, HELP] {
                ui.menu_button(group.name, |ui| menu_ui(ui, bar, group, &mut actions));
            }
            ui.add_space(14.0);
            ui.label(RichText::new(bar.file).color(palette::TEXT.color32()));
            if bar.is_dirty {
                quiet_ui(ui, "not saved");
            }
        });
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.add_space(8.0);
            for workspace in bar.workspaces.iter().rev() {
                tab_ui(ui, workspace, bar.situation.workspace, &mut actions);
            }
        });
    });
    actions
}

fn tab_ui(ui: &mut Ui, tab: &Workspace, shown: Workspace, actions: &mut Vec<TopBarAction>) {
    let command = tab.command();
    let about = format!("{} ({})", command.about, command.shown_keys());
    let tab_button = Button::selectable(*tab == shown, tab.name).min_size(vec2(TAB_WIDTH, 24.0));
    if ui.add(tab_button).on_hover_text(about).clicked() && *tab != shown {
        actions.push(TopBarAction::Run(command.name));
    }
}

/// An entry of a menu with the key and the purpose of its command.
pub fn item_ui(ui: &mut Ui, text: &str, command: &Command, is_enabled: bool) -> Response {
    ui.set_min_width(MENU_WIDTH);
    let button = Button::new(text).shortcut_text(command.shown_keys());
    let response = ui.add_enabled(is_enabled, button).on_hover_text(command.about);
    if response.clicked() {
        ui.close();
    }
    response
}

/// The last part of the File menu stands below the designs that it lists.
const LAST_PART: u16 = 9;

fn menu_ui(ui: &mut Ui, bar: &TopBarView, group: Group, actions: &mut Vec<TopBarAction>) {
    let own = |command: &&Command| command.group == group && command.is_in_menu();
    let mut before = None;
    for command in bar.commands.iter().filter(own) {
        let part = command.order / 10;
        if part == LAST_PART && group == FILE {
            designs_ui(ui, bar, actions);
        }
        if before.is_some_and(|before| before != part) {
            ui.separator();
        }
        before = Some(part);
        let name = command.label(&bar.situation);
        if item_ui(ui, &name, command, bar.situation.allows(command)).clicked() {
            actions.push(TopBarAction::Run(command.name));
        }
    }
}

/// Designs that were open, and those that are built in.
fn designs_ui(ui: &mut Ui, bar: &TopBarView, actions: &mut Vec<TopBarAction>) {
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
                actions.push(TopBarAction::File(FileRequest::Open(design.file.clone())));
            }
        }
    }
    ui.separator();
    quiet_ui(ui, "Built-in designs");
    for name in bar.builtins {
        if ui.button(*name).clicked() {
            ui.close();
            let open = FileRequest::OpenBuiltIn((*name).to_owned());
            actions.push(TopBarAction::File(open));
        }
    }
}
