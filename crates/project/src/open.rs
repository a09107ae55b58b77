//! Opens a design with its environment, bodies and meshes.

use super::builtin;
use super::error::StoreError;
use super::meshes::{Meshes, WhichMeshes, refresh_meshes};
use super::paths::{extension_of, file_name, free_name};
use super::read::{Kind, Storage, read};
use super::room_metal::SolvedMetal;
use super::stamps::Stamps;
use super::tool::parse_body;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use trackwright_design::{Design, Document, Origin, View};
use trackwright_field::Environment;
use trackwright_formats::{FormatError, design_file, mesh};
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_geometry::mesh_reference::MeshReference;

/// An open design and what it refers to.
#[derive(Clone, Debug)]
pub struct World {
    pub document: Document,
    /// The room, with its metal.
    pub environment: Arc<Environment>,
    pub(super) bare: Arc<Environment>,
    pub(super) solved: SolvedMetal,
    pub(super) meshes: Meshes,
    environment_reference: String,
    /// The further rooms whose files are watched.
    watched_rooms: Vec<String>,
    pub(super) stamps: Stamps,
}

impl World {
    /// A world whose environment and bodies' meshes are the ones that the design refers to.
    pub fn new(
        document: Document,
        environment: Arc<Environment>,
        tool_mesh: Option<Arc<SurfaceMesh>>,
        crf_mesh: Option<Arc<SurfaceMesh>>,
    ) -> Self {
        let meshes = Meshes::of_bodies(document.design(), [tool_mesh, crf_mesh]);
        Self::with_meshes(document, environment, meshes)
    }

    pub(super) fn with_meshes(
        document: Document,
        environment: Arc<Environment>,
        meshes: Meshes,
    ) -> Self {
        Self {
            environment_reference: document.design().environment.clone(),
            watched_rooms: Vec::new(),
            document,
            bare: Arc::clone(&environment),
            environment,
            solved: SolvedMetal::default(),
            meshes,
            stamps: Stamps::default(),
        }
    }

    /// States that environment and meshes are those that the design, which moved, now refers to.
    pub(super) fn references_are_current(&mut self, file_now: impl Fn(&str) -> String) {
        self.environment_is_current();
        self.meshes.moved(self.document.design(), file_now);
    }

    pub(super) fn environment_is_current(&mut self) {
        self.environment_reference = self.document.design().environment.clone();
    }

    /// Keeps what the further rooms' files are, for those that are not known yet. One that cannot
    /// be read is missed where the design is judged in it.
    fn watch_further_rooms(&mut self) -> Result<(), StoreError> {
        let rooms = &self.document.design().procedure.further_rooms;
        if *rooms == self.watched_rooms {
            return Ok(());
        }
        let (storage, own_file) = home(self.document.origin())?;
        for room in rooms {
            let file = storage.resolve(&own_file, room);
            if !is_on_disk(storage, &file) || self.stamps.knows(&file) {
                continue;
            }
            if let Ok(bytes) = storage.read(&file, Kind::ENVIRONMENT) {
                self.stamps.take(&file, &bytes);
            }
        }
        self.watched_rooms.clone_from(rooms);
        Ok(())
    }
}

/// Opens a design from the disk. A mesh that cannot be used is a [`World::mesh_problems`]; any
/// other file is an error.
pub fn open_design(path: &Path) -> Result<World, StoreError> {
    open(Storage::Disk, path, Origin::File(path.to_owned()), WhichMeshes::All)
}

/// Opens a design from the disk for a window that waits for it: large meshes are left to be read by a
/// thread, see [`World::awaited_meshes`].
pub fn open_design_to_show(path: &Path) -> Result<World, StoreError> {
    open(Storage::Disk, path, Origin::File(path.to_owned()), WhichMeshes::Small)
}

/// Opens another state of a design as a document of its own that was never saved. Save writes it beside the
/// design's file, to a name that is free: `pointer-row-7.design.ron` for the suffix `row-7`; that of a
/// built-in design is saved as any other of them is.
pub fn open_variant(origin: &Origin, design: Design, suffix: &str) -> Result<World, StoreError> {
    let (mut world, own) = match origin {
        Origin::BuiltIn(name) => (open_builtin(name)?, origin.clone()),
        Origin::File(file) => {
            let name = file_name(file);
            let (stem, extension) = name.split_at(name.find('.').unwrap_or(name.len()));
            let wanted = file.with_file_name(format!("{stem}-{suffix}{extension}"));
            let free = free_name(&wanted, |candidate| !candidate.exists());
            (open_design_to_show(file)?, Origin::File(free))
        }
    };
    let view = world.document.own_view().clone();
    let read = (world.document.design().clone(), view.clone());
    world.document = Document::recovered(design, view, own, Some(read));
    refresh_environment(&mut world)?;
    refresh_meshes(&mut world)?;
    Ok(world)
}

