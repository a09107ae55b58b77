//! Where Save puts the metal of a design's room: into the room's own file where that holds metal already
//! and no other design uses it, else into a new one beside the design. A room that was measured is never
//! written over.

use super::other_designs::other_designs;
use super::paths::{ENVIRONMENT_EXTENSION, absolute, folder_of, free_name, relative, room_name};
use super::read::{Kind, Storage};
use super::world::World;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use trackwright_design::{Design, Origin};
use trackwright_formats::{EnvironmentFile, environment};
use trackwright_metal::setup::{ObjectShape, RoomMetal};

/// A room that is saved as another file than the one that it came from.
pub(super) struct RoomMove {
    /// What the states that move with it refer to.
    old_reference: String,
    old_file: PathBuf,
    pub file: PathBuf,
}

impl RoomMove {
    /// The new place of a changed room whose file is left alone.
    pub fn of(world: &World, design_file: &Path) -> Option<Self> {
        let design = world.document.design();
        let old_file = Storage::Disk.resolve(design_file, &design.environment);
        if !is_room_changed(world) || is_own_room(design_file, &old_file) {
            return None;
        }
        let name = format!("{}-with-metal{ENVIRONMENT_EXTENSION}", room_name(&old_file));
        let file = free_name(&folder_of(design_file).join(name), |path| !path.exists());
        Some(Self { old_reference: design.environment.clone(), old_file, file })
    }

    /// Lets a state of the document refer to the new place, where it has metal in the old one.
    pub fn rewrite(&self, design: &mut Design, design_folder: &Path) {
        if design.environment != self.old_reference {
            return;
        }
        if let Some(metal) = &design.room_metal {
            let folder = folder_of(&self.file);
            design.room_metal = Some(with_meshes(metal, |mesh| {
                relative(&folder, &Storage::Disk.resolve(&self.old_file, mesh))
            }));
            design.environment = relative(design_folder, &self.file);
        }
    }
}

/// The room's file and its new text, where Save would write it.
pub(super) fn changed_room(world: &World, design_file: &Path) -> Option<(PathBuf, String)> {
    is_room_changed(world).then(|| {
        let design = world.document.design();
        let text = environment::write(&world.bare, design.room_metal.as_deref());
        (Storage::Disk.resolve(design_file, &design.environment), text)
    })
}

/// Whether the metal is not what the room's file holds.
pub(super) fn is_room_changed(world: &World) -> bool {
    let design = world.document.design();
    match world.document.saved() {
        Some((saved, _)) if saved.environment == design.environment => {
            saved.room_metal != design.room_metal
        }
        // Another room, which may have the metal that its file holds.
        _ => {
            let Origin::File(design_file) = world.document.origin() else {
                return design.room_metal.is_some();
            };
            let held = held(&Storage::Disk.resolve(design_file, &design.environment));
            held.is_none_or(|held| !is_alike(held.metal.as_ref(), design.room_metal.as_deref()))
        }
    }
}

/// The metal with other references to its meshes.
pub(super) fn with_meshes(
    metal: &RoomMetal,
    mut moved: impl FnMut(&str) -> String,
) -> Arc<RoomMetal> {
    let mut metal = metal.clone();
    for object in &mut metal.objects {
        if let ObjectShape::Mesh(mesh) = &mut object.shape {
            mesh.reference.file = moved(&mesh.reference.file);
        }
    }
    Arc::new(metal)
}

fn held(file: &Path) -> Option<EnvironmentFile> {
    environment::parse(&Storage::Disk.read(file, Kind::ENVIRONMENT).ok()?).ok()
}

/// Whether both are the same but for the surfaces of meshes, which a file does not hold.
fn is_alike(held: Option<&RoomMetal>, own: Option<&RoomMetal>) -> bool {
    let without_surfaces = |metal: &RoomMetal| {
        let metal =
            metal.clone().with_surfaces(|_| Ok::<_, std::convert::Infallible>(Arc::default()));
        metal.ok()
    };
    match (held, own) {
        (None, None) => true,
        (Some(held), Some(own)) => without_surfaces(held) == without_surfaces(own),
        _ => false,
    }
}

/// Whether a room's file holds metal and only this design uses it.
fn is_own_room(design_file: &Path, room_file: &Path) -> bool {
    let has_metal = Storage::Disk.is_on_disk(room_file)
        && held(room_file).is_some_and(|held| held.metal.is_some());
    let place = absolute(room_file);
    let others = other_designs(design_file);
    has_metal && others.iter().all(|other| !other.rooms.contains(&place))
}
