//! First-order answer of a frame fit to small errors of its sensors.
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
use nalgebra::{Matrix3, Point3, Unit, UnitQuaternion, Vector3};
use trackwright_field::samples::PoseError;
use trackwright_geometry::svd3::svd3;

/// Distance from a free axis, as a part of the distance from the centroid, below which a turn
/// about the axis moves nothing but round-off.
const ON_AXIS_RATIO: f64 = 1e-9;

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
    /// The axis of the first of them: a turn about it is held least.
    least_held: Vector3<f64>,
    determination: Determination,
}

/// What a unit error of one sensor turns the body by, before `A⁻¹`.
#[derive(Clone, Copy, Debug)]
struct LinearSensor {
    /// `x`, from the centroid.
    arm_mm: Vector3<f64>,
    /// `w² (I − n nᵀ)`, or `2 w² I` for a 6-DOF sensor and nothing for a marker.
    seen_mm2: Matrix3<f64>,
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
                    SensorOrientation::Marker => (Matrix3::zeros(), Matrix3::zeros()),
                    SensorOrientation::FiveDof(n) => {
                        let known = n.into_inner() * n.transpose();
                        (known, Matrix3::identity() - known)
                    }
                    SensorOrientation::SixDof(_) => {
                        (Matrix3::identity(), Matrix3::identity() * 2.0)
                    }
                };
                covariance += arm_mm * arm_mm.transpose() + known * weight_mm2;
                LinearSensor { arm_mm, seen_mm2: seen * weight_mm2 }
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
        let least_held = svd.u.column(0).into_owned();
        let centroid_in_body = centroid.into();
        Self { sensors, centroid_in_body, inverse, eigenvalues_mm2, least_held, determination }
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

    /// The turn that the sensors determine least: its axis in the body, and the standard deviation
    /// of the turn in rad for errors of 1 rad about every axis of every sensor, and for errors of 1 mm
    /// along every one. `None` where a turn is not determined at all.
    pub fn least_determined_turn(&self) -> Option<(Unit<Vector3<f64>>, f64, f64)> {
        if self.free_motion().is_some() {
            return None;
        }
        let axis = Unit::try_new(self.least_held, 0.5)?;
        let held_mm2 = self.eigenvalues_mm2[0];
        let sum = |of: &dyn Fn(&LinearSensor) -> f64| self.sensors.iter().map(of).sum::<f64>();
        let by_tilt = sum(&|sensor| (sensor.seen_mm2 * *axis).norm_squared()).sqrt() / held_mm2;
        let by_shift = sum(&|sensor| sensor.arm_mm.cross(&axis).norm_squared()).sqrt() / held_mm2;
        Some((axis, by_tilt, by_shift))
    }

    /// From the centroid to a point.
    pub fn lever_mm(&self, point_in_body: &Point3<f64>) -> Vector3<f64> {
        point_in_body - self.centroid_in_body
    }

    /// The motion that the sensors' errors cause, all in body axes, one error a sensor.
    pub fn motion(&self, errors: &[PoseError]) -> SmallMotion {
        debug_assert_eq!(errors.len(), self.sensors.len(), "one error a sensor");
        let n = self.sensors.len().max(1) as f64;
        let mut shift_mm = Vector3::zeros();
        let mut moment = Vector3::zeros();
        for (sensor, error) in self.sensors.iter().zip(errors) {
            shift_mm += error.position_mm / n;
            moment +=
                sensor.arm_mm.cross(&error.position_mm) + sensor.seen_mm2 * error.rotation_rad;
        }
        SmallMotion { shift_mm, turn_rad: self.inverse * moment }
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
    Ok(linear.covariance(sensors).point_mm2(&linear.lever_mm(point_in_body)))
}