/// Opens a design from the disk for its numbers alone: no mesh is read or missed.
pub fn open_design_without_meshes(path: &Path) -> Result<World, StoreError> {
    open(Storage::Disk, path, Origin::File(path.to_owned()), WhichMeshes::None)
}

/// Opens a built-in design.
pub fn open_builtin(name: &str) -> Result<World, StoreError> {
    let (name, file) = builtin::design_file(name)?;
    open(Storage::BuiltIn, &file, Origin::BuiltIn(name), WhichMeshes::All)
}

/// Opens a built-in design for its numbers alone.
pub fn open_builtin_without_meshes(name: &str) -> Result<World, StoreError> {
    let (name, file) = builtin::design_file(name)?;
    open(Storage::BuiltIn, &file, Origin::BuiltIn(name), WhichMeshes::None)
}

/// The field generator, in the tracker frame. Fails only if the embedded mesh is none.
pub fn generator_mesh() -> Result<SurfaceMesh, StoreError> {
    let file = Path::new(builtin::GENERATOR_MESH);
    read(Storage::BuiltIn, file, "a mesh", |bytes| {
        Ok(mesh::read(bytes, &extension_of(file), None)?)
    })
}

/// Reads the environment again where the design now refers to another one; whether it did. The design's
/// metal in it is then awaited. After an error it is as it was. Further rooms that the design now names are watched from then on.
pub fn refresh_environment(world: &mut World) -> Result<bool, StoreError> {
    world.watch_further_rooms()?;
    let reference = &world.document.design().environment;
    if *reference == world.environment_reference {
        return Ok(false);
    }
    let (storage, file) = home(world.document.origin())?;
    let mut reader = Reader::new(storage);
    let room = reader.room(&file, reference)?;
    world.is_in_room(room.bare);
    world.stamps.extend(reader.stamps);
    world.environment_is_current();
    Ok(true)
}

/// Whether a file can be changed by others: one of the built-in world cannot.
pub(super) fn is_on_disk(storage: Storage, file: &Path) -> bool {
    storage == Storage::Disk || file.is_absolute()
}

/// Where a document's files are, and its own file there.
pub(super) fn home(origin: &Origin) -> Result<(Storage, PathBuf), StoreError> {
    Ok(match origin {
        Origin::BuiltIn(name) => (Storage::BuiltIn, builtin::design_file(name)?.1),
        Origin::File(file) => (Storage::Disk, file.clone()),
    })
}

fn open(
    storage: Storage,
    file: &Path,
    origin: Origin,
    meshes: WhichMeshes,
) -> Result<World, StoreError> {
    let mut reader = Reader::new(storage);
    let (mut design, view) = reader.design(file)?;
    let room = reader.room(file, &design.environment)?;
    design.room_metal = room.metal;
    let meshes = Meshes::read(&mut reader, file, &design, meshes);
    let environment_file = storage.resolve(file, &design.environment);
    let document = Document::new(design, view, origin);
    let mut world = World::with_meshes(document, Arc::clone(&room.bare), meshes);
    world.has_room(room.bare, &environment_file)?;
    world.stamps = reader.stamps;
    world.watch_further_rooms()?;
    Ok(world)
}

/// Reads the files of a design and remembers what they were.
pub(super) struct Reader {
    pub(super) storage: Storage,
    pub(super) stamps: Stamps,
}

impl Reader {
    pub(super) fn new(storage: Storage) -> Self {
        Self { storage, stamps: Stamps::default() }
    }

    pub(super) fn design(&mut self, file: &Path) -> Result<(Design, View), StoreError> {
        let entry = self.read(file, Kind::DESIGN, design_file::parse)?;
        entry.into_design(|reference| {
            let file = self.storage.resolve(file, reference);
            self.read(&file, Kind::BODY, |bytes| parse_body(&file, bytes))
        })
    }

    pub(super) fn mesh(
        &mut self,
        from: &Path,
        mesh: &MeshReference,
    ) -> Result<Arc<SurfaceMesh>, StoreError> {
        let file = self.storage.resolve(from, &mesh.file);
        let extension = extension_of(&file);
        self.read(&file, "a mesh", |bytes| Ok(mesh::read(bytes, &extension, mesh.unit)?))
            .map(Arc::new)
    }

    pub(super) fn read<T>(
        &mut self,
        file: &Path,
        kind: impl Into<Kind>,
        parse: impl FnOnce(&[u8]) -> Result<T, FormatError>,
    ) -> Result<T, StoreError> {
        read(self.storage, file, kind, |bytes| {
            if is_on_disk(self.storage, file) {
                self.stamps.take(file, bytes);
            }
            parse(bytes)
        })
    }
}
