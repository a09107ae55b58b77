//! What a file's name says: its kind by its ending, and its own name before that.

use anyhow::bail;
use std::path::Path;

/// Whether a file's name ends so, in any case.
pub fn ends_with(file: &Path, ending: &str) -> bool {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    name.to_lowercase().ends_with(ending)
}

/// Which of the endings a file has; `what` is to be written to it.
///
/// # Errors
/// A name with none of them.
pub fn file_kind(
    file: &Path,
    what: &str,
    endings: &[&'static str],
) -> anyhow::Result<&'static str> {
    if let Some(ending) = endings.iter().find(|ending| ends_with(file, ending)) {
        return Ok(ending);
    }
    let (last, others) = endings.split_last().map_or(("", &[][..]), |(l, o)| (*l, o));
    bail!(
        "{}: found no kind of file that {what} can be written as, expected a name that ends with {} or {last}",
        file.display(),
        others.join(", ")
    )
}

/// A file's name without folder and ending.
pub fn own_name(file: &Path, ending: &str) -> String {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    name.split(ending).next().unwrap_or_default().to_owned()
}
