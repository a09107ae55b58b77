//! Meshes that were read for a body or the anatomy but are not, or no longer, its own: what a thread
//! read before an edit names it, and what undo comes back to. None of them is read twice.

use super::error::StoreError;
use super::meshes::MeshOwner;
use super::open::{World, home};
use super::place::Place;
use super::read::read;
use super::watch::Stamps;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use trackwright_design::{BodyRole, DesignBody};
use trackwright_formats::mesh;
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_geometry::mesh_reference::{MeshReference, MeshUnit};
use trackwright_geometry::mesh_report::MeshReport;

/// Meshes that are kept; a million triangles take some 100 MB.
const MOST: usize = 4;

/// A mesh that a body or the anatomy may get: what there is to read, for a thread that has no
/// world.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshImport {
    pub whose: MeshOwner,
    /// How its owner would refer to it.
    pub reference: MeshReference,
    place: Place,
    file: PathBuf,
}

/// A mesh that was read, with what there is to say of it.
#[derive(Clone, Debug)]
pub struct ImportedMesh {
    pub wanted: MeshImport,
    pub surface: Arc<SurfaceMesh>,
    pub report: Arc<MeshReport>,
    stamps: Stamps,
}

/// The meshes that were read last.
#[derive(Clone, Debug, Default)]
pub(super) struct MeshCache(Vec<ImportedMesh>);

impl MeshImport {
    /// A file for a body or the anatomy; `None` where there is no such body.
    ///
    /// # Errors
    /// A built-in design that is none.
    pub fn of_file(
        world: &World,
        whose: impl Into<MeshOwner>,
        mesh_file: &Path,
        unit: Option<MeshUnit>,
    ) -> Result<Option<Self>, StoreError> {
        let whose = whose.into();
        let Some(file) = super::mesh_reference_to(world, whose, mesh_file) else {
            return Ok(None);
        };
        Self::of_reference(world, whose, MeshReference { file, unit })
    }

    /// The owner's present mesh in another unit, or in that of its format.
    ///
    /// # Errors
    /// A built-in design that is none.
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
        };
        let Some(own) = own else {
            return Ok(None);
        };
        Self::of_reference(world, whose, MeshReference { unit, ..own })
    }

    pub(super) fn of_reference(
        world: &World,
        whose: MeshOwner,
        reference: MeshReference,
    ) -> Result<Option<Self>, StoreError> {
        let (place, design_file) = home(world.document.origin())?;
        let own_file = match whose {
            MeshOwner::Anatomy(_) => design_file,
            MeshOwner::Body(role) => {
                let Some(body) = world.document.design().body(role) else {
                    return Ok(None);
                };
                place.resolve(&design_file, &body.reference)
            }
        };
        Ok(Some(Self { whose, file: place.resolve(&own_file, &reference.file), reference, place }))
    }

    /// The mesh of a body that the design may get; `None` where it has none.
    pub(super) fn of_body(
        place: Place,
        design_file: &Path,
        role: BodyRole,
        body: &DesignBody,
    ) -> Option<Self> {
        let reference = body.mesh.clone()?;
        let body_file = place.resolve(design_file, &body.reference);
        Some(Self {
            whose: role.into(),
            file: place.resolve(&body_file, &reference.file),
            reference,
            place,
        })
    }

    /// The same file in another unit.
    pub fn with_unit(&self, unit: MeshUnit) -> Self {
        let mut other = self.clone();
        other.reference.unit = Some(unit);
        other
    }

    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Reads it and looks at it, which takes seconds for a million triangles: work for a thread.
    ///
    /// # Errors
    /// See [`StoreError`].
    pub fn read(&self) -> Result<ImportedMesh, StoreError> {
        let mut stamps = Stamps::default();
        let extension = self.file.extension().unwrap_or_default().to_string_lossy();
        let surface = read(self.place, &self.file, "a mesh", |bytes| {
            if self.place == Place::Disk || self.file.is_absolute() {
                stamps.take(&self.file, bytes);
            }
            Ok(mesh::read(bytes, &extension, self.reference.unit)?)
        })?;
        Ok(ImportedMesh {
            wanted: self.clone(),
            report: Arc::new(MeshReport::of(&surface)),
            surface: Arc::new(surface),
            stamps,
        })
    }
}

impl MeshCache {
    pub(super) fn keep(&mut self, mesh: ImportedMesh) {
        self.0.retain(|kept| !kept.is_of(&mesh.wanted));
        self.0.insert(0, mesh);
        self.0.truncate(MOST);
    }

