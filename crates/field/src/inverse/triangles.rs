//! The triangles of a model's orientations: how steep weights are in them, how far they are apart,
//! and where weights jump from one to the next.

use super::nets::Nets;
use super::slopes::{largest_differences, steepest_weights};
use crate::DistortionModel;
use nalgebra::{Unit, Vector3};
use trackwright_geometry::directions::{DirectionSet, Weighting};

/// A model's triangles and how steep weights are in them; for the set of one, a single triangle
/// in which nothing changes.
pub(super) struct Triangles {
    set: DirectionSet,
    pub corners: Vec<[usize; 3]>,
    pub steepest: Vec<[f64; 3]>,
    /// Ends of edges across which weights jump, and by how much.
    jumps: Vec<([usize; 2], f64)>,
}

impl Triangles {
    pub fn of(model: &DistortionModel) -> Self {
        let set = model.directions();
        if set == DirectionSet::One {
            return Self {
                set,
                corners: vec![[0; 3]],
                steepest: vec![[0.0; 3]],
                jumps: Vec::new(),
            };
        }
        let steepest = set
            .triangles()
            .iter()
            .map(|t| steepest_weights(&corners(set, t), model.weighting()))
            .collect();
        Self {
            set,
            jumps: match model.weighting() {
                Weighting::Area => weight_jumps(set),
                Weighting::Gnomonic => Vec::new(),
            },
            corners: set.triangles().to_vec(),
            steepest,
        }
    }

    /// The largest jump of the error across any edge, mm and radians.
    pub fn jump(&self, nets: &Nets) -> [f64; 2] {
        let mut largest = [0.0_f64; 2];
        for ([a, b], weight) in &self.jumps {
            let apart = largest_differences(&nets.of_direction[*a], &nets.of_direction[*b]);
            for (largest, apart) in largest.iter_mut().zip(apart) {
                *largest = largest.max(weight * apart);
            }
        }
        largest
    }

    /// Of each triangle, all by how far they are from it at least, itself first.
    pub fn neighbours(&self) -> Vec<Vec<Neighbour>> {
        let caps: Vec<_> = self
            .corners
            .iter()
            .map(|t| {
                let corners = corners(self.set, t);
                let middle = Unit::new_normalize(corners.iter().sum::<Vector3<f64>>());
                let radius = corners.iter().map(|c| middle.angle(c)).fold(0.0, f64::max);
                (middle, radius)
            })
            .collect();
        caps.iter()
            .map(|(middle, radius)| {
                let mut neighbours: Vec<_> = caps
                    .iter()
                    .enumerate()
                    .map(|(triangle, (other, other_radius))| Neighbour {
                        triangle,
                        // Less by a margin far above round-off and far below a triangle.
                        apart_rad: middle.angle(other) - radius - other_radius - 1e-6,
                    })
                    .collect();
                neighbours.sort_by(|a, b| a.apart_rad.total_cmp(&b.apart_rad));
                neighbours
            })
            .collect()
    }
}

fn corners(set: DirectionSet, triangle: &[usize; 3]) -> [Vector3<f64>; 3] {
    triangle.map(|d| set.directions()[d].into_inner())
}

/// A triangle as seen from another.
#[derive(Clone, Copy, Debug)]
pub(super) struct Neighbour {
    pub triangle: usize,
    /// No axes of the two are closer.
    pub apart_rad: f64,
}

/// Steps along an edge at which the jump of its weights is looked at, and what it may exceed the
/// largest of them by.
const EDGE_STEPS: usize = 48;
const BETWEEN_EDGE_STEPS: f64 = 0.05;

/// Jumps of weights below this are round-off of weights that are continuous.
const NO_JUMP: f64 = 1e-12;

/// Edges across which area weights jump.
fn weight_jumps(set: DirectionSet) -> Vec<([usize; 2], f64)> {
    let triangles = set.triangles();
    let mut jumps = Vec::new();
    for (first, t) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b, c) = (t[k], t[(k + 1) % 3], t[(k + 2) % 3]);
            // The neighbour has the edge the other way round.
            let other = triangles[..first].iter().find_map(|o| {
                let m = (0..3).find(|&m| o[m] == b && o[(m + 1) % 3] == a)?;
                Some(o[(m + 2) % 3])
            });
            if let Some(d) = other {
                let weight = weight_jump([a, b, c, d].map(|i| set.directions()[i].into_inner()));
                if weight > NO_JUMP {
                    jumps.push(([a, b], weight));
                }
            }
        }
    }
    jumps
}

/// The largest difference along the edge from `a` to `b` between the weight of `a` in the triangle
/// with `c` and in that with `d`.
fn weight_jump([a, b, c, d]: [Vector3<f64>; 4]) -> f64 {
    let half_area = |n: &Vector3<f64>, b: &Vector3<f64>, c: &Vector3<f64>| {
        n.dot(&b.cross(c)).abs().atan2(1.0 + n.dot(b) + b.dot(c) + c.dot(n))
    };
    let weight = |n: &Vector3<f64>, third: &Vector3<f64>| {
        let (of_a, of_b) = (half_area(n, &b, third), half_area(n, &a, third));
        of_a / (of_a + of_b)
    };
    let largest = (0..=EDGE_STEPS)
        .map(|i| {
            let t = i as f64 / EDGE_STEPS as f64;
            let n = (a * (1.0 - t) + b * t).normalize();
            (weight(&n, &c) - weight(&n, &d)).abs()
        })
        .fold(0.0, f64::max);
    largest * (1.0 + BETWEEN_EDGE_STEPS)
}
