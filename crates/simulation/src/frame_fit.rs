//! Six-degree frame of a rigid body from its sensors' readings (9)–(13).
//!
//! Positions and weighted axes enter one cross-covariance whose SVD gives the rotation (Arun,
//! Huang, Blostein, IEEE PAMI 9(5), 1987); the determinant correction keeps it a rotation
//! (Umeyama, IEEE PAMI 13(4), 1991). The sum of equation (11) runs over all rows, positions and
//! axes alike.

use super::body::{RigidBody, SensorOrientation};
use nalgebra::{Matrix3, Point3, Unit, UnitQuaternion, Vector3};
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_geometry::rotation::{axis_rotation, exp_vector};
use trackwright_geometry::svd3::{Svd3, svd3};

/// Second singular value of the cross-covariance, relative to the first, at or below which a
/// rotation about one axis is free.
pub const FREE_AXIS_RATIO: f64 = 1e-10;

/// Up to here the rotation is given and flagged as poorly determined.
pub const POOR_RATIO: f64 = 1e-6;

/// Sensors that are no further from their mean than this part of their coordinates are at one
/// place: the mean is good to an epsilon, and what is left of the positions is its round-off.
const SAME_PLACE: f64 = 4.0 * f64::EPSILON;

/// Sensors whose contributions are added up before they join the sum of all: ten thousand in one
/// sum would lose a hundred times the digits of one sensor.
const SUMMED_AT_A_TIME: usize = 64;

/// A body made ready to be fitted many times.
#[derive(Clone, Debug)]
pub struct FrameFitter {
    sensors: Vec<FitterSensor>,
    centroid_in_body: Point3<f64>,
    orientation_weight_mm: f64,
}

#[derive(Clone, Copy, Debug)]
struct FitterSensor {
    /// From the sensors' centroid; exactly zero where all sensors are at one place, so that
    /// round-off never passes for a lever.
    arm_in_body: Vector3<f64>,
    orientation: SensorOrientation,
}

/// What a tracker reads of one sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    pub position_mm: Point3<f64>,
    /// The sensor's axes; only z counts for a 5-DOF sensor, and none for a marker.
    pub rotation: UnitQuaternion<f64>,
}

/// A fitted frame and how well its sensors determine it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameFit {
    pub tracker_from_body: Pose,
    /// Of the cross-covariance `H`, descending, mm².
    pub singular_values_mm2: Vector3<f64>,
    pub determination: Determination,
}

/// What of a body's rotation its sensors determine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Determination {
    Full,
    /// Determined, but by so little that noise decides; the ratio of the two largest singular
    /// values.
    Poor {
        ratio: f64,
    },
    /// Any turn about this axis through the sensors' centroid gives the same readings; the turn
    /// nearest to the true pose was taken.
    FreeAxis {
        axis_in_body: Unit<Vector3<f64>>,
    },
    /// No rotation is determined at all; the true one was taken.
    FreeRotation,
}

impl FrameFitter {
    pub fn new(body: &RigidBody, orientation_weight_mm: f64) -> Self {
        let positions = || body.sensors.iter().map(|s| s.position_in_body.coords);
        let n = body.sensors.len().max(1) as f64;
        let rough = positions().sum::<Vector3<f64>>() / n;
        // Once more from there: the round-off of a long sum is left behind.
        let centroid = rough + positions().map(|p| p - rough).sum::<Vector3<f64>>() / n;
        let spread = positions().map(|p| (p - centroid).amax()).fold(0.0, f64::max);
        let largest = positions().map(|p| p.amax()).fold(0.0, f64::max);
        let is_spread = spread > SAME_PLACE * largest;
        Self {
            sensors: body
                .sensors
                .iter()
                .map(|s| FitterSensor {
                    arm_in_body: if is_spread {
                        s.position_in_body.coords - centroid
                    } else {
                        Vector3::zeros()
                    },
                    orientation: s.orientation,
                })
                .collect(),
            centroid_in_body: Point3::from(centroid),
            orientation_weight_mm,
        }
    }

    /// Mean of the sensors' positions.
    pub fn centroid_in_body(&self) -> Point3<f64> {
        self.centroid_in_body
    }

