//! `compensate`: measured poses corrected, and what became of them.

use super::prelude::*;
use super::validity::ValidityArgs;
use clap::ValueEnum;
use nalgebra::Point3;
use trackwright_calibration::doubts;
use trackwright_field::Environment;
use trackwright_field::compensation::{Compensated, Compensation, Method};
use trackwright_field::inverse::InverseState;
use trackwright_field::samples::MapKind;
use trackwright_formats::poses::{self, CompensatedRow, RowPlace};
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
    validity: ValidityArgs,

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
    let shown = Shown::new("compensating");
    let outcome =
        Compensation::of(&environment.model, &measured, args.outside, method, &shown.task)?;
    drop(shown);
    // The field is a function of the measured pose in a correction map, of the ideal one in another.
    let is_correction = method == Method::Correction;
    let each = outcome.answers.iter().zip(&measured);
    let at = each.map(|(found, measured)| match found.pose {
        Some(pose) if !is_correction => pose,
        _ => *measured,
    });
    let at: Vec<_> = at.collect();
    let validity = args.validity.at(&environment, &args.environment, &at, args.outside)?;
    output.write(|out| {
        let each = outcome.answers.iter().zip(&measured);
        let rows = each.map(|(found, measured)| row(&environment, found, measured));
        poses::write_compensated(out, rows, validity.as_deref())
    })?;
    output::note_outside("poses are", outcome.tally.outside, measured.len(), args.outside);
    let by = format!("by {}, written to {}", outcome.method.about(), args.output.display());
    output::print_section(args.common.format, &outcome.section().with(by))
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
            wanted.name()
        );
    }
    Ok(wanted)
}

/// An answer as a row; where the sensor is is known of the answer, else of the reading.
fn row(environment: &Environment, found: &Compensated, measured: &Pose) -> CompensatedRow {
    let position = Point3::from(found.pose.as_ref().unwrap_or(measured).translation.vector);
    CompensatedRow {
        pose: found.pose,
        place: RowPlace {
            is_outside: !found.is_inside,
            is_without_field: !environment.states_field_at(&position),
        },
        is_ambiguous: matches!(found.state, InverseState::Ambiguous(_)),
    }
}
