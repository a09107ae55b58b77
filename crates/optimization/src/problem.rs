//! What is searched for: a design in its rooms, what may move and within what, what is judged.

use crate::crf_patch::CrfPatch;
use nalgebra::Vector3;
use serde::Serialize;
use std::ops::RangeInclusive;
use std::sync::Arc;
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_geometry::surface::{Surface, SurfacePoint};
use trackwright_simulation::placement::{placement_mesh, vertices};
use trackwright_simulation::{Coil, Metric, Mode, Mounting, Requirement, Scenario};

/// A design whose sensors are to be placed.
#[derive(Clone, Debug)]
pub struct Problem {
    /// The design in each room that counts, at least one; they differ in their environments alone.
    pub scenarios: Vec<Scenario>,
    /// The study that is judged, in every room.
    pub mode: Mode,
    pub tool: MountedBody,
    pub crf: Option<MountedBody>,
    /// Where on the patient the CRF may stand, at most one; where nothing is stated its pose moves
    /// freely within its bounds.
    pub crf_patches: Vec<CrfPatch>,
    pub moves: Moves,
    pub goal: Goal,
    pub rooms: OverRooms,
    /// What sensors are off by when the bodies are built, if that is stated.
    pub built: Option<BuiltError>,
}

/// Standard deviations of where a built sensor is, independent of those of the others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BuiltError {
    /// Along each axis.
    pub position_mm: f64,
    /// About each axis.
    pub angle_deg: f64,
}

impl BuiltError {
    /// `None` where sensors are exactly where they are drawn.
    pub fn unless_exact(self) -> Option<Self> {
        (self.position_mm > 0.0 || self.angle_deg > 0.0).then_some(self)
    }

    /// 0.3 mm and 1°, what a coil that is glued onto a surface is off by, or what is stated where that is more.
    pub fn rough(stated: Option<Self>) -> Self {
        let stated = stated.unwrap_or(Self { position_mm: 0.0, angle_deg: 0.0 });
        Self { position_mm: stated.position_mm.max(0.3), angle_deg: stated.angle_deg.max(1.0) }
    }
}

impl Default for BuiltError {
    /// What a coil that is glued into a groove by hand is off by.
    fn default() -> Self {
        Self { position_mm: 0.2, angle_deg: 0.3 }
    }
}

/// Where the sensors of a body may be, and the shape of the body.
#[derive(Clone, Debug, Default)]
pub struct MountedBody {
    pub mounting: Mounting,
    /// `None` of a body without a mesh, or with one that has no triangle.
    pub surface: Option<Arc<Surface>>,
    /// Points of the surface, close enough to stand for all of it.
    pub vertices: Arc<[SurfacePoint]>,
}

impl MountedBody {
    /// A body with a mesh.
    pub fn of_mesh(mounting: Mounting, mesh: &SurfaceMesh) -> Self {
        let finer = placement_mesh(mesh);
        Self {
            mounting,
            surface: Surface::new(mesh).map(Arc::new),
            vertices: vertices(finer.as_ref().unwrap_or(mesh)).into(),
        }
    }

    /// A body without a mesh: its sensors can be in its channels and seats alone.
    pub fn without_mesh(mounting: Mounting) -> Self {
        Self { mounting, ..Self::default() }
    }
}

/// What may move.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Moves {
    /// Numbers of the tool's sensors.
    pub tool: Vec<usize>,
    /// Numbers of the CRF's sensors.
    pub crf: Vec<usize>,
    /// How many sensors the tool may have, or the CRF where none of the tool's move; as many as it
    /// has where absent.
    pub sensors: Option<RangeInclusive<usize>>,
    /// Kinds that an added sensor may be of; as the first that moves where there are none.
    pub kinds: Vec<SensorChoice>,
    /// How far the field generator may be moved from where it is.
    pub generator: Option<PoseBounds>,
    /// How far the CRF may be moved on the patient. Over a patch the shift bounds how far its foot is
    /// moved along its axes, and the turn that about the surface's normal.
    pub crf_pose: Option<PoseBounds>,
}

/// A kind of sensor that can be bought.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SensorChoice {
    /// 5 or 6.
    pub degrees_of_freedom: u8,
    pub coil: Option<Coil>,
    /// In a unit of one's own.
    pub cost: f64,
}

/// How far a pose may be from where it is, in its own axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseBounds {
    /// To either side along each axis.
    pub shift_mm: Vector3<f64>,
    /// About any axis.
    pub turn_deg: f64,
}

/// What is made least.
#[expect(clippy::large_enum_variant, reason = "there is one of it in a search")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// The largest ratio of a figure to its bound, one of the requirement's.
    Requirement(Requirement),
    /// One figure, mm or degrees.
    Figure(Metric),
}

/// How several rooms count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum OverRooms {
    #[default]
    Worst,
    Mean,
}

/// How long and how a search is made. The result depends on these and the problem alone, unless
/// it was stopped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    pub seed: u64,
    /// Frame fits that the search may take, in all; more find more where places are many.
    pub most_fits: u64,
}

/// Some 20 s of two cores.
const MOST_FITS: u64 = 40_000_000;

impl Default for Settings {
    fn default() -> Self {
        Self { seed: 0, most_fits: MOST_FITS }
    }
}
