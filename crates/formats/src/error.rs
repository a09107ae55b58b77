//! What can be wrong with a file's content: where, what was found, what was expected.

use super::mesh::error::MeshError;
use data_encoding::BASE64;
use std::io::ErrorKind;
use trackwright_design::DecisionError;
use trackwright_design::view::ViewError;
use trackwright_field::validity::FitValidityPartsError;
use trackwright_geometry::bounds::BoundsError;
use trackwright_geometry::limits::short;
use trackwright_metal::setup::SetupError;
use trackwright_procedure::Step;
use trackwright_simulation::motion::MotionError;
use trackwright_simulation::mounting::MountingError;

/// Why bytes are not the file they should be. The file's name is added by who read it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FormatError {
    #[error("line {line}, column {column}: found a byte that is not UTF-8, expected text")]
    NotUtf8 { line: usize, column: usize },
    /// The file could be opened but not read to its end.
    #[error("found what cannot be read ({found}), expected text")]
    Unreadable { kind: ErrorKind, found: String },
    #[error("line {line}, column {column}: {problem}")]
    Syntax {
        line: usize,
        column: usize,
        /// "found …, expected …".
        problem: String,
    },
    #[error("{field} is {found}, expected {expected}")]
    Field { field: String, found: String, expected: &'static str },
    #[error("line {line}: {field} is {found}, expected {expected}")]
    Cell { line: u64, field: String, found: String, expected: &'static str },
    #[error("line {line}: found {found}, expected {expected}")]
    Line { line: u64, found: String, expected: String },
    #[error("line 1: found no column {}, expected {expected}", missing.join(", "))]
    MissingColumns { missing: Vec<String>, expected: &'static str },
    #[error("line 1: found numbers, expected names of columns above them: {expected}")]
    NoHeader { expected: &'static str },
    #[error("line 1: column {column:?} is in {unit}, expected mm and unit quaternions")]
    Unit { column: String, unit: String },
    #[error("line 1: found column {0} twice, expected it once")]
    RepeatedColumn(String),
    #[error("found no rows, expected at least one")]
    NoRows,
    /// A file's version is not one that this program reads.
    #[error("version is {found}, expected {expected}{}", written_by(*found, *expected))]
    Version { found: u64, expected: u64 },
    #[error("volume: {0}")]
    Volume(BoundsError),
    /// A file of another kind.
    #[error("found {found}, expected {expected}{advice}")]
    Foreign {
        found: &'static str,
        expected: &'static str,
        /// What to do about it, behind a semicolon, or nothing.
        advice: &'static str,
    },
    /// In a file within the file.
    #[error("{part}: {cause}")]
    Part { part: &'static str, cause: Box<FormatError> },
    #[error("{prefix}{cause}")]
    Motion {
        /// "crf." for the motion of the CRF's own study, else nothing.
        prefix: &'static str,
        cause: MotionError,
    },
    #[error("support: {0}")]
    FitValidity(#[from] FitValidityPartsError),
    #[error(
        "checksum is {stored}, expected {computed}, the sum of the bytes: they are not what was once written"
    )]
    Checksum { stored: u32, computed: u32 },
    #[error(transparent)]
    Mounting(#[from] MountingError),
    #[error("anatomy[{index}] {name:?}: {cause}")]
    Anatomy { index: usize, name: String, cause: Box<MountingError> },
    #[error(transparent)]
    View(#[from] ViewError),
    #[error("procedure.{}.{cause}", step.key())]
    Decision { step: Step, cause: DecisionError },
    #[error("slides[{index}].{cause}")]
    Slide { index: usize, cause: ViewError },
    #[error(transparent)]
    Mesh(#[from] MeshError),
    #[error("{place}: found the material {found:?}, expected {names}")]
    Material { place: String, found: String, names: String },
    #[error("metal: {0}")]
    Metal(#[from] SetupError),
}

impl FormatError {
    /// A field with a value that it cannot have.
    pub(super) fn field(
        field: impl Into<String>,
        found: impl ToString,
        expected: &'static str,
    ) -> Self {
        Self::Field { field: field.into(), found: found.to_string(), expected }
    }

    /// A field with a number that it cannot have.
    pub(super) fn number(field: impl Into<String>, found: f64, expected: &'static str) -> Self {
        Self::field(field, short(found), expected)
    }

    /// A line that is not what it should be.
    pub(super) fn line(line: u64, found: impl Into<String>, expected: impl Into<String>) -> Self {
        Self::Line { line, found: found.into(), expected: expected.into() }
    }

    /// A cell or value with its line.
    pub(super) fn cell(
        line: u64,
        field: impl Into<String>,
        found: impl Into<String>,
        expected: &'static str,
    ) -> Self {
        Self::Cell { line, field: field.into(), found: found.into(), expected }
    }
}

/// The error of a file within a file, which names the part.
pub(super) fn in_part(part: &'static str) -> impl FnOnce(FormatError) -> FormatError {
    move |cause| FormatError::Part { part, cause: Box::new(cause) }
}

/// Longest piece of a line that an error quotes.
const MAX_QUOTE: usize = 60;

/// A line or cell between quotes, no more of it than an error has room for.
pub(super) fn quoted(text: &str) -> String {
    format!("{:?}", text.chars().take(MAX_QUOTE).collect::<String>())
}

fn written_by(found: u64, expected: u64) -> &'static str {
    match found > expected {
        true => "; a newer trackwright wrote it",
        false => "",
    }
}

/// The bytes that letters in base64 stand for.
pub(super) fn from_base64(field: &str, letters: &[u8]) -> Result<Vec<u8>, FormatError> {
    BASE64.decode(letters).map_err(|error| {
        let found = format!("no base64 from its letter {} on", error.position + 1);
        FormatError::field(field, found, "base64")
    })
}

/// The bytes as text, without a byte order mark.
pub(super) fn text(bytes: &[u8]) -> Result<&str, FormatError> {
    match std::str::from_utf8(bytes) {
        Ok(text) => Ok(text.strip_prefix('\u{feff}').unwrap_or(text)),
        Err(error) => {
            let good = &bytes[..error.valid_up_to()];
            let line_start = good.iter().rposition(|&b| b == b'\n').map_or(0, |i| i + 1);
            Err(FormatError::NotUtf8 {
                line: 1 + good.iter().filter(|&&b| b == b'\n').count(),
                column: 1 + good.len() - line_start,
            })
        }
    }
}
