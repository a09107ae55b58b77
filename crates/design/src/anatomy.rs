//! Anatomy: meshes that a design shows beside its bodies, the patient or what stands around. Drawn
//! translucent and nothing else: no figure, no sensor and no placement depends on them.

use serde::Deserialize;
use trackwright_geometry::mesh_reference::MeshReference;
use trackwright_geometry::pose::Pose;

/// A mesh that is only looked at.
#[derive(Clone, Debug, PartialEq)]
pub struct Anatomy {
    pub name: String,
    /// Its file is relative to the design's.
    pub mesh: MeshReference,
    pub on: AnatomyFrame,
    /// From the mesh's own frame to that of `on`.
    pub frame_from_mesh: Pose,
    /// sRGB, each from 0 to 1; that of bone where none is given.
    pub color: Option<[f64; 3]>,
}

/// What a mesh of anatomy moves with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Deserialize)]
pub enum AnatomyFrame {
    /// The patient. The tracker's frame where the design has no CRF.
    #[default]
    Crf,
    /// The room.
    Tracker,
}

impl AnatomyFrame {
    pub const ALL: [Self; 2] = [Self::Crf, Self::Tracker];

    /// What a list of them calls it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Crf => "CRF",
            Self::Tracker => "tracker",
        }
    }
}
