//! Which other designs a Save would change, because they use the same body.

use super::open::World;
use super::place::{Kind, Place, absolute};
use super::save::{is_changed, is_left_alone};
use super::write::folder_of;
use std::fs;
use std::path::{Path, PathBuf};
use trackwright_design::{BodyRole, Origin};
use trackwright_formats::design_file;

/// How design files are named.
const DESIGN_EXTENSION: &str = ".design.ron";

/// A changed body that other designs use too.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SharedBody {
    pub role: BodyRole,
    pub file: PathBuf,
    /// The other designs of the folder that use it, in order of their names.
    pub designs: Vec<PathBuf>,
}

/// The bodies that Save would change and that other designs in the design's folder use. Files
/// there that are no designs use nothing.
pub fn shared_bodies(world: &World) -> Vec<SharedBody> {
    let Origin::File(own_file) = world.document.origin() else {
        return Vec::new();
    };
    let design = world.document.design();
    let changed: Vec<_> = design
        .bodies()
        .filter(|(role, _)| is_changed(world, *role))
        .map(|(role, body)| (role, Place::Disk.resolve(own_file, &body.reference)))
        // Save leaves it as it is, and so the others too.
        .filter(|(role, file)| !is_left_alone(world, *role, file))
        .collect();
    if changed.is_empty() {
        return Vec::new();
    }
    let others = other_designs(own_file);
    changed
        .into_iter()
        .filter_map(|(role, file)| {
            let place = absolute(&file);
            let designs: Vec<_> = others
                .iter()
                .filter(|(_, bodies)| bodies.contains(&place))
                .map(|(design, _)| design.clone())
                .collect();
            (!designs.is_empty()).then_some(SharedBody { role, file, designs })
        })
        .collect()
}

/// The other designs of a folder, each with the bodies it uses.
fn other_designs(own_file: &Path) -> Vec<(PathBuf, Vec<PathBuf>)> {
    let own_place = absolute(own_file);
    let mut files: Vec<_> = fs::read_dir(folder_of(own_file))
        .into_iter()
        .flatten()
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.to_string_lossy().ends_with(DESIGN_EXTENSION))
        .filter(|path| absolute(path) != own_place)
        .collect();
    files.sort();
    files
        .into_iter()
        .filter_map(|file| {
            let design = design_file::parse(&Place::Disk.read(&file, Kind::DESIGN).ok()?).ok()?;
            let bodies = design
                .design
                .bodies()
                .map(|(_, body)| absolute(&Place::Disk.resolve(&file, &body.reference)))
                .collect();
            Some((file, bodies))
        })
        .collect()
}
