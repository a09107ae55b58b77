//! What keeps a sensor from a place.

use crate::problem::MountedBody;
use nalgebra::Point3;
use serde::Serialize;
use trackwright_geometry::bounds::Bounds;
use trackwright_simulation::{Coil, Sensor, coil_fits, coil_gap_mm, coil_points};

/// Round-off of places that touch what bounds them.
pub(crate) const TOUCH_MM: f64 = 1e-6;

/// Why a sensor cannot be where it is.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "constraint")]
pub enum Constraint {
    /// Its place is in no mounting region, or beyond the end of its channel.
    RegionEnd,
    /// The channel is too narrow there, or bends too much for the coil.
    ChannelTooNarrow,
    /// The coil reaches into a box that is kept free.
    KeepOut,
    /// The coil is nearer to the tip than is allowed.
    TipClearance { least_mm: f64 },
    /// The coil is partly in the body and sticks out of it.
    SticksOut,
    /// The coil is too near to another one's.
    Gap { other: String, least_mm: f64 },
    /// A rotation would be free, or barely determined, that is not at the start.
    Determination,
    /// A sensor would leave the model's box or the tracker's volume at more poses than at the start.
    OutsideField,
    /// A pose is as far from where it was as is allowed.
    PoseBound,
}

impl Constraint {
    /// What stands in the way, after "the coil of a".
    pub fn words(&self) -> String {
        match self {
            Self::RegionEnd => "ends where its mounting region ends".into(),
            Self::ChannelTooNarrow => "does not fit into its channel".into(),
            Self::KeepOut => "would reach into a box that is kept free".into(),
            Self::TipClearance { least_mm } => {
                format!("would be nearer than {least_mm:.1} mm to the tip")
            }
            Self::SticksOut => "would stick out of the body".into(),
            Self::Gap { other, least_mm } => {
                format!("would be nearer than {least_mm:.1} mm to that of {other}")
            }
            Self::Determination => "would leave a rotation open that the start determines".into(),
            Self::OutsideField => "would leave the field of the room at more poses".into(),
            Self::PoseBound => "would be farther away than is allowed".into(),
        }
    }
}

/// What a sensor breaks of what is to be kept free: the tip's surroundings and the forbidden boxes.
fn kept_free_fault(
    sensor: &Sensor,
    body: &MountedBody,
    tip_in_body: Option<&Point3<f64>>,
) -> Option<Constraint> {
    let mounting = &body.mounting;
    let points = coil_points(sensor);
    if let (Some(tip), least_mm @ 1e-9..) = (tip_in_body, mounting.tip_clearance_mm)
        && points.iter().any(|point| (point - tip).norm() < least_mm - TOUCH_MM)
    {
        return Some(Constraint::TipClearance { least_mm });
    }
    let reaches = |kept: &Bounds| points.iter().any(|point| kept.contains(point));
    mounting.keep_out.iter().any(reaches).then_some(Constraint::KeepOut)
}

/// What a sensor at a place of its body breaks by itself, whatever the other sensors do and whatever
/// region it is in; the least costly check first.
pub(crate) fn own_fault(
    sensor: &Sensor,
    body: &MountedBody,
    tip_in_body: Option<&Point3<f64>>,
    is_in_channel: bool,
) -> Option<Constraint> {
    if let Some(fault) = kept_free_fault(sensor, body, tip_in_body) {
        return Some(fault);
    }
    // A channel is stated to hold its coils, whether the mesh has it or not.
    let fits = is_in_channel || coil_fits(sensor, std::iter::empty(), body.surface.as_deref());
    (!fits).then_some(Constraint::SticksOut)
}

/// What two sensors of a body break together.
pub(crate) fn pair_fault(
    sensor: &Sensor,
    other: &Sensor,
    least_gap_mm: Option<f64>,
) -> Option<Constraint> {
    let (apart_mm, least_mm) = pair_gap_mm(sensor, other, least_gap_mm);
    // Round-off of coils that touch the gap is no fault.
    (apart_mm < least_mm).then(|| Constraint::Gap { other: other.name.clone(), least_mm })
}

/// How far apart two sensors' coils are, and how far they have to be at the least.
pub(crate) fn pair_gap_mm(
    sensor: &Sensor,
    other: &Sensor,
    least_gap_mm: Option<f64>,
) -> (f64, f64) {
    let length = |coil: Option<Coil>| coil.map_or(0.0, |coil| coil.length_mm);
    let least_mm = least_gap_mm.unwrap_or_else(|| length(sensor.coil).max(length(other.coil)));
    let apart_mm = coil_gap_mm(sensor, other)
        .unwrap_or_else(|| (sensor.position_in_body - other.position_in_body).norm());
    (apart_mm + TOUCH_MM, least_mm)
}
