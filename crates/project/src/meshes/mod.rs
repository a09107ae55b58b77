//! The meshes of an open design, its bodies' and its anatomy's: read with it and again when an edit
//! names others. A missing one is a [`World::mesh_problems`](super::World::mesh_problems), since no number depends on meshes.
//!
//! A mesh is known by what the design refers to it by, so that the order of anatomy, its names and
//! poses do not matter. Those read last are cached: a thread reads a mesh before an edit names it,
//! and undo comes back to one. None of them is read twice.

mod of_world;

pub use of_world::{mesh_reference_to, refresh_meshes, reload_meshes};

use super::error::StoreError;
use super::paths::extension_of;
use super::read::{Storage, read};
use super::reader::Reader;
use super::stamps::Stamps;
use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};
use trackwright_design::{BodyRole, Design, DesignBody};
use trackwright_formats::mesh;
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_geometry::mesh_reference::{MeshReference, MeshUnit};
use trackwright_geometry::mesh_report::MeshReport;

/// Meshes that are cached; a million triangles take some 100 MB.
const MOST_CACHED: usize = 4;

/// A larger file is read by a thread where a window waits for the design: this much is read and made
/// a surface within a frame or two.
const LARGE_BYTES: u64 = 1 << 20;

/// Which meshes are read with a design.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum WhichMeshes {
    All,
    /// Those that are read at once; the others are [`World::awaited_meshes`](super::World::awaited_meshes).
    Small,
    None,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MeshOwner {
    Body(BodyRole),
    /// Anatomy by its index in the design's list; `None` for what is not yet in it.
    Anatomy(Option<usize>),
    /// A metal object that is not yet in the room.
    NewMetal,
    /// The tool of a design that is made for it.
    NewTool,
}

impl From<BodyRole> for MeshOwner {
    fn from(role: BodyRole) -> Self {
        Self::Body(role)
    }
}

/// Within a sentence.
impl fmt::Display for MeshOwner {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Body(role) => role.fmt(f),
            Self::Anatomy(_) => f.write_str("anatomy"),
            Self::NewMetal => f.write_str("metal object"),
            Self::NewTool => f.write_str("new tool"),
        }
    }
}

impl MeshOwner {
    /// What its mesh is called within a sentence; `name` is that of the anatomy.
    fn mesh_name(self, name: &str) -> String {
        match self {
            Self::Body(role) => format!("the {role}'s mesh"),
            Self::Anatomy(_) => format!("the anatomy {name:?}"),
            Self::NewMetal => "the metal object's mesh".to_owned(),
            Self::NewTool => "the new tool's mesh".to_owned(),
        }
    }
}

/// Why a mesh is not there; the design keeps its reference.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{} is missing: {cause}", whose.mesh_name(name))]
pub struct MeshProblem {
    pub whose: MeshOwner,
    /// Of the anatomy; a body is named by its role.
    pub name: String,
    pub reference: MeshReference,
    pub cause: Arc<StoreError>,
}

/// Something wrong with a mesh that was read all the same.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}: {text}", whose.mesh_name(name))]
pub struct MeshDoubt {
    pub whose: MeshOwner,
    pub name: String,
    pub text: String,
}

#[derive(Clone, Debug, Default)]
pub(super) struct Meshes {
    bodies: [LoadedMesh; 2],
    /// Each file in each unit once.
    anatomy: Vec<LoadedMesh>,
    /// The meshes that were read last, the newest first.
    cache: Vec<ImportedMesh>,
}

#[derive(Clone, Debug, Default)]
struct LoadedMesh {
    /// What it was read by; `None` before that.
    source: Option<MeshSource>,
    surface: Option<Arc<SurfaceMesh>>,
    /// Made on first use.
    report: OnceLock<Arc<MeshReport>>,
    cause: Option<Arc<StoreError>>,
    /// Whether it is left to be read by a thread.
    is_awaited: bool,
}

#[derive(Clone, Debug, PartialEq)]
struct MeshSource {
    /// The design's reference to the body whose file refers to the mesh; `None` for the design's own.
    body: Option<String>,
    mesh: Option<MeshReference>,
}

impl MeshSource {
    fn of_body(body: &DesignBody) -> Self {
        Self { body: Some(body.reference.clone()), mesh: body.mesh.clone() }
    }

    fn of_anatomy(mesh: &MeshReference) -> Self {
        Self { body: None, mesh: Some(mesh.clone()) }
    }

