//! `distort`: poses as the tracker of an environment would measure them.

use super::output::OutsideArg;
use crate::field::{Environment, OutsidePolicy, Support};
use crate::formats::poses;
use crate::store;
use anyhow::Context;
use clap::Args;
use nalgebra::{Point3, Vector3};
use std::path::{Path, PathBuf};

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
    #[arg(long, value_enum, default_value_t)]
    outside: OutsideArg,

    /// Add where the model may be believed: the predicted standard error of the field (std_error_mm,
    /// std_error_deg; empty where it is not determined), the pose's leverage on the fit, whether the
    /// samples support it (0 or 1), and the distance to the nearest of them (distance_mm)
    #[arg(long)]
    support: bool,
}

/// Reads, distorts, and writes the table.
///
/// # Errors
/// Files that can't be used.
pub fn run(args: &DistortArgs) -> anyhow::Result<()> {
    let environment = store::read_environment(&args.environment)?;
    let support = match args.support {
        false => None,
        true => Some(support_of(&environment, &args.environment)?),
    };
    let ideal = store::read_poses(&args.poses)?;
    let outside = OutsidePolicy::from(args.outside);
    store::write_atomic(&args.output, |out| {
        let rows = ideal.iter().map(|pose| {
            let (measured, is_inside) = environment.model.distort(pose, outside);
            let is_kept = is_inside || outside != OutsidePolicy::Reject;
            (is_kept.then_some(measured), !is_inside)
        });
        match support {
            None => poses::write_with_outside(out, rows),
            Some(support) => {
                let believed = ideal.iter().map(|pose| {
                    let axis = pose.rotation * Vector3::z_axis();
                    let position = Point3::from(pose.translation.vector);
                    support.at(&position, &axis, outside)
                });
                poses::write_with_support(out, rows.zip(believed))
            }
        }
    })?;
    Ok(())
}

/// What an environment says of where its model may be believed.
///
/// # Errors
/// It says nothing.
pub(super) fn support_of<'a>(
    environment: &'a Environment,
    file: &Path,
) -> anyhow::Result<&'a Support> {
    environment.support.as_ref().with_context(|| {
        format!(
            "{}: found no `support`, expected it with --support; `fit` writes it unless told \
             --no-support, but not at order 0",
            file.display()
        )
    })
}
