//! The meshes of an open design, its bodies' and its anatomy: read with it, again when an edit names
//! others, and missed rather than demanded, as no number depends on them.

use super::anatomy::{AnatomyMeshes, refresh_anatomy};
use super::error::StoreError;
use super::mesh_cache::{ImportedMesh, MeshImport};
use super::open::{Reader, World, home};
use super::place::{Place, absolute, relative};
use super::write::folder_of;
use std::path::Path;
use std::sync::{Arc, OnceLock};
use trackwright_design::{BodyRole, Design, DesignBody, Origin};
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_geometry::mesh_reference::MeshReference;
use trackwright_geometry::mesh_report::MeshReport;

/// Whose a mesh is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MeshOwner {
    Body(BodyRole),
    /// Anatomy by its place in the design's list; `None` for what is not yet in it.
    Anatomy(Option<usize>),
}

impl From<BodyRole> for MeshOwner {
    fn from(role: BodyRole) -> Self {
        Self::Body(role)
    }
}

/// Within a sentence.
impl std::fmt::Display for MeshOwner {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Body(role) => role.fmt(f),
            Self::Anatomy(_) => f.write_str("anatomy"),
        }
    }
}

/// Why a mesh is not there; the design keeps its reference.
#[derive(Clone, Debug)]
pub struct MeshProblem {
    pub whose: MeshOwner,
    /// Of the anatomy; a body is told by its role.
    pub name: String,
    /// What the body or the design refers to.
    pub reference: MeshReference,
    pub cause: Arc<StoreError>,
}

impl std::fmt::Display for MeshProblem {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.whose {
            MeshOwner::Body(role) => write!(f, "the {role}'s mesh is missing: {}", self.cause),
            MeshOwner::Anatomy(_) => {
                write!(f, "the anatomy {:?} is missing: {}", self.name, self.cause)
            }
        }
    }
}

/// Something wrong with a mesh that was read all the same.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshDoubt {
    pub whose: MeshOwner,
    /// As of [`MeshProblem`].
    pub name: String,
    pub text: String,
}

impl std::fmt::Display for MeshDoubt {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.whose {
            MeshOwner::Body(role) => write!(f, "the {role}'s mesh: {}", self.text),
            MeshOwner::Anatomy(_) => write!(f, "the anatomy {:?}: {}", self.name, self.text),
        }
    }
}

impl World {
    /// What is wrong with the meshes that were read, as their reports have it.
    pub fn mesh_doubts(&self) -> Vec<MeshDoubt> {
        let design = self.document.design();
        let bodies = BodyRole::ALL
            .into_iter()
            .filter_map(|role| Some((role.into(), role.to_string(), self.mesh_report(role)?)));
        let anatomy = design.anatomy.iter().enumerate().filter_map(|(index, own)| {
            let whose = MeshOwner::Anatomy(Some(index));
            Some((whose, own.name.clone(), self.anatomy_report(&own.mesh)?))
        });
        let mut doubts = Vec::new();
        for (whose, name, report) in bodies.chain(anatomy) {
            let faults = report.findings().into_iter().filter(|it| it.is_fault);
            doubts.extend(faults.map(|fault| MeshDoubt {
                whose,
                name: name.clone(),
                text: fault.text,
            }));
        }
        doubts
    }
}

/// The meshes of an open design, as far as they were read.
#[derive(Clone, Debug, Default)]
pub(super) struct Meshes {
    /// The tool's and the CRF's.
    pub(super) bodies: [BodyMesh; 2],
    pub(super) anatomy: AnatomyMeshes,
}

impl Meshes {
    pub(super) fn read(reader: &mut Reader, design_file: &Path, design: &Design) -> Self {
        Self {
            bodies: BodyRole::ALL.map(|role| {
                design.body(role).map_or_else(BodyMesh::default, |body| {
                    BodyMesh::read(reader, design_file, body)
                })
            }),
            anatomy: AnatomyMeshes::read(reader, design_file, design),
        }
    }
}

/// The mesh of one body as it was read, or not.
#[derive(Clone, Debug, Default)]
pub(super) struct BodyMesh {
    /// What it was read by; `None` where nobody looked yet.
    source: Option<Source>,
    pub(super) surface: Option<Arc<SurfaceMesh>>,
    /// Made when it is first asked for.
    report: OnceLock<Arc<MeshReport>>,
    cause: Option<Arc<StoreError>>,
}

/// What leads to a mesh: the body's reference, and the mesh's in the body, if it has one.
#[derive(Clone, Debug, PartialEq)]
struct Source {
    body: String,
    mesh: Option<MeshReference>,
}

impl BodyMesh {
    /// A mesh that the body refers to now.
    pub(super) fn current(body: Option<&DesignBody>, surface: Option<Arc<SurfaceMesh>>) -> Self {
        Self { source: body.map(Source::of), surface, ..Self::default() }
    }

