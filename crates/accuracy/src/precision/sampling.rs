//! Poses to measure at: the same for the same seed, on every machine.

use nalgebra::{Point3, Unit, Vector3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardUniform, UnitSphere};
use trackwright_geometry::bounds::Bounds;

/// Positions spread evenly over a box, with axes spread evenly over the sphere.
pub fn poses(bounds: &Bounds, count: usize, seed: u64) -> Vec<(Point3<f64>, Unit<Vector3<f64>>)> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..count)
        .map(|_| {
            let position = Vector3::from_fn(|k, _| {
                let part: f64 = StandardUniform.sample(&mut rng);
                bounds.min_mm[k] + part * bounds.size_mm()[k]
            });
            let axis: [f64; 3] = UnitSphere.sample(&mut rng);
            (position.into(), Unit::new_normalize(Vector3::from(axis)))
        })
        .collect()
}
