//! Profiles with rounded corners, and the bodies made by turning, extruding or sweeping them.

use std::f64::consts::{PI, TAU};

use crate::shape::{Shape, ShapeBuilder};
use crate::vector::{Placement, Vec3, VecExt, vec3};

/// Greatest turn of one straight piece of a rounded corner: below the crease angle, and fine
/// enough for fillets of a fraction of a millimetre.
const MAX_TURN_DEG: f64 = 30.0;

/// Greatest gap between an arc and its chord: invisible at any zoom that shows a whole tool.
const MAX_SAG_MM: f64 = 0.02;

/// A corner of a profile: where it is along the axis, how far out, and how it is rounded.
///
/// `outset_mm` is the radius of a turned part, or the distance outwards from a reference outline.
#[derive(Clone, Copy, Debug)]
pub struct Corner {
    pub z_mm: f64,
    pub outset_mm: f64,
    pub fillet_mm: f64,
}

/// Shorthand for a [`Corner`]: profiles are tables and should read as such.
pub const fn at(z_mm: f64, outset_mm: f64, fillet_mm: f64) -> Corner {
    Corner { z_mm, outset_mm, fillet_mm }
}

/// The profile as a polyline of `[z, outset]`, its corners replaced by arcs.
///
/// Where two fillets want more than the edge between them has, they share it in proportion.
pub fn rounded(corners: &[Corner]) -> Vec<[f64; 2]> {
    let reach: Vec<f64> = (0..corners.len()).map(|i| wanted_reach_mm(corners, i)).collect();
    let mut points: Vec<[f64; 2]> = Vec::new();
    for (i, corner) in corners.iter().enumerate() {
        let centre = [corner.z_mm, corner.outset_mm];
        if reach[i] <= 0.0 {
            points.push(centre);
            continue;
        }
        let share = |j: usize| {
            let edge_mm = distance(centre, [corners[j].z_mm, corners[j].outset_mm]);
            (edge_mm / (reach[i] + reach[j])).min(1.0)
        };
        let (previous, next) = (&corners[i - 1], &corners[i + 1]);
        let tangent_mm = reach[i] * share(i - 1).min(share(i + 1));
        let start = towards(centre, [previous.z_mm, previous.outset_mm], tangent_mm);
        let end = towards(centre, [next.z_mm, next.outset_mm], tangent_mm);
        push_arc(&mut points, start, centre, end, tangent_mm);
    }
    points.dedup_by(|a, b| distance(*a, *b) < 1e-3);
    points
}

/// A body turned around +z.
pub fn turned(corners: &[Corner], segments: usize) -> Shape {
    lofted(corners, |radius_mm| circle(radius_mm, segments))
}

/// A body whose cross-section at each profile point is `outline(outset)`, counter-clockwise.
pub fn lofted(corners: &[Corner], outline: impl Fn(f64) -> Vec<[f64; 2]>) -> Shape {
    let rings: Vec<Vec<Vec3>> = rounded(corners)
        .iter()
        .map(|&[z, outset]| outline(outset).iter().map(|&[x, y]| vec3(x, y, z)).collect())
        .collect();
    skinned(&rings, 1)
}

/// A skin over rings of equal length, counter-clockwise seen from ahead, its ends closed by
/// `cap_rings` shrinking copies and a fan around the middle.
pub fn skinned(rings: &[Vec<Vec3>], cap_rings: usize) -> Shape {
    let mut builder = ShapeBuilder::default();
    let (Some(first), Some(last)) = (rings.first(), rings.last()) else {
        return builder.finish();
    };
    let shrunk = |ring: &[Vec3], step: usize| {
        let middle = middle_of(ring);
        let t = step as f64 / cap_rings as f64;
        ring.iter().map(|&point| point.between(middle, t)).collect::<Vec<_>>()
    };
    for step in (0..cap_rings).rev() {
        add_band(&mut builder, &shrunk(first, step + 1), &shrunk(first, step));
    }
    for pair in rings.windows(2) {
        add_band(&mut builder, &pair[0], &pair[1]);
    }
    for step in 0..cap_rings {
        add_band(&mut builder, &shrunk(last, step), &shrunk(last, step + 1));
    }
    builder.finish()
}

/// A skin over rings that run around and meet again, like a headband.
pub fn skinned_loop(rings: &[Vec<Vec3>]) -> Shape {
    let mut builder = ShapeBuilder::default();
    for (i, ring) in rings.iter().enumerate() {
        add_band(&mut builder, ring, &rings[(i + 1) % rings.len()]);
    }
    builder.finish()
}

