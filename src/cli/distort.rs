//! `distort`: poses as the tracker of an environment would measure them.

use super::output::OutsideArg;
use crate::field::OutsidePolicy;
use crate::formats::poses;
use crate::store;
use clap::Args;
use std::path::PathBuf;

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
}

/// Reads, distorts, and writes the table.
///
/// # Errors
/// Files that can't be used.
pub fn run(args: &DistortArgs) -> anyhow::Result<()> {
    let environment = store::read_environment(&args.environment)?;
    let ideal = store::read_poses(&args.poses)?;
    let outside = OutsidePolicy::from(args.outside);
    store::write_atomic(&args.output, |out| {
        let rows = ideal.iter().map(|pose| {
            let (measured, is_inside) = environment.model.distort(pose, outside);
            let is_kept = is_inside || outside != OutsidePolicy::Reject;
            (is_kept.then_some(measured), !is_inside)
        });
        poses::write_with_outside(out, rows)
    })?;
    Ok(())
}
