//! Closed triangle shapes: building them watertight, measuring them, shading their creases.

use std::collections::HashMap;

use crate::vector::{Placement, Vec3, VecExt};

/// Points closer than this are one point. A tenth of a micrometre is far below the finest
/// detail here (a 0.02 mm chord) and far above round-off.
const WELD_MM: f64 = 1e-4;

/// Faces that meet at a sharper angle than this are an edge of the instrument, not a curve.
const CREASE_DEG: f64 = 35.0;

/// A closed surface: shared points and counter-clockwise triangles, in millimetres.
#[derive(Clone, Debug, Default)]
pub struct Shape {
    pub points: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
    /// Exact normals, one a point, where the maker knows them; otherwise they come from the faces.
    pub normals: Option<Vec<Vec3>>,
}

/// A shape with its points split along creases, as a graphics card wants it.
#[derive(Clone, Debug, Default)]
pub struct ShadedShape {
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
}

/// Collects faces given by their corners and welds corners that coincide.
#[derive(Default)]
pub struct ShapeBuilder {
    shape: Shape,
    index_of_cell: HashMap<[i64; 3], u32>,
}

impl ShapeBuilder {
    /// Adds a triangle, counter-clockwise seen from outside; one that has no area is left out.
    pub fn triangle(&mut self, corners: [Vec3; 3]) {
        let [a, b, c] = corners.map(|corner| self.weld(corner));
        if a != b && b != c && c != a {
            self.shape.triangles.push([a, b, c]);
        }
    }

    /// Adds a four-sided face as two triangles, cut along its shorter diagonal.
    pub fn quad(&mut self, [a, b, c, d]: [Vec3; 4]) {
        // The margin keeps the choice, and so the file, independent of round-off.
        if (c - a).norm() <= (d - b).norm() + WELD_MM {
            self.triangle([a, b, c]);
            self.triangle([a, c, d]);
        } else {
            self.triangle([a, b, d]);
            self.triangle([b, c, d]);
        }
    }

    pub fn finish(self) -> Shape {
        self.shape
    }

    fn weld(&mut self, point: Vec3) -> u32 {
        let cell = point.to_array().map(|coordinate| (coordinate / WELD_MM).round() as i64);
        *self.index_of_cell.entry(cell).or_insert_with(|| {
            self.shape.points.push(point);
            self.shape.points.len() as u32 - 1
        })
    }
}

impl Shape {
    /// The shape moved by `map`, which must keep left-handed things left-handed.
    #[must_use]
    pub fn mapped(mut self, map: impl Fn(Vec3) -> Vec3) -> Self {
        for point in &mut self.points {
            *point = map(*point);
        }
        self.normals = None;
        self
    }

    #[must_use]
    pub fn placed(self, placement: &Placement) -> Self {
        self.mapped(|point| placement.body_from_part(point))
    }

    /// The shape and another one beside it, as one part.
    #[must_use]
    pub fn and(mut self, other: Self) -> Self {
        let first = self.points.len() as u32;
        self.points.extend(other.points);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|index| index + first)));
        self.normals = None;
        self
    }

    /// Splits points along creases and gives each corner its normal.
    ///
    /// A face's normal counts by its area, so that a small chamfer bends towards the large faces
    /// beside it and those stay flat in the light.
    pub fn shaded(&self) -> ShadedShape {
        if let Some(normals) = &self.normals {
            return ShadedShape {
                positions: self.points.clone(),
                normals: normals.clone(),
                triangles: self.triangles.clone(),
            };
        }
        let area_vectors: Vec<Vec3> = self.triangles.iter().map(|t| self.area_vector(t)).collect();
        let mut faces_at = vec![Vec::new(); self.points.len()];
        for (face, triangle) in self.triangles.iter().enumerate() {
            for &corner in triangle {
                faces_at[corner as usize].push(face);
            }
        }
        let min_cosine = CREASE_DEG.to_radians().cos();
        let mut shaded = ShadedShape::default();
        let mut index_of_corner = HashMap::new();
        for (face, triangle) in self.triangles.iter().enumerate() {
            let direction = area_vectors[face].normalized();
            let corners = triangle.map(|corner| {
                let normal = faces_at[corner as usize]
                    .iter()
                    .map(|&other| area_vectors[other])
                    .filter(|area| area.normalized().dot(&direction) >= min_cosine)
                    .fold(Vec3::default(), |sum, area| sum + area)
                    .normalized();
                let cell = normal.to_array().map(|component| (component * 1e5).round() as i64);
                *index_of_corner.entry((corner, cell)).or_insert_with(|| {
                    shaded.positions.push(self.points[corner as usize]);
                    shaded.normals.push(normal);
                    shaded.positions.len() as u32 - 1
                })
            });
            shaded.triangles.push(corners);
        }
        shaded
    }

    /// Outward, as long as the face is large.
    pub fn area_vector(&self, triangle: &[u32; 3]) -> Vec3 {
        let [a, b, c] = triangle.map(|index| self.points[index as usize]);
        (b - a).cross(&(c - a)) * 0.5
    }
}

/// Least and greatest coordinates of some points.
pub fn bounds_mm(points: &[Vec3]) -> (Vec3, Vec3) {
    let infinite = Vec3::repeat(f64::INFINITY);
    points.iter().fold((infinite, -infinite), |(low, high), p| {
        (low.zip_map(p, f64::min), high.zip_map(p, f64::max))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checks::{open_edge_count, volume_mm3};
    use crate::vector::vec3;

    fn unit_cube() -> Shape {
        let corner = |i: usize| vec3((i & 1) as f64, ((i >> 1) & 1) as f64, (i >> 2) as f64);
        let mut builder = ShapeBuilder::default();
        for quad in
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
        {
            builder.quad(quad.map(corner));
        }
        builder.finish()
    }

    #[test]
    fn a_cube_is_closed_and_its_edges_are_creases() {
        let cube = unit_cube();
        assert_eq!(open_edge_count(&cube), 0);
        assert!((volume_mm3(&cube) - 1.0).abs() < 1e-12);
        let shaded = cube.shaded();
        assert_eq!(shaded.positions.len(), 24);
        assert!(
            shaded.normals.iter().all(|n| (n.x.abs() + n.y.abs() + n.z.abs() - 1.0).abs() < 1e-12)
        );
    }

    #[test]
    fn a_missing_face_leaves_open_edges() {
        let mut cube = unit_cube();
        cube.triangles.pop();
        assert_eq!(open_edge_count(&cube), 3);
    }
}
