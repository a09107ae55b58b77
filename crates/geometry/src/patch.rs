//! The part of a mesh that is in a union of boxes, cut at their sides.
//!
//! Polygons are clipped by half-spaces (Sutherland and Hodgman 1974). What one box has taken is cut
//! off before the next: no piece is there twice.

use super::bounds::Bounds;
use super::mesh::SurfaceMesh;
use super::solid::Solid;
use nalgebra::{Point3, Vector3};

/// A corner with its normal.
type Corner = (Point3<f64>, Vector3<f64>);

impl SurfaceMesh {
    /// What of the instrument's surface is in one of the boxes, lifted off it along its normals; all of
    /// it without boxes.
    ///
    /// ```
    /// use nalgebra::Point3;
    /// use trackwright_geometry::bounds::Bounds;
    /// use trackwright_geometry::placeholder::placeholder;
    ///
    /// let rod = placeholder(&Point3::origin(), &[Point3::new(0.0, 0.0, 100.0)]);
    /// let patch = rod.patch(&[Bounds::from(([-5.0, -5.0, 20.0], [5.0, 5.0, 30.0]))], 0.0);
    /// assert!(!patch.triangles.is_empty());
    /// assert!(patch.positions_mm.iter().all(|at| (at.z - 25.0).abs() < 5.0 + 1e-9));
    /// ```
    pub fn patch(&self, boxes: &[Bounds], lift_mm: f64) -> Solid {
        let mut patch = Solid::default();
        for part in self.body_parts() {
            for triangle in &part.triangles {
                let corners = triangle.map(|i| {
                    let i = i as usize;
                    (part.positions_mm[i], part.normals[i])
                });
                match boxes {
                    [] => push(&mut patch, &corners, lift_mm),
                    boxes => push_within(&mut patch, &corners, boxes, lift_mm),
                }
            }
        }
        patch
    }
}

fn push_within(patch: &mut Solid, corners: &[Corner; 3], boxes: &[Bounds], lift_mm: f64) {
    let Some(own) = Bounds::around(corners.map(|(at, _)| at)) else {
        return;
    };
    let mut left = vec![corners.to_vec()];
    for bounds in boxes.iter().filter(|bounds| bounds.intersection(&own).is_some()) {
        let mut outside = Vec::new();
        for polygon in left {
            let inside = split(polygon, bounds, &mut outside);
            push(patch, &inside, lift_mm);
        }
        left = outside;
    }
}

/// The part of a convex polygon in a box; the pieces beside it are added to `outside`.
fn split(polygon: Vec<Corner>, bounds: &Bounds, outside: &mut Vec<Vec<Corner>>) -> Vec<Corner> {
    let mut inside = polygon;
    for axis in 0..3 {
        for (side, limit) in [(1.0, bounds.min_mm[axis]), (-1.0, bounds.max_mm[axis])] {
            let depth = |at: &Point3<f64>| side * (at[axis] - limit);
            let within = clip(&inside, depth);
            let is_beside = within.len() < 3;
            let beyond = match is_beside {
                true => inside,
                false => clip(&inside, |at| -depth(at)),
            };
            if beyond.len() >= 3 {
                outside.push(beyond);
            }
            if is_beside {
                return Vec::new();
            }
            inside = within;
        }
    }
    inside
}

/// What of a convex polygon is where `depth` is above zero; nothing of one that only touches it.
fn clip(polygon: &[Corner], depth: impl Fn(&Point3<f64>) -> f64) -> Vec<Corner> {
    if polygon.iter().all(|(at, _)| depth(at) <= 0.0) {
        return Vec::new();
    }
    let mut clipped = Vec::with_capacity(polygon.len() + 1);
    for (k, from) in polygon.iter().enumerate() {
        let to = &polygon[(k + 1) % polygon.len()];
        let [a, b] = [depth(&from.0), depth(&to.0)];
        if a >= 0.0 {
            clipped.push(*from);
        }
        if a * b < 0.0 {
            let part = a / (a - b);
            let at = Point3::from(from.0.coords.lerp(&to.0.coords, part));
            clipped.push((at, from.1.lerp(&to.1, part)));
        }
    }
    clipped
}

