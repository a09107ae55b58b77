//! Where the sensors of a body may be put: mounting regions, forbidden boxes and least distances.

use nalgebra::{Point3, Unit, Vector3};
use serde::{Deserialize, Serialize};
use std::fmt;
use trackwright_geometry::bounds::{Bounds, BoundsError};
use trackwright_geometry::limits::{
    length_above_zero_problem, length_problem, position_problem, short,
};
use trackwright_geometry::pose::MIN_NORM;

/// How far from 1 the length of a seat's axis may be: round-off of a normalised one.
const UNIT_TOLERANCE: f64 = 1e-9;

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

/// Why a mounting cannot be one. Regions, points and boxes have the numbers of their lists.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MountingError {
    #[error("{place}: {cause}")]
    Box { place: BoxPlace, cause: BoundsError },
    #[error("{place}: min {axis} and max {axis} are {}, expected min below max", short(*value_mm))]
    FlatBox { place: BoxPlace, axis: char, value_mm: f64 },
    #[error(
        "mounting[{region}].axis is {axis:?}, expected {} for a {kind}",
        or_list(kind.axes())
    )]
    Axis { region: usize, kind: RegionKind, axis: MountingAxis },
    #[error("mounting[{region}].points has {count}, expected at least two")]
    FewPoints { region: usize, count: usize },
    #[error("mounting[{region}].points[{point}] is ({}), expected {expected}", list(position_mm))]
    Point { region: usize, point: usize, position_mm: [f64; 3], expected: &'static str },
    #[error(
        "mounting[{region}].points[{point}] is ({}), expected another place than the point before",
        list(position_mm)
    )]
    RepeatedPoint { region: usize, point: usize, position_mm: [f64; 3] },
    #[error("mounting[{region}].radius is {}, expected {expected}", short(*radius_mm))]
    Radius { region: usize, radius_mm: f64, expected: &'static str },
    #[error("mounting[{region}].position is ({}), expected {expected}", list(position_mm))]
    Seat { region: usize, position_mm: [f64; 3], expected: &'static str },
    #[error("mounting[{region}].axis has length {length}, expected 1")]
    SeatAxis { region: usize, length: f64 },
    #[error("least_gap is {}, expected {expected}", short(*value_mm))]
    LeastGap { value_mm: f64, expected: &'static str },
    #[error("tip_clearance is {}, expected {expected}", short(*value_mm))]
    TipClearance { value_mm: f64, expected: &'static str },
}

/// Where a box is stated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BoxPlace {
    Surface {
        region: usize,
        index: usize,
    },
    KeepOut {
        index: usize,
    },
    /// Of the patch of anatomy that the CRF may stand on.
    CrfPatch {
        index: usize,
    },
}

impl fmt::Display for BoxPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Surface { region, index } => write!(f, "mounting[{region}].boxes[{index}]"),
            Self::KeepOut { index } => write!(f, "keep_out[{index}]"),
            Self::CrfPatch { index } => write!(f, "crf_patch[{index}]"),
        }
    }
}

/// Regions in which an axis may follow the place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RegionKind {
    Surface,
    Channel,
}

impl RegionKind {
    /// The axes that there are in such a region.
    pub fn axes(self) -> &'static [MountingAxis] {
        use MountingAxis::{Along, AsItIs, Free, Normal, Tangent};
        match self {
            Self::Surface => &[Free, Normal, Tangent, AsItIs],
            Self::Channel => &[Free, Along, AsItIs],
        }
    }
}

impl fmt::Display for RegionKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Surface => "surface",
            Self::Channel => "channel",
        })
    }
}

fn or_list(axes: &[MountingAxis]) -> String {
    axes.iter().map(|axis| format!("{axis:?}")).collect::<Vec<_>>().join(" or ")
}

fn list(coordinates: &[f64; 3]) -> String {
    coordinates.map(short).join(", ")
}

impl Mounting {
    /// A box that is stated, by its place; `None` where it is none of the body's.
    pub fn stated_box(&self, place: BoxPlace) -> Option<&Bounds> {
        match place {
            BoxPlace::CrfPatch { .. } => None,
            BoxPlace::KeepOut { index } => self.keep_out.get(index),
            BoxPlace::Surface { region, index } => match self.regions.get(region)? {
                MountingRegion::Surface { boxes, .. } => boxes.get(index),
                _ => None,
            },
        }
    }

