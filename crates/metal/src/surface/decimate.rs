//! Fewer triangles of the same closed shape: edges become points where that moves the surface least.
//!
//! Quadric error metrics (Garland and Heckbert, Surface Simplification Using Quadric Error Metrics, 1997).
//! An edge is collapsed only where its ends have exactly two common neighbours (the link condition), so
//! that a closed surface stays closed, and only where no triangle turns over.

use super::Indexed;
use nalgebra::{Matrix3, Point3, Vector3};
use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};
use trackwright_task::{Cancelled, Task};

/// Weight of the distance from where corners were beside the distance from their planes: spreads the
/// corners of flat faces evenly, which boundary elements need, and hardly moves curved ones.
const SPREAD: f64 = 1e-3;

/// Cosine of the largest angle that a triangle may turn by in one collapse.
const MIN_COSINE: f64 = 0.3;

/// Least ratio of a triangle's doubled area to its longest side squared after a collapse, unless it was
/// less before.
const MIN_SHAPE: f64 = 0.05;

/// Squared distance to planes, `xᵀ A x − 2 bᵀ x + c`.
#[derive(Clone, Copy, Default)]
struct Quadric {
    a: Matrix3<f64>,
    b: Vector3<f64>,
    c: f64,
}

impl Quadric {
    fn add(&mut self, other: &Self) {
        self.a += other.a;
        self.b += other.b;
        self.c += other.c;
    }

    fn at(&self, x: &Vector3<f64>) -> f64 {
        (x.dot(&(self.a * x)) - 2.0 * self.b.dot(x) + self.c).max(0.0)
    }
}

/// A collapse that may be next: its cost as an ordered number, the edge, and how often its ends had
/// changed when it was computed.
type Candidate = Reverse<(u64, [u32; 2], [u32; 2])>;

/// Collapses between two looks at the task: some tenths of a millisecond.
const COLLAPSES_A_STEP: usize = 64;

struct Surface {
    positions: Vec<Vector3<f64>>,
    quadrics: Vec<Quadric>,
    triangles: Vec<[u32; 3]>,
    is_alive: Vec<bool>,
    /// Living triangles of each corner.
    around: Vec<Vec<u32>>,
    changes: Vec<u32>,
}

/// A closed mesh with at most `most` triangles, or with the fewest that collapses lead to.
///
/// # Errors
/// [`Cancelled`].
pub fn decimated(
    positions_mm: &[Point3<f64>],
    triangles: &[[u32; 3]],
    most: usize,
    task: &Task,
) -> Result<Indexed, Cancelled> {
    let mut surface = Surface::new(positions_mm, triangles);
    let mut candidates: BinaryHeap<Candidate> = BinaryHeap::new();
    for &[a, b, c] in triangles {
        for [from, to] in [[a, b], [b, c], [c, a]] {
            if from < to {
                candidates.push(surface.candidate([from, to]));
            }
        }
    }
    let mut count = triangles.len();
    for tried in 0.. {
        if count <= most {
            break;
        }
        if tried % COLLAPSES_A_STEP == 0 {
            task.step(triangles.len() - count, triangles.len() - most)?;
        }
        let Some(Reverse((_, edge, changes))) = candidates.pop() else { break };
        if edge.map(|end| surface.changes[end as usize]) != changes {
            continue;
        }
        let Some(kept) = surface.collapse(edge) else { continue };
        count -= 2;
        for neighbour in surface.neighbours(kept) {
            candidates.push(surface.candidate([kept.min(neighbour), kept.max(neighbour)]));
        }
    }
    Ok(surface.compacted())
}

impl Surface {
    fn new(positions_mm: &[Point3<f64>], triangles: &[[u32; 3]]) -> Self {
        let positions: Vec<Vector3<f64>> = positions_mm.iter().map(|p| p.coords).collect();
        let mut quadrics = vec![Quadric::default(); positions.len()];
        let mut around = vec![Vec::new(); positions.len()];
        for (index, triangle) in triangles.iter().enumerate() {
            let [a, b, c] = triangle.map(|i| positions[i as usize]);
            let cross = (b - a).cross(&(c - a));
            let area = 0.5 * cross.norm();
            let normal = cross.try_normalize(f64::MIN_POSITIVE).unwrap_or_default();
            let along = normal.dot(&a);
            for corner in triangle {
                let x = positions[*corner as usize];
                quadrics[*corner as usize].add(&Quadric {
                    a: (normal * normal.transpose() + Matrix3::identity() * SPREAD) * area,
                    b: (normal * along + x * SPREAD) * area,
                    c: (along * along + x.norm_squared() * SPREAD) * area,
                });
                around[*corner as usize].push(index as u32);
            }
        }
        let (count, corners) = (triangles.len(), positions.len());
        Self {
            positions,
            quadrics,
            triangles: triangles.to_vec(),
            is_alive: vec![true; count],
            around,
            changes: vec![0; corners],
        }
    }

