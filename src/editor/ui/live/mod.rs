//! The panels of the Live workspace: pure functions from its desk to what the person asked for.

mod collecting;
mod panels;
mod tools;
mod tracker;

pub use collecting::collecting_ui;
pub use panels::LivePanels;
pub use tools::tools_ui;
pub use tracker::{recording_ui, tracker_ui};

use super::widgets::quiet_ui;
use crate::editor::palette;
use bevy_egui::egui::{self, RichText, Ui};

/// A name in quiet letters and its value at the right end.
fn fact_ui(ui: &mut Ui, name: &str, value: &str) {
    ui.horizontal(|ui| {
        quiet_ui(ui, name);
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            ui.add(egui::Label::new(value).truncate());
        });
    });
}

/// A line that says how something is, its colour saying how well.
fn state_ui(ui: &mut Ui, text: &str, color: palette::Rgb) {
    ui.add(egui::Label::new(RichText::new(text).color(color.color32())).wrap());
}

/// A button for the one thing that a section is about.
fn main_button(text: &str) -> egui::Button<'_> {
    egui::Button::new(RichText::new(text).color(palette::TEXT_STRONG.color32()))
        .fill(palette::ACCENT.color32_alpha(90))
        .min_size(egui::vec2(0.0, 24.0))
}
