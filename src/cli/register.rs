//! `register`: points in two frames, and how far off others are to be expected.

use super::numbers::above_zero;
use super::prelude::*;
use nalgebra::Point3;
use std::io::{self, Write};
use trackwright_calibration::doubts;
use trackwright_calibration::judged_registration::{JudgedRegistration, MAX_TURN_ERROR_DEG};
use trackwright_formats::poses;
use trackwright_geometry::number::shortest;
use trackwright_geometry::pose::pose_to_array;
use trackwright_project::Doubted;
use trackwright_report::calibration::registration_json;

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
    for suspicion in found.suspicions() {
        output::note(&format!("warning: {suspicion} --leave-out-outliers registers without it"));
    }
    found.check_turn(args.max_turn_error_deg).with_context(|| args.source.display().to_string())?;
    if let (Some(at), Some(output)) = (&args.at, &args.output) {
        let points = args.common.as_is.take(files.read_points(at)?)?;
        files.output(output)?.write(|out| write_moved(&found, out, &points))?;
    }
    if let Some(file) = &args.transform {
        let pose = [&found.registration.target_from_source];
        files.output(file)?.write(|out| poses::write(out, pose))?;
    }
    args.common.format.print(|| registration_json(&found), || as_text(&found))
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

fn as_text(found: &JudgedRegistration) -> String {
    let [x, y, z, quaternion @ ..] = pose_to_array(&found.registration.target_from_source);
    let is_left_out = |index: usize| found.left_out.iter().any(|point| point.index == index);
    let kept = (0..found.residuals_mm.len()).filter(|&k| !is_left_out(k));
    let worst = kept.map(|k| found.residuals_mm[k]).fold(0.0, f64::max);
    let used = found.residuals_mm.len() - found.left_out.len();
    let mut rows = vec![
        count("points", used),
        row("shift to the target frame", format!("{x:.3} {y:.3} {z:.3}"), "mm"),
        row("rotation, scalar first", quaternion.map(|v| format!("{v:.6}")).join(" "), ""),
        mm("left at the points, RMS (FRE)", found.registration.fre_rms_mm),
        mm("  largest", worst),
        mm("localisation of a point, RMS (FLE)", found.fle_mm),
        mm("points from one line, RMS", found.spread.off_line_mm()),
        number("standard error of the rotation about it", found.turn_error_deg(), 3, "deg"),
    ];
    for point in &found.left_out {
        rows.push(mm(format!("point {} left out, off by", point.index + 1), point.off_mm));
    }
    if !found.left_out.is_empty() {
        rows.push(mm("  FRE with all points", found.fre_of_all_mm));
    }
    output::aligned(&rows)
}
