//! A field read off a lattice of its own values, trilinearly: cheap at any order, and off by the
//! square of the spacing.

use nalgebra::{Point3, Unit, Vector3};
use trackwright_field::bernstein::control_points;
use trackwright_field::model::Coefficient;
use trackwright_field::{DistortionModel, OutsidePolicy};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::directions::DirectionWeights;

/// Values at the nodes of a lattice over the model's box, one set for each requested axis.
pub struct ValueLattice {
    bounds: Bounds,
    /// Nodes along each side.
    nodes: usize,
    /// Axis slowest, then x, y, z.
    pub values: Vec<Coefficient>,
}

impl ValueLattice {
    /// The model sampled for some axes; at least two nodes a side.
    pub fn new(model: &DistortionModel, axes: &[Unit<Vector3<f64>>], nodes: usize) -> Self {
        let bounds = *model.bounds();
        let nodes = nodes.max(2);
        let at_node = |axis: &Unit<Vector3<f64>>, part: [f64; 3]| {
            let at = bounds.min_mm + Vector3::from(part).component_mul(&bounds.size_mm());
            model.evaluate(&at, axis, OutsidePolicy::Clamp).error.values()
        };
        let of_axis = |axis| control_points(nodes - 1).map(move |part| at_node(axis, part));
        let values = axes.iter().flat_map(of_axis).collect();
        Self { bounds, nodes, values }
    }

    /// Bytes that a lattice takes.
    pub fn bytes(axes: usize, nodes: usize) -> usize {
        axes * nodes.pow(3) * size_of::<Coefficient>()
    }

    /// Longest distance of neighbouring nodes along an axis of the box.
    pub fn spacing_mm(bounds: &Bounds, nodes: usize) -> f64 {
        bounds.size_mm().max() / (nodes.max(2) - 1) as f64
    }

    /// The value for an axis between three that the lattice was made for, between the eight nodes around
    /// a position in the box.
    pub fn at(&self, position_mm: &Point3<f64>, axis: &DirectionWeights) -> Coefficient {
        let n = self.nodes;
        let scaled = self.bounds.to_unit(position_mm) * (n - 1) as f64;
        let cell = scaled.map(|s| (s as usize).min(n - 2));
        let part = Vector3::from_fn(|k, _| scaled[k] - cell[k] as f64);
        let mut total = [0.0; 6];
        for (&axis, &weight) in axis.directions.iter().zip(&axis.weights) {
            if weight == 0.0 {
                continue;
            }
            for corner in 0..8 {
                let [dx, dy, dz] = [corner >> 2, corner >> 1 & 1, corner & 1];
                let side = |k: usize, d: usize| if d == 1 { part[k] } else { 1.0 - part[k] };
                let factor = weight * side(0, dx) * side(1, dy) * side(2, dz);
                let index = ((axis * n + cell.x + dx) * n + cell.y + dy) * n + cell.z + dz;
                for (sum, value) in total.iter_mut().zip(&self.values[index]) {
                    *sum += factor * value;
                }
            }
        }
        total
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::precision::{sampling::poses, testing};
    use trackwright_geometry::directions::{DirectionSet, Weighting};

    /// Differences from the model at scattered poses.
    fn differences_mm(model: &DistortionModel, nodes: usize) -> Vec<f64> {
        let set = model.directions();
        let lattice = ValueLattice::new(model, set.directions(), nodes);
        poses(model.bounds(), 2000, 11)
            .iter()
            .map(|(position, axis)| {
                let found = lattice.at(position, &set.weights(axis, model.weighting()));
                let exact = model.evaluate(position, axis, OutsidePolicy::Clamp).error;
                (exact.position_mm - Vector3::new(found[0], found[1], found[2])).norm()
            })
            .collect()
    }

    fn worst(model: &DistortionModel, nodes: usize) -> f64 {
        differences_mm(model, nodes).into_iter().fold(0.0, f64::max)
    }

    #[test]
    fn linear_fields_are_read_off_exactly() {
        assert!(worst(&testing::linear_model(3), 4) < 1e-14);
    }

    #[test]
    fn error_falls_with_the_squared_spacing() {
        let model = testing::model(4, DirectionSet::Fourteen, Weighting::Area);
        let rms = |nodes: usize| {
            let all = differences_mm(&model, nodes);
            (all.iter().map(|e| e * e).sum::<f64>() / all.len() as f64).sqrt()
        };
        for (coarse, fine) in [(17, 33), (33, 65)] {
            let ratio = rms(coarse) / rms(fine);
            // 4 in the limit; 2,000 draws determine an RMS to some 3 %, two of them to 5 %.
            assert!((3.5..4.5).contains(&ratio), "{coarse}: {ratio}");
        }
    }

    /// `|e| <= Σ_k h_k²/8 max |∂²f/∂x_k²|`, and the second derivative of a Bernstein polynomial
    /// is at most `n (n - 1)` times its largest second difference, which is at most four times
    /// its largest coefficient.
    #[test]
    fn the_error_stays_below_its_bound() {
        let order = 3;
        let model = testing::model(order, DirectionSet::Six, Weighting::Gnomonic);
        let second = (order * (order - 1)) as f64 * 4.0 * testing::largest_mm(&model);
        for nodes in [3, 6, 12] {
            let h = 1.0 / (nodes - 1) as f64;
            // Three axes of the box, three components of the norm.
            let bound = 3.0 * h * h / 8.0 * second * 3.0_f64.sqrt();
            let found = worst(&model, nodes);
            assert!(found < bound && found > 0.001 * bound, "{found} {bound}");
        }
    }
}
