//! Cuts an isosurface, and the tetrahedra of its volume, to where a second scalar is at most zero.
//!
//! Both scalars are linear in the same tetrahedra, so the pieces fit without a gap, and what is cut
//! off of the volume is exact for them.

use super::{Isosurface, low_part, part};
use nalgebra::{Matrix3, Vector4};
use std::collections::HashMap;

/// Takes away what lies where the scalar, one number a vertex, is above zero.
pub(super) fn clip(surface: &mut Isosurface, excess: &[f64]) {
    let mut cut = Cut { vertex_of_edge: HashMap::new(), excess };
    let triangles = std::mem::take(&mut surface.triangles);
    for triangle in triangles {
        let polygon = cut.polygon(surface, triangle);
        for k in 2..polygon.len() {
            let corners = [polygon[0], polygon[k - 1], polygon[k]];
            // Where the cut goes through a corner two of them are the same.
            if corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0] {
                surface.triangles.push(corners);
            }
        }
    }
    drop_unused(surface);
}

struct Cut<'a> {
    vertex_of_edge: HashMap<(u32, u32), u32>,
    excess: &'a [f64],
}

impl Cut<'_> {
    /// What is left of a triangle, in the same turn.
    fn polygon(&mut self, surface: &mut Isosurface, triangle: [u32; 3]) -> Vec<u32> {
        let mut left = Vec::with_capacity(4);
        for k in 0..3 {
            let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
            let [at_a, at_b] = [a, b].map(|vertex| self.excess[vertex as usize] <= 0.0);
            if at_a {
                left.push(a);
            }
            if at_a != at_b {
                let (within, beyond) = if at_a { (a, b) } else { (b, a) };
                left.push(self.vertex(surface, within, beyond));
            }
        }
        left
    }

    /// Where the cut meets an edge, made when first needed.
    fn vertex(&mut self, surface: &mut Isosurface, within: u32, beyond: u32) -> u32 {
        let next = surface.positions_mm.len() as u32;
        let [from, to] = [within, beyond].map(|vertex| vertex as usize);
        let part = part(self.excess[from], self.excess[to], 0.0);
        if part == 0.0 {
            return within;
        }
        *self.vertex_of_edge.entry((within, beyond)).or_insert_with(|| {
            let (positions, normals) = (&mut surface.positions_mm, &mut surface.normals);
            positions.push(positions[from] + (positions[to] - positions[from]) * part);
            normals.push(normals[from] * (1.0 - part) + normals[to] * part);
            next
        })
    }
}

/// Vertices beyond the cut go, the others keep their order.
fn drop_unused(surface: &mut Isosurface) {
    let mut place_of = vec![u32::MAX; surface.positions_mm.len()];
    for vertex in surface.triangles.iter().flatten() {
        place_of[*vertex as usize] = 0;
    }
    let mut kept = Isosurface::default();
    for (vertex, place) in place_of.iter_mut().enumerate().filter(|(_, p)| **p == 0) {
        *place = kept.positions_mm.len() as u32;
        kept.positions_mm.push(surface.positions_mm[vertex]);
        kept.normals.push(surface.normals[vertex]);
    }
    for triangle in &surface.triangles {
        let places = triangle.map(|vertex| place_of[vertex as usize]);
        kept.triangles.push(places);
    }
    *surface = kept;
}

/// A corner of a piece of a tetrahedron: what of each of its four corners it is made of, and the
/// scalar there.
#[derive(Clone, Copy)]
struct Corner {
    shares: Vector4<f64>,
    value: f64,
}

/// Which part of a tetrahedron is both within and at most the level, and which is within, from what
/// its corners have.
pub(super) fn low_and_whole(values: [f64; 4], level: f64, excess: [f64; 4]) -> [f64; 2] {
    let corner = |k: usize| Corner { shares: Vector4::ith(k, 1.0), value: values[k] };
    // Where the cut meets the edge from a corner within to one beyond.
    let on = |from: usize, to: usize| {
        let part = part(excess[from], excess[to], 0.0);
        let between = match part {
            // An infinite value counts wherever the edge leaves its other end.
            0.0 => values[from],
            part => values[from] * (1.0 - part) + values[to] * part,
        };
        Corner { shares: Vector4::ith(from, 1.0 - part) + Vector4::ith(to, part), value: between }
    };
    let (within, beyond): (Vec<usize>, Vec<usize>) = (0..4).partition(|k| excess[*k] <= 0.0);
    let pieces: Vec<[Corner; 4]> = match (within.as_slice(), beyond.as_slice()) {
        (_, []) => vec![[0, 1, 2, 3].map(corner)],
        (&[a], &[b, c, d]) => vec![[corner(a), on(a, b), on(a, c), on(a, d)]],
        (&[a, b, c], &[d]) => {
            prism([corner(a), corner(b), corner(c)], [on(a, d), on(b, d), on(c, d)])
        }
        (&[a, b], &[c, d]) => {
            prism([corner(a), on(a, c), on(a, d)], [corner(b), on(b, c), on(b, d)])
        }
        _ => Vec::new(),
    };
    let mut sums = [0.0; 2];
    for piece in pieces {
        let whole = share_of(&piece);
        let (low, high): (Vec<usize>, Vec<usize>) = (0..4).partition(|k| piece[*k].value <= level);
        let low = low_part(&low, &high, |a, b| part(piece[a].value, piece[b].value, level));
        sums = [sums[0] + whole * low, sums[1] + whole];
    }
    sums
}

