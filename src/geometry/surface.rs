//! Rays and closest points on the surface of a body, in f64.
//!
//! A tree of boxes split at the median of the longest axis: built once a mesh, and fast enough
//! for every move of a pointer over a hundred thousand triangles.

use super::bounds::Bounds;
use super::mesh::SurfaceMesh;
use nalgebra::{Point3, Unit, Vector3};

/// Triangles a leaf holds; between 2 and 8 the time for a ray hardly changes.
const LEAF_TRIANGLES: usize = 4;

/// A half-line in the body frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    pub origin_mm: Point3<f64>,
    pub direction: Unit<Vector3<f64>>,
}

impl Ray {
    pub fn at(&self, distance_mm: f64) -> Point3<f64> {
        self.origin_mm + self.direction.into_inner() * distance_mm
    }

    /// The same ray in another frame.
    pub fn transformed_by(&self, target_from_source: &super::pose::Pose) -> Self {
        Self {
            origin_mm: target_from_source * self.origin_mm,
            direction: target_from_source.rotation * self.direction,
        }
    }

    /// Where along a line through `point_mm` the line passes nearest to the ray; `None` where the
    /// two are parallel.
    pub fn nearest_on_line(
        &self,
        point_mm: &Point3<f64>,
        direction: &Unit<Vector3<f64>>,
    ) -> Option<f64> {
        let cosine = self.direction.dot(direction);
        let sine2 = 1.0 - cosine * cosine;
        let between = point_mm - self.origin_mm;
        (sine2 > 1e-6)
            .then(|| (cosine * between.dot(&self.direction) - between.dot(direction)) / sine2)
    }

    /// Where the ray meets a plane; `None` where it runs along it or away from it.
    pub fn meets_plane(
        &self,
        point_mm: &Point3<f64>,
        normal: &Vector3<f64>,
    ) -> Option<Point3<f64>> {
        let slope = self.direction.dot(normal);
        let distance = (point_mm - self.origin_mm).dot(normal) / slope;
        (distance.is_finite() && distance >= 0.0).then(|| self.at(distance))
    }
}

/// A point of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    pub position_mm: Point3<f64>,
    /// Interpolated between the corners' normals, outward.
    pub normal: Unit<Vector3<f64>>,
}

/// The instrument's triangles (anatomy left out) in a tree that rays and points search.
#[derive(Clone, Debug)]
pub struct Surface {
    triangles: Vec<Triangle>,
    nodes: Vec<Node>,
}

#[derive(Clone, Copy, Debug)]
struct Triangle {
    corners: [Point3<f64>; 3],
    normals: [Vector3<f64>; 3],
}

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Bounds,
    /// A leaf: its triangles. An inner node: its right child (the left one comes next).
    content: NodeContent,
}

#[derive(Clone, Copy, Debug)]
enum NodeContent {
    Leaf { first: usize, len: usize },
    Inner { right: usize },
}

impl Surface {
    /// The surface of the body's parts; `None` without triangles that have an area.
    pub fn new(mesh: &SurfaceMesh) -> Option<Self> {
        let mut triangles: Vec<Triangle> = mesh
            .body_parts()
            .flat_map(|part| {
                part.triangles.iter().map(|t| Triangle {
                    corners: t.map(|i| part.positions_mm[i as usize]),
                    normals: t.map(|i| part.normals[i as usize]),
                })
            })
            .filter(Triangle::has_area)
            .collect();
        let mut nodes = Vec::new();
        let len = triangles.len();
        (len > 0).then(|| {
            build(&mut triangles, 0, len, &mut nodes);
            Self { triangles, nodes }
        })
    }

    /// Where the ray first enters the body: the nearest triangle that faces it.
    pub fn cast(&self, ray: &Ray) -> Option<SurfacePoint> {
        let mut best: Option<(f64, SurfacePoint)> = None;
        let mut stack = vec![0];
        while let Some(index) = stack.pop() {
            let node = &self.nodes[index];
            let limit = best.as_ref().map_or(f64::INFINITY, |b| b.0);
            if !box_is_met(&node.bounds, ray, limit) {
                continue;
            }
            match node.content {
                NodeContent::Inner { right } => stack.extend([right, index + 1]),
                NodeContent::Leaf { first, len } => {
                    for triangle in &self.triangles[first..first + len] {
                        if let Some((distance, weights)) = triangle.meets(ray)
                            && best.as_ref().is_none_or(|b| distance < b.0)
                        {
                            best = Some((distance, triangle.point(weights)));
                        }
                    }
                }
            }
        }
        best.map(|b| b.1)
    }

