//! Points of a body that a pointer snaps to: the ends of its shaft, the ends of its edges, and every
//! other corner of its mesh.

use super::gizmo::Eye;
use super::mesh::SurfaceMesh;
use super::orbit::Projection;
use super::surface::{Ray, Surface};
use super::weld::welded;
use nalgebra::{Point3, Unit, Vector3};
use std::collections::HashMap;

/// Faces that meet at more than this make an edge.
const EDGE_RAD: f64 = 30.0 * std::f64::consts::PI / 180.0;

/// What is nearer than this to the farthest corner belongs to the same end, millimetres: more than
/// the rounding of a mesh in single precision.
const END_MM: f64 = 1e-3;

/// And so much more for each millimetre beside it: more than an axis that is found from a mesh is off.
const END_SLOPE: f64 = 5e-4;

/// What lies less than this behind the surface, in pixels, is still seen.
const SEEN_PX: f64 = 1.5;

/// What a point is, the one that is preferred first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum SnapKind {
    /// The middle of an end of the body: of a body of revolution along its axis, of another one along its
    /// longest side.
    ShaftEnd,
    /// A corner at which faces meet at an angle.
    EdgeEnd,
    /// Any other corner of the mesh.
    Vertex,
}

impl SnapKind {
    /// What people call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::ShaftEnd => "shaft end",
            Self::EdgeEnd => "end of an edge",
            Self::Vertex => "vertex",
        }
    }

    /// How near the pointer has to be, in pixels. A fine mesh is dense with corners: between them
    /// the pointer stays free.
    pub fn reach_px(self) -> f64 {
        match self {
            Self::ShaftEnd => 14.0,
            Self::EdgeEnd => 9.0,
            Self::Vertex => 5.0,
        }
    }
}

/// A point that a pointer snaps to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SnapPoint {
    pub kind: SnapKind,
    /// Body frame.
    pub at_mm: Point3<f64>,
}

/// Every point of a body that a pointer snaps to, each place once.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SnapPoints(Vec<SnapPoint>);

impl SnapPoints {
    /// Those of the instrument, without anatomy; `surface` is that of the same mesh.
    pub fn of(mesh: &SurfaceMesh, surface: Option<&Surface>) -> Self {
        let corners = Corners::of(mesh);
        let is_sharp = corners.sharp();
        let longest_side = mesh.long_axis();
        let axis = surface.and_then(|surface| surface.revolution_axis(&longest_side));
        let along = axis.map_or(longest_side, |axis| axis.direction.into_inner());
        let ends = shaft_ends(&corners.places_mm, &along);
        let mut points: Vec<SnapPoint> = ends
            .iter()
            .map(|at_mm| SnapPoint { kind: SnapKind::ShaftEnd, at_mm: *at_mm })
            .collect();
        points.extend(corners.places_mm.iter().zip(is_sharp).map(|(at_mm, is_sharp)| {
            let kind = if is_sharp { SnapKind::EdgeEnd } else { SnapKind::Vertex };
            SnapPoint { kind, at_mm: *at_mm }
        }));
        Self(points)
    }

    /// All of them, the shaft's ends first.
    pub fn iter(&self) -> impl Iterator<Item = &SnapPoint> {
        self.0.iter()
    }

    /// The best one that is within reach of the pointer and that the surface does not hide. The ray
    /// of the pointer is in the body frame; the eye determines what a pixel spans.
    pub fn under(&self, ray: &Ray, eye: &Eye, surface: &Surface) -> Option<SnapPoint> {
        let mut near: Vec<(SnapKind, f64, &SnapPoint)> = self
            .0
            .iter()
            .filter_map(|point| {
                let [along_mm, off_mm] = ray.passes(&[point.at_mm; 2]);
                let off_px = off_mm / eye.mm_per_px_along(along_mm);
                let is_near = along_mm > 0.0 && off_px <= point.kind.reach_px();
                is_near.then_some((point.kind, off_px, point))
            })
            .collect();
        near.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let is_seen = |point: &SnapPoint| {
            // The middle of a round end lies behind its rim where the shaft is seen from the side.
            point.kind == SnapKind::ShaftEnd || is_seen(&point.at_mm, ray, eye, surface)
        };
        near.into_iter().map(|(_, _, point)| *point).find(|point| is_seen(point))
    }
}

