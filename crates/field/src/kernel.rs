//! Equation (8) for as many poses of one spherical triangle as a machine has lanes.
//!
//! A pose stays in its lane and the coefficients are spread to all lanes, so that neither the
//! order nor the six values have to fit a vector. The weights of the three orientations are
//! multiplied into the basis along z, once; the innermost sum then runs over orientation and k
//! together: 3 (n + 1) terms of six products, (n + 1)² times, which is all of the work but some
//! percent. Each lane computes the same whatever is in the others, and whatever its lane.

use super::bernstein::MAX_ORDER;
use super::evaluation::Coefficient;
use nalgebra::Vector3;
use pulp::Simd;
use trackwright_geometry::bounds::{Bounds, INSIDE_TOLERANCE};
use trackwright_geometry::directions::{ON_EDGE, TriangleShape, Weighting};

/// Places for a basis of the highest order.
pub(super) const MAX_TERMS: usize = MAX_ORDER + 1;

/// `P` vectors of poses; with several, one load of a coefficient serves more products.
pub(super) type Block<V, const P: usize> = [V; P];

/// A basis along one axis, in the first `order + 1` of `T` places.
pub(super) type Basis<V, const P: usize, const T: usize> = [Block<V, P>; T];

/// The six values.
pub(super) type Values<V, const P: usize> = [Block<V, P>; 6];

/// `B_0..B_n` by the triangle recurrence, as in [`super::bernstein::basis`].
#[inline(always)]
pub(super) fn basis<S: Simd, const P: usize, const T: usize>(
    simd: S,
    order: usize,
    at: Block<S::f64s, P>,
) -> Basis<S::f64s, P, T> {
    let (zero, one) = (simd.splat_f64s(0.0), simd.splat_f64s(1.0));
    let mut rest = at;
    for rest in &mut rest {
        *rest = simd.sub_f64s(one, *rest);
    }
    let mut basis = [[zero; P]; T];
    basis[0] = [one; P];
    for n in 1..=order {
        let mut carried = [zero; P];
        for value in &mut basis[..n] {
            for p in 0..P {
                let old = value[p];
                value[p] = simd.mul_add_e_f64s(rest[p], old, carried[p]);
                carried[p] = simd.mul_f64s(at[p], old);
            }
        }
        basis[n] = carried;
    }
    basis
}

/// Sum over orientations and i, j, k of coefficients and bases; `along_z` has the weights in it,
/// one basis an orientation.
#[inline(always)]
pub(super) fn contract<S: Simd, const P: usize, const T: usize, const D: usize>(
    simd: S,
    order: usize,
    directions: [&[Coefficient]; D],
    along_x: &Basis<S::f64s, P, T>,
    along_y: &Basis<S::f64s, P, T>,
    along_z: &[Basis<S::f64s, P, T>; D],
) -> Values<S::f64s, P> {
    let n = order + 1;
    let zero = simd.splat_f64s(0.0);
    let mut total = [[zero; P]; 6];
    for (i, x) in along_x[..n].iter().enumerate() {
        for (j, y) in along_y[..n].iter().enumerate() {
            let mut sum = [[zero; P]; 6];
            for (coefficients, basis) in directions.iter().zip(along_z) {
                let row = &coefficients[(i * n + j) * n..][..n];
                for (coefficient, z) in row.iter().zip(basis) {
                    for (sum, &c) in sum.iter_mut().zip(coefficient) {
                        let c = simd.splat_f64s(c);
                        for p in 0..P {
                            sum[p] = simd.mul_add_e_f64s(c, z[p], sum[p]);
                        }
                    }
                }
            }
            for p in 0..P {
                let xy = simd.mul_f64s(x[p], y[p]);
                for (total, sum) in total.iter_mut().zip(sum) {
                    total[p] = simd.mul_add_e_f64s(xy, sum[p], total[p]);
                }
            }
        }
    }
    total
}

/// The bases along z of three orientations, times their weights.
#[inline(always)]
pub(super) fn weighted<S: Simd, const P: usize, const T: usize>(
    simd: S,
    order: usize,
    basis: &Basis<S::f64s, P, T>,
    weights: [Block<S::f64s, P>; 3],
) -> [Basis<S::f64s, P, T>; 3] {
    let mut products = [[[simd.splat_f64s(0.0); P]; T]; 3];
    for (products, weight) in products.iter_mut().zip(weights) {
        for (product, value) in products.iter_mut().zip(&basis[..=order]) {
            for p in 0..P {
                product[p] = simd.mul_f64s(weight[p], value[p]);
            }
        }
    }
    products
}

