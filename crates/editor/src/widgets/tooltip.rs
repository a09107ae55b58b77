//! What a widget is for, in a sentence: shown when the pointer rests on it, and read to people who
//! cannot see the window.

use crate::widgets::basic::main_button;
use bevy_egui::egui::{Response, Ui};

/// Explains a widget, be it enabled or not.
pub trait Explain {
    /// Shows the sentence while the pointer is over the widget, and describes it by it.
    fn explained(self, about: impl Into<String>) -> Self;
}

impl Explain for Response {
    fn explained(self, about: impl Into<String>) -> Self {
        let about: String = about.into();
        self.ctx.accesskit_node_builder(self.id, |node| node.set_description(about.clone()));
        self.on_hover_text(&about).on_disabled_hover_text(about)
    }
}

/// A sentence with the key that does the same: `Looks along x (1)`.
pub fn with_keys(about: &str, keys: &str) -> String {
    match keys {
        "" => about.to_owned(),
        keys => format!("{about} ({keys})"),
    }
}

/// Names a widget for people who cannot see what stands beside it.
pub fn labelled(ui: &Ui, response: &Response, name: &str) {
    ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(name.to_owned()));
}

/// A button, with what it does in a sentence.
pub fn button_ui(ui: &mut Ui, text: &str, about: impl Into<String>) -> Response {
    ui.button(text).explained(about)
}

/// A button for the one thing that a section is about, with what it does in a sentence.
pub fn main_button_ui(ui: &mut Ui, text: &str, about: impl Into<String>) -> Response {
    ui.add(main_button(text)).explained(about)
}

/// A switch with its name, and with what it means in a sentence.
pub fn checkbox_ui(
    ui: &mut Ui,
    is_on: &mut bool,
    name: &str,
    about: impl Into<String>,
) -> Response {
    ui.checkbox(is_on, name).explained(about)
}
