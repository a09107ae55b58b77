//! `sweep status`: how far a sweep is.

use super::super::prelude::*;
use trackwright_sweep::status;

#[derive(Debug, Args)]
pub(super) struct StatusArgs {
    /// Folder that `sweep` wrote
    folder: PathBuf,

    /// How to print it
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Prints which rows are there.
///
/// # Errors
/// A folder that is none of a sweep.
pub(super) fn run(args: &StatusArgs) -> anyhow::Result<()> {
    output::print_section(args.format, &status(&args.folder)?.section())
}
