//! What one side of a table may be instead of what it is read as: a closed list, and what each changes.

use super::{SignedAxes, named_axes, on_axes, short, signed_axes};
use crate::robust::median;
use nalgebra::{Quaternion, Unit, UnitQuaternion, Vector3};
use std::fmt;
use trackwright_field::samples::Measurement;
use trackwright_geometry::pose::{Pose, pose_from_parts};

/// One of the two sides of a measurement table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    Ideal,
    Measured,
    Both,
}

/// What rows may be; lengths in mm, angles in radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mistake {
    /// The measured axes are others of the ideal ones.
    Axes(SignedAxes),
    /// A mirror image, whatever the plane.
    Mirrored,
    /// A rotation and a translation are between the sides.
    Frame { angle_rad: f64, shift: f64 },
    /// Positions of this side in mm times a factor.
    Unit { side: Side, factor: f64, units: &'static str },
    /// Measured positions are so many times as far from the origin.
    Scale(f64),
    /// Quaternions of this side have another order or other signs.
    Quaternions(Side, QuaternionChange),
    /// The measured sensors' z is this direction in the ideal sensors' frames.
    SensorAxis([f64; 3]),
    /// One rotation is between the orientations of the two sides, and none between the positions.
    OrientationFrame { angle_rad: f64 },
    /// Measured positions are off by one vector in the sensors' frames: another point of the tool.
    SensorOffset { offset_mm: [f64; 3], standard_error_mm: Option<f64> },
    /// Measured orientations are off by one rotation in the sensors' frames.
    SensorTilt { angle_rad: f64 },
    /// Ideal poses are in the columns of measured ones.
    Exchanged,
}

/// Units of one side, where positions in mm are so many times its numbers.
const UNITS: [(f64, &str); 7] = [
    (1000.0, "metres"),
    (304.8, "feet"),
    (100.0, "decimetres"),
    (25.4, "inches"),
    (10.0, "centimetres"),
    (0.1, "tenths of millimetres"),
    (1e-3, "micrometres"),
];

impl Mistake {
    /// Those without parameters, the simpler ones first. Of two that explain the same the first is named.
    pub(super) fn of_positions() -> impl Iterator<Item = Self> {
        let sides = [Side::Measured, Side::Ideal];
        let units = sides.into_iter().flat_map(|side| {
            UNITS.into_iter().map(move |(factor, units)| Self::Unit { side, factor, units })
        });
        units.chain(Self::of_axes())
    }

    pub(super) fn of_axes() -> impl Iterator<Item = Self> {
        signed_axes().map(Self::Axes)
    }

    /// The same of orientations.
    pub(super) fn of_orientations() -> impl Iterator<Item = Self> {
        let axes = [(2, -1.0), (0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)];
        let axes = axes.map(|(k, sign)| Vector3::ith(k, sign).into()).map(Self::SensorAxis);
        let sides = [Side::Measured, Side::Ideal, Side::Both];
        let changes = QuaternionChange::all()
            .flat_map(move |change| sides.map(|side| Self::Quaternions(side, change)));
        axes.into_iter().chain(changes)
    }

    /// Whether the far rows of a side in another unit are as far from its other rows as that makes them.
    pub(super) fn is_plausible(&self, rows: &[(usize, Measurement)], is_far: &[bool]) -> bool {
        let Self::Unit { side, factor, .. } = self else {
            return true;
        };
        let typical_mm = |of_far: bool| {
            let each = rows.iter().zip(is_far).filter(|(_, is)| **is == of_far);
            let reach = each.map(|((_, m), _)| match side {
                Side::Ideal => m.tracker_from_ideal.translation.vector.norm(),
                _ => m.tracker_from_measured.translation.vector.norm(),
            });
            median(&mut reach.collect::<Vec<_>>()).unwrap_or(0.0)
        };
        let ratio = typical_mm(false) / typical_mm(true);
        (ratio / factor).ln().abs() < 0.5 * factor.ln().abs()
    }

