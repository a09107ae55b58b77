//! `register`: points in two frames, and how far off others are to be expected.

use super::numbers::above_zero;
use super::output::{self, Format};
use crate::calibration::registration::{Registration, register};
use crate::calibration::registration_error::{PointSpread, fle_rms_mm};
use crate::formats::number::shortest;
use crate::formats::poses;
use crate::geometry::pose::pose_to_array;
use crate::store::Files;
use crate::study::figures::with_separators;
use anyhow::{Context, bail};
use clap::Args;
use nalgebra::Point3;
use serde_json::{Value, json};
use std::io::{self, Write};
use std::path::PathBuf;

/// Above this a registration says so little of a turn that it is refused unless told otherwise: a
/// target 50 mm away is off by 9 mm.
const MAX_TURN_ERROR_DEG: f64 = 10.0;

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

    /// Largest standard error of the turn that is accepted
    #[arg(long, value_name = "DEG", default_value_t = MAX_TURN_ERROR_DEG, value_parser = above_zero)]
    max_turn_error_deg: f64,

    /// How to print the figures
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Reads and registers.
///
/// # Errors
/// Files that can't be used, and points that determine no pose, with the reason.
pub fn run(args: &RegisterArgs, files: &Files) -> anyhow::Result<()> {
    let source = files.read_points(&args.source)?;
    let target = files.read_points(&args.target)?;
    let registration = register(&source, &target)
        .with_context(|| format!("{} and {}", args.source.display(), args.target.display()))?;
    let fle_mm = args
        .fle_mm
        .unwrap_or_else(|| fle_rms_mm(registration.fre_rms_mm, source.len()));
    let found = Registered {
        residuals_mm: source
            .iter()
            .zip(&target)
            .map(|(s, t)| (registration.target_from_source * s - t).norm())
            .collect(),
        registration,
        spread: PointSpread::of(&source),
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
        let points = files.read_points(at)?;
        files
            .output(output)?
            .write(|out| found.write_moved(out, &points))?;
    }
    if let Some(file) = &args.transform {
        let pose = [&found.registration.target_from_source];
        files.output(file)?.write(|out| poses::write(out, pose))?;
    }
    match args.format {
        Format::Json => output::print_json(&found.as_json()),
        Format::Text => output::print(&found.as_text()),
    }
}

/// A registration, and what it says of other points.
struct Registered {
    registration: Registration,
    residuals_mm: Vec<f64>,
    /// Of the points in the source frame.
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
            "points": self.residuals_mm.len(),
            "target_from_source": pose_to_array(&self.registration.target_from_source),
            "fre_rms_mm": self.registration.fre_rms_mm,
            "residuals_mm": self.residuals_mm,
            "fle_rms_mm": self.fle_mm,
            "off_line_mm": self.spread.off_line_mm(),
            "turn_std_error_deg": self.turn_error_deg(),
        })
    }

    fn as_text(&self) -> String {
        let row =
            |label: &str, value: String, unit: &str| (label.to_owned(), value, unit.to_owned());
        let mm = |value: f64| format!("{value:.3}");
        let [x, y, z, quaternion @ ..] = pose_to_array(&self.registration.target_from_source);
        let worst = self.residuals_mm.iter().copied().fold(0.0, f64::max);
        output::aligned(&[
            row("points", with_separators(self.residuals_mm.len()), ""),
            row(
                "shift to the target frame",
                [x, y, z].map(mm).join(" "),
                "mm",
            ),
            row(
                "rotation, scalar first",
                quaternion.map(|v| format!("{v:.6}")).join(" "),
                "",
            ),
            row(
                "left at the points, RMS (FRE)",
                mm(self.registration.fre_rms_mm),
                "mm",
            ),
            row("  largest", mm(worst), "mm"),
            row("localisation of a point, RMS (FLE)", mm(self.fle_mm), "mm"),
            row(
                "points from one line, RMS",
                mm(self.spread.off_line_mm()),
                "mm",
            ),
            row(
                "standard error of the rotation about it",
                format!("{:.3}", self.turn_error_deg()),
                "deg",
            ),
        ])
    }
}
