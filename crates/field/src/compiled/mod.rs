//! The compiled form of a room's field: cubic splines in position, even spherical harmonics in the
//! axis. Whatever a model computes once is evaluated by it in a time that does not depend on the model.

pub mod even_harmonics;
mod kernel;
mod slopes;
pub mod spline;
#[cfg(test)]
mod tests;

use super::evaluation::Coefficient;
use even_harmonics::{MAX_FUNCTIONS, functions};
use nalgebra::{DMatrix, Point3, SMatrix, Unit, Vector3};
use rayon::prelude::*;
use spline::{LOCAL, SplineAxis};
use trackwright_geometry::bounds::Bounds;

use kernel::Accumulation;
pub use slopes::FieldBounds;

/// Six values a function of the axis, padded to whole vectors of eight.
const fn stride(functions: usize) -> usize {
    (functions * 6).next_multiple_of(kernel::LANES)
}

/// Numbers a node has at most.
const MAX_STRIDE: usize = stride(MAX_FUNCTIONS);

/// The error of a reading over a box and all axes.
#[derive(Clone, Debug, PartialEq)]
pub struct CompiledField {
    bounds: Bounds,
    axes: [SplineAxis; 3],
    /// Highest degree in the axis, even; 0 where the field is that of one axis.
    degree: usize,
    /// Node after node, x slowest: function after function, six values each, then zeros.
    coefficients: Vec<f64>,
}

/// A field's values at a place and their changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CompiledSlopes {
    pub value: Coefficient,
    /// Per part of the box's edge.
    pub by_unit: SMatrix<f64, 6, 3>,
    /// Per radian, along the sphere.
    pub by_axis: SMatrix<f64, 6, 3>,
}

impl CompiledField {
    /// Compiles what is given at a place: six values for each even harmonic of the axis.
    ///
    /// `at` is called once for each node, on all cores.
    pub fn new(
        bounds: Bounds,
        cell_mm: f64,
        degree: usize,
        at: impl Fn(&[Point3<f64>]) -> Vec<Vec<Coefficient>> + Sync,
    ) -> Self {
        let size_mm = bounds.size_mm();
        let axes = [0, 1, 2].map(|k| {
            let cells = (size_mm[k] / cell_mm).ceil().clamp(1.0, MAX_CELLS as f64);
            SplineAxis::new(cells as usize)
        });
        let places = axes.map(SplineAxis::places);
        let nodes: Vec<Point3<f64>> = places[0]
            .iter()
            .flat_map(|&x| places[1].iter().map(move |&y| (x, y)))
            .flat_map(|(x, y)| places[2].iter().map(move |&z| Vector3::new(x, y, z)))
            .map(|unit| bounds.min_mm + size_mm.component_mul(&unit))
            .collect();
        let stride = stride(functions(degree));
        let mut coefficients = vec![0.0; nodes.len() * stride];
        coefficients
            .par_chunks_mut(NODES_AT_ONCE * stride)
            .zip(nodes.par_chunks(NODES_AT_ONCE))
            .for_each(|(out, nodes)| {
                for (out, values) in out.chunks_exact_mut(stride).zip(at(nodes)) {
                    for (out, value) in out.chunks_exact_mut(6).zip(values) {
                        out.copy_from_slice(&value);
                    }
                }
            });
        let counts = axes.map(SplineAxis::functions);
        for (k, axis) in axes.iter().enumerate() {
            let apart = counts[k + 1..].iter().product::<usize>() * stride;
            solve_along(&mut coefficients, &axis.from_values(), apart);
        }
        Self { bounds, axes, degree, coefficients }
    }

    /// The box that it was compiled over.
    pub fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    /// Highest degree in the axis; 0 where the field is that of one axis.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Cells along x, y and z.
    pub fn cells(&self) -> [usize; 3] {
        self.axes.map(SplineAxis::cells)
    }

    /// Memory in bytes.
    pub fn memory(&self) -> usize {
        size_of_val(self.coefficients.as_slice())
    }

    fn stride(&self) -> usize {
        stride(functions(self.degree))
    }

