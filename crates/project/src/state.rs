//! What belongs to no design: where the program keeps it, preferences, and recent designs.

use super::error::StoreError;
use super::read::{Kind, read_if_there};
use super::write::{Lock, write_bytes, write_error};
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use trackwright_formats::preferences_file::{self, Preferences};
use trackwright_formats::recent_file;

/// Names the state folder itself, before any other source.
pub const STATE_VARIABLE: &str = "TRACKWRIGHT_STATE";

/// The folder for state: `$TRACKWRIGHT_STATE`, else `trackwright` in `$XDG_STATE_HOME`, in
/// `%LOCALAPPDATA%` or in `~/.local/state`. `None` where the environment names none of them.
/// It need not exist.
pub fn state_folder() -> Option<PathBuf> {
    state_folder_of(|name| std::env::var_os(name))
}

/// The folder for recovery files, in the one for state.
pub fn recovery_folder() -> Option<PathBuf> {
    state_folder().map(|folder| folder.join("recovery"))
}

fn state_folder_of(variable: impl Fn(&str) -> Option<OsString>) -> Option<PathBuf> {
    let path = |name| variable(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    // The XDG base directory specification has relative paths ignored.
    let absolute = |name| path(name).filter(|p| p.is_absolute());
    path(STATE_VARIABLE).or_else(|| {
        absolute("XDG_STATE_HOME")
            .or_else(|| absolute("LOCALAPPDATA"))
            .or_else(|| Some(absolute("HOME")?.join(".local/state")))
            .map(|folder| folder.join("trackwright"))
    })
}

/// Makes a folder for nobody else's eyes, and those that it is in.
pub(super) fn create_private_folder(folder: &Path) -> Result<(), StoreError> {
    let mut builder = fs::DirBuilder::new();
    builder.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(folder).map_err(|cause| write_error(folder, cause))
}

const PREFERENCES: &str = "preferences.ron";
const PREFERENCES_BACKUP: &str = "preferences.ron.bak";

/// Stored preferences; `None` before the first.
pub fn read_preferences(folder: &Path) -> Result<Option<Preferences>, StoreError> {
    read_if_there(&folder.join(PREFERENCES), Kind::PREFERENCES, preferences_file::parse)
}

/// Writes preferences, whole or not at all. Of two windows the one that wrote last is right. A file
/// that cannot be used, as with a field that is mistyped, is kept beside as `preferences.ron.bak`.
pub fn write_preferences(folder: &Path, preferences: &Preferences) -> Result<(), StoreError> {
    create_private_folder(folder)?;
    let file = folder.join(PREFERENCES);
    if let Err(StoreError::Format { .. }) = read_preferences(folder) {
        fs::rename(&file, folder.join(PREFERENCES_BACKUP))
            .map_err(|cause| write_error(&file, cause))?;
    }
    let text = preferences_file::write(preferences);
    write_bytes(&file, text.as_bytes())
}

/// Designs that are remembered.
pub const MAX_RECENT: usize = 10;

const RECENT: &str = "recent.ron";
const RECENT_LOCK: &str = "recent.lock";

/// A design that was opened before.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecentDesign {
    /// Absolute.
    pub file: PathBuf,
    /// Whether there is no such file now.
    pub is_missing: bool,
}

/// The designs that were opened last, the newest first.
pub fn recent_designs(folder: &Path) -> Result<Vec<RecentDesign>, StoreError> {
    let designs = read_recent(folder)?
        .into_iter()
        .map(|file| RecentDesign { is_missing: !file.is_file(), file });
    Ok(designs.take(MAX_RECENT).collect())
}

/// Puts a design at the head of the list; one that cannot be read is begun anew.
pub fn remember_recent(folder: &Path, design: &Path) -> Result<(), StoreError> {
    let design = std::path::absolute(design).unwrap_or_else(|_| design.to_owned());
    change_recent(folder, |designs| {
        designs.retain(|known| *known != design);
        designs.insert(0, design);
        designs.truncate(MAX_RECENT);
    })
}