/// A round cable along a path, with flat ends whose edges are rounded.
pub fn cable(path: &[Vec3], radius_mm: f64, segments: usize) -> Shape {
    const END_STEPS: usize = 4;
    let mut rings = Vec::new();
    // Any direction across the path's beginning will do.
    let mut side = match path {
        [a, b, ..] if (*b - *a).normalized().y.abs() < 0.8 => Vec3::y(),
        _ => Vec3::x(),
    };
    for (i, &point) in path.iter().enumerate() {
        let ahead = path[(i + 1).min(path.len() - 1)] - path[i.saturating_sub(1)];
        // Carrying the side along keeps the cable from twisting.
        let frame = Placement::new(point, ahead, side);
        side = frame.x_axis;
        let ring = |radius_mm: f64, z_mm: f64| {
            let outline = circle(radius_mm, segments);
            let lift = |&[x, y]: &[f64; 2]| frame.body_from_part(vec3(x, y, z_mm));
            outline.iter().map(lift).collect::<Vec<_>>()
        };
        rings.push(ring(radius_mm, 0.0));
        if i + 1 == path.len() {
            let edge_mm = 0.3 * radius_mm;
            for step in 1..=END_STEPS {
                let (sin, cos) = (step as f64 / END_STEPS as f64 * PI / 2.0).sin_cos();
                rings.push(ring(radius_mm - edge_mm * (1.0 - cos), edge_mm * sin));
            }
        }
    }
    skinned(&rings, 1)
}

/// Points on the cubic Bézier curve of four control points, ends included.
pub fn bezier([a, b, c, d]: [Vec3; 4], pieces: usize) -> Vec<Vec3> {
    let on_curve = |i: usize| {
        let t = i as f64 / pieces as f64;
        let s = 1.0 - t;
        a * (s * s * s) + b * (3.0 * s * s * t) + c * (3.0 * s * t * t) + d * (t * t * t)
    };
    (0..=pieces).map(on_curve).collect()
}

/// A circle around the axis.
pub fn circle(radius_mm: f64, segments: usize) -> Vec<[f64; 2]> {
    let on_circle = |i: usize| {
        let (sin, cos) = (i as f64 / segments as f64 * TAU).sin_cos();
        [radius_mm * cos, radius_mm * sin]
    };
    (0..segments).map(on_circle).collect()
}

/// A rectangle with round corners; its straight sides come in pieces so that it can bend.
#[derive(Clone, Copy, Debug)]
pub struct RoundedRectangle {
    pub half_width_mm: f64,
    pub half_height_mm: f64,
    pub corner_mm: f64,
    pub corner_pieces: usize,
    /// Pieces of each side along the width, and along the height.
    pub side_pieces: [usize; 2],
}

impl RoundedRectangle {
    /// The outline moved outwards by `outset_mm` (inwards if negative), with equally many points.
    pub fn outline(&self, outset_mm: f64) -> Vec<[f64; 2]> {
        /// Corners stay this round, so that neighbouring points never meet.
        const MIN_CORNER_MM: f64 = 0.05;
        let corner = (self.corner_mm + outset_mm).max(MIN_CORNER_MM);
        let (w, h) =
            (self.half_width_mm + outset_mm - corner, self.half_height_mm + outset_mm - corner);
        let mut points: Vec<[f64; 2]> = Vec::new();
        for (quarter, [cx, cy]) in [[w, h], [-w, h], [-w, -h], [w, -h]].into_iter().enumerate() {
            for i in 0..=self.corner_pieces {
                let angle = (quarter as f64 + i as f64 / self.corner_pieces as f64) * PI / 2.0;
                points.push([cx + corner * angle.cos(), cy + corner * angle.sin()]);
            }
            let from = [cx, cy];
            let to = [[w, h], [-w, h], [-w, -h], [w, -h]][(quarter + 1) % 4];
            let end = points[points.len() - 1];
            let side_pieces = self.side_pieces[quarter % 2];
            for i in 1..side_pieces {
                let t = i as f64 / side_pieces as f64;
                points.push([end[0] + (to[0] - from[0]) * t, end[1] + (to[1] - from[1]) * t]);
            }
        }
        points
    }
}

fn add_band(builder: &mut ShapeBuilder, ring: &[Vec3], next: &[Vec3]) {
    for j in 0..ring.len() {
        let k = (j + 1) % ring.len();
        builder.quad([ring[j], ring[k], next[k], next[j]]);
    }
}

