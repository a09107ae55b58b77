//! Opens a design with its environment, bodies and meshes.

use super::builtin;
use super::error::StoreError;
use super::place::Place;
use super::read::read;
use super::watch::Stamps;
use crate::design::{BodyRole, Design, DesignBody, Document, Origin, View};
use crate::field::Environment;
use crate::formats::{FormatError, body, design_file, environment, gltf};
use crate::geometry::mesh::SurfaceMesh;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// An open design and what it refers to.
#[derive(Clone, Debug)]
pub struct World {
    pub document: Document,
    pub environment: Arc<Environment>,
    pub tool_mesh: Option<Arc<SurfaceMesh>>,
    pub crf_mesh: Option<Arc<SurfaceMesh>>,
    /// The reference that `environment` was read by.
    environment_reference: String,
    /// What the files were when they were last read or written.
    pub(super) stamps: Stamps,
}

impl World {
    /// A world whose environment is the one that the design refers to.
    pub fn new(
        document: Document,
        environment: Arc<Environment>,
        tool_mesh: Option<Arc<SurfaceMesh>>,
        crf_mesh: Option<Arc<SurfaceMesh>>,
    ) -> Self {
        Self {
            environment_reference: document.design().environment.clone(),
            document,
            environment,
            tool_mesh,
            crf_mesh,
            stamps: Stamps::default(),
        }
    }

    pub fn mesh(&self, role: BodyRole) -> Option<&Arc<SurfaceMesh>> {
        match role {
            BodyRole::Tool => self.tool_mesh.as_ref(),
            BodyRole::Crf => self.crf_mesh.as_ref(),
        }
    }

    /// States that the environment at hand is the one that the design now refers to.
    pub(super) fn environment_is_current(&mut self) {
        self.environment_reference = self.document.design().environment.clone();
    }
}

/// Opens a design from the disk.
///
/// # Errors
/// The first file that cannot be used; see [`StoreError`].
pub fn open_design(path: &Path) -> Result<World, StoreError> {
    open(Place::Disk, path, Origin::File(path.to_owned()))
}

/// Opens a built-in design.
///
/// # Errors
/// [`StoreError::NoSuchBuiltIn`].
pub fn open_builtin(name: &str) -> Result<World, StoreError> {
    let (name, file) = builtin::design_file(name)?;
    open(Place::BuiltIn, &file, Origin::BuiltIn(name))
}

/// Reads the environment again where the design now refers to another one, as after an edit or
/// its undo; whether it did.
///
/// # Errors
/// Those of reading it; the environment is then as it was.
pub fn refresh_environment(world: &mut World) -> Result<bool, StoreError> {
    let reference = &world.document.design().environment;
    if *reference == world.environment_reference {
        return Ok(false);
    }
    let (place, file) = home(world.document.origin())?;
    let mut reader = Reader::new(place);
    world.environment = reader.environment(&file, reference)?;
    world.stamps.extend(reader.stamps);
    world.environment_is_current();
    Ok(true)
}

/// Where a document's files are, and its own file there.
pub(super) fn home(origin: &Origin) -> Result<(Place, PathBuf), StoreError> {
    Ok(match origin {
        Origin::BuiltIn(name) => (Place::BuiltIn, builtin::design_file(name)?.1),
        Origin::File(file) => (Place::Disk, file.clone()),
    })
}

fn open(place: Place, file: &Path, origin: Origin) -> Result<World, StoreError> {
    let mut reader = Reader::new(place);
    let (design, view) = reader.design(file)?;
    let environment = reader.environment(file, &design.environment)?;
    let tool_mesh = reader.mesh(file, &design.tool.body)?;
    let crf_mesh = match &design.crf {
        Some(crf) => reader.mesh(file, &crf.body)?,
        None => None,
    };
    let document = Document::new(design, view, origin);
    let mut world = World::new(document, environment, tool_mesh, crf_mesh);
    world.stamps = reader.stamps;
    Ok(world)
}

/// Reads the files of a design and remembers what they were.
pub(super) struct Reader {
    place: Place,
    pub(super) stamps: Stamps,
}

impl Reader {
    pub(super) fn new(place: Place) -> Self {
        Self {
            place,
            stamps: Stamps::default(),
        }
    }

    /// A design with its bodies.
    pub(super) fn design(&mut self, file: &Path) -> Result<(Design, View), StoreError> {
        let entry = self.read(file, "a design", design_file::parse)?;
        entry.into_design(|reference| {
            let file = self.place.resolve(file, reference);
            self.read(&file, "a body", body::parse)
        })
    }

    pub(super) fn environment(
        &mut self,
        design_file: &Path,
        reference: &str,
    ) -> Result<Arc<Environment>, StoreError> {
        let file = self.place.resolve(design_file, reference);
        self.read(&file, "an environment", environment::parse)
            .map(Arc::new)
    }

    /// The mesh of a body that has one.
    pub(super) fn mesh(
        &mut self,
        design_file: &Path,
        body: &DesignBody,
    ) -> Result<Option<Arc<SurfaceMesh>>, StoreError> {
        let Some(mesh) = &body.mesh else {
            return Ok(None);
        };
        let body_file = self.place.resolve(design_file, &body.reference);
        let file = self.place.resolve(&body_file, mesh);
        self.read(&file, "a mesh", |bytes| Ok(gltf::parse(bytes)?))
            .map(|mesh| Some(Arc::new(mesh)))
    }

    fn read<T>(
        &mut self,
        file: &Path,
        expected: &'static str,
        parse: impl FnOnce(&[u8]) -> Result<T, FormatError>,
    ) -> Result<T, StoreError> {
        read(self.place, file, expected, |bytes| {
            if self.place == Place::Disk || file.is_absolute() {
                self.stamps.take(file, bytes);
            }
            parse(bytes)
        })
    }
}
