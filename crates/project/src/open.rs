//! Opens a design with its environment, bodies and meshes.

use super::builtin;
use super::error::StoreError;
use super::meshes::{Meshes, WhichMeshes, refresh_meshes};
use super::paths::{extension_of, file_name, free_name};
use super::read::{Storage, read};
use super::reader::{Reader, home};
use super::world::World;
use std::path::Path;
use std::sync::Arc;
use trackwright_design::{Design, Document, Origin};
use trackwright_formats::mesh;
use trackwright_geometry::mesh::SurfaceMesh;

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
