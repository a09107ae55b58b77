//! A mesh with fewer triangles that looks alike from afar: corners that share a cell of a lattice
//! become one (vertex clustering, Rossignac and Borrel 1993).

use super::bounds::Bounds;
use super::mesh::MeshPart;
use nalgebra::{Point3, Vector3};
use std::collections::HashMap;

/// By how much cells grow while there are still too many triangles.
const GROWTH: f64 = 1.3;

/// How often cells are halved that leave nothing of a narrow part: to a millionth of their side.
const MAX_HALVINGS: usize = 20;

/// A patch of a surface over a cell's face becomes two triangles.
const TRIANGLES_A_CELL: f64 = 2.0;

/// Corners of a cell, and the side of the surface that they are on: what lies back to back in a
/// thin wall stays apart.
type Cell = ([i64; 3], [bool; 3]);

/// A coarser part of at most `most` triangles; `None` where it has no more than that, or no surface.
/// Where so few make no surface, which a closed one's never do below four, the fewest that were found.
///
/// Nothing moves by more than a cell's diagonal, whose side is about √(2 area / `most`).
pub fn coarser(part: &MeshPart, most: usize) -> Option<MeshPart> {
    if part.triangles.len() <= most {
        return None;
    }
    let extent_mm = Bounds::around(part.positions_mm.iter().copied())?.size_mm().amax();
    let mut cell_mm = (TRIANGLES_A_CELL * area_mm2(part) / most.max(1) as f64).sqrt();
    if !(cell_mm.is_finite() && cell_mm > 0.0) {
        return None;
    }
    let mut coarse = clustered(part, cell_mm);
    for _ in 0..MAX_HALVINGS {
        if !coarse.triangles.is_empty() {
            break;
        }
        cell_mm /= 2.0;
        coarse = clustered(part, cell_mm);
    }
    // Larger cells than the part leave the same clusters, one a side of the surface.
    while coarse.triangles.len() > most && cell_mm <= extent_mm {
        cell_mm *= GROWTH;
        let next = clustered(part, cell_mm);
        if next.triangles.is_empty() {
            break;
        }
        if next.triangles.len() < coarse.triangles.len() {
            coarse = next;
        }
    }
    (!coarse.triangles.is_empty()).then_some(coarse)
}

fn area_mm2(part: &MeshPart) -> f64 {
    (0..part.triangles.len())
        .map(|triangle| {
            let [a, b, c] = part.corners_mm(triangle);
            (b - a).cross(&(c - a)).norm() / 2.0
        })
        .sum()
}

