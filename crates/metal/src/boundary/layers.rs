//! Layers on a triangle seen from a point, of the kernel `G = e^(−kR)/4πR`.
//!
//! All are integrals along the edges, without singularities (after Wilton et al., IEEE Trans. Antennas and
//! Propagation 32(3), 1984, who have `k = 0`): with the height `h` of the point over the plane, the distance `d` of
//! its foot from an edge, `x = R − |h|` and `φ(z) = (1 − e^(−z))/z`, along the edge's own `dt = ds/R`,
//!
//! `4π ∫ G dS = Σ d ∫ e^(−k|h|) φ(kx) R/(R + |h|) dt`,
//!
//! and likewise for the first moment, by the divergence theorem in the plane, and the slopes of both with the height.

use crate::panel::{FULL_ANGLE, Panel};
use nalgebra::{ComplexField, Point3, Vector3};

/// Gauss and Legendre's rules of four, six and eight points from −1 to 1, places on one side and weights, each with the
/// largest half of a piece that it is for.
const RULES: [(f64, &[(f64, f64)]); 3] = [
    (
        0.4,
        &[
            (0.339_981_043_584_856_3, 0.652_145_154_862_546_1),
            (0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
        ],
    ),
    (
        0.9,
        &[
            (0.238_619_186_083_196_9, 0.467_913_934_572_691),
            (0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
            (0.932_469_514_203_152, 0.171_324_492_379_170_36),
        ],
    ),
    (
        f64::INFINITY,
        &[
            (0.183_434_642_495_649_8, 0.362_683_783_378_362),
            (0.525_532_409_916_329, 0.313_706_645_877_887_3),
            (0.796_666_477_413_626_7, 0.222_381_034_453_374_5),
            (0.960_289_856_497_536_3, 0.101_228_536_290_376_3),
        ],
    ),
];

/// Longest piece of an edge for the rule, in `t`: layers are right to some 10⁻⁶ then.
const LONGEST_PIECE: f64 = 3.0;

/// Below this `φ` is its series, whose next term is 3·10⁻¹³.
const SMALL: f64 = 0.1;

/// A height below this part of a triangle's size is none.
const FLAT: f64 = 1e-9;

/// Real for the kernel without decay, `k = 0`.
pub(super) trait Number: ComplexField<RealField = f64> + Copy {}

impl<T: ComplexField<RealField = f64> + Copy> Number for T {}

/// A number of a triangle's layers.
pub(super) fn real<T: Number>(x: f64) -> T {
    T::from_real(x)
}

/// Layers with each corner's linear function `λ`, seen from a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layers<T> {
    /// `∫ λ G`.
    pub single: [T; 3],
    /// `∫ λ n·∇G`, with the gradient in the triangle. In its plane the mean from both sides.
    pub double: [T; 3],
    /// `∇ ∫ G`, with the gradient where it is seen from.
    pub gradient: Vector3<T>,
}

impl<T: Number> Layers<T> {
    pub fn seen_from(p: &Point3<f64>, panel: &Panel, k: T) -> Self {
        let (normal, corners) = (panel.normal(), panel.corners_mm());
        let height = panel.height_mm(p);
        let is_in_plane = height.abs() < FLAT * panel.radius_mm();
        let (h, side) = if is_in_plane { (0.0, 0.0) } else { (height.abs(), height.signum()) };
        let foot = p - normal.into_inner() * height;
        let at_foot = (-k * real(h)).exp();
        let inverse_k = if k == T::zero() { k } else { k.recip() };
        let (mut single, mut double) = (T::zero(), T::zero());
        let [mut single_moment, mut double_moment, mut along] =
            [Vector3::from_element(T::zero()); 3];
        for edge in 0..3 {
            let (a, b) = (corners[edge], corners[(edge + 1) % 3]);
            let length = (b - a).norm();
            let tangent = (b - a) / length;
            let outward = tangent.cross(normal);
            let (d, from) = ((a - foot).dot(&outward), (a - foot).dot(&tangent));
            // Beside a corner on the edge's own line.
            let c = (d * d + h * h).sqrt().max(1e-12 * length);
            // `c e^t` at both ends, where `s = c sinh t`.
            let [first, last] = [from, from + length].map(|s| {
                let r = (s * s + c * c).sqrt();
                if s < 0.0 { c * c / (r - s) } else { r + s }
            });
            let whole = (last / first).ln();
            let pieces = (whole / LONGEST_PIECE).ceil().max(1.0);
            let half = 0.5 * whole / pieces;
            let rule = RULES.iter().find(|(most, _)| half <= *most).map_or(RULES[2].1, |of| of.1);
            let mut sums = [T::zero(); 4];
            for piece in 0..pieces as usize {
                // Half of `c e^t` and of `c e^(−t)`: `R` is their sum, `s` their difference.
                let middle = first * (half * (2 * piece + 1) as f64).exp();
                let [ahead, back] = [0.5 * middle, 0.5 * c * c / middle];
                for (place, weight) in rule {
                    let step = (half * place).exp();
                    let away = 1.0 / step;
                    for (ahead, back) in [(ahead * away, back * step), (ahead * step, back * away)]
                    {
                        let (r, s) = (ahead + back, ahead - back);
                        let x = (d * d + s * s) / (r + h);
                        let w = weight * half;
                        let share = w / (r + h);
                        let beyond = (-k * real(x)).exp();
                        let inside = at_foot * phi([k, inverse_k], x, beyond);
                        let decay = at_foot * beyond;
                        sums[0] += inside * real(r * share);
                        sums[1] += (at_foot + k * real::<T>(h) * inside) * real(share);
                        sums[2] += phi([k, inverse_k], r, decay) * real(r * r * w);
                        sums[3] += decay * real(w);
                    }
                }
            }
            single += sums[0] * real(d);
            double += sums[1] * real(d * side);
            let outward: Vector3<T> = outward.map(real);
            single_moment += outward * sums[2];
            double_moment -= outward * (sums[3] * real(h * side));
            along += outward * sums[3];
        }
        let over: T = real(1.0 / FULL_ANGLE);
        let each = |whole: T, moment: &Vector3<T>| {
            [0, 1, 2].map(|corner| {
                let (next, last) = (corners[(corner + 1) % 3], corners[(corner + 2) % 3]);
                let slope = normal.cross(&(last - next)) / (2.0 * panel.area_mm2());
                let at_foot: T = real((foot - next).dot(&slope));
                (whole * at_foot + slope.map(real).dot(moment)) * over
            })
        };
        let gradient = (along + normal.map(real::<T>) * double) * -over;
        Self {
            single: each(single, &single_moment),
            double: each(double, &double_moment),
            gradient,
        }
    }
}

/// `(1 − e^(−kx))/kx`, of `k` and its inverse, `x` and `e^(−kx)`.
fn phi<T: Number>([k, inverse_k]: [T; 2], x: f64, decay: T) -> T {
    let z = k * real(x);
    if z.norm1() < SMALL {
        let mut sum = real::<T>(1.0 / 40_320.0);
        for inverse in [5_040.0, 720.0, 120.0, 24.0, 6.0, 2.0, 1.0] {
            sum = real::<T>(1.0 / inverse) - z * sum;
        }
        return sum;
    }
    (T::one() - decay) * inverse_k * real(1.0 / x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::c64;

    /// A point of a triangle: its place, the corners' functions there and its share of the area.
    type Point = (Point3<f64>, [f64; 3], f64);

    fn of_points(p: &Point3<f64>, normal: &Vector3<f64>, points: &[Point], k: c64) -> Layers<c64> {
        let zero = c64::new(0.0, 0.0);
        let gradient = Vector3::from_element(zero);
        let mut found = Layers { single: [zero; 3], double: [zero; 3], gradient };
        for (s, corners, area_mm2) in points {
            let v = p - s;
            let r = v.norm();
            let g = (-k * r).exp() * (area_mm2 / (FULL_ANGLE * r));
            let slope = g * (k * r + 1.0) * (v.dot(normal) / (r * r));
            found.gradient -= v.map(real::<c64>) * (g * (k * r + 1.0) / (r * r));
            for (corner, part) in corners.iter().enumerate() {
                found.single[corner] += g * *part;
                found.double[corner] += slope * *part;
            }
        }
        found
    }

    #[test]
    fn layers_are_sums_over_many_points() {
        let corners = [[0.0, 0.0, 0.0], [2.0, 0.1, 0.0], [0.3, 1.5, 0.2]].map(Point3::from);
        let panel = Panel::new(corners).unwrap();
        let count = 300;
        let mut points: Vec<Point> = Vec::new();
        for i in 0..count {
            for j in 0..count - i {
                for (up, part) in [(0, 1.0 / 3.0), (1, 2.0 / 3.0)] {
                    if j + up < count - i {
                        let [u, v] = [i, j].map(|k| (k as f64 + part) / f64::from(count as u32));
                        let s = corners[0]
                            + (corners[1] - corners[0]) * u
                            + (corners[2] - corners[0]) * v;
                        let share = panel.area_mm2() / f64::from((count * count) as u32);
                        points.push((s, [1.0 - u - v, u, v], share));
                    }
                }
            }
        }
        for p in [[0.5, 0.5, 1.0], [-1.0, 0.2, -0.3], [0.7, 0.5, 0.1]].map(Point3::from) {
            for k in [0.0, 0.05, 0.5, 5.0].map(|k| c64::new(k, k)) {
                let found = Layers::seen_from(&p, &panel, k);
                let summed = of_points(&p, panel.normal(), &points, k);
                let off = (found.gradient - summed.gradient).norm() / summed.gradient.norm();
                assert!(off < 1e-3, "{p} {k}: {off}");
                let each = found.single.iter().zip(&summed.single);
                for (found, summed) in each.chain(found.double.iter().zip(&summed.double)) {
                    // What 90,000 points leave beside a point a tenth of the size away.
                    assert!((found / summed - 1.0).norm() < 1e-3, "{p} {k}: {found} {summed}");
                }
            }
        }
    }
}
