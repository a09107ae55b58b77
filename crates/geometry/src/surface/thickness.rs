//! How thick a body is below a point of its surface. Parts of a mesh may overlap: they are counted
//! as a ray enters and leaves them.

use super::inside::Crossing;
use super::{Ray, Surface, SurfacePoint};
use crate::rotation::perpendicular;
use nalgebra::{Point3, Unit, Vector3};

/// What is nearer to where an inward ray begins is the surface that it begins on.
const SKIN_MM: f64 = 1e-4;

/// Crossings of one kind nearer than this are one.
const SAME_CROSSING_MM: f64 = 1e-7;

/// How far a ray is turned so that it misses edges: straight through a round part it would meet the
/// vertex on the other side. It changes a thickness by a millionth.
const OFF_EDGES: f64 = 1e-3;

impl Surface {
    /// How far it is through the body from a point of its surface, straight inward. Parts that
    /// overlap count as one. `None` where the ray never leaves, as in an open mesh.
    ///
    /// ```
    /// use nalgebra::{Point3, Vector3};
    /// use trackwright_geometry::placeholder::placeholder;
    /// use trackwright_geometry::surface::{Surface, SurfacePoint};
    ///
    /// // A rod of 1.5 mm from the origin along z.
    /// let mesh = placeholder(&Point3::origin(), &[Point3::new(0.0, 0.0, 100.0)]);
    /// let surface = Surface::new(&mesh).unwrap();
    /// let position_mm = Point3::new(1.5, 0.0, 50.0);
    /// let at = SurfacePoint { position_mm, normal: Vector3::x_axis() };
    /// // A polygon of 24 sides is a little narrower than its circle.
    /// assert!((surface.thickness_mm(&at).unwrap() - 3.0).abs() < 0.03);
    /// ```
    pub fn thickness_mm(&self, at: &SurfacePoint) -> Option<f64> {
        let crossings = self.sorted_crossings(&generic_ray(&at.position_mm, -at.normal));
        let mut parts = 1;
        let mut beyond = crossings.iter().filter(|crossing| crossing.distance_mm > SKIN_MM);
        let end = beyond.find(|crossing| {
            parts += crossing.step;
            parts == 0
        });
        end.map(|crossing| crossing.distance_mm)
    }

    /// The middle of the body straight below a point of its surface: in the bore of a tube along an
    /// axis, else halfway through the wall. `None` where the ray never leaves, as in an open mesh.
    pub fn middle_below(
        &self,
        at: &SurfacePoint,
        axis: &Unit<Vector3<f64>>,
    ) -> Option<Point3<f64>> {
        let inward = Ray { origin_mm: at.position_mm, direction: -at.normal };
        let wall_mm = self.thickness_mm(at)?;
        let mut beyond = self.sorted_crossings(&generic_ray(&at.position_mm, -at.normal));
        beyond.retain(|crossing| crossing.distance_mm > wall_mm + SKIN_MM);
        let far_mm = beyond.first().filter(|far| far.step > 0).map(|far| far.distance_mm);
        let bore = far_mm.map(|far_mm| inward.at(f64::midpoint(wall_mm, far_mm)));
        let reach_mm = far_mm.unwrap_or_default();
        let bore = bore.filter(|middle_mm| self.is_bore(middle_mm, axis, reach_mm));
        Some(bore.unwrap_or_else(|| inward.at(wall_mm / 2.0)))
    }

    /// Whether a point of the surface is hidden in another part of the body.
    pub fn is_covered(&self, at: &SurfacePoint) -> bool {
        let crossings = self.sorted_crossings(&generic_ray(&at.position_mm, at.normal));
        let mut beyond = crossings.iter().filter(|crossing| crossing.distance_mm > SKIN_MM);
        beyond.by_ref().map(|crossing| -crossing.step).sum::<i32>() > 0
    }

