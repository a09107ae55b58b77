//! The meshes that an open design refers to now, and those that it may get.

use super::super::error::StoreError;
use super::super::paths::{absolute, folder_of, relative};
use super::super::read::Storage;
use super::super::reader::{Reader, home};
use super::super::world::World;
use super::{
    ImportedMesh, LoadedMesh, MeshDoubt, MeshImport, MeshOwner, MeshProblem, MeshSource, place,
};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use trackwright_design::{BodyRole, Origin};
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_geometry::mesh_reference::{MeshReference, MeshUnit};
use trackwright_geometry::mesh_report::MeshReport;

impl World {
    /// The mesh of a body; `None` where it has none or it could not be read.
    pub fn mesh(&self, role: BodyRole) -> Option<&Arc<SurfaceMesh>> {
        self.meshes.bodies[place(role)].surface.as_ref()
    }

    /// Findings on a body's mesh, made on first use.
    pub fn mesh_report(&self, role: BodyRole) -> Option<Arc<MeshReport>> {
        self.meshes.bodies[place(role)].report()
    }

    /// The mesh that anatomy refers to; `None` where it could not be read.
    pub fn anatomy_mesh(&self, reference: &MeshReference) -> Option<&Arc<SurfaceMesh>> {
        self.meshes.find_anatomy(reference)?.surface.as_ref()
    }

    /// Findings on a mesh of the anatomy, made on first use.
    pub fn anatomy_report(&self, reference: &MeshReference) -> Option<Arc<MeshReport>> {
        self.meshes.find_anatomy(reference)?.report()
    }

    /// Keeps the meshes at hand that another world has, for a design that is opened in its place.
    pub fn inherit_meshes(&mut self, other: &Self) {
        self.meshes.inherit(&other.meshes);
    }

    /// Keeps a mesh at hand, for an edit that is going to name it. Where its owner refers to it
    /// already, as after its file was written anew, it is its own from now on; whether it is.
    pub fn keep_mesh(&mut self, mesh: ImportedMesh) -> bool {
        let design = self.document.shared_design();
        let reference = &mesh.request.reference;
        let is_used = match mesh.request.whose {
            MeshOwner::Anatomy(_) => {
                let is_used = design.anatomy.iter().any(|it| it.mesh == *reference);
                if is_used {
                    self.meshes.anatomy.retain(|it| it.reference() != Some(reference));
                    let loaded = LoadedMesh::imported(MeshSource::of_anatomy(reference), &mesh);
                    self.meshes.anatomy.push(loaded);
                }
                is_used
            }
            MeshOwner::Body(role) => {
                let body = design.body(role).filter(|body| body.mesh.as_ref() == Some(reference));
                if let Some(body) = body {
                    let loaded = LoadedMesh::imported(MeshSource::of_body(body), &mesh);
                    self.meshes.bodies[place(role)] = loaded;
                }
                body.is_some()
            }
            // The object that an edit adds has the surface itself.
            MeshOwner::NewMetal | MeshOwner::NewTool => false,
        };
        if is_used {
            self.stamps.extend(mesh.stamps.clone());
        }
        self.meshes.cache(mesh);
        is_used
    }

    /// The meshes that are left to be read by a thread, which [`World::keep_mesh`] or
    /// [`World::miss_mesh`] then gets.
    pub fn awaited_meshes(&self) -> Vec<MeshImport> {
        let design = self.document.design();
        let bodies = design.bodies().filter_map(|(role, body)| {
            let is_awaited = self.meshes.bodies[place(role)].is_awaited;
            Some((role.into(), body.mesh.clone().filter(|_| is_awaited)?))
        });
        let anatomy = design.anatomy.iter().enumerate().filter_map(|(index, own)| {
            let is_awaited = self.meshes.find_anatomy(&own.mesh)?.is_awaited;
            is_awaited.then(|| (MeshOwner::Anatomy(Some(index)), own.mesh.clone()))
        });
        let import = |(whose, reference)| MeshImport::of_reference(self, whose, reference);
        bodies.chain(anatomy).filter_map(|awaited| import(awaited).ok().flatten()).collect()
    }

