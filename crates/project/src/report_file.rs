//! Where a report goes, known before any work is spent on it.

use super::error::StoreError;
use super::write::folder_of;
use std::ffi::OsStr;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// The file that a report is written to: `output` itself where its name ends in `.html`, or
/// `NAME.html` in the folder `output`, which is made where it isn't there.
///
/// # Errors
/// [`StoreError::Write`] where nothing can be written there.
pub fn report_file(output: &Path, name: &OsStr) -> Result<PathBuf, StoreError> {
    let fails = |cause: io::Error| StoreError::Write { file: output.to_owned(), cause };
    let file = match fs::metadata(output) {
        // A file of another kind is hardly meant, and no folder.
        Ok(there) if there.is_file() && !is_page(output) => {
            return Err(fails(io::ErrorKind::NotADirectory.into()));
        }
        Ok(there) if there.is_file() => output.to_owned(),
        // A pipe, a terminal.
        Ok(there) if !there.is_dir() => return Ok(output.to_owned()),
        Err(_) if is_page(output) => output.to_owned(),
        _ => {
            fs::create_dir_all(output).map_err(fails)?;
            let mut page = name.to_owned();
            page.push(".html");
            output.join(page)
        }
    };
    tempfile::tempfile_in(folder_of(&file)).map_err(fails)?;
    Ok(file)
}

/// Whether a file's name is that of a page.
fn is_page(file: &Path) -> bool {
    let extension = file.extension().and_then(OsStr::to_str);
    extension.is_some_and(|e| e.eq_ignore_ascii_case("html") || e.eq_ignore_ascii_case("htm"))
}