    /// The frame that fits the readings, one a sensor in the body's order.
    ///
    /// `tracker_from_body_true` only decides what the sensors leave free.
    pub fn fit(&self, readings: &[Reading], tracker_from_body_true: &Pose) -> FrameFit {
        debug_assert_eq!(readings.len(), self.sensors.len(), "one reading a sensor");
        let n = readings.len().max(1) as f64;
        let partial =
            |some: &[Reading]| -> Vector3<f64> { some.iter().map(|r| r.position_mm.coords).sum() };
        let centroid = readings.chunks(SUMMED_AT_A_TIME).map(partial).sum::<Vector3<f64>>() / n;
        let svd = svd3(&self.cross_covariance(readings, &centroid));
        let s = svd.singular_values;
        let determination = determination(&svd);
        let rotation = match determination {
            Determination::FreeRotation => tracker_from_body_true.rotation,
            Determination::FreeAxis { axis_in_body } => {
                let measured = Unit::new_normalize(svd.v.column(0).into_owned());
                let turn =
                    axis_rotation(&(tracker_from_body_true.rotation * axis_in_body), &measured);
                exp_vector(&turn.vector_rad) * tracker_from_body_true.rotation
            }
            Determination::Full | Determination::Poor { .. } => svd.best_rotation(),
        };
        FrameFit {
            tracker_from_body: pose_from_parts(
                centroid - rotation * self.centroid_in_body.coords,
                rotation,
            ),
            singular_values_mm2: s,
            determination,
        }
    }

    /// `H = Σ q q'ᵀ` over positions and weighted axes (10), (11).
    fn cross_covariance(&self, readings: &[Reading], centroid: &Vector3<f64>) -> Matrix3<f64> {
        self.sensors
            .chunks(SUMMED_AT_A_TIME)
            .zip(readings.chunks(SUMMED_AT_A_TIME))
            .map(|(sensors, readings)| self.partial_covariance(sensors, readings, centroid))
            .sum()
    }

    fn partial_covariance(
        &self,
        sensors: &[FitterSensor],
        readings: &[Reading],
        centroid: &Vector3<f64>,
    ) -> Matrix3<f64> {
        let weight = self.orientation_weight_mm * self.orientation_weight_mm;
        let mut h = Matrix3::zeros();
        for (sensor, reading) in sensors.iter().zip(readings) {
            h += sensor.arm_in_body * (reading.position_mm.coords - centroid).transpose();
            match sensor.orientation {
                SensorOrientation::Marker => {}
                SensorOrientation::FiveDof(axis) => {
                    let measured = reading.rotation * Vector3::z();
                    h += axis.into_inner() * measured.transpose() * weight;
                }
                SensorOrientation::SixDof(rotation) => {
                    // Σ over the three axes of x x'ᵀ is R R'ᵀ.
                    let own = rotation.to_rotation_matrix();
                    let measured = reading.rotation.to_rotation_matrix();
                    h += own.matrix() * measured.matrix().transpose() * weight;
                }
            }
        }
        h
    }
}