    /// The same, to be changed.
    pub fn stated_box_mut(&mut self, place: BoxPlace) -> Option<&mut Bounds> {
        match place {
            BoxPlace::CrfPatch { .. } => None,
            BoxPlace::KeepOut { index } => self.keep_out.get_mut(index),
            BoxPlace::Surface { region, index } => match self.regions.get_mut(region)? {
                MountingRegion::Surface { boxes, .. } => boxes.get_mut(index),
                _ => None,
            },
        }
    }

    /// Whether nothing is stated.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Checks that sensors may be put by it: what a file and an edit may state.
    ///
    /// # Errors
    /// The first that is wrong.
    pub fn check(&self) -> Result<(), MountingError> {
        for (region, own) in self.regions.iter().enumerate() {
            own.check(region)?;
        }
        for (index, keep_out) in self.keep_out.iter().enumerate() {
            check_box(BoxPlace::KeepOut { index }, keep_out)?;
        }
        if let Some(value_mm) = self.least_gap_mm
            && let Some(expected) = length_problem(value_mm)
        {
            return Err(MountingError::LeastGap { value_mm, expected });
        }
        let value_mm = self.tip_clearance_mm;
        match length_problem(value_mm) {
            Some(expected) => Err(MountingError::TipClearance { value_mm, expected }),
            None => Ok(()),
        }
    }
}

impl MountingRegion {
    fn check(&self, region: usize) -> Result<(), MountingError> {
        match self {
            Self::Surface { axis, boxes } => {
                check_axis(region, RegionKind::Surface, *axis)?;
                let mut boxes = boxes.iter().enumerate();
                boxes.try_for_each(|(index, own)| {
                    check_box(BoxPlace::Surface { region, index }, own)
                })
            }
            Self::Channel { points_mm, radius_mm, axis } => {
                check_axis(region, RegionKind::Channel, *axis)?;
                check_points(region, points_mm)?;
                match radius_mm.and_then(|r| length_above_zero_problem(r).map(|e| (r, e))) {
                    Some((radius_mm, expected)) => {
                        Err(MountingError::Radius { region, radius_mm, expected })
                    }
                    None => Ok(()),
                }
            }
            Self::Seat { position_mm, axis } => {
                if let Some(expected) = position_problem(&position_mm.coords) {
                    let position_mm = position_mm.coords.into();
                    return Err(MountingError::Seat { region, position_mm, expected });
                }
                let length = axis.map_or(1.0, |axis| axis.norm());
                // A length that is not a number is not within the tolerance either.
                match (length - 1.0).abs() <= UNIT_TOLERANCE {
                    true => Ok(()),
                    false => Err(MountingError::SeatAxis { region, length }),
                }
            }
        }
    }
}

fn check_axis(region: usize, kind: RegionKind, axis: MountingAxis) -> Result<(), MountingError> {
    match kind.axes().contains(&axis) {
        true => Ok(()),
        false => Err(MountingError::Axis { region, kind, axis }),
    }
}

fn check_points(region: usize, points_mm: &[Point3<f64>]) -> Result<(), MountingError> {
    for (point, position) in points_mm.iter().enumerate() {
        let position_mm = position.coords.into();
        if let Some(expected) = position_problem(&position_mm) {
            return Err(MountingError::Point { region, point, position_mm, expected });
        }
        // A piece without a length has no direction.
        let before = point.checked_sub(1).map(|before| points_mm[before]);
        if before.is_some_and(|before| (position - before).norm() <= MIN_NORM) {
            return Err(MountingError::RepeatedPoint { region, point, position_mm });
        }
    }
    match points_mm.len() {
        count @ ..2 => Err(MountingError::FewPoints { region, count }),
        _ => Ok(()),
    }
}

