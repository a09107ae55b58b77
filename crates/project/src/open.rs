//! Opens a design with its environment, bodies and meshes.

use super::anatomy::AnatomyMeshes;
use super::builtin;
use super::error::StoreError;
use super::mesh_cache::{ImportedMesh, MeshCache};
use super::meshes::{BodyMesh, MeshOwner, MeshProblem, Meshes};
use super::place::{Kind, Place};
use super::read::read;
use super::tool::parse_body;
use super::watch::Stamps;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use trackwright_design::{BodyRole, Design, DesignBody, Document, Origin, View};
use trackwright_field::Environment;
use trackwright_formats::{FormatError, design_file, environment, mesh};
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_geometry::mesh_reference::MeshReference;
use trackwright_geometry::mesh_report::MeshReport;

/// An open design and what it refers to.
#[derive(Clone, Debug)]
pub struct World {
    pub document: Document,
    pub environment: Arc<Environment>,
    /// The tool's and the CRF's.
    meshes: [BodyMesh; 2],
    pub(super) anatomy: AnatomyMeshes,
    pub(super) mesh_cache: MeshCache,
    /// The reference that `environment` was read by.
    environment_reference: String,
    /// What the files were when they were last read or written.
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
        let design = document.design();
        let bodies = [
            BodyMesh::current(design.body(BodyRole::Tool), tool_mesh),
            BodyMesh::current(design.body(BodyRole::Crf), crf_mesh),
        ];
        let meshes = Meshes { bodies, ..Meshes::default() };
        Self::with_meshes(document, environment, meshes)
    }

    pub(super) fn with_meshes(
        document: Document,
        environment: Arc<Environment>,
        meshes: Meshes,
    ) -> Self {
        Self {
            environment_reference: document.design().environment.clone(),
            document,
            environment,
            meshes: meshes.bodies,
            anatomy: meshes.anatomy,
            mesh_cache: MeshCache::default(),
            stamps: Stamps::default(),
        }
    }

    /// The mesh of a body; `None` where it has none or it could not be read.
    pub fn mesh(&self, role: BodyRole) -> Option<&Arc<SurfaceMesh>> {
        self.body_mesh(role).surface.as_ref()
    }

    /// What there is to say of a body's mesh, made when it is first asked for.
    pub fn mesh_report(&self, role: BodyRole) -> Option<Arc<MeshReport>> {
        self.body_mesh(role).report()
    }

    /// Keeps a mesh at hand, for an edit that is going to name it. Where its owner refers to it
    /// already, as after its file was written anew, it is its own from now on; whether it is.
    pub fn keep_mesh(&mut self, mesh: ImportedMesh) -> bool {
        let design = self.document.shared_design();
        let is_taken = match mesh.wanted.whose {
            MeshOwner::Anatomy(_) => self.anatomy.take(&design, &mesh),
            MeshOwner::Body(role) => {
                let body = design
                    .body(role)
                    .filter(|body| body.mesh.as_ref() == Some(&mesh.wanted.reference));
                if let Some(body) = body {
                    self.set_body_mesh(role, BodyMesh::kept(body, &mesh));
                }
                body.is_some()
            }
        };
        if is_taken {
            self.stamps.extend(mesh.stamps());
        }
        self.mesh_cache.keep(mesh);
        is_taken
    }

    /// The meshes that could not be read, and why.
    pub fn mesh_problems(&self) -> Vec<MeshProblem> {
        let bodies = BodyRole::ALL.into_iter();
        bodies
            .filter_map(|role| self.body_mesh(role).problem(role))
            .chain(self.anatomy.problems(self.document.design()))
            .collect()
    }

    pub(super) fn body_mesh(&self, role: BodyRole) -> &BodyMesh {
        match role {
            BodyRole::Tool => &self.meshes[0],
            BodyRole::Crf => &self.meshes[1],
        }
    }

    pub(super) fn set_body_mesh(&mut self, role: BodyRole, mesh: BodyMesh) {
        let [tool, crf] = &mut self.meshes;
        *match role {
            BodyRole::Tool => tool,
            BodyRole::Crf => crf,
        } = mesh;
    }

    /// States that environment and meshes at hand are the ones that the design, which moved, now
    /// refers to.
    pub(super) fn references_are_current(&mut self) {
        self.environment_is_current();
        for (mesh, role) in self.meshes.iter_mut().zip(BodyRole::ALL) {
            mesh.moved(self.document.design().body(role));
        }
    }

    fn environment_is_current(&mut self) {
        self.environment_reference = self.document.design().environment.clone();
    }
}

