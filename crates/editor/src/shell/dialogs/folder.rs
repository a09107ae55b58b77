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

/// The entries that what is typed can mean: those with it in their names, in any case. The way up is
/// always one.
pub fn filtered<'a>(entries: &'a [Entry], typed: &str) -> Vec<&'a Entry> {
    let typed = typed.to_lowercase();
    let is_meant =
        |entry: &&Entry| **entry == Entry::Up || entry.name().to_lowercase().contains(&typed);
    entries.iter().filter(is_meant).collect()
}

/// The folders and files whose names begin with what is typed, in any case.
pub fn beginning_with<'a>(entries: &'a [Entry], typed: &str) -> Vec<&'a Entry> {
    let typed = typed.to_lowercase();
    let begins =
        |entry: &&Entry| **entry != Entry::Up && entry.name().to_lowercase().starts_with(&typed);
    entries.iter().filter(begins).collect()
}

/// What is typed, completed as far as all names agree that begin with it, and with a separator
/// behind the only folder; `None` where that adds nothing.
pub fn completed(entries: &[Entry], typed: &str) -> Option<String> {
    let all = beginning_with(entries, typed);
    let completed = match all.as_slice() {
        [Entry::Folder(name)] => format!("{name}{}", std::path::MAIN_SEPARATOR),
        [first, others @ ..] => {
            let mut common: Vec<char> = first.name().chars().collect();
            for other in others {
                let is_same = |(a, b): &(&char, char)| a.to_lowercase().eq(b.to_lowercase());
                let agreed = common.iter().zip(other.name().chars()).take_while(is_same).count();
                common.truncate(agreed);
            }
            common.into_iter().collect()
        }
        [] => return None,
    };
    (completed != typed).then_some(completed)
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

    fn entries() -> Vec<Entry> {
        let file = |name: &str| Entry::File(name.to_owned());
        let folder = Entry::Folder("Scans".to_owned());
        vec![Entry::Up, folder, file("pointer.stl"), file("Pointing.stl"), file("probe.stl")]
    }

    #[test]
    fn a_list_is_filtered_by_any_part_of_a_name() {
        let entries = entries();
        let names = |typed| {
            let found = filtered(&entries, typed);
            found.into_iter().map(Entry::name).collect::<Vec<_>>()
        };
        assert_eq!(names("OINT"), ["..", "pointer.stl", "Pointing.stl"]);
        assert_eq!(names("nothing"), [".."]);
        assert_eq!(names("").len(), entries.len());
    }

    #[test]
    fn names_are_completed_as_far_as_they_agree() {
        let entries = entries();
        let completed = |typed| completed(&entries, typed);
        assert_eq!(completed("p").as_deref(), None, "two ways from here");
        assert_eq!(completed("PO").as_deref(), Some("point"));
        assert_eq!(completed("point"), None);
        assert_eq!(completed("pr").as_deref(), Some("probe.stl"));
        assert_eq!(completed("probe.stl"), None);
        let scans = format!("Scans{}", std::path::MAIN_SEPARATOR);
        assert_eq!(completed("sc"), Some(scans));
        assert_eq!(completed("x"), None);
    }

    #[test]
    fn a_folder_that_is_not_there_is_named() {
        let error = list(Path::new("/no/such/folder"), &[".csv"]).unwrap_err();
        assert!(error.starts_with("/no/such/folder: "), "{error}");
    }
}
