//! `sweep merge`: all rows of a folder in one file.

use super::super::prelude::*;
use trackwright_sweep::{Folder, merge};

#[derive(Debug, Args)]
pub(super) struct MergeArgs {
    /// Folder that `sweep` wrote
    folder: PathBuf,

    /// Table to write (*.parquet)
    #[arg(short, long, value_name = "OUT.parquet")]
    output: PathBuf,

    /// How to print what was done
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Merges a folder's shards.
///
/// # Errors
/// Rows that are missing or there twice, a shard of another plan.
pub(super) fn run(args: &MergeArgs, files: &Files) -> anyhow::Result<()> {
    let output = files.output(&args.output)?;
    let (sweep, folder) = Folder::existing(&args.folder)?;
    sweep.inputs().iter().try_for_each(|file| files.input(file))?;
    let shown = Shown::new("merging");
    let report = merge(&sweep, &folder, &output, &shown.task)?;
    drop(shown);
    output::print_section(args.format, &report.section(&args.output))
}
