//! Anatomy: meshes that a design shows beside its bodies, the patient or what stands around. Drawn
//! translucent; no figure and no sensor depends on them. Where it states a patch, the CRF may be moved
//! over that when better places are searched for.

use serde::Deserialize;
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::mesh_reference::MeshReference;
use trackwright_geometry::pose::Pose;

/// A mesh beside the bodies.
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
    /// Boxes in the mesh's own frame, in millimetres: what of its surface is in one of them the CRF
    /// may stand on. None: nothing is stated.
    pub crf_patch: Vec<Bounds>,
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
