//! The field of one axis on a lattice, by sum factorisation.
//!
//! Points that share coordinates share sums: the coefficients are summed over one axis' basis once
//! a coordinate of that axis, then over the second axis' once a row, and only the last sum, of
//! n + 1 terms, is each point's own. The axis with the most coordinates comes last, so that it is
//! also the one in which the vectors lie.

use super::axis_model::AxisModel;
use super::batch::Instructions;
use super::bernstein;
use super::computed::ComputedBatch;
use super::evaluation::{Coefficient, Evaluation, OutsidePolicy};
use super::kernel::{Basis, MAX_TERMS, basis};
use super::samples::PoseError;
use nalgebra::{Point3, Vector3};
use pulp::bytemuck::cast_slice;
use pulp::{Simd, WithSimd};
use trackwright_geometry::bounds::Bounds;

/// Lanes of the widest vectors.
const MAX_LANES: usize = 8;

/// Places of a computed field that are evaluated at once: enough to fill vectors, few enough to stay in
/// the cache.
const BLOCK: usize = 1024;

impl AxisModel {
    /// What [`AxisModel::evaluate`] gives at all points with the given coordinates, x slowest and
    /// z fastest. Coordinates in mm, tracker frame.
    pub fn evaluate_lattice(
        &self,
        coordinates_mm: [&[f64]; 3],
        outside: OutsidePolicy,
        out: &mut Vec<Evaluation>,
    ) {
        self.evaluate_lattice_with(Instructions::Best, coordinates_mm, outside, out);
    }

    fn evaluate_lattice_with(
        &self,
        instructions: Instructions,
        coordinates_mm: [&[f64]; 3],
        outside: OutsidePolicy,
        out: &mut Vec<Evaluation>,
    ) {
        let [nx, ny, nz] = coordinates_mm.map(<[f64]>::len);
        let nothing = Evaluation { error: PoseError::default(), is_inside: false };
        out.clear();
        out.resize(nx * ny * nz, nothing);
        let clamp = outside != OutsidePolicy::Extrapolate;
        let strides = [ny * nz, nz, 1];
        let mut axes = [0, 1, 2].map(|k| Axis {
            index: k,
            stride: strides[k],
            coordinates: coordinates_mm[k]
                .iter()
                .map(|&v| Coordinate::new(self.bounds(), k, v, clamp))
                .collect(),
        });
        // In the order of summation.
        axes.sort_by_key(|axis| axis.coordinates.len());
        if let Some(computed) = self.model().computed() {
            let [along_x, along_y, along_z] = coordinates_mm;
            let place = |index: usize| {
                let (row, z) = (index / nz, along_z[index % nz]);
                Point3::new(along_x[row / ny], along_y[row % ny], z)
            };
            let (mut batch, mut places) = (ComputedBatch::default(), Vec::with_capacity(BLOCK));
            let no_axes = vec![Vector3::z_axis(); BLOCK.min(out.len())];
            for (block, out) in out.chunks_mut(BLOCK).enumerate() {
                places.clear();
                places.extend((0..out.len()).map(|k| place(block * BLOCK + k)));
                computed.evaluate_all(&mut batch, &places, &no_axes[..out.len()], out);
            }
            return;
        }
        if self.order() == 0 {
            visit_rows(&axes, |start, row_is_inside, _| {
                for (i, at) in axes[2].coordinates.iter().enumerate() {
                    out[start + i * axes[2].stride].is_inside = row_is_inside && at.is_inside;
                }
            });
            return;
        }
        instructions.run(Lattice {
            order: self.order(),
            coefficients: permuted(self, axes.each_ref().map(|a| a.index)),
            axes: &axes,
            out,
        });
    }
}

/// A coordinate in the unit cube.
#[derive(Clone, Copy)]
struct Coordinate {
    unit: f64,
    is_inside: bool,
}

impl Coordinate {
    fn new(bounds: &Bounds, axis: usize, value_mm: f64, clamp: bool) -> Self {
        let mut point = bounds.min_mm;
        point[axis] = value_mm;
        let at = if clamp { bounds.clamp(&point) } else { point };
        Self { unit: bounds.to_unit(&at)[axis], is_inside: bounds.contains(&point) }
    }
}

