//! Writes whole files or nothing: an interrupted write leaves the old file.

use super::error::StoreError;
use crate::field::Environment;
use crate::field::generator::Generator;
use crate::formats::{environment, generator};
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Writes a file through a temporary one beside it, which takes its place once it is whole and
/// on the disk. What is no plain file (`/dev/stdout`, a pipe) is written to as it is.
///
/// # Errors
/// [`StoreError::Write`]; a file that was there before is then untouched.
pub fn write_atomic(
    file: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), StoreError> {
    try_write(file, write).map_err(|cause| StoreError::Write {
        file: file.to_owned(),
        cause,
    })
}

/// Writes an environment.
///
/// # Errors
/// [`StoreError::Write`].
pub fn write_environment(file: &Path, environment: &Environment) -> Result<(), StoreError> {
    write_bytes(file, environment::write(environment).as_bytes())
}

/// Writes a field generator.
///
/// # Errors
/// [`StoreError::Write`].
pub fn write_generator(file: &Path, generator: &Generator) -> Result<(), StoreError> {
    write_bytes(file, generator::write(generator).as_bytes())
}

pub(super) fn write_bytes(file: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    write_atomic(file, |out| out.write_all(bytes))
}

fn try_write(file: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    // A link stays a link: the file that it leads to is the one to replace.
    let file = file.canonicalize().unwrap_or_else(|_| file.to_owned());
    let before = fs::metadata(&file).ok();
    if before.as_ref().is_some_and(|m| !m.is_file()) {
        let mut out = BufWriter::new(File::options().write(true).open(&file)?);
        write(&mut out)?;
        return out.flush();
    }
    let temporary = temporary_beside(&file, ".tmp")?;
    let mut out = BufWriter::new(temporary);
    write(&mut out)?;
    let temporary = out.into_inner().map_err(io::IntoInnerError::into_error)?;
    if let Some(before) = before {
        temporary.as_file().set_permissions(before.permissions())?;
    }
    temporary.as_file().sync_all()?;
    temporary.persist(&file).map_err(|error| error.error)?;
    sync_folder(&folder_of(&file));
    Ok(())
}

/// A new file beside another, to take its place once it is whole.
pub(super) fn temporary_beside(file: &Path, suffix: &str) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".trackwright-").suffix(suffix);
    // The mode that any new file gets; the umask is taken off it. A temporary file's own is 0600.
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder_of(file))
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
