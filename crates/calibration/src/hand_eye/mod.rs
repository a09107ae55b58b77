//! Hand-eye calibration of two trackers: `A = Y B X`, for any number of sensors on one body.
//!
//! A reference tracker sees the body (`B`, `reference_from_body`) while an EM tracker reads the
//! sensors on it (`A`, `tracker_from_sensor`). Unknown are where the reference tracker is (`Y`,
//! `tracker_from_reference`) and how each sensor sits on the body (`X`, `body_from_sensor`).
//!
//! A closed form starts (`start.rs`: Shah 2013, over all sensors), robust nonlinear least squares
//! ends (`solve.rs`).
//!
//! Where every turn is about one axis `u` of the body, `R u` is the same in every pose, and moving a
//! sensor along `u` moves all its readings alike: `Y` takes it up. So the least singular value of the
//! stacked `R − R̄` decides whether a motion determines the answer, as in a pivot calibration.
//!
//! Standard errors are those of a sandwich over poses: a distorted field shifts all sensors of a pose
//! together, and residuals are not normal, so the curvature alone would promise too much. With `g` the
//! gradient of a pose's part of the cost and `H` the curvature of the whole, the covariance is
//! `H⁻¹ Ω H⁻¹` with `Ω` that of `Σ g` (Huber 1967; over clusters: Liang & Zeger 1986), with the usual
//! factor for few clusters, and `Ω` that of neighbours which are not independent
//! (`calibration/long_run.rs`). What the room does alike everywhere is in the answer itself, and no
//! residual shows it.

mod section;
mod solve;
mod start;
#[cfg(test)]
mod tests;

use super::long_run::{EffectiveSize, LongRun, long_run_along};
use super::robust::{Loss, largest_std_dev};
use super::still_pose::Spread;
use nalgebra::{DMatrix, DVector, Matrix3, Matrix6, SMatrix, UnitQuaternion, Vector3};
pub(super) use solve::whitened;
use solve::{Solved, scatter_matrix, scatter_vector, whitened_slopes};
use std::collections::{BTreeMap, BTreeSet};
use trackwright_field::samples::PoseError;
use trackwright_geometry::pose::{Pose, is_finite};
use trackwright_geometry::rotation::{log_quaternion, rotation_angle_rad};
use trackwright_geometry::svd3::svd3;

/// What both trackers read of one sensor at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairedReading {
    /// Readings of one pose share it, and errors with it.
    pub pose: usize,
    /// Below the number of sensors.
    pub sensor: usize,
    pub reference_from_body: Pose,
    pub tracker_from_sensor: Pose,
    /// Of both readings, as far as it is known beforehand: standard errors of a component.
    pub noise: ReadingNoise,
}

/// What a reading is known to scatter by, whatever the room does to it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReadingNoise {
    pub tracker: Spread,
    pub reference: Spread,
}

/// How the trackers are matched, and what the motion has to have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandEyeSettings {
    pub loss: Loss,
    /// Standard deviation beyond the known noise; `None` is estimated for each sensor.
    pub scale: Option<Spread>,
    pub min_poses: usize,
    /// RMS turn about the axis that the body turned about least, at least.
    pub min_turn_rad: f64,
}

impl HandEyeSettings {
    /// As for a pivot calibration.
    pub const MIN_POSES: usize = 10;
    pub const MIN_TURN_DEG: f64 = 2.0;
}

impl Default for HandEyeSettings {
    fn default() -> Self {
        Self {
            loss: Loss::default(),
            scale: None,
            min_poses: Self::MIN_POSES,
            min_turn_rad: Self::MIN_TURN_DEG.to_radians(),
        }
    }
}

/// Where the reference tracker and the sensors are.
#[derive(Clone, Debug, PartialEq)]
pub struct HandEye {
    pub tracker_from_reference: Pose,
    /// One a sensor.
    pub body_from_sensor: Vec<Pose>,
    /// Of small changes: for `tracker_from_reference`, then for each `body_from_sensor`, a rotation
    /// vector in the target's axes (radians), by which the rotation is turned, and a translation (mm).
    pub covariance: DMatrix<f64>,
    pub poses: usize,
    /// Their effective number, neighbours not being independent.
    pub effective_size: EffectiveSize,
    /// Standard deviations beyond the known noise that residuals were weighted with, by sensor.
    pub scales: Vec<Spread>,
    pub motion: Motion,
}

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

impl Motion {
    fn of(readings: &[PairedReading]) -> Self {
        // Every pose once, however many sensors were read in it.
        let poses: BTreeMap<usize, UnitQuaternion<f64>> =
            readings.iter().map(|r| (r.pose, r.reference_from_body.rotation)).collect();
        let rotations: Vec<Matrix3<f64>> =
            poses.values().map(|r| r.to_rotation_matrix().into_inner()).collect();
        let count = rotations.len().max(1) as f64;
        let mean = rotations.iter().sum::<Matrix3<f64>>() / count;
        let squares: Matrix3<f64> =
            rotations.iter().map(|r| (r - mean).transpose() * (r - mean)).sum();
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
        Self {
            largest_rad,
            least_turn_rad: svd.singular_values[2].max(0.0).sqrt(),
            second_turn_rad: svd.singular_values[1].max(0.0).sqrt(),
            axis_in_body: clean(axis_in_body),
            axis_in_reference: clean(in_reference),
        }
    }

