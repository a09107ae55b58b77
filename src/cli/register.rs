//! `register`: points in two frames, and how far off others are to be expected.

use super::numbers::above_zero;
use super::prelude::*;
use nalgebra::Point3;
use std::io::{self, Write};
use trackwright_calibration::doubts;
use trackwright_calibration::judged_registration::{JudgedRegistration, MAX_TURN_ERROR_DEG};
use trackwright_formats::poses;
use trackwright_geometry::number::shortest;
use trackwright_project::Doubted;
use trackwright_report::section_text::section_text;

/// Register points in two frames, and report how far off other points are to be expected
#[derive(Debug, Args)]
pub struct RegisterArgs {
    /// Points in the frame that is moved: a table (CSV: x, y, z), rows of three numbers, points of
    /// 3D Slicer (*.mrk.json or *.fcsv: those that are defined, in RAS as Slicer shows them), or a
    /// ct-fiducials file of the JHU course; mm
    source: PathBuf,

    /// The same points, in the same order, in the frame to which it is moved
    target: PathBuf,

    /// Further points of the source frame, to be moved with an error that is to be expected (TRE)
    #[arg(long, value_name = "POINTS", requires = "output")]
    at: Option<PathBuf>,

    /// Table to write those to: x, y, z in the target frame, and tre_rms_mm
    #[arg(short, long, value_name = "OUT.csv", requires = "at")]
    output: Option<PathBuf>,

    /// Poses table to write the transform to, target from source; `export poses` makes a *.tfm of it
    #[arg(long, value_name = "OUT.csv")]
    transform: Option<PathBuf>,

    /// How well a point was localised, RMS (FLE); estimated from what the registration leaves where
    /// it is left out
    #[arg(long, value_name = "MM", value_parser = above_zero)]
    fle_mm: Option<f64>,

    /// Leave out points that the others contradict: the worst, again and again, as long as fewer than
    /// 1 % of registrations have one so far off by chance (Fisher's F, by the points without it). Four
    /// stay at least
    #[arg(long)]
    leave_out_outliers: bool,

    /// Largest standard error of the turn that is accepted
    #[arg(long, value_name = "DEG", default_value_t = MAX_TURN_ERROR_DEG, value_parser = above_zero)]
    max_turn_error_deg: f64,

    #[command(flatten)]
    common: TableArgs,
}

/// Reads and registers.
///
/// # Errors
/// Files that can't be used, and points that determine no pose, with the reason.
pub fn run(args: &RegisterArgs, files: &Files) -> anyhow::Result<()> {
    let source = args.common.as_is.take(files.read_points(&args.source)?)?;
    let target = args.common.as_is.take(files.read_points(&args.target)?)?;
    let named = || format!("{} and {}", args.source.display(), args.target.display());
    let found = JudgedRegistration::of(&source, &target, args.leave_out_outliers, args.fle_mm)
        .with_context(named)?;
    let suspicions = doubts::of_point_pairs(&source, &target);
    args.common.as_is.take(Doubted::new((), &args.target, suspicions))?;
    let section = found.section();
    output::note_all(&section);
    found.check_turn(args.max_turn_error_deg).with_context(|| args.source.display().to_string())?;
    if let (Some(at), Some(output)) = (&args.at, &args.output) {
        let points = args.common.as_is.take(files.read_points(at)?)?;
        files.output(output)?.write(|out| write_moved(&found, out, &points))?;
    }
    if let Some(file) = &args.transform {
        let pose = [&found.registration.target_from_source];
        files.output(file)?.write(|out| poses::write(out, pose))?;
    }
    args.common.format.print(|| &section, || section_text(&section))
}

fn write_moved(
    found: &JudgedRegistration,
    out: &mut dyn Write,
    points: &[Point3<f64>],
) -> io::Result<()> {
    writeln!(out, "x,y,z,tre_rms_mm")?;
    for point in points {
        let moved = found.registration.target_from_source * point;
        let [x, y, z] = [moved.x, moved.y, moved.z].map(shortest);
        let tre = shortest(found.spread.tre_rms_mm(found.fle_mm, point));
        writeln!(out, "{x},{y},{z},{tre}")?;
    }
    Ok(())
}