/// A box with its numbers spread to all lanes.
pub(super) struct LaneBounds<V> {
    min: [V; 3],
    max: [V; 3],
    size: [V; 3],
    lowest_inside: [V; 3],
    highest_inside: [V; 3],
}

impl<V: Copy> LaneBounds<V> {
    #[inline(always)]
    pub fn new<S: Simd<f64s = V>>(simd: S, bounds: &Bounds) -> Self {
        let splat =
            |v: Vector3<f64>| [simd.splat_f64s(v.x), simd.splat_f64s(v.y), simd.splat_f64s(v.z)];
        let size = bounds.size_mm();
        let slack = size * INSIDE_TOLERANCE;
        Self {
            min: splat(bounds.min_mm.coords),
            max: splat(bounds.max_mm.coords),
            // An axis without extent maps to 0: anything clamped to it is 0 from its minimum.
            size: splat(size.map(|s| if s > 0.0 { s } else { f64::INFINITY })),
            lowest_inside: splat(bounds.min_mm.coords - slack),
            highest_inside: splat(bounds.max_mm.coords + slack),
        }
    }

    /// Position in the unit cube, as [`Bounds::clamp`] and [`Bounds::to_unit`] have it.
    #[inline(always)]
    pub fn to_unit<S: Simd<f64s = V>>(&self, simd: S, at: [V; 3], clamp: bool) -> [V; 3] {
        let mut unit = at;
        for (k, v) in unit.iter_mut().enumerate() {
            if clamp {
                // By comparisons, so that a position that is not a number stays so.
                let (min, max) = (self.min[k], self.max[k]);
                let low = simd.select_f64s(simd.less_than_f64s(*v, min), min, *v);
                *v = simd.select_f64s(simd.less_than_f64s(max, low), max, low);
            }
            *v = simd.div_f64s(simd.sub_f64s(*v, self.min[k]), self.size[k]);
        }
        unit
    }

    /// 1 where the position lies in the box, else 0, as [`Bounds::contains`] has it.
    #[inline(always)]
    pub fn contains<S: Simd<f64s = V>>(&self, simd: S, at: [V; 3]) -> V {
        let (zero, mut inside) = (simd.splat_f64s(0.0), simd.splat_f64s(1.0));
        for (k, &v) in at.iter().enumerate() {
            let above = simd.greater_than_or_equal_f64s(v, self.lowest_inside[k]);
            let below = simd.less_than_or_equal_f64s(v, self.highest_inside[k]);
            inside = simd.select_f64s(above, simd.select_f64s(below, inside, zero), zero);
        }
        inside
    }
}

/// The weights of axes in a triangle, one axis a lane; as
/// [`trackwright_geometry::directions::DirectionSet::weights`].
#[inline(always)]
pub(super) fn weights<S: Simd>(
    simd: S,
    triangle: &TriangleShape,
    weighting: Weighting,
    axis: [S::f64s; 3],
) -> [S::f64s; 3] {
    let mut parts = [simd.splat_f64s(0.0); 3];
    match weighting {
        Weighting::Gnomonic => {
            for (part, &row) in parts.iter_mut().zip(&triangle.gnomonic_rows) {
                // In this order what is not a number stays so.
                *part = simd.max_f64s(simd.splat_f64s(0.0), dot(simd, row, axis));
            }
        }
        Weighting::Area => {
            let [a, b, c] = triangle.corners;
            let (a, b, c) = (dot(simd, a, axis), dot(simd, b, axis), dot(simd, c, axis));
            let sums = [simd.add_f64s(b, c), simd.add_f64s(c, a), simd.add_f64s(a, b)];
            for k in 0..3 {
                let triple = simd.abs_f64s(dot(simd, triangle.normals[k], axis));
                let rest = simd.splat_f64s(1.0 + triangle.opposite_cosines[k]);
                let half_area = atan_of_quotient(simd, triple, simd.add_f64s(rest, sums[k]));
                let is_on_edge = simd.less_than_f64s(triple, simd.splat_f64s(ON_EDGE));
                parts[k] = simd.select_f64s(is_on_edge, simd.splat_f64s(0.0), half_area);
            }
        }
    }
    let sum = simd.add_f64s(simd.add_f64s(parts[0], parts[1]), parts[2]);
    for part in &mut parts {
        *part = simd.div_f64s(*part, sum);
    }
    parts
}

