//! Pages, charts and drawings as text: what a command or the editor gives a person to keep.
//!
//! A chart is plain data until it is written, and so is everything else here:
//!
//! ```
//! use trackwright_report::plot::{Axis, Chart, Series, SeriesStyle};
//! let points = vec![(0.0, 0.4), (1.0, 0.7)];
//! let chart = Chart {
//!     title: "Tip error".to_owned(),
//!     x: Axis::linear("pose"),
//!     y: Axis::linear("mm"),
//!     series: vec![Series::new("measured", SeriesStyle::Line, points)],
//! };
//! assert!(chart.to_svg((600, 400)).starts_with("<svg"));
//! ```

pub mod agreement_chart;
pub mod comparison;
pub mod control_charts;
pub mod drawing;
pub mod error_charts;
pub mod found_metal;
pub mod kinds;
pub mod learning_chart;
pub mod manufacturing;
pub mod metal_chart;
pub mod metal_distance;
pub mod missed;
pub mod optimization_section;
pub mod page;
pub mod palette;
pub mod plot;
pub mod procedure;
pub mod room;
pub mod room_section;
pub mod section_html;
pub mod section_text;
pub mod selection;
pub mod selection_chart;
pub mod selection_section;
pub mod study;
pub mod sweep;
pub mod text_table;
pub mod words;
