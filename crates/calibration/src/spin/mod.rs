//! Spin calibration: which way a tool's shaft points, from poses in which the tool was turned about it.
//!
//! The shaft's direction `u` in the tool's frame stays one direction in the tracker's: minimised is
//! `Σ |R_i u − R_j u|²` over all pairs of poses, which is `Σ |(R_iᵀ R_j − I) u|²`. The answer is the
//! right singular vector of the mean rotation with the largest singular value, and the left one is
//! the direction in the tracker's frame. SlicerIGT (IGSIO's spin calibration) sums over successive
//! poses only, which between samples of a 40th of a second leaves little but noise.
//!
//! The tip's frame, the direction of the shaft and the refusals are SlicerIGT's.

mod section;
#[cfg(test)]
mod tests;

use super::long_run::{EffectiveSize, long_run};
use super::orientation_range::orientation_range_rad;
use super::robust::largest_std_dev;
use nalgebra::{DMatrix, DVector, Matrix3, Point3, Unit, Vector3};
use trackwright_geometry::pose::{Pose, pose_from_parts, quaternion_from_matrix};
use trackwright_geometry::svd3::svd3;

/// What a recording has to have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpinLimits {
    pub min_poses: usize,
    /// Largest angle between any two poses, at least.
    pub min_range_rad: f64,
    /// RMS turn about the shaft, at least.
    pub min_turn_rad: f64,
    /// RMS angle between the shaft and its mean direction in the tracker's frame, at most.
    pub max_rms_rad: f64,
}

impl SpinLimits {
    /// Poses and range as SlicerIGT requires them, of a spin as of a pivot.
    pub const MIN_POSES: usize = 10;
    pub const MIN_RANGE_DEG: f64 = 15.0;
    /// As of a pivot: one pose that is turned among many that are not is no spin.
    pub const MIN_TURN_DEG: f64 = 2.0;
    /// SlicerIGT leaves out what is off by more than 0.05 of the shaft's length, which is 2.9°.
    pub const MAX_RMS_DEG: f64 = 3.0;
}

impl Default for SpinLimits {
    fn default() -> Self {
        Self {
            min_poses: Self::MIN_POSES,
            min_range_rad: Self::MIN_RANGE_DEG.to_radians(),
            min_turn_rad: Self::MIN_TURN_DEG.to_radians(),
            max_rms_rad: Self::MAX_RMS_DEG.to_radians(),
        }
    }
}

/// Which way the shaft points, and what the poses leave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spin {
    pub poses: usize,
    /// Tool frame.
    pub shaft_in_tool: Unit<Vector3<f64>>,
    pub shaft_in_tracker: Unit<Vector3<f64>>,
    pub direction: ShaftDirection,
    pub rms_rad: f64,
    pub worst_rad: f64,
    /// Of `shaft_in_tool`, tool frame, of rank two.
    pub covariance: Matrix3<f64>,
    /// Their effective number, neighbours not being independent.
    pub effective_size: EffectiveSize,
    /// Standard error along the direction in which the shaft is known least.
    pub std_error_rad: f64,
    pub turn_rad: f64,
    pub orientation_range_rad: f64,
}

/// Which of the two directions along a shaft it is: only a tip determines that.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShaftDirection {
    TowardsTip,
    /// No tip is known.
    WithoutTip,
    /// The tip lies so near beside the tool's origin that it could be either.
    Open,
}

#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SpinError {
    #[error("too few poses: {found}, expected at least {needed}")]
    TooFewPoses { found: usize, needed: usize },
    #[error(
        "too little variation: no two poses differ by more than {found_deg:.1}°, expected at least {needed_deg:.1}°; \
         turn the tool about its shaft, best by whole turns (a 5-DOF sensor along the shaft never sees that)"
    )]
    TooSmallRange { found_deg: f64, needed_deg: f64 },
    #[error(
        "too little variation: the tool was turned by {found_deg:.2}° RMS, expected at least {needed_deg:.1}°; turn it \
         about its shaft all the time that is recorded, best by whole turns"
    )]
    TooLittleTurn { found_deg: f64, needed_deg: f64 },
    #[error(
        "too large an error: the shaft's direction is {rms_deg:.2}° RMS from where it points on average, expected at \
         most {allowed_deg:.2}°; turn the tool about its shaft alone, and hold the shaft still meanwhile"
    )]
    TooLargeError { rms_deg: f64, allowed_deg: f64 },
}

