//! `generator learn`: the coils that explain a tracker's measurements.

use super::fit::read;
use super::model_kind::checked_degree;
use super::prelude::*;
use clap::Subcommand;
use trackwright_field::harmonic::{LearnSettings, learn};
use trackwright_field::samples::MeasurementSet;
use trackwright_project::SampleReading;
use trackwright_report::room_section::learned_section;
use trackwright_result::Section;

/// Learn the field generator of a tracker from its measurements
#[derive(Debug, Subcommand)]
pub enum GeneratorCommand {
    /// Learn the effective field generator from measurements of one room or several
    Learn(LearnArgs),
}

#[derive(Debug, Args)]
pub struct LearnArgs {
    /// Measurement tables (CSV) of the same generator: ideal_x … ideal_qz, measured_x … measured_qz;
    /// mm, unit quaternions
    #[arg(required = true, value_name = "DATA")]
    data: Vec<PathBuf>,

    /// Generator to write (*.generator.ron)
    #[arg(short, long, value_name = "GENERATOR")]
    output: PathBuf,

    /// Degree of the room's harmonics while learning; from the number of measurements where left out
    #[arg(long, value_name = "L")]
    degree: Option<usize>,

    /// Measurements to learn from at most; more are thinned evenly
    #[arg(long, value_name = "N", default_value_t = LearnSettings::default().max_rows)]
    rows: usize,

    #[command(flatten)]
    common: TableArgs,
}

/// Learns a generator and writes it.
///
/// # Errors
/// Files that can't be used, too few measurements, tables without orientations.
pub fn run(command: &GeneratorCommand, files: &Files) -> anyhow::Result<()> {
    let GeneratorCommand::Learn(args) = command;
    let output = files.output(&args.output)?;
    output.expect_own()?;
    let degree = checked_degree(args.degree)?;
    let mut all: Option<MeasurementSet> = None;
    for file in &args.data {
        let set = read(files, file, SampleReading::of_distortion(false), args.common.as_is)?
            .measurements();
        match &mut all {
            None => all = Some(set),
            Some(all) if all.content != set.content => {
                bail!("{}: found no orientations, expected them as in the others", file.display())
            }
            Some(all) => all.measurements.extend(set.measurements),
        }
    }
    let set = all.context("found no table")?;
    let settings = LearnSettings { degree, max_rows: args.rows, ..LearnSettings::default() };
    let shown = Shown::new("learning");
    let name = file_name(&args.output);
    let name = name.split('.').next().unwrap_or(&name);
    let names: Vec<_> = args.data.iter().map(|file| file_name(file)).collect();
    let learned = learn(&shown.task, name, &set, &settings).with_context(|| names.join(", "))?;
    drop(shown);
    output.write_generator(&learned.generator)?;
    if !learned.has_converged {
        output::note(&format!(
            "note: learning ended after {} steps, before a step brought no more",
            learned.last_steps
        ));
    }
    let found = Section::default()
        .with(learned_section(&learned).headed(format!("{}:", names.join(", "))))
        .with(format!("written to {}", args.output.display()));
    output::print_section(args.common.format, &found)
}
