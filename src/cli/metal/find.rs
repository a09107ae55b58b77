//! `metal find`: the metal that disturbs a room.

use crate::cli::fit::{HAS_ROLLS, read};
use crate::cli::prelude::*;
use clap::ArgAction;
use trackwright_field::generator::Generator;
use trackwright_field::samples::MeasurementContent;
use trackwright_field::selection::{DEFAULT_FOLDS, DEFAULT_SEED};
use trackwright_metal::identify::compare::compare;
use trackwright_metal::identify::{IdentifySettings, MAX_BODIES, identify, room_of_found};
use trackwright_project::SampleReading;
use trackwright_report::found_metal::metal_section;

#[derive(Debug, Args)]
pub struct FindArgs {
    /// Measurement table (CSV): ideal_x … ideal_qz, measured_x … measured_qz; mm, unit quaternions
    data: PathBuf,

    /// The tracker's field generator: planar-nine, anser, or a file (*.generator.ron)
    #[arg(long, value_name = "NAME|FILE")]
    generator: Option<String>,

    /// Environment to write (*.env.ron): a room of the bodies found, as spheres, to be looked at in the
    /// editor and simulated in
    #[arg(short, long, value_name = "ENV")]
    output: Option<PathBuf>,

    /// Bodies to look for at most, 1 to 3
    #[arg(long, value_name = "N", default_value_t = MAX_BODIES)]
    most: usize,

    /// What the table's quaternions mean
    #[arg(long = "sensors", value_name = "SENSORS", value_parser = HAS_ROLLS, default_value = "5dof",
        action = ArgAction::Set)]
    has_rolls: bool,

    /// Parts that the rows are split into, each held out once
    #[arg(long, value_name = "K", default_value_t = DEFAULT_FOLDS)]
    folds: usize,

    /// Seed of the random folds
    #[arg(long, value_name = "N", default_value_t = DEFAULT_SEED)]
    seed: u64,

    /// Leave out the comparison with other models
    #[arg(long)]
    no_comparison: bool,

    #[command(flatten)]
    common: TableArgs,
}

/// Finds metal and prints it.
///
/// # Errors
/// Files that can't be used, no generator, tables without orientations or with too few rows.
pub fn run(args: &FindArgs, files: &Files) -> anyhow::Result<()> {
    let output = files.optional_output(args.output.as_deref())?;
    if let Some(output) = &output {
        output.expect_own()?;
    }
    let generator = generator(files, args.generator.as_deref())?;
    let named = || args.data.display().to_string();
    // What is suspected of the table is reported as `fit` does.
    read(files, &args.data, SampleReading::of_distortion(args.has_rolls), args.common.as_is)?;
    let mut set = files.read_measurements(&args.data)?;
    if args.has_rolls {
        set.content = MeasurementContent::SixDof;
    }
    let settings = IdentifySettings { most: args.most, folds: args.folds, seed: args.seed };
    let shown = Shown::new("looking for metal");
    let part = if args.no_comparison { 1.0 } else { 0.6 };
    let found = identify(&shown.task.subtask(0.0, part), &generator, &set, &settings)
        .with_context(named)?;
    let compared = match args.no_comparison {
        true => Vec::new(),
        false => compare(&shown.task.subtask(part, 1.0), &generator, &set, &settings, &found)
            .with_context(named)?,
    };
    drop(shown);
    if let Some(output) = &output {
        match room_of_found(&file_name(&args.data), &generator, &set, &found) {
            Some((bare, metal)) => output.write_room(&bare, &metal)?,
            None => output::note("note: no body is determined, no environment was written"),
        }
    }
    let sensors = if set.content == MeasurementContent::SixDof { "6-DOF" } else { "5-DOF" };
    let samples = with_separators(found.measurements);
    let of = format!("{}: {samples} samples, {sensors}", file_name(&args.data));
    let found = metal_section(&of, (&generator, &settings), &found, &compared);
    output::print_section(args.common.format, &found)
}

fn generator(files: &Files, name: Option<&str>) -> anyhow::Result<Generator> {
    let expected = "expected planar-nine, anser, or a file (*.generator.ron)";
    match name {
        None => bail!("found no --generator, {expected}"),
        Some("learn") => bail!(
            "--generator: found \"learn\", {expected}: a generator that is learned from the same table has the metal's part in it"
        ),
        Some(name) => match Generator::built_in(name) {
            Some(generator) => Ok(generator),
            None => files.read_generator(Path::new(name)),
        }
        .map_err(Into::into),
    }
}
