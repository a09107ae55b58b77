//! A design by its file or by the name of a built-in one.

use crate::store::{self, StoreError, World};
use std::path::Path;

/// Opens a file, or a built-in design where no file has that name.
///
/// # Errors
/// Those of opening it.
pub fn open_named(design: &Path) -> Result<World, StoreError> {
    let name = design.to_string_lossy();
    if !design.exists() && store::builtin_names().any(|builtin| builtin == name) {
        return store::open_builtin(&name);
    }
    store::open_design(design)
}
