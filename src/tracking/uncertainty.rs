//! First-order answer of a frame fit to small errors of its sensors (MATH, first-order
//! uncertainty; DOMAIN 3.4).
//!
//! A sensor's position error `e` and rotation error `φ` move the sensors' centroid by
//! `t = mean(e)` and turn the body by `θ = A⁻¹ [Σ x × e + w² Σ (I − n nᵀ) φ]`, so that a point at
//! `d` from the centroid moves by `t + θ × d`. Everything is in the body's axes: the fit knows no
//! others, and a covariance turns with the body.
//!
//! `A = tr(S) I − S`, where `S` is the cross-covariance of exact readings, so that what the
//! frame fit cannot determine and where `A` is singular are one statement.

use super::body::{RigidBody, SensorOrientation};
use super::frame_fit::{Determination, determination};
use super::tool_in_crf::FreeMotion;
use crate::geometry::svd3::svd3;
use nalgebra::{Matrix3, Point3, UnitQuaternion, Vector3};

/// Distance from a free axis, as a part of the distance from the centroid, below which a turn
/// about the axis moves nothing but round-off.
const ON_AXIS_RATIO: f64 = 1e-9;

/// The error of one sensor's reading, in the axes of whoever asks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorError {
    pub position_mm: Vector3<f64>,
    pub rotation_rad: Vector3<f64>,
}

/// Independent errors of one sensor, body axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorCovariance {
    pub position_mm2: Matrix3<f64>,
    pub rotation_rad2: Matrix3<f64>,
}

impl SensorCovariance {
    /// The same in every direction, and so in all axes.
    pub fn isotropic(position_std_mm: f64, rotation_std_rad: f64) -> Self {
        Self {
            position_mm2: Matrix3::identity() * (position_std_mm * position_std_mm),
            rotation_rad2: Matrix3::identity() * (rotation_std_rad * rotation_std_rad),
        }
    }
}

/// A small rigid motion: the centroid's shift and the turn about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmallMotion {
    pub shift_mm: Vector3<f64>,
    pub turn_rad: Vector3<f64>,
}

impl SmallMotion {
    /// How far a point moves that lies at `lever_mm` from the centroid.
    pub fn at(&self, lever_mm: &Vector3<f64>) -> Vector3<f64> {
        self.shift_mm + self.turn_rad.cross(lever_mm)
    }
}

/// Covariance of a small rigid motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionCovariance {
    pub shift_mm2: Matrix3<f64>,
    /// Rows are the shift's components, columns the turn's.
    pub shift_turn_mm_rad: Matrix3<f64>,
    pub turn_rad2: Matrix3<f64>,
}

impl MotionCovariance {
    pub fn zero() -> Self {
        Self {
            shift_mm2: Matrix3::zeros(),
            shift_turn_mm_rad: Matrix3::zeros(),
            turn_rad2: Matrix3::zeros(),
        }
    }

    /// Of a point at `lever_mm` from the centroid: `Cov(t − [d]× θ)`.
    pub fn point_mm2(&self, lever_mm: &Vector3<f64>) -> Matrix3<f64> {
        let lever = lever_mm.cross_matrix();
        let mixed = self.shift_turn_mm_rad * lever.transpose();
        symmetric(
            &(self.shift_mm2 - mixed - mixed.transpose()
                + lever * self.turn_rad2 * lever.transpose()),
        )
    }

    /// Between a point at `lever_mm` (rows) and the turn (columns).
    pub fn point_turn_mm_rad(&self, lever_mm: &Vector3<f64>) -> Matrix3<f64> {
        self.shift_turn_mm_rad - lever_mm.cross_matrix() * self.turn_rad2
    }

    /// In other axes.
    pub fn rotated_by(&self, target_from_source: &UnitQuaternion<f64>) -> Self {
        let r = target_from_source.to_rotation_matrix().into_inner();
        let turned = |m: &Matrix3<f64>| r * m * r.transpose();
        Self {
            shift_mm2: turned(&self.shift_mm2),
            shift_turn_mm_rad: turned(&self.shift_turn_mm_rad),
            turn_rad2: turned(&self.turn_rad2),
        }
    }

    fn add_scaled(&mut self, other: &Self, factor: f64) {
        self.shift_mm2 += other.shift_mm2 * factor;
        self.shift_turn_mm_rad += other.shift_turn_mm_rad * factor;
        self.turn_rad2 += other.turn_rad2 * factor;
    }
}

