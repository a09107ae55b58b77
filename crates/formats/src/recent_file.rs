//! The list of designs that were opened last, `recent.ron`.

use super::error::FormatError;
use super::recovery_file::{PathEntry, path_text};
use super::ron_text::{self, RonWriter, Version};
use serde::Deserialize;
use std::path::PathBuf;

#[derive(Deserialize)]
#[serde(rename = "Recent", deny_unknown_fields)]
struct RecentEntry {
    #[serde(rename = "version")]
    _version: Version,
    designs: Vec<PathEntry>,
}

/// The files, the last opened first.
pub fn parse(bytes: &[u8]) -> Result<Vec<PathBuf>, FormatError> {
    let entry: RecentEntry = ron_text::parse(bytes)?;
    Ok(entry.designs.into_iter().map(PathEntry::into_path).collect())
}

/// Writes the list, one file a line.
pub fn write(designs: &[PathBuf]) -> String {
    RonWriter::file(|out| out.lines("designs", designs.iter().map(|design| path_text(design))))
}
