//! The baseline of a design on the disk: a file of its own beside the design's, so that the design's
//! file stays as it is and older versions of the program open it.

use super::error::StoreError;
use super::paths::{absolute, file_name};
use super::read::{Kind, Storage, read_if_there};
use super::reader::Reader;
use super::write::{write_bytes, write_error};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use trackwright_design::Design;
use trackwright_formats::baseline_file::{self, BaselineFile};
use trackwright_geometry::mesh::SurfaceMesh;

const DESIGN_EXTENSION: &str = ".design.ron";
const BASELINE_EXTENSION: &str = ".baseline.ron";

/// A baseline as it was kept.
#[derive(Clone, Debug)]
pub struct KeptBaseline {
    pub design: Design,
    /// The file that it was read from; `None` for an earlier state of the design itself.
    pub source: Option<PathBuf>,
    /// What the tool looks like, where its mesh can be read.
    pub tool_mesh: Option<Arc<SurfaceMesh>>,
}

/// Where the baseline of a design's file is kept: `needle.baseline.ron` beside `needle.design.ron`.
pub fn baseline_file_of(design_file: &Path) -> PathBuf {
    let name = file_name(design_file);
    let stem = name.strip_suffix(DESIGN_EXTENSION).unwrap_or(&name);
    design_file.with_file_name(format!("{stem}{BASELINE_EXTENSION}"))
}

/// Reads the baseline of a design's file; `None` where it has none.
pub fn read_baseline(design_file: &Path) -> Result<Option<KeptBaseline>, StoreError> {
    let file = baseline_file_of(design_file);
    let Some(kept) = read_if_there(&file, Kind::BASELINE, baseline_file::parse)? else {
        return Ok(None);
    };
    let from = kept.source.clone().unwrap_or_else(|| design_file.to_owned());
    let mesh = kept.design.tool.body.mesh.as_ref();
    let tool_mesh = mesh.and_then(|mesh| Reader::new(Storage::Disk).mesh(&from, mesh).ok());
    Ok(Some(KeptBaseline { design: kept.design, source: kept.source, tool_mesh }))
}

/// Keeps a baseline beside a design's file, over the one that was kept there.
///
/// # Errors
/// See [`StoreError`]. What is there and is no baseline stays.
pub fn write_baseline(
    design_file: &Path,
    design: &Design,
    source: Option<&Path>,
) -> Result<(), StoreError> {
    read_baseline(design_file)?;
    let kept = BaselineFile { source: source.map(absolute), design: design.clone() };
    write_bytes(&baseline_file_of(design_file), baseline_file::write(&kept).as_bytes())
}

/// Removes the baseline of a design's file.
///
/// # Errors
/// See [`StoreError`]. What is there and is no baseline stays.
pub fn remove_baseline(design_file: &Path) -> Result<(), StoreError> {
    if read_baseline(design_file)?.is_none() {
        return Ok(());
    }
    let file = baseline_file_of(design_file);
    fs::remove_file(&file).map_err(|cause| write_error(&file, cause))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{DEFAULT_BUILTIN, open_builtin, save_as};

    #[test]
    fn a_baseline_is_kept_beside_its_design() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("needle.design.ron");
        let mut world = open_builtin(DEFAULT_BUILTIN).unwrap();
        save_as(&mut world, &file).unwrap();
        let before = fs::read(&file).unwrap();
        assert!(read_baseline(&file).unwrap().is_none());
        let design = world.document.design();
        write_baseline(&file, design, None).unwrap();
        let kept = read_baseline(&file).unwrap().unwrap();
        assert_eq!((&kept.design, kept.source), (design, None));
        assert!(kept.tool_mesh.is_some());
        assert!(folder.path().join("needle.baseline.ron").exists());
        assert_eq!(fs::read(&file).unwrap(), before, "the design's file stays as it was");
        remove_baseline(&file).unwrap();
        remove_baseline(&file).unwrap();
        assert!(read_baseline(&file).unwrap().is_none());
    }

    #[test]
    fn what_is_no_baseline_is_not_written_over() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("needle.design.ron");
        let other = baseline_file_of(&file);
        fs::write(&other, "my own notes").unwrap();
        let world = open_builtin(DEFAULT_BUILTIN).unwrap();
        assert!(write_baseline(&file, world.document.design(), None).is_err());
        assert!(remove_baseline(&file).is_err());
        assert_eq!(fs::read(&other).unwrap(), b"my own notes");
    }
}