    fn referring_file(&self, storage: Storage, design_file: &Path) -> PathBuf {
        let body = self.body.as_ref();
        body.map_or_else(|| design_file.to_owned(), |body| storage.resolve(design_file, body))
    }
}

impl LoadedMesh {
    /// Reads what the source refers to; a failure is kept.
    fn read(reader: &mut Reader, design_file: &Path, source: MeshSource) -> Self {
        let from = source.referring_file(reader.storage, design_file);
        let read = source.mesh.as_ref().map(|mesh| reader.mesh(&from, mesh)).transpose();
        let (surface, cause) = match read {
            Ok(surface) => (surface, None),
            Err(error) => (None, Some(Arc::new(error))),
        };
        Self { source: Some(source), surface, cause, ..Self::default() }
    }

    /// Leaves a large file of the disk to be read later.
    fn read_if_small(reader: &mut Reader, design_file: &Path, source: MeshSource) -> Self {
        let from = source.referring_file(reader.storage, design_file);
        let file = source.mesh.as_ref().map(|mesh| reader.storage.resolve(&from, &mesh.file));
        let is_large = file.is_some_and(|file| {
            reader.storage.is_on_disk(&file)
                && fs::metadata(&file)
                    .is_ok_and(|found| found.is_file() && found.len() > LARGE_BYTES)
        });
        match is_large {
            true => Self { source: Some(source), is_awaited: true, ..Self::default() },
            false => Self::read(reader, design_file, source),
        }
    }

    fn imported(source: MeshSource, mesh: &ImportedMesh) -> Self {
        Self {
            source: Some(source),
            surface: Some(Arc::clone(&mesh.surface)),
            report: Arc::clone(&mesh.report).into(),
            ..Self::default()
        }
    }

    fn reference(&self) -> Option<&MeshReference> {
        self.source.as_ref()?.mesh.as_ref()
    }

    fn report(&self) -> Option<Arc<MeshReport>> {
        let surface = self.surface.as_ref()?;
        Some(Arc::clone(self.report.get_or_init(|| Arc::new(MeshReport::of(surface)))))
    }

    fn problem(&self, whose: MeshOwner, name: String) -> Option<MeshProblem> {
        let cause = Arc::clone(self.cause.as_ref()?);
        Some(MeshProblem { whose, name, reference: self.reference()?.clone(), cause })
    }

    /// Keeps an equal surface, so that nothing is made of it again; whether anything differs.
    fn differs_after(&mut self, before: &Self) -> bool {
        let cause = |mesh: &Self| mesh.cause.as_ref().map(ToString::to_string);
        if self.surface == before.surface {
            self.surface.clone_from(&before.surface);
            return self.surface.is_none() && cause(self) != cause(before);
        }
        true
    }
}

impl Meshes {
    pub(super) fn of_bodies(design: &Design, surfaces: [Option<Arc<SurfaceMesh>>; 2]) -> Self {
        let mut meshes = Self::default();
        for (role, surface) in BodyRole::ALL.into_iter().zip(surfaces) {
            let source = design.body(role).map(MeshSource::of_body);
            meshes.bodies[place(role)] = LoadedMesh { source, surface, ..LoadedMesh::default() };
        }
        meshes
    }

    pub(super) fn read(
        reader: &mut Reader,
        design_file: &Path,
        design: &Design,
        which: WhichMeshes,
    ) -> Self {
        let read = match which {
            WhichMeshes::All => LoadedMesh::read,
            WhichMeshes::Small => LoadedMesh::read_if_small,
            WhichMeshes::None => return Self::default(),
        };
        let mut meshes = Self::default();
        for (role, body) in design.bodies() {
            let source = MeshSource::of_body(body);
            meshes.bodies[place(role)] = read(reader, design_file, source);
        }
        for anatomy in &design.anatomy {
            if meshes.find_anatomy(&anatomy.mesh).is_none() {
                let source = MeshSource::of_anatomy(&anatomy.mesh);
                meshes.anatomy.push(read(reader, design_file, source));
            }
        }
        meshes
    }

    fn find_anatomy(&self, reference: &MeshReference) -> Option<&LoadedMesh> {
        self.anatomy.iter().find(|mesh| mesh.reference() == Some(reference))
    }

