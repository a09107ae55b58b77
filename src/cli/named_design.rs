//! A design by its file or by the name of a built-in one.

use crate::store::{self, StoreError, World};
use std::path::Path;

/// Opens a file, or a built-in design where no file has that name.
///
/// # Errors
/// Those of opening it.
pub fn open_named(design: &Path) -> Result<World, StoreError> {
    match builtin_name(design) {
        Some(name) => store::open_builtin(name),
        None => store::open_design(design),
    }
}

/// The same for its numbers alone.
///
/// # Errors
/// Those of opening it.
pub fn open_named_without_meshes(design: &Path) -> Result<World, StoreError> {
    match builtin_name(design) {
        Some(name) => store::open_builtin_without_meshes(name),
        None => store::open_design_without_meshes(design),
    }
}

fn builtin_name(design: &Path) -> Option<&'static str> {
    let name = design.to_string_lossy();
    let mut names = store::builtin_names();
    names.find(|builtin| !design.exists() && *builtin == name)
}