/// Opens a design from the disk. A mesh that cannot be used is a [`World::mesh_problems`].
///
/// # Errors
/// The first file that cannot be used, meshes apart; see [`StoreError`].
pub fn open_design(path: &Path) -> Result<World, StoreError> {
    open(Place::Disk, path, Origin::File(path.to_owned()), WhichMeshes::All)
}

/// Opens a design from the disk for its numbers alone: no mesh is read or missed.
///
/// # Errors
/// As [`open_design`].
pub fn open_design_without_meshes(path: &Path) -> Result<World, StoreError> {
    open(Place::Disk, path, Origin::File(path.to_owned()), WhichMeshes::None)
}

/// Opens a built-in design.
///
/// # Errors
/// [`StoreError::NoSuchBuiltIn`].
pub fn open_builtin(name: &str) -> Result<World, StoreError> {
    let (name, file) = builtin::design_file(name)?;
    open(Place::BuiltIn, &file, Origin::BuiltIn(name), WhichMeshes::All)
}

/// Opens a built-in design for its numbers alone.
///
/// # Errors
/// As [`open_builtin`].
pub fn open_builtin_without_meshes(name: &str) -> Result<World, StoreError> {
    let (name, file) = builtin::design_file(name)?;
    open(Place::BuiltIn, &file, Origin::BuiltIn(name), WhichMeshes::None)
}

/// Which meshes are asked for.
#[derive(Clone, Copy, PartialEq)]
enum WhichMeshes {
    All,
    None,
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

fn open(
    place: Place,
    file: &Path,
    origin: Origin,
    meshes: WhichMeshes,
) -> Result<World, StoreError> {
    let mut reader = Reader::new(place);
    let (design, view) = reader.design(file)?;
    let environment = reader.environment(file, &design.environment)?;
    let meshes = match meshes {
        WhichMeshes::All => Meshes::read(&mut reader, file, &design),
        WhichMeshes::None => Meshes::default(),
    };
    let document = Document::new(design, view, origin);
    let mut world = World::with_meshes(document, environment, meshes);
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
        Self { place, stamps: Stamps::default() }
    }

    /// A design with its bodies.
    pub(super) fn design(&mut self, file: &Path) -> Result<(Design, View), StoreError> {
        let entry = self.read(file, Kind::DESIGN, design_file::parse)?;
        entry.into_design(|reference| {
            let file = self.place.resolve(file, reference);
            self.read(&file, Kind::BODY, |bytes| parse_body(&file, bytes))
        })
    }

    pub(super) fn environment(
        &mut self,
        design_file: &Path,
        reference: &str,
    ) -> Result<Arc<Environment>, StoreError> {
        let file = self.place.resolve(design_file, reference);
        self.read(&file, Kind::ENVIRONMENT, environment::parse).map(Arc::new)
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
        self.mesh_of(&body_file, mesh).map(Some)
    }

    /// The mesh that a file refers to.
    pub(super) fn mesh_of(
        &mut self,
        from: &Path,
        mesh: &MeshReference,
    ) -> Result<Arc<SurfaceMesh>, StoreError> {
        let file = self.place.resolve(from, &mesh.file);
        let extension = file.extension().unwrap_or_default().to_string_lossy();
        self.read(&file, "a mesh", |bytes| Ok(mesh::read(bytes, &extension, mesh.unit)?))
            .map(Arc::new)
    }

    fn read<T>(
        &mut self,
        file: &Path,
        kind: impl Into<Kind>,
        parse: impl FnOnce(&[u8]) -> Result<T, FormatError>,
    ) -> Result<T, StoreError> {
        read(self.place, file, kind, |bytes| {
            if self.place == Place::Disk || file.is_absolute() {
                self.stamps.take(file, bytes);
            }
            parse(bytes)
        })
    }
}
