//! Replaces files that others may be saving too: under a lock, and with a copy of what would be lost.

use super::error::StoreError;
use super::lock::Lock;
use super::place::{absolute, free_name};
use super::write::{Draft, folder_of, remove_leftovers, write_bytes, write_error};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use trackwright_formats::signature::holds_more_than_written;

/// What the name of a file's former version ends in.
const FORMER: &str = ".old";

/// A file that held comments, or fields that this version does not use, which its new version lacks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeptFile {
    pub file: PathBuf,
    /// The file as it was.
    pub former: PathBuf,
}

impl fmt::Display for KeptFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}: comments, and fields that this version does not use, are not kept; the file as it was is {}",
            self.file.display(),
            self.former.display()
        )
    }
}

/// Locks the files that are there, so that nobody else saves them between the look at what they hold
/// and their replacement. In one order everywhere, so that nobody waits for each other.
pub(super) fn lock_all(texts: &[(PathBuf, String)]) -> Result<BTreeMap<PathBuf, Lock>, StoreError> {
    let files: BTreeSet<PathBuf> = texts.iter().map(|(file, _)| absolute(file)).collect();
    let mut locks = BTreeMap::new();
    for file in files {
        if let Some(lock) = Lock::for_replacing(&file)? {
            locks.insert(file, lock);
        }
    }
    Ok(locks)
}

/// Writes a file; one that was not there must not have appeared meanwhile.
pub(super) fn replace(file: &Path, bytes: &[u8], was_there: bool) -> Result<(), StoreError> {
    remove_leftovers(&folder_of(file));
    let draft = Draft::write(file, |out| out.write_all(bytes));
    let placed = draft.and_then(|draft| match was_there {
        true => draft.place(),
        false => draft.place_new(),
    });
    placed.map_err(|cause| match cause.kind() {
        io::ErrorKind::AlreadyExists => StoreError::ChangedOnDisk { file: file.to_owned() },
        _ => write_error(file, cause),
    })
}

/// Copies a file of which something is lost when it is written anew.
pub(super) fn keep_former(file: &Path) -> Result<Option<KeptFile>, StoreError> {
    let Ok(bytes) = fs::read(file) else {
        return Ok(None);
    };
    if !holds_more_than_written(&bytes) {
        return Ok(None);
    }
    let mut former = file.as_os_str().to_owned();
    former.push(FORMER);
    let former = free_name(Path::new(&former), |path| !path.exists());
    write_bytes(&former, &bytes)?;
    Ok(Some(KeptFile { file: file.to_owned(), former }))
}

#[cfg(test)]
mod tests {
    use super::super::{open_builtin_without_meshes, open_design_without_meshes, save, save_as};
    use super::*;
    use std::thread;
    use trackwright_design::Edit;

    /// Saves of each of two threads; more with `TRACKWRIGHT_RUNS`.
    fn saves() -> usize {
        let runs = std::env::var("TRACKWRIGHT_RUNS");
        runs.map_or(40, |runs| runs.parse().unwrap())
    }

    /// Adds a letter to a design's name, as often as it takes to be the one who saves.
    fn add_letter(file: &Path, letter: char) {
        loop {
            let mut world = open_design_without_meshes(file).unwrap();
            let name = format!("{}{letter}", world.document.design().name);
            world.document.apply(Edit::SetName(name)).unwrap();
            match save(&mut world) {
                Ok(_) => return,
                Err(StoreError::ChangedOnDisk { .. }) => {}
                Err(error) => panic!("{error}"),
            }
        }
    }

    #[test]
    fn no_save_of_two_at_once_is_lost() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.design.ron");
        let mut world = open_builtin_without_meshes("pointer-on-head").unwrap();
        world.document.apply(Edit::SetName("n".into())).unwrap();
        save_as(&mut world, &file).unwrap();
        thread::scope(|scope| {
            for letter in ['a', 'b'] {
                let file = &file;
                scope.spawn(move || (0..saves()).for_each(|_| add_letter(file, letter)));
            }
        });
        let world = open_design_without_meshes(&file).unwrap();
        let name = &world.document.design().name;
        let count = |letter| name.chars().filter(|c| *c == letter).count();
        assert_eq!((count('a'), count('b')), (saves(), saves()));
    }

    #[test]
    fn a_file_that_appears_meanwhile_is_not_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a");
        fs::write(&file, "theirs").unwrap();
        let error = replace(&file, b"mine", false).unwrap_err();
        assert!(matches!(error, StoreError::ChangedOnDisk { .. }), "{error}");
        assert_eq!(fs::read(&file).unwrap(), b"theirs");
    }
}
