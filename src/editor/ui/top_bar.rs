//! The bar at the top: menus, the program's and the file's name.

use super::PanelAction;
use super::widgets::quiet_ui;
use crate::design::view::{Magnification, View};
use crate::editor::palette;
use crate::editor::precision::PrecisionRequest;
use crate::editor::state::{Axis, EditRequest, FileRequest, ViewRequest};
use bevy_egui::egui::{self, Button, RichText, Ui};

/// What the bar shows.
pub struct TopBarView<'a> {
    /// The file's name, or the built-in design's.
    pub file: &'a str,
    pub is_dirty: bool,
    pub undo_label: Option<&'a str>,
    pub redo_label: Option<&'a str>,
    pub builtins: &'a [&'a str],
    pub view: &'a View,
    pub is_left_shown: bool,
    pub is_right_shown: bool,
}

/// Draws the bar.
pub fn top_bar_ui(ui: &mut Ui, bar: &TopBarView) -> Vec<PanelAction> {
    let mut actions = Vec::new();
    ui.horizontal_centered(|ui| {
        ui.add_space(4.0);
        ui.label(
            RichText::new("trackwright")
                .strong()
                .color(palette::TEXT_STRONG.color32()),
        );
        ui.add_space(6.0);
        egui::MenuBar::new().ui(ui, |ui| {
            ui.menu_button("File", |ui| file_menu(ui, bar, &mut actions));
            ui.menu_button("Edit", |ui| edit_menu(ui, bar, &mut actions));
            ui.menu_button("View", |ui| view_menu(ui, bar, &mut actions));
            ui.add_space(14.0);
            ui.label(RichText::new(bar.file).color(palette::TEXT.color32()));
            if bar.is_dirty {
                quiet_ui(ui, "not saved");
            }
        });
    });
    actions
}

fn item(ui: &mut Ui, text: &str, shortcut: &str, enabled: bool) -> bool {
    ui.set_min_width(220.0);
    let clicked = ui
        .add_enabled(enabled, Button::new(text).shortcut_text(shortcut))
        .clicked();
    if clicked {
        ui.close();
    }
    clicked
}

fn file_menu(ui: &mut Ui, bar: &TopBarView, actions: &mut Vec<PanelAction>) {
    if item(ui, "Open…", "Ctrl+O", true) {
        actions.push(PanelAction::File(FileRequest::ShowOpen));
    }
    if item(ui, "Save", "Ctrl+S", true) {
        actions.push(PanelAction::File(FileRequest::Save));
    }
    if item(ui, "Save as…", "Ctrl+Shift+S", true) {
        actions.push(PanelAction::File(FileRequest::ShowSaveAs));
    }
    ui.separator();
    quiet_ui(ui, "Built-in designs");
    for name in bar.builtins {
        if item(ui, name, "", true) {
            actions.push(PanelAction::File(FileRequest::OpenBuiltIn(
                (*name).to_owned(),
            )));
        }
    }
    ui.separator();
    if item(ui, "Quit", "", true) {
        actions.push(PanelAction::File(FileRequest::Quit));
    }
}

fn edit_menu(ui: &mut Ui, bar: &TopBarView, actions: &mut Vec<PanelAction>) {
    let labelled = |verb: &str, label: Option<&str>| match label {
        Some(label) => format!("{verb} {}", lower_first(label)),
        None => verb.to_owned(),
    };
    let undo = labelled("Undo", bar.undo_label);
    if item(ui, &undo, "Ctrl+Z", bar.undo_label.is_some()) {
        actions.push(PanelAction::Edit(EditRequest::Undo));
    }
    let redo = labelled("Redo", bar.redo_label);
    if item(ui, &redo, "Ctrl+Shift+Z", bar.redo_label.is_some()) {
        actions.push(PanelAction::Edit(EditRequest::Redo));
    }
}

fn view_menu(ui: &mut Ui, bar: &TopBarView, actions: &mut Vec<PanelAction>) {
    if item(ui, "Frame selection", "F", true) {
        actions.push(PanelAction::View(ViewRequest::FrameSelection));
    }
    for (text, key, axis) in [
        ("Look along x", "1", Axis::X),
        ("Look along y", "3", Axis::Y),
        ("Look along z", "7", Axis::Z),
    ] {
        if item(ui, text, key, true) {
            actions.push(PanelAction::View(ViewRequest::LookAlong(axis)));
        }
    }
    ui.separator();
    let is_true_size = bar.view.magnification == Magnification::Times(1.0);
    let text = if is_true_size {
        "Magnify errors"
    } else {
        "Errors at true size"
    };
    if item(ui, text, "M", true) {
        actions.push(PanelAction::View(ViewRequest::Set(toggled_magnification(
            bar.view,
        ))));
    }
    if item(ui, "Error against run time…", "", true) {
        actions.push(PanelAction::Precision(PrecisionRequest::Open));
    }
    ui.separator();
    let fold = |shown: bool, name: &str| format!("{} {name}", if shown { "Hide" } else { "Show" });
    if item(ui, &fold(bar.is_left_shown, "outliner"), "", true) {
        actions.push(PanelAction::ToggleLeft);
    }
    if item(ui, &fold(bar.is_right_shown, "inspector"), "", true) {
        actions.push(PanelAction::ToggleRight);
    }
}

/// The view with errors at true size, or magnified again where they were at true size.
pub fn toggled_magnification(view: &View) -> View {
    let magnification = match view.magnification {
        Magnification::Times(1.0) => Magnification::Auto,
        _ => Magnification::Times(1.0),
    };
    View {
        magnification,
        ..view.clone()
    }
}

fn lower_first(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or_else(String::new, |first| {
        first.to_lowercase().chain(chars).collect()
    })
}