/// The sensors leave a rotation free, so a point away from their centroid has no covariance.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "the sensors do not determine the rotation: eigenvalues {smallest:.3e} and {largest:.3e} mm²"
)]
pub struct RotationNotDetermined {
    pub smallest: f64,
    pub largest: f64,
}

/// A body's frame fit, linearised at exact readings.
#[derive(Clone, Debug)]
pub struct LinearFit {
    sensors: Vec<LinearSensor>,
    centroid_in_body: Point3<f64>,
    /// `A⁻¹`; no turn about what is free.
    inverse: Matrix3<f64>,
    /// Of `A`, ascending, mm².
    eigenvalues_mm2: [f64; 3],
    determination: Determination,
}

/// What a unit error of one sensor turns the body by, before `A⁻¹`.
#[derive(Clone, Copy, Debug)]
struct LinearSensor {
    /// `x`, from the centroid.
    arm_mm: Vector3<f64>,
    /// `w² (I − n nᵀ)`, or `2 w² I` for a 6-DOF sensor.
    seen_mm2: Matrix3<f64>,
    is_five_dof: bool,
}

impl LinearFit {
    pub fn new(body: &RigidBody, orientation_weight_mm: f64) -> Self {
        let n = body.sensors.len().max(1) as f64;
        let weight_mm2 = orientation_weight_mm * orientation_weight_mm;
        let sum: Vector3<f64> = body.sensors.iter().map(|s| s.position_in_body.coords).sum();
        let centroid = sum / n;
        let mut covariance = Matrix3::zeros();
        let sensors = body
            .sensors
            .iter()
            .map(|s| {
                let arm_mm = s.position_in_body.coords - centroid;
                // Σ over a sensor's known axes of n nᵀ, and of I − n nᵀ.
                let (known, seen) = match &s.orientation {
                    SensorOrientation::FiveDof(n) => {
                        let known = n.into_inner() * n.transpose();
                        (known, Matrix3::identity() - known)
                    }
                    SensorOrientation::SixDof(_) => {
                        (Matrix3::identity(), Matrix3::identity() * 2.0)
                    }
                };
                covariance += arm_mm * arm_mm.transpose() + known * weight_mm2;
                LinearSensor {
                    arm_mm,
                    seen_mm2: seen * weight_mm2,
                    is_five_dof: matches!(s.orientation, SensorOrientation::FiveDof(_)),
                }
            })
            .collect();
        let svd = svd3(&covariance);
        let s = svd.singular_values;
        // Turning about the k-th axis is held by the other two.
        let eigenvalues_mm2 = [s[1] + s[2], s[0] + s[2], s[0] + s[1]];
        let determination = determination(&svd);
        let first_held = match determination {
            Determination::Full | Determination::Poor { .. } => 0,
            Determination::FreeAxis { .. } => 1,
            Determination::FreeRotation => 3,
        };
        let inverse = (first_held..3)
            .map(|k| svd.u.column(k) * svd.u.column(k).transpose() / eigenvalues_mm2[k])
            .sum();
        Self {
            sensors,
            centroid_in_body: centroid.into(),
            inverse,
            eigenvalues_mm2,
            determination,
        }
    }

    /// The same, or why a point away from the centroid has no covariance.
    ///
    /// # Errors
    /// [`RotationNotDetermined`] where the sensors leave a rotation free.
    pub fn determined(self) -> Result<Self, RotationNotDetermined> {
        if self.free_motion().is_none() {
            return Ok(self);
        }
        let [smallest, _, largest] = self.eigenvalues_mm2;
        Err(RotationNotDetermined { smallest, largest })
    }

    pub fn determination(&self) -> &Determination {
        &self.determination
    }

    /// What the sensors leave free, in the body's frame.
    pub fn free_motion(&self) -> Option<FreeMotion> {
        FreeMotion::in_body(&self.determination, self.centroid_in_body)
    }

    /// From the centroid to a point.
    pub fn lever_mm(&self, point_in_body: &Point3<f64>) -> Vector3<f64> {
        point_in_body - self.centroid_in_body
    }

    /// The motion that the sensors' errors cause, all in body axes, one error a sensor.
    pub fn motion(&self, errors: &[SensorError]) -> SmallMotion {
        debug_assert_eq!(errors.len(), self.sensors.len(), "one error a sensor");
        let n = self.sensors.len().max(1) as f64;
        let mut shift_mm = Vector3::zeros();
        let mut moment = Vector3::zeros();
        for (sensor, error) in self.sensors.iter().zip(errors) {
            shift_mm += error.position_mm / n;
            moment +=
                sensor.arm_mm.cross(&error.position_mm) + sensor.seen_mm2 * error.rotation_rad;
        }
        SmallMotion {
            shift_mm,
            turn_rad: self.inverse * moment,
        }
    }