/// What of a rotation a cross-covariance determines, by its singular values.
pub(super) fn determination(svd: &Svd3) -> Determination {
    let s = svd.singular_values;
    if s[0] <= 0.0 {
        Determination::FreeRotation
    } else if s[1] <= FREE_AXIS_RATIO * s[0] {
        Determination::FreeAxis { axis_in_body: Unit::new_normalize(svd.u.column(0).into_owned()) }
    } else if s[1] <= POOR_RATIO * s[0] {
        Determination::Poor { ratio: s[1] / s[0] }
    } else {
        Determination::Full
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Sensor;

    fn five(position: [f64; 3], axis: [f64; 3]) -> Sensor {
        Sensor::five_dof("", position, Unit::new_normalize(axis.into()))
    }

    fn body(sensors: Vec<Sensor>) -> RigidBody {
        RigidBody { name: "body".into(), tip_in_body: None, sensors }
    }

    fn truth() -> Pose {
        pose_from_parts(
            Vector3::new(10.0, -20.0, -300.0),
            UnitQuaternion::from_euler_angles(0.4, -1.1, 2.5),
        )
    }

    fn exact_readings(body: &RigidBody, pose: &Pose) -> Vec<Reading> {
        body.sensors
            .iter()
            .map(|s| {
                let at = pose * s.body_from_sensor();
                Reading { position_mm: at.translation.vector.into(), rotation: at.rotation }
            })
            .collect()
    }

    fn distance(a: &Pose, b: &Pose) -> f64 {
        (a.translation.vector - b.translation.vector).norm()
            + 100.0 * a.rotation.angle_to(&b.rotation)
    }

    #[test]
    fn exact_readings_give_the_exact_pose() {
        let b = body(vec![
            five([0.0, 0.0, 60.0], [0.0, 0.0, 1.0]),
            five([8.0, 0.0, 95.0], [0.0, -1.0, 0.2]),
        ]);
        let fit = FrameFitter::new(&b, 100.0).fit(&exact_readings(&b, &truth()), &Pose::identity());
        assert_eq!(fit.determination, Determination::Full);
        assert!(distance(&fit.tracker_from_body, &truth()) < 1e-10);
    }

    #[test]
    fn the_roll_of_a_five_dof_reading_changes_nothing() {
        let b = body(vec![
            five([0.0, 0.0, 60.0], [0.0, 0.0, 1.0]),
            five([8.0, 0.0, 95.0], [0.0, -1.0, 0.2]),
        ]);
        let fitter = FrameFitter::new(&b, 100.0);
        let plain = exact_readings(&b, &truth());
        let mut rolled = plain.clone();
        rolled[1].rotation *= UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 1.7);
        let (a, b) = (fitter.fit(&plain, &truth()), fitter.fit(&rolled, &truth()));
        assert!(distance(&a.tracker_from_body, &b.tracker_from_body) < 1e-10);
    }

    #[test]
    fn one_six_dof_sensor_determines_everything() {
        let mut b = body(vec![five([1.0, 2.0, 3.0], [0.0, 0.0, 1.0])]);
        b.sensors[0].orientation =
            SensorOrientation::SixDof(UnitQuaternion::from_euler_angles(0.1, 0.2, 0.3));
        let fit = FrameFitter::new(&b, 100.0).fit(&exact_readings(&b, &truth()), &Pose::identity());
        assert_eq!(fit.determination, Determination::Full);
        assert!(distance(&fit.tracker_from_body, &truth()) < 1e-10);
    }

    #[test]
    fn collinear_sensors_leave_a_free_axis_at_true_roll() {
        let b = body(vec![
            five([0.0, 0.0, 60.0], [0.0, 0.0, 1.0]),
            five([0.0, 0.0, 95.0], [0.0, 0.0, -1.0]),
        ]);
        let fit = FrameFitter::new(&b, 100.0).fit(&exact_readings(&b, &truth()), &truth());
        let Determination::FreeAxis { axis_in_body } = fit.determination else {
            panic!("{:?}", fit.determination);
        };
        assert!(axis_in_body.cross(&Vector3::z()).norm() < 1e-12);
        assert!(distance(&fit.tracker_from_body, &truth()) < 1e-10);
    }

    #[test]
    fn nearly_one_line_is_given_and_flagged() {
        let b = body(vec![
            five([0.0, 0.0, 60.0], [0.0, 0.0, 1.0]),
            five([0.0, 0.0, 95.0], [0.0, 1e-4, 1.0]),
        ]);
        let fit = FrameFitter::new(&b, 100.0).fit(&exact_readings(&b, &truth()), &truth());
        assert!(
            matches!(fit.determination, Determination::Poor { ratio } if ratio > 1e-10),
            "{:?}",
            fit.determination
        );
    }

    #[test]
    fn one_sensor_of_zero_axis_weight_fits_no_rotation() {
        let b = body(vec![five([0.0, 0.0, 60.0], [0.0, 0.0, 1.0])]);
        let fit = FrameFitter::new(&b, 0.0).fit(&exact_readings(&b, &truth()), &truth());
        assert_eq!(fit.determination, Determination::FreeRotation);
        assert!(distance(&fit.tracker_from_body, &truth()) < 1e-10);
    }
}
