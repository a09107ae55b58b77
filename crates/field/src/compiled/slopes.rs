//! Bounds of a compiled field over a part of its box and all axes, from its coefficients.
//!
//! A spline lies in the convex hull of its coefficients, and so do its derivatives. Harmonics of a
//! degree have `Σ Y² = (2l + 1) / 4π` at every axis and, along any tangent,
//! `Σ (∂Y)² = l (l + 1) (2l + 1) / 8π` (Unsöld's theorem), so that by Cauchy and Schwarz the norm of a
//! degree's coefficients bounds what the degree can be.

use super::CompiledField;
use super::spline::SplineAxis;
use crate::evaluation::Matrix6x3;
use crate::samples::PoseError;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// What a field can be at most over a part of its box, whatever the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldBounds {
    pub least_mm: Vector3<f64>,
    pub largest_mm: Vector3<f64>,
    pub largest_rad: f64,
    /// Largest change of the position error, then of the rotation, per mm.
    pub by_position: [f64; 2],
    /// The same per radian of the axis.
    pub by_axis: [f64; 2],
}

impl FieldBounds {
    /// Before anything is seen.
    pub const NOTHING: Self = Self {
        least_mm: Vector3::new(f64::INFINITY, f64::INFINITY, f64::INFINITY),
        largest_mm: Vector3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY),
        largest_rad: 0.0,
        by_position: [0.0; 2],
        by_axis: [0.0; 2],
    };

    /// Takes in an error and its derivatives.
    pub fn see(&mut self, error: &PoseError, by_position: &Matrix6x3, by_axis: &Matrix6x3) {
        self.least_mm = self.least_mm.inf(&error.position_mm);
        self.largest_mm = self.largest_mm.sup(&error.position_mm);
        self.largest_rad = self.largest_rad.max(error.rotation_rad.norm());
        for half in 0..2 {
            let norm = |m: &Matrix6x3| m.fixed_rows::<3>(3 * half).norm();
            self.by_position[half] = self.by_position[half].max(norm(by_position));
            self.by_axis[half] = self.by_axis[half].max(norm(by_axis));
        }
    }

    /// With errors and slopes so many times as large.
    #[must_use]
    pub fn widened(self, by: f64) -> Self {
        let middle = (self.least_mm + self.largest_mm) / 2.0;
        let half = (self.largest_mm - self.least_mm) / 2.0 * by;
        Self {
            least_mm: middle - half,
            largest_mm: middle + half,
            largest_rad: by * self.largest_rad,
            by_position: self.by_position.map(|slope| by * slope),
            by_axis: self.by_axis.map(|slope| by * slope),
        }
    }
}

impl CompiledField {
    /// Bounds over a part of the unit cube, an interval a coordinate. Intervals that reach beyond the
    /// cube are cut: there the field is that of its faces.
    pub fn bounds_over(&self, intervals: [[f64; 2]; 3]) -> FieldBounds {
        let size_mm = self.bounds.size_mm();
        let ranges = [0, 1, 2].map(|k| {
            let [low, high] = intervals[k].map(|t| t.clamp(0.0, 1.0));
            self.axes[k].functions_between(low, high)
        });
        let mut found = FieldBounds::NOTHING;
        let mut steepest = [[0.0_f64; 2]; 3];
        let counts = self.axes.map(SplineAxis::functions);
        for x in ranges[0][0]..ranges[0][1] {
            for y in ranges[1][0]..ranges[1][1] {
                for z in ranges[2][0]..ranges[2][1] {
                    let place = [x, y, z];
                    let node = self.node(place);
                    self.see_values(node, &mut found);
                    for k in 0..3 {
                        let mut next = place;
                        next[k] += 1;
                        if next[k] >= ranges[k][1].min(counts[k]) || size_mm[k] <= 0.0 {
                            continue;
                        }
                        let factor = self.axes[k].slope_factor(place[k]) / size_mm[k];
                        let difference: Vec<f64> = self
                            .node(next)
                            .iter()
                            .zip(node)
                            .map(|(a, b)| factor * (a - b))
                            .collect();
                        let norms = self.norms(&difference, |_| 1.0);
                        for (most, norm) in steepest[k].iter_mut().zip(norms) {
                            *most = most.max(norm);
                        }
                    }
                }
            }
        }
        found.by_position =
            [0, 1].map(|half| steepest.iter().map(|s| s[half].powi(2)).sum::<f64>().sqrt());
        found
    }

    /// Largest norm that the sum over all functions can have, of positions and of rotations; `part`
    /// multiplies the bound of a degree.
    fn norms(&self, node: &[f64], part: impl Fn(usize) -> f64) -> [f64; 2] {
        let mut norms = [0.0; 2];
        for (l, values) in degrees(self.degree, node) {
            let most = part(l) * ((2 * l + 1) as f64 / (4.0 * PI)).sqrt();
            for (half, norm) in norms.iter_mut().enumerate() {
                let each = values.chunks_exact(6).flat_map(|v| &v[3 * half..3 * half + 3]);
                *norm += most * each.map(|v| v * v).sum::<f64>().sqrt();
            }
        }
        norms
    }

    fn see_values(&self, node: &[f64], found: &mut FieldBounds) {
        let mut middle = Vector3::zeros();
        let mut reach = Vector3::zeros();
        for (l, values) in degrees(self.degree, node) {
            let most = ((2 * l + 1) as f64 / (4.0 * PI)).sqrt();
            for c in 0..3 {
                if l == 0 {
                    middle[c] = most * values[c];
                } else {
                    let each = values.chunks_exact(6).map(|v| v[c] * v[c]);
                    reach[c] += most * each.sum::<f64>().sqrt();
                }
            }
        }
        found.least_mm = found.least_mm.inf(&(middle - reach));
        found.largest_mm = found.largest_mm.sup(&(middle + reach));
        found.largest_rad = found.largest_rad.max(self.norms(node, |_| 1.0)[1]);
        let turning = self.norms(node, |l| ((l * (l + 1)) as f64 / 2.0).sqrt());
        for (most, norm) in found.by_axis.iter_mut().zip(turning) {
            *most = most.max(norm);
        }
    }
}

/// A node's values, degree by degree.
fn degrees(degree: usize, node: &[f64]) -> impl Iterator<Item = (usize, &[f64])> {
    let mut rest = node;
    (0..=degree).step_by(2).map(move |l| {
        let (own, after) = rest.split_at(6 * (2 * l + 1));
        rest = after;
        (l, own)
    })
}
