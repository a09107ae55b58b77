//! What a mesh covers on paper: its triangles on a raster, and the raster's borders as polygons.
//!
//! Exact to half a raster cell, which callers choose finer than a line of the drawing is wide.

use std::collections::HashMap;

/// Most cells along either side of a raster.
const MOST_CELLS: f64 = 1400.0;

/// How far a border may be from its polygon, in cells: more than the √2 that the steps of a slant line
/// can be off a line between two of them, less than anything one would see.
const SIMPLIFICATION_CELLS: f64 = 1.5;

/// Rings around what the triangles cover, in the units of their corners: filled by the even-odd
/// rule, holes are rings too. `cell` is the raster's width, made wider where the raster would be
/// too large.
pub fn silhouette(triangles: &[[[f64; 2]; 3]], cell: f64) -> Vec<Vec<[f64; 2]>> {
    let Some(raster) = Raster::of(triangles, cell) else {
        return Vec::new();
    };
    raster
        .borders()
        .into_iter()
        .map(|ring| simplified(&ring).into_iter().map(|at| raster.place(at)).collect())
        .collect()
}

/// Cells that are covered or not.
struct Raster {
    origin: [f64; 2],
    cell: f64,
    size: [usize; 2],
    covered: Vec<bool>,
}

impl Raster {
    fn of(triangles: &[[[f64; 2]; 3]], cell: f64) -> Option<Self> {
        let mut low = [f64::INFINITY; 2];
        let mut high = [f64::NEG_INFINITY; 2];
        for corner in triangles.iter().flatten().filter(|c| c.iter().all(|v| v.is_finite())) {
            for k in 0..2 {
                low[k] = low[k].min(corner[k]);
                high[k] = high[k].max(corner[k]);
            }
        }
        let extent = (high[0] - low[0]).max(high[1] - low[1]);
        if !extent.is_finite() || cell <= 0.0 {
            return None;
        }
        let cell = cell.max(extent / MOST_CELLS);
        // A free cell all around, so that every border closes.
        let origin = low.map(|v| v - 1.5 * cell);
        let size = [0, 1].map(|k| ((high[k] - low[k]) / cell) as usize + 4);
        let mut raster = Self { origin, cell, size, covered: vec![false; size[0] * size[1]] };
        for triangle in triangles {
            if triangle.iter().flatten().all(|v| v.is_finite()) {
                raster.cover(&triangle.map(|corner| raster.cells(corner)));
            }
        }
        Some(raster)
    }

    /// A point in cells; the middle of cell (i, j) is there.
    fn cells(&self, point: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|k| (point[k] - self.origin[k]) / self.cell - 0.5)
    }

    /// A corner between cells in the units of the triangles.
    fn place(&self, corner: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|k| self.origin[k] + corner[k] * self.cell)
    }

    fn cover(&mut self, triangle: &[[f64; 2]; 3]) {
        let [a, b, c] = *triangle;
        let area = cross(a, b, c);
        let size = self.size;
        let range = |k: usize| {
            let low = a[k].min(b[k]).min(c[k]).ceil().max(0.0) as usize;
            let high = a[k].max(b[k]).max(c[k]).floor().max(0.0) as usize;
            low..=high.min(size[k] - 1)
        };
        // A triangle on edge covers its edges alone.
        let rows = range(1).filter(|_| area != 0.0);
        for j in rows {
            for i in range(0) {
                let at = [i as f64, j as f64];
                let sides = [cross(a, b, at), cross(b, c, at), cross(c, a, at)];
                if sides.iter().all(|side| side * area >= 0.0) {
                    self.mark(at);
                }
            }
        }
        // What is thinner than a cell still leaves a line.
        for [from, to] in [[a, b], [b, c], [c, a]] {
            let steps = (to[0] - from[0]).abs().max((to[1] - from[1]).abs()).ceil();
            for step in 0..=steps as usize {
                let part = if steps > 0.0 { step as f64 / steps } else { 0.0 };
                self.mark([0, 1].map(|k| from[k] + (to[k] - from[k]) * part));
            }
        }
    }

    fn mark(&mut self, at: [f64; 2]) {
        let [i, j] = at.map(|v| v.round().max(0.0) as usize);
        if i < self.size[0] && j < self.size[1] {
            self.covered[j * self.size[0] + i] = true;
        }
    }

    fn is_covered(&self, [i, j]: [usize; 2]) -> bool {
        self.covered[j * self.size[0] + i]
    }

    /// Closed paths along the sides between covered and free cells, covered on the left.
    fn borders(&self) -> Vec<Vec<[f64; 2]>> {
        // From each corner of cells the ones that a side leads to: two where cells meet by a corner.
        let mut next: HashMap<[usize; 2], Vec<[usize; 2]>> = HashMap::new();
        let mut starts = Vec::new();
        let mut side = |from: [usize; 2], to: [usize; 2]| {
            next.entry(from).or_default().push(to);
            starts.push(from);
        };
        for j in 1..self.size[1] - 1 {
            for i in 1..self.size[0] - 1 {
                if !self.is_covered([i, j]) {
                    continue;
                }
                for (neighbour, from, to) in [
                    ([i, j - 1], [i, j], [i + 1, j]),
                    ([i + 1, j], [i + 1, j], [i + 1, j + 1]),
                    ([i, j + 1], [i + 1, j + 1], [i, j + 1]),
                    ([i - 1, j], [i, j + 1], [i, j]),
                ] {
                    if !self.is_covered(neighbour) {
                        side(from, to);
                    }
                }
            }
        }
        let mut rings = Vec::new();
        for start in starts {
            let mut ring = Vec::new();
            let mut at = start;
            while let Some(to) = next.get_mut(&at).and_then(Vec::pop) {
                ring.push(at.map(|v| v as f64));
                at = to;
            }
            if ring.len() > 3 {
                rings.push(ring);
            }
        }
        rings
    }
}

