//! A flat triangle with an even charge: its field anywhere.
//!
//! The field is `E(p) = ∫ (p − s)/|p − s|³ dS`: along the normal the solid angle of the triangle
//! (Van Oosterom and Strackee, IEEE Trans. Biomedical Engineering 30(2), 1983), along the triangle one
//! logarithm an edge (Wilton et al., IEEE Trans. Antennas and Propagation 32(3), 1984).

use nalgebra::{Matrix3, Point3, Unit, Vector3};
use std::f64::consts::PI;

/// Beyond this many times its circumradius a triangle's field is that of its charge and of the second
/// moments of it. What is left out are third moments: below 4·10⁻⁴ of the field there.
pub(crate) const FAR: f64 = 7.93;

/// From this many times its circumradius on a triangle's field is that of charges at some of its points. What is left
/// out is below 2·10⁻⁴ of the field there.
pub(crate) const MIDDLE: f64 = 2.5;

/// A rule of degree 2: points in the middle between the middle and each corner, weights alike.
pub(crate) const RULE: [[f64; 3]; 3] = [
    [2.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0],
    [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0],
    [1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0],
];

/// Points by their barycentric coordinates, with weights, of degree 5 (Dunavant, Int. J. Numerical Methods in
/// Engineering 21, 1985).
pub(crate) const FINE: [([f64; 3], f64); 7] = [
    ([1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0], 0.225),
    ([0.059_715_871_789_77, 0.470_142_064_105_115, 0.470_142_064_105_115], 0.132_394_152_788_506),
    ([0.470_142_064_105_115, 0.059_715_871_789_77, 0.470_142_064_105_115], 0.132_394_152_788_506),
    ([0.470_142_064_105_115, 0.470_142_064_105_115, 0.059_715_871_789_77], 0.132_394_152_788_506),
    ([0.797_426_985_353_087, 0.101_286_507_323_456, 0.101_286_507_323_456], 0.125_939_180_544_827),
    ([0.101_286_507_323_456, 0.797_426_985_353_087, 0.101_286_507_323_456], 0.125_939_180_544_827),
    ([0.101_286_507_323_456, 0.101_286_507_323_456, 0.797_426_985_353_087], 0.125_939_180_544_827),
];

/// A triangle of a surface, counter-clockwise seen from outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Panel {
    corners_mm: [Point3<f64>; 3],
    center_mm: Point3<f64>,
    normal: Unit<Vector3<f64>>,
    area_mm2: f64,
    /// Lengths of the edges from each corner to the next, and the directions out of the triangle
    /// square to them.
    edges_mm: [f64; 3],
    outward: [Vector3<f64>; 3],
    /// Largest distance of a corner from the middle.
    radius_mm: f64,
    /// Mean of `(s − center)(s − center)ᵀ`.
    moment_mm2: Matrix3<f64>,
}

impl Panel {
    /// `None` where the corners are on a line or not finite.
    pub fn new(corners_mm: [Point3<f64>; 3]) -> Option<Self> {
        let [a, b, c] = corners_mm;
        let cross = (b - a).cross(&(c - a));
        let normal = Unit::try_new(cross, f64::MIN_POSITIVE)?;
        let center_mm = Point3::from((a.coords + b.coords + c.coords) / 3.0);
        let sides = [b - a, c - b, a - c];
        let edges_mm = sides.map(|side| side.norm());
        let offsets = corners_mm.map(|corner| corner - center_mm);
        let is_fine = cross.norm().is_finite() && edges_mm.iter().all(|edge| *edge > 0.0);
        is_fine.then(|| Self {
            corners_mm,
            center_mm,
            normal,
            area_mm2: 0.5 * cross.norm(),
            edges_mm,
            outward: [0, 1, 2].map(|k| (sides[k] / edges_mm[k]).cross(&normal)),
            radius_mm: offsets.iter().fold(0.0, |most, offset| offset.norm().max(most)),
            moment_mm2: offsets.iter().map(|v| v * v.transpose()).sum::<Matrix3<f64>>() / 12.0,
        })
    }

    pub fn corners_mm(&self) -> &[Point3<f64>; 3] {
        &self.corners_mm
    }

    pub fn center_mm(&self) -> &Point3<f64> {
        &self.center_mm
    }

    pub fn normal(&self) -> &Unit<Vector3<f64>> {
        &self.normal
    }

    pub fn area_mm2(&self) -> f64 {
        self.area_mm2
    }

    /// Lengths of the edges from each corner to the next.
    pub(crate) fn edges_mm(&self) -> &[f64; 3] {
        &self.edges_mm
    }

    /// Largest distance of a corner from the middle.
    pub fn radius_mm(&self) -> f64 {
        self.radius_mm
    }

    /// Mean of `(s − center)(s − center)ᵀ` over the triangle.
    pub(crate) fn moment_mm2(&self) -> &Matrix3<f64> {
        &self.moment_mm2
    }

