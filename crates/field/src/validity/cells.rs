//! Where samples are: occupied cells of a lattice with the directions that have samples in them,
//! and the nearest to a point.

use super::fit_validity::FitValidityPartsError;
use nalgebra::Point3;
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::limits::{length_problem, position_problem};

/// Cells kept at most, so that the samples' places stay small in a file: some 100 kB of text.
pub const MAX_CELLS: usize = 4096;

/// Cells along the samples' longest extent at most, as a power of two: 0.12 mm in 500 mm.
const FINEST_LEVEL: u32 = 12;

/// A cell of the lattice, and a bit for each direction with a sample in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Cell {
    pub index: [u32; 3],
    pub directions: u64,
}

/// Occupied cells, the finest lattice that has at most [`MAX_CELLS`] of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Cells {
    origin_mm: Point3<f64>,
    edge_mm: f64,
    cells: Vec<Cell>,
    tree: Tree,
}

impl Default for Cells {
    fn default() -> Self {
        Self::new(Point3::origin(), 0.0, Vec::new())
    }
}

impl Cells {
    /// Cells of a lattice, with the tree that searches them.
    pub fn new(origin_mm: Point3<f64>, edge_mm: f64, cells: Vec<Cell>) -> Self {
        let mut found = Self { origin_mm, edge_mm, cells, tree: Tree::new(Vec::new()) };
        let points = found.cells.iter().map(|c| (found.center_mm(c), c.directions));
        found.tree = Tree::new(points.collect());
        found
    }

    /// Middle of a cell, tracker frame.
    pub(super) fn center_mm(&self, cell: &Cell) -> Point3<f64> {
        let along = |k: usize| self.edge_mm * (f64::from(cell.index[k]) + 0.5);
        Point3::from(std::array::from_fn(|k| self.origin_mm[k] + along(k)))
    }

    /// Thins samples, each with the bits of its directions.
    pub fn thinned(samples: impl Iterator<Item = (Point3<f64>, u64)> + Clone) -> Self {
        let Some(bounds) = Bounds::around(samples.clone().map(|(p, _)| p)) else {
            return Self::default();
        };
        let extent = bounds.size_mm().max();
        let last = (1_u32 << FINEST_LEVEL) - 1;
        let finest_mm = extent / f64::from(last + 1);
        let mut cells: Vec<Cell> = samples
            .map(|(p, directions)| {
                let from_min = p - bounds.min_mm;
                let index = std::array::from_fn(|k| match from_min[k] / finest_mm {
                    // All samples in one place.
                    i if i.is_nan() => 0,
                    i => (i as u32).min(last),
                });
                Cell { index, directions }
            })
            .collect();
        merge(&mut cells);
        let mut level = 0;
        while cells.len() > MAX_CELLS {
            level += 1;
            for cell in &mut cells {
                cell.index = cell.index.map(|i| i / 2);
            }
            merge(&mut cells);
        }
        Self::new(bounds.min_mm, finest_mm * f64::from(1_u32 << level), cells)
    }

    /// Corner of the lattice, tracker frame.
    pub fn origin_mm(&self) -> Point3<f64> {
        self.origin_mm
    }

    /// Edge of a cell.
    pub fn edge_mm(&self) -> f64 {
        self.edge_mm
    }

    /// The occupied cells.
    pub fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// How far a distance may be off: half a cell's diagonal.
    pub fn resolution_mm(&self) -> f64 {
        self.edge_mm * 0.75_f64.sqrt()
    }

    /// To the nearest sample of a direction, to within [`Self::resolution_mm`]; infinite where
    /// there is none.
    pub fn distance_mm(&self, position_mm: &Point3<f64>, direction: usize) -> f64 {
        self.tree.nearest_squared(position_mm, 1 << direction).sqrt()
    }

    pub(super) fn check(&self, directions: usize) -> Result<(), FitValidityPartsError> {
        let name = "cells";
        if self.cells.len() > MAX_CELLS {
            return Err(FitValidityPartsError::Count {
                name,
                found: self.cells.len(),
                expected: MAX_CELLS,
            });
        }
        let wrong = |found, expected| Err(FitValidityPartsError::Value { name, found, expected });
        if length_problem(self.edge_mm).is_some() {
            return wrong(self.edge_mm, "an edge in mm, at most 1e6");
        }
        let is_wrong = |v: &&f64| position_problem([*v]).is_some();
        if let Some(&found) = self.origin_mm.iter().find(is_wrong) {
            return wrong(found, "an origin of at most 1e6 mm");
        }
        match self.cells.iter().find(|c| c.directions >> directions != 0) {
            Some(c) => wrong(c.directions as f64, "bits of the model's directions"),
            None => Ok(()),
        }
    }
}