    fn check(&self, min_turn_rad: f64) -> Result<(), HandEyeError> {
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

#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum HandEyeError {
    #[error("too few poses: {found}, expected at least {needed}")]
    TooFewPoses { found: usize, needed: usize },
    #[error("sensor {sensor} (from 0) was read in {found} poses, expected at least {needed}")]
    SensorTooFew { sensor: usize, found: usize, needed: usize },
    #[error(
        "the body hardly turned: no pose differs from the first by more than {largest_deg:.2}°, so neither the sensors' \
         place on the body nor the reference tracker's place is determined; turn the body by tens of degrees \
         between poses, about two axes at least"
    )]
    NoRotation { largest_deg: f64 },
    #[error(
        "the body turned about one axis only, ({:.2}, {:.2}, {:.2}) in its own frame, ({:.2}, {:.2}, {:.2}) in \
         the reference tracker's: {found_deg:.2}° RMS across it, expected at least {needed_deg:.1}°; where the \
         sensors are along that axis is not determined; tilt the body about an axis across it too",
        .axis_in_body.x, .axis_in_body.y, .axis_in_body.z,
        .axis_in_reference.x, .axis_in_reference.y, .axis_in_reference.z
    )]
    OneAxis {
        axis_in_body: Vector3<f64>,
        axis_in_reference: Vector3<f64>,
        found_deg: f64,
        needed_deg: f64,
    },
    #[error(
        "the readings contain numbers that are none, or contradict each other: no answer was found"
    )]
    NoAnswer,
}

/// Solves `A = Y B X` for one `Y` and one `X` a sensor.
///
/// Minimised is `Σ ρ(√(|p|²/σp² + |r|²/σr²))` over readings, with `p` the position residual, `r` the
/// rotation vector of the residual rotation, and `σ²` the known noise of both trackers (the
/// reference's rotation over the sensor's lever) plus the scale squared. A scale that is not stated
/// is taken from the median of the residuals, anew until it stays.
///
/// # Errors
/// Too few poses, a motion that does not determine the answer, readings that are not finite.
pub fn hand_eye(
    readings: &[PairedReading],
    sensors: usize,
    settings: &HandEyeSettings,
) -> Result<HandEye, HandEyeError> {
    let needed = settings.min_poses.max(3);
    let poses_of = |sensor: Option<usize>| {
        let of_sensor = readings.iter().filter(|r| sensor.is_none_or(|s| r.sensor == s));
        of_sensor.map(|r| r.pose).collect::<BTreeSet<_>>().len()
    };
    let found = poses_of(None);
    if found < needed {
        return Err(HandEyeError::TooFewPoses { found, needed });
    }
    for sensor in 0..sensors {
        let found = poses_of(Some(sensor));
        if found < 3 {
            return Err(HandEyeError::SensorTooFew { sensor, found, needed: 3 });
        }
    }
    if readings.iter().any(|r| r.sensor >= sensors || !r.is_finite()) {
        return Err(HandEyeError::NoAnswer);
    }
    let motion = Motion::of(readings);
    motion.check(settings.min_turn_rad)?;
    let start = start::start(readings, sensors).ok_or(HandEyeError::NoAnswer)?;
    let solved = solve::solve(readings, start, settings).ok_or(HandEyeError::NoAnswer)?;
    let LongRun { covariance, effective_size } =
        covariance(readings, &solved, settings.loss).ok_or(HandEyeError::NoAnswer)?;
    Ok(HandEye {
        tracker_from_reference: solved.frames.y,
        body_from_sensor: solved.frames.x,
        covariance,
        poses: found,
        effective_size,
        scales: solved.scales,
        motion,
    })
}

/// What was read less what should have been, in the frame of both.
fn pose_error(read: &Pose, expected: &Pose) -> PoseError {
    PoseError {
        position_mm: read.translation.vector - expected.translation.vector,
        rotation_rad: log_quaternion(&(read.rotation * expected.rotation.inverse())),
    }
}

impl PairedReading {
    fn is_finite(&self) -> bool {
        is_finite(&self.reference_from_body) && is_finite(&self.tracker_from_sensor)
    }
}

impl HandEye {
    /// Where the EM tracker should have read a sensor.
    pub fn expected(&self, reading: &PairedReading) -> Pose {
        self.tracker_from_reference
            * reading.reference_from_body
            * self.body_from_sensor[reading.sensor]
    }

