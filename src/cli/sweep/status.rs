//! `sweep status`: how far a sweep is.

use super::super::prelude::*;
use std::collections::BTreeMap;
use trackwright_sweep::{Folder, slurm};

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
    let (sweep, folder) = Folder::existing(&args.folder)?;
    let coverage = folder.coverage()?;
    let missing = coverage.missing(0..sweep.rows());
    let mut states: BTreeMap<String, usize> = BTreeMap::new();
    for (_, state) in slurm::queue(&folder)?.tasks {
        *states.entry(state).or_default() += 1;
    }
    let ranges = || missing.iter().map(|rows| [rows.start, rows.end]).collect::<Vec<_>>();
    args.format.print(
        || {
            json!({
                "rows": sweep.rows(), "rows_there": coverage.rows(), "shards": coverage.shards.len(),
                "torn": coverage.torn.len(), "missing": ranges(), "slurm": states,
            })
        },
        || {
            let rows = |count: u64| with_separators(count as usize);
            let mut lines = vec![
                row("rows there", format!("{} of {}", rows(coverage.rows()), rows(sweep.rows())), ""),
                row("shards", coverage.shards.len().to_string(), ""),
            ];
            if !coverage.torn.is_empty() {
                lines.push(row("files cut short", coverage.torn.len().to_string(), ""));
            }
            lines.extend(missing.first().map(|gap| {
                let last = rows(gap.end - 1);
                row("first missing rows", format!("{} to {last}", rows(gap.start)), "")
            }));
            for (state, tasks) in &states {
                lines.push(row(format!("tasks {}", state.to_lowercase()), tasks.to_string(), ""));
            }
            output::aligned(&lines)
        },
    )
}