/// The shaft of a tool from poses (`tracker_from_tool`) in which it was turned about it.
pub fn spin(poses: &[Pose], limits: &SpinLimits) -> Result<Spin, SpinError> {
    // Two poses have an axis, whatever was turned: nothing is left over to judge it by.
    let needed = limits.min_poses.max(3);
    if poses.len() < needed {
        return Err(SpinError::TooFewPoses { found: poses.len(), needed });
    }
    let orientation_range_rad = orientation_range_rad(poses);
    if orientation_range_rad < limits.min_range_rad {
        return Err(SpinError::TooSmallRange {
            found_deg: orientation_range_rad.to_degrees(),
            needed_deg: limits.min_range_rad.to_degrees(),
        });
    }
    let count = poses.len() as f64;
    let sum: Matrix3<f64> =
        poses.iter().map(|pose| pose.rotation.to_rotation_matrix().into_inner()).sum();
    // `Σ (R − R̄)ᵀ (R − R̄) / n = I − R̄ᵀ R̄`, whose least eigenvalue is of the largest value here.
    let mean = svd3(&(sum / count));
    let [largest, second, third] = mean.singular_values.into();
    // A turn about the shaft moves both directions across it alike.
    let turn_rad = (1.0 - second * second).max(0.0).sqrt();
    if turn_rad < limits.min_turn_rad.max(f64::EPSILON.sqrt()) {
        return Err(SpinError::TooLittleTurn {
            found_deg: turn_rad.to_degrees(),
            needed_deg: limits.min_turn_rad.to_degrees(),
        });
    }
    let sign = f64::copysign(1.0, mean.v.column(0)[mean.v.column(0).iamax()]);
    let [shaft, there] = [mean.v, mean.u].map(|m| Unit::new_normalize(m.column(0) * sign));

    let (mut squares, mut worst_rad) = (0.0, 0.0_f64);
    for pose in poses {
        let seen = pose.rotation * shaft;
        let off_rad = there.cross(&seen).norm().atan2(there.dot(&seen));
        squares += off_rad * off_rad;
        worst_rad = worst_rad.max(off_rad);
    }
    let rms_rad = (squares / count).sqrt();
    // Also where something is not finite.
    if rms_rad.is_nan() || rms_rad > limits.max_rms_rad {
        return Err(SpinError::TooLargeError {
            rms_deg: rms_rad.to_degrees(),
            allowed_deg: limits.max_rms_rad.to_degrees(),
        });
    }
    // Two components a pose, less those of the two directions.
    let variance = squares / (2.0 * count - 4.0) / count;
    let across: Vec<(usize, f64)> =
        [(1, second), (2, third)].map(|(k, value)| (k, largest * largest - value * value)).into();
    // What a pose's residual moves the shaft by, along both directions across it.
    let influences = DMatrix::from_fn(2, poses.len(), |row, pose| {
        let (k, information) = across[row];
        let rotation = &poses[pose].rotation;
        let residual = rotation * shaft.into_inner() - there.into_inner();
        let along =
            rotation * mean.v.column(k).into_owned() - mean.u.column(k) * mean.singular_values[k];
        along.dot(&residual) / (count * information)
    });
    let independent = DVector::from_fn(2, |row, _| variance / across[row].1);
    let found = long_run(&influences, &DMatrix::from_diagonal(&independent));
    let axes = mean.v.fixed_columns::<2>(1);
    let covariance = axes * found.covariance.fixed_view::<2, 2>(0, 0) * axes.transpose();
    Ok(Spin {
        poses: poses.len(),
        shaft_in_tool: shaft,
        shaft_in_tracker: there,
        direction: ShaftDirection::WithoutTip,
        rms_rad,
        worst_rad,
        covariance,
        effective_size: found.effective_size,
        std_error_rad: largest_std_dev(&covariance),
        turn_rad,
        orientation_range_rad,
    })
}

/// How many standard errors the tip has to be along the shaft to distinguish its directions.
const SURE: f64 = 3.0;

impl Spin {
    /// Half the 95 % interval along the direction in which the shaft is known least; `None` where the
    /// recording is too short.
    pub fn half_width_rad(&self) -> Option<f64> {
        Some(self.effective_size.student_975()? * self.std_error_rad)
    }

    /// With the shaft pointing from the tool's origin towards its tip, which is known with a standard
    /// error.
    pub fn towards(mut self, tip_in_tool: &Point3<f64>, tip_std_error_mm: f64) -> Self {
        let along_mm = self.shaft_in_tool.dot(&tip_in_tool.coords);
        let by_shaft_mm = tip_in_tool.coords.norm() * self.std_error_rad;
        if along_mm.abs() <= SURE * tip_std_error_mm.hypot(by_shaft_mm) {
            return Self { direction: ShaftDirection::Open, ..self };
        }
        if along_mm < 0.0 {
            self.shaft_in_tool = -self.shaft_in_tool;
            self.shaft_in_tracker = -self.shaft_in_tracker;
        }
        Self { direction: ShaftDirection::TowardsTip, ..self }
    }
}

/// Shafts nearer to the tool's x take its y instead: SlicerIGT's, in degrees.
const NEAR_X_DEG: f64 = 20.0;

/// `tool_from_tip`, as SlicerIGT has it: the origin in the tip, z along the shaft towards the tip and
/// out of it, x the tool's own as nearly as can be (its y where the shaft is nearly along x).
pub fn tool_from_tip(tip_in_tool: &Point3<f64>, towards_tip: &Unit<Vector3<f64>>) -> Pose {
    let is_near_x = towards_tip.x.abs() > NEAR_X_DEG.to_radians().cos();
    let start = if is_near_x { Vector3::y() } else { Vector3::x() };
    let z = towards_tip.into_inner();
    let x = (start - z * z.dot(&start)).normalize();
    let turn = quaternion_from_matrix(&Matrix3::from_columns(&[x, z.cross(&x), z]));
    pose_from_parts(tip_in_tool.coords, turn)
}