/// Adds a convex polygon as a fan of triangles.
fn push(patch: &mut Solid, polygon: &[Corner], lift_mm: f64) {
    let base = patch.positions_mm.len() as u32;
    for (at, normal) in polygon {
        let normal = normal.try_normalize(0.0).unwrap_or_else(Vector3::z);
        patch.positions_mm.push(at + normal * lift_mm);
        patch.normals.push(normal);
    }
    let corners = polygon.len() as u32;
    patch.triangles.extend((2..corners).map(|k| [base, base + k - 1, base + k]));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::MeshPart;

    /// A square of 10 mm in the plane z = 0.
    fn square() -> SurfaceMesh {
        let corners = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]];
        let part = MeshPart {
            positions_mm: corners.map(|[x, y]| Point3::new(x, y, 0.0)).to_vec(),
            normals: vec![Vector3::z(); 4],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..MeshPart::default()
        };
        SurfaceMesh { parts: vec![part], ..SurfaceMesh::default() }
    }

    /// Counts a piece that is turned over as less than nothing.
    fn area_mm2(patch: &Solid) -> f64 {
        let corner = |i: u32| patch.positions_mm[i as usize];
        let of = |t: &[u32; 3]| {
            let [a, b, c] = t.map(corner);
            (b - a).cross(&(c - a)).z / 2.0
        };
        patch.triangles.iter().map(of).sum()
    }

    fn slab(min: [f64; 2], max: [f64; 2]) -> Bounds {
        Bounds::from(([min[0], min[1], -1.0], [max[0], max[1], 1.0]))
    }

    #[test]
    fn a_patch_has_the_area_of_the_union() {
        let (mesh, own) = (square(), |boxes: &[Bounds]| area_mm2(&square().patch(boxes, 0.0)));
        assert_eq!(area_mm2(&mesh.patch(&[], 0.0)), 100.0);
        let first = slab([1.0, 1.0], [5.0, 5.0]);
        for (boxes, expected) in [
            (vec![first], 16.0),
            // One corner of it is in both.
            (vec![first, slab([4.0, 4.0], [8.0, 8.0])], 31.0),
            (vec![first, slab([3.0, -2.0], [4.0, 12.0]), first], 22.0),
            (vec![slab([-5.0, -5.0], [20.0, 20.0]), first], 100.0),
            (vec![slab([20.0, 0.0], [30.0, 10.0])], 0.0),
        ] {
            let found = own(&boxes);
            assert!((found - expected).abs() < 1e-9, "{boxes:?}: {found}");
        }
    }

    #[test]
    fn what_only_touches_a_box_is_not_in_it() {
        let above = Bounds::from(([0.0; 3], [10.0, 10.0, 5.0]));
        let below = Bounds::from(([0.0, 0.0, -5.0], [10.0, 10.0, 0.0]));
        let around = slab([0.0, 0.0], [10.0, 10.0]);
        for own in [above, below] {
            assert!(square().patch(&[own], 0.0).triangles.is_empty(), "{own:?}");
            // It is still there for the next.
            assert_eq!(area_mm2(&square().patch(&[own, around], 0.0)), 100.0, "{own:?}");
        }
    }

    #[test]
    fn a_patch_is_lifted_along_its_normals() {
        let patch = square().patch(&[slab([2.0, 2.0], [3.0, 3.0])], 0.5);
        assert!(patch.positions_mm.iter().all(|at| at.z == 0.5));
        assert!(patch.normals.iter().all(|normal| *normal == Vector3::z()));
    }

    #[test]
    fn anatomy_has_no_patch() {
        let mut mesh = square();
        mesh.parts[0].name = "anatomy head".to_owned();
        assert!(mesh.patch(&[], 0.0).triangles.is_empty());
    }
}
