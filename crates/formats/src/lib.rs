//! Bytes to types and back: one parser and writer a file format, no disk.

pub mod agreement_log;
pub mod body;
pub mod characterised;
pub mod comparison_table;
mod computed_model;
pub mod design_file;
#[cfg(test)]
mod document_tests;
pub mod environment;
mod error;
pub mod export;
pub mod foreign;
pub mod generator;
pub mod gltf;
pub mod groups;
pub mod input;
pub mod jhu_cis;
pub mod log;
pub mod manufacturing_table;
pub mod markups;
pub mod matrices;
pub mod measurements;
pub mod mesh;
mod nearest;
pub mod pivot_recording;
pub mod points;
pub mod poses;
pub mod preferences_file;
pub mod printable;
mod process;
pub mod recent_file;
pub mod recorded_tool;
pub mod recording;
pub mod recovery_file;
mod ron_text;
mod ron_tokens;
pub mod signature;

pub mod table;
mod table_dialect;
#[cfg(test)]
mod test_cases;
#[cfg(test)]
mod tests;
pub mod tool_definition;
pub mod typed_number;
mod utf8;
mod validity;

pub use body::BodyFile;
pub use design_file::DesignFile;
pub use error::FormatError;
