//! Boundary elements: what a body of any shape answers, conducting or magnetic or both, at any skin depth.
//!
//! Outside, the field in units of the coils' is `H = ∇u`, with what is added `∇(u − u₀)`. Its currents `n × ∇u` and
//! its flux `q = n·H` on the surface decide the field on both sides (Stratton and Chu). Inside, with `k = (1 + i)/δ`
//! of the skin depth `δ` and the permeability `μ`, the field decays as `G = e^(−kR)/4πR` does; the electric field is
//! given by `m = n × E/(iωμ₀)`, whose divergence is `q`. Both sides have the same `n × H` and `n × E` (Poggio and
//! Miller; Chang and Harrington; Wu and Tsai). With the single layer `S`, the double layer `D`, 0 for `k = 0`, tested
//! with fluxes `f` and loops `w = n × ∇v`:
//!
//! `k²/μ ⟨f, S m⟩ + ⟨∇·f, (S/μ + S₀) q⟩ + C(f, u) = 2 ⟨∇·f, S₀ q₀ − D₀ u₀⟩`,
//!
//! `⟨w, (μ S + S₀) n × ∇u⟩ − C(m, v) = ⟨v, q₀⟩`, `C(f, u) = k² ⟨f, S(n u)⟩ − ⟨∇·f, (D + D₀) u⟩`.
//!
//! `C(f, u)` is what `⟨f, ∇ × S(n × ∇u)⟩` is by parts: without singularities, and exactly `k² ⟨f, S(n u)⟩` for loops.
//! So loops of `m` are divided by `μ`, and their equations by `k²`: nothing is lost however large the skin depth. The
//! right sides are such that a body that is neither conducting nor magnetic adds nothing, to round-off: `u₀` is the
//! potential of the coils' own normal field `q₀`, by the same functions, `⟨w, S₀ n × ∇u₀⟩ = ⟨v, q₀⟩/2 − ⟨q₀, D₀ v⟩`.
//! Only what a material changes has the error of the triangles, so that few are enough.
//!
//! `u` is linear on triangles and `q` even; `m` has its fluxes and loops, and loops about the longest edges of
//! triangles. A current around a hole that goes through the body has a potential that goes up by the current where what
//! spans the hole is passed through: each hole adds an unknown `I/k²`, for which `n × ∇u` is tested as it is, and a right
//! side, the coils' flux through the hole.

mod around;
#[cfg(test)]
mod convergence;
mod cycles;
mod functions;
mod inside;
mod layers;
mod near;
mod pair;
#[cfg(test)]
pub(crate) mod rings;
#[cfg(test)]
mod tests;

use crate::factors::Factors;
use crate::panel::{FULL_ANGLE, Panel};
use crate::panel_lanes::PanelLanes;
use crate::phase::InPhaseAndLag;
use crate::surface::ClosedSurface;
use around::Around;
use faer::linalg::solvers::Solve;
use faer::{Mat, c64};
use functions::Functions;
use inside::Inside;
use layers::real;
use nalgebra::{Matrix3, Point3, Vector3};
use near::Rules;
use pair::Pair;
use rayon::prelude::*;
use std::sync::Arc;
use trackwright_task::{Cancelled, Task};

/// Triangles whose layers are integrated before they are added to the equations.
const CHUNK: usize = 64;

/// Columns of right sides that a thread takes at a time.
const COLUMNS: usize = 64;

/// A body's field is that of its moment at so many times the root of its surface's area, to 10⁻⁴.
const FAR: f64 = 100.0;

/// Why no body was factored.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum BoundaryError {
    #[error(
        "the equations of {panels} triangles have no solution: the walls are too thin for them"
    )]
    Singular { panels: usize },
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// What is the same of a shape whatever its material, in the body's frame.
#[derive(Clone, Debug)]
pub struct BoundaryShape {
    surface: ClosedSurface,
    functions: Functions,
    /// `S₀` between triangles, `D₀` of loops over triangles, and `S₀` of the currents of loops and cycles.
    single: Mat<f64>,
    double: Mat<f64>,
    of_currents: Mat<f64>,
    /// Of `k = 0`.
    around: Around<f64>,
    /// From the mean normal field on each triangle: the potential of the coils' field, and the right sides of fluxes.
    potential: Mat<f64>,
    of_fluxes: Mat<f64>,
    lanes: PanelLanes,
}

/// A shape of a material at a frequency.
#[derive(Clone, Debug)]
pub struct BoundaryBody {
    shape: Arc<BoundaryShape>,
    /// From the mean normal field on each triangle, and the flux through each hole: what is added to the flux through
    /// each triangle, then to the potential of each loop, then the current around each hole.
    answer: InPhaseAndLag,
}

