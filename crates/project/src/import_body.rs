//! Another body for an open design, from a body file or a maker's definition: read by a thread that
//! has no world, and named so that Save puts it beside the design and over nobody's file.

use super::error::StoreError;
use super::mesh_cache::{ImportedMesh, MeshImport};
use super::open::{World, home};
use super::place::{Kind, Place, absolute, free_name};
use super::read::read;
use super::save::reach_mesh;
use super::tool::{body_name, extension_of};
use super::watch::Stamps;
use super::write::folder_of;
use std::path::{Path, PathBuf};
use trackwright_design::{BodyRole, DesignBody};
use trackwright_formats::tool_definition::{OnMismatch, read_body};
use trackwright_formats::{BodyFile, body};

/// A file that is to be the tool or the CRF: what there is to read.
#[derive(Clone, Debug)]
pub struct BodyImport {
    pub role: BodyRole,
    pub on_mismatch: OnMismatch,
    file: PathBuf,
    /// Of the design, and its file in its own place.
    place: Place,
    design_file: PathBuf,
    /// What it takes the place of.
    present: DesignBody,
    /// What the other body is referred to by.
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
    /// `None` where the design has no such body.
    ///
    /// # Errors
    /// A built-in design that is none.
    pub fn of_file(
        world: &World,
        role: BodyRole,
        file: &Path,
        on_mismatch: OnMismatch,
    ) -> Result<Option<Self>, StoreError> {
        let (place, design_file) = home(world.document.origin())?;
        let design = world.document.design();
        let Some(present) = design.body(role) else {
            return Ok(None);
        };
        let mut others = design.bodies().filter(|(other, _)| *other != role);
        Ok(Some(Self {
            role,
            on_mismatch,
            file: file.to_owned(),
            place,
            design_file,
            present: present.clone(),
            other_reference: others.next().map(|(_, body)| body.reference.clone()),
        }))
    }

    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Reads the body, and its mesh if it has one: work for a thread.
    ///
    /// # Errors
    /// See [`StoreError`]; a checksum that does not match only with [`OnMismatch::Refuse`].
    pub fn read(&self) -> Result<ImportedBody, StoreError> {
        let mut stamps = Stamps::default();
        let extension = extension_of(&self.file);
        let (found, kind) = read(Place::Disk, &self.file, Kind::TOOL, |bytes| {
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
        let mesh = MeshImport::of_body(self.place, &self.design_file, self.role, &body);
        Ok(ImportedBody {
            role: self.role,
            mesh: mesh.and_then(|mesh| mesh.read().ok()),
            body,
            stamps,
        })
    }

    /// Whether a body file lies where the design's own are saved.
    fn is_own_place(&self, file: &Path) -> bool {
        self.place == Place::Disk
            && absolute(&folder_of(file)) == absolute(&folder_of(&self.design_file))
    }

    fn as_design_body(&self, found: BodyFile, name: &str, is_body_file: bool) -> DesignBody {
        let mut body = DesignBody {
            reference: self.reference(name, is_body_file),
            mesh: found.mesh,
            rigid: found.rigid,
            definition: found.definition,
        };
        self.reach_mesh(&mut body);
        // What is there already is not another one because its file would be called otherwise.
        let mut again = body.clone();
        again.reference.clone_from(&self.present.reference);
        if text(&again) == text(&self.present) {
            return self.present.clone();
        }
        body
    }

    /// What the design refers to the body by: its own file where that lies beside the design, else
    /// a name there that nothing has yet.
    fn reference(&self, name: &str, is_body_file: bool) -> String {
        let is_others = |name: &str| self.other_reference.as_deref() == Some(name);
        if is_body_file && self.is_own_place(&self.file) && !is_others(name) {
            return name.to_owned();
        }
        let folder = folder_of(&self.design_file);
        let is_free = |path: &PathBuf| {
            let name = file_name(path);
            let exists = self.place == Place::Disk && path.exists();
            !exists && !is_others(&name) && self.present.reference != name
        };
        file_name(&free_name(&folder.join(name), is_free))
    }

    /// Leads to the same mesh from where the body will be; a built-in design has no place on the
    /// disk, so that the whole path does there.
    fn reach_mesh(&self, body: &mut DesignBody) {
        match self.place {
            Place::Disk => {
                let own_file = folder_of(&self.design_file).join(&body.reference);
                reach_mesh(&mut body.mesh, &self.file, &own_file);
            }
            Place::BuiltIn => {
                if let Some(mesh) = &mut body.mesh {
                    let file = Place::Disk.resolve(&self.file, &mesh.file);
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
            self.mesh_cache.keep(mesh.clone());
        }
    }
}

fn text(body: &DesignBody) -> String {
    body::write(&BodyFile::of(body))
}

fn file_name(file: &Path) -> String {
    let name = file.file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests;