    /// States that an awaited mesh could not be read; whether it was still awaited.
    pub fn miss_mesh(&mut self, missed: &MeshImport, cause: StoreError) -> bool {
        if !self.awaited_meshes().contains(missed) {
            return false;
        }
        let mesh = match missed.whose {
            MeshOwner::Body(role) => Some(&mut self.meshes.bodies[place(role)]),
            MeshOwner::Anatomy(_) => {
                let mut all = self.meshes.anatomy.iter_mut();
                all.find(|mesh| mesh.reference() == Some(&missed.reference))
            }
            MeshOwner::NewMetal | MeshOwner::NewTool => None,
        };
        if let Some(mesh) = mesh {
            mesh.is_awaited = false;
            mesh.cause = Some(Arc::new(cause));
        }
        true
    }

    /// The meshes that the design refers to, each with its owner and the owner's name.
    fn owned_meshes(&self) -> impl Iterator<Item = (MeshOwner, String, &LoadedMesh)> {
        let bodies = BodyRole::ALL
            .into_iter()
            .map(|role| (role.into(), role.to_string(), &self.meshes.bodies[place(role)]));
        let anatomy = self.document.design().anatomy.iter().enumerate();
        let anatomy = anatomy.filter_map(|(index, own)| {
            let whose = MeshOwner::Anatomy(Some(index));
            Some((whose, own.name.clone(), self.meshes.find_anatomy(&own.mesh)?))
        });
        bodies.chain(anatomy)
    }

    /// The meshes that could not be read, and why.
    pub fn mesh_problems(&self) -> Vec<MeshProblem> {
        self.owned_meshes().filter_map(|(whose, name, mesh)| mesh.problem(whose, name)).collect()
    }

    /// What is wrong with the meshes that were read, as their reports have it.
    pub fn mesh_doubts(&self) -> Vec<MeshDoubt> {
        let reported = self.owned_meshes();
        let reported =
            reported.filter_map(|(whose, name, mesh)| Some((whose, name, mesh.report()?)));
        let doubts = reported.flat_map(|(whose, name, report)| {
            let faults = report.findings().into_iter().filter(|it| it.is_fault);
            let doubt = move |text| MeshDoubt { whose, name: name.clone(), text };
            faults.map(|fault| doubt(fault.text)).collect::<Vec<_>>()
        });
        doubts.collect()
    }
}

/// Reads the meshes again that the design now refers to otherwise, as after an edit, its undo or a
/// recovery; whether any differs. Fails only for a built-in design that does not exist.
pub fn refresh_meshes(world: &mut World) -> Result<bool, StoreError> {
    read_meshes(world, false)
}

/// Reads all meshes again, as after their files were changed or put back; whether any differs.
pub fn reload_meshes(world: &mut World) -> Result<bool, StoreError> {
    read_meshes(world, true)
}

fn read_meshes(world: &mut World, is_forced: bool) -> Result<bool, StoreError> {
    let design = world.document.shared_design();
    let (storage, file) = home(world.document.origin())?;
    let mut reader = Reader::new(storage);
    let mut is_changed = false;
    for role in BodyRole::ALL {
        let before = &world.meshes.bodies[place(role)];
        let (now, differs) = match design.body(role) {
            Some(body) => {
                let source = MeshSource::of_body(body);
                world.meshes.reread(&mut reader, &file, (before, source), is_forced)
            }
            None => {
                let mut none = LoadedMesh::default();
                let differs = none.differs_after(before);
                (none, differs)
            }
        };
        is_changed |= differs;
        world.meshes.bodies[place(role)] = now;
    }
    let mut anatomy: Vec<LoadedMesh> = Vec::new();
    for reference in design.anatomy.iter().map(|anatomy| &anatomy.mesh) {
        if anatomy.iter().all(|mesh| mesh.reference() != Some(reference)) {
            let before = world.meshes.find_anatomy(reference).cloned().unwrap_or_default();
            let source = MeshSource::of_anatomy(reference);
            let (now, differs) =
                world.meshes.reread(&mut reader, &file, (&before, source), is_forced);
            is_changed |= differs;
            anatomy.push(now);
        }
    }
    world.meshes.anatomy = anatomy;
    world.stamps.extend(reader.stamps);
    Ok(is_changed)
}

