//! The equations of a shape of a material: the layers within it, and what flows around its holes.

use super::around::Around;
use super::functions::Functions;
use super::layers::real;
use super::pair::Pair;
use super::{BoundaryShape, for_pairs};
use faer::{Mat, c64};
use nalgebra::Vector3;
use trackwright_task::{Cancelled, Task};

/// What a skin depth and a permeability make of the equations.
pub(super) struct Inside<'a> {
    shape: &'a BoundaryShape,
    kk: c64,
    mu: f64,
    /// `⟨f, S m⟩` of all functions of `m`, and `⟨f, S(n u)⟩`.
    single: Mat<c64>,
    of_normals: Mat<c64>,
    /// Of fluxes: `⟨∇·f, (S/μ + S₀) q⟩` and `⟨∇·f, (D + D₀) u⟩`.
    charges: Mat<c64>,
    doubles: Mat<c64>,
    /// `C` of what flows around holes: of currents all but what they link is of order `k²`.
    around: Around<c64>,
}

fn add_both(matrix: &mut Mat<c64>, i: usize, j: usize, value: c64) {
    matrix[(i, j)] += value * 0.5;
    matrix[(j, i)] += value * 0.5;
}

impl<'a> Inside<'a> {
    pub fn new(shape: &'a BoundaryShape, k: c64, mu: f64, task: &Task) -> Result<Self, Cancelled> {
        let functions = &shape.functions;
        let Functions { loops, fluxes, .. } = *functions;
        let count = functions.count();
        let panels = shape.surface.panels();
        let around = Around::new(panels, functions, k, task)?;
        let mut inside = Self {
            shape,
            kk: k * k,
            mu,
            single: Mat::zeros(count, count),
            of_normals: Mat::zeros(count, loops),
            charges: Mat::zeros(fluxes, fluxes),
            doubles: Mat::zeros(fluxes, loops),
            around,
        };
        for_pairs(panels, k, task, |i, j, pair| {
            if !pair.is_none() {
                inside.add(i, j, pair);
            }
        })?;
        inside.add_at_rest();
        Ok(inside)
    }

    /// The layers of a triangle over another one.
    fn add(&mut self, i: usize, j: usize, pair: &Pair<c64>) {
        let functions = &self.shape.functions;
        let loops = functions.loops;
        let normal = self.shape.surface.panels()[j].normal();
        let complex = |v: &Vector3<f64>| v.map(real::<c64>);
        let whole = pair.whole();
        let over_target: [c64; 3] = [0, 1, 2].map(|l| (0..3).map(|k| pair.single[k][l]).sum());
        for (a, current) in functions.currents_of(i) {
            for (b, other) in functions.currents_of(j) {
                add_both(&mut self.single, a, b, whole * current.dot(&other));
            }
            for (b, other) in functions.linear_of(j) {
                let each = over_target.iter().zip(&other.at_corners);
                let value = each.map(|(single, at)| single * current.dot(at)).sum();
                add_both(&mut self.single, a, b, value);
            }
            for b in &functions.loops_of[j] {
                let of_normal = over_target[b.corner] * current.dot(normal);
                match a < loops {
                    true => add_both(&mut self.of_normals, a, b.number, of_normal),
                    false => self.of_normals[(a, b.number)] += of_normal,
                }
            }
        }
        for (a, own) in functions.linear_of(i) {
            // With each corner's function on the source.
            let tested: [Vector3<c64>; 3] = [0, 1, 2]
                .map(|l| (0..3).map(|k| complex(&own.at_corners[k]) * pair.single[k][l]).sum());
            let over_source: Vector3<c64> = tested.iter().sum();
            for (b, other) in functions.currents_of(j) {
                add_both(&mut self.single, a, b, over_source.dot(&complex(&other)));
            }
            for (b, other) in functions.linear_of(j) {
                let each = tested.iter().zip(&other.at_corners);
                let value = each.map(|(tested, at)| tested.dot(&complex(at))).sum();
                add_both(&mut self.single, a, b, value);
            }
            for b in &functions.loops_of[j] {
                self.of_normals[(a, b.number)] += tested[b.corner].dot(&complex(normal));
            }
        }
        for t in &functions.fluxes_of[i] {
            for u in &functions.fluxes_of[j] {
                let value = whole * (t.divergence * u.divergence / self.mu);
                add_both(&mut self.charges, t.number, u.number, value);
            }
            for b in &functions.loops_of[j] {
                self.doubles[(t.number, b.number)] += pair.double[b.corner] * t.divergence;
            }
        }
    }

