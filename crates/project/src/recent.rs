//! The designs that were opened last.

use super::error::StoreError;
use super::lock::Lock;
use super::place::{Kind, Place};
use super::read::read;
use super::state::create_private_folder;
use super::write::write_bytes;
use std::io;
use std::path::{Path, PathBuf};
use trackwright_formats::recent_file;

/// Designs that are remembered.
pub const MAX_RECENT: usize = 10;

const FILE: &str = "recent.ron";
const LOCK: &str = "recent.lock";

/// A design that was opened before.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecentDesign {
    /// Absolute.
    pub file: PathBuf,
    /// Whether there is no such file now.
    pub is_missing: bool,
}

/// The designs that were opened last, the newest first, as a state folder remembers them.
///
/// # Errors
/// See [`StoreError`]. A folder without a list has none.
pub fn recent_designs(folder: &Path) -> Result<Vec<RecentDesign>, StoreError> {
    let designs = read_list(folder)?
        .into_iter()
        .map(|file| RecentDesign { is_missing: !file.is_file(), file });
    Ok(designs.take(MAX_RECENT).collect())
}

/// Puts a design at the head of the list. A list that cannot be read is begun anew: it only
/// saves a walk through folders.
///
/// # Errors
/// [`StoreError::Write`] or [`StoreError::Lock`].
pub fn remember_recent(folder: &Path, design: &Path) -> Result<(), StoreError> {
    let design = std::path::absolute(design).unwrap_or_else(|_| design.to_owned());
    change(folder, |designs| {
        designs.retain(|known| *known != design);
        designs.insert(0, design);
        designs.truncate(MAX_RECENT);
    })
}

/// Takes a design off the list.
///
/// # Errors
/// As [`remember_recent`].
pub fn forget_recent(folder: &Path, design: &Path) -> Result<(), StoreError> {
    change(folder, |designs| designs.retain(|known| known != design))
}

/// Changes the list while no other process does, so that none forgets what another remembers.
fn change(folder: &Path, change: impl FnOnce(&mut Vec<PathBuf>)) -> Result<(), StoreError> {
    create_private_folder(folder)
        .map_err(|cause| StoreError::Write { file: folder.to_owned(), cause })?;
    // Held by anybody only while one small file is written.
    let _lock = Lock::wait_for(&folder.join(LOCK))?;
    let mut designs = read_list(folder).unwrap_or_default();
    change(&mut designs);
    write_bytes(&folder.join(FILE), recent_file::write(&designs).as_bytes())
}

fn read_list(folder: &Path) -> Result<Vec<PathBuf>, StoreError> {
    match read(Place::Disk, &folder.join(FILE), Kind::RECENT, recent_file::parse) {
        Err(StoreError::Read { cause, .. }) if cause.kind() == io::ErrorKind::NotFound => {
            Ok(Vec::new())
        }
        list => list,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn names(folder: &Path) -> Vec<String> {
        let name = |design: RecentDesign| design.file.to_string_lossy().into_owned();
        recent_designs(folder).unwrap().into_iter().map(name).collect()
    }

    #[test]
    fn the_last_ten_are_kept_each_once_and_missing_ones_marked() {
        let folder = tempfile::tempdir().unwrap();
        let state = folder.path().join("not/yet");
        assert_eq!(recent_designs(&state).unwrap(), []);
        let there = folder.path().join("there.design.ron");
        fs::write(&there, "").unwrap();
        remember_recent(&state, &there).unwrap();
        for number in 0..12 {
            remember_recent(&state, Path::new(&format!("/{number}"))).unwrap();
        }
        remember_recent(&state, &there).unwrap();
        remember_recent(&state, Path::new("/7")).unwrap();
        let list = recent_designs(&state).unwrap();
        assert_eq!(list.len(), MAX_RECENT);
        assert_eq!(names(&state)[..3], ["/7", &there.to_string_lossy(), "/11"]);
        assert_eq!((list[0].is_missing, list[1].is_missing), (true, false));
        forget_recent(&state, &there).unwrap();
        assert!(!names(&state).contains(&there.to_string_lossy().into_owned()));
    }

    #[test]
    fn a_broken_list_is_reported_and_begun_anew() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(FILE), "(").unwrap();
        assert!(recent_designs(folder.path()).is_err());
        remember_recent(folder.path(), Path::new("/a")).unwrap();
        assert_eq!(names(folder.path()), ["/a"]);
    }

    #[test]
    fn writers_at_once_forget_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let remember = |number: usize| {
            remember_recent(folder.path(), Path::new(&format!("/{number}"))).unwrap();
        };
        std::thread::scope(|scope| {
            for number in 0..MAX_RECENT {
                scope.spawn(move || remember(number));
            }
        });
        let mut names = names(folder.path());
        names.sort();
        let mut all: Vec<_> = (0..MAX_RECENT).map(|n| format!("/{n}")).collect();
        all.sort();
        assert_eq!(names, all);
    }
}
