//! A built-in design in a folder of its own, with all that it refers to.

use std::path::{Path, PathBuf};
use trackwright_design::View;

/// Copies of a design, its bodies, meshes and room, laid out as in the repository.
pub struct Copied {
    folder: tempfile::TempDir,
    pub design: PathBuf,
}

impl Copied {
    /// Of `designs/NAME.design.ron`.
    pub fn new(name: &str) -> Self {
        let folder = tempfile::Builder::new().prefix("trackwright-").tempdir().unwrap();
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        for part in ["bodies", "meshes", "environments"] {
            let to = folder.path().join("assets").join(part);
            std::fs::create_dir_all(&to).unwrap();
            for entry in std::fs::read_dir(root.join("assets").join(part)).unwrap() {
                let entry = entry.unwrap();
                if entry.file_type().unwrap().is_file() {
                    std::fs::copy(entry.path(), to.join(entry.file_name())).unwrap();
                }
            }
        }
        let file = format!("designs/{name}.design.ron");
        std::fs::create_dir(folder.path().join("designs")).unwrap();
        let design = folder.path().join(&file);
        std::fs::copy(root.join(file), &design).unwrap();
        Self { folder, design }
    }

    /// Changes the design's view, in the file.
    pub fn change_view(&self, change: impl FnOnce(&mut View)) {
        let mut world = trackwright_project::open_design(&self.design).unwrap();
        let mut view = world.document.view().clone();
        change(&mut view);
        world.document.set_view(view);
        trackwright_project::save(&mut world).unwrap();
    }

    pub fn path(&self, relative: &str) -> PathBuf {
        self.folder.path().join(relative)
    }

    /// The bytes of the design and of all bodies.
    pub fn bytes(&self) -> Vec<(PathBuf, Vec<u8>)> {
        let bodies = std::fs::read_dir(self.path("assets/bodies")).unwrap();
        let mut files: Vec<PathBuf> = bodies.map(|entry| entry.unwrap().path()).collect();
        files.push(self.design.clone());
        files.sort();
        files
            .into_iter()
            .map(|file| {
                let bytes = std::fs::read(&file).unwrap();
                (file, bytes)
            })
            .collect()
    }
}
