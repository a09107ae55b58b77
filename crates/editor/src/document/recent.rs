//! The designs that were opened last, for the File menu.

use bevy::prelude::Resource;
use std::path::{Path, PathBuf};
use trackwright_project::{RecentDesign, recent_designs, remember_recent};

/// The list, and where it is kept.
#[derive(Resource, Clone, Debug, Default)]
pub struct RecentDesigns {
    folder: Option<PathBuf>,
    pub designs: Vec<RecentDesign>,
}

impl RecentDesigns {
    /// The list in a state folder. One that cannot be read is empty: it only saves a walk through
    /// folders.
    pub fn in_folder(folder: PathBuf) -> Self {
        Self { designs: recent_designs(&folder).unwrap_or_default(), folder: Some(folder) }
    }

    /// Puts a design at its head.
    pub fn remember(&mut self, design: &Path) {
        let Some(folder) = &self.folder else { return };
        if remember_recent(folder, design).is_ok() {
            self.designs = recent_designs(folder).unwrap_or_default();
        }
    }
}
