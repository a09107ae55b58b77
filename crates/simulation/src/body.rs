//! Rigid bodies with sensors, in the body's own frame.

use nalgebra::{Point3, Unit, UnitQuaternion, Vector3};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::mesh_report::length_doubt;
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_geometry::rotation::{axis_rotation, exp_vector};

/// Turns below this come from the rounding of products of rotations.
const MIN_TURN_RAD: f64 = 1e-12;

/// A tool or a coordinate reference frame (CRF): sensors held rigidly together.
#[derive(Clone, Debug, PartialEq)]
pub struct RigidBody {
    pub name: String,
    /// What the body is for, in its frame, millimetres; the origin where none is given.
    pub tip_in_body: Option<Point3<f64>>,
    pub sensors: Vec<Sensor>,
}

impl RigidBody {
    /// The point whose error is judged.
    pub fn judged_tip_in_body(&self) -> Point3<f64> {
        self.tip_in_body.unwrap_or_else(Point3::origin)
    }

    /// What is wrong with the size of what its tip and sensors span, if anything.
    pub fn size_doubt(&self) -> Option<String> {
        let sensors = self.sensors.iter().map(|sensor| sensor.position_in_body);
        let bounds = Bounds::around(sensors.chain(self.tip_in_body))?;
        length_doubt(bounds.size_mm().amax())
    }
}

/// One coil assembly or marker, and where it sits.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensor {
    pub name: String,
    /// Millimetres, body frame.
    pub position_in_body: Point3<f64>,
    pub orientation: SensorOrientation,
    pub coil: Option<Coil>,
}

/// How a sensor is turned in its body, and how much of that it can measure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SensorOrientation {
    /// None: a marker of an optical tracker, whose position alone is measured.
    Marker,
    /// A unit axis, the sensor's local z. Its roll carries no information.
    FiveDof(Unit<Vector3<f64>>),
    /// `body_from_sensor` as a full rotation.
    SixDof(UnitQuaternion<f64>),
}

/// Size of a sensor's coil in millimetres.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Coil {
    #[serde(rename = "diameter")]
    pub diameter_mm: f64,
    #[serde(rename = "length")]
    pub length_mm: f64,
}

impl Sensor {
    /// A sensor whose coil is not known, or that has none.
    pub fn new(
        name: impl Into<String>,
        position_in_body: impl Into<Point3<f64>>,
        orientation: SensorOrientation,
    ) -> Self {
        let (name, position_in_body) = (name.into(), position_in_body.into());
        Self { name, position_in_body, orientation, coil: None }
    }

    /// A 5-DOF sensor with an axis.
    pub fn five_dof(
        name: impl Into<String>,
        position_in_body: impl Into<Point3<f64>>,
        axis_in_body: Unit<Vector3<f64>>,
    ) -> Self {
        Self::new(name, position_in_body, SensorOrientation::FiveDof(axis_in_body))
    }

    /// A 6-DOF sensor with a rotation `body_from_sensor`.
    pub fn six_dof(
        name: impl Into<String>,
        position_in_body: impl Into<Point3<f64>>,
        body_from_sensor: UnitQuaternion<f64>,
    ) -> Self {
        Self::new(name, position_in_body, SensorOrientation::SixDof(body_from_sensor))
    }

    /// The sensor's local z in the body frame; none of a marker.
    pub fn axis_in_body(&self) -> Option<Unit<Vector3<f64>>> {
        self.orientation.axis()
    }

    /// The sensor with its axis along a direction, by the smallest turn; a marker as it is.
    #[must_use]
    pub fn pointed_along(self, axis_in_body: &Unit<Vector3<f64>>) -> Self {
        match self.axis_in_body() {
            Some(own) if own != *axis_in_body => {
                let turn = exp_vector(&axis_rotation(&own, axis_in_body).vector_rad);
                Self { orientation: self.orientation.rotated_by(&turn), ..self }
            }
            _ => self,
        }
    }

    /// The sensor after its pose was moved from `start` to `now` in the body frame; where the
    /// turn is round-off the orientation stays as it was.
    pub fn moved(&self, start: &Pose, now: &Pose) -> Self {
        let turn = now.rotation * start.rotation.inverse();
        let mut sensor = self.clone();
        sensor.position_in_body = now.translation.vector.into();
        if turn.angle() > MIN_TURN_RAD {
            sensor.orientation = self.orientation.rotated_by(&turn);
        }
        sensor
    }

