//! The list of designs that were opened last, `recent.ron`.

use super::error::FormatError;
use super::recovery_file::{PathEntry, path_text};
use super::ron_text;
use serde::Deserialize;
use std::fmt::Write;
use std::path::PathBuf;

#[derive(Deserialize)]
#[serde(rename = "Recent", deny_unknown_fields)]
struct RecentEntry {
    version: u64,
    designs: Vec<PathEntry>,
}

impl ron_text::Versioned for RecentEntry {
    fn version(&self) -> u64 {
        self.version
    }
}

/// The files, the last opened first.
///
/// # Errors
/// See [`FormatError`].
pub fn parse(bytes: &[u8]) -> Result<Vec<PathBuf>, FormatError> {
    let entry: RecentEntry = ron_text::parse(bytes)?;
    Ok(entry.designs.into_iter().map(PathEntry::into_path).collect())
}

/// Writes the list, one file a line.
pub fn write(designs: &[PathBuf]) -> String {
    let mut out = String::from("(\n    version: 1,\n    designs: [\n");
    for design in designs {
        // Writing to a string cannot fail.
        let _ = writeln!(out, "        {},", path_text(design));
    }
    out.push_str("    ],\n)\n");
    out
}
