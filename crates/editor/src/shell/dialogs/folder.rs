//! What a folder offers to a dialog: its folders, and its files of one kind.

use std::path::{Path, PathBuf};

/// One line of a dialog's list.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Entry {
    /// The folder above.
    Up,
    Folder(String),
    File(String),
}

impl Entry {
    pub fn name(&self) -> &str {
        match self {
            Self::Up => "..",
            Self::Folder(name) | Self::File(name) => name,
        }
    }

    /// Where it leads from a folder.
    pub fn path(&self, folder: &Path) -> PathBuf {
        match self {
            Self::Up => folder.parent().unwrap_or(folder).to_path_buf(),
            Self::Folder(name) | Self::File(name) => folder.join(name),
        }
    }
}

/// Folders first, then files whose names end in one of these, in any case; each by name, and hidden
/// ones are left out.
///
/// # Errors
/// The system's, in words that name the folder.
pub fn list(folder: &Path, extensions: &[&str]) -> Result<Vec<Entry>, String> {
    let found =
        std::fs::read_dir(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut entries: Vec<Entry> = found
        .flatten()
        .filter_map(|entry| {
            let name = entry.file_name().into_string().ok()?;
            if name.starts_with('.') {
                return None;
            }
            if entry.path().is_dir() {
                Some(Entry::Folder(name))
            } else {
                let lower = name.to_lowercase();
                let is_wanted = extensions.iter().any(|end| lower.ends_with(end));
                is_wanted.then_some(Entry::File(name))
            }
        })
        .collect();
    if folder.parent().is_some() {
        entries.push(Entry::Up);
    }
    entries.sort();
    Ok(entries)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_are_listed_before_files_of_the_kind() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["b.design.ron", "a.design.ron", "notes.txt", ".x.design.ron"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        std::fs::create_dir(folder.path().join("rooms")).unwrap();
        let entries = list(folder.path(), &[".design.ron"]).unwrap();
        let names: Vec<&str> = entries.iter().map(Entry::name).collect();
        assert_eq!(names, ["..", "rooms", "a.design.ron", "b.design.ron"]);
    }

    #[test]
    fn a_folder_that_is_not_there_is_named() {
        let error = list(Path::new("/no/such/folder"), &[".csv"]).unwrap_err();
        assert!(error.starts_with("/no/such/folder: "), "{error}");
    }
}
