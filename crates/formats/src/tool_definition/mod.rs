//! Tool definitions: the files by which trackers' makers state where a tool's markers or coils are.
//!
//! Each is kept as it was read, to the byte: what this program does not know of one is not lost,
//! and what it changes is written over the original. [`to_body`](ToolDefinition::to_body) and
//! [`from_body()`] lead to bodies and back.

mod atracsys_ini;
pub(super) mod definition;
mod facts;
mod from_body;
mod geometry;
mod kind;
mod matching;
mod ndi_em;
mod ndi_image;
mod ndi_optical;
pub(super) mod ndi_rom;
mod saw_json;
#[cfg(test)]
mod tests;
mod tool_plist;

pub use atracsys_ini::AtracsysIni;
pub use definition::{MAX_BYTES, ToolDefinition, read_body};
pub use facts::{Fact, Lost};
pub use from_body::{BodyFormat, Conversion, ConversionError, DefinitionFormat, from_body};
pub use geometry::Geometry;
pub use kind::{kind_of, kind_of_extension};
pub use ndi_em::{EmCoil, EmRom};
pub use ndi_image::{Checksum, OnMismatch};
pub use ndi_optical::{OpticalMarker, OpticalRom};
pub use ndi_rom::{NdiRom, SerialWord};
pub use saw_json::SawJson;
pub use tool_plist::ToolPlist;