    /// The surface point nearest to a point.
    pub fn closest(&self, point_mm: &Point3<f64>) -> SurfacePoint {
        let mut best = (f64::INFINITY, 0, [1.0, 0.0, 0.0]);
        let mut stack = vec![(0.0, 0)];
        while let Some((box_distance2, index)) = stack.pop() {
            if box_distance2 >= best.0 {
                continue;
            }
            match self.nodes[index].content {
                NodeContent::Inner { right } => {
                    let mut children = [index + 1, right].map(|child| {
                        let nearest = self.nodes[child].bounds.clamp(point_mm);
                        ((nearest - point_mm).norm_squared(), child)
                    });
                    // The nearer one is searched first, so it is pushed last.
                    if children[0].0 < children[1].0 {
                        children.swap(0, 1);
                    }
                    stack.extend(children);
                }
                NodeContent::Leaf { first, len } => {
                    for i in first..first + len {
                        let weights = self.triangles[i].closest(point_mm);
                        let at = self.triangles[i].position(weights);
                        let distance2 = (at - point_mm).norm_squared();
                        if distance2 < best.0 {
                            best = (distance2, i, weights);
                        }
                    }
                }
            }
        }
        self.triangles[best.1].point(best.2)
    }

    /// The point under the ray or, where it passes by, the one nearest to where the ray crosses
    /// the plane through `near_mm` that faces it: a pointer that slips off a thin shaft still
    /// slides along it.
    pub fn under(&self, ray: &Ray, near_mm: &Point3<f64>) -> SurfacePoint {
        self.cast(ray).unwrap_or_else(|| {
            let beside = ray.meets_plane(near_mm, &ray.direction).unwrap_or(*near_mm);
            self.closest(&beside)
        })
    }
}

impl Triangle {
    fn bounds(&self) -> Bounds {
        let [a, b, c] = self.corners;
        Bounds {
            min_mm: a.inf(&b).inf(&c),
            max_mm: a.sup(&b).sup(&c),
        }
    }

    fn cross(&self) -> Vector3<f64> {
        let [a, b, c] = self.corners;
        (b - a).cross(&(c - a))
    }

    fn has_area(&self) -> bool {
        self.cross().norm() > 0.0
    }

    fn position(&self, [u, v, w]: [f64; 3]) -> Point3<f64> {
        let [a, b, c] = self.corners.map(|p| p.coords);
        Point3::from(a * u + b * v + c * w)
    }

    fn point(&self, weights: [f64; 3]) -> SurfacePoint {
        let [a, b, c] = self.normals;
        let smooth = a * weights[0] + b * weights[1] + c * weights[2];
        SurfacePoint {
            position_mm: self.position(weights),
            normal: Unit::try_new(smooth, 1e-9)
                .unwrap_or_else(|| Unit::new_normalize(self.cross())),
        }
    }

    /// Distance and corner weights where the ray meets the front (Möller & Trumbore, 1997).
    fn meets(&self, ray: &Ray) -> Option<(f64, [f64; 3])> {
        let [a, b, c] = self.corners;
        let (ab, ac) = (b - a, c - a);
        let p = ray.direction.cross(&ac);
        let determinant = ab.dot(&p);
        // Negative: seen from behind. Zero: seen edge on.
        if determinant <= 0.0 {
            return None;
        }
        let from_a = ray.origin_mm - a;
        let v = from_a.dot(&p) / determinant;
        let q = from_a.cross(&ab);
        let w = ray.direction.dot(&q) / determinant;
        let distance = ac.dot(&q) / determinant;
        (v >= 0.0 && w >= 0.0 && v + w <= 1.0 && distance >= 0.0)
            .then_some((distance, [1.0 - v - w, v, w]))
    }

    /// Corner weights of the nearest point (Ericson, Real-Time Collision Detection, 5.1.5).
    fn closest(&self, point: &Point3<f64>) -> [f64; 3] {
        let [a, b, c] = self.corners;
        let (ab, ac) = (b - a, c - a);
        let (ap, bp, cp) = (point - a, point - b, point - c);
        let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
        if d1 <= 0.0 && d2 <= 0.0 {
            return [1.0, 0.0, 0.0];
        }
        let (d3, d4) = (ab.dot(&bp), ac.dot(&bp));
        if d3 >= 0.0 && d4 <= d3 {
            return [0.0, 1.0, 0.0];
        }
        let vc = d1 * d4 - d3 * d2;
        if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
            let v = d1 / (d1 - d3);
            return [1.0 - v, v, 0.0];
        }
        let (d5, d6) = (ab.dot(&cp), ac.dot(&cp));
        if d6 >= 0.0 && d5 <= d6 {
            return [0.0, 0.0, 1.0];
        }
        let vb = d5 * d2 - d1 * d6;
        if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
            let w = d2 / (d2 - d6);
            return [1.0 - w, 0.0, w];
        }
        let va = d3 * d6 - d5 * d4;
        if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
            let w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
            return [0.0, 1.0 - w, w];
        }
        let sum = va + vb + vc;
        [va / sum, vb / sum, vc / sum]
    }
}

