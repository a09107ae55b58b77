//! The other designs of a folder: what they share with a design is theirs too.

use super::paths::{absolute, files_ending, folder_of};
use super::read::{Kind, Storage};
use std::path::{Path, PathBuf};
use trackwright_formats::design_file;

/// How a design's file ends.
pub(super) const DESIGN_EXTENSION: &str = ".design.ron";

/// Another design of a folder, and the files that it uses.
pub(super) struct OtherDesign {
    pub file: PathBuf,
    pub bodies: Vec<PathBuf>,
    pub rooms: Vec<PathBuf>,
}

/// The other designs of a folder.
pub(super) fn other_designs(own_file: &Path) -> Vec<OtherDesign> {
    let own_place = absolute(own_file);
    let files = files_ending(&folder_of(own_file), DESIGN_EXTENSION).unwrap_or_default();
    files
        .into_iter()
        .filter(|file| absolute(file) != own_place)
        .filter_map(|file| {
            let design = design_file::parse(&Storage::Disk.read(&file, Kind::DESIGN).ok()?).ok()?;
            let design = design.design;
            let place = |reference: &str| absolute(&Storage::Disk.resolve(&file, reference));
            let rooms = design.procedure.further_rooms.iter().chain([&design.environment]);
            Some(OtherDesign {
                bodies: design.bodies().map(|(_, body)| place(&body.reference)).collect(),
                rooms: rooms.map(|room| place(room)).collect(),
                file,
            })
        })
        .collect()
}
