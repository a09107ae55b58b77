//! The panels of the Live workspace: pure functions from its desk to what the person asked for.

pub mod collecting;
pub mod panels;
pub mod tools;
pub mod tracker;

use crate::palette;
use crate::palette::ThemedColor;
use bevy_egui::egui::{self, RichText, Ui};

/// A line that says how something is, its colour saying how well.
fn state_ui(ui: &mut Ui, text: &str, color: palette::Rgb) {
    ui.add(egui::Label::new(RichText::new(text).color(color.color32())).wrap());
}
