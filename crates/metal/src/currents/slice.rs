//! Outlines of a closed surface in planes across an axis.

use crate::panel::Panel;
use nalgebra::{Point2, Point3, Rotation3, Vector2};
use std::collections::HashMap;
use std::f64::consts::PI;

/// A turn of an outline beyond this is a corner that is kept.
const CORNER_RAD: f64 = 0.5;

/// More corners than this are a curve of straight pieces.
const MOST_CORNERS: usize = 12;

/// Of a closed polygon, counter-clockwise: twice its area, and its middle.
fn area_and_middle(outline: &[Point2<f64>]) -> (f64, Point2<f64>) {
    let mut twice = 0.0;
    let mut sum = Vector2::zeros();
    for (p, q) in edges(outline) {
        let cross = p.coords.perp(&q.coords);
        twice += cross;
        sum += (p.coords + q.coords) * cross;
    }
    (twice, Point2::from(sum / (3.0 * twice)))
}

fn edges(outline: &[Point2<f64>]) -> impl Iterator<Item = (&Point2<f64>, &Point2<f64>)> {
    outline.iter().zip(outline.iter().cycle().skip(1))
}

/// Where a surface is cut by the plane of a height, in a frame whose third axis is across the plane;
/// counter-clockwise. `None` where the cut is not one outline that is seen whole from its middle.
pub(super) fn outline(
    panels: &[Panel],
    body_from_stack: &Rotation3<f64>,
    height_mm: f64,
) -> Option<Vec<Point2<f64>>> {
    let key = |p: &Point2<f64>| [p.x.to_bits(), p.y.to_bits()];
    let mut next: HashMap<[u64; 2], Point2<f64>> = HashMap::new();
    let mut start = None;
    for panel in panels {
        let corners = panel.corners_mm().map(|p| body_from_stack.inverse_transform_point(&p));
        let is_above = corners.map(|p| p.z >= height_mm);
        // Metal is to the left of a cut that enters the half space above.
        let (mut enters, mut leaves) = (None, None);
        for k in 0..3 {
            let (from, to) = (k, (k + 1) % 3);
            match (is_above[from], is_above[to]) {
                (false, true) => enters = Some(crossing(&corners[from], &corners[to], height_mm)),
                (true, false) => leaves = Some(crossing(&corners[from], &corners[to], height_mm)),
                _ => {}
            }
        }
        if let (Some(from), Some(to)) = (leaves, enters)
            && from != to
        {
            next.insert(key(&from), to);
            start.get_or_insert(from);
        }
    }
    let start = start?;
    let mut outline = vec![start];
    while let Some(point) = next.remove(&key(outline.last()?)) {
        if point == start {
            break;
        }
        outline.push(point);
    }
    let (twice_area, middle) = area_and_middle(&outline);
    if twice_area < 0.0 {
        outline.reverse();
    }
    let is_seen = |(p, q): (&Point2<f64>, &Point2<f64>)| (p - middle).perp(&(q - middle)) > 0.0;
    (next.is_empty() && outline.len() > 2 && edges(&outline).all(is_seen)).then_some(outline)
}

/// Of an edge, the same to the bit from both of its triangles.
fn crossing(a: &Point3<f64>, b: &Point3<f64>, height_mm: f64) -> Point2<f64> {
    let (low, high) = if a.z < b.z { (a, b) } else { (b, a) };
    let part = (height_mm - low.z) / (high.z - low.z);
    (low + (high - low) * part).xy()
}

/// An outline of so many points and the same area, finer towards its corners.
pub(super) fn resampled(outline: &[Point2<f64>], count: usize) -> Vec<Point2<f64>> {
    let (twice_area, middle) = area_and_middle(outline);
    let low = outline.iter().fold(outline[0], |low, p| low.inf(p));
    let high = outline.iter().fold(outline[0], |high, p| high.sup(p));
    // Of a narrow outline the short sides have points as well.
    let size = (high - low).map(|edge| edge.max(f64::MIN_POSITIVE));
    let scaled = |v: Vector2<f64>| v.component_div(&size).norm();
    let points = outline.len();
    let side = |k: usize| outline[(k + 1) % points] - outline[k % points];
    let is_corner = |k: usize| {
        let (before, after) = (side(k + points - 1), side(k));
        before.perp(&after).atan2(before.dot(&after)) > CORNER_RAD
    };
    let mut corners: Vec<usize> = (0..points).filter(|&k| is_corner(k)).collect();
    let is_curve = corners.is_empty() || corners.len() > MOST_CORNERS;
    if is_curve {
        corners = vec![0];
    }
    let whole: f64 = (0..points).map(|k| scaled(side(k))).sum();
    let mut found = Vec::new();
    for (at, &first) in corners.iter().enumerate() {
        let last = corners.get(at + 1).map_or(corners[0] + points, |next| *next);
        let lengths: Vec<f64> = (first..last).map(|k| scaled(side(k))).collect();
        let length: f64 = lengths.iter().sum();
        let parts = ((count as f64 * length / whole).round() as usize).max(2);
        for k in 0..parts {
            let part = k as f64 / parts as f64;
            let part = if is_curve { part } else { 0.5 - 0.5 * (PI * part).cos() };
            let mut left = part * length;
            let mut segment = 0;
            while segment + 1 < lengths.len() && left > lengths[segment] {
                left -= lengths[segment];
                segment += 1;
            }
            let along = (left / lengths[segment].max(f64::MIN_POSITIVE)).min(1.0);
            found.push(outline[(first + segment) % points] + side(first + segment) * along);
        }
    }
    let (own, _) = area_and_middle(&found);
    let scale = (twice_area / own).sqrt();
    found.iter().map(|p| middle + (p - middle) * scale).collect()
}

/// Middle of an outline.
pub(super) fn middle(outline: &[Point2<f64>]) -> Point2<f64> {
    area_and_middle(outline).1
}
