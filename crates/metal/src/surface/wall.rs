//! How thick a body's walls are beside its triangles, which decides how well boundary elements resolve it.

use super::ClosedSurface;
use crate::panel::Panel;
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// How far a ray may pass a triangle's border and still meet it, beside its size: rays through an edge
/// meet one of its triangles.
const BORDER: f64 = 1e-9;

/// A wall of a body, from the middle of a triangle inwards to the opposite one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wall {
    pub thickness_mm: f64,
    /// Size of the larger of the two triangles: from its middle to the farthest corner.
    pub triangle_mm: f64,
    /// Middle of the triangle, in the body's frame.
    pub at_mm: Point3<f64>,
}

impl Wall {
    /// Whether the wall is thinner than its triangles. The induced dipole of discs that no flux enters is
    /// 1.5 % low where triangles are 1.8 times their thickness, 3 % at 3.5 times, 6 % at 14 times.
    pub fn is_thin(&self) -> bool {
        self.thickness_mm < self.triangle_mm
    }
}

impl ClosedSurface {
    /// The wall that is thinnest beside its triangles; `None` where no ray from a triangle's middle meets
    /// another one.
    pub fn thinnest_wall(&self) -> Option<Wall> {
        let ratio = |wall: &Wall| wall.thickness_mm / wall.triangle_mm;
        let walls: Vec<Option<Wall>> =
            self.panels.par_iter().map(|panel| wall_behind(panel, &self.panels)).collect();
        walls.into_iter().flatten().min_by(|a, b| ratio(a).total_cmp(&ratio(b)))
    }
}

fn wall_behind(panel: &Panel, panels: &[Panel]) -> Option<Wall> {
    let (from, inward) = (panel.center_mm(), -panel.normal().into_inner());
    let own = |other: &&Panel| !std::ptr::eq(*other, panel);
    let met = panels.iter().filter(own).filter_map(|other| {
        let thickness_mm = ray_distance_mm(other, from, &inward)?;
        let triangle_mm = panel.radius_mm().max(other.radius_mm());
        Some(Wall { thickness_mm, triangle_mm, at_mm: *from })
    });
    met.min_by(|a, b| a.thickness_mm.total_cmp(&b.thickness_mm))
}

/// How far along a ray a triangle is that faces along it, as the other side of a wall does.
fn ray_distance_mm(panel: &Panel, from: &Point3<f64>, along: &Vector3<f64>) -> Option<f64> {
    let slope = panel.normal().dot(along);
    let distance_mm = -panel.height_mm(from) / slope;
    if slope <= 0.0 || distance_mm.is_nan() || distance_mm <= 0.0 {
        return None;
    }
    let at = from + along * distance_mm;
    let [a, b, c] = panel.corners_mm();
    let border = BORDER * panel.radius_mm() * panel.radius_mm();
    let is_inside =
        |p: &Point3<f64>, q: &Point3<f64>| (q - p).cross(&(at - p)).dot(panel.normal()) >= -border;
    (is_inside(a, b) && is_inside(b, c) && is_inside(c, a)).then_some(distance_mm)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::{cuboid, sphere};

    fn thinnest(mesh: &trackwright_geometry::mesh::SurfaceMesh) -> Wall {
        ClosedSurface::new(mesh).unwrap().thinnest_wall().unwrap()
    }

    #[test]
    fn plates_are_as_thick_as_they_are() {
        for (height_mm, is_thin) in [(40.0, false), (2.0, true)] {
            let wall = thinnest(&cuboid(&Vector3::new(200.0, 120.0, height_mm), 500).unwrap());
            assert!((wall.thickness_mm - height_mm).abs() < 1e-9, "{wall:?}");
            assert!((5.0..30.0).contains(&wall.triangle_mm), "{wall:?}");
            assert_eq!(wall.is_thin(), is_thin, "{wall:?}");
        }
    }

    #[test]
    fn hollow_spheres_are_as_thick_as_their_shell() {
        let mut mesh = sphere(20.0, 2).unwrap();
        assert!(!thinnest(&mesh).is_thin() && thinnest(&mesh).thickness_mm > 39.0);
        mesh.parts.extend(sphere(19.0, 2).unwrap().parts);
        let wall = thinnest(&mesh);
        // A sphere of 320 triangles has its faces' middles 2 % within.
        assert!((0.6..1.4).contains(&wall.thickness_mm) && wall.is_thin(), "{wall:?}");
    }
}