    /// The field of one axis, or its mean over all of them.
    #[must_use]
    pub fn at_axis(&self, axis: Option<&Vector3<f64>>) -> Self {
        let mut by_axis = [0.0; MAX_FUNCTIONS];
        match axis {
            Some(axis) => even_harmonics::values(self.degree, axis, &mut by_axis),
            None => even_harmonics::values(0, &Vector3::z(), &mut by_axis),
        }
        // The one function of degree 0 has this value.
        let constant = 0.5 / std::f64::consts::PI.sqrt();
        let count = functions(self.degree);
        let own = stride(1);
        let mut coefficients = vec![0.0; self.coefficients.len() / self.stride() * own];
        let nodes = self.coefficients.chunks_exact(self.stride());
        for (out, node) in coefficients.chunks_exact_mut(own).zip(nodes) {
            for (values, by_axis) in node.chunks_exact(6).zip(&by_axis[..count]) {
                for (out, value) in out.iter_mut().zip(values) {
                    *out += by_axis / constant * value;
                }
            }
        }
        Self { bounds: self.bounds, axes: self.axes, degree: 0, coefficients }
    }

    /// Values at a place in the unit cube.
    pub fn evaluate(&self, unit: &Vector3<f64>, axis: &Unit<Vector3<f64>>) -> Coefficient {
        let mut out = [[0.0; 6]];
        self.evaluate_all(std::slice::from_ref(unit), std::slice::from_ref(axis), &mut out);
        out[0]
    }

    /// Values at places in the unit cube. What a place gets does not depend on the others.
    ///
    /// # Panics
    /// Where there are not as many axes and values as places.
    pub fn evaluate_all(
        &self,
        units: &[Vector3<f64>],
        axes: &[Unit<Vector3<f64>>],
        out: &mut [Coefficient],
    ) {
        assert!(units.len() == axes.len() && units.len() == out.len(), "one of each a place");
        pulp::Arch::new().dispatch(Accumulation { field: self, units, axes, out });
    }

    /// Values at a place in the unit cube, with their changes.
    pub fn evaluate_with_slopes(&self, unit: &Vector3<f64>, axis: &Vector3<f64>) -> CompiledSlopes {
        let count = functions(self.degree);
        let mut by_axis = [0.0; MAX_FUNCTIONS];
        let mut turns = [Vector3::zeros(); MAX_FUNCTIONS];
        even_harmonics::values(self.degree, axis, &mut by_axis);
        even_harmonics::slopes(self.degree, axis, &mut turns);
        let local = [0, 1, 2].map(|k| self.axes[k].at(unit[k]));
        let slopes = [0, 1, 2].map(|k| self.axes[k].slopes(unit[k]));
        let mut value = [0.0; 6];
        let mut by_unit = SMatrix::zeros();
        let mut turned = SMatrix::zeros();
        for i in 0..LOCAL {
            for j in 0..LOCAL {
                for k in 0..LOCAL {
                    let [a, b, c] = [local[0].values[i], local[1].values[j], local[2].values[k]];
                    let weight = a * b * c;
                    let changes = Vector3::new(
                        slopes[0][i] * b * c,
                        a * slopes[1][j] * c,
                        a * b * slopes[2][k],
                    );
                    let node =
                        self.node([local[0].first + i, local[1].first + j, local[2].first + k]);
                    for (f, values) in node.chunks_exact(6).take(count).enumerate() {
                        for (row, v) in values.iter().enumerate() {
                            value[row] += weight * by_axis[f] * v;
                            for column in 0..3 {
                                by_unit[(row, column)] += changes[column] * by_axis[f] * v;
                                turned[(row, column)] += weight * turns[f][column] * v;
                            }
                        }
                    }
                }
            }
        }
        CompiledSlopes { value, by_unit, by_axis: turned }
    }

    fn node(&self, place: [usize; 3]) -> &[f64] {
        let [_, y, z] = self.axes.map(SplineAxis::functions);
        let stride = self.stride();
        let index = (place[0] * y + place[1]) * z + place[2];
        &self.coefficients[index * stride..][..stride]
    }
}

/// Most cells along an axis: 43³ nodes of degree 6 are 107 MB.
const MAX_CELLS: usize = 40;

/// Nodes that a core computes at a time.
const NODES_AT_ONCE: usize = 64;

/// Multiplies the values along one axis, which lie `apart` from each other, by a matrix.
fn solve_along(values: &mut [f64], matrix: &DMatrix<f64>, apart: usize) {
    let count = matrix.nrows();
    values.par_chunks_mut(count * apart).for_each(|block| {
        let old = DMatrix::from_column_slice(apart, count, block);
        let new = old * matrix.transpose();
        block.copy_from_slice(new.as_slice());
    });
}
