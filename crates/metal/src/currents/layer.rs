//! A layer of a body in which currents flow in closed loops: triangles over an outline, with a stream
//! function that is linear on each and 0 on the outline.

use super::slice::middle;
use nalgebra::{Point2, Vector2};

/// Rings and layers are nearer to each other towards a body's surface, where currents of a small skin depth flow: of
/// eight rings the last is 1/180 of the way from the middle.
const GRADING: f64 = 2.5;

/// From 0 to 1, slower towards the end.
pub(super) fn graded(part: f64) -> f64 {
    1.0 - (1.0 - part).powf(GRADING)
}

/// A layer between two heights.
#[derive(Clone, Debug)]
pub(super) struct Layer {
    pub heights_mm: [f64; 2],
    /// Nodes inside the outline: those whose stream function is free, the first ones of all.
    pub free: usize,
    pub triangles: Vec<Triangle>,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Triangle {
    pub nodes: [usize; 3],
    pub corners_mm: [Point2<f64>; 3],
    pub center_mm: Point2<f64>,
    pub area_mm2: f64,
    /// Largest distance of a corner from the middle.
    pub radius_mm: f64,
    /// Gradients of the nodes' shape functions.
    pub gradients: [Vector2<f64>; 3],
}

impl Layer {
    /// Rings about the middle, alike to the outline and nearer to each other towards it.
    pub fn new(outline: &[Point2<f64>], rings: usize, heights_mm: [f64; 2]) -> Option<Self> {
        let (count, middle) = (outline.len(), middle(outline));
        let mut nodes = vec![middle];
        for ring in 1..=rings {
            let part = graded(ring as f64 / rings as f64);
            nodes.extend(outline.iter().map(|p| middle + (p - middle) * part));
        }
        let node = |ring: usize, k: usize| 1 + (ring - 1) * count + k % count;
        let mut triangles: Vec<[usize; 3]> =
            (0..count).map(|k| [0, node(1, k), node(1, k + 1)]).collect();
        for ring in 1..rings {
            for k in 0..count {
                let (a, b) = (node(ring, k), node(ring, k + 1));
                let (d, c) = (node(ring + 1, k), node(ring + 1, k + 1));
                let is_first = (nodes[a] - nodes[c]).norm() < (nodes[b] - nodes[d]).norm();
                let halves = if is_first { [[a, d, c], [a, c, b]] } else { [[a, d, b], [d, c, b]] };
                triangles.extend(halves);
            }
        }
        let triangles = triangles.into_iter().map(|own| Triangle::new(own, &nodes));
        let triangles = triangles.collect::<Option<_>>()?;
        Some(Self { heights_mm, free: nodes.len() - count, triangles })
    }

    pub fn thickness_mm(&self) -> f64 {
        self.heights_mm[1] - self.heights_mm[0]
    }

    pub fn middle_mm(&self) -> f64 {
        0.5 * (self.heights_mm[0] + self.heights_mm[1])
    }
}

impl Triangle {
    /// `None` where it has no area, or is turned over.
    fn new(nodes: [usize; 3], all: &[Point2<f64>]) -> Option<Self> {
        let corners_mm = nodes.map(|node| all[node]);
        let [a, b, c] = corners_mm;
        let twice = (b - a).perp(&(c - a));
        let center_mm = Point2::from((a.coords + b.coords + c.coords) / 3.0);
        let radius_mm = corners_mm.iter().map(|p| (p - center_mm).norm()).fold(0.0, f64::max);
        let gradients = [c - b, a - c, b - a].map(|edge| Vector2::new(-edge.y, edge.x) / twice);
        let area_mm2 = 0.5 * twice;
        (twice > 0.0).then_some(Self {
            nodes,
            corners_mm,
            center_mm,
            area_mm2,
            radius_mm,
            gradients,
        })
    }

    /// Three points of the same weight that integrate what is of the second degree.
    pub fn rule_mm(&self) -> [Point2<f64>; 3] {
        self.corners_mm.map(|corner| nalgebra::center(&corner, &self.center_mm))
    }

    /// `∫ 1/R` over the triangle, from a point so far above its plane
    /// (Wilton et al., IEEE Trans. Antennas and Propagation 32(3), 1984).
    pub fn potential_mm(&self, p: &Point2<f64>, height_mm: f64) -> f64 {
        let to_corners = self.corners_mm.map(|corner| corner - p);
        let norms = to_corners.map(|v| v.norm().hypot(height_mm));
        let mut sum = 0.0;
        for k in 0..3 {
            let next = (k + 1) % 3;
            let edge = to_corners[next] - to_corners[k];
            let (length, ends) = (edge.norm(), norms[k] + norms[next]);
            let rest = (ends - length).max(f64::EPSILON * length);
            let inside_mm = to_corners[k].perp(&edge) / length;
            sum += inside_mm * ((ends + length) / rest).ln();
        }
        sum - height_mm * self.solid_angle(&to_corners, &norms, height_mm)
    }

    /// Van Oosterom and Strackee, IEEE Trans. Biomedical Engineering 30(2), 1983.
    fn solid_angle(&self, to_corners: &[Vector2<f64>; 3], norms: &[f64; 3], height_mm: f64) -> f64 {
        let [a, b, c] = to_corners;
        let [ra, rb, rc] = *norms;
        let height2 = height_mm * height_mm;
        let dot = |u: &Vector2<f64>, v: &Vector2<f64>| u.dot(v) + height2;
        let volume = height_mm * 2.0 * self.area_mm2;
        let below = ra * rb * rc + dot(a, b) * rc + dot(b, c) * ra + dot(c, a) * rb;
        (2.0 * volume.atan2(below)).abs()
    }
}