impl BoundaryShape {
    /// Integrates all pairs of panels, on all threads.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn new(surface: ClosedSurface, task: &Task) -> Result<Self, Cancelled> {
        let functions = Functions::new(&surface);
        let (panels, loops) = (surface.panels(), functions.loops);
        let count = panels.len();
        let mut single: Mat<f64> = Mat::zeros(count, count);
        let mut double: Mat<f64> = Mat::zeros(count, loops);
        let mut of_currents: Mat<f64> = Mat::zeros(functions.currents(), functions.currents());
        for_pairs(panels, 0.0, task, |i, j, pair| {
            let whole = pair.whole();
            single[(i, j)] += 0.5 * whole;
            single[(j, i)] += 0.5 * whole;
            for b in &functions.loops_of[j] {
                double[(i, b.number)] += pair.double[b.corner];
            }
            for (b, current) in functions.currents_of(j) {
                for (a, other) in functions.currents_of(i) {
                    let value = 0.5 * whole * other.dot(&current);
                    of_currents[(a, b)] += value;
                    of_currents[(b, a)] += value;
                }
            }
        })?;
        let mut half_flux = Mat::from_fn(loops, count, |a, j| -double[(j, a)]);
        for (j, (panel, own)) in panels.iter().zip(&functions.loops_of).enumerate() {
            own.iter().for_each(|a| half_flux[(a.number, j)] += panel.area_mm2() / 6.0);
        }
        let of_loops = of_currents.as_ref().submatrix(0, 0, loops, loops);
        let potential: Mat<f64> = of_loops.partial_piv_lu().solve(&half_flux);
        let source: Mat<f64> = &single - &double * &potential;
        let mut of_fluxes = Mat::zeros(functions.fluxes, count);
        for j in 0..count {
            for (i, own) in functions.fluxes_of.iter().enumerate() {
                own.iter()
                    .for_each(|t| of_fluxes[(t.number, j)] += 2.0 * t.divergence * source[(i, j)]);
            }
        }
        let around = Around::new(panels, &functions, 0.0, task)?;
        let lanes = PanelLanes::new(panels);
        Ok(Self {
            surface,
            functions,
            single,
            double,
            of_currents,
            around,
            potential,
            of_fluxes,
            lanes,
        })
    }

    pub fn surface(&self) -> &ClosedSurface {
        &self.surface
    }

    /// Of each hole that goes through the body, triangles that span what flows around it, with their shares.
    pub(crate) fn spans(&self) -> &[Vec<(f64, Panel)>] {
        &self.functions.cycles.spans
    }
}

/// Calls `each` with every pair of a target and a source. While it is called with some rows, the next ones are
/// integrated on other threads.
fn for_pairs<T: layers::Number + Send + Sync>(
    panels: &[Panel],
    k: T,
    task: &Task,
    mut each: impl FnMut(usize, usize, &Pair<T>) + Send,
) -> Result<(), Cancelled> {
    let rules = Rules::new();
    let row = |i: usize| -> (Pair<T>, Vec<[Pair<T>; 2]>) {
        let beyond = panels[i + 1..].iter();
        let all = beyond.map(|other| Pair::both(&panels[i], other, k, &rules));
        (Pair::own(&panels[i], k, &rules), all.collect())
    };
    let rows = |first: usize| -> Vec<_> {
        let rows = first..panels.len().min(first + CHUNK);
        rows.into_par_iter().map(row).collect()
    };
    let mut found = rows(0);
    for first in (0..panels.len()).step_by(CHUNK) {
        // Of what is left, rows are shorter and shorter.
        let left = 1.0 - first as f64 / panels.len() as f64;
        task.step(((1.0 - left * left) * panels.len() as f64) as usize, panels.len())?;
        let add = || {
            for (i, (own, row)) in (first..).zip(&found) {
                each(i, i, own);
                for (j, [pair, back]) in (i + 1..).zip(row) {
                    each(i, j, pair);
                    each(j, i, back);
                }
            }
        };
        let next = first + CHUNK;
        found = rayon::join(add, || if next < panels.len() { rows(next) } else { Vec::new() }).1;
    }
    Ok(())
}