/// Whether the surface does not hide a point from where a ray of the pointer comes.
fn is_seen(at_mm: &Point3<f64>, ray: &Ray, eye: &Eye, surface: &Surface) -> bool {
    let sight = match eye.camera.projection {
        Projection::Perspective => match Unit::try_new(at_mm - ray.origin_mm, 1e-9) {
            Some(direction) => Ray { direction, ..*ray },
            None => return true,
        },
        Projection::Orthographic => {
            let far = ray.direction.into_inner() * eye.camera.eye_distance_mm();
            Ray { origin_mm: at_mm - far, ..*ray }
        }
    };
    let distance_mm = (at_mm - sight.origin_mm).norm();
    let slack_mm = SEEN_PX * eye.mm_per_px_along(distance_mm);
    surface.hit(&sight).is_none_or(|hit| hit.distance_mm >= distance_mm - slack_mm)
}

/// Middles of the two ends of corners along a direction: of a round end the point of its axis.
fn shaft_ends(places_mm: &[Point3<f64>], along: &Vector3<f64>) -> Vec<Point3<f64>> {
    let end = |along: Vector3<f64>| {
        let far = |place: &Point3<f64>| place.coords.dot(&along);
        let farthest = places_mm.iter().max_by(|a, b| far(a).total_cmp(&far(b)))?;
        let is_of_end = |place: &Point3<f64>| {
            let between = place - farthest;
            let behind_mm = -between.dot(&along);
            behind_mm <= END_MM + END_SLOPE * between.cross(&along).norm()
        };
        let of_end = places_mm.iter().filter(|place| is_of_end(place));
        let (sum, count) = of_end
            .fold((Vector3::zeros(), 0.0), |(sum, count), place| (sum + place.coords, count + 1.0));
        Some(Point3::from(sum / count))
    };
    [*along, -along].into_iter().filter_map(end).collect()
}

/// The places of a mesh's corners, each once, and the triangles between them.
struct Corners {
    places_mm: Vec<Point3<f64>>,
    triangles: Vec<[usize; 3]>,
}

impl Corners {
    fn of(mesh: &SurfaceMesh) -> Self {
        let (mut positions_mm, mut corners) = (Vec::new(), Vec::new());
        for part in mesh.body_parts() {
            let first = positions_mm.len();
            positions_mm.extend_from_slice(&part.positions_mm);
            corners.extend(part.triangles.iter().map(|t| t.map(|corner| first + corner as usize)));
        }
        let vertices = welded(&positions_mm);
        let mut places_mm: Vec<Point3<f64>> = Vec::new();
        for (vertex, at_mm) in vertices.iter().zip(&positions_mm) {
            // Vertices are counted in the order in which they are first met.
            if *vertex as usize == places_mm.len() {
                places_mm.push(*at_mm);
            }
        }
        let triangles =
            corners.into_iter().map(|t: [usize; 3]| t.map(|corner| vertices[corner] as usize));
        Self { places_mm, triangles: triangles.collect() }
    }

    /// For each place whether it is on an edge: where faces meet at an angle, or where one ends.
    fn sharp(&self) -> Vec<bool> {
        let mut faces: HashMap<[usize; 2], Vec<Unit<Vector3<f64>>>> = HashMap::new();
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(|corner| self.places_mm[corner]);
            // One without an area has no normal.
            let Some(normal) = Unit::try_new((b - a).cross(&(c - a)), 1e-12) else {
                continue;
            };
            let [i, j, k] = *triangle;
            for [from, to] in [[i, j], [j, k], [k, i]] {
                faces.entry([from.min(to), from.max(to)]).or_default().push(normal);
            }
        }
        let mut is_sharp = vec![false; self.places_mm.len()];
        for (ends, normals) in faces {
            let is_edge = normals.len() == 1
                || normals.iter().any(|normal| normal.dot(&normals[0]) < EDGE_RAD.cos());
            if is_edge {
                for end in ends {
                    is_sharp[end] = true;
                }
            }
        }
        is_sharp
    }
}

#[cfg(test)]
mod tests;
