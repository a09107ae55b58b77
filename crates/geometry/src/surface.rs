//! Rays and closest points on the surface of a body, in f64.
//!
//! A tree of boxes split at the median of the longest axis: built once a mesh, on any thread, and
//! fast enough for every move of a pointer over a million triangles.
//!
//! It is written here because the crates that do this in f64 gain nothing: over a torus of a
//! million triangles `parry3d-f64` 0.31 took about as long with a third more memory, meets triangles
//! from behind too, and brings a second library of vectors; `bvh` 0.13 took at least twice the time a
//! query and twice the memory. `docs/developing/measurements.md` has the figures.

mod axis_channel;
mod inside;
mod thickness;

use super::bounds::Bounds;
use super::mesh::SurfaceMesh;
use super::revolution::RevolutionAxis;
use super::weld::welded;
pub use axis_channel::AxisChannel;
pub use inside::{BORE_DIRECTIONS, bore_directions};
use nalgebra::{Point3, Unit, Vector3};
use std::sync::OnceLock;

/// Triangles a leaf holds; between 2 and 8 the time for a ray hardly changes.
const LEAF_TRIANGLES: usize = 4;

/// Subtrees of fewer triangles are not handed to another thread.
const LEAST_SHARED: usize = 20_000;

/// Nodes that wait while one is looked at: as many as the tree is deep, which halving keeps to 24
/// levels for the largest mesh.
const STACK: usize = 32;

/// A half-line in the body frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    pub origin_mm: Point3<f64>,
    pub direction: Unit<Vector3<f64>>,
}

impl Ray {
    /// The point at a distance from the origin.
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

/// Where a ray enters a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceHit {
    pub distance_mm: f64,
    /// The triangle's corners, counted through the vertices of the body's parts one after the other.
    pub corners: [usize; 3],
    /// What each corner counts for; together 1.
    pub weights: [f64; 3],
}

/// The instrument's triangles (anatomy left out) in a tree that rays and points search.
#[derive(Clone, Debug)]
pub struct Surface {
    triangles: Vec<Triangle>,
    /// Of the corners; most are shared by six triangles.
    normals: Vec<Vector3<f64>>,
    /// Each node followed by its left subtree, then its right one.
    nodes: Vec<Node>,
    /// What the tree has no use for, but a shell may need to be closed.
    without_area: Vec<Triangle>,
    /// Found when it is first needed.
    axis: OnceLock<Option<RevolutionAxis>>,
    is_closed: OnceLock<bool>,
}

#[derive(Clone, Copy, Debug)]
struct Triangle {
    corners: [Point3<f64>; 3],
    /// Places in the surface's normals.
    normals: [u32; 3],
}

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Bounds,
    content: NodeContent,
}

#[derive(Clone, Copy, Debug)]
enum NodeContent {
    /// A leaf's triangles.
    Leaf { first: u32, len: u32 },
    /// How far behind the node its right child is; the left one comes next.
    Inner { right: u32 },
}

impl Surface {
    /// The surface of the body's parts; `None` without triangles that have an area.
    pub fn new(mesh: &SurfaceMesh) -> Option<Self> {
        let count = mesh.body_parts().map(|part| part.triangles.len()).sum();
        let mut triangles = Vec::with_capacity(count);
        let mut normals = Vec::new();
        let mut without_area = Vec::new();
        for part in mesh.body_parts() {
            let first = normals.len() as u32;
            normals.extend_from_slice(&part.normals);
            let of_part = part.triangles.iter().map(|t| Triangle {
                corners: t.map(|i| part.positions_mm[i as usize]),
                normals: t.map(|i| first + i),
            });
            for triangle in of_part {
                match triangle.has_area() {
                    true => triangles.push(triangle),
                    false => without_area.push(triangle),
                }
            }
        }
        (!triangles.is_empty()).then(|| Self {
            nodes: build(&mut triangles, 0),
            triangles,
            normals,
            without_area,
            axis: OnceLock::new(),
            is_closed: OnceLock::new(),
        })
    }

    /// The corners of its triangles, each with its normal, which may have any length: what
    /// [`closest`](Self::closest) interpolates between.
    pub fn triangles(&self) -> impl ExactSizeIterator<Item = [(Point3<f64>, Vector3<f64>); 3]> {
        self.triangles.iter().map(|triangle| {
            std::array::from_fn(|k| {
                (triangle.corners[k], self.normals[triangle.normals[k] as usize])
            })
        })
    }