impl BoundaryBody {
    /// Solves for the answers to a field through each triangle, with two complex unknowns a triangle and one for each
    /// longest edge. The skin depth
    /// is infinite where no currents flow.
    ///
    /// # Errors
    /// Equations that have no solution, and [`Cancelled`].
    pub fn new(
        shape: Arc<BoundaryShape>,
        skin_depth_mm: f64,
        relative_permeability: f64,
        task: &Task,
    ) -> Result<Self, BoundaryError> {
        let functions = &shape.functions;
        let panels = shape.surface.panels();
        let (loops, fluxes, count) = (functions.loops, functions.fluxes, panels.len());
        let holes = functions.cycles.holes();
        let k = c64::new(1.0, 1.0) / skin_depth_mm;
        let inside = Inside::new(&shape, k, relative_permeability, &task.subtask(0.0, 0.4))?;
        let [of_flux, of_loop, of_hole, size] = Inside::parts(&shape);
        // Of a size of their own, rows and columns are of order 1.
        let size_mm = (shape.surface.area_mm2() / count as f64).sqrt();
        let is_flux = |k: usize| (of_flux..of_loop).contains(&k);
        let row_by = |k: usize| if is_flux(k) { 1.0 } else { 1.0 / size_mm };
        let column_by = |k: usize| if is_flux(k) || k >= of_hole { size_mm } else { 1.0 };
        let entry = |i: usize, j: usize| inside.entry(i, j) * (row_by(i) * column_by(j));
        let factors = Factors::new(size, entry, &task.subtask(0.4, 0.7))?;
        let factors = factors.ok_or(BoundaryError::Singular { panels: count })?;
        let of_columns = |columns: &[usize]| {
            let mut right: Mat<c64> = Mat::zeros(size, columns.len());
            for (column, &j) in columns.iter().enumerate() {
                if let Some(hole) = j.checked_sub(count) {
                    right[(of_hole + hole, column)] = real(-1.0 / size_mm);
                    continue;
                }
                for t in 0..fluxes {
                    right[(of_flux + t, column)] = real(shape.of_fluxes[(t, j)]);
                }
                for a in &functions.loops_of[j] {
                    right[(of_loop + a.number, column)] =
                        real(panels[j].area_mm2() / (3.0 * size_mm));
                }
            }
            let found = factors.solve(&right, of_flux);
            let mut added: Mat<c64> = Mat::zeros(count + loops + holes, columns.len());
            for (column, &j) in columns.iter().enumerate() {
                for (i, own) in functions.fluxes_of.iter().enumerate() {
                    let each =
                        own.iter().map(|t| found[(t.number, column)] * (t.divergence * size_mm));
                    added[(i, column)] = each.sum::<c64>() - if i == j { 1.0 } else { 0.0 };
                }
                for a in 0..loops {
                    let own = if j < count { shape.potential[(a, j)] } else { 0.0 };
                    added[(count + a, column)] = found[(of_loop - of_flux + a, column)] - own;
                }
                for hole in 0..holes {
                    added[(count + loops + hole, column)] =
                        found[(of_hole - of_flux + hole, column)] * (k * k * size_mm);
                }
            }
            added
        };
        let all: Vec<usize> = (0..count + holes).collect();
        let solving = task.subtask(0.7, 1.0);
        let parts: Vec<Mat<c64>> = all
            .par_chunks(COLUMNS)
            .map(|columns| match task.cancel.is_cancelled() {
                true => Err(Cancelled),
                false => Ok(of_columns(columns)),
            })
            .collect::<Result<_, _>>()?;
        solving.step(1, 1)?;
        let part = |of: fn(c64) -> f64| {
            let entry = |i: usize, j: usize| of(parts[j / COLUMNS][(i, j % COLUMNS)]);
            Mat::from_fn(count + loops + holes, count + holes, entry)
        };
        let answer = InPhaseAndLag { in_phase: part(|z| z.re), lag: part(|z| z.im) };
        Ok(Self { shape, answer })
    }

    pub fn surface(&self) -> &ClosedSurface {
        &self.shape.surface
    }

    pub fn shape(&self) -> &Arc<BoundaryShape> {
        &self.shape
    }

    /// Added fluxes through triangles, added potentials of loops, and currents around holes.
    pub fn unknowns(&self) -> usize {
        self.answer.in_phase.nrows()
    }

    /// From a mean normal field on each panel, and the flux through each hole: the unknowns.
    pub(crate) fn answer(&self) -> &InPhaseAndLag {
        &self.answer
    }

