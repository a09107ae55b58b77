//! Seeded models and poses, for tests and measurements.

use super::bernstein::coefficient_count;
use super::model::DistortionModel;
use super::samples::MapKind;
use nalgebra::{Point3, Quaternion, UnitQuaternion, Vector3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal, StandardUniform};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::directions::{DirectionSet, Weighting};
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_geometry::rotation::exp_vector;

/// Numbers that are the same each time.
pub struct Seeded(ChaCha8Rng);

impl Seeded {
    /// Numbers of a seed.
    pub fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// Uniform in `[0, 1)`.
    pub fn uniform(&mut self) -> f64 {
        StandardUniform.sample(&mut self.0)
    }

    /// Standard normal.
    pub fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// Three standard normal numbers.
    pub fn normal_vector(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.normal())
    }

    /// Vectors of standard normal numbers of which neighbours have a correlation: a stationary AR(1).
    pub fn autocorrelated(&mut self, count: usize, correlation: f64) -> Vec<Vector3<f64>> {
        let fresh = (1.0 - correlation * correlation).sqrt();
        let mut state = self.normal_vector();
        (0..count)
            .map(|_| {
                let here = state;
                state = state * correlation + self.normal_vector() * fresh;
                here
            })
            .collect()
    }

    /// A pose with normal errors of these standard deviations a component, in the target's axes.
    pub fn around(&mut self, pose: &Pose, position_mm: f64, angle_rad: f64) -> Pose {
        let at = pose.translation.vector + self.normal_vector() * position_mm;
        pose_from_parts(at, exp_vector(&(self.normal_vector() * angle_rad)) * pose.rotation)
    }

    /// Any pose, within some `size_mm` of the origin.
    pub fn pose_within(&mut self, size_mm: f64) -> Pose {
        let at = self.normal_vector() * size_mm;
        pose_from_parts(at, exp_vector(&(self.normal_vector() * 1.5)))
    }

    /// In the box grown by `margin` of its size on each side.
    pub fn position(&mut self, bounds: &Bounds, margin: f64) -> Point3<f64> {
        let size = bounds.size_mm();
        bounds.min_mm
            + Vector3::from_fn(|k, _| size[k] * (self.uniform() * (1.0 + 2.0 * margin) - margin))
    }

    /// Any rotation at a [`Self::position`].
    pub fn pose(&mut self, bounds: &Bounds, margin: f64) -> Pose {
        let q = Quaternion::from_vector(nalgebra::Vector4::from_fn(|_, _| self.normal()));
        let position = self.position(bounds, margin);
        pose_from_parts(position.coords, UnitQuaternion::new_normalize(q))
    }
}

/// A box like that of a measured room, mm.
pub fn room() -> Bounds {
    Bounds::from(([-230.0, -200.0, -530.0], [230.0, 250.0, -70.0]))
}

/// Errors of some `size_mm` and `size_rad` that change from coefficient to coefficient: rougher
/// than any room for its size.
pub fn random_model(
    order: usize,
    directions: DirectionSet,
    weighting: Weighting,
    [size_mm, size_rad]: [f64; 2],
    seed: u64,
) -> DistortionModel {
    let mut seeded = Seeded::new(seed);
    let coefficients = (0..directions.len() * coefficient_count(order))
        .map(|_| std::array::from_fn(|k| seeded.normal() * if k < 3 { size_mm } else { size_rad }))
        .collect();
    DistortionModel::new(order, directions, weighting, MapKind::Distortion, room(), coefficients)
        .unwrap()
}
