//! What metal does to a tracker's field.

mod distance;

use super::prelude::*;
use clap::Subcommand;

/// Compute what metal does to a tracker's field
#[derive(Debug, Subcommand)]
pub enum MetalCommand {
    /// Find from how far away a metal object lets a design meet its requirement
    Distance(distance::DistanceArgs),
}

/// Does what is requested of metal.
///
/// # Errors
/// Those of the subcommands.
pub fn run(command: &MetalCommand, files: &Files) -> anyhow::Result<()> {
    match command {
        MetalCommand::Distance(args) => distance::run(args, files),
    }
}
