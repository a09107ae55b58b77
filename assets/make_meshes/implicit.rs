//! Surfaces given by a function that is negative inside: blending them, meeting them, meshing them.

use std::collections::HashMap;

use crate::shape::Shape;
use crate::vector::{Vec3, VecExt, vec3};

/// Step of the central differences that give a gradient: small beside any curve of a head.
const GRADIENT_STEP_MM: f64 = 0.01;

/// Steps that draw a mesh point onto the surface; blends of distances converge within five.
const PROJECTION_STEPS: usize = 8;

/// A solid by its signed function, roughly a distance in millimetres, negative inside.
pub trait Solid {
    fn value_mm(&self, point: Vec3) -> f64;

    /// Direction in which the value grows: the surface's outward normal.
    fn outward(&self, point: Vec3) -> Vec3 {
        self.gradient(point).normalized()
    }

    fn gradient(&self, point: Vec3) -> Vec3 {
        let h = GRADIENT_STEP_MM;
        let along =
            |step: Vec3| (self.value_mm(point + step) - self.value_mm(point - step)) / (2.0 * h);
        vec3(along(Vec3::x() * h), along(Vec3::y() * h), along(Vec3::z() * h))
    }

    /// How far from `origin`, which is outside, a ray first meets the surface, up to `limit_mm`.
    fn first_hit_mm(&self, origin: Vec3, direction: Vec3, limit_mm: f64) -> Option<f64> {
        /// Finer than the thinnest feature, an ear's rim.
        const STEP_MM: f64 = 1.0;
        let direction = direction.normalized();
        let value = |t: f64| self.value_mm(origin + direction * t);
        let mut outside = 0.0;
        while outside < limit_mm {
            let mut inside = outside + STEP_MM;
            if value(inside) <= 0.0 {
                for _ in 0..40 {
                    let middle = 0.5 * (outside + inside);
                    if value(middle) <= 0.0 {
                        inside = middle;
                    } else {
                        outside = middle;
                    }
                }
                return Some(inside);
            }
            outside = inside;
        }
        None
    }
}

/// Union whose seam is rounded over about `blend_mm` (polynomial smooth minimum, Quilez 2013).
pub fn union(a: f64, b: f64, blend_mm: f64) -> f64 {
    let h = (blend_mm - (a - b).abs()).max(0.0) / blend_mm;
    // Cubic, so that the normal has no kink where the blend begins.
    a.min(b) - h * h * h * blend_mm / 6.0
}

/// `a` without `b`, with a rounded seam.
pub fn without(a: f64, b: f64, blend_mm: f64) -> f64 {
    -union(-a, b, blend_mm)
}

/// Common part, with a rounded seam.
pub fn common(a: f64, b: f64, blend_mm: f64) -> f64 {
    -union(-a, -b, blend_mm)
}

/// Signed distance to an ellipsoid, to first order (Quilez 2008): exact on the surface.
pub fn ellipsoid(point: Vec3, centre: Vec3, radii: Vec3) -> f64 {
    let offset = point - centre;
    let inverse = vec3(1.0 / radii.x, 1.0 / radii.y, 1.0 / radii.z);
    let k0 = offset.component_mul(&inverse).norm();
    let k1 = offset.component_mul(&inverse).component_mul(&inverse).norm();
    if k1 < 1e-9 {
        return -radii.x.min(radii.y).min(radii.z);
    }
    k0 * (k0 - 1.0) / k1
}

/// A capsule whose radius goes from `radius_a` to `radius_b` along its axis.
pub fn capsule(point: Vec3, [a, b]: [Vec3; 2], [radius_a, radius_b]: [f64; 2]) -> f64 {
    let axis = b - a;
    let t = ((point - a).dot(&axis) / axis.dot(&axis)).clamp(0.0, 1.0);
    (point - a.between(b, t)).norm() - (radius_a + (radius_b - radius_a) * t)
}

/// Grid lines along one axis: sections `(from, step)` up to `end`, steps rounded to fit.
pub fn grid_lines(sections: &[(f64, f64)], end: f64) -> Vec<f64> {
    let mut lines = Vec::new();
    for (i, &(from, step)) in sections.iter().enumerate() {
        let to = sections.get(i + 1).map_or(end, |next| next.0);
        let pieces = ((to - from) / step).round().max(1.0) as usize;
        lines.extend((0..pieces).map(|j| from + (to - from) * j as f64 / pieces as f64));
    }
    lines.push(end);
    lines
}

