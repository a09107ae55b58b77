//! Programs that others wrote, to check ours against: Python packages that `tests/run` installs.

#![allow(
    dead_code,
    reason = "the files and messages that need it come one after the other"
)]

use std::path::{Path, PathBuf};
use std::process::Command;

/// The Python that has the packages of `tests/peers/requirements.txt`, ready to run one of the
/// scripts beside it.
#[track_caller]
pub fn python(script: &str) -> Command {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = std::env::var_os("TRACKWRIGHT_PEERS")
        .map_or_else(|| root.join("target/peers"), PathBuf::from);
    let python = folder.join("bin/python");
    assert!(
        python.exists(),
        "{} is not there: tests/run installs it",
        python.display()
    );
    let mut command = Command::new(python);
    command.arg("-B").arg(root.join("tests/peers").join(script));
    command
}
