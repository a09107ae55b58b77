//! `distort`: poses as the tracker of an environment would measure them.

use super::prelude::*;
use super::validity::ValidityArgs;
use nalgebra::Point3;
use trackwright_calibration::doubts;
use trackwright_formats::poses::{self, RowPlace};

/// Distort poses as the tracker of an environment would measure them
#[derive(Debug, Args)]
pub struct DistortArgs {
    /// Environment (*.env.ron)
    environment: PathBuf,

    /// Poses of sensors in the tracker frame (CSV): x, y, z, qw, qx, qy, qz; mm, unit quaternions
    poses: PathBuf,

    /// Table to write: the poses as measured, and whether each was outside the model's box
    #[arg(short, long, value_name = "OUT.csv")]
    output: PathBuf,

    /// What happens to positions outside the model's box; rejected ones get empty pose cells
    #[arg(long, value_parser = OUTSIDE, default_value = "clamp")]
    outside: OutsidePolicy,

    #[command(flatten)]
    validity: ValidityArgs,

    #[command(flatten)]
    as_is: AsIsArgs,
}

/// Reads, distorts, and writes the table.
///
/// # Errors
/// Files that can't be used.
pub fn run(args: &DistortArgs, files: &Files) -> anyhow::Result<()> {
    let output = files.output(&args.output)?;
    let environment = files.read_environment(&args.environment)?;
    let room = environment.model.bounds();
    let poses = files.read_poses(&args.poses)?.and(|poses| doubts::in_room(poses, room));
    let ideal = args.as_is.take(poses)?;
    let outside = args.outside;
    let validity = args.validity.at(&environment, &args.environment, &ideal, outside)?;
    let mut outside_count = 0;
    output.write(|out| {
        let rows = ideal.iter().map(|pose| {
            let (measured, is_inside) = environment.model.distort(pose, outside);
            let is_kept = is_inside || outside != OutsidePolicy::Reject;
            outside_count += usize::from(!is_inside);
            let position: Point3<f64> = pose.translation.vector.into();
            let place = RowPlace {
                is_outside: !is_inside,
                is_without_field: !environment.states_field_at(&position),
            };
            (is_kept.then_some(measured), place)
        });
        poses::write_with_outside(out, rows, validity.as_deref())
    })?;
    output::note_outside("poses are", outside_count, ideal.len(), outside);
    Ok(())
}
