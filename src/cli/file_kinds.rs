//! What a file's name gives: its kind by its ending, and its own name before that.

use super::choice::Choice;
use anyhow::bail;
use std::path::Path;
use trackwright_formats::export::PatientAxes;
use trackwright_project::file_name;

/// Whether a file's name ends so, in any case.
pub fn ends_with(file: &Path, ending: &str) -> bool {
    file_name(file).to_lowercase().ends_with(ending)
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
    file_name(file).split(ending).next().unwrap_or_default().to_owned()
}

/// What 3D Slicer takes the tracker's x, y and z for.
pub const AXES: Choice<PatientAxes> = Choice(&[
    (
        "ras",
        "Its own right, anterior, superior, as it takes live poses over OpenIGTLink: files, which \
         are in LPS, have x and y negated",
        PatientAxes::Ras,
    ),
    (
        "lps",
        "Left, posterior, superior: files have the tracker's numbers as they are",
        PatientAxes::Lps,
    ),
]);

/// Refuses other axes than the usual ones for a file that is in the tracker's own.
pub fn refuse_axes(axes: PatientAxes, file: &Path) -> anyhow::Result<()> {
    if axes != PatientAxes::Ras {
        bail!(
            "--axes: {} is in the tracker's own axes, expected a file for 3D Slicer with it",
            file.display()
        );
    }
    Ok(())
}
