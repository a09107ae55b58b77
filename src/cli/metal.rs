//! What metal does to a tracker's field.

mod distance;
mod find;

#[cfg(feature = "editor")]
pub(super) use distance::object_index;

use super::prelude::*;
use clap::Subcommand;

/// Compute what metal does to a tracker's field
#[derive(Debug, Subcommand)]
pub enum MetalCommand {
    /// Find the compact metal bodies that explain the errors of a measurement table
    Find(find::FindArgs),
    /// Find from how far away a metal object lets a design meet its requirement
    Distance(distance::DistanceArgs),
}

/// Does what is requested of metal.
///
/// # Errors
/// Those of the subcommands.
pub fn run(command: &MetalCommand, files: &Files) -> anyhow::Result<()> {
    match command {
        MetalCommand::Find(args) => find::run(args, files),
        MetalCommand::Distance(args) => distance::run(args, files),
    }
}
