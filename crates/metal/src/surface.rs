//! A closed surface of flat triangles, checked so that boundary elements on it have a meaning.

mod decimate;
mod remesh;

use crate::crossing::first_crossing;
use crate::panel::{FULL_ANGLE, Panel};
use nalgebra::Point3;
use rayon::prelude::*;
pub use remesh::{MAX_FINE_TRIANGLES, MIN_TARGET};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::limits::position_problem;
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_geometry::weld::welded;
use trackwright_task::Cancelled;

/// Most triangles of a body. Its equations take some 500 MB, and some seconds.
pub const MAX_TRIANGLES: usize = 2000;

/// Doubled area relative to the square of the longest side, below which a triangle has none: corners
/// in f32 that were meant to be on a line stray by 1e-7 of it.
const NO_AREA: f64 = 1e-7;

/// A closed surface in the body's own frame.
#[derive(Clone, Debug, PartialEq)]
pub struct ClosedSurface {
    panels: Vec<Panel>,
    /// Which shell each panel belongs to.
    shell_of: Vec<usize>,
    shells: Vec<Shell>,
    bounds: Bounds,
    coarsened_from: Option<usize>,
}

/// A connected part of a surface: the outside of a body, or the wall of a hollow in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shell {
    pub area_mm2: f64,
    /// Negative for the wall of a hollow.
    pub volume_mm3: f64,
}