/// An axis of the lattice.
struct Axis {
    /// 0, 1 or 2: x, y or z.
    index: usize,
    /// From one coordinate to the next, in the list of points.
    stride: usize,
    coordinates: Vec<Coordinate>,
}

/// Visits the rows along the last axis: start in the list of points, whether the two other
/// coordinates are inside, and their places.
fn visit_rows(axes: &[Axis; 3], mut visit: impl FnMut(usize, bool, [usize; 2])) {
    let [first, second, _] = axes;
    for (i, a) in first.coordinates.iter().enumerate() {
        for (j, b) in second.coordinates.iter().enumerate() {
            let start = i * first.stride + j * second.stride;
            visit(start, a.is_inside && b.is_inside, [i, j]);
        }
    }
}

/// The coefficients with their three indices in the order of summation.
fn permuted(model: &AxisModel, order_of_axes: [usize; 3]) -> Vec<Coefficient> {
    let n = model.order() + 1;
    let strides = [n * n, n, 1];
    let [a, b, c] = order_of_axes.map(|axis| strides[axis]);
    let mut out = Vec::with_capacity(n * n * n);
    for i in 0..n {
        for j in 0..n {
            out.extend((0..n).map(|k| model.coefficients()[i * a + j * b + k * c]));
        }
    }
    out
}

struct Lattice<'a> {
    order: usize,
    coefficients: Vec<Coefficient>,
    axes: &'a [Axis; 3],
    out: &'a mut [Evaluation],
}

impl WithSimd for Lattice<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let n = self.order + 1;
        let [first, second, last] = self.axes;
        let mut bases = Vec::with_capacity(last.coordinates.len().div_ceil(S::F64_LANES));
        for coordinates in last.coordinates.chunks(S::F64_LANES) {
            let mut units = [0.0; MAX_LANES];
            for (unit, at) in units.iter_mut().zip(coordinates) {
                *unit = at.unit;
            }
            let along: Basis<S::f64s, 1, MAX_TERMS> =
                basis(simd, self.order, [S::as_simd_f64s(&units).0[0]]);
            bases.push(along);
        }
        let mut plane = vec![[0.0; 6]; n * n];
        let mut row = [[0.0; 6]; MAX_TERMS];
        for (i, a) in first.coordinates.iter().enumerate() {
            sum_over(&self.coefficients, self.order, a.unit, &mut plane);
            for (j, b) in second.coordinates.iter().enumerate() {
                sum_over(&plane, self.order, b.unit, &mut row[..n]);
                let start = i * first.stride + j * second.stride;
                let is_inside = a.is_inside && b.is_inside;
                for (v, basis) in bases.iter().enumerate() {
                    let lanes = values_at(simd, &row[..n], basis);
                    let from = v * S::F64_LANES;
                    let here = &last.coordinates[from..];
                    for (lane, at) in here.iter().enumerate().take(S::F64_LANES) {
                        let [x, y, z, rx, ry, rz] = &lanes;
                        self.out[start + (from + lane) * last.stride] = Evaluation {
                            error: PoseError {
                                position_mm: Vector3::new(x[lane], y[lane], z[lane]),
                                rotation_rad: Vector3::new(rx[lane], ry[lane], rz[lane]),
                            },
                            is_inside: is_inside && at.is_inside,
                        };
                    }
                }
            }
        }
    }
}

/// Sums coefficients over their first index at a place of its axis.
#[inline(always)]
fn sum_over(coefficients: &[Coefficient], order: usize, unit: f64, out: &mut [Coefficient]) {
    let basis = bernstein::basis(order, unit);
    out.fill([0.0; 6]);
    for (part, b) in coefficients.chunks_exact(out.len()).zip(basis) {
        for (sum, c) in out.iter_mut().zip(part) {
            for k in 0..6 {
                sum[k] += b * c[k];
            }
        }
    }
}

