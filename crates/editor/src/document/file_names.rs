//! Names of design files, and the folder in which dialogs begin.

use std::path::{Path, PathBuf};
use trackwright_design::{Document, Origin};
use trackwright_project::{Starter, file_name};

/// What design files are called.
pub const DESIGN_EXTENSION: &str = ".design.ron";

/// What a person calls the file that a document came from.
pub fn origin_name(origin: &Origin) -> String {
    match origin {
        Origin::BuiltIn(_) if Starter::of(origin).is_some() => "untitled".to_owned(),
        Origin::BuiltIn(name) => format!("{name} (built in)"),
        Origin::File(path) => file_name(path),
    }
}

/// `Saved needle.design.ron, tool.body.ron, operating-table.env.ron`: a file by its name, then every
/// other one that was written with it.
pub fn saved_words(file: String, written: &[PathBuf]) -> String {
    let others = written.iter().map(|path| file_name(path)).filter(|name| *name != file);
    let names = std::iter::once(file.clone()).chain(others);
    format!("Saved {}", names.collect::<Vec<_>>().join(", "))
}

/// What the file of a design is called; of one that was never saved, after the design's own name.
pub fn default_file_name(document: &Document) -> String {
    match document.origin() {
        Origin::File(path) => file_name(path),
        Origin::BuiltIn(_) => format!("{}{DESIGN_EXTENSION}", stem_of(&document.design().name)),
    }
}

/// Longest name that is made of a design's, in letters: file systems take some 250 bytes.
const MOST_LETTERS: usize = 60;

/// A name as one that every file system and every shell takes: lower case, with hyphens between its
/// words.
fn stem_of(name: &str) -> String {
    let lower = name.to_lowercase();
    let words = lower.split(|letter: char| !letter.is_alphanumeric());
    let words: Vec<&str> = words.filter(|word| !word.is_empty()).collect();
    let stem: String = words.join("-").chars().take(MOST_LETTERS).collect();
    match stem.trim_end_matches('-') {
        "" => "untitled".to_owned(),
        stem => stem.to_owned(),
    }
}

/// The path with the extension of designs where a person left it out.
pub(crate) fn with_extension(path: &Path) -> PathBuf {
    let name = path.as_os_str().to_string_lossy();
    if name.ends_with(".ron") {
        path.to_path_buf()
    } else {
        PathBuf::from(format!("{name}{DESIGN_EXTENSION}"))
    }
}

/// Where dialogs begin: the folder of the open file, else the working folder.
pub fn file_folder(world: &trackwright_project::World) -> PathBuf {
    let of_file = match world.document.origin() {
        Origin::File(path) => path.parent().map(Path::to_path_buf),
        Origin::BuiltIn(_) => None,
    };
    of_file.filter(|folder| !folder.as_os_str().is_empty()).unwrap_or_else(working_folder)
}

pub(crate) fn working_folder() -> PathBuf {
    std::env::current_dir().unwrap_or_else(|_| PathBuf::from("/"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn saving_names_every_file_the_design_first() {
        let design = || origin_name(&Origin::File("a/needle.design.ron".into()));
        let written = ["tool.body.ron", "operating-table.env.ron", "needle.design.ron"];
        let written = written.map(|name| Path::new("a").join(name));
        let words = "Saved needle.design.ron, tool.body.ron, operating-table.env.ron";
        assert_eq!(saved_words(design(), &written), words);
        assert_eq!(saved_words(design(), &[]), "Saved needle.design.ron");
    }

    #[test]
    fn a_design_that_was_never_saved_suggests_its_name() {
        assert_eq!(stem_of("Pointer on a head-mounted CRF"), "pointer-on-a-head-mounted-crf");
        assert_eq!(stem_of(" ../Ärzte: 2 "), "ärzte-2");
        assert_eq!(stem_of("…"), "untitled");
        assert_eq!(stem_of(&"x".repeat(500)).len(), MOST_LETTERS);
    }

    #[test]
    fn a_name_without_extension_becomes_a_design() {
        assert_eq!(with_extension(Path::new("a/b")), Path::new("a/b.design.ron"));
        assert_eq!(with_extension(Path::new("a/b.design.ron")), Path::new("a/b.design.ron"));
    }
}
