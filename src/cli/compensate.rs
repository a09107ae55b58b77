//! `compensate`: measured poses corrected, and what became of them.

use super::prelude::*;
use clap::ValueEnum;
use trackwright_calibration::doubts;
use trackwright_field::DistortionModel;
use trackwright_field::compensation::{Compensated, Difference, Method, Tally, compensate};
use trackwright_field::inverse::InverseState;
use trackwright_field::samples::MapKind;
use trackwright_formats::poses::{self, CompensatedRow};
use trackwright_geometry::pose::Pose;

/// Correct measured poses by the map of an environment, or by the inverse of it
#[derive(Debug, Args)]
pub struct CompensateArgs {
    /// Environment (*.env.ron)
    environment: PathBuf,

    /// Poses of sensors as measured, in the tracker frame (CSV): x, y, z, qw, qx, qy, qz; mm, unit quaternions
    poses: PathBuf,

    /// Table to write: the poses corrected, and whether each was outside the model's box, converged
    /// and is ambiguous; one that did not converge has empty pose cells
    #[arg(short, long, value_name = "OUT.csv")]
    output: PathBuf,

    /// What happens to positions outside the model's box; rejected ones count as not converged in
    /// the table
    #[arg(long, value_parser = OUTSIDE, default_value = "clamp")]
    outside: OutsidePolicy,

    /// How poses are corrected
    #[arg(long, value_enum, default_value_t)]
    method: MethodArg,

    #[command(flatten)]
    common: TableArgs,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum MethodArg {
    /// A correction map directly, a distortion map by its inverse
    #[default]
    Auto,
    /// The poses whose distortion is what was measured; for a distortion map
    Inverse,
    /// The paper's: a distortion map used as if it were a correction map
    Shortcut,
}

/// What one run came to.
struct Outcome {
    method: Method,
    tally: Tally,
    /// The shortcut against the inverse; none for a correction map.
    shortcut: Option<Difference>,
}

/// Reads, corrects, and writes the table.
///
/// # Errors
/// Files that can't be used.
pub fn run(args: &CompensateArgs, files: &Files) -> anyhow::Result<()> {
    let output = files.output(&args.output)?;
    let environment = files.read_environment(&args.environment)?;
    let method = method(args, environment.model.map())?;
    let room = environment.model.bounds();
    let poses = files.read_poses(&args.poses)?.and(|poses| doubts::in_room(poses, room));
    let measured = args.common.as_is.take(poses)?;
    let (compensated, shortcut) = compensated(&environment.model, &measured, args.outside, method)?;
    output.write(|out| poses::write_compensated(out, compensated.iter().map(row)))?;
    let outcome = Outcome { method, tally: Tally::of(&measured, &compensated), shortcut };
    args.common.format.print(|| as_json(&outcome), || as_text(args, &outcome))
}

fn method(args: &CompensateArgs, map: MapKind) -> anyhow::Result<Method> {
    let wanted = match args.method {
        MethodArg::Auto => return Ok(Method::of(map)),
        MethodArg::Inverse => Method::Inverse,
        MethodArg::Shortcut => Method::Shortcut,
    };
    if map == MapKind::Correction {
        bail!(
            "{}: found a correction map, expected a distortion map with --method {}; \
             --method auto applies a correction map as it is",
            args.environment.display(),
            name(wanted)
        );
    }
    Ok(wanted)
}

/// The answers, and for a distortion map how far the shortcut is from the inverse.
fn compensated(
    model: &DistortionModel,
    measured: &[Pose],
    outside: OutsidePolicy,
    method: Method,
) -> anyhow::Result<(Vec<Compensated>, Option<Difference>)> {
    let shown = Shown::new("compensating");
    let by = |method| compensate(model, measured, outside, method, &shown.task);
    Ok(match method {
        Method::Correction => (by(Method::Correction)?, None),
        Method::Inverse | Method::Shortcut => {
            let (inverse, shortcut) = (by(Method::Inverse)?, by(Method::Shortcut)?);
            let difference = Difference::between(&inverse, &shortcut);
            let wanted = if method == Method::Inverse { inverse } else { shortcut };
            (wanted, difference)
        }
    })
}

fn row(found: &Compensated) -> CompensatedRow {
    CompensatedRow {
        pose: found.pose,
        is_outside: !found.is_inside,
        is_ambiguous: matches!(found.state, InverseState::Ambiguous(_)),
    }
}

fn name(method: Method) -> &'static str {
    match method {
        Method::Correction => "correction",
        Method::Inverse => "inverse",
        Method::Shortcut => "shortcut",
    }
}

fn as_json(outcome: &Outcome) -> Value {
    let mut value = tally_as_json(&outcome.tally);
    value["method"] = json!(name(outcome.method));
    value["shortcut_against_inverse"] = json!(outcome.shortcut.map(|d| json!({
        "compared": d.compared,
        "position_rms_mm": d.position_rms_mm,
        "position_max_mm": d.position_max_mm,
        "angle_rms_deg": d.angle_rms_rad.to_degrees(),
        "angle_max_deg": d.angle_max_rad.to_degrees(),
    })));
    value
}

/// What became of readings that were corrected for a room.
pub(super) fn tally_as_json(t: &Tally) -> Value {
    json!({
        "rows": t.rows,
        "converged": t.converged,
        "ambiguous": t.ambiguous,
        "folded": t.folded,
        "not_converged": t.not_converged,
        "rejected": t.rejected,
        "outside": t.outside,
        "largest_correction_mm": t.largest_correction_mm,
        "largest_correction_deg": t.largest_correction_rad.to_degrees(),
    })
}

fn as_text(args: &CompensateArgs, outcome: &Outcome) -> String {
    let t = &outcome.tally;
    let mut rows = vec![
        count("rows", t.rows),
        count("converged", t.converged),
        count("of these ambiguous", t.ambiguous),
        count("folded", t.folded),
        count("not converged", t.not_converged),
        count("rejected", t.rejected),
        count("outside the model's box", t.outside),
        number("largest correction", t.largest_correction_mm, 4, "mm"),
        number("", t.largest_correction_rad.to_degrees(), 4, "°"),
    ];
    if let Some(d) = &outcome.shortcut {
        let (rms, max) = ("shortcut against inverse, RMS", "shortcut against inverse, max");
        rows.extend([
            number(rms, d.position_rms_mm, 6, "mm"),
            number(max, d.position_max_mm, 6, "mm"),
            number(rms, d.angle_rms_rad.to_degrees(), 6, "°"),
            number(max, d.angle_max_rad.to_degrees(), 6, "°"),
        ]);
    }
    format!(
        "{}\nby {}, written to {}",
        output::aligned(&rows),
        match outcome.method {
            Method::Correction => "correction map",
            Method::Inverse => "inverse of the distortion map",
            Method::Shortcut => "shortcut, the distortion map used as a correction",
        },
        args.output.display()
    )
}
