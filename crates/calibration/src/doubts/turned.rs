//! Orientations of two sides: which order, signs or rotation would bring them together.
//!
//! Only the sensors' z axes are compared: the roll of a 5-DOF sensor is any.

use super::{Explained, Side, Suspicion};
use crate::robust::median;
use nalgebra::{Matrix3, Quaternion, Unit, UnitQuaternion, Vector3};
use std::fmt;
use trackwright_field::samples::Measurement;
use trackwright_geometry::rotation::rotation_angle_rad;
use trackwright_geometry::svd3::svd3;

/// Median angle between the axes of two sides that requires an explanation: ten times what the
/// worst of the rooms has (RMS 2.7°, median 1.6°), and half of it where a better one is at hand.
const UNEXPLAINED_RAD: f64 = 0.35;
const LEAST_RAD: f64 = 0.17;

/// Median angle that no field makes.
pub(super) const CERTAIN_RAD: f64 = 0.79;

/// An explanation as good as the best to this factor is preferred where it is simpler.
const AS_GOOD: f64 = 1.5;

/// The same in radians: a field turns axes by some degrees, by which a wrong change may seem better.
const AS_GOOD_RAD: f64 = 0.035;

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

/// What is suspected of orientations; `has_frame_difference` where positions are already known to be
/// in two frames, which orientations then are as well.
pub(super) fn suspicion(rows: &[Measurement], has_frame_difference: bool) -> Option<Suspicion> {
    let identity = |q: &UnitQuaternion<f64>| *q;
    let before = apart(rows, identity, identity)?;
    if before <= LEAST_RAD {
        return None;
    }
    let explained = |after: f64| Explained::new(before, after, LEAST_RAD, CERTAIN_RAD);
    if let Some((side, change, after)) = best_change(rows)
        && let Some(explained) = explained(after)
    {
        return Some(Suspicion::Quaternions { side, change, explained });
    }
    let axis = mean_axis_in_sensor(rows);
    if let Some(axis) = axis
        && let Some(explained) = explained(median_of(rows, |m| {
            (m.tracker_from_ideal.rotation * axis).angle(&measured_axis(m))
        })?)
    {
        return Some(Suspicion::SensorAxis { axis_in_sensor: axis.into(), explained });
    }
    let rotation = axes_rotation(rows);
    let turned =
        explained(median_of(rows, |m| (rotation * ideal_axis(m)).angle(&measured_axis(m)))?);
    match turned {
        Some(_) if has_frame_difference => None,
        Some(explained) => Some(Suspicion::OrientationFrame {
            angle_rad: rotation_angle_rad(&rotation),
            explained,
        }),
        None => {
            (before > UNEXPLAINED_RAD).then_some(Suspicion::Orientations { median_rad: before })
        }
    }
}

/// The simplest change that is about as good as the best, of the measured side first.
fn best_change(rows: &[Measurement]) -> Option<(Side, QuaternionChange, f64)> {
    let identity = |q: &UnitQuaternion<f64>| *q;
    let mut tried = Vec::new();
    for side in [Side::Measured, Side::Ideal, Side::Both] {
        for change in QuaternionChange::all() {
            let changed = |q: &UnitQuaternion<f64>| change.apply(q);
            let after = match side {
                Side::Measured => apart(rows, identity, changed),
                Side::Ideal => apart(rows, changed, identity),
                Side::Both => apart(rows, changed, changed),
            };
            tried.push((side, change, after?));
        }
    }
    let best = tried.iter().map(|tried| tried.2).min_by(f64::total_cmp)?;
    let is_good = |found: &(Side, QuaternionChange, f64)| found.2 <= AS_GOOD * best + AS_GOOD_RAD;
    tried.into_iter().find(is_good)
}

/// Median angle between the z axes of the two sides, each rotation changed.
fn apart(
    rows: &[Measurement],
    ideal: impl Fn(&UnitQuaternion<f64>) -> UnitQuaternion<f64>,
    measured: impl Fn(&UnitQuaternion<f64>) -> UnitQuaternion<f64>,
) -> Option<f64> {
    median_of(rows, |m| {
        let z = Vector3::z();
        let ideal_axis = ideal(&m.tracker_from_ideal.rotation) * z;
        ideal_axis.angle(&(measured(&m.tracker_from_measured.rotation) * z))
    })
}

fn median_of(rows: &[Measurement], value: impl Fn(&Measurement) -> f64) -> Option<f64> {
    median(&mut rows.iter().map(value).collect::<Vec<_>>())
}

fn ideal_axis(m: &Measurement) -> Vector3<f64> {
    m.tracker_from_ideal.rotation * Vector3::z()
}

fn measured_axis(m: &Measurement) -> Vector3<f64> {
    m.tracker_from_measured.rotation * Vector3::z()
}

/// The measured z axis in the ideal sensor's frame, where it is one throughout.
fn mean_axis_in_sensor(rows: &[Measurement]) -> Option<Vector3<f64>> {
    let each = rows.iter().map(|m| m.tracker_from_ideal.rotation.inverse() * measured_axis(m));
    let mean = each.sum::<Vector3<f64>>() / rows.len() as f64;
    // Directions all over the sphere have a mean near zero, whose direction is meaningless.
    mean.try_normalize(0.5)
}

/// The rotation that takes the ideal axes nearest to the measured ones (Wahba 1965).
fn axes_rotation(rows: &[Measurement]) -> UnitQuaternion<f64> {
    let each = rows.iter().map(|m| ideal_axis(m) * measured_axis(m).transpose());
    svd3(&each.sum::<Matrix3<f64>>()).best_rotation()
}
