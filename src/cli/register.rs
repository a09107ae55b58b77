//! `register`: points in two frames, and how far off others are to be expected.

use super::numbers::above_zero;
use super::prelude::*;
use nalgebra::Point3;
use std::io::{self, Write};
use trackwright_calibration::doubts;
use trackwright_calibration::fiducial_outliers::{OutlyingPoint, register_without_outliers};
use trackwright_calibration::registration::{Registration, register};
use trackwright_calibration::registration_error::{PointSpread, fle_rms_mm};
use trackwright_formats::poses;
use trackwright_geometry::number::shortest;
use trackwright_geometry::pose::pose_to_array;
use trackwright_project::Doubted;

/// Above this a registration determines a turn so poorly that it is refused by default: a
/// target 50 mm away is off by 9 mm.
const MAX_TURN_ERROR_DEG: f64 = 10.0;

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
    let all = register(&source, &target).with_context(named)?;
    let suspicions = doubts::of_point_pairs(&source, &target);
    args.common.as_is.take(Doubted::new((), &args.target, suspicions))?;
    let (cleaned, outlying) = register_without_outliers(&source, &target).with_context(named)?;
    if !args.leave_out_outliers {
        for point in &outlying {
            output::note(&format!(
                "warning: point {} is {:.2} mm off where the others, without it, leave {:.2} mm RMS: is it an outlier? \
                 --leave-out-outliers registers without it",
                point.index + 1,
                point.off_mm,
                cleaned.fre_rms_mm
            ));
        }
    }
    let (registration, left_out) = match args.leave_out_outliers {
        true => (cleaned, outlying),
        false => (all, Vec::new()),
    };
    let is_used = |index: usize| left_out.iter().all(|point| point.index != index);
    let used: Vec<Point3<f64>> =
        (0..source.len()).filter(|&k| is_used(k)).map(|k| source[k]).collect();
    let fle_mm = args.fle_mm.unwrap_or_else(|| fle_rms_mm(registration.fre_rms_mm, used.len()));
    let found = Registered {
        residuals_mm: source
            .iter()
            .zip(&target)
            .map(|(s, t)| (registration.target_from_source * s - t).norm())
            .collect(),
        registration,
        fre_of_all_mm: all.fre_rms_mm,
        left_out,
        spread: PointSpread::of(&used),
        fle_mm,
    };
    let turn_error_deg = found.spread.turn_std_error_rad(fle_mm).to_degrees();
    // Also where it is not a number.
    if !turn_error_deg.le(&args.max_turn_error_deg) {
        bail!(
            "{}: the points are {:.2} mm RMS from one line and were localised to {fle_mm:.2} mm, so that the rotation \
             about it is known to {turn_error_deg:.1}° only, expected {:.1}° at most; take points farther apart",
            args.source.display(),
            found.spread.off_line_mm(),
            args.max_turn_error_deg
        );
    }
    if let (Some(at), Some(output)) = (&args.at, &args.output) {
        let points = args.common.as_is.take(files.read_points(at)?)?;
        files.output(output)?.write(|out| found.write_moved(out, &points))?;
    }
    if let Some(file) = &args.transform {
        let pose = [&found.registration.target_from_source];
        files.output(file)?.write(|out| poses::write(out, pose))?;
    }
    args.common.format.print(|| found.as_json(), || found.as_text())
}

/// A registration, and what it predicts of other points.
struct Registered {
    registration: Registration,
    /// FRE with the points that were left out.
    fre_of_all_mm: f64,
    left_out: Vec<OutlyingPoint>,
    /// Of all points, those left out too.
    residuals_mm: Vec<f64>,
    /// Of the points that were used, in the source frame.
    spread: PointSpread,
    fle_mm: f64,
}

impl Registered {
    fn write_moved(&self, out: &mut dyn Write, points: &[Point3<f64>]) -> io::Result<()> {
        writeln!(out, "x,y,z,tre_rms_mm")?;
        for point in points {
            let moved = self.registration.target_from_source * point;
            let [x, y, z] = [moved.x, moved.y, moved.z].map(shortest);
            let tre = shortest(self.spread.tre_rms_mm(self.fle_mm, point));
            writeln!(out, "{x},{y},{z},{tre}")?;
        }
        Ok(())
    }

    fn turn_error_deg(&self) -> f64 {
        self.spread.turn_std_error_rad(self.fle_mm).to_degrees()
    }

    fn as_json(&self) -> Value {
        json!({
            "points": self.residuals_mm.len() - self.left_out.len(),
            "target_from_source": pose_to_array(&self.registration.target_from_source),
            "fre_rms_mm": self.registration.fre_rms_mm,
            "residuals_mm": self.residuals_mm,
            "fre_of_all_rms_mm": self.fre_of_all_mm,
            "left_out": self.left_out.iter().map(|point| json!({
                "point": point.index + 1,
                "off_mm": point.off_mm,
                "chance": point.chance,
            })).collect::<Vec<_>>(),
            "fle_rms_mm": self.fle_mm,
            "off_line_mm": self.spread.off_line_mm(),
            "turn_std_error_deg": self.turn_error_deg(),
        })
    }

    fn as_text(&self) -> String {
        let [x, y, z, quaternion @ ..] = pose_to_array(&self.registration.target_from_source);
        let is_left_out = |index: usize| self.left_out.iter().any(|point| point.index == index);
        let kept = (0..self.residuals_mm.len()).filter(|&k| !is_left_out(k));
        let worst = kept.map(|k| self.residuals_mm[k]).fold(0.0, f64::max);
        let used = self.residuals_mm.len() - self.left_out.len();
        let mut rows = vec![
            count("points", used),
            row("shift to the target frame", format!("{x:.3} {y:.3} {z:.3}"), "mm"),
            row("rotation, scalar first", quaternion.map(|v| format!("{v:.6}")).join(" "), ""),
            mm("left at the points, RMS (FRE)", self.registration.fre_rms_mm),
            mm("  largest", worst),
            mm("localisation of a point, RMS (FLE)", self.fle_mm),
            mm("points from one line, RMS", self.spread.off_line_mm()),
            number("standard error of the rotation about it", self.turn_error_deg(), 3, "deg"),
        ];
        for point in &self.left_out {
            rows.push(mm(format!("point {} left out, off by", point.index + 1), point.off_mm));
        }
        if !self.left_out.is_empty() {
            rows.push(mm("  FRE with all points", self.fre_of_all_mm));
        }
        output::aligned(&rows)
    }
}