/// Appends the subtree over `triangles[first..first + len]`, sorting them as it goes.
fn build(triangles: &mut [Triangle], first: usize, len: usize, nodes: &mut Vec<Node>) {
    let own = &mut triangles[first..first + len];
    let bounds = own
        .iter()
        .map(Triangle::bounds)
        .reduce(|a, b| Bounds {
            min_mm: a.min_mm.inf(&b.min_mm),
            max_mm: a.max_mm.sup(&b.max_mm),
        })
        .expect("a node has triangles");
    let index = nodes.len();
    nodes.push(Node {
        bounds,
        content: NodeContent::Leaf { first, len },
    });
    if len <= LEAF_TRIANGLES {
        return;
    }
    let axis = bounds.size_mm().imax();
    let middle = len / 2;
    let center = |t: &Triangle| t.corners.iter().map(|p| p[axis]).sum::<f64>();
    own.select_nth_unstable_by(middle, |a, b| center(a).total_cmp(&center(b)));
    build(triangles, first, middle, nodes);
    nodes[index].content = NodeContent::Inner { right: nodes.len() };
    build(triangles, first + middle, len - middle, nodes);
}

/// Whether the ray passes through the box within `limit_mm` (slab test; NaN from `0 · ∞` on a
/// face counts as met).
fn box_is_met(bounds: &Bounds, ray: &Ray, limit_mm: f64) -> bool {
    let (mut near, mut far) = (0.0_f64, limit_mm);
    for k in 0..3 {
        let inverse = 1.0 / ray.direction[k];
        let to_min = (bounds.min_mm[k] - ray.origin_mm[k]) * inverse;
        let to_max = (bounds.max_mm[k] - ray.origin_mm[k]) * inverse;
        if to_min.is_nan() || to_max.is_nan() {
            continue;
        }
        near = near.max(to_min.min(to_max));
        far = far.min(to_min.max(to_max));
    }
    near <= far
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::geometry::mesh::MeshPart;
    use std::f64::consts::TAU;

    /// A closed cylinder along z with smooth sides and flat caps.
    pub(crate) fn cylinder(radius_mm: f64, length_mm: f64, sides: u32) -> SurfaceMesh {
        let mut part = MeshPart {
            name: "shaft".to_owned(),
            positions_mm: Vec::new(),
            normals: Vec::new(),
            triangles: Vec::new(),
            base_color: [1.0; 4],
            metallic: 1.0,
            roughness: 0.3,
        };
        let rim = |i: u32| {
            let (sine, cosine) = (f64::from(i) / f64::from(sides) * TAU).sin_cos();
            Vector3::new(cosine, sine, 0.0)
        };
        for i in 0..sides {
            let base = part.positions_mm.len() as u32;
            for (corner, z) in [(i, 0.0), (i + 1, 0.0), (i + 1, length_mm), (i, length_mm)] {
                part.positions_mm
                    .push(Point3::from(rim(corner) * radius_mm + Vector3::z() * z));
                part.normals.push(rim(corner));
            }
            part.triangles
                .extend([[base, base + 1, base + 2], [base, base + 2, base + 3]]);
            for (z, normal, order) in [
                (0.0, -Vector3::z(), [0, 2, 1]),
                (length_mm, Vector3::z(), [0, 1, 2]),
            ] {
                let base = part.positions_mm.len() as u32;
                for offset in [Vector3::zeros(), rim(i) * radius_mm, rim(i + 1) * radius_mm] {
                    part.positions_mm
                        .push(Point3::from(offset + Vector3::z() * z));
                    part.normals.push(normal);
                }
                part.triangles.push(order.map(|k: u32| base + k));
            }
        }
        SurfaceMesh {
            parts: vec![part],
            ..SurfaceMesh::default()
        }
    }

    fn ray(origin: [f64; 3], direction: [f64; 3]) -> Ray {
        Ray {
            origin_mm: origin.into(),
            direction: Unit::new_normalize(direction.into()),
        }
    }

    #[test]
    fn a_ray_hits_the_near_side_with_the_smooth_normal() {
        let surface = Surface::new(&cylinder(2.0, 100.0, 64)).unwrap();
        let hit = surface
            .cast(&ray([50.0, 0.7, 40.0], [-1.0, 0.0, 0.0]))
            .unwrap();
        // A chord of 64 sides is 2 (1 - cos(pi / 64)) = 0.0024 mm inside the circle.
        assert!((hit.position_mm - Point3::new((4.0f64 - 0.49).sqrt(), 0.7, 40.0)).norm() < 0.003);
        let radial = Vector3::new(hit.position_mm.x, hit.position_mm.y, 0.0).normalize();
        assert!(hit.normal.angle(&radial) < 0.005);
    }

    #[test]
    fn rays_from_inside_or_past_the_body_miss() {
        let surface = Surface::new(&cylinder(2.0, 100.0, 32)).unwrap();
        assert!(
            surface
                .cast(&ray([0.0, 0.0, 50.0], [1.0, 0.0, 0.0]))
                .is_none()
        );
        assert!(
            surface
                .cast(&ray([50.0, 3.0, 50.0], [-1.0, 0.0, 0.0]))
                .is_none()
        );
        assert!(
            surface
                .cast(&ray([50.0, 0.0, 50.0], [1.0, 0.0, 0.0]))
                .is_none()
        );
    }

    #[test]
    fn the_tree_agrees_with_trying_every_triangle() {
        let surface = Surface::new(&cylinder(5.0, 80.0, 48)).unwrap();
        let mut state = 1u64;
        let mut random = || {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        for _ in 0..300 {
            let from = [random() * 60.0, random() * 60.0, random() * 200.0];
            let to = Point3::new(random() * 12.0, random() * 12.0, 40.0 + random() * 100.0);
            let ray = ray(from, (to - Point3::from(from)).into());
            let all = surface.triangles.iter().filter_map(|t| t.meets(&ray));
            let nearest = all.map(|m| m.0).min_by(f64::total_cmp).map(|d| ray.at(d));
            let found = surface.cast(&ray).map(|hit| hit.position_mm);
            assert_eq!(nearest.is_some(), found.is_some());
            if let (Some(a), Some(b)) = (nearest, found) {
                assert!((a - b).norm() < 1e-9);
            }
            let closest = surface.closest(&Point3::from(from));
            let least = surface
                .triangles
                .iter()
                .map(|t| (t.position(t.closest(&from.into())) - Point3::from(from)).norm())
                .min_by(f64::total_cmp)
                .unwrap();
            assert!(((closest.position_mm - Point3::from(from)).norm() - least).abs() < 1e-12);
        }
    }

    #[test]
    fn the_closest_point_of_a_point_on_the_axis_is_a_radius_away() {
        let surface = Surface::new(&cylinder(2.0, 100.0, 64)).unwrap();
        let closest = surface.closest(&Point3::new(0.0, 0.0, 40.0));
        assert!((closest.position_mm - Point3::new(0.0, 0.0, 40.0)).norm() < 2.0);
        assert!((closest.position_mm.z - 40.0).abs() < 1e-9);
    }

    #[test]
    fn the_nearest_place_on_a_line_is_where_the_gap_is_perpendicular_to_both() {
        let ray = ray([10.0, 3.0, 0.0], [-1.0, 0.2, 0.1]);
        let line = Unit::new_normalize(Vector3::new(0.1, 0.3, 1.0));
        let start = Point3::new(1.0, 2.0, 3.0);
        let place = start + line.into_inner() * ray.nearest_on_line(&start, &line).unwrap();
        let along_ray = (place - ray.origin_mm).dot(&ray.direction);
        let gap = place - ray.at(along_ray);
        assert!(gap.dot(&line).abs() < 1e-9 && gap.dot(&ray.direction).abs() < 1e-9);
        assert!(ray.nearest_on_line(&start, &ray.direction).is_none());
    }

    #[test]
    fn a_ray_beside_a_shaft_still_finds_the_place_along_it() {
        let surface = Surface::new(&cylinder(1.0, 100.0, 32)).unwrap();
        let beside = ray([50.0, 6.0, 40.0], [-1.0, 0.0, 0.0]);
        let point = surface.under(&beside, &Point3::new(0.0, 0.0, 20.0));
        assert!((point.position_mm.z - 40.0).abs() < 1e-9);
        assert!((point.position_mm.y - 1.0).abs() < 0.01);
    }

    #[test]
    fn anatomy_and_empty_meshes_are_no_surface() {
        let mut mesh = cylinder(1.0, 10.0, 8);
        mesh.parts[0].name = "anatomy-head".to_owned();
        assert!(Surface::new(&mesh).is_none());
        assert!(Surface::new(&SurfaceMesh::default()).is_none());
    }
}
