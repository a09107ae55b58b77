//! Where the sensors of a body sit, as a workshop measures it.

use super::sheet::{BuiltBody, SheetAxis, SheetBody, SheetPair, SheetSensor};
use crate::body::{RigidBody, Sensor, SensorOrientation};
use crate::pairs::sensor_pairs;
use nalgebra::{Unit, Vector3};
use trackwright_geometry::pose::quaternion_to_array;

/// Sine of the angle to z below which an axis has no azimuth.
const ALONG_Z: f64 = 1e-9;

/// The body without tolerances.
pub fn sheet_body(role: BuiltBody, body: &RigidBody) -> SheetBody {
    let origin = match role {
        BuiltBody::Tool => Some(body.judged_tip_in_body()),
        BuiltBody::Crf => body.tip_in_body,
    };
    let sensor = |s: &Sensor| {
        let from_tip = origin.map(|origin| s.position_in_body - origin);
        SheetSensor {
            name: s.name.clone(),
            kind: s.orientation.kind_name(),
            position_in_body_mm: s.position_in_body.coords.into(),
            position_from_tip_mm: from_tip.map(Into::into),
            distance_from_tip_mm: from_tip.map(|v| v.norm()),
            axis: s.axis_in_body().map(sheet_axis),
            rotation: match &s.orientation {
                SensorOrientation::SixDof(rotation) => Some(quaternion_to_array(rotation)),
                SensorOrientation::Marker | SensorOrientation::FiveDof(_) => None,
            },
            coil: s.coil,
            alone: None,
        }
    };
    let count = body.sensors.len();
    let sum: Vector3<f64> = body.sensors.iter().map(|s| s.position_in_body.coords).sum();
    SheetBody {
        role,
        name: body.name.clone(),
        tip_in_body_mm: body.tip_in_body.map(|tip| tip.coords.into()),
        centroid_in_body_mm: (count > 0).then(|| (sum / count as f64).into()),
        sensors: body.sensors.iter().map(sensor).collect(),
        pairs: sensor_pairs(&body.sensors)
            .map(|pair| SheetPair {
                a: pair.a,
                b: pair.b,
                distance_mm: pair.distance_mm,
                angle_deg: pair.angle_rad.map(f64::to_degrees),
            })
            .collect(),
        together: None,
    }
}

fn sheet_axis(axis: Unit<Vector3<f64>>) -> SheetAxis {
    let across = axis.x.hypot(axis.y);
    SheetAxis {
        direction: axis.into_inner().into(),
        polar_deg: across.atan2(axis.z).to_degrees(),
        azimuth_deg: (across > ALONG_Z).then(|| axis.y.atan2(axis.x).to_degrees()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn an_axis_along_z_has_no_azimuth() {
        assert_eq!(sheet_axis(Vector3::z_axis()).azimuth_deg, None);
        let down = sheet_axis(-Vector3::z_axis());
        assert_eq!((down.polar_deg, down.azimuth_deg), (180.0, None));
        let y = sheet_axis(Vector3::y_axis());
        assert_eq!((y.polar_deg, y.azimuth_deg), (90.0, Some(90.0)));
    }

    proptest! {
        #[test]
        fn the_two_angles_are_the_axis(x in -1.0..1.0_f64, y in -1.0..1.0_f64, z in -1.0..1.0_f64) {
            prop_assume!(Vector3::new(x, y, z).norm() > 1e-3);
            let axis = Unit::new_normalize(Vector3::new(x, y, z));
            let found = sheet_axis(axis);
            let polar = found.polar_deg.to_radians();
            let azimuth = found.azimuth_deg.unwrap_or(0.0).to_radians();
            let back = Vector3::new(
                polar.sin() * azimuth.cos(),
                polar.sin() * azimuth.sin(),
                polar.cos(),
            );
            prop_assert!((back - axis.into_inner()).norm() < 1e-8);
        }
    }
}
