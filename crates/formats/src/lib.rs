//! Bytes to types and back: one parser and writer a file format, no disk.
//!
//! ```
//! use trackwright_formats::poses;
//!
//! let table = b"x,y,z,qw,qx,qy,qz\n1.5,0,-300,1,0,0,0\n";
//! let found = poses::parse(table)?;
//! assert_eq!(found[0].translation.vector.z, -300.0);
//! let mut written = Vec::new();
//! poses::write(&mut written, &found).expect("memory takes it");
//! assert_eq!(written, table);
//! let error = poses::parse(b"x,y\n1,2\n").unwrap_err();
//! assert!(error.to_string().starts_with("line 1: found no column z"));
//! # Ok::<(), trackwright_formats::FormatError>(())
//! ```

pub mod agreement_log;
pub mod baseline_file;
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
mod mounting;
mod nearest;
pub mod number_path;
pub mod pivot_recording;
pub mod plate_recording;
pub mod points;
pub mod poses;
pub mod preferences_file;
pub mod printable;
mod process;
pub mod protocol_table;
pub mod recent_file;
pub mod recorded_tool;
pub mod recording;
pub mod recovery_file;
mod ron_text;
mod ron_tokens;
mod ron_tree;
mod room_metal;
pub mod signature;
pub mod sweep_plan;
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
pub use environment::EnvironmentFile;
pub use error::FormatError;