/// Between two triangles whose corners belong together, as three tetrahedra.
fn prism(p: [Corner; 3], q: [Corner; 3]) -> Vec<[Corner; 4]> {
    vec![[p[0], p[1], p[2], q[2]], [p[0], p[1], q[1], q[2]], [p[0], q[0], q[1], q[2]]]
}

/// How much of the tetrahedron a piece of it is.
fn share_of(piece: &[Corner; 4]) -> f64 {
    let edges = [1, 2, 3].map(|k| (piece[k].shares - piece[0].shares).xyz());
    Matrix3::from_columns(&edges).determinant().abs()
}

#[cfg(test)]
mod tests {
    use super::super::tests::lattice;
    use nalgebra::{Point3, Vector3};
    use std::f64::consts::PI;

    #[test]
    fn two_planes_leave_a_quarter_of_the_box() {
        let center = Point3::new(2.0, 4.0, 0.0);
        let [normal, other] = [Vector3::new(0.6, 0.0, 0.8), Vector3::new(0.8, 0.0, -0.6)];
        let counts = [5, 7, 4];
        let values = lattice(counts, |p| normal.dot(&(p - center)));
        let excess = lattice(counts, |p| other.dot(&(p - center))).values;
        let clipped = values.clipped_isosurface(0.0, Some(&excess));
        let whole = values.bounds.size_mm().product();
        // The box is as long along x as along z, so both planes halve it and each other.
        assert!((clipped.whole_mm3 - whole / 2.0).abs() < 1e-12 * whole);
        assert!((clipped.surface.volume_mm3 - whole / 4.0).abs() < 1e-12 * whole);
        let surface = &clipped.surface;
        let mut area = 0.0;
        for [a, b, c] in &surface.triangles {
            let [a, b, c] = [a, b, c].map(|v| surface.positions_mm[*v as usize]);
            let double = (b - a).cross(&(c - a));
            assert!(double.dot(&normal) > 0.0);
            area += double.norm() / 2.0;
        }
        for (p, n) in surface.positions_mm.iter().zip(&surface.normals) {
            assert!(normal.dot(&(p - center)).abs() < 1e-12 && other.dot(&(p - center)) < 1e-12);
            assert!((n - normal).norm() < 1e-9);
        }
        // From the middle to the box's face, 12 mm along z, and 24 mm along y.
        assert!((area - 12.0 / 0.8 * 24.0).abs() < 1e-9, "{area}");
    }

    #[test]
    fn a_plane_halves_a_ball() {
        let center = Point3::new(2.0, 4.0, 0.0);
        let counts = [31, 31, 31];
        let values = lattice(counts, |p| (p - center).norm_squared());
        let slant = Vector3::new(1.0, 2.0, 3.0);
        let excess = lattice(counts, |p| slant.dot(&(p - center))).values;
        let radius: f64 = 7.0;
        let all = values.isosurface(radius * radius);
        let half = values.clipped_isosurface(radius * radius, Some(&excess));
        // The lattice is the same seen from the other side of the middle.
        let volume = half.surface.volume_mm3;
        assert!((volume - all.volume_mm3 / 2.0).abs() < 1e-9 * volume);
        assert!((volume / (2.0 / 3.0 * PI * radius.powi(3)) - 1.0).abs() < 0.02);
        assert!(half.surface.positions_mm.len() < all.positions_mm.len());
    }

    #[test]
    fn infinite_values_beyond_the_cut_do_not_count() {
        let counts = [13, 3, 3];
        let values = lattice(counts, |p| if p.x > 3.0 { f64::INFINITY } else { 1.0 });
        let excess = lattice(counts, |p| p.x - 3.0).values;
        let clipped = values.clipped_isosurface(2.0, Some(&excess));
        let face = 24.0 * 24.0;
        assert!((clipped.whole_mm3 - 13.0 * face).abs() < 1e-9);
        assert!((clipped.surface.volume_mm3 - 12.0 * face).abs() < 1e-9);
    }

    #[test]
    fn what_is_cut_away_altogether_leaves_nothing() {
        let counts = [3, 3, 3];
        let values = lattice(counts, |p| p.x);
        let nothing = values.clipped_isosurface(0.0, Some(&[1.0; 27]));
        assert_eq!(nothing, Default::default());
        let none = values.clipped_isosurface(0.0, Some(&[-1.0; 26]));
        assert_eq!(none, Default::default());
    }
}
