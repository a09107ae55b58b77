//! Inputs without structure that are the same every time.

use nalgebra::{Point3, Unit, UnitQuaternion, Vector3};
use trackwright_field::DistortionModel;
use trackwright_field::bernstein::coefficient_count;
use trackwright_field::model::ModelError;
use trackwright_field::samples::MapKind;
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::directions::{DirectionSet, Weighting};

/// A linear congruential sequence (Knuth's multiplier): no randomness is needed, only numbers
/// that no formula is fond of.
#[derive(Clone, Debug)]
pub struct Sequence(u64);

impl Sequence {
    pub fn new(seed: u64) -> Self {
        let mut sequence = Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
        sequence.unit();
        sequence
    }

    /// In `[0, 1)`.
    pub fn unit(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// In `[-1, 1)`.
    pub fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    pub fn vector(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.signed())
    }

    pub fn axis(&mut self) -> Unit<Vector3<f64>> {
        loop {
            let v = self.vector();
            if (0.1..1.0).contains(&v.norm()) {
                return Unit::new_normalize(v);
            }
        }
    }

    pub fn rotation(&mut self) -> UnitQuaternion<f64> {
        let axis = self.axis();
        UnitQuaternion::from_axis_angle(&axis, 3.0 * self.signed())
    }

    pub fn point_in(&mut self, bounds: &Bounds) -> Point3<f64> {
        let size = bounds.size_mm();
        bounds.min_mm + Vector3::from_fn(|k, _| size[k] * self.unit())
    }
}

/// A cube with one corner somewhere, or the volume of a planar generator.
pub fn cube(corner: [f64; 3], edge_mm: f64) -> Bounds {
    Bounds::from((corner, corner.map(|c| c + edge_mm)))
}

/// A model whose coefficients change sign without pattern, to 1 mm and 0.01 rad.
///
/// # Errors
/// As [`DistortionModel::new`].
pub fn model(
    order: usize,
    directions: DirectionSet,
    weighting: Weighting,
    bounds: Bounds,
    seed: u64,
) -> Result<DistortionModel, ModelError> {
    let mut sequence = Sequence::new(seed);
    let coefficients = (0..directions.len() * coefficient_count(order))
        .map(|_| std::array::from_fn(|k| sequence.signed() * if k < 3 { 1.0 } else { 0.01 }))
        .collect();
    DistortionModel::new(order, directions, weighting, MapKind::Distortion, bounds, coefficients)
}