    /// The layers of `k = 0`.
    fn add_at_rest(&mut self) {
        let shape = self.shape;
        let functions = &shape.functions;
        for (i, own) in functions.fluxes_of.iter().enumerate() {
            for t in own {
                for (j, other) in functions.fluxes_of.iter().enumerate() {
                    for u in other {
                        let charges = t.divergence * u.divergence * shape.single[(i, j)];
                        self.charges[(t.number, u.number)] += real::<c64>(charges);
                    }
                }
                for b in 0..functions.loops {
                    let double = t.divergence * shape.double[(i, b)];
                    self.doubles[(t.number, b)] += real::<c64>(double);
                }
            }
        }
        let (at_rest, links) = (&shape.around.0, &functions.cycles.links);
        let (loops, first_flux) = (functions.loops, functions.first_flux());
        for hole in 0..functions.cycles.holes() {
            for a in 0..functions.count() {
                let at_rest = at_rest[(a, hole)];
                // The sum of both layers of a current is exactly how often it is linked.
                let added = match a {
                    _ if a >= first_flux => at_rest,
                    _ if (loops..functions.currents()).contains(&a) => {
                        links[(a - loops, hole)] - at_rest
                    }
                    _ => -at_rest,
                };
                self.around.0[(a, hole)] += real::<c64>(added);
            }
        }
    }

    /// `C` of a flux and a loop of `u`.
    fn coupling(&self, t: usize, b: usize) -> c64 {
        let of_normals = self.of_normals[(self.shape.functions.first_flux() + t, b)];
        self.kk * of_normals - self.doubles[(t, b)]
    }

    /// Where each kind of unknown begins, and how many there are: loops and cycles of `m`, its fluxes, loops of `u`,
    /// holes.
    pub fn parts(shape: &BoundaryShape) -> [usize; 4] {
        let functions = &shape.functions;
        let fluxes = functions.first_flux();
        let loops = functions.count();
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
            ((0, a), (0, b)) => self.single[(a, b)],
            ((0, a), (1, t)) => self.single[(a, fluxes + t)] / self.mu,
            ((0, a), (2, b)) => self.of_normals[(a, b)],
            ((0, a), (_, hole)) => self.around.0[(a, hole)],
            ((1, t), (0, b)) => self.single[(fluxes + t, b)] * self.kk,
            ((1, t), (1, u)) => {
                let single = self.single[(fluxes + t, fluxes + u)];
                single * self.kk / self.mu + self.charges[(t, u)]
            }
            ((1, t), (2, b)) => self.coupling(t, b),
            ((1, t), (_, hole)) => self.around.0[(fluxes + t, hole)] * self.kk,
            ((2, a), (0, b)) => -self.of_normals[(b, a)] * self.kk * self.mu,
            ((2, a), (1, t)) => -self.coupling(t, a),
            ((2, a), (2, b)) => self.both_layers(a, b),
            ((2, a), (_, hole)) => self.both_around(a, hole) * self.kk,
            ((_, hole), (0, b)) => -self.around.0[(b, hole)] * self.mu,
            ((_, hole), (1, t)) => -self.around.0[(fluxes + t, hole)],
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
        self.single[(a, b)] * self.mu + self.shape.of_currents[(a, b)]
    }

    /// Both layers of what flows around a hole.
    fn both_around(&self, a: usize, hole: usize) -> c64 {
        let Functions { loops, cycles, .. } = &self.shape.functions;
        let of = |cycle: usize| self.both_layers(a, loops + cycle) * cycles.around[(cycle, hole)];
        (0..cycles.count).map(of).sum()
    }
}
