//! Which way a sensor points at a place of the surface.

use crate::body::Sensor;
use nalgebra::{Unit, Vector3};
use serde::{Deserialize, Serialize};
use trackwright_geometry::rotation::perpendicular;
use trackwright_geometry::surface::SurfacePoint;

/// Shortest part of an axis along the surface that still is a direction.
const MIN_ALONG: f64 = 1e-9;

/// How a sensor is turned where it is put.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum AxisRule {
    /// As it is now.
    #[default]
    Keep,
    /// Along the surface's normal, outward.
    Normal,
    /// Along the surface, as near to its present axis as that allows.
    Tangent,
}

impl AxisRule {
    pub const ALL: [Self; 3] = [Self::Keep, Self::Normal, Self::Tangent];

    /// What a person calls it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Keep => "as it is",
            Self::Normal => "out of the surface",
            Self::Tangent => "along the surface",
        }
    }

    /// The sensor at a place of its body's surface, by the smallest turn that the rule needs; a
    /// marker needs none.
    pub fn placed(self, sensor: &Sensor, at: &SurfacePoint) -> Sensor {
        let placed = Sensor { position_in_body: at.position_mm, ..sensor.clone() };
        let Some(own) = sensor.axis_in_body() else {
            return placed;
        };
        let axis = match self {
            Self::Keep => own,
            Self::Normal => at.normal,
            Self::Tangent => along_surface(&own, &at.normal),
        };
        placed.pointed_along(&axis)
    }
}

/// The direction along a surface that is nearest to an axis.
pub fn along_surface(axis: &Unit<Vector3<f64>>, normal: &Unit<Vector3<f64>>) -> Unit<Vector3<f64>> {
    let part = axis.into_inner() - normal.into_inner() * normal.dot(axis);
    Unit::try_new(part, MIN_ALONG).unwrap_or_else(|| perpendicular(normal))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::SensorOrientation;
    use nalgebra::{Point3, UnitQuaternion};

    #[test]
    fn each_axis_rule_moves_the_sensor_and_sets_its_axis() {
        let at = SurfacePoint {
            position_mm: Point3::new(1.0, 2.0, 3.0),
            normal: Unit::new_normalize(Vector3::new(0.2, -0.4, 0.9)),
        };
        let tilted = Unit::new_normalize(Vector3::new(0.5, 0.1, -0.7));
        let orientations = [
            SensorOrientation::FiveDof(tilted),
            SensorOrientation::FiveDof(-at.normal),
            SensorOrientation::SixDof(UnitQuaternion::from_euler_angles(0.3, 1.0, -2.0)),
        ];
        for orientation in orientations {
            let sensor = Sensor::new("moved", Point3::origin(), orientation);
            let axis = |rule: AxisRule| {
                let placed = rule.placed(&sensor, &at);
                assert_eq!(placed.position_in_body, at.position_mm);
                placed.axis_in_body().unwrap()
            };
            let own = sensor.axis_in_body().unwrap();
            assert_eq!(axis(AxisRule::Keep), own);
            assert!((axis(AxisRule::Normal).into_inner() - at.normal.into_inner()).norm() < 1e-14);
            let tangent = axis(AxisRule::Tangent);
            assert!(tangent.dot(&at.normal).abs() < 1e-14);
            // Nothing along the surface is nearer to the axis than its shadow.
            let sine = own.cross(&at.normal).norm();
            assert!((tangent.dot(&own) - sine).abs() < 1e-13);
        }
    }
}
