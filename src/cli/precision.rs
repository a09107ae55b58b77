//! `precision`: error against run time, for every way of computing the same thing.

use super::named_design::named_or_builtin;
use super::prelude::*;
use trackwright_accuracy::precision::page::{self, PICTURE};
use trackwright_accuracy::precision::{self, Report, Settings};

/// Measure error against run time, for every way of computing the same thing
#[derive(Debug, Args)]
pub struct PrecisionArgs {
    /// Design whose room and study are measured (*.design.ron); the built-in one where none is named
    design: Option<PathBuf>,

    /// Folder to write precision.md, its pictures, precision.csv and precision.json to
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,

    /// A first look within seconds: few poses and samples, each timed once
    #[arg(long)]
    quick: bool,

    /// How to print the figures
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Measures, writes the page, and prints the table.
///
/// # Errors
/// A design that can't be used, a folder that can't be written to.
pub fn run(args: &PrecisionArgs, files: &Files) -> anyhow::Result<()> {
    let world = named_or_builtin(files, args.design.as_deref())?;
    let design = world.document.design();
    let scenario = trackwright_project::resolve(design, &world.environment);
    output::make_folder(args.output.as_deref())?;
    let shown = Shown::new("measuring");
    let settings = if args.quick { Settings::quick() } else { Settings::default() };
    let report = precision::run_each(&scenario, &settings, &shown.task, |_| ())?;
    drop(shown);
    if let Some(folder) = &args.output {
        write(files, &report, &design.name, folder)?;
    }
    args.format.print(|| report.rows().collect::<Vec<_>>(), || as_text(&report, &design.name))
}

fn write(files: &Files, report: &Report, design: &str, folder: &Path) -> anyhow::Result<()> {
    let put = |name: &str, bytes: &[u8]| files.output(&folder.join(name))?.write_bytes(bytes);
    for family in report.families.iter().filter(|f| f.left_out.is_none()) {
        let svg = page::chart(family).to_svg(PICTURE);
        put(&family.what.picture(), svg.as_bytes())?;
    }
    put("precision.csv", &page::csv(report)?)?;
    let json = serde_json::to_string_pretty(&report.rows().collect::<Vec<_>>())?;
    put("precision.json", json.as_bytes())?;
    put("precision.md", page::markdown(report, design).as_bytes())?;
    Ok(())
}

fn as_text(report: &Report, design: &str) -> String {
    let mut parts = vec![format!(
        "{design} in {}\n{}\n• on the front of its problem, ◎ the default\n",
        report.room,
        page::machine(&report.machine)
    )];
    parts.extend(report.families.iter().map(page::family_text));
    parts.join("\n").trim_end().to_owned()
}
