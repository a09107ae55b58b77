//! `--as-is`: what commands do with tables that may not be what they are read as; and what commands
//! that read tables have in common.

use super::output::{self, Format};
use anyhow::anyhow;
use clap::Args;
use trackwright_project::{Doubted, StoreError};

/// How tables are taken; an argument of every command that reads one.
#[derive(Args, Clone, Copy, Debug, Default)]
pub(super) struct AsIsArgs {
    /// Take tables as they stand, whatever is suspected of their units, frames, rows and quaternions
    #[arg(long)]
    pub as_is: bool,
}

/// What commands have in common that read tables and print figures.
#[derive(Args, Clone, Copy, Debug)]
pub(super) struct TableArgs {
    #[command(flatten)]
    pub as_is: AsIsArgs,

    /// How to print the figures
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

impl AsIsArgs {
    /// A table's content; what is suspected of it is a warning.
    ///
    /// # Errors
    /// A table that is beyond doubt not what it is read as.
    pub(super) fn take<T>(self, table: Doubted<T>) -> anyhow::Result<T> {
        let taken = table.take(self.as_is, |file, suspicion| {
            output::note(&format!("warning: {}: {suspicion}", file.display()));
        });
        taken.map_err(refused)
    }

    /// The contents of files of one kind; what is suspected of several is reported of the first.
    ///
    /// # Errors
    /// As [`Self::take`].
    pub(super) fn take_all<T>(self, tables: Vec<Doubted<T>>) -> anyhow::Result<Vec<T>> {
        let files = tables.len();
        let mut first = Vec::new();
        let mut taken = Vec::with_capacity(files);
        for table in tables {
            let content = table.take(self.as_is, |file, suspicion| {
                let kind = std::mem::discriminant(suspicion);
                match first.iter_mut().find(|(known, _, _)| *known == kind) {
                    Some((_, _, count)) => *count += 1,
                    None => first.push((kind, format!("{}: {suspicion}", file.display()), 1)),
                }
            });
            taken.push(content.map_err(refused)?);
        }
        for (_, text, count) in first {
            output::note(&match count {
                1 => format!("warning: {text}"),
                _ => format!("warning: {text} (so in {count} of {files} files)"),
            });
        }
        Ok(taken)
    }
}

/// The error with the way out.
pub(super) fn refused(error: StoreError) -> anyhow::Error {
    match error {
        StoreError::Doubted { .. } => anyhow!("{error}; --as-is takes the table as it stands"),
        error => error.into(),
    }
}