    /// The mesh as it was read, if its file is still what it was then.
    pub(super) fn find(&self, wanted: &MeshImport) -> Option<&ImportedMesh> {
        let kept = self.0.iter().find(|kept| kept.is_of(wanted))?;
        kept.is_current().then_some(kept)
    }
}

impl ImportedMesh {
    fn is_of(&self, wanted: &MeshImport) -> bool {
        let own = &self.wanted;
        (own.place, &own.file, own.reference.unit)
            == (wanted.place, &wanted.file, wanted.reference.unit)
    }

    fn is_current(&self) -> bool {
        let is_embedded = self.wanted.place == Place::BuiltIn && !self.wanted.file.is_absolute();
        is_embedded || self.stamps.is_unchanged(&self.wanted.file)
    }

    pub(super) fn stamps(&self) -> Stamps {
        self.stamps.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{open_builtin, refresh_meshes};
    use std::fs;
    use trackwright_design::Edit;

    /// A tetrahedron of this size, as OBJ.
    fn tetrahedron(size: f64) -> String {
        format!(
            "v 0 0 0\nv {size} 0 0\nv 0 {size} 0\nv 0 0 {size}\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
        )
    }

    fn give(world: &mut World, reference: &MeshReference) {
        let edit = Edit::SetMesh { body: BodyRole::Tool, mesh: Some(reference.clone()) };
        world.document.apply(edit).unwrap();
        refresh_meshes(world).unwrap();
    }

    #[test]
    fn a_mesh_that_was_read_for_a_body_is_not_read_again_unless_its_file_changed() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("tool.obj");
        fs::write(&file, tetrahedron(100.0)).unwrap();
        let mut world = open_builtin("pointer-on-head").unwrap();
        let own = Arc::clone(world.mesh(BodyRole::Tool).unwrap());
        let wanted = MeshImport::of_file(&world, BodyRole::Tool, &file, None).unwrap();
        let read = wanted.unwrap().read().unwrap();
        world.keep_mesh(read.clone());
        give(&mut world, &read.wanted.reference);
        assert!(Arc::ptr_eq(world.mesh(BodyRole::Tool).unwrap(), &read.surface));
        let report = world.mesh_report(BodyRole::Tool).unwrap();
        assert!(Arc::ptr_eq(&report, &read.report));
        // Undo and redo find what was there.
        world.document.undo();
        refresh_meshes(&mut world).unwrap();
        assert_eq!(world.mesh(BodyRole::Tool), Some(&own));
        world.document.redo();
        refresh_meshes(&mut world).unwrap();
        assert!(Arc::ptr_eq(world.mesh(BodyRole::Tool).unwrap(), &read.surface));
        world.document.undo();
        refresh_meshes(&mut world).unwrap();
        fs::write(&file, tetrahedron(80.0)).unwrap();
        world.document.redo();
        refresh_meshes(&mut world).unwrap();
        let size = world.mesh_report(BodyRole::Tool).unwrap().bounds.unwrap();
        assert_eq!(size.size_mm().x, 80.0);
        // Read once more, after its program wrote it anew, it is the body's without an edit.
        fs::write(&file, tetrahedron(60.0)).unwrap();
        let again = read.wanted.read().unwrap();
        assert!(world.keep_mesh(again));
        let size = world.mesh_report(BodyRole::Tool).unwrap().bounds.unwrap();
        assert_eq!(size.size_mm().x, 60.0);
        assert!(crate::changes(&world).is_empty());
    }

    #[test]
    fn another_unit_of_the_same_file_is_another_mesh() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("tool.obj");
        fs::write(&file, tetrahedron(10.0)).unwrap();
        let mut world = open_builtin("pointer-on-head").unwrap();
        let wanted = MeshImport::of_file(&world, BodyRole::Tool, &file, None).unwrap();
        let wanted = wanted.unwrap();
        for (unit, size_mm) in [(MeshUnit::Millimetre, 10.0), (MeshUnit::Inch, 254.0)] {
            let read = wanted.with_unit(unit).read().unwrap();
            world.keep_mesh(read.clone());
            give(&mut world, &read.wanted.reference);
            let bounds = world.mesh_report(BodyRole::Tool).unwrap().bounds.unwrap();
            assert_eq!(bounds.size_mm().amax(), size_mm);
        }
        let again = MeshImport::in_unit(&world, BodyRole::Tool, None).unwrap();
        assert_eq!(again.unwrap().reference.unit, None);
    }
}