fn middle_of(ring: &[Vec3]) -> Vec3 {
    ring.iter().fold(Vec3::default(), |sum, &point| sum + point) * (1.0 / ring.len() as f64)
}

/// How far along its edges a corner's fillet begins, were there room enough.
fn wanted_reach_mm(corners: &[Corner], i: usize) -> f64 {
    if i == 0 || i + 1 == corners.len() || corners[i].fillet_mm <= 0.0 {
        return 0.0;
    }
    let [a, b, c] = [i - 1, i, i + 1].map(|j| [corners[j].z_mm, corners[j].outset_mm]);
    corners[i].fillet_mm * (turn_rad(a, b, c) / 2.0).tan()
}

/// The change of direction at `b` on the way from `a` to `c`.
fn turn_rad(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    let (u, v) = ([b[0] - a[0], b[1] - a[1]], [c[0] - b[0], c[1] - b[1]]);
    (u[0] * v[1] - u[1] * v[0]).atan2(u[0] * v[0] + u[1] * v[1]).abs()
}

/// Adds the arc that touches `start`-`centre` at `start` and `centre`-`end` at `end`.
fn push_arc(
    points: &mut Vec<[f64; 2]>,
    start: [f64; 2],
    centre: [f64; 2],
    end: [f64; 2],
    tangent_mm: f64,
) {
    let turn = turn_rad(start, centre, end);
    if turn < 1e-6 {
        points.push(centre);
        return;
    }
    let radius_mm = tangent_mm / (turn / 2.0).tan();
    let by_turn = turn / MAX_TURN_DEG.to_radians();
    let by_sag = turn / (2.0 * (1.0 - MAX_SAG_MM / radius_mm).clamp(-1.0, 1.0).acos());
    let pieces = by_turn.max(by_sag).ceil().max(1.0) as usize;
    // An arc is a rational quadratic curve whose middle weight is the cosine of half its turn;
    // sampling it by angle keeps the pieces equal.
    for i in 0..=pieces {
        let angle = turn * i as f64 / pieces as f64;
        let (a, c) = ((turn - angle) / 2.0, angle / 2.0);
        let (a, c) = (a.sin(), c.sin());
        let weights = [a * a, 2.0 * a * c * (turn / 2.0).cos(), c * c];
        let sum: f64 = weights.iter().sum();
        points.push(
            [0, 1].map(|k| {
                (weights[0] * start[k] + weights[1] * centre[k] + weights[2] * end[k]) / sum
            }),
        );
    }
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

fn towards(from: [f64; 2], to: [f64; 2], step_mm: f64) -> [f64; 2] {
    let t = step_mm / distance(from, to);
    [from[0] + (to[0] - from[0]) * t, from[1] + (to[1] - from[1]) * t]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checks::{open_edge_count, volume_mm3};
    use crate::shape::bounds_mm;

    #[test]
    fn a_fillet_is_a_true_arc() {
        let points = rounded(&[at(0.0, 0.0, 0.0), at(0.0, 5.0, 2.0), at(9.0, 5.0, 0.0)]);
        for [z, r] in &points[1..points.len() - 1] {
            let from_centre_mm = (z - 2.0).hypot(r - 3.0);
            assert!((from_centre_mm - 2.0).abs() < 1e-9, "({z}, {r})");
        }
    }

    #[test]
    fn a_turned_cylinder_has_its_volume() {
        let corners =
            [at(0.0, 0.0, 0.0), at(0.0, 5.0, 0.0), at(10.0, 5.0, 0.0), at(10.0, 0.0, 0.0)];
        let shape = turned(&corners, 90);
        assert_eq!(open_edge_count(&shape), 0);
        let expected_mm3 = PI * 25.0 * 10.0;
        assert!((volume_mm3(&shape) / expected_mm3 - 1.0).abs() < 2e-3);
    }

    #[test]
    fn crowded_fillets_share_their_edge() {
        let corners = [at(0.0, 0.0, 0.0), at(0.0, 2.0, 9.0), at(3.0, 2.0, 9.0), at(3.0, 0.0, 0.0)];
        let shape = turned(&corners, 24);
        assert_eq!(open_edge_count(&shape), 0);
        let (low, high) = bounds_mm(&shape.points);
        assert!(low.z > -1e-9 && high.z < 3.0 + 1e-9 && high.x < 2.0 + 1e-9);
    }
}
