//! The document that a person edits: a design with its bodies inlined, its view, edits, history.
//!
//! ```
//! use trackwright_design::{Design, DesignBody, Document, Edit, Origin, View};
//!
//! let body = DesignBody::of_file("probe.body.ron".to_owned());
//! let design = Design::of_tool("probe", "room.env.ron", body);
//! let mut document = Document::new(design, View::default(), Origin::BuiltIn("probe"));
//! document.apply(Edit::SetName("pointer".to_owned()))?;
//! assert_eq!(document.design().name, "pointer");
//! assert_eq!(document.undo().as_deref(), Some("Rename design"));
//! assert_eq!(document.design().name, "probe");
//! assert!(!document.is_dirty());
//! # Ok::<(), trackwright_design::EditError>(())
//! ```

mod anatomy;
mod arrange;
mod check;
mod content;
mod day;
pub mod definition;
mod document;
mod edit;
mod edit_error;
mod handles;
mod history;
mod layers;
mod list_edits;
mod metal_edits;
mod missing_layers;
mod new_sensor;
mod procedure;
mod slides;
#[cfg(test)]
mod tests;
mod things;
pub mod view;

pub use anatomy::{Anatomy, AnatomyFrame};
pub use arrange::{ArrangeError, Arrangement, MAX_ARRAY, MirrorPlane, fresh_name, mirrored};
pub use content::{CrfPlacement, Design, DesignBody, Target, ToolPlacement};
pub use day::{Day, NoDay};
pub use document::{Document, Origin};
pub use edit::Edit;
pub use edit_error::{EditError, MAX_ANATOMY, MAX_FURTHER_ROOMS, MAX_SENSORS, MAX_SLIDES};
pub use handles::HandleAxes;
pub use history::{HistoryList, HistoryState};
pub use list_edits::{AnatomyEdit, ProcedureEdit, SlideEdit};
pub use metal_edits::MetalEdit;
pub use missing_layers::MissingLayer;
pub use new_sensor::{sensor_beside_last, sensor_on_surface};
pub use procedure::{Decision, DecisionError, Procedure};
pub use slides::{Slide, SlideFigure};
pub use things::{BodyRole, Thing, Things};
pub use view::View;