#[inline(always)]
fn dot<S: Simd>(simd: S, a: Vector3<f64>, b: [S::f64s; 3]) -> S::f64s {
    let splat = |v| simd.splat_f64s(v);
    let sum = simd.mul_f64s(splat(a.x), b[0]);
    let sum = simd.mul_add_e_f64s(splat(a.y), b[1], sum);
    simd.mul_add_e_f64s(splat(a.z), b[2], sum)
}

/// Arctangent of `y / x` for `y >= 0`, `x > 0`, to 3e-16 of its value.
///
/// Above a quotient of 0.66 it is π/4 and the arctangent of `(y - x) / (y + x)`; what remains is
/// the rational approximation of S. Moshier's Cephes library, `atan.c`.
#[inline(always)]
pub(super) fn atan_of_quotient<S: Simd>(simd: S, y: S::f64s, x: S::f64s) -> S::f64s {
    const REDUCED_ABOVE: f64 = 0.66;
    const P: [f64; 5] = [
        -8.750_608_600_031_904e-1,
        -1.615_753_718_733_365_2e1,
        -7.500_855_792_314_705e1,
        -1.228_866_684_490_136_1e2,
        -64.850_219_049_420_25,
    ];
    const Q: [f64; 6] = [
        1.0,
        24.858_464_901_423_062,
        165.027_009_831_698_85,
        432.881_060_491_290_27,
        485.390_399_635_913_7,
        194.550_657_148_261_4,
    ];
    let splat = |v| simd.splat_f64s(v);
    let is_large = simd.greater_than_f64s(y, simd.mul_f64s(x, splat(REDUCED_ABOVE)));
    let numerator = simd.select_f64s(is_large, simd.sub_f64s(y, x), y);
    let denominator = simd.select_f64s(is_large, simd.add_f64s(y, x), x);
    let t = simd.div_f64s(numerator, denominator);
    let z = simd.mul_f64s(t, t);
    let horner = |coefficients: &[f64]| {
        let mut value = splat(coefficients[0]);
        for &c in &coefficients[1..] {
            value = simd.mul_add_e_f64s(value, z, splat(c));
        }
        value
    };
    let quotient = simd.div_f64s(simd.mul_f64s(z, horner(&P)), horner(&Q));
    let small = simd.mul_add_e_f64s(t, quotient, t);
    let offset = simd.select_f64s(is_large, splat(std::f64::consts::FRAC_PI_4), splat(0.0));
    simd.add_f64s(offset, small)
}

#[cfg(test)]
mod tests {
    use super::*;
    use pulp::Scalar;

    #[test]
    fn the_arctangent_is_right_to_the_last_bits() {
        for i in 0..=20_000 {
            let quotient = f64::from(i) / 10_000.0;
            for x in [1e-3, 1.0, 3.7] {
                let y = quotient * x;
                let exact = y.atan2(x);
                let found = atan_of_quotient(Scalar::new(), y, x);
                assert!((found - exact).abs() <= 4e-16 * exact, "{quotient} {x}");
            }
        }
        for y in [0.0, 1e-300, 1e-16, 1e-8] {
            let found = atan_of_quotient(Scalar::new(), y, 1.0);
            assert!((found - y.atan()).abs() <= 4e-16 * y);
        }
    }

    #[test]
    fn the_basis_is_that_of_the_definition() {
        for order in 0..=MAX_ORDER {
            for x in [-0.2, 0.0, 0.3, 1.0, 1.1] {
                let found: Basis<f64, 1, MAX_TERMS> = basis(Scalar::new(), order, [x]);
                let expected = super::super::bernstein::basis(order, x);
                for (f, e) in found.iter().zip(expected).take(order + 1) {
                    assert!((f[0] - e).abs() <= 1e-15 * e.abs().max(1.0));
                }
            }
        }
    }
}
