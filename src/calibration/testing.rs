//! Seeded noise for the tests of this room.

use crate::geometry::pose::{Pose, pose_from_parts};
use crate::geometry::rotation::exp_vector;
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

pub struct Noise(ChaCha8Rng);

impl Noise {
    pub fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// Three standard normal numbers.
    pub fn normal(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| StandardNormal.sample(&mut self.0))
    }

    /// Vectors of standard normal numbers of which neighbours have a correlation: a stationary AR(1).
    pub fn autocorrelated(&mut self, count: usize, correlation: f64) -> Vec<Vector3<f64>> {
        let fresh = (1.0 - correlation * correlation).sqrt();
        let mut state = self.normal();
        (0..count)
            .map(|_| {
                let here = state;
                state = state * correlation + self.normal() * fresh;
                here
            })
            .collect()
    }

    /// A pose with normal errors of these standard deviations a component, in the target's axes.
    pub fn around(&mut self, pose: &Pose, position_mm: f64, angle_rad: f64) -> Pose {
        let at = pose.translation.vector + self.normal() * position_mm;
        pose_from_parts(at, exp_vector(&(self.normal() * angle_rad)) * pose.rotation)
    }

    /// Any pose, within some `size_mm` of the origin.
    pub fn pose(&mut self, size_mm: f64) -> Pose {
        let at = self.normal() * size_mm;
        pose_from_parts(at, exp_vector(&(self.normal() * 1.5)))
    }
}