/// How a body, the design its anatomy, or the room its metal refers to a mesh file: relative to its own file, or by the
/// whole path in a built-in design, which is not on the disk. `None` where there is no such body.
pub fn mesh_reference_to(
    world: &World,
    whose: impl Into<MeshOwner>,
    mesh_file: &Path,
) -> Option<String> {
    let design = world.document.design();
    let whose = whose.into();
    let own = match whose {
        MeshOwner::Body(role) => Some(&design.body(role)?.reference),
        MeshOwner::Anatomy(_) | MeshOwner::NewTool => None,
        MeshOwner::NewMetal => Some(&design.environment),
    };
    // A new design is of the built-in world until it is saved.
    if whose == MeshOwner::NewTool {
        return Some(absolute(mesh_file).to_string_lossy().into_owned());
    }
    let Origin::File(design_file) = world.document.origin() else {
        return Some(absolute(mesh_file).to_string_lossy().into_owned());
    };
    let resolve = |own: &String| Storage::Disk.resolve(design_file, own);
    let own_file = own.map_or_else(|| design_file.clone(), resolve);
    Some(relative(&folder_of(&own_file), mesh_file))
}

impl MeshImport {
    /// A file for a body or the anatomy; `None` where there is no such body.
    pub fn of_file(
        world: &World,
        whose: impl Into<MeshOwner>,
        mesh_file: &Path,
        unit: Option<MeshUnit>,
    ) -> Result<Option<Self>, StoreError> {
        let whose = whose.into();
        match mesh_reference_to(world, whose, mesh_file) {
            Some(file) => Self::of_reference(world, whose, MeshReference { file, unit }),
            None => Ok(None),
        }
    }

    /// The owner's present mesh in another unit, or in that of its format.
    pub fn in_unit(
        world: &World,
        whose: impl Into<MeshOwner>,
        unit: Option<MeshUnit>,
    ) -> Result<Option<Self>, StoreError> {
        let whose = whose.into();
        let design = world.document.design();
        let own = match whose {
            MeshOwner::Body(role) => design.body(role).and_then(|body| body.mesh.clone()),
            MeshOwner::Anatomy(index) => index
                .and_then(|index| design.anatomy.get(index))
                .map(|anatomy| anatomy.mesh.clone()),
            MeshOwner::NewMetal | MeshOwner::NewTool => None,
        };
        match own {
            Some(own) => Self::of_reference(world, whose, MeshReference { unit, ..own }),
            None => Ok(None),
        }
    }

    fn of_reference(
        world: &World,
        whose: MeshOwner,
        reference: MeshReference,
    ) -> Result<Option<Self>, StoreError> {
        let (storage, design_file) = match whose {
            MeshOwner::NewTool => (Storage::BuiltIn, PathBuf::new()),
            _ => home(world.document.origin())?,
        };
        let own_file = match whose {
            MeshOwner::Anatomy(_) | MeshOwner::NewTool => design_file,
            MeshOwner::NewMetal => {
                storage.resolve(&design_file, &world.document.design().environment)
            }
            MeshOwner::Body(role) => match world.document.design().body(role) {
                Some(body) => storage.resolve(&design_file, &body.reference),
                None => return Ok(None),
            },
        };
        let file = storage.resolve(&own_file, &reference.file);
        Ok(Some(Self { whose, file, reference, storage }))
    }
}