/// Why a mesh is no closed surface.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SurfaceError {
    #[error("the mesh has no triangles")]
    Empty,
    #[error("a corner is at ({}, {}, {}), expected {expected}", .at_mm.x, .at_mm.y, .at_mm.z)]
    Position { at_mm: Point3<f64>, expected: &'static str },
    #[error("{found} triangles, expected at most {most}: coarsen the mesh to that many")]
    TooManyTriangles { found: usize, most: usize },
    #[error("a target of {most} triangles, expected {MIN_TARGET} to {MAX_TRIANGLES}")]
    Target { most: usize },
    #[error("{count} triangles have no area, the first is number {first}")]
    NoArea { count: usize, first: usize },
    #[error("the mesh is open: {edges} edges have a triangle on one side only")]
    Open { edges: usize },
    #[error("{edges} edges have more than two triangles")]
    NonManifold { edges: usize },
    #[error("{edges} edges have triangles that face opposite ways")]
    Turned { edges: usize },
    #[error("the mesh cuts itself: triangles {first} and {second} near ({}, {}, {}) mm", .at_mm.x, .at_mm.y, .at_mm.z)]
    CutsItself { first: usize, second: usize, at_mm: Point3<f64> },
    #[error("part {shell} of the mesh lies within another one, which no field reaches")]
    Nested { shell: usize },
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl ClosedSurface {
    /// The surface of a mesh's body parts: closed, oriented, not cutting itself, of at most
    /// [`MAX_TRIANGLES`].
    ///
    /// Corners at one place are one. Triangles that have a corner twice are left out, and a shell that
    /// shows its inside is turned.
    ///
    /// # Errors
    /// What is wrong with the mesh; see [`SurfaceError`].
    pub fn new(mesh: &SurfaceMesh) -> Result<Self, SurfaceError> {
        let (positions_mm, triangles) = joined(mesh)?;
        let found = triangles.len();
        if found > MAX_TRIANGLES {
            return Err(SurfaceError::TooManyTriangles { found, most: MAX_TRIANGLES });
        }
        Self::of_triangles(&positions_mm, triangles)
    }

    fn of_triangles(
        positions_mm: &[Point3<f64>],
        mut triangles: Vec<[u32; 3]>,
    ) -> Result<Self, SurfaceError> {
        if triangles.is_empty() {
            return Err(SurfaceError::Empty);
        }
        check_edges(&triangles)?;
        let corners = |t: &[u32; 3]| t.map(|i| positions_mm[i as usize]);
        let without_area = |t: &[u32; 3]| !has_area(&corners(t));
        if let Some(first) = triangles.iter().position(without_area) {
            let count = triangles.iter().filter(|t| without_area(t)).count();
            return Err(SurfaceError::NoArea { count, first });
        }
        if let Some((first, second)) = first_crossing(positions_mm, &triangles) {
            let [a, b, c] = corners(&triangles[first]);
            let at_mm = Point3::from((a.coords + b.coords + c.coords) / 3.0);
            return Err(SurfaceError::CutsItself { first, second, at_mm });
        }
        let (shell_of, count) = shells(positions_mm.len(), &triangles);
        turn_outside_in(positions_mm, &mut triangles, &shell_of, count)?;
        let panels: Option<Vec<Panel>> = triangles.iter().map(|t| Panel::new(corners(t))).collect();
        let panels = panels.ok_or(SurfaceError::NoArea { count: 1, first: 0 })?;
        let mut shells = vec![Shell { area_mm2: 0.0, volume_mm3: 0.0 }; count];
        for (panel, &shell) in panels.iter().zip(&shell_of) {
            shells[shell].area_mm2 += panel.area_mm2();
            shells[shell].volume_mm3 += volume_mm3(panel.corners_mm());
        }
        let used = triangles.iter().flatten().map(|&i| positions_mm[i as usize]);
        let bounds = Bounds::around(used).ok_or(SurfaceError::Empty)?;
        Ok(Self { panels, shell_of, shells, bounds, coarsened_from: None })
    }

    pub fn panels(&self) -> &[Panel] {
        &self.panels
    }

    /// The shell that each panel belongs to.
    pub fn shell_of(&self) -> &[usize] {
        &self.shell_of
    }

    pub fn shells(&self) -> &[Shell] {
        &self.shells
    }

    pub fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    /// Triangles of the mesh, where this has fewer.
    pub fn coarsened_from(&self) -> Option<usize> {
        self.coarsened_from
    }

    pub fn area_mm2(&self) -> f64 {
        self.shells.iter().map(|shell| shell.area_mm2).sum()
    }

    pub fn volume_mm3(&self) -> f64 {
        self.shells.iter().map(|shell| shell.volume_mm3).sum()
    }

    /// Whether a point is in the metal, by the solid angle of the surface around it; not in a hollow.
    /// Either where it is on the surface.
    pub fn contains(&self, p: &Point3<f64>) -> bool {
        self.bounds.contains(p)
            && self.panels.iter().map(|panel| panel.solid_angle(p)).sum::<f64>() > 0.5 * FULL_ANGLE
    }

    /// Distance of a point from the nearest panel, and that panel's size: within about one size the
    /// field of even charges is that of the triangles rather than that of the surface.
    pub fn nearest(&self, p: &Point3<f64>) -> (f64, f64) {
        let nearest = self.panels.iter().map(|panel| {
            let least_mm = (p - panel.center_mm()).norm() - panel.radius_mm();
            (least_mm, panel)
        });
        let mut best = (f64::INFINITY, 0.0);
        for (least_mm, panel) in nearest {
            if least_mm < best.0 {
                let distance_mm = panel.distance_mm(p);
                if distance_mm < best.0 {
                    best = (distance_mm, panel.radius_mm());
                }
            }
        }
        best
    }
}

/// Corners, and the triangles between them by their numbers.
type Indexed = (Vec<Point3<f64>>, Vec<[u32; 3]>);

/// All body parts as one, corners at one place as one, without triangles that have a corner twice.
fn joined(mesh: &SurfaceMesh) -> Result<Indexed, SurfaceError> {
    let positions = mesh.body_parts().flat_map(|part| part.positions_mm.iter().copied());
    let positions: Vec<Point3<f64>> = positions.collect();
    for at_mm in &positions {
        if let Some(expected) = position_problem(&at_mm.coords) {
            return Err(SurfaceError::Position { at_mm: *at_mm, expected });
        }
    }
    let vertices = welded(&positions);
    let count = vertices.iter().max().map_or(0, |last| *last as usize + 1);
    let mut positions_mm = vec![Point3::origin(); count];
    for (position, &vertex) in positions.iter().zip(&vertices).rev() {
        positions_mm[vertex as usize] = *position;
    }
    let mut triangles = Vec::new();
    let mut first = 0;
    for part in mesh.body_parts() {
        triangles.extend(part.triangles.iter().map(|t| t.map(|i| vertices[first + i as usize])));
        first += part.positions_mm.len();
    }
    let triangles = without_double_corners(triangles);
    if triangles.is_empty() {
        return Err(SurfaceError::Empty);
    }
    Ok((positions_mm, triangles))
}

fn without_double_corners(mut triangles: Vec<[u32; 3]>) -> Vec<[u32; 3]> {
    triangles.retain(|[a, b, c]| a != b && b != c && c != a);
    triangles
}

fn double_area_mm2([a, b, c]: &[Point3<f64>; 3]) -> f64 {
    (b - a).cross(&(c - a)).norm()
}

fn longest_side_mm([a, b, c]: &[Point3<f64>; 3]) -> f64 {
    [b - a, c - b, a - c].map(|side| side.norm()).into_iter().fold(0.0, f64::max)
}

/// Each edge has two triangles, which run along it in opposite ways.
fn check_edges(triangles: &[[u32; 3]]) -> Result<(), SurfaceError> {
    let mut edges: Vec<(u32, u32, bool)> = triangles
        .iter()
        .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
        .map(|(from, to)| (from.min(to), from.max(to), from < to))
        .collect();
    edges.par_sort_unstable();
    let (mut open, mut turned, mut non_manifold) = (0, 0, 0);
    for edge in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        match edge {
            [_] => open += 1,
            [one, other] => turned += usize::from(one.2 == other.2),
            _ => non_manifold += 1,
        }
    }
    match (open, non_manifold, turned) {
        (0, 0, 0) => Ok(()),
        (0, 0, edges) => Err(SurfaceError::Turned { edges }),
        (0, edges, _) => Err(SurfaceError::NonManifold { edges }),
        (edges, ..) => Err(SurfaceError::Open { edges }),
    }
}

