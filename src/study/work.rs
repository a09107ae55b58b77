//! How much was computed, counted where it is done.

use serde::Serialize;
use std::ops::{Add, AddAssign, Mul};

/// Counts of what a computation did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Work {
    /// Evaluations of the distortion model for a study's trials.
    pub study_evaluations: u64,
    /// Evaluations for one pose in the scene.
    pub pose_evaluations: u64,
    /// Evaluations for a slice: its sample points.
    pub slice_evaluations: u64,
    /// Frames fitted to readings.
    pub frame_fits: u64,
}

impl Add for Work {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            study_evaluations: self.study_evaluations + other.study_evaluations,
            pose_evaluations: self.pose_evaluations + other.pose_evaluations,
            slice_evaluations: self.slice_evaluations + other.slice_evaluations,
            frame_fits: self.frame_fits + other.frame_fits,
        }
    }
}

impl AddAssign for Work {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Mul<u64> for Work {
    type Output = Self;

    fn mul(self, times: u64) -> Self {
        Self {
            study_evaluations: self.study_evaluations * times,
            pose_evaluations: self.pose_evaluations * times,
            slice_evaluations: self.slice_evaluations * times,
            frame_fits: self.frame_fits * times,
        }
    }
}
