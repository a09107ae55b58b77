//! What commands do with the design that they are given.

use super::prelude::*;
use trackwright_design::Design;
use trackwright_project::{StoreError, World};

/// Opens the numbers of a design's file, or those of the built-in design where none is named.
///
/// # Errors
/// Those of opening it.
pub fn named_or_builtin(files: &Files, design: Option<&Path>) -> Result<World, StoreError> {
    match design {
        Some(file) => files.open_design_without_meshes(file),
        None => {
            trackwright_project::open_builtin_without_meshes(trackwright_project::DEFAULT_BUILTIN)
        }
    }
}

/// Reports which meshes could not be read and what is wrong with the others; nothing that is
/// computed depends on them.
pub fn note_meshes(world: &World) {
    for problem in world.mesh_problems() {
        output::note(&format!("note: {problem}; it is drawn without it"));
    }
    for doubt in world.mesh_doubts() {
        output::note(&format!("warning: {doubt}"));
    }
}

/// Reports which bodies have a size that no instrument has.
pub fn note_sizes(design: &Design) {
    for (role, body) in design.bodies() {
        if let Some(doubt) = body.rigid.size_doubt() {
            output::note(&format!(
                "warning: {}: tip and sensors of the {role}: {doubt}",
                design.name
            ));
        }
    }
}