    /// The sensor after something that it moves with went from `start` to `now` in the body frame.
    pub fn carried(&self, start: &Pose, now: &Pose) -> Self {
        let turn = now.rotation * start.rotation.inverse();
        // A turn that is round-off would shift what is far from where it turns.
        let turn = if turn.angle() > MIN_TURN_RAD { turn } else { UnitQuaternion::identity() };
        let own = self.body_from_sensor();
        let from_start = own.translation.vector - start.translation.vector;
        let shift = now.translation.vector - start.translation.vector;
        let swing = turn * from_start - from_start;
        self.moved(
            &own,
            &pose_from_parts(own.translation.vector + swing + shift, turn * own.rotation),
        )
    }

    /// The sensor's pose; for a 5-DOF sensor one of the many with its axis, for a marker turned
    /// like the body.
    pub fn body_from_sensor(&self) -> Pose {
        pose_from_parts(self.position_in_body.coords, self.orientation.any_rotation())
    }
}

impl SensorOrientation {
    /// The sensor's local z; none of a marker.
    pub fn axis(&self) -> Option<Unit<Vector3<f64>>> {
        match self {
            Self::Marker => None,
            Self::FiveDof(axis) => Some(*axis),
            Self::SixDof(rotation) => Some(rotation * Vector3::z_axis()),
        }
    }

    /// A rotation whose z is the axis: the smallest from z for a 5-DOF sensor, none for a marker.
    pub fn any_rotation(&self) -> UnitQuaternion<f64> {
        match self {
            Self::Marker => UnitQuaternion::identity(),
            Self::SixDof(rotation) => *rotation,
            Self::FiveDof(axis) => UnitQuaternion::rotation_between_axis(&Vector3::z_axis(), axis)
                .unwrap_or_else(|| {
                    UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI)
                }),
        }
    }

    /// The orientation after a rotation in the body frame.
    pub fn rotated_by(&self, rotation: &UnitQuaternion<f64>) -> Self {
        match self {
            Self::Marker => Self::Marker,
            Self::FiveDof(axis) => Self::FiveDof(Unit::new_normalize(rotation * axis.into_inner())),
            Self::SixDof(own) => {
                Self::SixDof(UnitQuaternion::new_normalize((rotation * own).into_inner()))
            }
        }
    }

    pub fn degrees_of_freedom(&self) -> u8 {
        match self {
            Self::Marker => 3,
            Self::FiveDof(_) => 5,
            Self::SixDof(_) => 6,
        }
    }

    /// What a person calls a sensor that measures this.
    pub fn kind_name(&self) -> &'static str {
        match self {
            Self::Marker => "marker",
            Self::FiveDof(_) => "5 DOF",
            Self::SixDof(_) => "6 DOF",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    fn sensor(position: [f64; 3]) -> Sensor {
        Sensor::five_dof("a", position, Vector3::x_axis())
    }

    #[test]
    fn a_carried_sensor_keeps_its_relative_pose() {
        let start = pose_from_parts(Vector3::new(2.0, 0.0, 60.0), UnitQuaternion::identity());
        let quarter = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), FRAC_PI_2);
        let now = pose_from_parts(Vector3::new(0.0, 2.0, 70.0), quarter);
        let carried = sensor([3.0, 0.0, 90.0]).carried(&start, &now);
        let expected = Point3::new(0.0, 3.0, 100.0);
        assert!((carried.position_in_body - expected).norm() < 1e-12);
        assert!((carried.axis_in_body().unwrap().into_inner() - Vector3::y()).norm() < 1e-12);
    }

    #[test]
    fn what_is_carried_nowhere_stays_as_it_is_to_the_bit() {
        let turn = UnitQuaternion::from_euler_angles(0.3, 1.1, -2.0);
        let start = pose_from_parts(Vector3::new(0.1, 0.7, 60.3), turn);
        let other = sensor([0.123, -4.56, 99.9]);
        assert_eq!(other.carried(&start, &start), other);
    }
}
