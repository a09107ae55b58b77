//! The panels of the Live workspace: pure functions from its desk to what the person asked for.

mod collecting;
mod panels;
mod tools;
mod tracker;

pub use collecting::collecting_ui;
pub use panels::LivePanels;
pub use tools::tools_ui;
pub use tracker::{recording_ui, tracker_ui};

use crate::palette;
use crate::palette::ThemedColor;
use bevy_egui::egui::{self, RichText, Ui};

/// A line that says how something is, its colour saying how well.
fn state_ui(ui: &mut Ui, text: &str, color: palette::Rgb) {
    ui.add(egui::Label::new(RichText::new(text).color(color.color32())).wrap());
}
