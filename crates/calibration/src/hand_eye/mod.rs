//! Hand-eye calibration of two trackers: `A = Y B X`, for any number of sensors on one body.
//!
//! A reference tracker sees the body (`B`, `reference_from_body`) while an EM tracker reads the
//! sensors on it (`A`, `tracker_from_sensor`). Unknown are where the reference tracker is (`Y`,
//! `tracker_from_reference`) and how each sensor sits on the body (`X`, `body_from_sensor`).
//!
//! A closed form starts (`start.rs`: Shah 2013, over all sensors), robust nonlinear least squares
//! ends (`solve.rs`), and `covariance.rs` says how far the answer is to be believed. Motions that do
//! not determine the answer are refused (`motion.rs`).

mod covariance;
mod motion;
mod solve;
mod start;
#[cfg(test)]
mod tests;

pub use motion::Motion;

use super::long_run::{EffectiveSize, LongRun};
use super::robust::Loss;
use super::still_pose::Spread;
use nalgebra::{DMatrix, Matrix3, Matrix6, Vector3};
use std::collections::BTreeSet;
use trackwright_geometry::pose::Pose;
use trackwright_geometry::rotation::log_quaternion;

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
    /// Standard deviation of what the known noise does not say, for all sensors; `None` is estimated
    /// for each from the residuals.
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
    /// Independent poses that they are worth, neighbours not being independent.
    pub effective_size: EffectiveSize,
    /// What each sensor's readings scatter by beside the known noise: the scale that residuals were
    /// weighed with.
    pub scales: Vec<Spread>,
    pub motion: Motion,
}

/// Why paired readings say nothing about where the trackers are.
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
         sensors are along that axis nobody can tell; tilt the body about an axis across it too",
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
/// is what the median of the residuals says, taken anew until it stays.
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
    let motion = motion::of(readings);
    motion.check(settings.min_turn_rad)?;
    let start = start::start(readings, sensors).ok_or(HandEyeError::NoAnswer)?;
    let solved = solve::solve(readings, start, settings).ok_or(HandEyeError::NoAnswer)?;
    let LongRun { covariance, effective_size } =
        covariance::covariance(readings, &solved, settings.loss).ok_or(HandEyeError::NoAnswer)?;
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

impl PairedReading {
    fn is_finite(&self) -> bool {
        [&self.reference_from_body, &self.tracker_from_sensor].iter().all(|pose| {
            let at = pose.translation.vector;
            let turn = pose.rotation.coords;
            at.iter().chain(turn.iter()).all(|v| v.is_finite())
        })
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
    pub fn error_vectors(&self, reading: &PairedReading) -> [Vector3<f64>; 2] {
        let expected = self.expected(reading);
        let off = reading.tracker_from_sensor.translation.vector - expected.translation.vector;
        let turn = reading.tracker_from_sensor.rotation * expected.rotation.inverse();
        [off, log_quaternion(&turn)]
    }

    /// Distance and angle between a reading and where it should be, mm and radians.
    pub fn error(&self, reading: &PairedReading) -> (f64, f64) {
        let [off, turn] = self.error_vectors(reading);
        (off.norm(), turn.norm())
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
            position_mm: worst(&covariance.fixed_view::<3, 3>(0, 0).into_owned()),
            angle_rad: worst(&self.block(0)),
        }
    }

    /// Covariance of `tracker_from_reference`: what [`Self::covariance`] says of it alone.
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
        Spread { position_mm: worst(&self.block(first + 3)), angle_rad: worst(&self.block(first)) }
    }

    fn block(&self, first: usize) -> Matrix3<f64> {
        self.covariance.fixed_view::<3, 3>(first, first).into_owned()
    }
}

/// Standard deviation along the direction in which it is largest.
fn worst(covariance: &Matrix3<f64>) -> f64 {
    covariance.symmetric_eigenvalues().max().max(0.0).sqrt()
}
