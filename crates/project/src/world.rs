//! An open design with all that its files hold.

use super::error::StoreError;
use super::meshes::Meshes;
use super::read::Kind;
use super::reader::home;
use super::stamps::Stamps;
use std::path::Path;
use std::sync::Arc;
use trackwright_design::{Document, Origin};
use trackwright_field::Environment;
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_metal::furnished::{FurnishError, Furnished};
use trackwright_metal::setup::RoomMetal;

/// An open design and what it refers to.
#[derive(Clone, Debug)]
pub struct World {
    pub document: Document,
    /// The room, with its metal.
    pub environment: Arc<Environment>,
    pub(super) bare: Arc<Environment>,
    pub(super) solved: SolvedMetal,
    pub(super) meshes: Meshes,
    pub(super) environment_reference: String,
    /// The further rooms whose files are watched.
    watched_rooms: Vec<String>,
    pub(super) stamps: Stamps,
}

impl World {
    /// The files of the disk that it was read from.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        let own = match self.document.origin() {
            Origin::File(file) => Some(file.as_path()),
            Origin::BuiltIn(_) => None,
        };
        own.into_iter().chain(self.stamps.iter().map(|(file, _)| file.as_path()))
    }

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
    pub(super) fn watch_further_rooms(&mut self) -> Result<(), StoreError> {
        let rooms = &self.document.design().procedure.further_rooms;
        if *rooms == self.watched_rooms {
            return Ok(());
        }
        let (storage, own_file) = home(self.document.origin())?;
        for room in rooms {
            let file = storage.resolve(&own_file, room);
            if !storage.is_on_disk(&file) || self.stamps.knows(&file) {
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

/// The metal that a world's environment has.
#[derive(Clone, Debug, Default)]
pub(super) struct SolvedMetal {
    pub metal: Option<Arc<RoomMetal>>,
    pub furnished: Option<Furnished>,
    pub problem: Option<Arc<FurnishError>>,
}
