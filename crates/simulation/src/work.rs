//! How much was computed, counted where it is done.

use serde::Serialize;
use std::ops::{Add, AddAssign};

/// Counts of what a computation did, and of what it did not have to do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Work {
    /// Evaluations of the distortion model for a study's trials.
    pub study_evaluations: u64,
    /// Evaluations for one pose in the scene.
    pub pose_evaluations: u64,
    /// Evaluations for a slice: its sample points, and for the tip error each sensor at each.
    pub slice_evaluations: u64,
    /// Evaluations for arrows on a lattice.
    pub arrow_evaluations: u64,
    /// Evaluations for the places where a sensor might sit.
    pub placement_evaluations: u64,
    /// Evaluations for the region where a requirement is met.
    pub region_evaluations: u64,
    /// Frames fitted to readings.
    pub frame_fits: u64,
    /// Those of the evaluations above that were the CRF's.
    pub crf_evaluations: u64,
    /// Times that the CRF was tracked.
    pub crf_trackings: u64,
    /// Trials that used a CRF tracked before.
    pub crf_reuses: u64,
    /// Readings of sensors that stay where they are, used again for another place of the one that
    /// does not.
    pub reading_reuses: u64,
    /// Models blended for one orientation.
    pub coefficient_blends: u64,
    /// Those of the evaluations above that used a model blended before.
    pub blended_evaluations: u64,
}

impl Add for Work {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            study_evaluations: self.study_evaluations + other.study_evaluations,
            pose_evaluations: self.pose_evaluations + other.pose_evaluations,
            slice_evaluations: self.slice_evaluations + other.slice_evaluations,
            arrow_evaluations: self.arrow_evaluations + other.arrow_evaluations,
            placement_evaluations: self.placement_evaluations + other.placement_evaluations,
            region_evaluations: self.region_evaluations + other.region_evaluations,
            frame_fits: self.frame_fits + other.frame_fits,
            crf_evaluations: self.crf_evaluations + other.crf_evaluations,
            crf_trackings: self.crf_trackings + other.crf_trackings,
            crf_reuses: self.crf_reuses + other.crf_reuses,
            reading_reuses: self.reading_reuses + other.reading_reuses,
            coefficient_blends: self.coefficient_blends + other.coefficient_blends,
            blended_evaluations: self.blended_evaluations + other.blended_evaluations,
        }
    }
}

impl Extend<Work> for Work {
    fn extend<I: IntoIterator<Item = Work>>(&mut self, more: I) {
        more.into_iter().for_each(|work| *self += work);
    }
}

impl AddAssign for Work {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}