fn clustered(part: &MeshPart, cell_mm: f64) -> MeshPart {
    let mut cells: HashMap<Cell, u32> = HashMap::new();
    let mut sums: Vec<(Vector3<f64>, Vector3<f64>, f64)> = Vec::new();
    let cluster_of: Vec<u32> = part
        .positions_mm
        .iter()
        .zip(&part.normals)
        .map(|(at, normal)| {
            let place = [at.x, at.y, at.z].map(|v| (v / cell_mm).floor() as i64);
            let side = [normal.x, normal.y, normal.z].map(|v| v < 0.0);
            let next = sums.len() as u32;
            let cluster = *cells.entry((place, side)).or_insert(next);
            if cluster == next {
                sums.push((Vector3::zeros(), Vector3::zeros(), 0.0));
            }
            let sum = &mut sums[cluster as usize];
            sum.0 += at.coords;
            sum.1 += normal;
            sum.2 += 1.0;
            cluster
        })
        .collect();
    let triangles = part.triangles.iter().filter_map(|corners| {
        let mut clusters = corners.map(|corner| cluster_of[corner as usize]);
        let [a, b, c] = clusters;
        // The least one first: the same triangle is written in one way.
        let least = (0..3).min_by_key(|&k| clusters[k]).unwrap_or_default();
        clusters.rotate_left(least);
        (a != b && b != c && c != a).then_some(clusters)
    });
    let mut triangles: Vec<[u32; 3]> = triangles.collect();
    triangles.sort_unstable();
    triangles.dedup();
    MeshPart {
        triangles,
        positions_mm: sums.iter().map(|(at, _, count)| Point3::from(at / *count)).collect(),
        normals: sums
            .iter()
            .map(|(_, normal, _)| normal.try_normalize(1e-9).unwrap_or_else(Vector3::z))
            .collect(),
        name: part.name.clone(),
        ..*part
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::SurfaceMesh;
    use crate::surface::Surface;
    use std::f64::consts::TAU;

    /// A closed sphere of 80,000 triangles.
    fn sphere(radius_mm: f64) -> MeshPart {
        let [around, along] = [200u32, 200u32];
        let base_color = [0.2, 0.4, 0.6, 1.0];
        let mut part = MeshPart { base_color, metallic: 0.5, ..MeshPart::default() };
        for j in 0..=along {
            let (ring, height) = (f64::from(j) / f64::from(along) * TAU / 2.0).sin_cos();
            for i in 0..around {
                let (sine, cosine) = (f64::from(i) / f64::from(around) * TAU).sin_cos();
                let normal = Vector3::new(ring * cosine, ring * sine, height);
                part.positions_mm.push(Point3::from(normal * radius_mm));
                part.normals.push(normal);
            }
        }
        for j in 0..along {
            for i in 0..around {
                let at = |i: u32, j: u32| j * around + i % around;
                part.triangles.extend([
                    [at(i, j), at(i, j + 1), at(i + 1, j + 1)],
                    [at(i, j), at(i + 1, j + 1), at(i + 1, j)],
                ]);
            }
        }
        part
    }

    #[test]
    fn a_coarse_sphere_is_within_a_cell_of_the_fine() {
        let fine = sphere(30.0);
        let most = 5000;
        let coarse = coarser(&fine, most).unwrap();
        assert!(coarse.triangles.len() <= most);
        assert!(coarse.triangles.len() > most / 4);
        let area = area_mm2(&fine);
        let cell_mm = (TRIANGLES_A_CELL * area / most as f64).sqrt();
        // Cells grew at most a few times.
        let far_mm = cell_mm * GROWTH.powi(3) * 3.0_f64.sqrt();
        let surface =
            Surface::new(&SurfaceMesh { parts: vec![fine.clone()], ..SurfaceMesh::default() });
        let surface = surface.unwrap();
        for at in &coarse.positions_mm {
            assert!((surface.closest(at).position_mm - at).norm() <= far_mm);
        }
        assert!((area_mm2(&coarse) / area - 1.0).abs() < 0.1);
        assert_eq!((coarse.base_color, coarse.metallic), (fine.base_color, fine.metallic));
    }

    /// A flat strip along x, of squares whose normals are all the same.
    fn strip(squares: u32) -> MeshPart {
        let corners = 0..=squares;
        let positions_mm =
            corners.flat_map(|k| [0.0, 1.0].map(|y| Point3::new(f64::from(k), y, 0.0)));
        let positions_mm: Vec<_> = positions_mm.collect();
        MeshPart {
            normals: vec![Vector3::z(); positions_mm.len()],
            positions_mm,
            triangles: (0..squares)
                .flat_map(|k| [[2 * k, 2 * k + 2, 2 * k + 1], [2 * k + 1, 2 * k + 2, 2 * k + 3]])
                .collect(),
            ..sphere(1.0)
        }
    }

    #[test]
    fn every_target_ends_with_a_surface() {
        let (sphere, strip) = (sphere(30.0), strip(1000));
        for most in (0..=100).step_by(4) {
            let found = coarser(&sphere, most).unwrap().triangles.len();
            // Eight corners at last, one in each octant, have no more triangles than that.
            assert!((1..=most.max(2 * 56)).contains(&found), "{most}: {found}");
            // Cells that are wider than the strip leave a line.
            let found = coarser(&strip, most).unwrap().triangles.len();
            assert!((1..=2000).contains(&found), "{most}: {found}");
        }
    }

    #[test]
    fn a_closed_surface_has_few_triangles_at_last() {
        // Eight corners, one in each octant.
        let found = coarser(&sphere(30.0), 1).unwrap();
        assert_eq!(found.positions_mm.len(), 8);
        let count = found.triangles.len();
        assert!((4..=2 * 56).contains(&count), "{count}");
    }

    #[test]
    fn small_or_empty_meshes_are_not_coarsened() {
        let mut part = sphere(10.0);
        assert!(coarser(&part, part.triangles.len()).is_none());
        for at in &mut part.positions_mm {
            *at = Point3::origin();
        }
        assert!(coarser(&part, 100).is_none());
    }
}
