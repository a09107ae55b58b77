//! Whether a body turned enough for its sensors' places to be determined.
//!
//! Where every turn is about one axis `u` of the body, `R u` is the same in every pose, and moving a
//! sensor along `u` moves all its readings alike: `Y` takes it up. So what counts is the least
//! singular value of the stacked `R − R̄` (`calibration/pivot.rs` asks for the same).

use super::{HandEyeError, PairedReading};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use std::collections::BTreeMap;
use trackwright_geometry::rotation::{log_quaternion, rotation_angle_rad};
use trackwright_geometry::svd3::svd3;

/// How a body turned, seen by the reference tracker.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Largest angle from the first pose to any other: at least half of that between any two.
    pub largest_rad: f64,
    /// RMS turn about the axis that the body turned about least.
    pub least_turn_rad: f64,
    /// RMS turn about the axis that it turned about second least.
    pub second_turn_rad: f64,
    /// The axis whose direction hardly changed: what the body turned about, if anything.
    pub axis_in_body: Vector3<f64>,
    pub axis_in_reference: Vector3<f64>,
}

pub(super) fn of(readings: &[PairedReading]) -> Motion {
    // Every pose once, however many sensors were read in it.
    let poses: BTreeMap<usize, UnitQuaternion<f64>> =
        readings.iter().map(|r| (r.pose, r.reference_from_body.rotation)).collect();
    let rotations: Vec<Matrix3<f64>> =
        poses.values().map(|r| r.to_rotation_matrix().into_inner()).collect();
    let count = rotations.len().max(1) as f64;
    let mean = rotations.iter().sum::<Matrix3<f64>>() / count;
    let squares: Matrix3<f64> = rotations.iter().map(|r| (r - mean).transpose() * (r - mean)).sum();
    let svd = svd3(&(squares / count));
    let first = poses.values().next().copied().unwrap_or_default();
    let largest_rad =
        poses.values().map(|r| rotation_angle_rad(&(first.inverse() * r))).fold(0.0, f64::max);
    let axis_in_body: Vector3<f64> = svd.v.column(2).into_owned();
    // The sense of the longest turn, so that it reads like one.
    let turn = poses
        .values()
        .map(|r| log_quaternion(&(first.inverse() * r)))
        .max_by(|a, b| a.norm().total_cmp(&b.norm()))
        .unwrap_or_default();
    let sign = if turn.dot(&axis_in_body) < 0.0 { -1.0 } else { 1.0 };
    let in_reference = mean * axis_in_body;
    // Round-off reads like a tilt.
    let clean = |axis: Vector3<f64>| {
        let unit = axis.try_normalize(0.0).unwrap_or(axis);
        unit.map(|v| if v.abs() < 1e-9 { 0.0 } else { v * sign })
    };
    Motion {
        largest_rad,
        least_turn_rad: svd.singular_values[2].max(0.0).sqrt(),
        second_turn_rad: svd.singular_values[1].max(0.0).sqrt(),
        axis_in_body: clean(axis_in_body),
        axis_in_reference: clean(in_reference),
    }
}

impl Motion {
    pub(super) fn check(&self, min_turn_rad: f64) -> Result<(), HandEyeError> {
        // A rotation of 0 leaves nothing to solve for, whatever is allowed.
        let needed_rad = min_turn_rad.max(1e-6);
        // A turn about one axis moves the two directions across it.
        if self.second_turn_rad < needed_rad {
            return Err(HandEyeError::NoRotation { largest_deg: self.largest_rad.to_degrees() });
        }
        if self.least_turn_rad < needed_rad {
            return Err(HandEyeError::OneAxis {
                axis_in_body: self.axis_in_body,
                axis_in_reference: self.axis_in_reference,
                found_deg: self.least_turn_rad.to_degrees(),
                needed_deg: needed_rad.to_degrees(),
            });
        }
        Ok(())
    }
}
