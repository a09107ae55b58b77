//! A mesh with more triangles of the same shape: values at its corners are too far apart in the middle of a
//! shaft that is one triangle long.

use super::mesh::{MeshPart, SurfaceMesh};
use nalgebra::Vector3;
use std::collections::HashMap;

impl SurfaceMesh {
    /// The instrument with no edge longer than this; `None` where it has none already.
    ///
    /// Edges are halved until they are short enough, and the same whichever triangle they are halved
    /// for: what was closed stays closed.
    ///
    /// ```
    /// use nalgebra::Point3;
    /// use trackwright_geometry::placeholder::placeholder;
    ///
    /// let mesh = placeholder(&Point3::origin(), &[Point3::new(0.0, 0.0, 100.0)]);
    /// let finer = mesh.finer(10.0).unwrap();
    /// assert!(finer.finer(10.0).is_none());
    /// assert_eq!(finer.body_bounds(), mesh.body_bounds());
    /// ```
    pub fn finer(&self, longest_mm: f64) -> Option<Self> {
        let is_long = |part: &MeshPart| !part.is_anatomy() && has_longer_edge(part, longest_mm);
        if !(longest_mm > 0.0 && self.parts.iter().any(is_long)) {
            return None;
        }
        let parts = self.parts.iter().map(|part| match is_long(part) {
            true => finer_part(part, longest_mm),
            false => part.clone(),
        });
        Some(Self { parts: parts.collect(), reading: self.reading })
    }
}

/// The longest edge of a triangle, as the number of the corner that it begins at, and its length.
fn longest_edge(part: &MeshPart, triangle: [u32; 3]) -> (usize, f64) {
    let at = |k: usize| part.positions_mm[triangle[k % 3] as usize];
    let length = |k: usize| (at(k + 1) - at(k)).norm();
    let longest = (0..3).max_by(|a, b| length(*a).total_cmp(&length(*b))).unwrap_or(0);
    (longest, length(longest))
}

/// An edge of no finite length is none that can be halved.
fn is_longer(length_mm: f64, longest_mm: f64) -> bool {
    length_mm.is_finite() && length_mm > longest_mm
}

fn has_longer_edge(part: &MeshPart, longest_mm: f64) -> bool {
    part.triangles.iter().any(|t| is_longer(longest_edge(part, *t).1, longest_mm))
}

fn finer_part(part: &MeshPart, longest_mm: f64) -> MeshPart {
    let mut finer = MeshPart { triangles: Vec::new(), ..part.clone() };
    let mut middles: HashMap<[u32; 2], u32> = HashMap::new();
    let mut open: Vec<[u32; 3]> = part.triangles.iter().rev().copied().collect();
    while let Some(triangle) = open.pop() {
        let (from, length_mm) = longest_edge(&finer, triangle);
        if !is_longer(length_mm, longest_mm) {
            finer.triangles.push(triangle);
            continue;
        }
        let [a, b, c] = [0, 1, 2].map(|k| triangle[(from + k) % 3]);
        let middle = *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
            let [pa, pb] = [a, b].map(|i| finer.positions_mm[i as usize]);
            let [na, nb]: [Vector3<f64>; 2] = [a, b].map(|i| finer.normals[i as usize]);
            finer.positions_mm.push(nalgebra::center(&pa, &pb));
            finer.normals.push((na + nb).try_normalize(1e-12).unwrap_or(na));
            finer.positions_mm.len() as u32 - 1
        });
        open.extend([[middle, b, c], [a, middle, c]]);
    }
    finer
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::tests::cylinder;

    /// Area, and six times the volume.
    fn sizes(mesh: &SurfaceMesh) -> [f64; 2] {
        let part = &mesh.parts[0];
        (0..part.triangles.len()).fold([0.0; 2], |[area, volume], t| {
            let [a, b, c] = part.corners_mm(t).map(|p| p.coords);
            [area + (b - a).cross(&(c - a)).norm() / 2.0, volume + a.dot(&b.cross(&c))]
        })
    }

    #[test]
    fn a_finer_mesh_has_the_same_shape() {
        let mesh = cylinder(2.5, 100.0, 32);
        let finer = mesh.finer(8.0).unwrap();
        for (a, b) in sizes(&mesh).into_iter().zip(sizes(&finer)) {
            assert!((a - b).abs() < 1e-9 * a.abs(), "{a} {b}");
        }
        let part = &finer.parts[0];
        assert!(part.triangles.iter().all(|t| longest_edge(part, *t).1 <= 8.0));
        assert_eq!(part.normals.len(), part.positions_mm.len());
        assert!(part.normals.iter().all(|normal| (normal.norm() - 1.0).abs() < 1e-12));
    }

    #[test]
    fn an_edge_is_halved_alike_from_both_sides() {
        // Two triangles back to back share a long edge, which is the longest of one of them only.
        let corners = [[0.0, 0.0, 0.0], [30.0, 0.0, 0.0], [15.0, 4.0, 0.0], [15.0, -60.0, 0.0]];
        let part = MeshPart {
            positions_mm: corners.map(Into::into).to_vec(),
            normals: vec![Vector3::z(); 4],
            triangles: vec![[0, 1, 2], [1, 0, 3]],
            ..MeshPart::default()
        };
        let mesh = SurfaceMesh { parts: vec![part], ..SurfaceMesh::default() };
        let finer = &mesh.finer(8.0).unwrap().parts[0];
        let mut sides: HashMap<[u32; 2], usize> = HashMap::new();
        for [a, b, c] in &finer.triangles {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                *sides.entry([*from.min(to), *from.max(to)]).or_default() += 1;
            }
        }
        let on_shared = |i: u32| finer.positions_mm[i as usize].y == 0.0;
        let shared = sides.iter().filter(|([a, b], _)| on_shared(*a) && on_shared(*b));
        let counts: Vec<usize> = shared.map(|(_, count)| *count).collect();
        assert_eq!(counts, [2; 4]);
    }
}
