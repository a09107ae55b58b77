//! The document that a person edits: a design with its bodies inlined, its view, edits, history.

mod content;
mod document;
mod edit;
mod history;
#[cfg(test)]
mod tests;
pub mod view;

pub use content::{BodyRole, CrfPlacement, Design, DesignBody, Target, ToolPlacement};
pub use document::{Document, Origin};
pub use edit::{Edit, EditError};
pub use view::View;
