//! The equations of a shape of a material: the layers within it, and what flows around its holes.

use super::around::Around;
use super::functions::Functions;
use super::layers::real;
use super::{BoundaryShape, for_pairs};
use faer::{Mat, c64};
use nalgebra::Vector3;
use trackwright_task::{Cancelled, Task};

/// What a skin depth and a permeability make of the equations.
pub(super) struct Inside<'a> {
    shape: &'a BoundaryShape,
    kk: c64,
    mu: f64,
    /// `S` of currents, of currents and loops' normals, and of fluxes and currents.
    of_currents: Mat<c64>,
    of_normals: Mat<c64>,
    of_both: Mat<c64>,
    /// `C`, and all of fluxes with fluxes.
    coupling: Mat<c64>,
    of_fluxes: Mat<c64>,
    /// `C` of what flows around holes: of currents, where all but what they link is of order `k²`, and of fluxes.
    around: Around<c64>,
}

fn add_both(matrix: &mut Mat<c64>, i: usize, j: usize, value: c64) {
    matrix[(i, j)] += value * 0.5;
    matrix[(j, i)] += value * 0.5;
}

impl<'a> Inside<'a> {
    pub fn new(shape: &'a BoundaryShape, k: c64, mu: f64, task: &Task) -> Result<Self, Cancelled> {
        let functions = &shape.functions;
        let (loops, fluxes) = (functions.loops, functions.fluxes);
        let currents = functions.currents();
        let panels = shape.surface.panels();
        let complex = |v: &Vector3<f64>| v.map(real::<c64>);
        let kk = k * k;
        let mut of_currents = Mat::zeros(currents, currents);
        let mut of_normals: Mat<c64> = Mat::zeros(currents, loops);
        let mut of_both: Mat<c64> = Mat::zeros(fluxes, currents);
        let mut coupling: Mat<c64> = Mat::zeros(fluxes, loops);
        let mut of_fluxes = Mat::zeros(fluxes, fluxes);
        for (i, own) in functions.fluxes_of.iter().enumerate() {
            for (j, other) in functions.fluxes_of.iter().enumerate() {
                for (t, u) in own.iter().flat_map(|t| other.iter().map(move |u| (t, u))) {
                    let charges = 4.0 * t.by * u.by * shape.single[(i, j)];
                    of_fluxes[(t.number, u.number)] += real::<c64>(charges);
                }
            }
        }
        for_pairs(panels, k, task, |i, j, pair| {
            if pair.is_none() {
                return;
            }
            let whole: c64 = pair.single.iter().sum();
            let target: Vector3<c64> = pair.moment.iter().sum();
            let corners = panels[j].corners_mm().map(|corner| complex(&corner.coords));
            let source: Vector3<c64> = (0..3).map(|c| corners[c] * pair.single[c]).sum();
            let product: c64 = (0..3).map(|c| corners[c].dot(&pair.moment[c])).sum();
            let normal = panels[j].normal();
            for (a, current) in functions.currents_of(i) {
                for (b, other) in functions.currents_of(j) {
                    add_both(&mut of_currents, a, b, whole * current.dot(&other));
                }
                for b in &functions.loops_of[j] {
                    let of_normal = pair.single[b.corner] * current.dot(normal);
                    match a < loops {
                        true => add_both(&mut of_normals, a, b.number, of_normal),
                        false => of_normals[(a, b.number)] += of_normal,
                    }
                }
                for u in &functions.fluxes_of[j] {
                    let from = source - complex(&u.from_mm) * whole;
                    let value = complex(&current).dot(&from);
                    of_both[(u.number, a)] += value * (0.5 * u.by);
                }
            }
            for t in &functions.fluxes_of[i] {
                let from = complex(&t.from_mm);
                for (b, current) in functions.currents_of(j) {
                    let value = complex(&current).dot(&(target - from * whole));
                    of_both[(t.number, b)] += value * (0.5 * t.by);
                }
                for b in &functions.loops_of[j] {
                    let single = pair.moment[b.corner] - from * pair.single[b.corner];
                    let single = kk * complex(normal).dot(&single);
                    coupling[(t.number, b.number)] += (single - pair.double[b.corner] * 2.0) * t.by;
                }
                for u in &functions.fluxes_of[j] {
                    let other = complex(&u.from_mm);
                    let along =
                        product - from.dot(&source) - other.dot(&target) + from.dot(&other) * whole;
                    let value = (kk * along + whole * 4.0) * (t.by * u.by / mu);
                    add_both(&mut of_fluxes, t.number, u.number, value);
                }
            }
        })?;
        for (i, own) in functions.fluxes_of.iter().enumerate() {
            for t in own {
                for b in 0..loops {
                    coupling[(t.number, b)] -= real::<c64>(2.0 * t.by * shape.double[(i, b)]);
                }
            }
        }
        let mut around = Around::new(panels, functions, k, task)?;
        let (at_rest, links) = (&shape.around, &functions.cycles.links);
        for hole in 0..functions.cycles.holes() {
            for a in 0..currents {
                // At rest the sum of both layers is exactly how often the current is linked.
                let linked = a.checked_sub(loops).map_or(0.0, |cycle| links[(cycle, hole)]);
                around.currents[(a, hole)] += real::<c64>(linked - at_rest.currents[(a, hole)]);
            }
            for t in 0..fluxes {
                around.fluxes[(t, hole)] += real::<c64>(at_rest.fluxes[(t, hole)]);
            }
        }
        Ok(Self { shape, kk, mu, of_currents, of_normals, of_both, coupling, of_fluxes, around })
    }

