//! What a widget is for, in a sentence: shown when the pointer rests on it, and read to people who
//! cannot see the window.

use bevy_egui::egui::Response;

/// Explains a widget, be it enabled or not.
pub trait Explain {
    /// Shows the sentence while the pointer is over the widget, and describes it by it.
    #[must_use]
    fn explained(self, about: &str) -> Self;
}

impl Explain for Response {
    fn explained(self, about: &str) -> Self {
        self.ctx.accesskit_node_builder(self.id, |node| node.set_description(about.to_owned()));
        self.on_hover_text(about).on_disabled_hover_text(about)
    }
}

/// A sentence with the key that does the same: `Looks along x (1)`.
pub fn with_keys(about: &str, keys: &str) -> String {
    match keys {
        "" => about.to_owned(),
        keys => format!("{about} ({keys})"),
    }
}
