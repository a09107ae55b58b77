//! Preferences in the state folder.

use super::error::StoreError;
use super::place::{Kind, Place};
use super::read::read;
use super::state::create_private_folder;
use super::write::write_bytes;
use std::fs;
use std::io;
use std::path::Path;
use trackwright_formats::preferences_file::{self, Preferences};

const FILE: &str = "preferences.ron";
const BACKUP: &str = "preferences.ron.bak";

/// How a person left the window; `None` where nobody did yet.
///
/// # Errors
/// See [`StoreError`]: a file that is damaged, or that a later version of the program wrote.
pub fn read_preferences(folder: &Path) -> Result<Option<Preferences>, StoreError> {
    let parse = preferences_file::parse;
    match read(Place::Disk, &folder.join(FILE), Kind::PREFERENCES, parse) {
        Err(StoreError::Read { cause, .. }) if cause.kind() == io::ErrorKind::NotFound => Ok(None),
        preferences => preferences.map(Some),
    }
}

/// Writes preferences, whole or not at all. Of two windows the one that wrote last is right. A file
/// that cannot be used, as with a field that is mistyped, is kept beside as `preferences.ron.bak`.
///
/// # Errors
/// [`StoreError::Write`].
pub fn write_preferences(folder: &Path, preferences: &Preferences) -> Result<(), StoreError> {
    create_private_folder(folder)
        .map_err(|cause| StoreError::Write { file: folder.to_owned(), cause })?;
    let file = folder.join(FILE);
    if let Err(StoreError::Format { .. }) = read_preferences(folder) {
        fs::rename(&file, folder.join(BACKUP))
            .map_err(|cause| StoreError::Write { file: file.clone(), cause })?;
    }
    let text = preferences_file::write(preferences);
    write_bytes(&file, text.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn preferences_outlast_a_session_and_a_damaged_file_is_named_and_written_anew() {
        let folder = tempfile::tempdir().unwrap();
        let state = folder.path().join("not/yet");
        assert_eq!(read_preferences(&state).unwrap(), None);
        let preferences = Preferences { window: Some([1000, 700]), ..Preferences::default() };
        write_preferences(&state, &preferences).unwrap();
        assert_eq!(read_preferences(&state).unwrap(), Some(preferences));
        fs::write(state.join(FILE), "(version: 1, scale").unwrap();
        let error = read_preferences(&state).unwrap_err().to_string();
        assert!(error.contains(FILE), "{error}");
        write_preferences(&state, &Preferences::default()).unwrap();
        assert!(read_preferences(&state).unwrap().is_some());
        let kept = fs::read_to_string(state.join(BACKUP)).unwrap();
        assert_eq!(kept, "(version: 1, scale");
        // What was written over a file that can be read is gone.
        write_preferences(&state, &Preferences::default()).unwrap();
        assert_eq!(fs::read_to_string(state.join(BACKUP)).unwrap(), kept);
    }

    #[test]
    fn mistyped_preferences_are_named_and_kept_beside() {
        let folder = tempfile::tempdir().unwrap();
        let preferences = Preferences::default();
        write_preferences(folder.path(), &preferences).unwrap();
        let file = folder.path().join(FILE);
        let mistyped = fs::read_to_string(&file).unwrap();
        let mistyped = mistyped.replace("scale:", "sacle:");
        fs::write(&file, &mistyped).unwrap();
        let error = read_preferences(folder.path()).unwrap_err().to_string();
        assert!(error.contains("`sacle`, expected `scale`"), "{error}");
        write_preferences(folder.path(), &preferences).unwrap();
        assert_eq!(read_preferences(folder.path()).unwrap(), Some(preferences));
        let kept = fs::read_to_string(folder.path().join(BACKUP)).unwrap();
        assert_eq!(kept, mistyped);
    }

    /// A folder under a regular file can be made by nobody, root included.
    #[test]
    fn a_state_folder_that_cannot_be_made_is_an_error_that_names_it() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let folder = file.path().join("state");
        let error = write_preferences(&folder, &Preferences::default()).unwrap_err();
        assert!(error.to_string().contains("cannot be written"), "{error}");
    }
}