    /// The axis of a body of revolution, its direction the one along `long_axis`; `None` where the
    /// body is none.
    pub fn revolution_axis(&self, long_axis: &Vector3<f64>) -> Option<RevolutionAxis> {
        let axis = self.axis.get_or_init(|| {
            let corners: Vec<[Point3<f64>; 3]> = self.triangles.iter().map(|t| t.corners).collect();
            RevolutionAxis::of_connected(&corners, &self.connected()[..corners.len()])
        });
        axis.map(|axis| axis.towards(long_axis))
    }

    /// The corners of all triangles, then of those without an area, by number: one a place.
    fn connected(&self) -> Vec<[u32; 3]> {
        let all = || self.triangles.iter().chain(&self.without_area);
        let mut positions_mm = vec![Point3::origin(); self.normals.len()];
        for triangle in all() {
            for (place, corner) in triangle.normals.iter().zip(&triangle.corners) {
                positions_mm[*place as usize] = *corner;
            }
        }
        let vertices = welded(&positions_mm);
        all().map(|triangle| triangle.normals.map(|place| vertices[place as usize])).collect()
    }

    /// Where the ray first enters the body: the nearest triangle that faces it.
    ///
    /// ```
    /// use nalgebra::{Point3, Vector3};
    /// use trackwright_geometry::placeholder::placeholder;
    /// use trackwright_geometry::surface::{Ray, Surface};
    ///
    /// // A rod of 1.5 mm from the origin along z.
    /// let mesh = placeholder(&Point3::origin(), &[Point3::new(0.0, 0.0, 100.0)]);
    /// let surface = Surface::new(&mesh).unwrap();
    /// let ray = Ray { origin_mm: Point3::new(9.0, 0.0, 50.0), direction: -Vector3::x_axis() };
    /// assert!((surface.cast(&ray).unwrap().position_mm.x - 1.5).abs() < 1e-9);
    /// ```
    pub fn cast(&self, ray: &Ray) -> Option<SurfacePoint> {
        let (_, triangle, weights) = self.first_met(ray)?;
        Some(self.point(triangle, weights))
    }

    /// The same as the triangle that is met and where in it: what a value at each vertex is
    /// interpolated with.
    pub fn hit(&self, ray: &Ray) -> Option<SurfaceHit> {
        let (distance_mm, triangle, weights) = self.first_met(ray)?;
        Some(SurfaceHit { distance_mm, corners: triangle.normals.map(|i| i as usize), weights })
    }

    fn first_met(&self, ray: &Ray) -> Option<(f64, &Triangle, [f64; 3])> {
        let mut best = (f64::INFINITY, None);
        let inverse = ray.direction.map(|component| 1.0 / component);
        let mut stack = Vec::with_capacity(STACK);
        stack.push((0.0, 0));
        while let Some((box_distance, index)) = stack.pop() {
            if box_distance > best.0 {
                continue;
            }
            match self.nodes[index].content {
                NodeContent::Inner { right } => {
                    let mut children = [index + 1, index + right as usize].map(|child| {
                        let bounds = &self.nodes[child].bounds;
                        (box_distance_along(bounds, ray, &inverse, best.0), child)
                    });
                    // The nearer one is searched first, so it is pushed last.
                    if children[0].0 < children[1].0 {
                        children.swap(0, 1);
                    }
                    stack.extend(children.into_iter().filter(|child| child.0.is_finite()));
                }
                NodeContent::Leaf { first, len } => {
                    for triangle in self.leaf(first, len) {
                        if let Some((distance, weights)) = triangle.meets(ray)
                            && distance < best.0
                        {
                            best = (distance, Some((triangle, weights)));
                        }
                    }
                }
            }
        }
        let (triangle, weights) = best.1?;
        Some((best.0, triangle, weights))
    }