    /// Where a ray enters and leaves parts, the nearest first.
    fn sorted_crossings(&self, ray: &Ray) -> Vec<Crossing> {
        let mut found = self.crossings(ray);
        found.sort_by(|a, b| a.distance_mm.total_cmp(&b.distance_mm));
        // A ray through an edge meets both its triangles.
        found.dedup_by(|next, last| {
            next.step == last.step && next.distance_mm - last.distance_mm < SAME_CROSSING_MM
        });
        found
    }
}

/// A ray that is turned a little, so that it meets no edge but by chance.
fn generic_ray(origin_mm: &Point3<f64>, towards: Unit<Vector3<f64>>) -> Ray {
    let u = perpendicular(&towards).into_inner();
    let v = towards.cross(&u);
    let direction = towards.into_inner() + u * OFF_EDGES + v * (0.618 * OFF_EDGES);
    Ray { origin_mm: *origin_mm, direction: Unit::new_normalize(direction) }
}

#[cfg(test)]
mod tests {
    use super::super::tests::cylinder;
    use super::*;
    use crate::mesh::{MeshPart, SurfaceMesh};
    use crate::solid::Solid;

    fn side(radius_mm: f64, z_mm: f64) -> SurfacePoint {
        SurfacePoint { position_mm: Point3::new(radius_mm, 0.0, z_mm), normal: Vector3::x_axis() }
    }

    #[test]
    fn a_round_shaft_is_as_thick_as_its_diameter() {
        let surface = Surface::new(&cylinder(2.5, 100.0, 32)).unwrap();
        // From a vertex to the one on the other side.
        let found = surface.thickness_mm(&side(2.5, 100.0 / 3.0)).unwrap();
        assert!((found - 5.0).abs() < 1e-3, "{found}");
    }

    #[test]
    fn parts_that_overlap_are_one_body() {
        let mut mesh = cylinder(7.0, 100.0, 32);
        mesh.parts.extend(cylinder(2.5, 100.0, 32).parts);
        let surface = Surface::new(&mesh).unwrap();
        let outer = side(7.0, 40.0);
        let found = surface.thickness_mm(&outer).unwrap();
        assert!((found - 14.0).abs() < 1e-3, "{found}");
        assert!(!surface.is_covered(&outer) && surface.is_covered(&side(2.5, 40.0)));
        for (x_mm, is_inside) in [(0.0, true), (5.0, true), (7.5, false)] {
            assert_eq!(surface.contains(&Point3::new(x_mm, 0.0, 40.0)), is_inside, "{x_mm}");
        }
    }

    #[test]
    fn the_middle_of_a_shaft_is_on_its_axis() {
        let surface = Surface::new(&cylinder(2.5, 100.0, 32)).unwrap();
        let found = surface.middle_below(&side(2.5, 40.0), &Vector3::z_axis()).unwrap();
        assert!((found - Point3::new(0.0, 0.0, 40.0)).norm() < 1e-3, "{found}");
    }

    #[test]
    fn the_middle_of_a_tube_is_in_its_bore() {
        // 3 mm across with a bore of 2 mm.
        let outline = [[1.0, 0.0], [1.5, 0.0], [1.5, 50.0], [1.0, 50.0], [1.0, 0.0]];
        let Solid { positions_mm, normals, triangles } = Solid::turned(&outline);
        let part = MeshPart { positions_mm, normals, triangles, ..MeshPart::default() };
        let mesh = SurfaceMesh { parts: vec![part], ..SurfaceMesh::default() };
        let surface = Surface::new(&mesh).unwrap();
        let middle = |axis| surface.middle_below(&side(1.5, 20.0), &axis).unwrap();
        let found = middle(Vector3::z_axis());
        assert!(found.coords.xy().norm() < 0.02, "{found}");
        // Along another axis the walls are those of a fork: the middle of the near one.
        let found = middle(Vector3::y_axis());
        assert!((found.x - 1.25).abs() < 0.02, "{found}");
    }
}