    /// The row as it is where the mistake is undone; those with parameters of a fit leave it.
    pub(super) fn undone(&self, m: &Measurement) -> Measurement {
        let ideal = |change: &dyn Fn(&Pose) -> Pose| Measurement {
            tracker_from_ideal: change(&m.tracker_from_ideal),
            ..*m
        };
        let measured = |change: &dyn Fn(&Pose) -> Pose, m: Measurement| Measurement {
            tracker_from_measured: change(&m.tracker_from_measured),
            ..m
        };
        let of_side = |side: Side, change: &dyn Fn(&Pose) -> Pose| match side {
            Side::Ideal => ideal(change),
            Side::Measured => measured(change, *m),
            Side::Both => measured(change, ideal(change)),
        };
        match self {
            Self::Axes(rows) => ideal(&|pose| {
                pose_from_parts(on_axes(rows, &pose.translation.vector), pose.rotation)
            }),
            // Lengths are those of the side with the larger numbers.
            Self::Unit { side, factor, .. } => {
                let other = if *side == Side::Ideal { Side::Measured } else { Side::Ideal };
                let (side, factor) =
                    if *factor > 1.0 { (*side, *factor) } else { (other, factor.recip()) };
                of_side(side, &|pose| {
                    pose_from_parts(pose.translation.vector * factor, pose.rotation)
                })
            }
            Self::Quaternions(side, change) => of_side(*side, &|pose| {
                pose_from_parts(pose.translation.vector, change.apply(&pose.rotation))
            }),
            Self::SensorAxis(axis) => ideal(&|pose| {
                let z = pose.rotation * Vector3::from(*axis);
                let turn = UnitQuaternion::rotation_between(&Vector3::z(), &z);
                // None where it is opposite: half a turn about any axis across.
                let half = || UnitQuaternion::from_scaled_axis(Vector3::x() * std::f64::consts::PI);
                pose_from_parts(pose.translation.vector, turn.unwrap_or_else(half))
            }),
            _ => *m,
        }
    }

    /// Whether it is about orientations, and the sides differ by angles.
    pub(super) fn is_of_angles(&self) -> bool {
        matches!(
            self,
            Self::Quaternions(..)
                | Self::SensorAxis(_)
                | Self::OrientationFrame { .. }
                | Self::SensorTilt { .. }
        )
    }
}

/// What follows "the sides are … apart, …".
impl fmt::Display for Mistake {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Axes(rows) => write!(
                f,
                "where {}: {}",
                named_axes(rows, "measured ", "ideal "),
                match super::is_mirror(rows) {
                    true => "is one side mirrored or left-handed?",
                    false => "are axes taken for others?",
                }
            ),
            Self::Mirrored => f.write_str(
                "where one is the other's mirror image, registered: is one mirrored or left-handed?",
            ),
            Self::Frame { angle_rad, shift } => write!(
                f,
                "once they are registered (a rotation by {:.1}° and a translation of {} mm): are they in two frames?",
                angle_rad.to_degrees(),
                short(*shift)
            ),
            Self::Unit { side, units, .. } => {
                write!(f, "where {}'s positions are in {units}", named(*side))
            }
            Self::Scale(ratio) => write!(
                f,
                "where measured positions are {ratio:.3} times as far from the origin as ideal ones: is one side \
                 scaled? If not, the room does it"
            ),
            Self::Quaternions(side, change) => write!(
                f,
                "where {} quaternions {change}",
                match side {
                    Side::Ideal => "the ideal",
                    Side::Measured => "the measured",
                    Side::Both => "all",
                }
            ),
            Self::SensorAxis([_, _, z]) if *z == -1.0 => {
                f.write_str("where the sensor's axis of one side is reversed")
            }
            Self::SensorAxis([x, y, z]) => write!(
                f,
                "where the measured z axis is ({x:.2}, {y:.2}, {z:.2}) in the ideal sensor's frame: is another axis \
                 meant?"
            ),
            Self::OrientationFrame { angle_rad } => write!(
                f,
                "once all are rotated by {:.1}°, which the positions are not: are they in another frame?",
                angle_rad.to_degrees()
            ),
            Self::SensorOffset { offset_mm: [x, y, z], standard_error_mm } => {
                let is_along_z = *x == 0.0 && *y == 0.0;
                if is_along_z {
                    write!(f, "where measured positions are {z:.2} mm along the sensor's z axis from ideal ones")?;
                } else {
                    write!(
                        f,
                        "where measured positions are ({x:.2}, {y:.2}, {z:.2}) mm along the sensor's axes from ideal ones"
                    )?;
                }
                if let Some(standard_error_mm) = standard_error_mm {
                    write!(f, " (standard error {standard_error_mm:.2} mm)")?;
                }
                f.write_str(
                    ", which no room does: is one side of the tip, the other of the coil?",
                )?;
                // Of all rows, and one number.
                match is_along_z && standard_error_mm.is_some() {
                    true => write!(f, " (sensor offset {z:.2} takes it out)"),
                    false => Ok(()),
                }
            }
            Self::SensorTilt { angle_rad } => write!(
                f,
                "where the sensor's axis of one side is turned by {:.1}° in the sensor's frame: is it mounted otherwise?",
                angle_rad.to_degrees()
            ),
            Self::Exchanged => f.write_str("with the sides exchanged: are ideal poses in the measured columns?"),
        }
    }
}

