//! `import`: measurement tables from other programs' files.

use crate::calibration::calibration_object;
use crate::formats::measurements;
use crate::store;
use crate::study::figures::with_separators;
use anyhow::Context;
use clap::{Args, Subcommand};
use std::path::PathBuf;

#[derive(Debug, Subcommand)]
pub enum ImportCommand {
    /// From the calibration files of the Johns Hopkins computer-integrated-surgery data sets
    JhuCis(JhuCisArgs),
}

#[derive(Debug, Args)]
pub struct JhuCisArgs {
    /// Geometry of the calibration object (*-calbody.txt)
    calbody: PathBuf,

    /// What both trackers read (*-calreadings.txt)
    calreadings: PathBuf,

    /// Position-only measurement table to write
    #[arg(short, long, value_name = "DATA.csv")]
    output: PathBuf,
}

/// Imports.
///
/// # Errors
/// Files that can't be used, markers that determine no pose.
pub fn run(command: &ImportCommand) -> anyhow::Result<()> {
    let ImportCommand::JhuCis(args) = command;
    let body = store::read_calbody(&args.calbody)?;
    let frames = store::read_calreadings(&args.calreadings)?;
    let set = calibration_object::measurements(&body, &frames)
        .with_context(|| args.calreadings.display().to_string())?;
    store::write_atomic(&args.output, |out| measurements::write(out, &set))?;
    super::output::print(&format!(
        "{} samples of {} frames written to {}",
        with_separators(set.measurements.len()),
        with_separators(frames.len()),
        args.output.display()
    ))
}
