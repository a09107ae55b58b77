//! A body's outline seen from its widest side, small: where its sensors are at a glance.

use super::silhouette::silhouette;
use super::{FARTHEST_MM, is_drawable};
use nalgebra::{Point3, Vector3};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_simulation::RigidBody;

/// Cells of the raster along the longer side: finer than a pixel of a small picture.
const CELLS: f64 = 200.0;

/// A parallel projection of a body along its shortest side, mm. The longest side runs to the right,
/// the next one up.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyOutline {
    right: Vector3<f64>,
    up: Vector3<f64>,
    /// Rings around what the body covers; none without a mesh.
    pub rings: Vec<Vec<[f64; 2]>>,
    pub low: [f64; 2],
    pub high: [f64; 2],
}

impl BodyOutline {
    /// Of a body with its sensors where they are, and its tip; `None` where there is nothing to draw.
    pub fn of(body: &RigidBody, mesh: Option<&SurfaceMesh>) -> Option<Self> {
        let corners = mesh.and_then(SurfaceMesh::body_bounds).map(|bounds| bounds.corners_mm());
        let places = body.sensors.iter().map(|sensor| sensor.position_in_body);
        let points = places.chain(body.tip_in_body).chain(corners.into_iter().flatten());
        let points: Vec<Point3<f64>> = points.filter(is_drawable).collect();
        let bounds = Bounds::around(points.iter().copied())?;
        let extent = bounds.max_mm - bounds.min_mm;
        let mut axes = [0, 1, 2];
        axes.sort_by(|a, b| extent[*b].total_cmp(&extent[*a]));
        let axis = |k: usize| Vector3::from_fn(|row, _| f64::from(u8::from(row == axes[k])));
        let of_axes = |corner: Point3<f64>| [corner[axes[0]], corner[axes[1]]];
        let mut outline = Self {
            right: axis(0),
            up: axis(1),
            rings: Vec::new(),
            low: of_axes(bounds.min_mm),
            high: of_axes(bounds.max_mm),
        };
        if let Some(mesh) = mesh {
            let triangles: Vec<[[f64; 2]; 3]> =
                mesh.body_parts().flat_map(|part| outline.triangles(part)).collect();
            outline.rings = silhouette(&triangles, extent[axes[0]] / CELLS);
        }
        Some(outline)
    }

    /// Where a point of the body is, to the right and up.
    pub fn at(&self, point: &Point3<f64>) -> [f64; 2] {
        [self.right.dot(&point.coords), self.up.dot(&point.coords)]
    }

    fn triangles(
        &self,
        part: &trackwright_geometry::mesh::MeshPart,
    ) -> impl Iterator<Item = [[f64; 2]; 3]> {
        let corner = |index: u32| part.positions_mm.get(index as usize).map(|p| self.at(p));
        let is_near = |at: &[f64; 2]| at.iter().all(|v| v.abs() <= FARTHEST_MM);
        part.triangles.iter().filter_map(move |corners| {
            let [a, b, c] = corners.map(|index| corner(index).filter(is_near));
            Some([a?, b?, c?])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackwright_geometry::mesh::MeshPart;
    use trackwright_simulation::Sensor;

    /// A plate of 80 x 2 x 20 mm from the origin on.
    fn plate() -> SurfaceMesh {
        let corners = [[0.0, 0.0], [80.0, 0.0], [80.0, 20.0], [0.0, 20.0]];
        let positions_mm =
            [0.0, 2.0].into_iter().flat_map(|y| corners.map(move |[x, z]| Point3::new(x, y, z)));
        let part = MeshPart {
            positions_mm: positions_mm.collect(),
            triangles: vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]],
            ..MeshPart::default()
        };
        SurfaceMesh { parts: vec![part], ..SurfaceMesh::default() }
    }

    fn body(places: &[[f64; 3]]) -> RigidBody {
        let sensor = |at: &[f64; 3]| Sensor::five_dof("coil", *at, Vector3::z_axis());
        RigidBody {
            name: "plate".into(),
            tip_in_body: None,
            sensors: places.iter().map(sensor).collect(),
        }
    }

    #[test]
    fn an_outline_is_seen_along_the_shortest_side() {
        let outline = BodyOutline::of(&body(&[[40.0, 1.0, 5.0]]), Some(&plate())).unwrap();
        assert_eq!((outline.low, outline.high), ([0.0, 0.0], [80.0, 20.0]));
        assert_eq!(outline.at(&Point3::new(40.0, 1.0, 5.0)), [40.0, 5.0]);
        assert_eq!(outline.rings.len(), 1);
        // Within two cells of the plate's own border.
        for [x, z] in outline.rings.iter().flatten() {
            let off = x.min(80.0 - x).min(*z).min(20.0 - z);
            assert!(off.abs() <= 2.0 * 80.0 / CELLS, "{x} {z}");
        }
    }

    #[test]
    fn a_body_without_a_mesh_has_its_sensors() {
        let outline = BodyOutline::of(&body(&[[0.0, 0.0, 0.0], [0.0, 0.0, 90.0]]), None).unwrap();
        assert!(outline.rings.is_empty());
        assert_eq!((outline.low[0], outline.high[0]), (0.0, 90.0));
        assert_eq!(BodyOutline::of(&body(&[]), None), None);
    }
}
