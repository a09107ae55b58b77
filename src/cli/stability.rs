//! `stability`: the battery of stiff and extreme cases.

use super::prelude::*;
use trackwright_accuracy::stability::case::{Extent, Methods, Row};
use trackwright_accuracy::stability::{families, page, run as run_battery};

/// Check the program's own numbers in stiff and extreme cases against 192 bits;
/// exit status 1 where a bound is broken
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

/// Runs the battery, prints every row, and reports whether all hold.
///
/// # Errors
/// A folder that cannot be written.
pub fn run(args: &StabilityArgs, files: &Files) -> anyhow::Result<Ending> {
    output::make_folder(args.output.as_deref())?;
    let shown = Shown::new("stability");
    let families = families(if args.quick { Extent::Reduced } else { Extent::Full });
    let rows = run_battery(&families, &Methods::OWN, &shown.task)?;
    drop(shown);
    if let Some(folder) = &args.output {
        write(files, folder, "stability.md", page::markdown(&families, &rows).as_bytes())?;
        write(files, folder, "stability.json", serde_json::to_string_pretty(&rows)?.as_bytes())?;
        write(files, folder, "stability.csv", &page::csv(&rows)?)?;
    }
    args.format.print(|| &rows, || page::text(&rows))?;
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