    /// Another state of a mesh, and whether it differs: read again where the source is another one,
    /// from the cache where it is there, or from the file in any case where that is forced.
    fn reread(
        &self,
        reader: &mut Reader,
        design_file: &Path,
        (before, source): (&LoadedMesh, MeshSource),
        is_forced: bool,
    ) -> (LoadedMesh, bool) {
        if !is_forced && before.source.as_ref() == Some(&source) {
            return (before.clone(), false);
        }
        let cached = source.mesh.as_ref().filter(|_| !is_forced).and_then(|mesh| {
            let from = source.referring_file(reader.storage, design_file);
            let file = reader.storage.resolve(&from, &mesh.file);
            let key = (reader.storage, file.as_path(), mesh.unit);
            // As it was read, if its file is still what it was then.
            self.cache.iter().find(|it| it.request.key() == key).filter(|it| it.is_current())
        });
        let mut now = match cached {
            Some(cached) => {
                reader.stamps.extend(cached.stamps.clone());
                LoadedMesh::imported(source, cached)
            }
            None => LoadedMesh::read(reader, design_file, source),
        };
        let differs = now.differs_after(before);
        (now, differs)
    }

    /// States that the design moved: its bodies' references, and what its files are called now.
    pub(super) fn moved(&mut self, design: &Design, file_now: impl Fn(&str) -> String) {
        for (mesh, role) in self.bodies.iter_mut().zip(BodyRole::ALL) {
            if mesh.source.is_some() {
                mesh.source = design.body(role).map(MeshSource::of_body);
            }
        }
        for mesh in &mut self.anatomy {
            if let Some(reference) = mesh.source.as_mut().and_then(|source| source.mesh.as_mut()) {
                reference.file = file_now(&reference.file);
            }
        }
    }

    /// Keeps what another world has at hand.
    pub(super) fn inherit(&mut self, other: &Self) {
        self.cache.clone_from(&other.cache);
    }

    pub(super) fn cache(&mut self, mesh: ImportedMesh) {
        self.cache.retain(|it| it.request.key() != mesh.request.key());
        self.cache.insert(0, mesh);
        self.cache.truncate(MOST_CACHED);
    }
}

fn place(role: BodyRole) -> usize {
    match role {
        BodyRole::Tool => 0,
        BodyRole::Crf => 1,
    }
}

/// A mesh that a body or the anatomy may get: what there is to read, for a thread that has no world.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshImport {
    pub whose: MeshOwner,
    /// How its owner would refer to it.
    pub reference: MeshReference,
    storage: Storage,
    file: PathBuf,
}

/// A mesh that was read, with its findings.
#[derive(Clone, Debug)]
pub struct ImportedMesh {
    pub request: MeshImport,
    pub surface: Arc<SurfaceMesh>,
    pub report: Arc<MeshReport>,
    stamps: Stamps,
}

impl MeshImport {
    /// The mesh of a body that the design may get; `None` where it has none.
    pub(super) fn of_body(
        storage: Storage,
        design_file: &Path,
        role: BodyRole,
        body: &DesignBody,
    ) -> Option<Self> {
        let reference = body.mesh.clone()?;
        let body_file = storage.resolve(design_file, &body.reference);
        let file = storage.resolve(&body_file, &reference.file);
        Some(Self { whose: role.into(), file, reference, storage })
    }

    /// The same file in another unit.
    pub fn with_unit(&self, unit: MeshUnit) -> Self {
        let mut other = self.clone();
        other.reference.unit = Some(unit);
        other
    }

    /// The file that is read.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Meshes of one key have the same surface.
    fn key(&self) -> (Storage, &Path, Option<MeshUnit>) {
        (self.storage, &self.file, self.reference.unit)
    }

    fn is_embedded(&self) -> bool {
        !self.storage.is_on_disk(&self.file)
    }

    /// Reads and examines it, which takes seconds for a million triangles: work for a thread.
    pub fn read(&self) -> Result<ImportedMesh, StoreError> {
        let mut stamps = Stamps::default();
        let surface = read(self.storage, &self.file, "a mesh", |bytes| {
            if !self.is_embedded() {
                stamps.take(&self.file, bytes);
            }
            Ok(mesh::read(bytes, &extension_of(&self.file), self.reference.unit)?)
        })?;
        Ok(ImportedMesh {
            request: self.clone(),
            report: Arc::new(MeshReport::of(&surface)),
            surface: Arc::new(surface),
            stamps,
        })
    }
}

impl ImportedMesh {
    fn is_current(&self) -> bool {
        self.request.is_embedded() || self.stamps.is_unchanged(&self.request.file)
    }
}
