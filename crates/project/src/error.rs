//! What can go wrong with files, in the words that the command line and the editor show.

use std::io;
use std::path::PathBuf;
use std::sync::Arc;
use trackwright_calibration::doubts::Suspicion;
use trackwright_formats::FormatError;
use trackwright_formats::signature::Signature;
use trackwright_formats::tool_definition::ConversionError;
use trackwright_metal::furnished::FurnishError;
use trackwright_task::Cancelled;

/// A file that could not be used. Nothing was changed by the attempt.
///
/// The message is whole: what lies behind it is part of it, and no source to be printed again.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    #[error("{}: {}, expected {expected}", file.display(), what_was_read(cause))]
    Read { file: PathBuf, expected: &'static str, cause: io::Error },
    #[error("{}: {cause}", file.display())]
    Format { file: PathBuf, cause: FormatError },
    #[error("{}: cannot be written: {}", file.display(), what_happened(cause))]
    Write { file: PathBuf, cause: io::Error },
    #[error("{}: found more than {limit} bytes, expected {expected}", file.display())]
    TooLarge { file: PathBuf, limit: u64, expected: &'static str },
    #[error("{}: found no quaternions, expected them for 6-DOF sensors", file.display())]
    NoQuaternions { file: PathBuf },
    /// A table that is not used unless it is stated to be as it is meant.
    #[error("{}: {suspicion}", file.display())]
    Doubted { file: PathBuf, suspicion: Box<Suspicion> },
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    #[error("{}: {cause}", file.display())]
    Metal { file: PathBuf, cause: Arc<FurnishError> },
    #[error("{name}: found no built-in design of this name, expected one of {names}")]
    NoSuchBuiltIn { name: String, names: String },
    #[error("the built-in design {0} is read-only, expected Save as and a file of your own")]
    ReadOnly(&'static str),
    #[error("{}: tool and CRF are the same file but differ now, expected one to be saved as another file", file.display())]
    BodiesDiffer { file: PathBuf },
    #[error("{}: somebody else changed this file since it was read, expected a word on whose content is to stay", file.display())]
    ChangedOnDisk { file: PathBuf },
    #[error("{}: cannot be locked: {}", file.display(), what_happened(cause))]
    Lock { file: PathBuf, cause: io::Error },
    /// One of the files that are read, to be written over.
    #[error("{}: found a file that is read here, expected another one to write to", file.display())]
    IsInput { file: PathBuf },
    #[error("{}: this command writes {} there as well, expected two files", file.display(), other.display())]
    TwoOutputs { file: PathBuf, other: PathBuf },
    /// Something to be written over that is no earlier output.
    #[error("{}: found {found} that no command wrote, or that somebody has changed since; expected another name, or --overwrite to replace it", file.display())]
    NotOwn { file: PathBuf, found: Signature },
    #[error("{}: the design itself uses this file, expected another one to save as", file.display())]
    InUse { file: PathBuf },
    #[error("{}: found a name of no known format, expected one in .body.ron, .rom, .tool, .ini or .json", file.display())]
    NoBodyFormat { file: PathBuf },
    #[error("{}: the body cannot be a {format}: {cause}", file.display())]
    NotConvertible { file: PathBuf, format: &'static str, cause: ConversionError },
}

impl StoreError {
    /// Whether a checksum does not match: the file can be read all the same.
    pub fn is_checksum(&self) -> bool {
        matches!(self, Self::Format { cause: FormatError::Checksum { .. }, .. })
    }

    /// Whether a file is sound as far as can be checked, but of another version of the program.
    pub fn is_other_version(&self) -> bool {
        matches!(self, Self::Format { cause: FormatError::Version { .. }, .. })
    }
}

/// What there was in the place of a file.
fn what_was_read(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "File not found".to_owned(),
        _ => format!("found {}", what_happened(error)),
    }
}

/// An I/O error without its number.
fn what_happened(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "no such file or folder".to_owned(),
        io::ErrorKind::PermissionDenied => "no permission".to_owned(),
        io::ErrorKind::IsADirectory => "a folder".to_owned(),
        io::ErrorKind::NotADirectory => "a file where a folder should be".to_owned(),
        io::ErrorKind::AlreadyExists => "a file is there already".to_owned(),
        io::ErrorKind::StorageFull => "no space left".to_owned(),
        _ => error.to_string(),
    }
}
