//! A design as an argument: a file, or the name of a built-in one.

use crate::store::{self, World};
use std::path::Path;

/// A file, or a built-in design where no file has that name.
///
/// # Errors
/// Files that cannot be used.
pub fn open_design_or_builtin(design: &Path) -> anyhow::Result<World> {
    let name = design.to_string_lossy();
    if !design.exists() && store::builtin_names().any(|builtin| builtin == name) {
        return Ok(store::open_builtin(&name)?);
    }
    Ok(store::open_design(design)?)
}