/// Takes a design off the list.
pub fn forget_recent(folder: &Path, design: &Path) -> Result<(), StoreError> {
    change_recent(folder, |designs| designs.retain(|known| known != design))
}

/// Changes the list while no other process does, so that none forgets what another remembers.
fn change_recent(folder: &Path, change: impl FnOnce(&mut Vec<PathBuf>)) -> Result<(), StoreError> {
    create_private_folder(folder)?;
    // Held by anybody only while one small file is written.
    let _lock = Lock::wait_for(&folder.join(RECENT_LOCK))?;
    let mut designs = read_recent(folder).unwrap_or_default();
    change(&mut designs);
    write_bytes(&folder.join(RECENT), recent_file::write(&designs).as_bytes())
}

fn read_recent(folder: &Path) -> Result<Vec<PathBuf>, StoreError> {
    let read = read_if_there(&folder.join(RECENT), Kind::RECENT, recent_file::parse)?;
    Ok(read.unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_state_folder_is_the_first_that_is_named() {
        let folder = |variables: &[(&str, &str)]| {
            let variables = variables.to_vec();
            state_folder_of(move |name| {
                let found = variables.iter().find(|(n, _)| *n == name);
                found.map(|(_, value)| OsString::from(value))
            })
        };
        let home = ("HOME", "/home/a");
        let xdg = ("XDG_STATE_HOME", "/state");
        assert_eq!(folder(&[home, xdg, (STATE_VARIABLE, "here")]), Some("here".into()));
        assert_eq!(folder(&[home, xdg]), Some("/state/trackwright".into()));
        assert_eq!(
            folder(&[home, ("XDG_STATE_HOME", "not/absolute"), (STATE_VARIABLE, "")]),
            Some("/home/a/.local/state/trackwright".into())
        );
        assert_eq!(folder(&[]), None);
    }

    #[test]
    fn damaged_preferences_are_named_and_kept_beside() {
        let folder = tempfile::tempdir().unwrap();
        let state = folder.path().join("not/yet");
        let file = state.join(PREFERENCES);
        assert_eq!(read_preferences(&state).unwrap(), None);
        let preferences = Preferences { window: Some([1000, 700]), ..Preferences::default() };
        write_preferences(&state, &preferences).unwrap();
        assert_eq!(read_preferences(&state).unwrap(), Some(preferences.clone()));
        let mistyped = fs::read_to_string(&file).unwrap().replace("scale:", "sacle:");
        let cut = "(version: 1, scale".to_owned();
        for (damaged, named) in [(cut, PREFERENCES), (mistyped, "`sacle`, expected `scale`")] {
            fs::write(&file, &damaged).unwrap();
            let error = read_preferences(&state).unwrap_err().to_string();
            assert!(error.contains(named), "{error}");
            // What was written over a file that can be read is gone.
            for _ in 0..2 {
                write_preferences(&state, &preferences).unwrap();
                assert_eq!(read_preferences(&state).unwrap(), Some(preferences.clone()));
                let kept = fs::read_to_string(state.join(PREFERENCES_BACKUP)).unwrap();
                assert_eq!(kept, damaged);
            }
        }
    }

    /// A folder under a regular file can be made by nobody, root included.
    #[test]
    fn a_state_folder_that_cannot_be_made_is_named() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let folder = file.path().join("state");
        let error = write_preferences(&folder, &Preferences::default()).unwrap_err();
        assert!(error.to_string().contains("cannot be written"), "{error}");
    }

    fn names(folder: &Path) -> Vec<String> {
        let name = |design: RecentDesign| design.file.to_string_lossy().into_owned();
        recent_designs(folder).unwrap().into_iter().map(name).collect()
    }

    #[test]
    fn the_last_ten_are_kept_once_each() {
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
        fs::write(folder.path().join(RECENT), "(").unwrap();
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