/// Meshes the surface on a grid by naive surface nets (Gibson 1998): one point a cell that the
/// surface crosses, drawn onto the surface, and one four-sided face a grid edge that it crosses.
///
/// The surface must lie within the grid and be smooth at the grid's scale.
pub fn meshed(solid: &impl Solid, [xs, ys, zs]: [&[f64]; 3]) -> Shape {
    let size = [xs.len(), ys.len(), zs.len()];
    let node = |i: [usize; 3]| vec3(xs[i[0]], ys[i[1]], zs[i[2]]);
    let flat = |i: [usize; 3]| (i[2] * size[1] + i[1]) * size[0] + i[0];
    let mut values = Vec::with_capacity(size.iter().product());
    for z in 0..size[2] {
        for y in 0..size[1] {
            values.extend((0..size[0]).map(|x| solid.value_mm(node([x, y, z]))));
        }
    }
    let value = |i: [usize; 3]| values[flat(i)];
    let mut shape = Shape::default();
    let mut point_of_cell = HashMap::new();
    for cell in cells(size) {
        let corners: [[usize; 3]; 8] =
            std::array::from_fn(|k| [0, 1, 2].map(|axis| cell[axis] + (k >> axis & 1)));
        let mut sum = Vec3::default();
        let mut crossings = 0.0;
        for (k, &a) in corners.iter().enumerate() {
            for axis in 0..3 {
                let b = corners[k | 1 << axis];
                let (from, to) = (value(a), value(b));
                if a != b && (from < 0.0) != (to < 0.0) {
                    sum += node(a).between(node(b), from / (from - to));
                    crossings += 1.0;
                }
            }
        }
        if crossings > 0.0 {
            point_of_cell.insert(cell, shape.points.len() as u32);
            shape.points.push(projected(solid, sum * (1.0 / crossings)));
        }
    }
    for cell in cells(size) {
        for axis in 0..3 {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let mut ahead = cell;
            ahead[axis] += 1;
            let (from, to) = (value(cell), value(ahead));
            if (from < 0.0) == (to < 0.0) || cell[u] == 0 || cell[v] == 0 {
                continue;
            }
            let around = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[du, dv]| {
                let mut neighbour = cell;
                neighbour[u] -= 1 - du;
                neighbour[v] -= 1 - dv;
                point_of_cell[&neighbour]
            });
            let [a, b, c, d] =
                if from < 0.0 { around } else { [around[0], around[3], around[2], around[1]] };
            push_quad(&mut shape, [a, b, c, d]);
        }
    }
    shape.normals = Some(shape.points.iter().map(|&point| solid.outward(point)).collect());
    shape
}

/// All cells of a grid with `size` nodes, in a fixed order.
fn cells(size: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    let [nx, ny, nz] = size.map(|n| n - 1);
    (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])))
}

fn projected(solid: &impl Solid, mut point: Vec3) -> Vec3 {
    for _ in 0..PROJECTION_STEPS {
        let gradient = solid.gradient(point);
        let steepness = gradient.dot(&gradient).max(0.05);
        point = point - gradient * (solid.value_mm(point) / steepness);
    }
    point
}

/// Adds a face cut along its shorter diagonal.
fn push_quad(shape: &mut Shape, [a, b, c, d]: [u32; 4]) {
    let length = |i: u32, j: u32| (shape.points[i as usize] - shape.points[j as usize]).norm();
    if length(a, c) < length(b, d) + 1e-9 {
        shape.triangles.extend([[a, b, c], [a, c, d]]);
    } else {
        shape.triangles.extend([[a, b, d], [b, c, d]]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checks::{open_edge_count, volume_mm3};
    use std::f64::consts::PI;

    struct Ball;

    impl Solid for Ball {
        fn value_mm(&self, point: Vec3) -> f64 {
            ellipsoid(point, Vec3::default(), vec3(10.0, 10.0, 10.0))
        }
    }

    #[test]
    fn a_ball_is_closed_round_and_looks_outwards() {
        let lines = grid_lines(&[(-12.0, 2.0), (0.0, 1.0)], 12.0);
        let shape = meshed(&Ball, [&lines, &lines, &lines]);
        assert_eq!(open_edge_count(&shape), 0);
        assert!(shape.points.iter().all(|point| (point.norm() - 10.0).abs() < 1e-9));
        assert!((volume_mm3(&shape) / (4.0 / 3.0 * PI * 1000.0) - 1.0).abs() < 0.02);
    }

    #[test]
    fn a_ray_meets_the_ball_where_it_should() {
        let hit = Ball.first_hit_mm(vec3(0.0, 6.0, -30.0), Vec3::z(), 60.0);
        assert!((hit.unwrap() - 22.0).abs() < 1e-6);
        assert!(Ball.first_hit_mm(vec3(0.0, 11.0, -30.0), Vec3::z(), 60.0).is_none());
    }
}
