//! Equation (8) in single precision throughout: what halving the bytes would cost in error.

use nalgebra::{Matrix3, Point3, Unit, Vector3};
use trackwright_field::DistortionModel;
use trackwright_field::bernstein::MAX_ORDER;
use trackwright_geometry::directions::Weighting;

/// As in `geometry::directions`, for numbers of 24 bits.
const IN_TRIANGLE: f32 = 1e-6;

/// A position and an axis in single precision.
pub type SinglePose = (Point3<f32>, Vector3<f32>);

/// A model of which every number is an `f32`.
pub struct SingleModel {
    order: usize,
    weighting: Weighting,
    min_mm: Vector3<f32>,
    size_mm: Vector3<f32>,
    directions: Vec<Vector3<f32>>,
    triangles: Vec<[usize; 3]>,
    inverses: Vec<Matrix3<f32>>,
    /// Six values and two to fill up a vector.
    coefficients: Vec<[f32; 8]>,
}

/// A pose in single precision.
pub fn single_pose(position_mm: &Point3<f64>, axis: &Unit<Vector3<f64>>) -> SinglePose {
    (position_mm.cast(), axis.into_inner().cast())
}

impl SingleModel {
    /// A model in single precision.
    pub fn new(model: &DistortionModel) -> Self {
        let set = model.directions();
        let directions: Vec<Vector3<f32>> =
            set.directions().iter().map(|d| d.into_inner().cast()).collect();
        let inverses = set
            .triangles()
            .iter()
            .filter_map(|t| {
                Matrix3::from_columns(&t.map(|i| set.directions()[i].into_inner())).try_inverse()
            })
            .map(|m| m.cast())
            .collect();
        Self {
            order: model.order(),
            weighting: model.weighting(),
            min_mm: model.bounds().min_mm.coords.cast(),
            size_mm: model.bounds().size_mm().cast(),
            directions,
            triangles: set.triangles().to_vec(),
            inverses,
            coefficients: model
                .coefficients()
                .iter()
                .map(|c| std::array::from_fn(|k| c.get(k).map_or(0.0, |&v| v as f32)))
                .collect(),
        }
    }

    /// The six values at a pose in the box.
    pub fn evaluate(&self, (position_mm, axis): &SinglePose) -> [f32; 8] {
        let n = self.order + 1;
        let unit = (position_mm.coords - self.min_mm)
            .zip_map(&self.size_mm, |d, s| if s > 0.0 { d / s } else { 0.0 })
            .map(|u| u.clamp(0.0, 1.0));
        let [bx, by, bz] = [0, 1, 2].map(|k| basis(self.order, unit[k]));
        let (directions, weights) = self.weights(axis);
        let mut total = [0.0_f32; 8];
        for (direction, weight) in directions.into_iter().zip(weights) {
            if weight == 0.0 {
                continue;
            }
            let own = &self.coefficients[direction * n * n * n..][..n * n * n];
            let mut rows = own.chunks_exact(n);
            for &x in &bx[..n] {
                let mut along_y = [0.0_f32; 8];
                for (&y, row) in by[..n].iter().zip(&mut rows) {
                    let mut along_z = [0.0_f32; 8];
                    for (&z, coefficient) in bz[..n].iter().zip(row) {
                        for (sum, c) in along_z.iter_mut().zip(coefficient) {
                            *sum += z * c;
                        }
                    }
                    for (sum, c) in along_y.iter_mut().zip(along_z) {
                        *sum += y * c;
                    }
                }
                for (sum, c) in total.iter_mut().zip(along_y) {
                    *sum += weight * x * c;
                }
            }
        }
        total
    }

    fn weights(&self, axis: &Vector3<f32>) -> ([usize; 3], [f32; 3]) {
        if self.directions.len() == 1 {
            return ([0; 3], [1.0, 0.0, 0.0]);
        }
        let mut best = (0, f32::NEG_INFINITY, Vector3::zeros());
        for (i, inverse) in self.inverses.iter().enumerate() {
            let l = inverse * axis;
            if l.min() > best.1 {
                best = (i, l.min(), l);
                if l.min() >= -IN_TRIANGLE {
                    break;
                }
            }
        }
        let corners = self.triangles[best.0];
        let parts = match self.weighting {
            Weighting::Gnomonic => best.2.map(|l| l.max(0.0)).into(),
            Weighting::Area => {
                let [a, b, c] = corners.map(|i| &self.directions[i]);
                [half_area(axis, b, c), half_area(a, axis, c), half_area(a, b, axis)]
            }
        };
        let sum: f32 = parts.iter().sum();
        (corners, parts.map(|p| p / sum))
    }
}

fn basis(order: usize, x: f32) -> [f32; MAX_ORDER + 1] {
    let mut b = [0.0; MAX_ORDER + 1];
    b[0] = 1.0;
    for n in 1..=order {
        let mut carried = 0.0;
        for value in &mut b[..n] {
            let old = *value;
            *value = carried + (1.0 - x) * old;
            carried = x * old;
        }
        b[n] = carried;
    }
    b
}

fn half_area(a: &Vector3<f32>, b: &Vector3<f32>, c: &Vector3<f32>) -> f32 {
    let triple = a.dot(&b.cross(c)).abs();
    triple.atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::precision::field::exact_position_mm;
    use crate::precision::{sampling::poses, testing};
    use crate::references::distance;
    use trackwright_geometry::directions::DirectionSet;

    #[test]
    fn single_precision_is_right_to_its_round_off() {
        for set in DirectionSet::ALL {
            let model = testing::model(4, set, Weighting::Area);
            let single = SingleModel::new(&model);
            let worst = poses(model.bounds(), 200, 5)
                .iter()
                .map(|(position, axis)| {
                    let found = single.evaluate(&single_pose(position, axis));
                    let found = [0, 1, 2].map(|k| f64::from(found[k]));
                    distance(&found, &exact_position_mm(&model, position, axis))
                })
                .fold(0.0, f64::max);
            // Near an edge a weight of size w is off by some epsilon, and so is what it weighs.
            let unit = f64::from(f32::EPSILON) * testing::largest_mm(&model);
            assert!(worst < 100.0 * unit && worst > 0.1 * unit, "{set:?} {worst:e}");
        }
    }
}
