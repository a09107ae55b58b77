//! Baseline files: the design that another one is held against, whole in one file beside it.
//!
//! Design and bodies are kept as the texts of their own files, as a recovery file has them, so that a
//! baseline stays what it was whatever becomes of the files that it came from.

use super::error::FormatError;
use super::recovery_file::{PathEntry, path_text, read_texts, write_texts};
use super::ron_text::{self, RonWriter, Version};
use serde::Deserialize;
use std::path::PathBuf;
use trackwright_design::{Design, View};

/// What a baseline file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct BaselineFile {
    /// Where it was read from, absolute; `None` for an earlier state of the design itself.
    pub source: Option<PathBuf>,
    /// Without the metal of its room: it is judged in the rooms of the design that is open.
    pub design: Design,
}

#[derive(Deserialize)]
#[serde(rename = "Baseline", deny_unknown_fields)]
struct BaselineEntry {
    #[serde(rename = "version")]
    _version: Version,
    #[serde(default)]
    source: Option<PathEntry>,
    design: String,
    tool_body: String,
    #[serde(default)]
    crf_body: Option<String>,
}

/// Reads a baseline file.
///
/// # Errors
/// See [`FormatError`]; [`FormatError::Part`] for one of the files within it.
pub fn parse(bytes: &[u8]) -> Result<BaselineFile, FormatError> {
    let entry: BaselineEntry = ron_text::parse(bytes)?;
    let (design, _) = read_texts(&entry.design, &entry.tool_body, entry.crf_body.as_deref())?;
    Ok(BaselineFile { source: entry.source.map(PathEntry::into_path), design })
}

/// Writes a baseline file.
pub fn write(file: &BaselineFile) -> String {
    RonWriter::file(|out| {
        if let Some(source) = &file.source {
            out.field("source", path_text(source));
        }
        write_texts(out, &file.design, &View::default());
    })
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::recovery_file;

    fn file(source: Option<PathBuf>) -> BaselineFile {
        let recovered = recovery_file::parse(&recovery_file::tests::good()).unwrap();
        BaselineFile { source, design: Design { room_metal: None, ..recovered.design } }
    }

    /// For the tests of all documents.
    pub(crate) fn good() -> String {
        write(&file(Some("/a.design.ron".into())))
    }

    #[test]
    fn a_baseline_reads_back_whole() {
        for source in [None, Some("/designs/needle \"2\".design.ron".into())] {
            let file = file(source);
            assert_eq!(parse(write(&file).as_bytes()), Ok(file));
        }
    }

    #[test]
    fn a_baseline_of_a_later_version_is_refused() {
        let text = write(&file(None)).replacen("version: 1", "version: 2", 1);
        let error = parse(text.as_bytes()).unwrap_err().to_string();
        assert!(error.starts_with("version is 2, expected 1"), "{error}");
    }
}
