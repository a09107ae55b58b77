//! Writes whole files or nothing: an interrupted write leaves the old file.

use super::error::StoreError;
use super::lock::Lock;
use std::fs::{self, File};
use std::io::{self, BufWriter, Read, Write};
use std::path::{Path, PathBuf};

/// What the names of temporary files begin with.
const TEMPORARY: &str = ".trackwright-";

/// Tries to make a temporary file that nobody removes while it is made. One is all but always enough.
const TEMPORARY_ATTEMPTS: usize = 16;

/// Writes a file of the program's own, whatever was there before, and removes what interrupted writes
/// left in its folder.
///
/// # Errors
/// [`StoreError::Write`]; a file that was there before is then untouched.
pub(super) fn write_bytes(file: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    remove_leftovers(&folder_of(file));
    let draft = Draft::write(file, |out| out.write_all(bytes));
    draft.and_then(Draft::place).map_err(|cause| write_error(file, cause))
}

pub(super) fn write_error(file: &Path, cause: io::Error) -> StoreError {
    StoreError::Write { file: file.to_owned(), cause }
}

/// A file that is whole and on the disk, beside the one whose place it is to take. What is no plain
/// file (`/dev/stdout`, a pipe) has been written to as it is.
#[derive(Debug)]
pub(super) struct Draft {
    /// Links followed: a link stays a link.
    file: PathBuf,
    /// `None` for what is no plain file.
    temporary: Option<Temporary>,
}

impl Draft {
    pub(super) fn write(
        file: &Path,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> io::Result<Self> {
        let file = file.canonicalize().unwrap_or_else(|_| file.to_owned());
        let before = fs::metadata(&file).ok();
        if before.as_ref().is_some_and(|m| !m.is_file()) {
            let mut out = BufWriter::new(File::options().write(true).open(&file)?);
            write(&mut out)?;
            out.flush()?;
            return Ok(Self { file, temporary: None });
        }
        let temporary = Temporary::beside(&file, ".tmp")?;
        let mut out = BufWriter::new(&temporary.handle);
        write(&mut out)?;
        out.flush()?;
        drop(out);
        if let Some(before) = before {
            temporary.handle.set_permissions(before.permissions())?;
        }
        temporary.handle.sync_all()?;
        Ok(Self { file, temporary: Some(temporary) })
    }

    /// What it and the file that it is to replace begin with; `None` where there is nothing to replace.
    pub(super) fn beginnings(&self, length: u64) -> io::Result<Option<[Vec<u8>; 2]>> {
        let Some(temporary) = &self.temporary else {
            return Ok(None);
        };
        let beginning = |file: &Path| -> io::Result<Vec<u8>> {
            let mut bytes = Vec::new();
            File::open(file)?.take(length).read_to_end(&mut bytes)?;
            Ok(bytes)
        };
        match beginning(&self.file) {
            Ok(old) => Ok(Some([old, beginning(&temporary.path)?])),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Whether the file that it is to replace holds the same already.
    pub(super) fn is_there_already(&self) -> io::Result<bool> {
        let Some(temporary) = &self.temporary else {
            return Ok(false);
        };
        let is_as_long = fs::metadata(&self.file)?.len() == temporary.handle.metadata()?.len();
        Ok(is_as_long && fs::read(&self.file)? == fs::read(&temporary.path)?)
    }

    /// Replaces the file.
    pub(super) fn place(self) -> io::Result<()> {
        if let Some(temporary) = self.temporary {
            temporary.path.persist(&self.file).map_err(|e| e.error)?;
            sync_folder(&folder_of(&self.file));
        }
        Ok(())
    }

    /// Becomes the file, which must not be there.
    pub(super) fn place_new(self) -> io::Result<()> {
        if let Some(temporary) = self.temporary {
            let placed = temporary.path.persist_noclobber(&self.file);
            placed.map_err(|e| e.error)?;
            sync_folder(&folder_of(&self.file));
        }
        Ok(())
    }
}

/// A file beside another, to take its place once it is whole. It is locked for as long as it is
/// written, so that one whose lock is free is what an interrupted write left.
#[derive(Debug)]
pub(super) struct Temporary {
    pub(super) handle: File,
    pub(super) path: tempfile::TempPath,
}

impl Temporary {
    pub(super) fn beside(file: &Path, suffix: &str) -> io::Result<Self> {
        let mut builder = tempfile::Builder::new();
        builder.prefix(TEMPORARY).suffix(suffix);
        // The mode that any new file gets; the umask is taken off it. A temporary file's own is 0600.
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            builder.permissions(fs::Permissions::from_mode(0o666));
        }
        for _ in 0..TEMPORARY_ATTEMPTS {
            let (handle, path) = builder.tempfile_in(folder_of(file))?.into_parts();
            // Where files cannot be locked nobody removes them either.
            let is_taken = matches!(handle.try_lock(), Err(fs::TryLockError::WouldBlock));
            if !is_taken && path.exists() {
                return Ok(Self { handle, path });
            }
        }
        Err(io::ErrorKind::WouldBlock.into())
    }
}

/// Removes the temporary files of a folder that nobody writes any more.
pub(super) fn remove_leftovers(folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let is_temporary = entry.file_name().to_string_lossy().starts_with(TEMPORARY);
        // No link, no pipe.
        if !is_temporary || !entry.file_type().is_ok_and(|kind| kind.is_file()) {
            continue;
        }
        let Ok(handle) = File::open(entry.path()) else {
            continue;
        };
        if let Ok(Some(lock)) = Lock::take_open(handle, &entry.path()) {
            let _ = fs::remove_file(lock.file());
        }
    }
}

/// The folder of a file, never empty.
pub(super) fn folder_of(file: &Path) -> PathBuf {
    match file.parent() {
        Some(folder) if folder != Path::new("") => folder.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// Makes the new name outlast a power cut. The file is in place by now, and file systems that
/// cannot do this are no reason to say it isn't.
fn sync_folder(folder: &Path) {
    if cfg!(unix) {
        let _ = File::open(folder).and_then(|folder| folder.sync_all());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let name = |entry: io::Result<fs::DirEntry>| entry.unwrap().file_name();
        let mut names: Vec<String> =
            entries.map(|entry| name(entry).to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    #[test]
    fn leftovers_of_interrupted_writes_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.csv");
        for name in [".trackwright-a.tmp", ".trackwright-b.mp4", ".trackwrong"] {
            fs::write(folder.path().join(name), "half a li").unwrap();
        }
        write_bytes(&file, b"whole").unwrap();
        assert_eq!(names(folder.path()), [".trackwrong", "a.csv"]);
    }

    #[test]
    fn a_temporary_file_in_use_is_no_leftover() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.csv");
        let in_use = Temporary::beside(&file, ".tmp").unwrap();
        write_bytes(&file, b"whole").unwrap();
        assert!(in_use.path.exists());
        drop(in_use);
        assert_eq!(names(folder.path()), ["a.csv"]);
    }

    #[test]
    fn a_failed_write_leaves_the_old_file() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.csv");
        write_bytes(&file, b"old").unwrap();
        let failed = Draft::write(&file, |out| {
            out.write_all(b"ne")?;
            Err(io::ErrorKind::StorageFull.into())
        });
        assert_eq!(failed.unwrap_err().kind(), io::ErrorKind::StorageFull);
        assert_eq!(fs::read(&file).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["a.csv"]);
    }
}
