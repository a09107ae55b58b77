//! Which file a name leads to, whatever else it is called.

use super::place::absolute;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

/// A file by what the system knows it by: hard and symbolic links to one file are equal.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum FileId {
    /// Device and number.
    #[cfg(unix)]
    Node(u64, u64),
    /// What cannot be looked at, or has no number.
    Path(PathBuf),
}

impl FileId {
    pub(super) fn of(file: &Path) -> Self {
        #[cfg(unix)]
        if let Ok(metadata) = fs::metadata(file) {
            return Self::of_metadata(&metadata);
        }
        Self::Path(absolute(file))
    }

    #[cfg(unix)]
    fn of_metadata(metadata: &fs::Metadata) -> Self {
        use std::os::unix::fs::MetadataExt;
        Self::Node(metadata.dev(), metadata.ino())
    }
}

/// Whether a name still leads to the file that was opened by it.
#[cfg(unix)]
pub(super) fn is_still(handle: &File, file: &Path) -> io::Result<bool> {
    let opened = FileId::of_metadata(&handle.metadata()?);
    match fs::metadata(file) {
        Ok(there) => Ok(FileId::of_metadata(&there) == opened),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error),
    }
}

/// Names do not move there while a file is open.
#[cfg(not(unix))]
pub(super) fn is_still(_: &File, file: &Path) -> io::Result<bool> {
    fs::exists(file)
}