/// Sorts, and makes one of those in the same place.
fn merge(cells: &mut Vec<Cell>) {
    cells.sort_unstable();
    cells.dedup_by(|next, kept| {
        let is_same = next.index == kept.index;
        if is_same {
            kept.directions |= next.directions;
        }
        is_same
    });
}

/// A k-d tree whose nodes know which directions are below them. The middle of a range is its
/// node; the halves beside it are its children.
#[derive(Clone, Debug, PartialEq)]
struct Tree {
    points: Vec<(Point3<f64>, u64)>,
    /// Directions of each node and all below it.
    below: Vec<u64>,
}

impl Tree {
    fn new(mut points: Vec<(Point3<f64>, u64)>) -> Self {
        let mut below = vec![0; points.len()];
        arrange(&mut points, &mut below, 0);
        Self { points, below }
    }

    fn nearest_squared(&self, at: &Point3<f64>, direction: u64) -> f64 {
        let mut best = f64::INFINITY;
        self.search(0, self.points.len(), 0, at, direction, &mut best);
        best
    }

    fn search(
        &self,
        from: usize,
        to: usize,
        axis: usize,
        at: &Point3<f64>,
        direction: u64,
        best: &mut f64,
    ) {
        if from == to {
            return;
        }
        let node = from + (to - from) / 2;
        if self.below[node] & direction == 0 {
            return;
        }
        let (point, directions) = &self.points[node];
        if directions & direction != 0 {
            *best = best.min((at - point).norm_squared());
        }
        let beyond = at[axis] - point[axis];
        let (near, far) = if beyond < 0.0 {
            ((from, node), (node + 1, to))
        } else {
            ((node + 1, to), (from, node))
        };
        let next = (axis + 1) % 3;
        self.search(near.0, near.1, next, at, direction, best);
        if beyond * beyond < *best {
            self.search(far.0, far.1, next, at, direction, best);
        }
    }
}

/// Puts the median along `axis` in the middle, and so on in both halves.
fn arrange(points: &mut [(Point3<f64>, u64)], below: &mut [u64], axis: usize) -> u64 {
    if points.is_empty() {
        return 0;
    }
    let middle = points.len() / 2;
    points.select_nth_unstable_by(middle, |a, b| a.0[axis].total_cmp(&b.0[axis]));
    let (left, rest) = points.split_at_mut(middle);
    let (left_below, rest_below) = below.split_at_mut(middle);
    let next = (axis + 1) % 3;
    let all = rest[0].1
        | arrange(left, left_below, next)
        | arrange(&mut rest[1..], &mut rest_below[1..], next);
    rest_below[0] = all;
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points spread over a box, with one to three of five directions each.
    fn samples(count: usize) -> Vec<(Point3<f64>, u64)> {
        let spread = |i: usize, step: f64| (i as f64 * step + 0.5).fract();
        (0..count)
            .map(|i| {
                let p = Point3::new(
                    300.0 * spread(i, 0.819_172_5),
                    80.0 * spread(i, 0.671_043_6) - 1e3,
                    9.0 * spread(i, 0.549_700_5),
                );
                (p, 1 << (i % 5) | 1 << (i % 3))
            })
            .collect()
    }

    fn nearest(samples: &[(Point3<f64>, u64)], at: &Point3<f64>, direction: usize) -> f64 {
        samples
            .iter()
            .filter(|(_, bits)| bits >> direction & 1 == 1)
            .map(|(p, _)| (p - at).norm())
            .fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn tree_distances_are_those_of_a_full_search() {
        for count in [1, 2, 17, 1000, 60_000] {
            let samples = samples(count);
            let cells = Cells::thinned(samples.iter().copied());
            assert!(cells.cells().len() <= MAX_CELLS.min(count));
            for (i, at) in self::samples(50).into_iter().enumerate() {
                let at = at.0 * 1.5;
                for direction in 0..6 {
                    let (found, exact) =
                        (cells.distance_mm(&at, direction), nearest(&samples, &at, direction));
                    let is_close = found == exact || (found - exact).abs() <= cells.resolution_mm();
                    assert!(is_close, "{count} {i} {direction}: {found} {exact}");
                }
            }
        }
    }

    #[test]
    fn samples_in_one_place_are_one_cell_there() {
        let place = Point3::new(1.0, 2.0, 3.0);
        let cells = Cells::thinned([(place, 1), (place, 4)].into_iter());
        assert_eq!(cells.cells(), [Cell { index: [0; 3], directions: 5 }]);
        assert_eq!(cells.distance_mm(&Point3::new(1.0, 2.0, 8.0), 2), 5.0);
        assert_eq!(cells.distance_mm(&place, 1), f64::INFINITY);
    }
}
