//! The rooms that a design could be put in: its own, the built-in ones, and those of a folder.

use super::builtin;
use super::error::StoreError;
use super::files::Files;
use super::paths::{
    ENVIRONMENT_EXTENSION, absolute, file_name, files_ending, folder_of, free_name, relative,
};
use super::read::Storage;
use super::reader::{Reader, home};
use super::room_metal::RoomContent;
use super::save_room::with_meshes;
use super::world::World;
use super::write::write_bytes;
use std::fs;
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
    Ok(match storage {
        Storage::BuiltIn => match builtin::path_of(&path) {
            Some(path) => RoomSource::BuiltIn(path),
            None => RoomSource::File(absolute(&path)),
        },
        Storage::Disk => RoomSource::File(absolute(&path)),
    })
}

/// How the open design refers to a room; `None` for a built-in room and a design on the disk.
pub fn reference_to_room(world: &World, room: &RoomSource) -> Result<Option<String>, StoreError> {
    let (storage, file) = home(world.document.origin())?;
    Ok(match (storage, room) {
        (Storage::BuiltIn, RoomSource::BuiltIn(path)) => {
            let folder = file.parent().unwrap_or(Path::new(""));
            Some(upwards(folder, Path::new(path)))
        }
        (Storage::BuiltIn, RoomSource::File(path)) => {
            Some(absolute(path).to_string_lossy().into_owned())
        }
        (Storage::Disk, RoomSource::File(path)) => Some(relative(&folder_of(&file), path)),
        (Storage::Disk, RoomSource::BuiltIn(_)) => None,
    })
}

/// How a design refers to a file that a person named.
pub fn reference_to_file(world: &World, file: &Path) -> Result<String, StoreError> {
    // A file is always within a design's reach.
    Ok(reference_to_room(world, &RoomSource::of_file(file))?.unwrap_or_default())
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

/// Writes a copy of a room for the open design, with the meshes of its metal where those are built in; what
/// it holds, and how the design refers to it.
///
/// # Errors
/// As [`write_room_for`]; a room that cannot be read.
pub fn copy_room_for(
    world: &World,
    file: &Path,
    room: &RoomSource,
) -> Result<(RoomContent, String), StoreError> {
    let mut content = room.read()?;
    let folder = folder_of(file);
    let mut moved = Vec::new();
    for mesh in content.metal.iter().flat_map(|metal| metal.mesh_files()) {
        moved.push(match room {
            RoomSource::File(path) => relative(&folder, &Storage::Disk.resolve(path, mesh)),
            RoomSource::BuiltIn(path) => {
                let built_in = Storage::BuiltIn.resolve(Path::new(path), mesh);
                let kind = "a mesh";
                let bytes = Storage::BuiltIn.read(&built_in, kind);
                let bytes = bytes.map_err(|failure| failure.into_error(&built_in, kind))?;
                let is_free =
                    |copy: &PathBuf| fs::read(copy).map_or(!copy.exists(), |found| found == *bytes);
                let copy = free_name(&folder.join(file_name(&built_in)), is_free);
                if !copy.exists() {
                    write_bytes(&copy, &bytes)?;
                }
                file_name(&copy)
            }
        });
    }
    let mut moved = moved.into_iter();
    let metal = content.metal.as_ref();
    content.metal = metal.map(|metal| with_meshes(metal, |_| moved.next().unwrap_or_default()));
    let reference = write_room_for(world, file, &content.bare, content.metal.as_deref())?;
    Ok((content, reference))
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
    use crate::{open_builtin, save_as};

    #[test]
    fn a_design_refers_to_its_own_room_as_it_did() {
        let mut world = open_builtin("endoscope").unwrap();
        let own = own_room(&world).unwrap();
        assert!(builtin_rooms().any(|room| room == own), "{own:?}");
        let reference = reference_to_room(&world, &own).unwrap();
        assert_eq!(reference.as_ref(), Some(&world.document.design().environment));

        let folder = tempfile::tempdir().unwrap();
        save_as(&mut world, &folder.path().join("a.design.ron")).unwrap();
        // From the disk the built-in room is out of reach, and its copy is beside the design.
        assert_eq!(reference_to_room(&world, &own).unwrap(), None);
        let own = own_room(&world).unwrap();
        assert_eq!(rooms_of_folder(folder.path()), std::slice::from_ref(&own));
        let reference = reference_to_room(&world, &own).unwrap();
        assert_eq!(reference.as_ref(), Some(&world.document.design().environment));
    }
}
