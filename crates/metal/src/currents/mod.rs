//! Currents in a conductor of one piece that is neither hollow nor magnetic, at any skin depth.
//!
//! The body is cut into layers across each of its three axes. In a layer currents flow in closed loops, given by a
//! stream function `ψ` that is linear on triangles and 0 on the outline: their sheet current is `∇ψ × a`, with the
//! axis `a`, evenly over the layer's thickness `h`. Tested with the same loops, Ohm's law and the law of induction are
//!
//! `(L/4π − i δ²/2 R) ψ = −∫ φ (a·B₀) dS`,
//!
//! `R_ij = ∫ ∇φ_i·∇φ_j dS/h` in a layer, `L_ij = ∬ ∇φ_i·∇φ_j/|r − s|` between any two of an axis, with the skin
//! depth `δ`. What a tracker measures in phase is the real part of `ψ`.
//!
//! The axes do not act on each other. That is exact where currents flow across one axis only: spheres and bodies of
//! revolution in even fields, plates, long rods. In a field that varies over a compact body its loops about the three
//! axes answer the same change of the field more than once.

mod inductance;
mod layer;
mod slice;

#[cfg(test)]
mod tests;

use crate::panel::{FULL_ANGLE, Panel};
use crate::panel_lanes::PanelLanes;
use crate::surface::ClosedSurface;
use faer::linalg::solvers::DenseSolveCore;
use faer::{Mat, c64};
use inductance::HeightDifferences;
use layer::Layer;
use nalgebra::{Matrix3, Point3, Rotation3, SymmetricEigen, Vector3};
use rayon::prelude::*;
use std::sync::Arc;
use trackwright_task::{Cancelled, Task};

/// Points of an outline, rings and layers, by the thickness across the axis as a part of the next longer extent:
/// about 700 unknowns each. A thin body has its currents alike through its thickness.
const SIZES: [(f64, Size); 3] = [
    (0.02, Size { points: 32, rings: 9, layers: 2 }),
    (0.06, Size { points: 28, rings: 8, layers: 4 }),
    (f64::INFINITY, Size { points: 20, rings: 7, layers: 6 }),
];

/// Across the longer axes of a thin body hardly a current flows.
const SMALL: Size = Size { points: 16, rings: 5, layers: 6 };
const THIN: f64 = 0.1;

/// Axes of a body are its frame's where its second moments are along these, by this part.
const ALIGNED: f64 = 1e-6;

#[derive(Clone, Copy, Debug)]
struct Size {
    points: usize,
    rings: usize,
    layers: usize,
}

/// A body's layers with what their loops induce in each other: of any conductivity and frequency.
#[derive(Clone, Debug)]
pub struct CurrentShape {
    stacks: Vec<Stack>,
}

/// The layers across an axis.
#[derive(Clone, Debug)]
struct Stack {
    body_from_stack: Rotation3<f64>,
    layers: Vec<Layer>,
    /// Number of the first unknown of each layer, and of all unknowns.
    first: Vec<usize>,
    resistance: Mat<f64>,
    inductance: Mat<f64>,
    /// The layers' triangles in the stack's frame.
    panels: Vec<Panel>,
    lanes: PanelLanes,
}

/// A shape at a skin depth.
#[derive(Clone, Debug)]
pub struct CurrentBody {
    shape: Arc<CurrentShape>,
    /// Of each axis: from a source to the stream function in phase.
    answers: Vec<Mat<f64>>,
}

impl CurrentShape {
    /// Cuts a body into layers and integrates all pairs of their triangles, on all threads. `None` of a body that
    /// is not in one piece, hollow, or so bent that a cut is not seen whole from its middle.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn new(surface: &ClosedSurface, task: &Task) -> Result<Option<Self>, Cancelled> {
        if surface.shells().len() != 1 {
            return Ok(None);
        }
        let Some(axes) = axes_of(surface) else { return Ok(None) };
        let extents_mm = axes.map(|axis| extent_mm(surface, &(axis * Vector3::z())));
        let mut stacks = Vec::with_capacity(axes.len());
        for (k, axis) in axes.iter().enumerate() {
            let others = [extents_mm[(k + 1) % 3], extents_mm[(k + 2) % 3]];
            let thickness = extents_mm[k].1 / others[0].1.min(others[1].1);
            let is_of_thin = others.iter().any(|other| other.1 < THIN * extents_mm[k].1);
            let size = match is_of_thin {
                true => SMALL,
                false => {
                    SIZES.into_iter().find(|(most, _)| thickness <= *most).map_or(SMALL, |of| of.1)
                }
            };
            let part = task.subtask(k as f64 / 3.0, (k + 1) as f64 / 3.0);
            let Some(layers) = layers(surface, axis, extents_mm[k], size) else { return Ok(None) };
            stacks.push(Stack::new(*axis, layers, &part)?);
        }
        Ok(Some(Self { stacks }))
    }
}

