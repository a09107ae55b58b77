//! The built-in world, embedded in the program: designs, and all that they refer to.

use super::error::StoreError;
use std::path::{Path, PathBuf};

/// What opens where no file is named.
pub const DEFAULT_BUILTIN: &str = "pointer-on-head";

const NAMES: [&str; 3] = ["pointer-on-head", "shaver-on-head", "endoscope"];

/// A file of the repository by its path there.
macro_rules! embedded {
    ($($path:literal),* $(,)?) => {
        &[$(($path, include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/", $path)))),*]
    };
}

const FILES: &[(&str, &[u8])] = embedded![
    "designs/pointer-on-head.design.ron",
    "designs/shaver-on-head.design.ron",
    "designs/endoscope.design.ron",
    "assets/bodies/pointer.body.ron",
    "assets/bodies/shaver.body.ron",
    "assets/bodies/endoscope.body.ron",
    "assets/bodies/head-crf.body.ron",
    "assets/environments/operating-table.env.ron",
];

/// The built-in designs' names.
pub fn builtin_names() -> impl Iterator<Item = &'static str> {
    NAMES.into_iter()
}

/// The embedded file at a path without dots.
pub(super) fn bytes(path: &Path) -> Option<&'static [u8]> {
    FILES
        .iter()
        .find(|(name, _)| Path::new(name) == path)
        .map(|(_, bytes)| *bytes)
}

/// A built-in design's own spelling of its name, and its file.
pub(super) fn design_file(name: &str) -> Result<(&'static str, PathBuf), StoreError> {
    let name = NAMES
        .into_iter()
        .find(|n| *n == name)
        .ok_or_else(|| StoreError::NoSuchBuiltIn {
            name: name.to_owned(),
            names: NAMES.join(", "),
        })?;
    Ok((name, PathBuf::from(format!("designs/{name}.design.ron"))))
}
