//! `import`: measurement tables from other programs' files.

use super::prelude::*;
use clap::Subcommand;
use trackwright_calibration::calibration_object;
use trackwright_calibration::doubts::{PairedDoubts, PoseFrame};
use trackwright_field::selection::clusters;
use trackwright_formats::{groups, measurements};
use trackwright_project::Doubted;

/// Make a measurement table from another program's files
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

    /// Position-only measurement table to write, with a column `frame` for the placements of the
    /// calibration object, and a column `cluster` where the positions come in clusters: rows that
    /// belong together, for `select`
    #[arg(short, long, value_name = "DATA.csv")]
    output: PathBuf,

    #[command(flatten)]
    as_is: AsIsArgs,
}

/// Imports.
///
/// # Errors
/// Files that can't be used, markers that determine no pose.
pub fn run(command: &ImportCommand, files: &Files) -> anyhow::Result<()> {
    let ImportCommand::JhuCis(args) = command;
    let output = files.output(&args.output)?;
    let body = files.read_calbody(&args.calbody)?;
    let frames = files.read_calreadings(&args.calreadings)?;
    let set = calibration_object::measurements(&body, &frames)
        .with_context(|| args.calreadings.display().to_string())?;
    let doubts = PairedDoubts::of(&set.measurements, set.content, PoseFrame::Tracker);
    let set = args.as_is.take(Doubted::new(set, &args.calreadings, doubts))?;
    let frame_of_row: Vec<usize> = frames
        .iter()
        .enumerate()
        .flat_map(|(i, frame)| frame.em_on_object.iter().map(move |_| i))
        .collect();
    let ideal: Vec<_> =
        set.measurements.iter().map(|m| m.tracker_from_ideal.translation.vector.into()).collect();
    let clusters = clusters::find(&ideal);
    let mut columns = vec![("frame", frame_of_row.as_slice())];
    columns.extend(clusters.as_ref().map(|c| ("cluster", c.as_slice())));
    let mut table = Vec::new();
    measurements::write(&mut table, &set)?;
    output.write(|out| groups::write_beside(out, &table, &columns))?;
    let in_clusters = clusters.map_or_else(String::new, |clusters| {
        let count = clusters.iter().max().map_or(0, |last| last + 1);
        format!(" in {} clusters", with_separators(count))
    });
    super::output::print(&format!(
        "{} samples of {} frames{in_clusters} written to {}",
        with_separators(set.measurements.len()),
        with_separators(frames.len()),
        args.output.display()
    ))
}