    /// Where each kind of unknown begins, and how many there are: currents of `m`, its fluxes, loops of `u`, holes.
    pub fn parts(shape: &BoundaryShape) -> [usize; 4] {
        let functions = &shape.functions;
        let fluxes = functions.currents();
        let loops = fluxes + functions.fluxes;
        let holes = loops + functions.loops;
        [fluxes, loops, holes, holes + functions.cycles.holes()]
    }

    /// An entry of the equations.
    pub fn entry(&self, row: usize, column: usize) -> c64 {
        let [fluxes, loops, holes, _] = Self::parts(self.shape);
        let place = |k: usize| match k {
            _ if k < fluxes => (0, k),
            _ if k < loops => (1, k - fluxes),
            _ if k < holes => (2, k - loops),
            _ => (3, k - holes),
        };
        match (place(row), place(column)) {
            ((0, a), (0, b)) => self.of_currents[(a, b)],
            ((0, a), (1, t)) => self.of_both[(t, a)] / self.mu,
            ((0, a), (2, b)) => self.of_normals[(a, b)],
            ((0, a), (_, hole)) => self.around.currents[(a, hole)],
            ((1, t), (0, b)) => self.of_both[(t, b)] * self.kk,
            ((1, t), (1, u)) => self.of_fluxes[(t, u)],
            ((1, t), (2, b)) => self.coupling[(t, b)],
            ((1, t), (_, hole)) => self.around.fluxes[(t, hole)] * self.kk,
            ((2, a), (0, b)) => -self.of_normals[(b, a)] * self.kk * self.mu,
            ((2, a), (1, t)) => -self.coupling[(t, a)],
            ((2, a), (2, b)) => self.both_layers(a, b),
            ((2, a), (_, hole)) => self.both_around(a, hole) * self.kk,
            ((_, hole), (0, b)) => -self.around.currents[(b, hole)] * self.mu,
            ((_, hole), (1, t)) => -self.around.fluxes[(t, hole)],
            ((_, hole), (2, b)) => self.both_around(b, hole),
            ((_, hole), (_, other)) => {
                let around = &self.shape.functions.cycles.around;
                let of = |cycle: usize| {
                    let current = self.shape.functions.loops + cycle;
                    self.both_around(current, other) * around[(cycle, hole)]
                };
                (0..around.nrows()).map(of).sum::<c64>() * self.kk
            }
        }
    }

    fn both_layers(&self, a: usize, b: usize) -> c64 {
        self.of_currents[(a, b)] * self.mu + self.shape.of_currents[(a, b)]
    }

    /// Both layers of what flows around a hole.
    fn both_around(&self, a: usize, hole: usize) -> c64 {
        let Functions { loops, cycles, .. } = &self.shape.functions;
        let of = |cycle: usize| self.both_layers(a, loops + cycle) * cycles.around[(cycle, hole)];
        (0..cycles.count).map(of).sum()
    }
}
