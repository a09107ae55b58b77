//! The direction of a tool's shaft, from its tip and its sensors.

use super::body::RigidBody;
use nalgebra::{Unit, Vector3};

/// Sensors whose mean is nearer to the tip determine no direction of a shaft.
const LEAST_SHAFT_MM: f64 = 10.0;

/// Tools are drawn along an axis of their frame; sensors stand beside it on either side. A line
/// from tip to sensors that is this close to an axis of the frame means that axis.
const ALONG_AXIS_DEG: f64 = 20.0;

/// From the tip along the shaft; `None` where the sensors do not determine it.
pub fn shaft_in_body(body: &RigidBody) -> Option<Unit<Vector3<f64>>> {
    let tip = body.judged_tip_in_body();
    let sum: Vector3<f64> = body.sensors.iter().map(|s| s.position_in_body - tip).sum();
    let mean = sum / body.sensors.len().max(1) as f64;
    let line = Unit::try_new(mean, LEAST_SHAFT_MM)?;
    let longest = line.iamax();
    let mut axis = Vector3::zeros();
    axis[longest] = line[longest].signum();
    let is_along = line.angle(&axis).to_degrees() <= ALONG_AXIS_DEG;
    Some(if is_along { Unit::new_unchecked(axis) } else { line })
}
