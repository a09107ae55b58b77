//! Reads the files of a design, wherever it is.

use super::builtin;
use super::error::StoreError;
use super::paths::extension_of;
use super::read::{Kind, Storage, read};
use super::stamps::Stamps;
use super::tool::parse_body;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use trackwright_design::{Design, Origin, View};
use trackwright_formats::{FormatError, design_file, mesh};
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_geometry::mesh_reference::MeshReference;

/// Reads the files of a design and remembers what they were.
pub(super) struct Reader {
    pub(super) storage: Storage,
    pub(super) stamps: Stamps,
}

impl Reader {
    pub(super) fn new(storage: Storage) -> Self {
        Self { storage, stamps: Stamps::default() }
    }

    pub(super) fn design(&mut self, file: &Path) -> Result<(Design, View), StoreError> {
        let entry = self.read(file, Kind::DESIGN, design_file::parse)?;
        entry.into_design(|reference| {
            let file = self.storage.resolve(file, reference);
            self.read(&file, Kind::BODY, |bytes| parse_body(&file, bytes))
        })
    }

    pub(super) fn mesh(
        &mut self,
        from: &Path,
        mesh: &MeshReference,
    ) -> Result<Arc<SurfaceMesh>, StoreError> {
        let file = self.storage.resolve(from, &mesh.file);
        let extension = extension_of(&file);
        self.read(&file, "a mesh", |bytes| Ok(mesh::read(bytes, &extension, mesh.unit)?))
            .map(Arc::new)
    }

    pub(super) fn read<T>(
        &mut self,
        file: &Path,
        kind: impl Into<Kind>,
        parse: impl FnOnce(&[u8]) -> Result<T, FormatError>,
    ) -> Result<T, StoreError> {
        read(self.storage, file, kind, |bytes| {
            if self.storage.is_on_disk(file) {
                self.stamps.take(file, bytes);
            }
            parse(bytes)
        })
    }
}

/// Where a document's files are, and its own file there.
pub(super) fn home(origin: &Origin) -> Result<(Storage, PathBuf), StoreError> {
    Ok(match origin {
        Origin::BuiltIn(name) => (Storage::BuiltIn, builtin::design_file(name)?.1),
        Origin::File(file) => (Storage::Disk, file.clone()),
    })
}
