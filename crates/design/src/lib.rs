//! The document that a person edits: a design with its bodies inlined, its view, edits, history.

mod anatomy;
mod arrange;
mod check;
mod content;
mod day;
pub mod definition;
mod document;
mod edit;
mod edit_label;
mod history;
mod layer_names;
mod missing_layers;
mod new_sensor;
mod place;
mod procedure;
mod slides;
#[cfg(test)]
mod tests;
mod things;
pub mod view;

pub use anatomy::{Anatomy, AnatomyEdit, AnatomyFrame, MAX_ANATOMY};
pub use arrange::{ArrangeError, Arrangement, MAX_ARRAY, MirrorPlane, fresh_name, mirrored};
pub use content::{BodyRole, CrfPlacement, Design, DesignBody, Target, ToolPlacement};
pub use day::{Day, NoDay};
pub use document::{Document, Origin};
pub use edit::{Edit, EditError};
pub use history::{HistoryList, HistoryState};
pub use missing_layers::MissingLayer;
pub use new_sensor::{sensor_beside_last, sensor_on_surface};
pub use place::HandleAxes;
pub use procedure::{Decision, DecisionError, MAX_FURTHER_ROOMS, Procedure, ProcedureEdit};
pub use slides::{MAX_SLIDES, Slide, SlideEdit, SlideFigure};
pub use things::{Thing, Things};
pub use view::View;
