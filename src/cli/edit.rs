//! `trackwright [DESIGN]`: the editor, on the built-in design where none is named.

use crate::editor::app;
use crate::editor::preflight::{self, Missing};
use crate::store;
use std::path::Path;

/// How it went with the editor.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Edited {
    /// It was open, and was closed.
    Done,
    /// It cannot open here: the caller does what can be done without it.
    CannotOpen(Missing),
}

/// Opens the editor and stays until its window closes.
///
/// # Errors
/// A design that cannot be opened; that the editor failed.
pub fn edit(design: Option<&Path>) -> anyhow::Result<Edited> {
    let world = match design {
        Some(path) => store::open_design(path)?,
        None => store::open_builtin(store::DEFAULT_BUILTIN)?,
    };
    if let Err(missing) = preflight::window() {
        return Ok(Edited::CannotOpen(missing));
    }
    match app::run(world) {
        bevy::app::AppExit::Success => Ok(Edited::Done),
        bevy::app::AppExit::Error(code) => anyhow::bail!("the editor failed with code {code}"),
    }
}