fn has_area(corners: &[Point3<f64>; 3]) -> bool {
    double_area_mm2(corners) > NO_AREA * longest_side_mm(corners).powi(2)
}

/// Six times less than the box product: what a triangle adds to the volume about the origin.
fn volume_mm3([a, b, c]: &[Point3<f64>; 3]) -> f64 {
    a.coords.dot(&b.coords.cross(&c.coords)) / 6.0
}

/// The shell of each triangle: those that share a corner are of one; and how many there are.
fn shells(vertices: usize, triangles: &[[u32; 3]]) -> (Vec<usize>, usize) {
    let mut parents: Vec<u32> = (0..vertices as u32).collect();
    for &[a, b, c] in triangles {
        for other in [b, c] {
            let (one, other) = (root(&mut parents, a), root(&mut parents, other));
            parents[one.max(other) as usize] = one.min(other);
        }
    }
    let mut number = vec![usize::MAX; vertices];
    let mut count = 0;
    let shell_of = triangles.iter().map(|t| {
        let root = root(&mut parents, t[0]) as usize;
        if number[root] == usize::MAX {
            number[root] = count;
            count += 1;
        }
        number[root]
    });
    (shell_of.collect(), count)
}

fn root(parents: &mut [u32], mut vertex: u32) -> u32 {
    while parents[vertex as usize] != vertex {
        // Halving the way keeps it short for the next.
        parents[vertex as usize] = parents[parents[vertex as usize] as usize];
        vertex = parents[vertex as usize];
    }
    vertex
}