pub(super) fn named(side: Side) -> &'static str {
    match side {
        Side::Ideal => "the ideal side",
        Side::Measured => "the measured side",
        Side::Both => "each side",
    }
}

/// Where the numbers of a quaternion are that is read as w, x, y, z.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Order {
    /// As they are read.
    AsRead,
    /// They are x, y, z, w.
    ScalarLast,
    /// They are z, w, x, y: scalar-first numbers in columns that begin with x.
    ScalarSecond,
}

/// Another order and other signs of a quaternion's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QuaternionChange {
    order: Order,
    /// Whether the signs of x, y and z are reversed.
    flips: [bool; 3],
}

impl QuaternionChange {
    /// All changes but none, the simpler ones first.
    fn all() -> impl Iterator<Item = Self> {
        let orders = [Order::AsRead, Order::ScalarLast, Order::ScalarSecond];
        // The inverse, mirrored axes, their inverses.
        let flips = [0b000, 0b111, 0b011, 0b101, 0b110, 0b001, 0b010, 0b100];
        let each = orders.into_iter().flat_map(move |order| {
            flips.map(|bits: u8| Self {
                order,
                flips: [bits & 1 != 0, bits & 2 != 0, bits & 4 != 0],
            })
        });
        each.skip(1)
    }

    fn apply(self, rotation: &UnitQuaternion<f64>) -> UnitQuaternion<f64> {
        let q = rotation.quaternion();
        let read = [q.w, q.i, q.j, q.k];
        let [w, x, y, z] = match self.order {
            Order::AsRead => read,
            Order::ScalarLast => [read[3], read[0], read[1], read[2]],
            Order::ScalarSecond => [read[1], read[2], read[3], read[0]],
        };
        let signed = |value: f64, k: usize| if self.flips[k] { -value } else { value };
        Unit::new_unchecked(Quaternion::new(w, signed(x, 0), signed(y, 1), signed(z, 2)))
    }
}

impl fmt::Display for QuaternionChange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let order = match self.order {
            Order::AsRead => None,
            Order::ScalarLast => Some("are read in the order x, y, z, w"),
            Order::ScalarSecond => Some("have their scalar in the column qx"),
        };
        let names = ["qx", "qy", "qz"].into_iter().zip(self.flips);
        let flipped: Vec<_> = names.filter_map(|(name, is)| is.then_some(name)).collect();
        let signs = match flipped.len() {
            0 => None,
            3 => Some("are inverted".to_owned()),
            _ => Some(format!(
                "have {} with the other sign, as left-handed ones do",
                flipped.join(" and ")
            )),
        };
        match (order, signs) {
            (Some(order), None) => f.write_str(order),
            (None, Some(signs)) => f.write_str(&signs),
            (Some(order), Some(signs)) => write!(f, "{order} and {signs}"),
            (None, None) => f.write_str("stay"),
        }
    }
}
