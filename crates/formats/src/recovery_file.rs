//! Recovery files: a whole open document in one file, as a session leaves it in case it ends badly.
//!
//! Design and bodies are kept as the texts of their own files, so that they are read with the same
//! care and can be taken out by hand if all else fails.

use super::body::{self, BodyFile};
use super::design_file::{self, DesignFile};
use super::error::{FormatError, in_part};
use super::ron_text::{self, RonWriter, Version};
use super::room_metal::{self, RoomMetalEntry};
use serde::{Deserialize, Deserializer};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use trackwright_design::{Design, DesignBody, View};

/// What a recovery file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct RecoveryFile {
    /// Milliseconds since 1970.
    pub written_unix_ms: u64,
    /// Of the session that wrote it.
    pub process: u32,
    /// Whether anything was unsaved.
    pub is_dirty: bool,
    pub origin: RecoveryOrigin,
    /// The meshes of its metal have no surface yet.
    pub design: Design,
    pub view: View,
    /// What the session knew of the files it had read or written.
    pub stamps: Vec<(PathBuf, FileStamp)>,
}

/// Where a document came from.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub enum RecoveryOrigin {
    BuiltIn(String),
    /// Absolute.
    File(#[serde(deserialize_with = "path")] PathBuf),
}

/// What a file was when it was read or written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FileStamp {
    /// Bytes.
    pub length: u64,
    /// The file's own time, nanoseconds since 1970; 0 where it has none.
    pub modified_ns: u64,
    /// When this was found.
    pub taken_ns: u64,
    /// FNV-1a of the bytes.
    pub hash: u64,
}

