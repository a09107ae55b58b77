//! `pivot`: where a tool's tip is, from recordings around one point, and which way its shaft points,
//! from recordings of turns about it.

mod spin;

use super::numbers::above_zero;
use super::prelude::*;
use super::tool_reader::ToolReader;
use nalgebra::Point3;
use spin::SpinArgs;
use trackwright_calibration::pivot::{Pivot, PivotLimits, pivot};
use trackwright_formats::points;
use trackwright_result::data;

/// Find where a tool's tip is from recordings around one point, and which way its shaft points
/// from recordings of turns about it, or report why they don't determine it
#[derive(Debug, Args)]
pub struct PivotArgs {
    /// Recordings of one tool around one point: tables of NDI Track or ToolBox (CSV, TSV) or of NDI's
    /// sample of the combined API, an Aurora log, a PLUS sequence (*.igs.mha); 4x4 matrices as text, row by row; a poses table (CSV: x, y,
    /// z, qw, qx, qy, qz); or an empivot or optpivot file of the JHU course, whose tool has the
    /// frame of its markers' mean in the first frame. All in mm
    #[arg(required_unless_present = "spin")]
    recordings: Vec<PathBuf>,

    #[command(flatten)]
    spin: SpinArgs,

    /// The tool that is meant where a recording has several: a part of its name
    #[arg(long, value_name = "NAME")]
    tool: Option<String>,

    /// The tool in whose frame poses are taken, where a recording has several: a part of its name. A
    /// --tool such as StylusToReference means the same
    #[arg(long, value_name = "NAME", requires = "tool", conflicts_with = "environment")]
    relative_to: Option<String>,

    /// Fewest poses that are accepted; 3 are needed
    #[arg(long, value_name = "COUNT", default_value_t = PivotLimits::MIN_POSES)]
    min_poses: usize,

    /// Least angle between the two poses that differ most
    #[arg(long, value_name = "DEG", default_value_t = PivotLimits::MIN_RANGE_DEG, value_parser = above_zero)]
    min_range_deg: f64,

    /// Least RMS turn about the axis that the tool turned about least
    #[arg(long, value_name = "DEG", default_value_t = PivotLimits::MIN_TURN_DEG, value_parser = above_zero)]
    min_turn_deg: f64,

    /// Largest RMS distance of the tip from the point that it rested in
    #[arg(long, value_name = "MM", default_value_t = PivotLimits::MAX_RMS_MM, value_parser = above_zero, requires = "recordings")]
    max_rms_mm: f64,

    /// Room (*.env.ron) that readings are corrected for before anything else
    #[arg(long, value_name = "ENV")]
    environment: Option<PathBuf>,

    /// What happens to readings outside that room's box; of markers, the whole frame is left out
    #[arg(long, value_parser = OUTSIDE, default_value = "clamp", requires = "environment")]
    outside: OutsidePolicy,

    /// Geometry of the JHU course's calibration object (*-calbody.txt), which an optpivot file needs:
    /// its pivot is then in the frame of the EM tracker
    #[arg(long, value_name = "CALBODY")]
    calbody: Option<PathBuf>,

    /// Further recordings of the same tool, such as of fiducials that were touched with it: where the
    /// tip was in each sample goes to --output
    #[arg(long, value_name = "FILE", num_args = 1.., requires = "output")]
    tips: Vec<PathBuf>,

    /// Table to write the tips to: x, y, z in the tracker's frame, mm
    #[arg(short, long, value_name = "OUT.csv", requires = "tips")]
    output: Option<PathBuf>,

    #[command(flatten)]
    common: TableArgs,
}

/// Reads and calibrates.
///
/// # Errors
/// Files that can't be used, and recordings that cannot answer, with the reason.
pub fn run(args: &PivotArgs, files: &Files) -> anyhow::Result<()> {
    let tips_output = files.optional_output(args.output.as_deref())?;
    let tip_frame = files.optional_output(args.spin.tip_frame())?;
    let limits = PivotLimits {
        min_poses: args.min_poses,
        min_range_rad: args.min_range_deg.to_radians(),
        min_turn_rad: args.min_turn_deg.to_radians(),
        max_rms_mm: args.max_rms_mm,
    };
    let mut reader = reader(args, files)?;
    let pivoted = match args.recordings.as_slice() {
        [] => None,
        recordings => {
            let poses = reader.read_all(recordings.iter().map(PathBuf::as_path))?;
            Some(pivot(&poses, &limits).map_err(|error| output::refused("no tip", &error))?)
        }
    };
    let tip = match &pivoted {
        Some(found) => Some((found.tip_in_tool, found.tip_std_error_mm)),
        None => args.spin.tip().map(|tip| (tip, 0.0)),
    };
    let shaft = args.spin.shaft(&mut reader, &limits, tip)?;
    if let Some(output) = &tips_output {
        let Some((tip, _)) = tip else {
            bail!("--tips: found no tip, expected recordings around one point, or --tip X,Y,Z");
        };
        let poses = reader.read_all(args.tips.iter().map(PathBuf::as_path))?;
        let tips: Vec<Point3<f64>> = poses.iter().map(|pose| pose * tip).collect();
        output.write(|out| points::write(out, &tips))?;
    }
    if args.calbody.is_some() && !reader.has_used_base {
        output::note(
            "note: --calbody was not used: no recording has markers of the EM tracker's base",
        );
    }
    SpinArgs::write_tip_frame(tip_frame.as_ref(), shaft.as_ref(), tip.map(|(tip, _)| tip))?;
    let found = pivoted.as_ref().map(Pivot::section).unwrap_or_default();
    let found = match &shaft {
        Some(shaft) => found.noting(shaft.section().notes).with(shaft.section().named("spin")),
        None => found,
    };
    let found = match reader.room {
        Some(_) => found.with(data("compensated", reader.tally.section())),
        None => found,
    };
    output::print_section(args.common.format, &found)
}

fn reader<'a>(args: &PivotArgs, files: &'a Files) -> anyhow::Result<ToolReader<'a>> {
    let mut reader = ToolReader::of_tool(files, args.tool.as_deref(), args.common.as_is);
    reader.reference.clone_from(&args.relative_to);
    if let Some(file) = &args.environment {
        reader.room = Some((files.read_environment(file)?, args.outside));
    }
    if let Some(file) = &args.calbody {
        reader.base = Some(files.read_calbody(file)?.optical_on_base);
    }
    Ok(reader)
}
