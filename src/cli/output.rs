//! What all commands share: formats, policies, tables of text, notes, and progress.

use super::choice::Choice;
use anyhow::{Context, anyhow};
use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use std::io::{IsTerminal, Write};
use std::path::Path;
use trackwright_field::OutsidePolicy;
use trackwright_formats::printable::printable;
use trackwright_formats::printable::{printable_json, printable_lines};
use trackwright_report::section_text::section_text;
use trackwright_result::{Refusal, Remedy, Section, with_separators};
use trackwright_task::Task;

/// How a command that did its work ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    Done,
    /// It did what was requested, and the result is that something does not hold.
    DoesNotHold,
    /// It was cancelled; what it has written stays.
    Interrupted,
}

impl From<()> for Ending {
    fn from((): ()) -> Self {
        Self::Done
    }
}

/// How figures are printed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// For a person
    #[default]
    Text,
    /// For a program
    Json,
}

impl Format {
    /// Prints a result in this format.
    ///
    /// # Errors
    /// Standard output that cannot be written.
    pub fn print<J: Serialize>(
        self,
        json: impl FnOnce() -> J,
        text: impl FnOnce() -> String,
    ) -> anyhow::Result<()> {
        match self {
            Self::Json => print_json(&json()),
            Self::Text => print(&text()),
        }
    }
}

/// Prints a result in a format, and its notes beside it.
///
/// # Errors
/// Standard output that cannot be written.
pub fn print_section(format: Format, found: &Section) -> anyhow::Result<()> {
    note_all(found);
    format.print(|| found, || section_text(found))
}

/// The notes of a result.
pub fn note_all(found: &Section) {
    for reserve in &found.notes {
        let start = if reserve.is_warning { "warning: " } else { "" };
        note(&format!("{start}{}", reserve.sentence(Remedy::as_option)));
    }
}

/// Why there is no result, with the option that lifts the refusal.
pub fn refused(what: &str, error: &impl Refusal) -> anyhow::Error {
    anyhow!("{what}: {}", error.with_remedy(Remedy::as_option))
}

/// What happens to positions outside the model's box.
pub const OUTSIDE: Choice<OutsidePolicy> = Choice(&[
    ("clamp", "The nearest point of the box stands for them", OutsidePolicy::Clamp),
    ("extrapolate", "The polynomial is used as it is", OutsidePolicy::Extrapolate),
    ("reject", "They are left out and counted", OutsidePolicy::Reject),
]);

/// Prints a result to standard output; nothing else goes there. What of it a terminal would obey, or
/// nobody would see, is escaped.
pub fn print(text: &str) -> anyhow::Result<()> {
    print_as_it_is(&printable_lines(text))
}

fn print_as_it_is(text: &str) -> anyhow::Result<()> {
    let mut out = std::io::stdout().lock();
    match writeln!(out, "{text}").and_then(|()| out.flush()) {
        // A reader that has had enough (`| head`) is no failure.
        Err(e) if e.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        other => other.context("standard output cannot be written"),
    }
}

/// Prints a result as JSON, whose strings are those of the files.
pub fn print_json(value: &impl Serialize) -> anyhow::Result<()> {
    print_as_it_is(&printable_json(&serde_json::to_string_pretty(value)?))
}

/// Prints a note beside the result, on standard error, as [`print()`] does.
pub fn note(text: &str) {
    // Nowhere to print it is no reason to fail.
    let _ = writeln!(std::io::stderr(), "{}", printable_lines(text));
}

/// Reports how many of the positions that a room was evaluated at are outside its box, which the
/// printed figures do not show, and what stood for the field there; nothing where none is. `what`
/// goes on to the verb: "poses are".
pub fn note_outside(what: &str, outside: usize, of: usize, policy: OutsidePolicy) {
    if outside == 0 {
        return;
    }
    let (kind, then) = match policy {
        OutsidePolicy::Clamp => ("warning", "the nearest point of the box stands for them"),
        OutsidePolicy::Extrapolate => ("warning", "the model is extrapolated there"),
        OutsidePolicy::Reject => ("note", "they are left out"),
    };
    note(&format!(
        "{kind}: {} of {} {what} outside the room's box: {then}",
        with_separators(outside),
        with_separators(of)
    ));
}

/// What figures are of: a design in a room, whatever these are called in one line.
pub fn head(design: &str, room: &str) -> String {
    format!("{} in {}", printable(design), printable(room))
}

/// Makes the folder that results go to: before minutes are spent on what could then not be written.
///
/// # Errors
/// A folder that cannot be made.
pub fn make_folder(folder: Option<&Path>) -> anyhow::Result<()> {
    match folder {
        Some(folder) => std::fs::create_dir_all(folder)
            .with_context(|| format!("{}: cannot make the folder", folder.display())),
        None => Ok(()),
    }
}

/// A progress bar on a terminal's standard error, and nothing anywhere else.
pub fn progress(len: u64, what: &'static str) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{msg} {wide_bar} {human_pos}/{human_len} {eta}")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(len).with_style(style).with_message(what)
}

/// Steps of a bar that receives parts of the whole.
const STEPS: u64 = 1000;

/// Work with a progress bar that is there as long as this is.
pub struct Shown {
    pub task: Task,
    bar: ProgressBar,
}

impl Shown {
    pub fn new(what: &'static str) -> Self {
        let bar = progress(STEPS, what);
        let task = Task::with_progress({
            let bar = bar.clone();
            move |part| bar.set_position((part * STEPS as f64) as u64)
        });
        Self { task, bar }
    }

    /// What is going on, from now on.
    pub fn set_message(&self, what: String) {
        self.bar.set_message(what);
    }
}

impl Drop for Shown {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_with_a_line_end_stays_in_its_line() {
        let name = "a\nrequirement  met\u{202e}";
        assert_eq!(head(name, "room"), r"a\u{a}requirement  met\u{202e} in room");
    }
}
