//! Where the program keeps what belongs to no design: recovery files, recent designs.

use std::ffi::OsString;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Names the state folder itself, before anything else is asked.
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
pub(super) fn create_private_folder(folder: &Path) -> io::Result<()> {
    let mut builder = fs::DirBuilder::new();
    builder.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(folder)
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
}
