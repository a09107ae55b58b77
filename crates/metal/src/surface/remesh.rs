//! A surface with about as many triangles as boundary elements need, whatever a file has.

use super::decimate::decimated;
use super::{
    ClosedSurface, Indexed, MAX_TRIANGLES, SurfaceError, check_edges, double_area_mm2, joined,
    longest_side_mm,
};
use nalgebra::{Point3, Vector3};
use trackwright_geometry::mesh::{MeshPart, SurfaceMesh};
use trackwright_task::Task;

/// Most triangles of a mesh that is remeshed; a million take seconds.
pub const MAX_FINE_TRIANGLES: usize = 2_000_000;

/// Fewest triangles that a mesh is remeshed to.
pub const MIN_TARGET: usize = 48;

/// The part of the triangles that edges are collapsed to; the rest is for halving what became long.
const KEPT: f64 = 0.7;

/// By how much the longest edge that stays grows while halving leads to too many triangles.
const GROWTH: f64 = 1.15;

impl ClosedSurface {
    /// The surface of a mesh with about as many triangles as `most`, and no more: edges are collapsed
    /// where there are too many, and long ones halved where there are fewer.
    ///
    /// Files have as many triangles as their shape needs to be seen, which may be a million on a curve and
    /// two on a plate. Boundary elements need them small beside the distance of coils and other metal.
    ///
    /// # Errors
    /// What is wrong with the mesh; [`SurfaceError::TooManyTriangles`] where its shape needs more than
    /// `most`, or where it is larger than [`MAX_FINE_TRIANGLES`]; [`SurfaceError::Cancelled`].
    pub fn remeshed(mesh: &SurfaceMesh, most: usize, task: &Task) -> Result<Self, SurfaceError> {
        if !(MIN_TARGET..=MAX_TRIANGLES).contains(&most) {
            return Err(SurfaceError::Target { most });
        }
        let (mut positions_mm, mut triangles) = joined(mesh)?;
        let found = triangles.len();
        if found > MAX_FINE_TRIANGLES {
            return Err(SurfaceError::TooManyTriangles { found, most: MAX_FINE_TRIANGLES });
        }
        check_edges(&triangles)?;
        if found > most {
            let kept = (KEPT * most as f64) as usize;
            (positions_mm, triangles) = decimated(&positions_mm, &triangles, kept, task)?;
            if triangles.len() > most {
                return Err(SurfaceError::TooManyTriangles { found: triangles.len(), most });
            }
        }
        let (positions_mm, triangles) = finest(positions_mm, triangles, most)?;
        let coarsened_from = (found > most).then_some(found);
        Ok(Self { coarsened_from, ..Self::of_triangles(&positions_mm, triangles)? })
    }
}

/// Long edges halved while there are no more than `most` triangles.
fn finest(
    positions_mm: Vec<Point3<f64>>,
    triangles: Vec<[u32; 3]>,
    most: usize,
) -> Result<Indexed, SurfaceError> {
    let corners = |t: &[u32; 3]| t.map(|i| positions_mm[i as usize]);
    let area_mm2: f64 = triangles.iter().map(|t| double_area_mm2(&corners(t)) / 2.0).sum();
    let longest_mm = triangles.iter().map(|t| longest_side_mm(&corners(t))).fold(0.0, f64::max);
    let whole = SurfaceMesh {
        parts: vec![MeshPart {
            normals: vec![Vector3::z(); positions_mm.len()],
            positions_mm,
            triangles,
            ..MeshPart::default()
        }],
        ..SurfaceMesh::default()
    };
    // Equilateral triangles of this side would be twice too many.
    let mut side_mm = (4.0 / 3.0_f64.sqrt() * area_mm2 / (2 * most) as f64).sqrt();
    while side_mm < longest_mm {
        if let Some(finer) = whole.finer(side_mm)
            && finer.parts[0].triangles.len() <= most
        {
            return joined(&finer);
        }
        side_mm *= GROWTH;
    }
    joined(&whole)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::{cuboid, cylinder, sphere};
    use std::f64::consts::PI;
    use trackwright_geometry::bounds::Bounds;
    use trackwright_geometry::solid::Solid;

    #[test]
    fn meshes_get_the_triangles_they_need() {
        let task = Task::default();
        let fine = sphere(50.0, 6).unwrap();
        let coarse = ClosedSurface::remeshed(&fine, 1000, &task).unwrap();
        assert_eq!(coarse.coarsened_from(), Some(81_920));
        assert!((600..=1000).contains(&coarse.panels().len()));
        assert!((coarse.volume_mm3() / (4.0 / 3.0 * PI * 50.0_f64.powi(3)) - 1.0).abs() < 0.03);
        // A box of twelve triangles, as files have it.
        let solid = Solid::cuboid(&Bounds {
            min_mm: Point3::new(-100.0, -50.0, -5.0),
            max_mm: Point3::new(100.0, 50.0, 5.0),
        });
        let Solid { positions_mm, normals, triangles } = solid;
        let part = MeshPart { positions_mm, normals, triangles, ..MeshPart::default() };
        let plate = SurfaceMesh { parts: vec![part], ..SurfaceMesh::default() };
        let plate = ClosedSurface::remeshed(&plate, 1000, &task).unwrap();
        assert!((500..=1000).contains(&plate.panels().len()), "{}", plate.panels().len());
        assert!((plate.volume_mm3() / 2e5 - 1.0).abs() < 1e-12);
        assert_eq!(plate.coarsened_from(), None);
        // A plate of a thousand triangles a side stays flat.
        let flat = cuboid(&Vector3::new(200.0, 100.0, 10.0), 8000).unwrap();
        let flat = ClosedSurface::remeshed(&flat, 500, &task).unwrap();
        assert!((flat.volume_mm3() / 2e5 - 1.0).abs() < 0.02, "{}", flat.volume_mm3());
        let rod =
            ClosedSurface::remeshed(&cylinder(5.0, 150.0, 9000).unwrap(), 400, &task).unwrap();
        assert!((rod.volume_mm3() / (PI * 25.0 * 150.0) - 1.0).abs() < 0.03);
        let mut open = fine;
        open.parts[0].triangles.pop();
        assert_eq!(
            ClosedSurface::remeshed(&open, 1000, &task),
            Err(SurfaceError::Open { edges: 3 })
        );
        assert_eq!(ClosedSurface::remeshed(&open, 9, &task), Err(SurfaceError::Target { most: 9 }));
    }

    #[test]
    fn meshes_beyond_two_million_are_refused() {
        let mut mesh = sphere(50.0, 0).unwrap();
        let part = &mut mesh.parts[0];
        part.triangles = part.triangles.iter().copied().cycle().take(2_000_001).collect();
        let error = ClosedSurface::remeshed(&mesh, 1000, &Task::default()).unwrap_err();
        assert_eq!(
            error.to_string(),
            "2000001 triangles, expected at most 2000000: coarsen the mesh to that many"
        );
    }
}
