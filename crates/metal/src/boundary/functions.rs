//! Currents in closed loops and fluxes on a closed surface of triangles.
//!
//! A loop about a corner is `n × ∇λ`, with the corner's linear function `λ`: even on each of its triangles. A flux
//! through an edge is `(r − c)/2A` in the triangle that has the corner `c` opposite to it, and the same with the other
//! sign beyond the edge (Rao, Wilton and Glisson, IEEE Trans. Antennas and Propagation 30(3), 1982). Fluxes through
//! the edges of a tree that joins all triangles of a shell, loops about all its corners but one, and
//! [cycles](super::cycles) where holes go through the body, are all there are.
//!
//! In a flat triangle a flux that enters through its surface flows along it too, by as much as the triangle is longer
//! than high. Loops about edges, `n × ∇(4 λ_a λ_b)`, take that away: with those about the diagonal of a parallelogram
//! it is as in a rectangle that none flows along.

use super::cycles::{Cycles, Tree};
use crate::panel::Panel;
use crate::surface::ClosedSurface;
use nalgebra::Vector3;
use std::collections::{HashMap, VecDeque};

/// The loops and fluxes of a surface.
#[derive(Clone, Debug)]
pub(super) struct Functions {
    pub loops: usize,
    pub edge_loops: usize,
    pub fluxes: usize,
    /// Of each triangle.
    pub loops_of: Vec<Vec<Loop>>,
    pub edge_loops_of: Vec<Vec<Linear>>,
    pub fluxes_of: Vec<Vec<Linear>>,
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

/// A flux, or a loop about an edge, in one of its two triangles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Linear {
    pub number: usize,
    pub at_corners: [Vector3<f64>; 3],
    pub divergence: f64,
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
        let (edge_loops, edge_loops_of) = edge_loops(panels, &corners, &triangles_at);
        Self { loops, edge_loops, fluxes, loops_of, edge_loops_of, fluxes_of, cycles }
    }

    /// Those of `m`: currents, loops about edges, fluxes.
    pub fn count(&self) -> usize {
        self.currents() + self.edge_loops + self.fluxes
    }

    /// Where fluxes begin in `m`.
    pub fn first_flux(&self) -> usize {
        self.currents() + self.edge_loops
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

    /// Numbers in `m` of the loops about edges and the fluxes of a triangle.
    pub fn linear_of(&self, triangle: usize) -> impl Iterator<Item = (usize, &Linear)> {
        let (first_edge, first_flux) = (self.currents(), self.first_flux());
        let edge_loops = self.edge_loops_of[triangle].iter();
        let fluxes = self.fluxes_of[triangle].iter();
        edge_loops
            .map(move |of| (first_edge + of.number, of))
            .chain(fluxes.map(move |of| (first_flux + of.number, of)))
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
        let each = (0..3).filter_map(|corner| {
            let current = along(panel, corner) / (2.0 * panel.area_mm2());
            Some(Loop { number: number[own[corner]]?, corner, current })
        });
        each.collect()
    };
    (kept.len(), corners.iter().zip(surface.panels()).map(of).collect())
}

/// About edges that are the longest of both their triangles. Edges but a fiftieth shorter than the longest count: the
/// cells of a ring are trapezia.
fn edge_loops(
    panels: &[Panel],
    corners: &[[usize; 3]],
    triangles_at: &HashMap<[usize; 2], Vec<usize>>,
) -> (usize, Vec<Vec<Linear>>) {
    let mut edges_of: Vec<[usize; 2]> = triangles_at.keys().copied().collect();
    edges_of.sort_unstable();
    let mut loops_of = vec![Vec::new(); panels.len()];
    let mut count = 0;
    for edge in edges_of {
        let both = &triangles_at[&edge];
        let opposite = |t: usize| (0..3).find(|k| !edge.contains(&corners[t][*k])).unwrap_or(0);
        let is_long = |t: usize| {
            let lengths = panels[t].edges_mm();
            let longest = lengths.iter().fold(0.0, |most: f64, length| most.max(*length));
            let own = lengths[(opposite(t) + 1) % 3];
            own > 0.98 * longest
        };
        if !both.iter().all(|t| is_long(*t)) {
            continue;
        }
        for &t in both {
            let (panel, k) = (&panels[t], opposite(t));
            let about = |corner: usize| along(panel, corner) * (2.0 / panel.area_mm2());
            let mut at_corners = [Vector3::zeros(); 3];
            at_corners[(k + 1) % 3] = about((k + 2) % 3);
            at_corners[(k + 2) % 3] = about((k + 1) % 3);
            loops_of[t].push(Linear { number: count, at_corners, divergence: 0.0 });
        }
        count += 1;
    }
    (count, loops_of)
}

/// The edge opposite to a corner, as currents about the corner flow.
fn along(panel: &Panel, corner: usize) -> Vector3<f64> {
    let at = panel.corners_mm();
    at[(corner + 1) % 3] - at[(corner + 2) % 3]
}

fn fluxes(
    panels: &[Panel],
    corners: &[[usize; 3]],
    triangles_at: &HashMap<[usize; 2], Vec<usize>>,
) -> (usize, Vec<Vec<Linear>>, Tree) {
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
                    let panel = &panels[triangle];
                    let at = panel.corners_mm();
                    let from = at[opposite.unwrap_or(0)];
                    let divergence = sign / panel.area_mm2();
                    let at_corners = at.map(|corner| (corner - from) * (0.5 * divergence));
                    fluxes_of[triangle].push(Linear { number: count, at_corners, divergence });
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
            let flux = each.map(|(own, panel)| {
                own.iter().map(|f| f.divergence).sum::<f64>() * panel.area_mm2()
            });
            assert!(flux.sum::<f64>().abs() < 1e-12);
        }
    }

    #[test]
    fn loops_about_diagonals_turn_fluxes() {
        let mesh = cuboid(&Vector3::new(90.0, 80.0, 2.0), 200).unwrap();
        let surface = ClosedSurface::new(&mesh).unwrap();
        let found = Functions::new(&surface);
        let mut count = 0;
        for (own, panel) in found.edge_loops_of.iter().zip(surface.panels()) {
            for edge_loop in own {
                // From the right angle a unit of divergence is half along each leg; a loop moves it from one to the
                // other.
                let at = panel.corners_mm();
                let right = (0..3).find(|k| edge_loop.at_corners[*k].norm() == 0.0).unwrap();
                for (sign, leg) in [(1.0, (right + 2) % 3), (-1.0, (right + 1) % 3)] {
                    let leg = at[leg] - at[right];
                    let across = |k: usize| {
                        let turned = edge_loop.at_corners[k] * (0.25 * sign * panel.area_mm2());
                        let flux = (at[k] - at[right]) * 0.5 + turned;
                        flux.cross(&leg).norm() / leg.norm()
                    };
                    assert!((0..3).all(|k| across(k) < 1e-12 * panel.radius_mm()), "{sign}");
                }
                count += 1;
            }
        }
        assert!(count > 100 && count == 2 * found.edge_loops, "{count}");
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
