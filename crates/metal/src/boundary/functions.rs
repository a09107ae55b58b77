//! Currents in closed loops and fluxes on a closed surface of triangles.
//!
//! A loop about a corner is `n × ∇λ`, with the corner's linear function `λ`: even on each of its triangles. A flux
//! through an edge is `(r − c)/2A` in the triangle that has the corner `c` opposite to it, and the same with the other
//! sign beyond the edge (Rao, Wilton and Glisson, IEEE Trans. Antennas and Propagation 30(3), 1982). Fluxes through
//! the edges of a tree that joins all triangles of a shell, loops about all its corners but one, and
//! [cycles](super::cycles) where holes go through the body, are all there are.

use super::cycles::{Cycles, Tree};
use crate::panel::Panel;
use crate::surface::ClosedSurface;
use nalgebra::Vector3;
use std::collections::{HashMap, VecDeque};

/// The loops and fluxes of a surface.
#[derive(Clone, Debug)]
pub(super) struct Functions {
    pub loops: usize,
    pub fluxes: usize,
    /// Of each triangle.
    pub loops_of: Vec<Vec<Loop>>,
    pub fluxes_of: Vec<Vec<Flux>>,
    /// Where holes go through the body.
    pub cycles: Cycles,
}

/// A loop in one of its triangles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Loop {
    pub number: usize,
    /// The corner that it is about.
    pub corner: usize,
    pub current: Vector3<f64>,
}

/// A flux in one of its two triangles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flux {
    pub number: usize,
    /// `±1/2A`.
    pub by: f64,
    /// The corner that it comes from.
    pub from_mm: Vector3<f64>,
}

impl Functions {
    pub fn new(surface: &ClosedSurface) -> Self {
        let panels = surface.panels();
        let mut numbers: HashMap<[u64; 3], usize> = HashMap::new();
        let number = |p: &nalgebra::Point3<f64>| {
            let next = numbers.len();
            *numbers.entry([p.x, p.y, p.z].map(f64::to_bits)).or_insert(next)
        };
        let corners: Vec<usize> = panels.iter().flat_map(Panel::corners_mm).map(number).collect();
        let corners: Vec<[usize; 3]> =
            corners.chunks_exact(3).map(|of| [of[0], of[1], of[2]]).collect();
        let mut triangles_at: HashMap<[usize; 2], Vec<usize>> = HashMap::new();
        for (triangle, own) in corners.iter().enumerate() {
            for edge in edges(own) {
                triangles_at.entry(edge).or_default().push(triangle);
            }
        }
        let (loops, loops_of) = loops(surface, &corners, numbers.len());
        let (fluxes, fluxes_of, tree) = fluxes(panels, &corners, &triangles_at);
        let cycles = Cycles::new(panels, &corners, &triangles_at, &tree);
        Self { loops, fluxes, loops_of, fluxes_of, cycles }
    }

    /// Loops and cycles: currents without divergence, even on each triangle.
    pub fn currents(&self) -> usize {
        self.loops + self.cycles.count
    }

    /// Numbers of loops and, after them, cycles of a triangle, with their currents in it.
    pub fn currents_of(&self, triangle: usize) -> impl Iterator<Item = (usize, Vector3<f64>)> {
        let loops = self.loops_of[triangle].iter().map(|of| (of.number, of.current));
        let cycles = self.cycles.currents_of[triangle].iter();
        loops.chain(cycles.map(|(number, current)| (self.loops + number, *current)))
    }
}

/// The edge opposite to each corner.
fn edges(own: &[usize; 3]) -> [[usize; 2]; 3] {
    [0, 1, 2].map(|k| {
        let (a, b) = (own[(k + 1) % 3], own[(k + 2) % 3]);
        [a.min(b), a.max(b)]
    })
}

