//! `trackwright [DESIGN]`: the editor, on the built-in design where none is named.

use super::output;
use std::path::Path;
use trackwright_editor::app;
use trackwright_editor::app::measure;
use trackwright_editor::app::measure::process::Started;
use trackwright_editor::app::preflight::{self, Missing};
use trackwright_editor::runner::diagnostics::ExplainLine;

/// How it went with the editor.
pub enum Opened {
    /// It was open, and its window was closed.
    Closed,
    /// It cannot open here: the caller does what can be done without it.
    Missing(Missing),
}

/// Opens the editor and stays until its window closes. With `explain` it reports what is drawn and
/// computed on standard error, with `controls` also where each control is.
///
/// # Errors
/// A design that cannot be opened; that the editor failed.
pub fn run(design: Option<&Path>, explain: bool, controls: bool) -> anyhow::Result<Opened> {
    let world = match design {
        Some(path) => trackwright_project::open_design_to_show(path)?,
        None => trackwright_project::open_builtin(trackwright_project::DEFAULT_BUILTIN)?,
    };
    let _display = match preflight::window() {
        Ok(display) => display,
        Err(missing) => return Ok(Opened::Missing(missing)),
    };
    let explain: Option<ExplainLine> = explain.then(|| Box::new(output::note) as ExplainLine);
    app::edit(world, explain, controls)?;
    Ok(Opened::Closed)
}

/// Measures what a hand waits for in the editor, in a window that closes by itself; prints the
/// figures on standard output.
///
/// # Errors
/// No display or adapter; that the window failed, or was closed too early.
pub fn measure() -> anyhow::Result<()> {
    let started = Started::of_process();
    let _display = preflight::window()?;
    output::print(&measure::text(&measure::measure(started)?))
}