    /// Normal fields, a column each, without their mean over each shell, which a field without sources there has not.
    pub(crate) fn without_mean(&self, normal_field: &Mat<f64>) -> Mat<f64> {
        let surface = self.surface();
        let (panels, shell_of) = (surface.panels(), surface.shell_of());
        let mut fields = normal_field.clone();
        for column in 0..fields.ncols() {
            let mut flux = vec![0.0; surface.shells().len()];
            for (i, panel) in panels.iter().enumerate() {
                flux[shell_of[i]] += fields[(i, column)] * panel.area_mm2();
            }
            for i in 0..panels.len() {
                let shell = shell_of[i];
                fields[(i, column)] -= flux[shell] / surface.shells()[shell].area_mm2;
            }
        }
        fields
    }

    /// The moments that even fields along x, y and z bring about, a column each; in phase, and what lags.
    pub fn moments_mm3(&self) -> [Matrix3<f64>; 2] {
        [&self.answer.in_phase, &self.answer.lag].map(|answer| self.moments_by(answer))
    }

    fn moments_by(&self, answer: &Mat<f64>) -> Matrix3<f64> {
        let panels = self.surface().panels();
        let spans = self.shape.spans();
        let spanned = |hole: usize| -> Vector3<f64> {
            spans[hole]
                .iter()
                .map(|(share, of)| of.normal().as_ref() * (of.area_mm2() * share))
                .sum()
        };
        let even = Mat::from_fn(panels.len() + spans.len(), 3, |i, axis| match panels.get(i) {
            Some(panel) => panel.normal()[axis],
            None => spanned(i - panels.len())[axis],
        });
        let far_mm = FAR * self.surface().area_mm2().sqrt();
        let mut fields = [Vector3::zeros(); 3];
        let sources = self.sources(&(answer * &even));
        self.add_fields(&sources, &Point3::new(far_mm, 0.0, 0.0), &mut fields);
        // A dipole's field along x is twice its moment's x, and opposite to its y and z.
        let by = FULL_ANGLE * far_mm.powi(3);
        Matrix3::from_columns(&fields.map(|f| Vector3::new(0.5 * f.x, -f.y, -f.z) * by))
    }

    /// Of unknowns: the flux through each panel and its current, four columns a coil.
    pub fn sources(&self, unknowns: &Mat<f64>) -> Mat<f64> {
        let count = self.surface().panels().len();
        let mut sources = Mat::zeros(count, 4 * unknowns.ncols());
        for coil in 0..unknowns.ncols() {
            for i in 0..count {
                sources[(i, 4 * coil)] = unknowns[(i, coil)];
                for (number, current) in self.currents_of(i) {
                    for axis in 0..3 {
                        sources[(i, 4 * coil + 1 + axis)] +=
                            current[axis] * unknowns[(count + number, coil)];
                    }
                }
            }
        }
        sources
    }

    /// Adds the fields of [`Self::sources`] at a point outside, in the body's frame; one field a coil.
    ///
    /// # Panics
    /// If the sources are not those of this body, or `fields` are not one a coil.
    pub fn add_fields(&self, sources: &Mat<f64>, p: &Point3<f64>, fields: &mut [Vector3<f64>]) {
        let mut sums = vec![Vector3::zeros(); 4 * fields.len()];
        self.shape.lanes.add_fields(self.surface().panels(), sources, p, &mut sums);
        for (field, of) in fields.iter_mut().zip(sums.chunks_exact(4)) {
            // The field of a current is its cross product with that of a charge.
            let (x, y, z) = (of[1], of[2], of[3]);
            let currents = Vector3::new(y.z - z.y, z.x - x.z, x.y - y.x);
            *field += (of[0] + currents) / FULL_ANGLE;
        }
    }

    /// Calls `each` with every unknown and the field that a unit of it has at a point outside.
    pub(crate) fn for_unit_fields(
        &self,
        p: &Point3<f64>,
        mut each: impl FnMut(usize, Vector3<f64>),
    ) {
        let panels = self.surface().panels();
        for (i, panel) in panels.iter().enumerate() {
            let field = panel.field(p) / FULL_ANGLE;
            each(i, field);
            for (number, current) in self.currents_of(i) {
                each(panels.len() + number, current.cross(&field));
            }
        }
    }

    /// Loops, and after them holes, that make currents in a triangle, with what a unit of each makes.
    fn currents_of(&self, triangle: usize) -> impl Iterator<Item = (usize, Vector3<f64>)> {
        let Functions { loops, loops_of, cycles, .. } = &self.shape.functions;
        let around = cycles.around_in(triangle).into_iter().enumerate();
        let of_loops = loops_of[triangle].iter().map(|of| (of.number, of.current));
        of_loops.chain(around.map(move |(hole, current)| (loops + hole, current)))
    }
}