/// All loops of a shell together are none: one of each is left out.
fn loops(surface: &ClosedSurface, corners: &[[usize; 3]], count: usize) -> (usize, Vec<Vec<Loop>>) {
    let mut is_left_out = vec![false; count];
    let mut is_met = vec![false; surface.shells().len()];
    for (own, &shell) in corners.iter().zip(surface.shell_of()) {
        if !std::mem::replace(&mut is_met[shell], true) {
            is_left_out[own[0]] = true;
        }
    }
    let mut number = vec![None; count];
    let kept: Vec<usize> = (0..count).filter(|&corner| !is_left_out[corner]).collect();
    for (next, &corner) in kept.iter().enumerate() {
        number[corner] = Some(next);
    }
    let of = |(own, panel): (&[usize; 3], &Panel)| {
        let at = panel.corners_mm();
        let each = (0..3).filter_map(|corner| {
            let along = at[(corner + 1) % 3] - at[(corner + 2) % 3];
            let current = along / (2.0 * panel.area_mm2());
            Some(Loop { number: number[own[corner]]?, corner, current })
        });
        each.collect()
    };
    (kept.len(), corners.iter().zip(surface.panels()).map(of).collect())
}

fn fluxes(
    panels: &[Panel],
    corners: &[[usize; 3]],
    triangles_at: &HashMap<[usize; 2], Vec<usize>>,
) -> (usize, Vec<Vec<Flux>>, Tree) {
    let mut tree: Tree = vec![None; panels.len()];
    let mut fluxes_of = vec![Vec::new(); panels.len()];
    let mut is_reached = vec![false; panels.len()];
    let mut count = 0;
    for start in 0..panels.len() {
        if std::mem::replace(&mut is_reached[start], true) {
            continue;
        }
        let mut queue = VecDeque::from([start]);
        while let Some(from) = queue.pop_front() {
            for edge in edges(&corners[from]) {
                let beyond = triangles_at[&edge].iter().find(|to| !is_reached[**to]);
                let Some(&to) = beyond else { continue };
                is_reached[to] = true;
                tree[to] = Some((from, edge));
                for (triangle, sign) in [(from, 1.0), (to, -1.0)] {
                    let opposite = edges(&corners[triangle]).iter().position(|own| *own == edge);
                    let from_mm = panels[triangle].corners_mm()[opposite.unwrap_or(0)].coords;
                    let by = sign / (2.0 * panels[triangle].area_mm2());
                    fluxes_of[triangle].push(Flux { number: count, by, from_mm });
                }
                count += 1;
                queue.push_back(to);
            }
        }
    }
    (count, fluxes_of, tree)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boundary::rings::ring;
    use crate::shapes::{cuboid, sphere};

    #[test]
    fn loops_and_fluxes_are_all_there_are() {
        let mut hollow = sphere(20.0, 1).unwrap();
        hollow.parts.extend(sphere(10.0, 1).unwrap().parts);
        for (mesh, shells) in [(cuboid(&Vector3::new(9.0, 8.0, 2.0), 60).unwrap(), 1), (hollow, 2)]
        {
            let surface = ClosedSurface::new(&mesh).unwrap();
            let found = Functions::new(&surface);
            let triangles = surface.panels().len();
            assert_eq!(found.loops, triangles / 2 + shells);
            assert_eq!(found.fluxes, triangles - shells);
            assert_eq!(found.cycles.count, 0);
            // Currents of all loops about the corners of a triangle, and fluxes over all of a shell, are none.
            for own in found.loops_of.iter().filter(|own| own.len() == 3) {
                let sum: Vector3<f64> = own.iter().map(|of| of.current).sum();
                assert!(sum.norm() < 1e-12);
            }
            let each = found.fluxes_of.iter().zip(surface.panels());
            let flux =
                each.map(|(own, panel)| own.iter().map(|f| f.by).sum::<f64>() * panel.area_mm2());
            assert!(flux.sum::<f64>().abs() < 1e-12);
        }
    }

    #[test]
    fn a_ring_has_a_hole() {
        let mesh = ring([22.0, 38.0, 16.0], 12, [1, 1]);
        let found = Functions::new(&ClosedSurface::new(&mesh).unwrap()).cycles;
        assert_eq!((found.count, found.holes()), (2, 1));
        // What spans the current around it is the disc within the ring, whatever its current's direction.
        let spanned: Vector3<f64> = found.spans[0]
            .iter()
            .map(|(share, of)| of.normal().as_ref() * (of.area_mm2() * share))
            .sum();
        let radius_mm = (spanned.z.abs() / std::f64::consts::PI).sqrt();
        assert!((22.0..=38.0).contains(&radius_mm), "{radius_mm}");
        let largest = found.links.norm_max();
        assert!(largest == 1.0 && found.around.norm_max() == 1.0, "{largest}");
    }
}