/// Twice the area of a triangle, positive counter-clockwise.
fn cross(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// A ring with the fewest of its corners that stay close to all of them (Douglas and Peucker,
/// Cartographica 10(2), 1973), each half between two far corners by itself.
fn simplified(ring: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let far = ring
        .iter()
        .enumerate()
        .max_by(|a, b| distance(*a.1, ring[0]).total_cmp(&distance(*b.1, ring[0])))
        .map_or(0, |(index, _)| index);
    let mut closed = ring.to_vec();
    closed.push(ring[0]);
    let mut is_kept = vec![false; closed.len()];
    is_kept[0] = true;
    is_kept[far] = true;
    let mut open = vec![(0, far), (far, closed.len() - 1)];
    while let Some((from, to)) = open.pop() {
        let farthest = (from + 1..to)
            .map(|k| (k, off(closed[k], closed[from], closed[to])))
            .max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((k, distance)) = farthest
            && distance > SIMPLIFICATION_CELLS
        {
            is_kept[k] = true;
            open.extend([(from, k), (k, to)]);
        }
    }
    let kept = ring.iter().zip(&is_kept);
    kept.filter(|(_, is_kept)| **is_kept).map(|(at, _)| *at).collect()
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Distance of a point from a line segment.
fn off(point: [f64; 2], from: [f64; 2], to: [f64; 2]) -> f64 {
    let length = distance(from, to);
    if length == 0.0 {
        return distance(point, from);
    }
    let along = ((point[0] - from[0]) * (to[0] - from[0])
        + (point[1] - from[1]) * (to[1] - from[1]))
        / (length * length);
    let part = along.clamp(0.0, 1.0);
    distance(point, [0, 1].map(|k| from[k] + (to[k] - from[k]) * part))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(rings: &[Vec<[f64; 2]>]) -> f64 {
        rings
            .iter()
            .map(|ring| {
                let turned = ring.iter().cycle().skip(1);
                let twice: f64 =
                    ring.iter().zip(turned).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum();
                twice / 2.0
            })
            .sum()
    }

    /// A disc with a round hole, as triangles.
    fn washer(outer: f64, inner: f64) -> Vec<[[f64; 2]; 3]> {
        let at = |k: usize, r: f64| {
            let angle = std::f64::consts::TAU * k as f64 / 180.0;
            [7.0 + r * angle.cos(), -3.0 + r * angle.sin()]
        };
        (0..180)
            .flat_map(|k| {
                let [a, b] = [at(k, inner), at(k, outer)];
                let [c, d] = [at(k + 1, inner), at(k + 1, outer)];
                [[a, b, d], [a, d, c]]
            })
            .collect()
    }

    #[test]
    fn a_washer_is_a_ring_and_a_hole_of_its_own_area() {
        let rings = silhouette(&washer(10.0, 4.0), 0.02);
        assert_eq!(rings.len(), 2);
        // Half a cell, more where edges are marked, along both circles.
        let expected = std::f64::consts::PI * (100.0 - 16.0);
        let slack = std::f64::consts::TAU * 14.0 * 0.03;
        assert!((area(&rings) - expected).abs() < slack, "{}", area(&rings));
        for ring in &rings {
            assert!(ring.len() < 200, "{}", ring.len());
        }
        // The hole runs the other way around.
        let mut each: Vec<f64> = rings.iter().map(|r| area(std::slice::from_ref(r))).collect();
        each.sort_by(f64::total_cmp);
        assert!(each[0] < 0.0 && each[1] > 0.0);
    }

    #[test]
    fn a_thin_needle_is_drawn_from_end_to_end() {
        let needle = [[[0.0, 0.0], [100.0, 0.001], [100.0, 0.0]]];
        let rings = silhouette(&needle, 0.5);
        let xs = || rings.iter().flatten().map(|at| at[0]);
        let (low, high) = (xs().fold(f64::MAX, f64::min), xs().fold(f64::MIN, f64::max));
        assert!(low.abs() <= 0.5 && (high - 100.0).abs() <= 0.5, "{low} {high}");
    }

    #[test]
    fn empty_and_non_finite_have_no_silhouette() {
        assert!(silhouette(&[], 0.1).is_empty());
        assert!(silhouette(&[[[f64::NAN; 2]; 3]], 0.1).is_empty());
        // A huge mesh makes a coarse raster, not a huge one.
        let huge = [[[0.0, 0.0], [1e12, 0.0], [0.0, 1e12]]];
        assert_eq!(silhouette(&huge, 0.1).len(), 1);
    }
}