    /// A mesh that was read before.
    pub(super) fn kept(body: &DesignBody, mesh: &ImportedMesh) -> Self {
        Self {
            source: Some(Source::of(body)),
            surface: Some(Arc::clone(&mesh.surface)),
            report: Arc::clone(&mesh.report).into(),
            cause: None,
        }
    }

    /// Reads what the body refers to; a failure is kept beside it.
    fn read(reader: &mut Reader, design_file: &Path, body: &DesignBody) -> Self {
        let (surface, cause) = match reader.mesh(design_file, body) {
            Ok(surface) => (surface, None),
            Err(error) => (None, Some(Arc::new(error))),
        };
        Self { source: Some(Source::of(body)), surface, report: OnceLock::new(), cause }
    }

    /// What there is to say of the mesh.
    pub(super) fn report(&self) -> Option<Arc<MeshReport>> {
        let surface = self.surface.as_ref()?;
        let report = self.report.get_or_init(|| Arc::new(MeshReport::of(surface)));
        Some(Arc::clone(report))
    }

    /// States that the body refers to the same mesh by other words now.
    pub(super) fn moved(&mut self, body: Option<&DesignBody>) {
        if self.source.is_some() {
            self.source = body.map(Source::of);
        }
    }

    pub(super) fn problem(&self, body: BodyRole) -> Option<MeshProblem> {
        Some(MeshProblem {
            whose: body.into(),
            name: body.to_string(),
            cause: Arc::clone(self.cause.as_ref()?),
            reference: self.source.as_ref()?.mesh.clone()?,
        })
    }
}

impl Source {
    fn of(body: &DesignBody) -> Self {
        Self { body: body.reference.clone(), mesh: body.mesh.clone() }
    }
}

/// Reads the meshes again that the design now refers to otherwise, as after an edit, its undo or a
/// recovery; whether there were any. What cannot be read is a [`World::mesh_problems`], not an
/// error: a body without mesh is drawn by its sensors, anatomy without one not at all.
///
/// # Errors
/// A built-in design that is none.
pub fn refresh_meshes(world: &mut World) -> Result<bool, StoreError> {
    read_meshes(world, false)
}

/// Reads all meshes again, as after their files were changed or put back; whether any differs.
///
/// # Errors
/// As [`refresh_meshes`].
pub fn reload_meshes(world: &mut World) -> Result<bool, StoreError> {
    read_meshes(world, true)
}

fn read_meshes(world: &mut World, is_forced: bool) -> Result<bool, StoreError> {
    let design = world.document.shared_design();
    let (place, file) = home(world.document.origin())?;
    let mut reader = Reader::new(place);
    let mut is_changed = false;
    for role in BodyRole::ALL {
        let body = design.body(role);
        let has = world.body_mesh(role);
        if has.source == body.map(Source::of) && !is_forced {
            continue;
        }
        let kept = match body.and_then(|body| body.mesh.clone()) {
            Some(mesh) if !is_forced => MeshImport::of_reference(world, role.into(), mesh)?,
            _ => None,
        };
        let kept = kept.and_then(|wanted| world.mesh_cache.find(&wanted));
        let mut now = match (body, kept) {
            (None, _) => BodyMesh::default(),
            (Some(body), Some(kept)) => {
                reader.stamps.extend(kept.stamps());
                BodyMesh::kept(body, kept)
            }
            (Some(body), None) => BodyMesh::read(&mut reader, &file, body),
        };
        if now.surface == has.surface {
            // Whoever made something of it need not make it again.
            now.surface.clone_from(&has.surface);
        }
        is_changed |= match (&now.surface, &has.surface) {
            (Some(now), Some(before)) => !Arc::ptr_eq(now, before),
            (None, None) => words(now.cause.as_ref()) != words(has.cause.as_ref()),
            _ => true,
        };
        world.set_body_mesh(role, now);
    }
    is_changed |= refresh_anatomy(world, &mut reader, &file, is_forced)?;
    world.stamps.extend(reader.stamps);
    Ok(is_changed)
}

/// What went wrong, to be compared.
pub(super) fn words(cause: Option<&Arc<StoreError>>) -> Option<String> {
    cause.map(ToString::to_string)
}

/// How a body, or the design its anatomy, refers to a mesh file: relative to its own file, or by the
/// whole path in a built-in design, which has no place on the disk. `None` where there is no such
/// body.
pub fn mesh_reference_to(
    world: &World,
    whose: impl Into<MeshOwner>,
    mesh_file: &Path,
) -> Option<String> {
    let body = match whose.into() {
        MeshOwner::Body(role) => Some(world.document.design().body(role)?),
        MeshOwner::Anatomy(_) => None,
    };
    Some(match world.document.origin() {
        Origin::File(design_file) => {
            let own_file = match body {
                Some(body) => Place::Disk.resolve(design_file, &body.reference),
                None => design_file.clone(),
            };
            relative(&folder_of(&own_file), mesh_file)
        }
        Origin::BuiltIn(_) => absolute(mesh_file).to_string_lossy().into_owned(),
    })
}