    /// Field of a unit charge density, without dimension. In the plane the part along the normal is its
    /// mean from both sides, 0; on an edge the field is infinite, and finite but meaningless here.
    #[inline]
    pub fn field(&self, p: &Point3<f64>) -> Vector3<f64> {
        let r = p - self.center_mm;
        let distance2 = r.norm_squared();
        if distance2 > (FAR * self.radius_mm).powi(2) {
            return point_field(&r, &self.moment_mm2) * self.area_mm2;
        }
        if distance2 > (MIDDLE * self.radius_mm).powi(2) {
            return self.field_of_points(p);
        }
        let to_corners = self.corners_mm.map(|corner| corner - p);
        let norms = to_corners.map(|v| v.norm());
        let mut field = self.normal.into_inner() * -solid_angle_of(&to_corners, &norms);
        for k in 0..3 {
            let (sum, edge) = (norms[k] + norms[(k + 1) % 3], self.edges_mm[k]);
            let rest = (sum - edge).max(f64::EPSILON * edge);
            field += self.outward[k] * ((sum + edge) / rest).ln();
        }
        field
    }

    fn field_of_points(&self, p: &Point3<f64>) -> Vector3<f64> {
        let from_corners = self.corners_mm.map(|corner| p - corner);
        let of_point = |(bary, weight): ([f64; 3], f64)| {
            let r: Vector3<f64> = from_corners.iter().zip(bary).map(|(v, part)| v * part).sum();
            let inverse2 = 1.0 / r.norm_squared();
            r * (inverse2 * inverse2.sqrt() * weight)
        };
        FINE.into_iter().map(of_point).sum::<Vector3<f64>>() * self.area_mm2
    }

    /// Solid angle at which the triangle is seen: the flux through it, outward, of a unit point charge.
    /// Between −2π and 2π, positive from behind; 0 in its plane.
    #[inline]
    pub fn solid_angle(&self, p: &Point3<f64>) -> f64 {
        let to_corners = self.corners_mm.map(|corner| corner - p);
        solid_angle_of(&to_corners, &to_corners.map(|v| v.norm()))
    }

    /// Height of a point over the triangle's plane, positive outside.
    pub fn height_mm(&self, p: &Point3<f64>) -> f64 {
        (p - self.corners_mm[0]).dot(&self.normal)
    }

    /// Distance of a point from the nearest point of the triangle.
    pub fn distance_mm(&self, p: &Point3<f64>) -> f64 {
        let from_corners = self.corners_mm.map(|corner| p - corner);
        let is_over = (0..3).all(|k| from_corners[k].dot(&self.outward[k]) <= 0.0);
        if is_over {
            return self.height_mm(p).abs();
        }
        let to_edge = |k: usize| {
            let side = self.corners_mm[(k + 1) % 3] - self.corners_mm[k];
            let along = (from_corners[k].dot(&side) / side.norm_squared()).clamp(0.0, 1.0);
            (from_corners[k] - side * along).norm()
        };
        to_edge(0).min(to_edge(1)).min(to_edge(2))
    }

    /// Whether a segment goes through the triangle, its border included.
    pub fn is_cut_by(&self, from: &Point3<f64>, to: &Point3<f64>) -> bool {
        let (before, after) = (self.height_mm(from), self.height_mm(to));
        if before == after || (before > 0.0) == (after > 0.0) {
            return false;
        }
        let at = from + (to - from) * (before / (before - after));
        (0..3).all(|k| (at - self.corners_mm[k]).dot(&self.outward[k]) <= 0.0)
    }

    /// Points of a rule over the triangle, each of the same weight, their number such that what varies
    /// over `smooth_mm` is integrated well: 3, 12 or 48.
    pub fn rule_mm(&self, smooth_mm: f64) -> Vec<Point3<f64>> {
        let whole = Piece { corners_mm: self.corners_mm, radius_mm: self.radius_mm };
        let mut pieces = vec![whole];
        for _ in 0..2 {
            if pieces[0].radius_mm * 4.0 < smooth_mm {
                break;
            }
            pieces = pieces.iter().flat_map(Piece::quarters).collect();
        }
        pieces.iter().flat_map(Piece::rule_mm).collect()
    }
}

/// A part of a triangle, alike to it.
struct Piece {
    corners_mm: [Point3<f64>; 3],
    radius_mm: f64,
}

impl Piece {
    fn rule_mm(&self) -> [Point3<f64>; 3] {
        let [a, b, c] = self.corners_mm.map(|corner| corner.coords);
        RULE.map(|[u, v, w]| Point3::from(a * u + b * v + c * w))
    }

    fn quarters(&self) -> [Self; 4] {
        let [a, b, c] = self.corners_mm;
        let middle = |p: &Point3<f64>, q: &Point3<f64>| nalgebra::center(p, q);
        let (ab, bc, ca) = (middle(&a, &b), middle(&b, &c), middle(&c, &a));
        let radius_mm = 0.5 * self.radius_mm;
        [[a, ab, ca], [ab, b, bc], [ca, bc, c], [bc, ca, ab]]
            .map(|corners_mm| Self { corners_mm, radius_mm })
    }
}

