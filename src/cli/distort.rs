//! `distort`: poses as the tracker of an environment would measure them.

use super::prelude::*;
use nalgebra::{Point3, Vector3};
use trackwright_calibration::doubts;
use trackwright_field::gaussian::FieldPoint;
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

    /// Add the model validity: the standard error of each reading (std_error_mm, std_error_deg) and
    /// its 95 % bound (within95_mm, within95_deg), misfit included where the environment keeps its
    /// measurements; else the standard error of the fit alone. Of polynomials also the pose's
    /// leverage on the fit, whether the samples support it (0 or 1), and the distance to the nearest
    /// of them (distance_mm). Cells are empty where nothing is known
    #[arg(long)]
    support: bool,

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
    if args.support && !environment.has_validity() {
        anyhow::bail!(
            "{}: found no `support` and no `process`, expected one of them with --support; `fit` \
             writes both without --no-support",
            args.environment.display()
        );
    }
    let room = environment.model.bounds();
    let poses = files.read_poses(&args.poses)?.and(|poses| doubts::in_room(poses, room));
    let ideal = args.as_is.take(poses)?;
    let outside = args.outside;
    let validity = match args.support {
        false => None,
        true => {
            let each = ideal.iter().map(|pose| FieldPoint {
                position_mm: Point3::from(pose.translation.vector),
                axis: pose.rotation * Vector3::z_axis(),
            });
            let points: Vec<_> = each.collect();
            let validity = environment.validity(&points, outside);
            validity.with_context(|| args.environment.display().to_string())?
        }
    };
    let mut outside_count = 0;
    output.write(|out| {
        let rows = ideal.iter().map(|pose| {
            let (measured, is_inside) = environment.model.distort(pose, outside);
            let is_kept = is_inside || outside != OutsidePolicy::Reject;
            outside_count += usize::from(!is_inside);
            let position = Point3::from(pose.translation.vector);
            let place = RowPlace {
                is_outside: !is_inside,
                is_without_field: !environment.states_field_at(&position),
            };
            (is_kept.then_some(measured), place)
        });
        match validity {
            None => poses::write_with_outside(out, rows),
            Some(validity) => poses::write_with_validity(out, rows.zip(validity)),
        }
    })?;
    output::note_outside("poses are", outside_count, ideal.len(), outside);
    Ok(())
}
