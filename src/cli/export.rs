//! `export`: the field, poses, the tips of a study and the 3D view as files of other programs.

mod field;
mod poses;
mod scene;
mod tips;

use super::prelude::*;
use clap::Subcommand;

/// Write the field of an environment, or poses, as files for 3D Slicer, ParaView or a spreadsheet
#[derive(Debug, Subcommand)]
pub enum ExportCommand {
    /// The error of an environment on a lattice: a displacement field for 3D Slicer (*.nrrd, *.mha),
    /// image data for ParaView (*.vti), or a table (*.csv)
    Field(field::FieldArgs),
    /// Poses or tips of a recording or table: points (*.mrk.json) or one transform (*.tfm) for
    /// 3D Slicer, or a poses table (*.csv)
    Poses(poses::PosesArgs),
    /// The tips of a design's study, where they are and where the tracker would report them:
    /// points for 3D Slicer (*.mrk.json) or a table (*.csv)
    Tips(tips::TipsArgs),
    /// The 3D view of a design as one file for other programs (*.glb): bodies, sensors, magnified
    /// errors, the room and what its layers show, in the editor's colours
    Scene(scene::SceneArgs),
}

/// Exports.
///
/// # Errors
/// Files that can't be used, and what they cannot hold.
pub fn run(command: &ExportCommand, files: &Files) -> anyhow::Result<()> {
    match command {
        ExportCommand::Field(args) => field::run(args, files),
        ExportCommand::Poses(args) => poses::run(args, files),
        ExportCommand::Tips(args) => tips::run(args, files),
        ExportCommand::Scene(args) => scene::run(args, files),
    }
}