/// How far a body reaches along its axes, the least first; `None` of a surface that is not finite.
pub(crate) fn extents_mm(surface: &ClosedSurface) -> Option<[f64; 3]> {
    let along = |axis: Rotation3<f64>| extent_mm(surface, &(axis * Vector3::z())).1;
    let mut extents = axes_of(surface)?.map(along);
    extents.sort_by(f64::total_cmp);
    Some(extents)
}

/// Frames whose third axes are the body's.
fn axes_of(surface: &ClosedSurface) -> Option<[Rotation3<f64>; 3]> {
    let area = surface.area_mm2();
    let panels = surface.panels();
    let middle: Vector3<f64> =
        panels.iter().map(|p| p.center_mm().coords * p.area_mm2()).sum::<Vector3<f64>>() / area;
    let moments: Matrix3<f64> = panels
        .iter()
        .map(|panel| {
            let at = panel.center_mm().coords - middle;
            (at * at.transpose() + panel.moment_mm2()) * panel.area_mm2()
        })
        .sum::<Matrix3<f64>>()
        / area;
    let across = [(0, 1), (0, 2), (1, 2)].map(|at| moments[at].abs());
    let is_aligned = across.into_iter().fold(0.0, f64::max) <= ALIGNED * moments.trace();
    let own = match is_aligned {
        true => Matrix3::identity(),
        false => SymmetricEigen::new(moments).eigenvectors,
    };
    let frame = |k: usize| {
        let [x, z] = [own.column((k + 1) % 3), own.column(k)].map(|axis| axis.into_owned());
        Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, z.cross(&x), z]))
    };
    own.iter().all(|value| value.is_finite()).then(|| [0, 1, 2].map(frame))
}

/// The lowest point of a surface along a direction, and how far it reaches from there.
fn extent_mm(surface: &ClosedSurface, direction: &Vector3<f64>) -> (f64, f64) {
    let heights = surface.panels().iter().flat_map(|panel| panel.corners_mm());
    let (low, high) = heights
        .map(|p| p.coords.dot(direction))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), mm| (low.min(mm), high.max(mm)));
    (low, high - low)
}

/// Thinner towards both ends.
fn layers(
    surface: &ClosedSurface,
    body_from_stack: &Rotation3<f64>,
    (low_mm, extent_mm): (f64, f64),
    size: Size,
) -> Option<Vec<Layer>> {
    let height_mm = |k: usize| {
        let from_middle = 2.0 * k as f64 / size.layers as f64 - 1.0;
        let part = from_middle.signum() * layer::graded(from_middle.abs());
        low_mm + extent_mm * (0.5 + 0.5 * part)
    };
    let each = (0..size.layers).map(|k| {
        let heights_mm = [height_mm(k), height_mm(k + 1)];
        let middle_mm = 0.5 * (heights_mm[0] + heights_mm[1]);
        let outline = slice::outline(surface.panels(), body_from_stack, middle_mm)?;
        Layer::new(&slice::resampled(&outline, size.points), size.rings, heights_mm)
    });
    each.collect()
}

impl Stack {
    fn new(
        body_from_stack: Rotation3<f64>,
        layers: Vec<Layer>,
        task: &Task,
    ) -> Result<Self, Cancelled> {
        let mut first = vec![0];
        for layer in &layers {
            first.push(first[first.len() - 1] + layer.free);
        }
        let count = first[layers.len()];
        let mut resistance = Mat::zeros(count, count);
        for (layer, first) in layers.iter().zip(&first) {
            for t in &layer.triangles {
                let weight = t.area_mm2 / layer.thickness_mm();
                for (i, j) in pairs(&t.nodes, &t.nodes, layer.free, layer.free) {
                    resistance[(first + t.nodes[i], first + t.nodes[j])] +=
                        weight * t.gradients[i].dot(&t.gradients[j]);
                }
            }
        }
        let mut inductance = Mat::zeros(count, count);
        let blocks = layers.len() * (layers.len() + 1) / 2;
        let mut done = 0;
        for (a, target) in layers.iter().enumerate() {
            for (b, source) in layers.iter().enumerate().skip(a) {
                task.step(done, blocks)?;
                done += 1;
                let block = coupling(target, source);
                for i in 0..target.free {
                    for j in 0..source.free {
                        inductance[(first[a] + i, first[b] + j)] = block[(i, j)];
                        inductance[(first[b] + j, first[a] + i)] = block[(i, j)];
                    }
                }
            }
        }
        let in_stack = |layer: &Layer| {
            let middle_mm = layer.middle_mm();
            let corners = layer.triangles.iter().map(|t| t.corners_mm);
            corners
                .map(|corners| corners.map(|p| Point3::new(p.x, p.y, middle_mm)))
                .collect::<Vec<_>>()
        };
        let panels: Vec<Panel> = layers.iter().flat_map(in_stack).filter_map(Panel::new).collect();
        let lanes = PanelLanes::new(&panels);
        Ok(Self { body_from_stack, layers, first, resistance, inductance, panels, lanes })
    }

