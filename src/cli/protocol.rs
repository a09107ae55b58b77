//! `protocol`: standard tests of a tracker, in a simulated room or from recordings, and over time.

mod chart;
mod hummel;
mod rods;

use super::prelude::*;
use clap::Subcommand;

/// Assess a tracker by a standard test, and follow its figures over time
#[derive(Debug, Subcommand)]
pub enum ProtocolCommand {
    /// Run the protocol of Hummel et al. (Medical Physics 32(7), 2005): jitter, distances and turns on a
    /// plate with holes, and rods of metal beside the sensor
    Hummel(Box<hummel::HummelArgs>),
    /// Draw control charts of the tables of repeated runs, and list what is out of control
    Chart(chart::ChartArgs),
}

/// Runs a protocol, or draws its charts.
///
/// # Errors
/// Files that can't be used, plates that are not in the room, readings that are no run of a protocol.
pub fn run(command: &ProtocolCommand, files: &Files) -> anyhow::Result<()> {
    match command {
        ProtocolCommand::Hummel(args) => hummel::run(args, files),
        ProtocolCommand::Chart(args) => chart::run(args, files),
    }
}
