//! This program in a process of its own, on a copy of the open design: what it writes there is what the
//! command line writes, and the window stays as it is.
//!
//! The copy is the design as it is, saved or not, in a folder that lives as long as the work.

use crate::document::file_names::default_file_name;
use bevy::prelude::Resource;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use trackwright_project::{StoreError, World};

/// The program that is started: this one.
#[derive(Resource, Clone, Debug, PartialEq, Eq)]
pub struct OwnProgram(pub PathBuf);

impl Default for OwnProgram {
    fn default() -> Self {
        // Without a path, starting it reports the error.
        Self(std::env::current_exe().unwrap_or_default())
    }
}

/// Why a process wrote nothing.
#[derive(Debug, thiserror::Error)]
pub enum OwnProgramError {
    #[error(transparent)]
    Copy(#[from] StoreError),
    #[error("the program cannot be started: {0}")]
    Start(std::io::Error),
    /// In the words of the command line.
    #[error("{0}")]
    Program(String),
}

/// Runs a command that writes a file; its output. `arguments` gets the copy, which has been opened, and
/// its file. What is there already is replaced: the person was shown that it is.
pub(crate) fn write_by(
    program: &Path,
    mut world: World,
    file: &Path,
    arguments: impl FnOnce(&World, &Path) -> Result<Vec<OsString>, StoreError>,
) -> Result<String, OwnProgramError> {
    let folder = tempfile::tempdir().map_err(OwnProgramError::Start)?;
    let copy = folder.path().join(default_file_name(&world.document));
    trackwright_project::save_as(&mut world, &copy)?;
    let output = Command::new(program)
        .args(arguments(&world, &copy)?)
        .arg("--output")
        .arg(file)
        .args(file.exists().then_some("--overwrite"))
        .stdin(Stdio::null())
        .output()
        .map_err(OwnProgramError::Start)?;
    let [result, complaint] = [output.stdout, output.stderr]
        .map(|bytes| String::from_utf8_lossy(&bytes).trim().to_owned());
    match output.status.success() {
        true => Ok(result),
        false => Err(OwnProgramError::Program(complaint.trim_start_matches("error: ").to_owned())),
    }
}
