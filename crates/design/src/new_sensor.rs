//! Sensors to begin with: beside the last one, or on the body's surface.

use super::arrange::fresh_name;
use nalgebra::{Point3, Unit, Vector3};
use std::collections::HashSet;
use trackwright_geometry::surface::SurfacePoint;
use trackwright_geometry::surface_drag::SurfaceDirections;
use trackwright_simulation::body::{RigidBody, Sensor, SensorOrientation};

/// How far beside the last one, along its axis: to be seen and dragged away.
const BESIDE_MM: f64 = 15.0;

/// One beside the body's last sensor and turned like it; at the tip, along z, where it has none.
pub fn sensor_beside_last(body: &RigidBody) -> Sensor {
    match body.sensors.last() {
        None => sensor(body, body.judged_tip_in_body(), Vector3::z_axis()),
        Some(last) => {
            let axis = last.axis_in_body().unwrap_or_else(Vector3::z_axis);
            let place = last.position_in_body + axis.into_inner() * BESIDE_MM;
            sensor(body, place, axis)
        }
    }
}

/// One at a point of the body's surface with its axis along the shaft there, as a coil is glued
/// on.
pub fn sensor_on_surface(
    body: &RigidBody,
    at: &SurfacePoint,
    directions: &SurfaceDirections,
) -> Sensor {
    sensor(body, at.position_mm, directions.along)
}

/// With a name of its own, the coil of the last one, and a marker as that is.
fn sensor(body: &RigidBody, place: Point3<f64>, axis: Unit<Vector3<f64>>) -> Sensor {
    let taken: HashSet<String> = body.sensors.iter().map(|s| s.name.clone()).collect();
    let last = body.sensors.last();
    let is_marker = last.is_some_and(|last| last.orientation == SensorOrientation::Marker);
    let first = if is_marker { "marker 1" } else { "sensor 1" }.to_owned();
    Sensor {
        name: match taken.contains(&first) {
            true => fresh_name(&first, &taken),
            false => first,
        },
        position_in_body: place,
        orientation: match is_marker {
            true => SensorOrientation::Marker,
            false => SensorOrientation::FiveDof(axis),
        },
        coil: last.and_then(|last| last.coil),
    }
}