    /// What a reading is off by, in the EM tracker's frame: mm, and a rotation vector in radians.
    pub fn pose_error(&self, reading: &PairedReading) -> PoseError {
        pose_error(&reading.tracker_from_sensor, &self.expected(reading))
    }

    /// Distance and angle between a reading and where it should be, mm and radians.
    pub fn error(&self, reading: &PairedReading) -> (f64, f64) {
        let error = self.pose_error(reading);
        (error.position_mm.norm(), error.rotation_rad.norm())
    }

    /// Standard errors of `tracker_from_reference` along the worst direction: of its rotation, and of
    /// where it puts a point of the reference frame (its origin is a metre from anything measured).
    pub fn reference_error(&self, at_in_reference_mm: &Vector3<f64>) -> Spread {
        let lever = (self.tracker_from_reference.rotation * at_in_reference_mm).cross_matrix();
        let mut from_change = DMatrix::zeros(3, self.covariance.nrows());
        from_change.fixed_view_mut::<3, 3>(0, 0).copy_from(&-lever);
        from_change.fixed_view_mut::<3, 3>(0, 3).copy_from(&Matrix3::identity());
        let covariance = &from_change * &self.covariance * from_change.transpose();
        Spread {
            position_mm: largest_std_dev(&covariance.fixed_view::<3, 3>(0, 0).into_owned()),
            angle_rad: largest_std_dev(&self.block(0)),
        }
    }

    /// Covariance of `tracker_from_reference`: the block of [`Self::covariance`] for it alone.
    pub fn reference_covariance(&self) -> Matrix6<f64> {
        self.covariance.fixed_view::<6, 6>(0, 0).into_owned()
    }

    /// Covariance of a `body_from_sensor`, likewise.
    pub fn sensor_covariance(&self, sensor: usize) -> Matrix6<f64> {
        let first = 6 + 6 * sensor;
        let block = self.covariance.fixed_view::<6, 6>(first, first);
        block.into_owned()
    }

    /// Standard errors of a `body_from_sensor` along the worst direction.
    pub fn sensor_error(&self, sensor: usize) -> Spread {
        let first = 6 + 6 * sensor;
        Spread {
            position_mm: largest_std_dev(&self.block(first + 3)),
            angle_rad: largest_std_dev(&self.block(first)),
        }
    }

    fn block(&self, first: usize) -> Matrix3<f64> {
        self.covariance.fixed_view::<3, 3>(first, first).into_owned()
    }
}

/// Of small changes of all unknowns; `None` where the curvature is not positive.
fn covariance(readings: &[PairedReading], solved: &Solved, loss: Loss) -> Option<LongRun> {
    let unknowns = solved.frames.unknowns();
    let mut curvature = DMatrix::zeros(unknowns, unknowns);
    let mut of_weights = DMatrix::zeros(unknowns, unknowns);
    let mut gradients: BTreeMap<usize, DVector<f64>> = BTreeMap::new();
    for (reading, sigma) in readings.iter().zip(&solved.sigmas) {
        let residual = solved.frames.residual(reading);
        let slopes = whitened_slopes(solved.frames.slopes(reading, &residual), sigma);
        let r = whitened(&residual, sigma);
        let s = r.norm();
        let weight = loss.weight(s);
        // ρ bends along the residual by ρ'' and across it by ρ' / s.
        let along = if s > 0.0 { (loss.curvature(s) - weight) / (s * s) } else { 0.0 };
        let bend = SMatrix::<f64, 6, 6>::identity() * weight + r * r.transpose() * along;
        let full = slopes.transpose() * bend * slopes;
        scatter_matrix(&mut curvature, reading.sensor, &full);
        let straight = slopes.transpose() * slopes * weight;
        scatter_matrix(&mut of_weights, reading.sensor, &straight);
        let gradient = gradients.entry(reading.pose).or_insert_with(|| DVector::zeros(unknowns));
        scatter_vector(gradient, reading.sensor, &(slopes.transpose() * r * weight));
    }
    // By number of the pose, which is the order of recording.
    let scores = DMatrix::from_columns(&gradients.into_values().collect::<Vec<_>>());
    let found = long_run_along(&scores, &(&scores * scores.transpose()), &of_weights);
    // A loss that is not convex can bend the wrong way where many readings are far.
    let inverse = inverse(&curvature).or_else(|| inverse(&of_weights))?;
    let (clusters, values) = (scores.ncols() as f64, 6.0 * readings.len() as f64);
    let factor = clusters / (clusters - 1.0) * (values - 1.0) / (values - unknowns as f64).max(1.0);
    Some(LongRun { covariance: &inverse * found.covariance * &inverse * factor, ..found })
}

/// Of a positive definite matrix, its rows and columns divided by the root of the diagonal first.
fn inverse(matrix: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let lengths = matrix.diagonal().map(f64::sqrt);
    let divided = |m: &DMatrix<f64>| {
        DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)] / (lengths[i] * lengths[j]))
    };
    Some(divided(&divided(matrix).cholesky()?.inverse()))
}