/// Field of a unit charge spread with second moments `moment`, to their order: with the potential
/// `1/R + (3 r·M r − R² tr M) / (2 R⁵)`.
#[inline]
fn point_field(r: &Vector3<f64>, moment: &Matrix3<f64>) -> Vector3<f64> {
    let inverse2 = 1.0 / r.norm_squared();
    let inverse3 = inverse2 * inverse2.sqrt();
    let (along, trace) = (moment * r, moment.trace());
    let square = r.dot(&along) * inverse2;
    let radial = 1.0 + inverse2 * (7.5 * square - 1.5 * trace);
    (r * radial - along * (3.0 * inverse2)) * inverse3
}

#[inline]
fn solid_angle_of(to_corners: &[Vector3<f64>; 3], norms: &[f64; 3]) -> f64 {
    let [a, b, c] = to_corners;
    let [la, lb, lc] = norms;
    let triple = a.dot(&b.cross(c));
    let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    if triple == 0.0 {
        // In the plane, where the angle of the inside would be 2π from either side.
        return 0.0;
    }
    2.0 * triple.atan2(below)
}

/// Solid angle of a sphere's whole inside.
pub const FULL_ANGLE: f64 = 4.0 * PI;

#[cfg(test)]
mod tests {
    use super::*;

    fn panel() -> Panel {
        let corners = [[0.0, 0.0, 0.0], [4.0, 0.5, 0.2], [1.0, 3.0, -0.3]];
        Panel::new(corners.map(Into::into)).unwrap()
    }

    /// By pieces so small that each is a point.
    fn by_points(panel: &Panel, p: &Point3<f64>) -> Vector3<f64> {
        let mut pieces = vec![Piece { corners_mm: panel.corners_mm, radius_mm: panel.radius_mm }];
        for _ in 0..6 {
            pieces = pieces.iter().flat_map(Piece::quarters).collect();
        }
        let part = panel.area_mm2 / (3 * pieces.len()) as f64;
        let points = pieces.iter().flat_map(Piece::rule_mm);
        points.map(|s| (p - s) * (part / (p - s).norm().powi(3))).sum()
    }

    #[test]
    fn fields_are_the_sum_of_points() {
        for at in [[1.0, 1.0, 1.0], [5.0, 1.0, 0.3], [-1.0, -1.0, -0.5], [2.0, 1.0, -3.0]] {
            let p = Point3::from(at);
            let (found, expected) = (panel().field(&p), by_points(&panel(), &p));
            // Pieces are 0.05 mm, the rule's error (0.05/1)³ of each.
            assert!((found - expected).norm() < 2e-6 * expected.norm(), "{found} {expected}");
            let angle = panel().solid_angle(&p);
            assert!((found.dot(&panel().normal) + angle).abs() < 1e-12);
        }
    }

    #[test]
    fn fields_pass_from_far_to_near() {
        let panel = panel();
        for (times, most) in [(FAR, 4e-4), (MIDDLE, 2e-4)] {
            for direction in [[0.0, 0.0, 1.0], [1.0, 0.2, 0.1], [-0.6, 0.5, 0.7]] {
                let unit = Vector3::from(direction).normalize();
                let p = panel.center_mm + unit * (1.001 * times * panel.radius_mm);
                let near = by_points(&panel, &p);
                let error = (panel.field(&p) - near).norm();
                assert!(error < most * near.norm(), "{times} {}", error / near.norm());
            }
        }
    }

    #[test]
    fn distances_are_those_of_the_nearest_point() {
        let panel =
            Panel::new([[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]].map(Into::into)).unwrap();
        for (at, distance) in [
            ([0.5, 0.5, -3.0], 3.0),
            ([-3.0, -4.0, 0.0], 5.0),
            ([1.0, -2.0, 0.0], 2.0),
            ([2.0, 2.0, 1.0], 3.0_f64.sqrt()),
        ] {
            assert!((panel.distance_mm(&at.into()) - distance).abs() < 1e-14, "{at:?}");
        }
    }

    #[test]
    fn segments_through_a_panel_cut_it() {
        let panel =
            Panel::new([[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]].map(Into::into)).unwrap();
        let is_cut = |from: [f64; 3], to: [f64; 3]| panel.is_cut_by(&from.into(), &to.into());
        assert!(is_cut([1.0, 1.0, -1.0], [1.0, 1.0, 2.0]));
        assert!(is_cut([1.0, 1.0, 2.0], [1.5, 0.5, -1.0]));
        assert!(!is_cut([3.0, 3.0, -1.0], [3.0, 3.0, 1.0]));
        assert!(!is_cut([1.0, 1.0, 0.5], [1.0, 1.0, 2.0]));
        assert!(!is_cut([1.0, 1.0, 1.0], [1.0, 1.0, 1.0]));
        assert!(!is_cut([f64::NAN, 1.0, 1.0], [1.0, 1.0, -1.0]));
    }

    #[test]
    fn a_line_is_no_panel() {
        assert!(Panel::new([[0.0; 3], [1.0, 1.0, 0.0], [2.0, 2.0, 0.0]].map(Into::into)).is_none());
        assert!(
            Panel::new([[0.0; 3], [1.0, f64::NAN, 0.0], [2.0, 0.0, 0.0]].map(Into::into)).is_none()
        );
    }
}