/// Without what round-off adds to one side of the diagonal.
fn symmetric(m: &Matrix3<f64>) -> Matrix3<f64> {
    (m + m.transpose()) * 0.5
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Sensor;
    use crate::frame_fit::{FrameFitter, Reading};
    use nalgebra::Unit;
    use trackwright_geometry::pose::{Pose, pose_from_parts};
    use trackwright_geometry::rotation::{exp_vector, log_quaternion};

    /// Step of central differences: truncation some h², round-off of some hundred mm over h.
    const STEP: f64 = 1e-4;
    const CLOSE: f64 = 1e-7;

    fn sensor(position: [f64; 3], orientation: SensorOrientation) -> Sensor {
        Sensor::new("", position, orientation)
    }

    fn five(position: [f64; 3], axis: [f64; 3]) -> Sensor {
        let axis = Unit::new_normalize(Vector3::from(axis));
        sensor(position, SensorOrientation::FiveDof(axis))
    }

    fn six(position: [f64; 3], turn: [f64; 3]) -> Sensor {
        let turn = exp_vector(&Vector3::from(turn));
        sensor(position, SensorOrientation::SixDof(turn))
    }

    fn body(sensors: Vec<Sensor>) -> RigidBody {
        RigidBody { name: "body".into(), tip_in_body: None, sensors }
    }

    /// Reads and refits with the body's frame as the tracker's.
    fn refitted(body: &RigidBody, weight_mm: f64, errors: &[PoseError]) -> Pose {
        let readings: Vec<_> = body
            .sensors
            .iter()
            .zip(errors)
            .map(|(s, e)| Reading {
                position_mm: s.position_in_body + e.position_mm,
                rotation: exp_vector(&e.rotation_rad) * s.orientation.any_rotation(),
            })
            .collect();
        FrameFitter::new(body, weight_mm).fit(&readings, &Pose::identity()).tracker_from_body
    }

    /// Every error of every sensor, one at a time, against central differences of the frame fit.
    fn assert_is_the_derivative(body: &RigidBody, weight_mm: f64) {
        let linear = LinearFit::new(body, weight_mm);
        let point = Point3::new(-20.0, 7.0, 90.0);
        for index in 0..body.sensors.len() {
            for component in 0..6 {
                let at = |size: f64| {
                    let mut errors = vec![PoseError::default(); body.sensors.len()];
                    if component < 3 {
                        errors[index].position_mm[component] = size;
                    } else {
                        errors[index].rotation_rad[component - 3] = size;
                    }
                    errors
                };
                let (plus, minus) =
                    (refitted(body, weight_mm, &at(STEP)), refitted(body, weight_mm, &at(-STEP)));
                let moved = (plus * point - minus * point) / (2.0 * STEP);
                let turned =
                    log_quaternion(&(plus.rotation * minus.rotation.inverse())) / (2.0 * STEP);
                let motion = linear.motion(&at(1.0));
                let found = motion.at(&linear.lever_mm(&point));
                let what = format!("sensor {index}, component {component}, w {weight_mm}");
                let scale = 1.0 + moved.norm();
                assert!((found - moved).norm() < CLOSE * scale, "{what}: {found} {moved}");
                assert!((motion.turn_rad - turned).norm() < CLOSE, "{what}");
            }
        }
    }

    #[test]
    fn the_linear_fit_is_the_derivative_of_the_frame_fit() {
        let fives = body(vec![
            five([0.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
            five([30.0, 0.0, 10.0], [1.0, 0.5, 0.2]),
            five([0.0, 25.0, 40.0], [-0.3, 1.0, 0.0]),
        ]);
        let mixed = body(vec![
            five([0.0, 0.0, 60.0], [0.0, 0.0, 1.0]),
            six([8.0, -3.0, 95.0], [0.4, -1.0, 2.0]),
        ]);
        for weight_mm in [0.0, 10.0, 100.0, 1000.0] {
            assert_is_the_derivative(&fives, weight_mm);
        }
        for weight_mm in [3.0, 100.0] {
            assert_is_the_derivative(&mixed, weight_mm);
            assert_is_the_derivative(&body(vec![six([1.0, 2.0, 3.0], [0.1, 0.2, 0.3])]), weight_mm);
        }
    }

    #[test]
    fn linear_fit_with_a_free_axis_is_the_fits_derivative() {
        let line = body(vec![
            five([0.0, 0.0, 60.0], [0.0, 0.0, 1.0]),
            five([0.0, 0.0, 95.0], [0.0, 0.0, -1.0]),
        ]);
        assert_is_the_derivative(&line, 100.0);
        assert_is_the_derivative(&line, 0.0);
        // Not determined at all: positions shift the only sensor, nothing turns it.
        let one = body(vec![five([0.0, 0.0, 60.0], [0.0, 0.6, 0.8])]);
        assert_is_the_derivative(&one, 0.0);
        assert_is_the_derivative(&one, 100.0);
    }

    #[test]
    fn the_covariance_is_the_sum_of_what_every_error_does() {
        let tool = body(vec![
            five([0.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
            six([30.0, 0.0, 10.0], [1.0, 0.5, 0.2]),
            five([0.0, 25.0, 40.0], [-0.3, 1.0, 0.0]),
        ]);
        let linear = LinearFit::new(&tool, 60.0);
        let lever_mm = linear.lever_mm(&Point3::new(3.0, -80.0, 11.0));
        // Each sensor with its own covariance L Lᵀ.
        let half = |k: usize| {
            let seed = k as f64;
            Matrix3::from_fn(|r, c| ((seed + 1.3 * r as f64 + 2.1 * c as f64) * 1.7).sin())
        };
        let covariances: Vec<_> = (0..3)
            .map(|k| SensorCovariance {
                position_mm2: half(k) * half(k).transpose(),
                rotation_rad2: half(k + 7) * half(k + 7).transpose() * 1e-4,
            })
            .collect();
        let (mut point, mut cross, mut turn) =
            (Matrix3::zeros(), Matrix3::zeros(), Matrix3::zeros());
        for k in 0..3 {
            for column in 0..6 {
                let mut errors = vec![PoseError::default(); 3];
                if column < 3 {
                    errors[k].position_mm = half(k).column(column).into();
                } else {
                    errors[k].rotation_rad = half(k + 7).column(column - 3) * 1e-2;
                }
                let motion = linear.motion(&errors);
                let moved = motion.at(&lever_mm);
                point += moved * moved.transpose();
                cross += moved * motion.turn_rad.transpose();
                turn += motion.turn_rad * motion.turn_rad.transpose();
            }
        }
        let found = linear.covariance(&covariances);
        let close = |a: &Matrix3<f64>, b: &Matrix3<f64>| (a - b).norm() < 1e-13 * (1.0 + b.norm());
        assert!(close(&found.point_mm2(&lever_mm), &point));
        assert!(close(&found.point_turn_mm_rad(&lever_mm), &cross));
        assert!(close(&found.turn_rad2, &turn));
    }

    #[test]
    fn an_undetermined_rotation_reports_its_eigenvalues() {
        let line = body(vec![
            five([0.0, 0.0, 60.0], [0.0, 0.0, 1.0]),
            five([0.0, 0.0, 90.0], [0.0, 0.0, 1.0]),
        ]);
        let sensors = [SensorCovariance::isotropic(0.5, 0.01); 2];
        let error = point_covariance_mm2(&line, 100.0, &sensors, &Point3::origin()).unwrap_err();
        // Positions 15 mm either side of the middle, two axes of weight 100.
        let expected = 2.0 * 15.0 * 15.0 + 2.0 * 100.0 * 100.0;
        assert!(error.smallest <= 1e-10 * error.largest, "{error}");
        assert!((error.largest - expected).abs() < 1e-9 * expected, "{error}");
    }

    #[test]
    fn a_free_turn_alone_is_projected_away() {
        let pose = pose_from_parts(
            Vector3::new(1.0, 2.0, 3.0),
            UnitQuaternion::from_euler_angles(0.3, 1.0, -2.0),
        );
        let free = FreeMotion { center: Point3::new(0.0, 0.0, 5.0), axis: Some(Vector3::z_axis()) }
            .transformed_by(&pose);
        let point = pose * Point3::new(10.0, 0.0, 40.0);
        let projection = free.determined_projection(&point);
        let tangent = pose.rotation * Vector3::y();
        assert!((projection * tangent).norm() < 1e-14);
        for kept in [Vector3::x(), Vector3::z()].map(|v| pose.rotation * v) {
            assert!((projection * kept - kept).norm() < 1e-14);
        }
        let on_axis = pose * Point3::new(0.0, 0.0, 40.0);
        assert_eq!(free.determined_projection(&on_axis), Matrix3::identity());
    }
}
