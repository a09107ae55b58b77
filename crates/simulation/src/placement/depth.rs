//! How deep below the surface a sensor is imagined: a coil lies in a bore as often as on the outside.

use nalgebra::{Point3, Unit, Vector3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_geometry::revolution::RevolutionAxis;
use trackwright_geometry::surface::{Surface, SurfacePoint};
use trackwright_geometry::surface_drag::ON_AXIS_MM;

/// A place's value stands for what is nearer than this.
const LONGEST_EDGE_MM: f64 = 6.0;

/// Edges across the diagonal of a large body.
const EDGES_ACROSS: f64 = 100.0;

/// A body's mesh with as many vertices as placement needs: a shaft may be one triangle long. `None`
/// where it has them.
pub fn placement_mesh(mesh: &SurfaceMesh) -> Option<SurfaceMesh> {
    mesh.finer(longest_edge_mm(mesh)?)
}

/// The longest edge between vertices that placement takes for all of a body's surface; `None` of a mesh
/// without a body.
pub fn longest_edge_mm(mesh: &SurfaceMesh) -> Option<f64> {
    let diagonal_mm = mesh.body_bounds()?.diagonal_mm();
    Some(LONGEST_EDGE_MM.max(diagonal_mm / EDGES_ACROSS))
}

/// The vertices of an instrument, part after part in the mesh's order; one whose normal has no
/// direction looks along z.
pub fn vertices(mesh: &SurfaceMesh) -> Vec<SurfacePoint> {
    mesh.body_parts()
        .flat_map(|part| part.positions_mm.iter().zip(&part.normals))
        .map(|(position_mm, normal)| SurfacePoint {
            position_mm: *position_mm,
            normal: Unit::try_new(*normal, 1e-12).unwrap_or_else(Vector3::z_axis),
        })
        .collect()
}

/// How deep below the surface a sensor is put.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum CoilDepth {
    /// Its middle on the surface.
    #[default]
    Surface,
    /// As deep as it lies now; where the body is thinner than that on both sides, in its middle. On
    /// the axis of a round body, along that.
    Own,
}

impl CoilDepth {
    pub const ALL: [Self; 2] = [Self::Surface, Self::Own];

    /// What a person calls it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Surface => "on the surface",
            Self::Own => "as deep as it is",
        }
    }

    /// Where a sensor is imagined below each vertex of an instrument, in the order of [`vertices`];
    /// the normals are those of the surface.
    pub fn places(self, mesh: &SurfaceMesh, sensor_in_body: &Point3<f64>) -> Vec<SurfacePoint> {
        let mut places = vertices(mesh);
        let surface = match self {
            Self::Surface => None,
            Self::Own => Surface::new(mesh),
        };
        let Some(surface) = surface else {
            return places;
        };
        // Of either direction.
        let is_on = |axis: &RevolutionAxis| axis.arm_mm(sensor_in_body).norm() <= ON_AXIS_MM;
        if let Some(axis) = surface.revolution_axis(&Vector3::z()).filter(is_on) {
            // Exactly in line: two coils in line leave a rotation free, and hardly beside each other
            // they determine it by noise.
            for place in &mut places {
                let way_mm = axis.along_mm(&place.position_mm) - axis.along_mm(sensor_in_body);
                place.position_mm = sensor_in_body + axis.direction.into_inner() * way_mm;
            }
            return places;
        }
        let depth_mm = depth_mm(&places, &surface, sensor_in_body);
        if depth_mm > 0.0 {
            places.par_iter_mut().for_each(|place| {
                let half_mm = surface.thickness_mm(place).map_or(f64::INFINITY, |all| all / 2.0);
                let below = place.position_mm - place.normal.into_inner() * depth_mm.min(half_mm);
                // Below a wall that faces the wrong way there is no body.
                if surface.contains(&below) {
                    place.position_mm = below;
                }
            });
        }
        places
    }
}

/// How deep a point is below the nearest vertex that no other part of the body covers, of those that
/// have it behind them; zero outside.
fn depth_mm(vertices: &[SurfacePoint], surface: &Surface, point: &Point3<f64>) -> f64 {
    if !surface.contains(point) {
        return 0.0;
    }
    let away = |vertex: &SurfacePoint| (vertex.position_mm - point).norm();
    let depth = |vertex: &SurfacePoint| (vertex.position_mm - point).dot(&vertex.normal);
    let mut nearest: Vec<&SurfacePoint> =
        vertices.iter().filter(|v| away(v).is_finite() && depth(v) > 0.0).collect();
    nearest.sort_by(|a, b| away(a).total_cmp(&away(b)));
    nearest.into_iter().find(|vertex| !surface.is_covered(vertex)).map_or(0.0, depth)
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackwright_geometry::placeholder::placeholder;

    /// A rod of 1.5 mm along z.
    fn rod() -> SurfaceMesh {
        let sensors = [Point3::new(0.0, 0.0, 100.0), Point3::new(0.0, 0.0, 60.0)];
        placeholder(&Point3::origin(), &sensors)
    }

    #[test]
    fn a_coil_in_the_bore_stays_in_the_bore() {
        let mesh = rod();
        let places = CoilDepth::Own.places(&mesh, &Point3::new(0.0, 0.0, 60.0));
        let all = vertices(&mesh);
        assert_eq!(places.len(), all.len());
        for (place, vertex) in places.iter().zip(&all) {
            assert_eq!(place.normal, vertex.normal);
            // In line with where it is, to round-off.
            let off_mm = place.position_mm.coords.xy().norm();
            assert!(off_mm < 1e-9, "{off_mm}");
            assert!((place.position_mm.z - vertex.position_mm.z).abs() < 1e-9);
        }
    }

    #[test]
    fn beside_the_axis_a_coil_keeps_its_depth() {
        let mesh = rod();
        // 0.5 mm off the axis of a rod of 1.5 mm radius.
        let places = CoilDepth::Own.places(&mesh, &Point3::new(0.5, 0.0, 60.0));
        for (place, vertex) in places.iter().zip(&vertices(&mesh)) {
            // Along the rod, and not at its rounded ends.
            if vertex.normal.dot(&Vector3::z()).abs() < 1e-9 {
                let depth_mm = (vertex.position_mm - place.position_mm).norm();
                assert!((depth_mm - 1.0).abs() < 0.02, "{depth_mm}");
            }
        }
    }

    #[test]
    fn a_coil_on_the_surface_stays_on_the_surface() {
        let mesh = rod();
        let own = CoilDepth::Own.places(&mesh, &Point3::new(1.6, 0.0, 60.0));
        assert_eq!(own, vertices(&mesh));
        assert_eq!(CoilDepth::Surface.places(&mesh, &Point3::origin()), own);
    }
}