#[derive(Deserialize)]
#[serde(rename = "Recovery", deny_unknown_fields)]
struct RecoveryEntry {
    #[serde(rename = "version")]
    _version: Version,
    written_unix_ms: u64,
    process: u32,
    is_dirty: bool,
    origin: RecoveryOrigin,
    design: String,
    tool_body: String,
    crf_body: Option<String>,
    metal: Option<RoomMetalEntry>,
    stamps: Vec<StampEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct StampEntry {
    #[serde(deserialize_with = "path")]
    file: PathBuf,
    stamp: FileStamp,
}

/// A path; as bytes where it is no text.
#[derive(Deserialize)]
pub(super) enum PathEntry {
    Text(String),
    Bytes(Vec<u8>),
}

impl RecoveryFile {
    pub fn written(&self) -> SystemTime {
        UNIX_EPOCH.checked_add(Duration::from_millis(self.written_unix_ms)).unwrap_or(UNIX_EPOCH)
    }
}

/// Reads a recovery file.
///
/// # Errors
/// See [`FormatError`]; [`FormatError::Part`] for one of the files within it.
pub fn parse(bytes: &[u8]) -> Result<RecoveryFile, FormatError> {
    let entry: RecoveryEntry = ron_text::parse(bytes)?;
    let (mut design, view) =
        read_texts(&entry.design, &entry.tool_body, entry.crf_body.as_deref())?;
    design.room_metal = entry.metal.map(RoomMetalEntry::check).transpose()?.map(Arc::new);
    Ok(RecoveryFile {
        written_unix_ms: entry.written_unix_ms,
        process: entry.process,
        is_dirty: entry.is_dirty,
        origin: entry.origin,
        design,
        view,
        stamps: entry.stamps.into_iter().map(|entry| (entry.file, entry.stamp)).collect(),
    })
}

/// Writes a recovery file.
pub fn write(file: &RecoveryFile) -> String {
    let origin = match &file.origin {
        RecoveryOrigin::BuiltIn(name) => format!("BuiltIn({})", ron_text::string(name)),
        RecoveryOrigin::File(path) => format!("File({})", path_text(path)),
    };
    RonWriter::file(|out| {
        out.field("written_unix_ms", file.written_unix_ms);
        out.field("process", file.process);
        out.field("is_dirty", file.is_dirty);
        out.field("origin", origin);
        write_texts(out, &file.design, &file.view);
        if let Some(metal) = &file.design.room_metal {
            out.fields("metal", |out| room_metal::write(out, metal));
        }
        let line = |(path, stamp): &(PathBuf, FileStamp)| {
            let FileStamp { length, modified_ns, taken_ns, hash } = stamp;
            format!(
                "(file: {}, stamp: (length: {length}, modified_ns: {modified_ns}, \
                 taken_ns: {taken_ns}, hash: {hash}))",
                path_text(path)
            )
        };
        out.lines("stamps", file.stamps.iter().map(line));
    })
}

/// A design and its view from the texts of its own file and of its bodies'.
pub(super) fn read_texts(
    design: &str,
    tool_body: &str,
    crf_body: Option<&str>,
) -> Result<(Design, View), FormatError> {
    let design = design_file::parse(design.as_bytes()).map_err(in_part("design"))?;
    let mut bodies = [("tool_body", Some(tool_body)), ("crf_body", crf_body)].into_iter();
    design.into_design(|_| -> Result<BodyFile, FormatError> {
        // The tool's first, as `into_design` requests them.
        match bodies.next() {
            Some((name, Some(text))) => body::parse(text.as_bytes()).map_err(in_part(name)),
            _ => Err(FormatError::field("crf_body", "missing", "the CRF's")),
        }
    })
}

/// Writes a design as fields that [`read_texts`] takes.
pub(super) fn write_texts(out: &mut RonWriter, design: &Design, view: &View) {
    let body = |body: &DesignBody| body::write(&BodyFile::of(body));
    out.string("design", &design_file::write(&DesignFile::of(design, view)));
    out.string("tool_body", &body(&design.tool.body));
    out.optional_string("crf_body", design.crf.as_ref().map(|crf| body(&crf.body)).as_deref());
}

impl PathEntry {
    pub(super) fn into_path(self) -> PathBuf {
        match self {
            Self::Text(text) => text.into(),
            Self::Bytes(bytes) => path_of_bytes(bytes),
        }
    }
}

fn path<'de, D: Deserializer<'de>>(deserializer: D) -> Result<PathBuf, D::Error> {
    PathEntry::deserialize(deserializer).map(PathEntry::into_path)
}

/// A path as a [`PathEntry`]. Elsewhere than on Unix what is no text loses what is none of it.
pub(super) fn path_text(path: &Path) -> String {
    if path.to_str().is_none()
        && let Some(bytes) = bytes_of_path(path)
    {
        return format!("Bytes({bytes:?})");
    }
    format!("Text({})", ron_text::string(&path.to_string_lossy()))
}

#[cfg(unix)]
fn bytes_of_path(path: &Path) -> Option<&[u8]> {
    Some(std::os::unix::ffi::OsStrExt::as_bytes(path.as_os_str()))
}

#[cfg(not(unix))]
fn bytes_of_path(_: &Path) -> Option<&[u8]> {
    None
}

#[cfg(unix)]
fn path_of_bytes(bytes: Vec<u8>) -> PathBuf {
    let text: std::ffi::OsString = std::os::unix::ffi::OsStringExt::from_vec(bytes);
    text.into()
}

#[cfg(not(unix))]
fn path_of_bytes(bytes: Vec<u8>) -> PathBuf {
    String::from_utf8_lossy(&bytes).into_owned().into()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::test_cases::assert_refused;
    use proptest::prelude::*;

    fn file_of(design: &str) -> RecoveryFile {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../designs");
        let read = |name: &str| std::fs::read(folder.join(name)).unwrap();
        let entry = design_file::parse(&read(&format!("{design}.design.ron"))).unwrap();
        let (mut own, view) = entry.into_design(|file| body::parse(&read(file))).unwrap();
        // One of them in a room with metal.
        let metal = || Arc::new(room_metal::tests::metal());
        own.room_metal = (design == "pointer-on-head").then(metal);
        RecoveryFile {
            written_unix_ms: 1_700_000_000_123,
            process: 4321,
            is_dirty: true,
            origin: RecoveryOrigin::BuiltIn("\"\\\n".to_owned()),
            design: own,
            view,
            stamps: vec![(
                "/a b/c".into(),
                FileStamp { length: u64::MAX, modified_ns: 1, taken_ns: 2, hash: 3 },
            )],
        }
    }

    /// For the tests of all parsers.
    pub(crate) fn good() -> Vec<u8> {
        write(&file_of("pointer-on-head")).into_bytes()
    }

    #[test]
    fn what_is_written_reads_back_whole() {
        for design in ["pointer-on-head", "endoscope"] {
            let mut file = file_of(design);
            assert_eq!(parse(write(&file).as_bytes()).as_ref(), Ok(&file));
            file.origin = RecoveryOrigin::File("/ä\u{202e}/\u{1}\"".into());
            assert_eq!(parse(write(&file).as_bytes()).as_ref(), Ok(&file));
            #[cfg(unix)]
            {
                file.origin = RecoveryOrigin::File(path_of_bytes(vec![b'/', 0xff, b'"']));
                assert_eq!(parse(write(&file).as_bytes()).as_ref(), Ok(&file));
            }
        }
    }

    #[test]
    fn errors_name_the_part_of_a_recovery_file() {
        let good = String::from_utf8(good()).unwrap();
        let cases = r#"
            crf_body: => crf: | line 9, column 5: found the unknown field `crf`, expected …
            design: "(\\n    version: 1 => design: "(\\n    version: 3
                | design: version is 3, expected 1…
            tool_body: "( => tool_body: " | tool_body: line …
        "#;
        assert_refused(&good, cases, |text| parse(text.as_bytes()).unwrap_err().to_string());
    }

    proptest! {
        #[test]
        fn a_file_cut_short_is_an_error(cut in any::<prop::sample::Index>()) {
            let bytes = good();
            // Behind the last parenthesis there is a line end, which nobody would miss.
            prop_assert!(parse(&bytes[..cut.index(bytes.len() - 1)]).is_err());
        }
    }
}