    /// Covariance of the motion from one independent covariance a sensor.
    pub fn covariance(&self, sensors: &[SensorCovariance]) -> MotionCovariance {
        debug_assert_eq!(sensors.len(), self.sensors.len(), "one covariance a sensor");
        let mut sum = MotionCovariance::zero();
        for (sensor, covariance) in self.sensors.iter().zip(sensors) {
            let (position, rotation) = self.contributions(sensor, covariance);
            sum.add_scaled(&position, 1.0);
            sum.add_scaled(&rotation, 1.0);
        }
        sum
    }

    /// What each sensor adds to the covariance for a unit variance of its position, mm², and of
    /// its rotation, rad²; for errors without a direction whose size changes from place to place.
    pub fn unit_covariances(&self) -> Vec<UnitCovariance> {
        let unit = SensorCovariance::isotropic(1.0, 1.0);
        self.sensors
            .iter()
            .map(|sensor| {
                let (position, rotation) = self.contributions(sensor, &unit);
                UnitCovariance { position, rotation }
            })
            .collect()
    }

    /// Whether each sensor is a 5-DOF one, whose roll is no reading.
    pub fn are_five_dof(&self) -> impl Iterator<Item = bool> + '_ {
        self.sensors.iter().map(|s| s.is_five_dof)
    }

    fn contributions(
        &self,
        sensor: &LinearSensor,
        covariance: &SensorCovariance,
    ) -> (MotionCovariance, MotionCovariance) {
        let n = self.sensors.len() as f64;
        let by_position = self.inverse * sensor.arm_mm.cross_matrix();
        let by_rotation = self.inverse * sensor.seen_mm2;
        let position = MotionCovariance {
            shift_mm2: covariance.position_mm2 / (n * n),
            shift_turn_mm_rad: covariance.position_mm2 * by_position.transpose() / n,
            turn_rad2: by_position * covariance.position_mm2 * by_position.transpose(),
        };
        let rotation = MotionCovariance {
            turn_rad2: by_rotation * covariance.rotation_rad2 * by_rotation.transpose(),
            ..MotionCovariance::zero()
        };
        (position, rotation)
    }
}

/// What one sensor adds to a motion's covariance for unit variances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnitCovariance {
    pub position: MotionCovariance,
    pub rotation: MotionCovariance,
}

impl UnitCovariance {
    /// Adds this sensor at given standard deviations, position per axis and rotation per component.
    pub fn add_to(&self, sum: &mut MotionCovariance, position_std_mm: f64, rotation_std_rad: f64) {
        sum.add_scaled(&self.position, position_std_mm * position_std_mm);
        sum.add_scaled(&self.rotation, rotation_std_rad * rotation_std_rad);
    }
}

impl FreeMotion {
    /// Projects a small error of a point, in the free motion's frame, to the part that no free
    /// rotation can change: along the axis and towards it, or towards the centre.
    pub fn determined_projection(&self, point: &Point3<f64>) -> Matrix3<f64> {
        let lever = point - self.center;
        let (axial, radial) = match &self.axis {
            None => (Matrix3::zeros(), lever),
            Some(axis) => {
                let a = axis.into_inner();
                (a * a.transpose(), lever - a * a.dot(&lever))
            }
        };
        if radial.norm() <= ON_AXIS_RATIO * lever.norm() {
            return Matrix3::identity();
        }
        let u = radial.normalize();
        axial + u * u.transpose()
    }
}

/// Covariance in mm² of a point of the body, all in the body frame, from one covariance a sensor.
///
/// # Errors
/// [`RotationNotDetermined`] where the sensors leave a rotation free.
pub fn point_covariance_mm2(
    body: &RigidBody,
    orientation_weight_mm: f64,
    sensors: &[SensorCovariance],
    point_in_body: &Point3<f64>,
) -> Result<Matrix3<f64>, RotationNotDetermined> {
    let linear = LinearFit::new(body, orientation_weight_mm).determined()?;
    Ok(linear
        .covariance(sensors)
        .point_mm2(&linear.lever_mm(point_in_body)))
}

/// Without what round-off adds to one side of the diagonal.
fn symmetric(m: &Matrix3<f64>) -> Matrix3<f64> {
    (m + m.transpose()) * 0.5
}
