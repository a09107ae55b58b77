//! The bar at the top: menus, the file's name, the workspaces' tabs.

use crate::document::file_names::origin_name;
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
use crate::widgets::tooltip::{Explain, button_ui};
use bevy::prelude::*;
use bevy_egui::egui::{self, Align, Button, Layout, Response, RichText, Ui, UiBuilder, vec2};
use trackwright_project::{RecentDesign, file_name};

const TAB_WIDTH: f32 = 62.0;
const LEAST_TAB_WIDTH: f32 = 40.0;
const TAB_HEIGHT: f32 = 24.0;

/// The menus, and what there has to be left of the tabs for the program's name beside them.
const MENUS_WIDTH: f32 = 200.0;
const NAMED_WIDTH: f32 = 300.0;

/// Right of the tabs.
const EDGE: f32 = 8.0;

/// Room for "not saved", whether it stands there or not.
const MARK_WIDTH: f32 = 64.0;

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
        file: &origin_name(document.origin()),
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
    // Tabs, menus and the file's name have places of their own: no text moves another.
    let whole = ui.available_rect_before_wrap();
    let (count, gap) = (bar.workspaces.len().max(1) as f32, ui.spacing().item_spacing.x);
    // In a narrow or enlarged window tabs are as narrow as leaves the menus their place.
    let room = (whole.width() - MENUS_WIDTH - EDGE) / count - gap;
    let tab_width = room.clamp(LEAST_TAB_WIDTH, TAB_WIDTH);
    let tabs_width = count * (tab_width + gap) + EDGE;
    let (left, tabs) = whole.split_left_right_at_x((whole.right() - tabs_width).max(whole.left()));
    let left_to_right = Layout::left_to_right(Align::Center);
    ui.scope_builder(UiBuilder::new().max_rect(left).layout(left_to_right), |ui| {
        ui.add_space(4.0);
        if left.width() > NAMED_WIDTH {
            ui.label(RichText::new("trackwright").strong().color(palette::TEXT_STRONG.color32()));
            ui.add_space(6.0);
        }
        egui::MenuBar::new().ui(ui, |ui| {
            for group in [FILE, EDIT, VIEW, HELP] {
                let menu = ui.menu_button(group.name, |ui| menu_ui(ui, bar, group, &mut actions));
                menu.response.explained(group.about());
            }
            ui.add_space(14.0);
            file_ui(ui, bar);
        });
    });
    let right_to_left = Layout::right_to_left(Align::Center);
    ui.scope_builder(UiBuilder::new().max_rect(tabs).layout(right_to_left), |ui| {
        ui.add_space(EDGE);
        for workspace in bar.workspaces.iter().rev() {
            tab_ui(ui, workspace, (bar.situation.workspace, tab_width), &mut actions);
        }
    });
    actions
}

/// The file's name, as much of it as there is room for, and whether it is saved at the right end.
fn file_ui(ui: &mut Ui, bar: &TopBarView) {
    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
        let mark = vec2(MARK_WIDTH, ui.available_height());
        ui.allocate_ui_with_layout(mark, Layout::left_to_right(Align::Center), |ui| {
            ui.set_min_width(MARK_WIDTH);
            if bar.is_dirty {
                quiet_ui(ui, "not saved");
            }
        });
        ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
            let name = RichText::new(bar.file).color(palette::TEXT.color32());
            ui.add(egui::Label::new(name).truncate());
        });
    });
}

fn tab_ui(
    ui: &mut Ui,
    tab: &Workspace,
    (shown, width): (Workspace, f32),
    actions: &mut Vec<TopBarAction>,
) {
    let command = tab.command();
    let about = command.tooltip();
    let tab_button = Button::selectable(*tab == shown, tab.name).truncate();
    let size = vec2(width, TAB_HEIGHT);
    if ui.add_sized(size, tab_button).explained(about).clicked() && *tab != shown {
        actions.push(TopBarAction::Run(command.name));
    }
}

/// An entry of a menu with the key and the purpose of its command.
pub fn item_ui(ui: &mut Ui, text: &str, command: &Command, is_enabled: bool) -> Response {
    ui.set_min_width(MENU_WIDTH);
    let button = Button::new(text).shortcut_text(command.shown_keys());
    let response = ui.add_enabled(is_enabled, button).explained(command.tooltip());
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
            let name = file_name(&design.file);
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
        if button_ui(ui, name, "Opens a design that comes with the program").clicked() {
            ui.close();
            let open = FileRequest::OpenBuiltIn((*name).to_owned());
            actions.push(TopBarAction::File(open));
        }
    }
}