/// Turns shells such that those in no other face out and those in one other face in.
fn turn_outside_in(
    positions_mm: &[Point3<f64>],
    triangles: &mut [[u32; 3]],
    shell_of: &[usize],
    count: usize,
) -> Result<(), SurfaceError> {
    let corners = |t: &[u32; 3]| t.map(|i| positions_mm[i as usize]);
    let mut volumes = vec![0.0; count];
    let mut first = vec![Point3::origin(); count];
    for (triangle, &shell) in triangles.iter().zip(shell_of) {
        volumes[shell] += volume_mm3(&corners(triangle));
        first[shell] = positions_mm[triangle[0] as usize];
    }
    // How many other shells each is in, whichever way they face.
    let depth = |shell: usize| -> usize {
        let mut angles = vec![0.0; count];
        for (triangle, &other) in triangles.iter().zip(shell_of) {
            if other != shell {
                let panel = Panel::new(corners(triangle));
                angles[other] += panel.map_or(0.0, |panel| panel.solid_angle(&first[shell]));
            }
        }
        angles.iter().filter(|angle| angle.abs() > 0.5 * FULL_ANGLE).count()
    };
    let depths: Vec<usize> = match count {
        1 => vec![0],
        _ => (0..count).into_par_iter().map(depth).collect(),
    };
    if let Some(shell) = depths.iter().position(|depth| *depth > 1) {
        return Err(SurfaceError::Nested { shell });
    }
    for (triangle, &shell) in triangles.iter_mut().zip(shell_of) {
        if (volumes[shell] > 0.0) != (depths[shell] == 0) {
            triangle.swap(1, 2);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::{cuboid, sphere};
    use nalgebra::Vector3;
    use std::f64::consts::PI;
    use trackwright_geometry::mesh::MeshPart;

    fn edited(edit: impl Fn(&mut MeshPart)) -> Result<ClosedSurface, SurfaceError> {
        let mut mesh = sphere(10.0, 1).unwrap();
        edit(&mut mesh.parts[0]);
        ClosedSurface::new(&mesh)
    }

    fn added(mut mesh: SurfaceMesh, other: SurfaceMesh, shift: [f64; 3]) -> SurfaceMesh {
        mesh.parts.extend(other.parts.into_iter().map(|mut part| {
            part.positions_mm.iter_mut().for_each(|p| *p += Vector3::from(shift));
            part
        }));
        mesh
    }

    #[test]
    fn a_sphere_has_its_size() {
        let surface = edited(|_| {}).unwrap();
        assert_eq!((surface.panels().len(), surface.shells().len()), (80, 1));
        assert!(surface.contains(&Point3::new(0.0, 5.0, 7.0)));
        assert!(!surface.contains(&Point3::new(0.0, 9.0, 9.0)));
        let (distance_mm, size_mm) = surface.nearest(&Point3::new(0.0, 30.0, 0.0));
        assert!((18.5..20.5).contains(&distance_mm) && (2.0..6.0).contains(&size_mm));
    }

    #[test]
    fn a_shell_that_shows_its_inside_is_turned() {
        let turned = edited(|part| part.triangles.iter_mut().for_each(|t| t.swap(0, 1))).unwrap();
        assert!((turned.volume_mm3() / edited(|_| {}).unwrap().volume_mm3() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_hollow_is_no_metal() {
        let hollow = added(sphere(10.0, 2).unwrap(), sphere(6.0, 2).unwrap(), [0.0; 3]);
        let surface = ClosedSurface::new(&hollow).unwrap();
        let expected = 4.0 / 3.0 * PI * (1000.0 - 216.0);
        assert!((surface.volume_mm3() / expected - 1.0).abs() < 1e-12);
        assert!(surface.contains(&Point3::new(8.0, 0.0, 0.0)));
        assert!(!surface.contains(&Point3::new(4.0, 0.0, 0.0)));
        let within = added(hollow, sphere(3.0, 1).unwrap(), [0.0; 3]);
        assert_eq!(ClosedSurface::new(&within), Err(SurfaceError::Nested { shell: 2 }));
        let apart = added(sphere(10.0, 2).unwrap(), sphere(6.0, 2).unwrap(), [0.0, 17.0, 0.0]);
        assert_eq!(ClosedSurface::new(&apart).unwrap().shells().len(), 2);
    }

    #[test]
    fn faulty_meshes_are_refused() {
        let error = |edit: &dyn Fn(&mut MeshPart)| edited(edit).unwrap_err().to_string();
        assert_eq!(
            error(&|part| part.triangles.truncate(79)),
            "the mesh is open: 3 edges have a triangle on one side only"
        );
        assert_eq!(error(&|part| part.triangles.clear()), "the mesh has no triangles");
        assert_eq!(
            error(&|part| part.triangles.push(part.triangles[0])),
            "3 edges have more than two triangles"
        );
        assert_eq!(
            error(&|part| part.triangles[5].swap(0, 1)),
            "3 edges have triangles that face opposite ways"
        );
        let nan = error(&|part| part.positions_mm[3].y = f64::NAN);
        assert!(nan.contains(", NaN, ") && nan.ends_with("expected finite numbers"), "{nan}");
        let large = ClosedSurface::new(&sphere(10.0, 4).unwrap()).unwrap_err();
        assert_eq!(
            large.to_string(),
            "5120 triangles, expected at most 2000: coarsen the mesh to that many"
        );
    }

    #[test]
    fn triangles_without_area_are_refused() {
        // A corner of a box's side moved onto the line between its neighbours.
        let mut mesh = cuboid(&Vector3::repeat(10.0), 48).unwrap();
        let part = &mut mesh.parts[0];
        let middle = part.positions_mm.iter().position(|p| p.x == 5.0 && p.y == 0.0 && p.z == 0.0);
        let middle = part.positions_mm[middle.unwrap()];
        let corner = Point3::new(5.0, -5.0, 0.0);
        for p in &mut part.positions_mm {
            if *p == middle {
                *p = corner + (Point3::new(5.0, -5.0, 5.0) - corner) * 0.5;
            }
        }
        let error = ClosedSurface::new(&mesh).unwrap_err();
        assert!(matches!(error, SurfaceError::NoArea { count: 1 | 2, .. }), "{error}");
    }

    #[test]
    fn meshes_that_cut_themselves_are_refused() {
        // Two spheres that overlap, and a corner pulled through the other side.
        let overlap = added(sphere(10.0, 2).unwrap(), sphere(10.0, 2).unwrap(), [12.0, 3.0, 1.0]);
        let error = ClosedSurface::new(&overlap).unwrap_err();
        assert!(matches!(error, SurfaceError::CutsItself { .. }), "{error}");
        let through = edited(|part| part.positions_mm[0] = -part.positions_mm[0] * 1.5);
        assert!(matches!(through.unwrap_err(), SurfaceError::CutsItself { .. }));
    }
}