    /// The surface point nearest to a point.
    pub fn closest(&self, point_mm: &Point3<f64>) -> SurfacePoint {
        let mut best = (f64::INFINITY, &self.triangles[0], [1.0, 0.0, 0.0]);
        let mut stack = Vec::with_capacity(STACK);
        stack.push((0.0, 0));
        while let Some((box_distance2, index)) = stack.pop() {
            if box_distance2 >= best.0 {
                continue;
            }
            match self.nodes[index].content {
                NodeContent::Inner { right } => {
                    let mut children = [index + 1, index + right as usize].map(|child| {
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
                    for triangle in self.leaf(first, len) {
                        let weights = triangle.closest(point_mm);
                        let distance2 = (triangle.position(weights) - point_mm).norm_squared();
                        if distance2 < best.0 {
                            best = (distance2, triangle, weights);
                        }
                    }
                }
            }
        }
        self.point(best.1, best.2)
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

    fn leaf(&self, first: u32, len: u32) -> &[Triangle] {
        &self.triangles[first as usize..(first + len) as usize]
    }

    fn point(&self, triangle: &Triangle, weights: [f64; 3]) -> SurfacePoint {
        let [a, b, c] = triangle.normals.map(|i| self.normals[i as usize]);
        let smooth = a * weights[0] + b * weights[1] + c * weights[2];
        SurfacePoint {
            position_mm: triangle.position(weights),
            normal: Unit::try_new(smooth, 1e-9)
                .unwrap_or_else(|| Unit::new_normalize(triangle.cross())),
        }
    }
}

impl Triangle {
    fn bounds(&self) -> Bounds {
        let [a, b, c] = self.corners;
        Bounds { min_mm: a.inf(&b).inf(&c), max_mm: a.sup(&b).sup(&c) }
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

/// The subtree over `own`, which it sorts: those triangles of the surface from `first` on.
///
/// Where it is cut depends on the number of triangles alone, and so does the result on theirs, not on
/// the number of threads.
fn build(own: &mut [Triangle], first: usize) -> Vec<Node> {
    let mut nodes = Vec::with_capacity(own.len());
    if own.len() >= LEAST_SHARED {
        let bounds = bounds_of(own);
        let middle = halve(own, &bounds);
        let (left, right) = own.split_at_mut(middle);
        let (left, right) = rayon::join(|| build(left, first), || build(right, first + middle));
        nodes.push(Node { bounds, content: NodeContent::Inner { right: 1 + left.len() as u32 } });
        nodes.extend(left);
        nodes.extend(right);
    } else {
        push_subtree(own, first, &mut nodes);
    }
    nodes
}

/// Appends the subtree over `own`.
fn push_subtree(own: &mut [Triangle], first: usize, nodes: &mut Vec<Node>) {
    let index = nodes.len();
    let bounds = bounds_of(own);
    nodes.push(Node {
        bounds,
        content: NodeContent::Leaf { first: first as u32, len: own.len() as u32 },
    });
    if own.len() <= LEAF_TRIANGLES {
        return;
    }
    let middle = halve(own, &bounds);
    let (left, right) = own.split_at_mut(middle);
    push_subtree(left, first, nodes);
    nodes[index].content = NodeContent::Inner { right: (nodes.len() - index) as u32 };
    push_subtree(right, first + middle, nodes);
}

/// Sorts triangles into halves along the longest side of their box; where the second begins.
fn halve(own: &mut [Triangle], bounds: &Bounds) -> usize {
    let axis = bounds.size_mm().imax();
    let middle = own.len() / 2;
    let center = |t: &Triangle| t.corners.iter().map(|p| p[axis]).sum::<f64>();
    own.select_nth_unstable_by(middle, |a, b| center(a).total_cmp(&center(b)));
    middle
}

fn bounds_of(triangles: &[Triangle]) -> Bounds {
    triangles
        .iter()
        .map(Triangle::bounds)
        .reduce(|a, b| Bounds { min_mm: a.min_mm.inf(&b.min_mm), max_mm: a.max_mm.sup(&b.max_mm) })
        .expect("a node has triangles")
}

/// How far along the ray the box begins; infinite where the ray misses it or meets it only beyond
/// `limit_mm` (slab test; NaN from `0 · ∞` on a face counts as met). `inverse` is 1 by direction.
fn box_distance_along(bounds: &Bounds, ray: &Ray, inverse: &Vector3<f64>, limit_mm: f64) -> f64 {
    let (mut near, mut far) = (0.0_f64, limit_mm);
    for k in 0..3 {
        let to_min = (bounds.min_mm[k] - ray.origin_mm[k]) * inverse[k];
        let to_max = (bounds.max_mm[k] - ray.origin_mm[k]) * inverse[k];
        if to_min.is_nan() || to_max.is_nan() {
            continue;
        }
        near = near.max(to_min.min(to_max));
        far = far.min(to_min.max(to_max));
    }
    if near <= far { near } else { f64::INFINITY }
}

#[cfg(test)]
pub(crate) mod tests;
