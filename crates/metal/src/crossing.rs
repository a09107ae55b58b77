//! Whether triangles of a surface cut each other: edges against triangles, along a sweep.

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// Volumes of tetrahedra relative to the cube of the pair's size, below which an edge only touches a
/// triangle's plane or edge: what computing them from coordinates far from the origin leaves.
const TOUCHING: f64 = 1e-9;

/// Sine of the angle below which two triangles of one edge lie on each other.
const FOLDED: f64 = 1e-6;

/// The first pair of triangles, by their numbers, that cut each other or lie folded on each other.
///
/// Triangles are sorted by where they begin along the longest side of all; each is compared with those
/// that begin before it ends and overlap it across. Of a pair with common corners only the edges are
/// looked at that have none of them. Triangles that only touch, such as faces of two boxes put together,
/// do not cut each other.
pub fn first_crossing(
    positions_mm: &[Point3<f64>],
    triangles: &[[u32; 3]],
) -> Option<(usize, usize)> {
    let boxes: Vec<[Point3<f64>; 2]> = triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|i| positions_mm[i as usize]);
            [a.inf(&b).inf(&c), a.sup(&b).sup(&c)]
        })
        .collect();
    let whole = boxes.iter().copied().reduce(|[la, ha], [lb, hb]| [la.inf(&lb), ha.sup(&hb)])?;
    let axis = (whole[1] - whole[0]).imax();
    let mut order: Vec<usize> = (0..triangles.len()).collect();
    order.sort_by(|&a, &b| boxes[a][0][axis].total_cmp(&boxes[b][0][axis]));
    let overlaps = |a: usize, b: usize| {
        (0..3).all(|k| boxes[a][0][k] <= boxes[b][1][k] && boxes[b][0][k] <= boxes[a][1][k])
    };
    let first_of = |at: usize| {
        let one = order[at];
        let begins_before = |other: &&usize| boxes[**other][0][axis] <= boxes[one][1][axis];
        let others = order[at + 1..].iter().take_while(begins_before);
        let cut = |other: &&usize| {
            overlaps(one, **other) && cross(positions_mm, triangles[one], triangles[**other])
        };
        others.filter(cut).map(|&other| (one.min(other), one.max(other))).min()
    };
    (0..order.len()).into_par_iter().filter_map(first_of).min()
}

fn cross(positions_mm: &[Point3<f64>], one: [u32; 3], other: [u32; 3]) -> bool {
    let common = one.iter().filter(|corner| other.contains(corner)).count();
    match common {
        0 | 1 => enters(positions_mm, one, other) || enters(positions_mm, other, one),
        2 => is_folded(positions_mm, one, other),
        _ => true,
    }
}

/// Whether an edge of `one` that has no corner of `other` goes through `other`.
fn enters(positions_mm: &[Point3<f64>], one: [u32; 3], other: [u32; 3]) -> bool {
    let at = |i: u32| positions_mm[i as usize];
    let [a, b, c] = other.map(at);
    (0..3).any(|k| {
        let (from, to) = (one[k], one[(k + 1) % 3]);
        if other.contains(&from) || other.contains(&to) {
            return false;
        }
        let (p, q) = (at(from), at(to));
        let size = (b - a).norm().max((c - a).norm()).max((q - p).norm());
        let least = TOUCHING * size.powi(3);
        let volume = |o: &Point3<f64>, x: &Point3<f64>, y: &Point3<f64>, z: &Point3<f64>| {
            (x - o).dot(&(y - o).cross(&(z - o)))
        };
        let (before, after) = (volume(&p, &a, &b, &c), volume(&q, &a, &b, &c));
        if before.abs() < least || after.abs() < least || (before > 0.0) == (after > 0.0) {
            return false;
        }
        let around = [volume(&p, &q, &a, &b), volume(&p, &q, &b, &c), volume(&p, &q, &c, &a)];
        around.iter().all(|v| *v > least) || around.iter().all(|v| *v < -least)
    })
}

/// Whether two triangles of one edge lie on the same side of it in the same plane.
fn is_folded(positions_mm: &[Point3<f64>], one: [u32; 3], other: [u32; 3]) -> bool {
    let lone = |t: &[u32; 3], of: &[u32; 3]| t.iter().copied().find(|corner| !of.contains(corner));
    let (Some(tip), Some(other_tip)) = (lone(&one, &other), lone(&other, &one)) else {
        return true;
    };
    let at = |i: u32| positions_mm[i as usize];
    let edge: Vec<u32> = one.iter().copied().filter(|corner| *corner != tip).collect();
    let along = (at(edge[1]) - at(edge[0])).normalize();
    let across = |tip: u32| {
        let v: Vector3<f64> = at(tip) - at(edge[0]);
        (v - along * v.dot(&along)).normalize()
    };
    let (u, v) = (across(tip), across(other_tip));
    u.dot(&v) > 0.0 && u.cross(&v).norm() < FOLDED
}

#[cfg(test)]
mod tests {
    use super::*;

    fn crossing(corners: &[[f64; 3]], triangles: &[[u32; 3]]) -> Option<(usize, usize)> {
        let positions: Vec<Point3<f64>> = corners.iter().map(|&c| c.into()).collect();
        first_crossing(&positions, triangles)
    }

    const FLAT: [[f64; 3]; 3] = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];

    #[test]
    fn an_edge_through_a_triangle_crosses() {
        let apart = [[0, 1, 2], [3, 4, 5]];
        let with = |others: [[f64; 3]; 3]| crossing(&[FLAT, others].concat(), &apart);
        assert_eq!(with([[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [9.0, 1.0, 0.5]]), Some((0, 1)));
        // Beside it, above it, with a corner on it, and in its plane.
        assert_eq!(with([[3.0, 3.0, -1.0], [3.0, 3.0, 1.0], [9.0, 1.0, 0.5]]), None);
        assert_eq!(with([[1.0, 1.0, 0.1], [1.0, 1.0, 1.0], [9.0, 1.0, 0.5]]), None);
        assert_eq!(with([[1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [9.0, 1.0, 0.5]]), None);
        assert_eq!(with([[1.0, 1.0, 0.0], [2.0, 1.0, 0.0], [1.0, 2.0, 0.0]]), None);
    }

    #[test]
    fn neighbours_cross_away_from_what_they_share() {
        // One corner in common: the other's far edge goes through, or does not.
        let fan = [[0, 1, 2], [0, 3, 4]];
        let with = |far: [[f64; 3]; 2]| crossing(&[&FLAT[..], &far[..]].concat(), &fan);
        assert_eq!(with([[1.0, 1.0, -1.0], [1.0, 1.0, 1.0]]), Some((0, 1)));
        assert_eq!(with([[-1.0, 1.0, -1.0], [-1.0, 1.0, 1.0]]), None);
        // An edge in common: folded back, or open.
        let hinge = [[0, 1, 2], [1, 0, 3]];
        let with = |tip: [f64; 3]| crossing(&[&FLAT[..], &[tip][..]].concat(), &hinge);
        assert_eq!(with([1.0, 2.0, 0.0]), Some((0, 1)));
        assert_eq!(with([1.0, 2.0, 0.1]), None);
        assert_eq!(with([1.0, -2.0, 0.0]), None);
    }
}
