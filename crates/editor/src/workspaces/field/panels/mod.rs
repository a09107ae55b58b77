//! The panels of the Field workspace: pure functions from its state to the person's requests.

pub mod fit_quality;
pub mod metal;
pub mod rooms;
pub mod selection;
pub mod settings;
pub mod systems;
pub mod table;

use crate::widgets::basic::{MET_SIGN, quiet_ui};
use crate::widgets::theme;
use bevy_egui::egui::{self, Color32, RichText, Ui, vec2};

/// Width of the names in front of fields.
const NAME_WIDTH: f32 = 92.0;

/// A row of a name and what belongs to it.
fn named_ui<R>(ui: &mut Ui, name: &str, add: impl FnOnce(&mut Ui) -> R) -> R {
    ui.horizontal(|ui| {
        let size = vec2(NAME_WIDTH, ui.spacing().interact_size.y);
        let layout = egui::Layout::left_to_right(egui::Align::Center);
        ui.allocate_ui_with_layout(size, layout, |ui| {
            ui.set_min_width(NAME_WIDTH);
            ui.label(name);
        });
        add(ui)
    })
    .inner
}

/// The head of a table's column, at the column's right end.
fn head_ui(ui: &mut Ui, text: &str) {
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
        quiet_ui(ui, text);
    });
}

/// A cell of a table of numbers, at the column's right end.
fn cell_ui(ui: &mut Ui, text: impl Into<String>, color: Color32) -> egui::Response {
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
        ui.label(RichText::new(text).color(color))
    })
    .inner
}

/// Something that is as it should be, with a sign before it.
fn good_ui(ui: &mut Ui, text: &str) {
    let color = theme::verdict_color(Some(true));
    ui.add(egui::Label::new(RichText::new(format!("{MET_SIGN} {text}")).color(color)).wrap());
}