    /// Where an edge's ends go together, and what that costs.
    fn target(&self, edge: [u32; 2]) -> (Vector3<f64>, f64) {
        let [one, other] = edge.map(|end| self.quadrics[end as usize]);
        let mut sum = one;
        sum.add(&other);
        // Spread makes the matrix positive definite.
        let middle = || {
            let [a, b] = edge.map(|end| self.positions[end as usize]);
            (a + b) * 0.5
        };
        let x = sum.a.cholesky().map_or_else(middle, |factor| factor.solve(&sum.b));
        (x, sum.at(&x))
    }

    fn candidate(&self, edge: [u32; 2]) -> Candidate {
        let cost = self.target(edge).1;
        // Numbers above zero are ordered as their bits are; the edge decides between equals.
        Reverse((cost.to_bits(), edge, edge.map(|end| self.changes[end as usize])))
    }

    fn neighbours(&self, corner: u32) -> Vec<u32> {
        let triangles = self.around[corner as usize].iter();
        let corners = triangles.flat_map(|&t| self.triangles[t as usize]);
        let mut found: Vec<u32> = corners.filter(|other| *other != corner).collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Collapses an edge into its first end, where it may be.
    fn collapse(&mut self, edge: [u32; 2]) -> Option<u32> {
        let [kept, lost] = edge;
        let ring = self.neighbours(kept);
        let common = self.neighbours(lost).iter().filter(|n| ring.contains(n)).count();
        let of_both = |t: &u32| {
            let corners = self.triangles[*t as usize];
            corners.contains(&kept) && corners.contains(&lost)
        };
        let gone: Vec<u32> = self.around[kept as usize].iter().copied().filter(of_both).collect();
        // A tetrahedron has no edge to lose.
        if common != 2 || gone.len() != 2 || ring.len() < 4 {
            return None;
        }
        let (target, _) = self.target(edge);
        let moves = edge.iter().flat_map(|end| &self.around[*end as usize]);
        for &t in moves.filter(|t| !gone.contains(t)) {
            let corners = self.triangles[t as usize];
            let old = corners.map(|corner| self.positions[corner as usize]);
            let new = corners.map(|corner| match edge.contains(&corner) {
                true => target,
                false => self.positions[corner as usize],
            });
            let ([old_normal, new_normal], [old_shape, new_shape]) =
                ([normal(&old), normal(&new)], [shape(&old), shape(&new)]);
            let cosine = old_normal.dot(&new_normal) / (old_normal.norm() * new_normal.norm());
            // A triangle without an area has no cosine.
            let turns = !(cosine > MIN_COSINE || old_normal.norm() == 0.0);
            if turns || (new_shape < MIN_SHAPE && new_shape < old_shape) {
                return None;
            }
        }
        let lost_quadric = self.quadrics[lost as usize];
        self.quadrics[kept as usize].add(&lost_quadric);
        self.positions[kept as usize] = target;
        for &t in &gone {
            self.is_alive[t as usize] = false;
            for corner in self.triangles[t as usize] {
                self.around[corner as usize].retain(|other| *other != t);
            }
        }
        for t in std::mem::take(&mut self.around[lost as usize]) {
            for corner in &mut self.triangles[t as usize] {
                if *corner == lost {
                    *corner = kept;
                }
            }
            self.around[kept as usize].push(t);
        }
        self.changes[kept as usize] += 1;
        self.changes[lost as usize] += 1;
        Some(kept)
    }

    fn compacted(self) -> Indexed {
        let mut numbers: HashMap<u32, u32> = HashMap::new();
        let mut positions_mm = Vec::new();
        let alive = self.triangles.iter().zip(&self.is_alive).filter(|(_, alive)| **alive);
        let triangles = alive.map(|(triangle, _)| {
            triangle.map(|corner| {
                *numbers.entry(corner).or_insert_with(|| {
                    positions_mm.push(Point3::from(self.positions[corner as usize]));
                    positions_mm.len() as u32 - 1
                })
            })
        });
        let triangles = triangles.collect();
        (positions_mm, triangles)
    }
}

fn normal([a, b, c]: &[Vector3<f64>; 3]) -> Vector3<f64> {
    (b - a).cross(&(c - a))
}

fn shape(corners: &[Vector3<f64>; 3]) -> f64 {
    let [a, b, c] = corners;
    let longest2 = [b - a, c - b, a - c].map(|side| side.norm_squared()).into_iter();
    normal(corners).norm() / longest2.fold(f64::MIN_POSITIVE, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::sphere;

    #[test]
    fn a_sphere_stays_closed_and_round() {
        let part = &sphere(50.0, 5).unwrap().parts[0];
        for most in [2000, 500, 100] {
            let found = decimated(&part.positions_mm, &part.triangles, most, &Task::default());
            let (positions, triangles) = found.unwrap();
            assert!((most - 1..=most).contains(&triangles.len()), "{}", triangles.len());
            // Euler's formula of a closed surface without holes.
            assert_eq!(positions.len(), triangles.len() / 2 + 2);
            let radii = positions.iter().map(|p| p.coords.norm());
            let worst = radii.map(|r| (r / 50.0 - 1.0).abs()).fold(0.0, f64::max);
            // Corners are where planes of the old triangles meet, outside by up to the sagitta of an
            // edge: 1/8 of its square, which is 29/most of the squared radius in the mean.
            assert!(worst < 2.0 * 29.0 / 8.0 / most as f64, "{most} {worst}");
        }
    }
}
