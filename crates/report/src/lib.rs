//! Pages and plots, as text: what a command or the editor hands to a person to keep.

pub mod agreement_chart;
pub mod drawing;
pub mod error_charts;
pub mod learning_chart;
pub mod manufacturing;
pub mod page;
pub mod palette;
pub mod plot;
pub mod room;
pub mod selection;
pub mod selection_chart;
pub mod text_table;
pub mod words;
