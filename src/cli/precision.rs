//! `precision`: error against run time, for every way of computing the same thing.

use super::output::{self, Format};
use anyhow::Context;
use clap::Args;
use std::path::{Path, PathBuf};
use trackwright_accuracy::precision::page::{self, PICTURE};
use trackwright_accuracy::precision::{self, Report, Settings};
use trackwright_project::Files;
use trackwright_task::Task;

/// Parts of the progress bar.
const PROGRESS: u64 = 1000;

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
    let world = match &args.design {
        Some(file) => files.open_design_without_meshes(file)?,
        None => {
            trackwright_project::open_builtin_without_meshes(trackwright_project::DEFAULT_BUILTIN)?
        }
    };
    let design = world.document.design();
    let scenario = trackwright_project::resolve(design, &world.environment);
    if let Some(folder) = &args.output {
        // Before a minute is spent on what could then not be written.
        std::fs::create_dir_all(folder)
            .with_context(|| format!("{}: cannot make the folder", folder.display()))?;
    }
    let bar = output::progress(PROGRESS, "measuring");
    let task = Task::with_progress({
        let bar = bar.clone();
        move |part| bar.set_position((part * PROGRESS as f64) as u64)
    });
    let settings = if args.quick { Settings::quick() } else { Settings::default() };
    let report = precision::run(&scenario, &settings, &task)?;
    bar.finish_and_clear();
    if let Some(folder) = &args.output {
        write(files, &report, &design.name, folder)?;
    }
    match args.format {
        Format::Json => output::print_json(&report.rows().collect::<Vec<_>>()),
        Format::Text => output::print(&as_text(&report, &design.name)),
    }
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
