//! `sweep status`: how far a sweep is.

use super::super::prelude::*;
use trackwright_report::sweep_json::status_json;
use trackwright_sweep::{Status, status};

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
    let status = status(&args.folder)?;
    args.format.print(|| status_json(&status), || as_text(&status))
}

fn as_text(status: &Status) -> String {
    let rows = |count: u64| with_separators(count as usize);
    let mut lines = vec![
        row("rows there", format!("{} of {}", rows(status.rows_there), rows(status.rows)), ""),
        row("shards", status.shards.to_string(), ""),
    ];
    if status.torn > 0 {
        lines.push(row("files cut short", status.torn.to_string(), ""));
    }
    lines.extend(status.missing.first().map(|gap| {
        row("first missing rows", format!("{} to {}", rows(gap.start), rows(gap.end - 1)), "")
    }));
    for (state, tasks) in &status.tasks {
        lines.push(row(format!("tasks {}", state.to_lowercase()), tasks.to_string(), ""));
    }
    output::aligned(&lines)
}