/// Checks a box, which has an extent along every axis.
///
/// # Errors
/// [`MountingError::Box`] and [`MountingError::FlatBox`].
pub fn check_box(place: BoxPlace, own: &Bounds) -> Result<(), MountingError> {
    own.check().map_err(|cause| MountingError::Box { place, cause })?;
    let axes = ['x', 'y', 'z'].into_iter().zip(own.min_mm.iter().zip(own.max_mm.iter()));
    for (axis, (&min_mm, &max_mm)) in axes {
        if min_mm >= max_mm {
            return Err(MountingError::FlatBox { place, axis, value_mm: min_mm });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn channel(points: &[[f64; 3]], radius_mm: Option<f64>, axis: MountingAxis) -> Mounting {
        let points_mm = points.iter().map(|p| Point3::from(*p)).collect();
        of(MountingRegion::Channel { points_mm, radius_mm, axis })
    }

    fn of(region: MountingRegion) -> Mounting {
        Mounting { regions: vec![region], ..Mounting::default() }
    }

    fn patch(axis: MountingAxis, min: [f64; 3], max: [f64; 3]) -> Mounting {
        of(MountingRegion::Surface { axis, boxes: vec![Bounds::from((min, max))] })
    }

    const LINE: [[f64; 3]; 2] = [[0.0, 0.0, 10.0], [0.0, 0.0, 130.0]];

    #[test]
    fn axes_follow_only_what_is_there() {
        use MountingAxis::{Along, AsItIs, Free, Normal, Tangent};
        for axis in [AsItIs, Free, Normal, Tangent, Along] {
            let is_of_surface = patch(axis, [0.0; 3], [1.0; 3]).check().is_ok();
            assert_eq!(is_of_surface, axis != Along, "{axis:?}");
            let is_of_channel = channel(&LINE, None, axis).check().is_ok();
            assert_eq!(is_of_channel, !matches!(axis, Normal | Tangent), "{axis:?}");
        }
        let error = channel(&LINE, None, Normal).check().unwrap_err().to_string();
        let expected = "mounting[0].axis is Normal, expected Free or Along or AsItIs for a channel";
        assert_eq!(error, expected);
    }

    #[test]
    fn what_is_no_region_is_refused() {
        let seat = |position: [f64; 3], axis: [f64; 3]| {
            let axis = Some(Unit::new_unchecked(axis.into()));
            of(MountingRegion::Seat { position_mm: position.into(), axis })
        };
        let gap = |least_gap_mm| Mounting { least_gap_mm, ..Mounting::default() };
        let clearance = |tip_clearance_mm| Mounting { tip_clearance_mm, ..Mounting::default() };
        let line = |radius| channel(&LINE, Some(radius), MountingAxis::Along);
        let of_points = |points: &[[f64; 3]]| channel(points, None, MountingAxis::Along);
        let keep_out = Bounds::from(([0.0; 3], [1.0, f64::NAN, 1.0]));
        let keep_out = Mounting { keep_out: vec![keep_out], ..Mounting::default() };
        let whole = MountingRegion::Surface { axis: MountingAxis::Normal, boxes: Vec::new() };
        for good in [
            Mounting::default(),
            of(whole),
            line(0.5),
            seat([1.0; 3], [0.0, 0.0, 1.0]),
            gap(Some(0.0)),
            clearance(5.0),
        ] {
            assert_eq!(good.check(), Ok(()));
        }
        let far = [0.0, 0.0, 2e6];
        for (bad, expected) in [
            (of_points(&LINE[..1]), "points has 1, expected at least two"),
            (of_points(&[]), "points has 0, expected at least two"),
            (of_points(&[LINE[0], LINE[1], LINE[1]]), "points[2] is (0, 0, 130), expected another"),
            (
                of_points(&[[0.0; 3], [1e-200; 3]]),
                "points[1] is (1e-200, 1e-200, 1e-200), expected another",
            ),
            (of_points(&[LINE[0], far]), "points[1] is (0, 0, 2000000), expected coordinates"),
            (line(0.0), "radius is 0, expected a length above zero"),
            (line(f64::NAN), "radius is NaN, expected a length above zero"),
            (seat(far, [0.0, 0.0, 1.0]), "position is (0, 0, 2000000), expected coordinates"),
            (seat([0.0; 3], [0.0, 0.0, 2.0]), "axis has length 2, expected 1"),
            (seat([0.0; 3], [f64::NAN; 3]), "axis has length NaN, expected 1"),
            (patch(MountingAxis::Free, [2.0; 3], [1.0; 3]), "boxes[0]: min x is 2, max x is 1"),
            (
                patch(MountingAxis::Free, [0.0; 3], [1.0, 0.0, 1.0]),
                "boxes[0]: min y and max y are 0, expected min below max",
            ),
            (keep_out, "keep_out[0]: max is (1, NaN, 1), expected finite numbers"),
            (gap(Some(-1.0)), "least_gap is -1, expected zero or more"),
            (clearance(f64::INFINITY), "tip_clearance is inf, expected zero or more"),
        ] {
            let error = bad.check().unwrap_err().to_string();
            let error = error.strip_prefix("mounting[0].").unwrap_or(&error);
            assert!(error.starts_with(expected), "{error}");
        }
    }
}