/// The six values at a vector of points of a row, each by lane.
#[inline(always)]
fn values_at<S: Simd>(
    simd: S,
    row: &[Coefficient],
    basis: &Basis<S::f64s, 1, MAX_TERMS>,
) -> [[f64; MAX_LANES]; 6] {
    let mut sums = [simd.splat_f64s(0.0); 6];
    for (coefficient, b) in row.iter().zip(basis) {
        for (sum, &c) in sums.iter_mut().zip(coefficient) {
            *sum = simd.mul_add_e_f64s(simd.splat_f64s(c), b[0], *sum);
        }
    }
    let mut lanes = [[0.0; MAX_LANES]; 6];
    for (lanes, sum) in lanes.iter_mut().zip(sums) {
        lanes[..S::F64_LANES].copy_from_slice(cast_slice(&[sum]));
    }
    lanes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::DistortionModel;
    use crate::random_models::{random_model, room};
    use crate::samples::MapKind;
    use nalgebra::{Point3, Unit};
    use trackwright_geometry::directions::{DirectionSet, Weighting};

    fn model(order: usize) -> DistortionModel {
        match order {
            0 => DistortionModel::zero(room(), MapKind::Distortion),
            _ => random_model(order, DirectionSet::Fourteen, Weighting::Area, [1.0, 1.0], 1),
        }
    }

    fn places(count: usize, from: f64, to: f64) -> Vec<f64> {
        (0..count).map(|i| from + (to - from) * i as f64 / count.max(2) as f64).collect()
    }

    #[test]
    fn a_lattice_has_the_values_of_its_points() {
        let axis = Unit::new_normalize(Vector3::new(0.3, -0.7, 0.2));
        for order in [0, 1, 2, 3, 6, 9] {
            let model = model(order);
            for [nx, ny, nz] in [[1, 9, 13], [17, 1, 3], [8, 16, 1], [3, 4, 5], [1, 1, 1]] {
                let (xs, ys, zs) = (
                    places(nx, -250.0, 270.0),
                    places(ny, -200.0, 270.0),
                    places(nz, -550.0, -70.0),
                );
                for (outside, tolerance) in [
                    (OutsidePolicy::Clamp, 1e-13),
                    // Outside the box a basis of order 9 reaches some ten.
                    (OutsidePolicy::Extrapolate, 1e-11),
                ] {
                    for level in [Instructions::Best, Instructions::Avx2, Instructions::Portable] {
                        let mut out = Vec::new();
                        let lists = [&xs[..], &ys, &zs];
                        let at_axis = model.at_axis(&axis);
                        at_axis.evaluate_lattice_with(level, lists, outside, &mut out);
                        assert_eq!(out.len(), nx * ny * nz);
                        let mut found = out.iter();
                        for &x in &xs {
                            for &y in &ys {
                                for &z in &zs {
                                    let p = Point3::new(x, y, z);
                                    let expected = model.evaluate(&p, &axis, outside);
                                    let found = found.next().unwrap();
                                    assert_eq!(found.is_inside, expected.is_inside, "{p}");
                                    let d = found.error.largest_difference(&expected.error);
                                    assert!(d < tolerance, "order {order} at {p}: {d}");
                                }
                            }
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn a_lattice_without_points_has_no_values() {
        let mut out = Vec::new();
        let at_axis = model(2).at_axis(&Vector3::z_axis());
        at_axis.evaluate_lattice([&[0.0], &[], &[1.0]], OutsidePolicy::Clamp, &mut out);
        assert!(out.is_empty());
    }

    #[test]
    fn what_is_not_a_number_stays_in_its_place() {
        let at_axis = model(2).at_axis(&Vector3::z_axis());
        let (mut clean, mut dirty) = (Vec::new(), Vec::new());
        let outside = OutsidePolicy::Clamp;
        at_axis.evaluate_lattice([&[0.0, 1.0], &[2.0], &[-200.0]], outside, &mut clean);
        at_axis.evaluate_lattice([&[0.0, f64::NAN], &[2.0], &[-200.0]], outside, &mut dirty);
        assert_eq!(clean[0], dirty[0]);
        assert!(clean[1].is_inside && !dirty[1].is_inside);
    }
}
