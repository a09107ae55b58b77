//! What a computation found, as data: the library that computes it names each figure once, for programs
//! and for people, and every medium shows it in its own way.
//!
//! ```
//! use trackwright_result::{Section, count, mm};
//! let found = Section::of([
//!     count("poses", "poses", 1200),
//!     mm("rms_mm", "distance of the tip from it, RMS", 0.123_456),
//! ]);
//! assert_eq!(found.to_json()["rms_mm"], 0.123_456);
//! ```

mod json;
mod remedy;
mod row;
mod section;
mod table;

pub use remedy::{Note, Refusal, Remedy};
pub use row::{Row, count, data, deg, mm, number, text, value_text, vector, with_separators};
pub use section::{Item, Section};
pub use table::{Column, Columns, Table};
