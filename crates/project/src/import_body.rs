//! Another body for an open design, from a body file or a maker's definition: read by a thread that
//! has no world, and named so that Save puts it beside the design and over nobody's file.

use super::error::StoreError;
use super::meshes::{ImportedMesh, MeshImport};
use super::paths::{absolute, extension_of, file_name, folder_of, free_name};
use super::read::{Kind, Storage, read};
use super::reader::home;
use super::stamps::Stamps;
use super::tool::{body_name, body_text, reach_mesh};
use super::world::World;
use std::path::{Path, PathBuf};
use trackwright_design::{BodyRole, DesignBody};
use trackwright_formats::BodyFile;
use trackwright_formats::tool_definition::{OnMismatch, read_body};

/// A file that is to be the tool or the CRF: what there is to read.
#[derive(Clone, Debug)]
pub struct BodyImport {
    pub role: BodyRole,
    pub on_mismatch: OnMismatch,
    file: PathBuf,
    storage: Storage,
    design_file: PathBuf,
    /// `None` where the design is to gain a CRF.
    present: Option<DesignBody>,
    other_reference: Option<String>,
}

/// A body that was read, as the design would hold it.
#[derive(Clone, Debug)]
pub struct ImportedBody {
    pub role: BodyRole,
    pub body: DesignBody,
    /// `None` where it has none, or one that cannot be read: that is missed after the edit.
    mesh: Option<ImportedMesh>,
    stamps: Stamps,
}

impl BodyImport {
    /// A file for a body, in the place of the present one if there is one.
    pub fn of_file(
        world: &World,
        role: BodyRole,
        file: &Path,
        on_mismatch: OnMismatch,
    ) -> Result<Self, StoreError> {
        let (storage, design_file) = home(world.document.origin())?;
        let design = world.document.design();
        let mut others = design.bodies().filter(|(other, _)| *other != role);
        Ok(Self {
            role,
            on_mismatch,
            file: file.to_owned(),
            storage,
            design_file,
            present: design.body(role).cloned(),
            other_reference: others.next().map(|(_, body)| body.reference.clone()),
        })
    }

    /// The file that is read.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Reads the body and its mesh: work for a thread. A wrong checksum is refused unless accepted.
    pub fn read(&self) -> Result<ImportedBody, StoreError> {
        let mut stamps = Stamps::default();
        let extension = extension_of(&self.file);
        let (found, kind) = read(Storage::Disk, &self.file, Kind::TOOL, |bytes| {
            if self.is_own_place(&self.file) {
                stamps.take(&self.file, bytes);
            }
            read_body(bytes, &extension, self.on_mismatch)
        })?;
        let name = match kind {
            None if extension.eq_ignore_ascii_case("ron") => file_name(&self.file),
            _ => body_name(&self.file),
        };
        let body = self.as_design_body(found, &name, kind.is_none());
        let mesh = MeshImport::of_body(self.storage, &self.design_file, self.role, &body);
        Ok(ImportedBody {
            role: self.role,
            mesh: mesh.and_then(|mesh| mesh.read().ok()),
            body,
            stamps,
        })
    }

    fn is_own_place(&self, file: &Path) -> bool {
        self.storage == Storage::Disk
            && absolute(&folder_of(file)) == absolute(&folder_of(&self.design_file))
    }

    fn as_design_body(&self, found: BodyFile, name: &str, is_body_file: bool) -> DesignBody {
        let mut body = DesignBody {
            reference: self.reference(name, is_body_file),
            mesh: found.mesh,
            rigid: found.rigid,
            definition: found.definition,
            mounting: found.mounting,
        };
        self.reach_mesh(&mut body);
        // What is there already is not another one because its file would be called otherwise.
        let is_same = |present: &&DesignBody| {
            let reference = present.reference.clone();
            body_text(&DesignBody { reference, ..body.clone() }) == body_text(present)
        };
        self.present.as_ref().filter(is_same).cloned().unwrap_or(body)
    }

    /// The design's reference: the file itself beside the design, else a free name there.
    fn reference(&self, name: &str, is_body_file: bool) -> String {
        let is_others = |name: &str| self.other_reference.as_deref() == Some(name);
        if is_body_file && self.is_own_place(&self.file) && !is_others(name) {
            return name.to_owned();
        }
        let folder = folder_of(&self.design_file);
        let is_free = |path: &PathBuf| {
            let name = file_name(path);
            let exists = self.storage == Storage::Disk && path.exists();
            let is_own = self.present.as_ref().is_some_and(|present| present.reference == name);
            !exists && !is_others(&name) && !is_own
        };
        file_name(&free_name(&folder.join(name), is_free))
    }

    /// Leads to the same mesh from the body's file; by the whole path in a built-in design.
    fn reach_mesh(&self, body: &mut DesignBody) {
        match self.storage {
            Storage::Disk => {
                let own_file = folder_of(&self.design_file).join(&body.reference);
                reach_mesh(&mut body.mesh, &self.file, &own_file);
            }
            Storage::BuiltIn => {
                if let Some(mesh) = &mut body.mesh {
                    let file = Storage::Disk.resolve(&self.file, &mesh.file);
                    mesh.file = absolute(&file).to_string_lossy().into_owned();
                }
            }
        }
    }
}

impl World {
    /// Keeps at hand what was read with a body, for an edit that is going to put it in.
    pub fn keep_body(&mut self, taken: &ImportedBody) {
        self.stamps.extend(taken.stamps.clone());
        if let Some(mesh) = &taken.mesh {
            self.meshes.cache(mesh.clone());
        }
    }
}
