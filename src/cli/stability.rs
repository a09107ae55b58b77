//! `stability`: the battery of stiff and extreme cases.

use super::Ending;
use super::output::{self, Format};
use anyhow::Context;
use clap::Args;
use std::path::{Path, PathBuf};
use trackwright_accuracy::stability::methods::Own;
use trackwright_accuracy::stability::row::Row;
use trackwright_accuracy::stability::{Extent, families, page, run as run_battery};
use trackwright_project::Files;
use trackwright_task::Task;

#[derive(Debug, Args)]
pub struct StabilityArgs {
    /// Folder to write stability.md, stability.json and stability.csv to; made where it isn't there
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,

    /// The smaller cases of every family alone: seconds instead of minutes
    #[arg(long)]
    quick: bool,

    /// How to print the rows
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Steps of the progress bar.
const PROGRESS_STEPS: u64 = 1000;

/// Runs the battery, prints every row, and says whether all hold.
///
/// # Errors
/// A folder that cannot be written.
pub fn run(args: &StabilityArgs, files: &Files) -> anyhow::Result<Ending> {
    // Before the minutes, not after them.
    if let Some(folder) = &args.output {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("{}: cannot be made", folder.display()))?;
    }
    let bar = output::progress(PROGRESS_STEPS, "stability");
    let task = Task::with_progress({
        let bar = bar.clone();
        move |part| bar.set_position((part * PROGRESS_STEPS as f64) as u64)
    });
    let families = families(if args.quick { Extent::Reduced } else { Extent::Full });
    let rows = run_battery(&families, &Own, &task)?;
    bar.finish_and_clear();
    if let Some(folder) = &args.output {
        write(files, folder, "stability.md", page::markdown(&families, &rows).as_bytes())?;
        write(files, folder, "stability.json", serde_json::to_string_pretty(&rows)?.as_bytes())?;
        write(files, folder, "stability.csv", &page::csv(&rows)?)?;
    }
    match args.format {
        Format::Json => output::print_json(&rows)?,
        Format::Text => output::print(&page::text(&rows))?,
    }
    Ok(ending(&rows))
}

fn ending(rows: &[Row]) -> Ending {
    if rows.iter().all(|r| r.holds) { Ending::Done } else { Ending::DoesNotHold }
}

fn write(files: &Files, folder: &Path, name: &str, bytes: &[u8]) -> anyhow::Result<()> {
    Ok(files.output(&folder.join(name))?.write_bytes(bytes)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_row_that_does_not_hold_is_the_answer() {
        let good = Row::behaviour("case", "holds", true);
        let bad = Row::behaviour("case", "holds", false);
        assert_eq!(ending(&[good.clone(), good.clone()]), Ending::Done);
        assert_eq!(ending(&[good, bad]), Ending::DoesNotHold);
    }
}
