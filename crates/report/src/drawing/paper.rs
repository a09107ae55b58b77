//! From millimetres of a body or a room to pixels of a drawing.

use super::silhouette::silhouette;
use maud::{Markup, html};
use nalgebra::{Point3, Unit, Vector3};
use std::fmt::Write;
use trackwright_geometry::mesh::{MeshPart, SurfaceMesh};
use trackwright_geometry::pose::Pose;

/// A cell of a silhouette's raster, in pixels of the drawing: finer than its lines.
const CELL_PX: f64 = 0.5;

/// A parallel projection onto paper: where a point of the drawn frame comes to lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Paper {
    /// Of the drawn frame, at right angles.
    pub right: Unit<Vector3<f64>>,
    pub up: Unit<Vector3<f64>>,
    pub px_per_mm: f64,
    /// Where the drawn frame's origin is on the drawing.
    pub origin_px: [f64; 2],
}

impl Paper {
    /// A point on the drawing, in pixels.
    pub fn at(&self, point: &Point3<f64>) -> [f64; 2] {
        [
            self.origin_px[0] + self.px_per_mm * self.right.dot(&point.coords),
            self.origin_px[1] - self.px_per_mm * self.up.dot(&point.coords),
        ]
    }

    /// A direction in pixels, y down, and how much of it points at the reader.
    pub fn direction(&self, direction: &Vector3<f64>) -> ([f64; 2], f64) {
        ([self.right.dot(direction), -self.up.dot(direction)], self.towards().dot(direction))
    }

    /// The direction that points at the reader.
    pub fn towards(&self) -> Vector3<f64> {
        self.right.cross(&self.up)
    }
}

/// The silhouettes of a mesh's parts, the farthest first; `frame_from_mesh` puts the mesh into the
/// drawn frame.
pub fn parts(paper: &Paper, mesh: &SurfaceMesh, frame_from_mesh: &Pose) -> Vec<DrawnPart> {
    mesh.parts.iter().filter_map(|part| DrawnPart::of(paper, part, frame_from_mesh)).collect()
}

/// A part of a mesh on paper.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnPart {
    /// Towards the reader, the mean over its corners.
    pub depth_mm: f64,
    pub is_anatomy: bool,
    rings: Vec<Vec<[f64; 2]>>,
}

impl DrawnPart {
    fn of(paper: &Paper, part: &MeshPart, frame_from_mesh: &Pose) -> Option<Self> {
        let towards = paper.towards();
        let points: Vec<Point3<f64>> =
            part.positions_mm.iter().map(|point| frame_from_mesh * point).collect();
        let places: Vec<[f64; 2]> = points.iter().map(|point| paper.at(point)).collect();
        let triangles: Vec<[[f64; 2]; 3]> = part
            .triangles
            .iter()
            .filter_map(|corners| {
                let [a, b, c] = corners.map(|corner| places.get(corner as usize).copied());
                Some([a?, b?, c?])
            })
            .collect();
        let rings = silhouette(&triangles, CELL_PX);
        let depth: f64 = points.iter().map(|point| towards.dot(&point.coords)).sum();
        (!rings.is_empty()).then(|| Self {
            depth_mm: depth / points.len().max(1) as f64,
            is_anatomy: part.is_anatomy(),
            rings,
        })
    }

    /// The silhouette as a path.
    pub fn draw(&self, class: &str) -> Markup {
        let mut path = String::new();
        for ring in &self.rings {
            for (k, [x, y]) in ring.iter().enumerate() {
                // A string takes all that is written to it.
                let _ = write!(path, "{}{x:.1} {y:.1}", if k == 0 { 'M' } else { 'L' });
            }
            path.push('Z');
        }
        html! { path class=(class) fill-rule="evenodd" d=(path) {} }
    }
}

/// A coordinate as it is written.
pub fn px(value: f64) -> String {
    format!("{value:.1}")
}

/// A line between two places.
pub fn line(class: &str, from: [f64; 2], to: [f64; 2]) -> Markup {
    html! { line class=(class) x1=(px(from[0])) y1=(px(from[1])) x2=(px(to[0])) y2=(px(to[1])) {} }
}

/// Text whose anchor is `start`, `middle` or `end` of it.
pub fn text(class: &str, anchor: &str, at: [f64; 2], words: &str) -> Markup {
    html! { text class=(class) text-anchor=(anchor) x=(px(at[0])) y=(px(at[1])) { (words) } }
}
