//! Where the sensors of a body may be put: mounting regions, forbidden boxes and least distances.

use nalgebra::{Point3, Unit, Vector3};
use serde::{Deserialize, Serialize};
use trackwright_geometry::bounds::Bounds;

/// How a sensor may be turned in a mounting region.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum MountingAxis {
    /// As it is in the body now.
    #[default]
    AsItIs,
    /// Any direction.
    Free,
    /// Along the surface's normal, outward.
    Normal,
    /// Along the surface, as near to its present axis as that allows.
    Tangent,
    /// Along the channel.
    Along,
}

/// A place, or a set of places, that a sensor may be put at. Millimetres, body frame.
#[derive(Clone, Debug, PartialEq)]
pub enum MountingRegion {
    /// A part of the body's surface: what of it lies in one of the boxes, all of it without boxes.
    Surface { axis: MountingAxis, boxes: Vec<Bounds> },
    /// The middle line of a bore, and its inner radius where that is known.
    Channel { points_mm: Vec<Point3<f64>>, radius_mm: Option<f64>, axis: MountingAxis },
    /// One place; the sensor's axis there, or as it is.
    Seat { position_mm: Point3<f64>, axis: Option<Unit<Vector3<f64>>> },
}

/// What a body states about where its sensors may be. Nothing stated: its whole surface, axes as
/// they are.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mounting {
    pub regions: Vec<MountingRegion>,
    /// Boxes that no coil may reach into.
    pub keep_out: Vec<Bounds>,
    /// Least distance between two coils, millimetres; `None` for the length of the longer one.
    pub least_gap_mm: Option<f64>,
    /// Least distance of a coil from the tip, millimetres.
    pub tip_clearance_mm: f64,
}

impl Mounting {
    /// Whether nothing is stated.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}
