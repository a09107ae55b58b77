//! Opens a design with its environment, bodies and meshes.

use super::builtin;
use super::error::StoreError;
use super::place::Place;
use super::read::{read, read_mesh_at};
use crate::design::{BodyRole, CrfPlacement, Design, DesignBody, Document, Origin, ToolPlacement};
use crate::field::Environment;
use crate::formats::{BodyFile, body, design_file, environment};
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
    world.environment = open_environment(place, &file, reference)?;
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
    let entry = read(place, file, "a design", design_file::parse)?;
    let environment = open_environment(place, file, &entry.environment)?;
    let (tool_body, tool_mesh) = open_body(place, file, entry.tool_body)?;
    let (crf, crf_mesh) = match entry.crf {
        None => (None, None),
        Some(crf) => {
            let (body, mesh) = open_body(place, file, crf.body)?;
            let placement = CrfPlacement {
                body,
                tracker_from_crf: crf.tracker_from_crf,
                targets: crf.targets,
                motion: crf.motion,
                requirement: crf.requirement,
            };
            (Some(placement), mesh)
        }
    };
    let design = Design {
        name: entry.name,
        environment: entry.environment,
        crf,
        tool: ToolPlacement {
            body: tool_body,
            crf_from_tool: entry.crf_from_tool,
        },
        motion: entry.motion,
        orientation_weight_mm: entry.orientation_weight_mm,
        requirement: entry.requirement,
    };
    let document = Document::new(design, entry.view, origin);
    Ok(World::new(document, environment, tool_mesh, crf_mesh))
}

fn open_environment(
    place: Place,
    design_file: &Path,
    reference: &str,
) -> Result<Arc<Environment>, StoreError> {
    let file = place.resolve(design_file, reference);
    read(place, &file, "an environment", environment::parse).map(Arc::new)
}

type OpenBody = (DesignBody, Option<Arc<SurfaceMesh>>);

fn open_body(place: Place, design_file: &Path, reference: String) -> Result<OpenBody, StoreError> {
    let file = place.resolve(design_file, &reference);
    let BodyFile { rigid, mesh } = read(place, &file, "a body", body::parse)?;
    let surface = mesh
        .as_deref()
        .map(|mesh| read_mesh_at(place, &place.resolve(&file, mesh)).map(Arc::new))
        .transpose()?;
    let body = DesignBody {
        reference,
        mesh,
        rigid,
    };
    Ok((body, surface))
}