    fn unknowns(&self) -> usize {
        self.first[self.layers.len()]
    }

    /// Each triangle with the number of its layer's first unknown and free nodes, in their order.
    fn triangles(&self) -> impl Iterator<Item = (&layer::Triangle, usize, usize)> {
        self.layers.iter().zip(&self.first).flat_map(|(layer, first)| {
            layer.triangles.iter().map(move |triangle| (triangle, *first, layer.free))
        })
    }
}

/// Pairs of corners of which both are free.
fn pairs(
    rows: &[usize; 3],
    columns: &[usize; 3],
    free_rows: usize,
    free_columns: usize,
) -> impl Iterator<Item = (usize, usize)> {
    let (rows, columns) = (*rows, *columns);
    let all = (0..3).flat_map(|i| (0..3).map(move |j| (i, j)));
    all.filter(move |&(i, j)| rows[i] < free_rows && columns[j] < free_columns)
}

/// `L` between the free nodes of two layers.
fn coupling(target: &Layer, source: &Layer) -> Mat<f64> {
    let differences = HeightDifferences::new(target, source);
    let is_same = std::ptr::eq(target, source);
    let rows: Vec<Vec<[f64; 2]>> = target
        .triangles
        .par_iter()
        .map(|t| {
            let mut row = vec![[0.0; 2]; source.free];
            for s in &source.triangles {
                let mut integral = differences.of_triangles(t, s);
                // Rules differ on the two sides; in a layer the mean keeps the matrix symmetric.
                if is_same {
                    integral = 0.5 * (integral + differences.of_triangles(s, t));
                }
                for (node, gradient) in s.nodes.iter().zip(&s.gradients) {
                    if let Some(sum) = row.get_mut(*node) {
                        sum[0] += gradient.x * integral;
                        sum[1] += gradient.y * integral;
                    }
                }
            }
            row
        })
        .collect();
    let mut block = Mat::zeros(target.free, source.free);
    for (t, row) in target.triangles.iter().zip(&rows) {
        for (node, gradient) in t.nodes.iter().zip(&t.gradients).filter(|of| *of.0 < target.free) {
            for (j, [x, y]) in row.iter().enumerate() {
                block[(*node, j)] += gradient.x * x + gradient.y * y;
            }
        }
    }
    block
}

