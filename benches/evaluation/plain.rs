//! The baseline: equation (8) as anyone would write it, one pose at a time.
//!
//! The triangle is searched for among all, the weights are the areas by Van Oosterom & Strackee,
//! and the sums run innermost first, so that it is the cheapest plain form: `(n + 1)³` products
//! of six values an orientation, then `(n + 1)²`, then `n + 1`.

use nalgebra::{Matrix3, Point3, Unit, Vector3};
use trackwright_field::DistortionModel;
use trackwright_field::bernstein::basis;

pub struct Plain<'a> {
    model: &'a DistortionModel,
    triangles: Vec<Triangle>,
}

struct Triangle {
    directions: [usize; 3],
    corners: [Vector3<f64>; 3],
    inverse: Matrix3<f64>,
}

impl<'a> Plain<'a> {
    pub fn new(model: &'a DistortionModel) -> Self {
        let set = model.directions();
        let triangles = set.triangles().iter().map(|&directions| {
            let corners = directions.map(|d| set.directions()[d].into_inner());
            Triangle {
                directions,
                corners,
                inverse: Matrix3::from_columns(&corners)
                    .try_inverse()
                    .expect("a triangle of the sphere"),
            }
        });
        Self { model, triangles: triangles.collect() }
    }

    pub fn evaluate(&self, position_mm: &Point3<f64>, axis: &Unit<Vector3<f64>>) -> [f64; 6] {
        let bounds = self.model.bounds();
        let unit = bounds.to_unit(&bounds.clamp(position_mm));
        let (directions, weights) = self.weights(axis);
        let order = self.model.order();
        let n = order + 1;
        let [bx, by, bz] = [0, 1, 2].map(|k| basis(order, unit[k]));
        let mut total = [0.0; 6];
        for (&direction, &weight) in directions.iter().zip(&weights) {
            let coefficients = self.model.of_direction(direction);
            let mut rows = coefficients.chunks_exact(n);
            for &x in &bx[..n] {
                let mut along_y = [0.0; 6];
                for (&y, row) in by[..n].iter().zip(&mut rows) {
                    let mut along_z = [0.0; 6];
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

    fn weights(&self, axis: &Unit<Vector3<f64>>) -> ([usize; 3], [f64; 3]) {
        let found = self
            .triangles
            .iter()
            .find(|t| (t.inverse * axis.as_ref()).min() >= -1e-14)
            .expect("the triangles cover the sphere");
        let (n, [a, b, c]) = (axis.as_ref(), &found.corners);
        let areas = [half_area(n, b, c), half_area(a, n, c), half_area(a, b, n)];
        let sum: f64 = areas.iter().sum();
        (found.directions, areas.map(|area| area / sum))
    }
}

fn half_area(a: &Vector3<f64>, b: &Vector3<f64>, c: &Vector3<f64>) -> f64 {
    a.dot(&b.cross(c)).abs().atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
}
