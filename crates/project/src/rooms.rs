//! The rooms that a design could be put in: its own, the built-in ones, and those of a folder.

use super::builtin;
use super::error::StoreError;
use super::files::Files;
use super::paths::{
    ENVIRONMENT_EXTENSION, absolute, built_in_reference, file_name, files_ending, folder_of,
    relative,
};
use super::read::Storage;
use super::reader::{Reader, home};
use super::room_metal::RoomContent;
use super::world::World;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use trackwright_field::Environment;
use trackwright_formats::environment;
use trackwright_metal::setup::RoomMetal;
use trackwright_task::{Cancelled, Task};

/// Most rooms of one folder that are read: a list for a person.
const MOST_ROOMS: usize = 64;

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum RoomSource {
    BuiltIn(&'static str),
    File(PathBuf),
}

#[derive(Clone, Debug, PartialEq)]
pub struct RoomListing {
    pub place: RoomSource,
    pub summary: RoomSummary,
}

#[derive(Clone, Debug, PartialEq)]
pub struct RoomSummary {
    pub name: String,
    /// `None` for an ideal room.
    pub samples: Option<usize>,
    pub held_out_rms_mm: Option<f64>,
    /// Whether metal is added to it.
    pub has_metal: bool,
}

impl RoomSummary {
    /// The summary of a room.
    pub fn of(room: &RoomContent) -> Self {
        let provenance = room.bare.provenance.as_ref();
        Self {
            name: room.bare.name.clone(),
            has_metal: room.metal.is_some(),
            samples: provenance.map(|p| p.samples),
            held_out_rms_mm: provenance
                .and_then(|p| p.holdout.as_ref())
                .map(|h| h.after.position_rms_mm),
        }
    }
}

impl RoomSource {
    fn path(&self) -> &Path {
        match self {
            Self::BuiltIn(path) => Path::new(path),
            Self::File(path) => path,
        }
    }

    fn storage(&self) -> Storage {
        match self {
            Self::BuiltIn(_) => Storage::BuiltIn,
            Self::File(_) => Storage::Disk,
        }
    }

    /// The file's name without its folder.
    pub fn file_name(&self) -> String {
        file_name(self.path())
    }

    /// The file, of a room that is on the disk.
    pub fn file(&self) -> Option<&Path> {
        match self {
            Self::BuiltIn(_) => None,
            Self::File(file) => Some(file),
        }
    }

    /// A file of the disk, by any of its names.
    pub fn of_file(file: &Path) -> Self {
        Self::File(absolute(file))
    }

    /// Reads the room and its metal.
    pub fn read(&self) -> Result<RoomContent, StoreError> {
        Reader::new(self.storage()).room(Path::new(""), &self.path().to_string_lossy())
    }

    /// Reads the room, with its metal solved for.
    pub fn read_solved(&self) -> Result<Arc<Environment>, StoreError> {
        self.solved(&self.read()?)
    }

    /// The room that was [read](Self::read), with its metal solved for.
    pub fn solved(&self, content: &RoomContent) -> Result<Arc<Environment>, StoreError> {
        Ok(content.solved(self.path(), &Task::default())?.environment)
    }
}

impl Files {
    /// Reads an environment, with its metal solved for.
    pub fn read_environment(&self, file: &Path) -> Result<Environment, StoreError> {
        let furnished = self.read_room(file)?.solved(file, &Task::default())?;
        Ok(Arc::unwrap_or_clone(furnished.environment))
    }

    /// Reads an environment and the metal in it.
    pub fn read_room(&self, file: &Path) -> Result<RoomContent, StoreError> {
        let mut reader = Reader::new(Storage::Disk);
        let content = reader.room(Path::new(""), &file.to_string_lossy())?;
        self.inputs(&reader.stamps)?;
        Ok(content)
    }
}

/// Where the room of the open design is.
pub fn own_room(world: &World) -> Result<RoomSource, StoreError> {
    room_at(world, &world.document.design().environment)
}

/// Where the further rooms are that the open design is judged in.
pub fn further_rooms(world: &World) -> Result<Vec<RoomSource>, StoreError> {
    let files = &world.document.design().procedure.further_rooms;
    files.iter().map(|file| room_at(world, file)).collect()
}

fn room_at(world: &World, reference: &str) -> Result<RoomSource, StoreError> {
    let (storage, file) = home(world.document.origin())?;
    let path = storage.resolve(&file, reference);
    let built_in = storage.built_in(&path).map(RoomSource::BuiltIn);
    Ok(built_in.unwrap_or_else(|| RoomSource::File(absolute(&path))))
}

/// How the open design refers to a room.
pub fn reference_to_room(world: &World, room: &RoomSource) -> Result<String, StoreError> {
    let (storage, file) = home(world.document.origin())?;
    Ok(match (storage, room) {
        (Storage::BuiltIn, RoomSource::BuiltIn(path)) => {
            let folder = file.parent().unwrap_or(Path::new(""));
            upwards(folder, Path::new(path))
        }
        (Storage::BuiltIn, RoomSource::File(path)) => absolute(path).to_string_lossy().into_owned(),
        (Storage::Disk, RoomSource::File(path)) => relative(&folder_of(&file), path),
        (Storage::Disk, RoomSource::BuiltIn(path)) => built_in_reference(path),
    })
}

/// How a design refers to a file that a person named.
pub fn reference_to_file(world: &World, file: &Path) -> Result<String, StoreError> {
    reference_to_room(world, &RoomSource::of_file(file))
}

/// A reference within the built-in world, whose paths begin at its root and have no dots.
fn upwards(folder: &Path, target: &Path) -> String {
    let up = folder.components().map(|_| "..");
    let down = target.components().map(|c| c.as_os_str().to_string_lossy());
    up.map(Into::into).chain(down).collect::<Vec<_>>().join("/")
}

/// Writes a room with its metal for the open design, and returns how the design refers to it.
///
/// # Errors
/// [`StoreError::IsInput`] for a file of the design itself, as undo has to find its room as it is; a file
/// that cannot be written.
pub fn write_room_for(
    world: &World,
    file: &Path,
    bare: &Environment,
    metal: Option<&RoomMetal>,
) -> Result<String, StoreError> {
    let text = environment::write(bare, metal);
    Files::except_design(world).output(file)?.write_bytes(text.as_bytes())?;
    reference_to_file(world, file)
}

/// The built-in rooms.
pub fn builtin_rooms() -> impl Iterator<Item = RoomSource> {
    builtin::paths().filter(|path| path.ends_with(ENVIRONMENT_EXTENSION)).map(RoomSource::BuiltIn)
}

/// The environment files of a folder, by name.
pub fn rooms_of_folder(folder: &Path) -> Vec<RoomSource> {
    let files = files_ending(folder, ENVIRONMENT_EXTENSION).unwrap_or_default();
    let mut files: Vec<_> = files.iter().map(|path| absolute(path)).collect();
    files.sort();
    files.truncate(MOST_ROOMS);
    files.into_iter().map(RoomSource::File).collect()
}

/// Reads rooms for a list, each once, built-in ones first, then by name; others are left out.
pub fn list_rooms(places: Vec<RoomSource>, task: &Task) -> Result<Vec<RoomListing>, Cancelled> {
    let mut listings: Vec<RoomListing> = Vec::new();
    let all = places.len();
    for (i, place) in places.into_iter().enumerate() {
        task.step(i, all)?;
        if listings.iter().any(|listing| listing.place == place) {
            continue;
        }
        if let Ok(content) = place.read() {
            listings.push(RoomListing { summary: RoomSummary::of(&content), place });
        }
    }
    // The order depends on nothing that a choice from the list changes.
    let key = |listing: &RoomListing| {
        let is_file = matches!(listing.place, RoomSource::File(_));
        (is_file, listing.summary.name.clone(), listing.place.file_name())
    };
    listings.sort_by_cached_key(key);
    Ok(listings)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{open_builtin, open_design_without_meshes, refresh_environment, save, save_as};
    use trackwright_design::{Edit, MetalEdit};

    #[test]
    fn a_design_refers_to_its_own_room_as_it_did() {
        let mut world = open_builtin("endoscope").unwrap();
        let own = own_room(&world).unwrap();
        assert!(builtin_rooms().any(|room| room == own), "{own:?}");
        let reference = reference_to_room(&world, &own).unwrap();
        assert_eq!(reference, world.document.design().environment);

        let folder = tempfile::tempdir().unwrap();
        save_as(&mut world, &folder.path().join("a.design.ron")).unwrap();
        // Its copy is beside the design.
        let copy = own_room(&world).unwrap();
        assert_eq!(rooms_of_folder(folder.path()), std::slice::from_ref(&copy));
        let reference = reference_to_room(&world, &copy).unwrap();
        assert_eq!(reference, world.document.design().environment);
        assert_eq!(
            reference_to_room(&world, &own).unwrap(),
            "builtin:/assets/environments/operating-table.env.ron"
        );
    }

    #[test]
    fn a_design_on_the_disk_may_be_in_a_built_in_room() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.design.ron");
        let mut world = open_builtin("endoscope").unwrap();
        save_as(&mut world, &file).unwrap();
        for room in builtin_rooms() {
            let content = room.read().unwrap();
            let reference = reference_to_room(&world, &room).unwrap();
            let metal = content.metal.clone();
            world.document.apply(Edit::SetEnvironment { file: reference, metal }).unwrap();
            refresh_environment(&mut world).unwrap();
            assert_eq!(own_room(&world).unwrap(), room);
            let written = save(&mut world).unwrap().written;
            assert_eq!(written, std::slice::from_ref(&file), "the room is written nowhere");
            let again = open_design_without_meshes(&file).unwrap();
            assert_eq!(own_room(&again).unwrap(), room);
            assert_eq!(again.document.design(), world.document.design());
            assert!(again.files().all(Path::is_absolute), "only files of the disk are watched");
        }

        // Metal that is moved makes it a room of its own, whose built-in meshes stay where they are.
        let design = world.document.design();
        let metal = design.room_metal.clone().expect("the last of the built-in rooms has metal");
        world.document.apply(Edit::Metal(MetalEdit::SetFrequency(4e3))).unwrap();
        save(&mut world).unwrap();
        let again = open_design_without_meshes(&file).unwrap();
        let own = own_room(&again).unwrap();
        assert_eq!(own.file_name(), "operating-theatre-with-metal.env.ron");
        let kept = again.document.design().room_metal.as_ref().unwrap();
        let meshes = |metal: &RoomMetal| metal.mesh_files().count();
        assert!(meshes(kept) > 0 && meshes(kept) == meshes(&metal));
        assert!(kept.mesh_files().all(|mesh| mesh.starts_with("builtin:/assets/meshes/")));

        let elsewhere = tempfile::tempdir().unwrap();
        let room = builtin_rooms().next().unwrap();
        let file = reference_to_room(&world, &room).unwrap();
        world.document.apply(Edit::SetEnvironment { file, metal: None }).unwrap();
        save_as(&mut world, &elsewhere.path().join("b.design.ron")).unwrap();
        assert_eq!(own_room(&world).unwrap(), room);
    }
}