impl CurrentBody {
    /// Factors the equations at a skin depth.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn new(
        shape: Arc<CurrentShape>,
        skin_depth_mm: f64,
        task: &Task,
    ) -> Result<Self, Cancelled> {
        let loss_mm2 = 0.5 * skin_depth_mm * skin_depth_mm;
        let count = shape.stacks.len();
        let mut answers = Vec::with_capacity(count);
        for (k, stack) in shape.stacks.iter().enumerate() {
            task.step(k, count)?;
            let size = stack.unknowns();
            let matrix = Mat::from_fn(size, size, |i, j| {
                let (induced, lost) = (stack.inductance[(i, j)], stack.resistance[(i, j)]);
                c64::new(induced / FULL_ANGLE, -loss_mm2 * lost)
            });
            let inverse = matrix.partial_piv_lu().inverse();
            answers.push(Mat::from_fn(size, size, |i, j| inverse[(i, j)].re));
        }
        task.step(1, 1)?;
        Ok(Self { shape, answers })
    }

    pub fn shape(&self) -> &Arc<CurrentShape> {
        &self.shape
    }

    pub(crate) fn count(&self) -> usize {
        self.shape.stacks.iter().map(Stack::unknowns).sum()
    }

    /// The layers' triangles, in the body's frame: where the field across them is taken.
    pub(crate) fn samples(&self) -> Vec<Panel> {
        let of = |stack: &Stack| {
            let moved = |panel: &Panel| {
                Panel::new(panel.corners_mm().map(|corner| stack.body_from_stack * corner))
            };
            stack.panels.iter().filter_map(moved).collect::<Vec<_>>()
        };
        self.shape.stacks.iter().flat_map(of).collect()
    }

    /// Stream functions that answer the mean field across each sample; a column a coil.
    pub(crate) fn answer(&self, normal_field: &Mat<f64>) -> Mat<f64> {
        let coils = normal_field.ncols();
        let mut all: Mat<f64> = Mat::zeros(self.count(), coils);
        let (mut first_row, mut first_sample) = (0, 0);
        for (stack, answer) in self.shape.stacks.iter().zip(&self.answers) {
            let mut source: Mat<f64> = Mat::zeros(stack.unknowns(), coils);
            for (at, (triangle, first, free)) in stack.triangles().enumerate() {
                for node in triangle.nodes.into_iter().filter(|node| *node < free) {
                    for coil in 0..coils {
                        let across = normal_field[(first_sample + at, coil)];
                        source[(first + node, coil)] -= across * triangle.area_mm2 / 3.0;
                    }
                }
            }
            let found: Mat<f64> = answer * &source;
            for coil in 0..coils {
                for i in 0..stack.unknowns() {
                    all[(first_row + i, coil)] = found[(i, coil)];
                }
            }
            first_row += stack.unknowns();
            first_sample += stack.panels.len();
        }
        all
    }

    /// The currents of stream functions: of each axis two columns a coil, the components of the sheet current.
    pub(crate) fn currents(&self, stream: &Mat<f64>) -> Vec<Mat<f64>> {
        let mut first_row = 0;
        let of_stack = |stack: &Stack| {
            let mut currents: Mat<f64> = Mat::zeros(stack.panels.len(), 2 * stream.ncols());
            for (at, (triangle, first, free)) in stack.triangles().enumerate() {
                let corners = triangle.nodes.iter().zip(&triangle.gradients);
                for (node, gradient) in corners.filter(|of| *of.0 < free) {
                    for coil in 0..stream.ncols() {
                        let value = stream[(first_row + first + node, coil)];
                        currents[(at, 2 * coil)] += gradient.y * value;
                        currents[(at, 2 * coil + 1)] -= gradient.x * value;
                    }
                }
            }
            first_row += stack.unknowns();
            currents
        };
        self.shape.stacks.iter().map(of_stack).collect()
    }

    /// Adds the fields of [`Self::currents`] at a point outside, in the body's frame; one field a coil.
    pub(crate) fn add_fields(
        &self,
        currents: &[Mat<f64>],
        p: &Point3<f64>,
        fields: &mut [Vector3<f64>],
    ) {
        for (stack, currents) in self.shape.stacks.iter().zip(currents) {
            let in_stack = stack.body_from_stack.inverse_transform_point(p);
            let mut sums = vec![Vector3::zeros(); 2 * fields.len()];
            // The field of a current is its cross product with that of a charge.
            stack.lanes.add_fields(&stack.panels, currents, &in_stack, &mut sums);
            for (field, sums) in fields.iter_mut().zip(sums.chunks_exact(2)) {
                let (x, y) = (sums[0], sums[1]);
                let own = Vector3::new(y.z, -x.z, x.y - y.x);
                *field += stack.body_from_stack * own / FULL_ANGLE;
            }
        }
    }

    /// Calls `each` with every unknown and the field that a unit of it has at a point outside.
    pub(crate) fn for_unit_fields(
        &self,
        p: &Point3<f64>,
        mut each: impl FnMut(usize, Vector3<f64>),
    ) {
        let mut first_row = 0;
        for stack in &self.shape.stacks {
            let in_stack = stack.body_from_stack.inverse_transform_point(p);
            for ((triangle, first, free), panel) in stack.triangles().zip(&stack.panels) {
                let field = panel.field(&in_stack) / FULL_ANGLE;
                for (node, gradient) in triangle.nodes.iter().zip(&triangle.gradients) {
                    if *node < free {
                        let current = Vector3::new(gradient.y, -gradient.x, 0.0);
                        each(
                            first_row + first + node,
                            stack.body_from_stack * current.cross(&field),
                        );
                    }
                }
            }
            first_row += stack.unknowns();
        }
    }
}
