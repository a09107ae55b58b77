//! Derivatives of the error (8) by position and axis, analytic, for inverting the map.
//!
//! Value and three slopes of one orientation's polynomial are contracted with the six values side by
//! side in a vector: the innermost sum runs over k with one product for the value and one for the
//! slope along z; the sums along y and x are of lower order. Vectors of eight lanes hold a
//! coefficient's six values and the first two of the next, which are not used.

use super::bernstein::{MAX_ORDER, basis_with_slopes};
use super::evaluation::{Coefficient, Evaluation, Linearization, Matrix6x3, OutsidePolicy};
use super::model::DistortionModel;
use super::samples::PoseError;
use nalgebra::{Point3, Unit, Vector3};
use pulp::{Simd, WithSimd};
use trackwright_geometry::directions::{DirectionSet, Weighting};

impl DistortionModel {
    /// The error (8) with its derivatives by position and along the sphere of axes.
    pub fn evaluate_with_jacobian(
        &self,
        position_mm: &Point3<f64>,
        axis: &Unit<Vector3<f64>>,
        outside: OutsidePolicy,
    ) -> Linearization {
        let is_inside = self.bounds().contains(position_mm);
        if let Some(computed) = self.computed() {
            return computed.linearized(position_mm, axis);
        }
        if self.order() == 0 {
            return Linearization {
                at: Evaluation { error: PoseError::default(), is_inside },
                by_position: Matrix6x3::zeros(),
                by_axis: Matrix6x3::zeros(),
            };
        }
        let weights = self.directions().weights(axis, self.weighting());
        let slopes = match self.directions() {
            DirectionSet::One => [Vector3::zeros(); 3],
            set => {
                let corners = weights.directions.map(|d| set.directions()[d].into_inner());
                weight_slopes(&corners, self.weighting(), axis)
            }
        };
        let (unit, unit_per_mm) = self.unit_position(position_mm, outside);
        let bases = [0, 1, 2].map(|k| basis_with_slopes(self.order(), unit[k]));
        let count = match self.directions() {
            DirectionSet::One => 1,
            _ => 3,
        };
        let sums = pulp::Arch::new().dispatch(Contraction {
            order: self.order(),
            nets: weights.directions.map(|d| self.of_direction(d)),
            bases: &bases,
            count,
        });
        let mut value = [0.0; 6];
        let mut by_position = Matrix6x3::zeros();
        let mut by_axis = Matrix6x3::zeros();
        for (k, [e, x, y, z]) in sums.iter().enumerate().take(count) {
            let weight = weights.weights[k];
            for row in 0..6 {
                value[row] += weight * e[row];
                for (column, slope) in [x, y, z].into_iter().enumerate() {
                    by_position[(row, column)] += weight * unit_per_mm[column] * slope[row];
                    by_axis[(row, column)] += e[row] * slopes[k][column];
                }
            }
        }
        let at = Evaluation { error: PoseError::of_values(value), is_inside };
        Linearization { at, by_position, by_axis }
    }

    /// Position in the unit cube and its derivative by each coordinate; 0 for one that is clamped
    /// or has no extent.
    pub(super) fn unit_position(
        &self,
        position_mm: &Point3<f64>,
        outside: OutsidePolicy,
    ) -> (Vector3<f64>, Vector3<f64>) {
        let bounds = self.bounds();
        let at = match outside {
            OutsidePolicy::Extrapolate => *position_mm,
            OutsidePolicy::Clamp | OutsidePolicy::Reject => bounds.clamp(position_mm),
        };
        let size = bounds.size_mm();
        let unit_per_mm = Vector3::from_fn(|k, _| {
            let is_free = at[k] == position_mm[k] && size[k] > 0.0;
            if is_free { 1.0 / size[k] } else { 0.0 }
        });
        (bounds.to_unit(&at), unit_per_mm)
    }
}

/// Gradients on the sphere of the three weights in a triangle whose corners run counter-clockwise,
/// per radian, perpendicular to the axis.
pub(super) fn weight_slopes(
    corners: &[Vector3<f64>; 3],
    weighting: Weighting,
    axis: &Unit<Vector3<f64>>,
) -> [Vector3<f64>; 3] {
    let n = axis.as_ref();
    // Of a share of each corner, the weights before they are scaled to add to 1.
    let shares = [0, 1, 2].map(|k| {
        let (b, c) = (&corners[(k + 1) % 3], &corners[(k + 2) % 3]);
        match weighting {
            Weighting::Gnomonic => gnomonic_share(n, b, c),
            Weighting::Area => area_share(n, b, c),
        }
    });
    let sum: f64 = shares.iter().map(|s| s.0).sum();
    let slope_sum: Vector3<f64> = shares.iter().map(|s| s.1).sum();
    shares.map(|(share, slope)| {
        let gradient = (slope - slope_sum * (share / sum)) / sum;
        gradient - n * n.dot(&gradient)
    })
}

/// Volume of the axis with the opposite edge: proportional to its gnomonic coordinate.
fn gnomonic_share(n: &Vector3<f64>, b: &Vector3<f64>, c: &Vector3<f64>) -> (f64, Vector3<f64>) {
    let normal = b.cross(c);
    (n.dot(&normal).max(0.0), normal)
}

/// Half the area of the spherical triangle opposite a corner, `atan2(n·(b×c), 1 + n·b + b·c + c·n)`;
/// corners run counter-clockwise, so that the triple product is not negative inside, and its slope
/// on the edge itself is that from inside.
fn area_share(n: &Vector3<f64>, b: &Vector3<f64>, c: &Vector3<f64>) -> (f64, Vector3<f64>) {
    let normal = b.cross(c);
    let triple = n.dot(&normal);
    let denominator = 1.0 + n.dot(b) + b.dot(c) + c.dot(n);
    let slope =
        (normal * denominator - (b + c) * triple) / (triple * triple + denominator * denominator);
    (triple.max(0.0).atan2(denominator), slope)
}

/// A basis and its slopes along one axis.
type BasisAndSlopes = ([f64; MAX_ORDER + 1], [f64; MAX_ORDER + 1]);

/// Lanes that are loaded for a coefficient.
const LOADED: usize = 8;

/// Value, and slopes by x, y, z in the unit cube; only the first six of each count.
type Sums = [[f64; LOADED]; 4];

/// The work for up to three orientations.
struct Contraction<'a> {
    order: usize,
    nets: [&'a [Coefficient]; 3],
    bases: &'a [BasisAndSlopes; 3],
    /// How many of the nets count.
    count: usize,
}

impl WithSimd for Contraction<'_> {
    type Output = [Sums; 3];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [Sums; 3] {
        let mut sums = [[[0.0; LOADED]; 4]; 3];
        for (net, sums) in self.nets.iter().zip(&mut sums).take(self.count) {
            // In vectors of one lane the last two would be for nothing.
            for vector in 0..6_usize.div_ceil(S::F64_LANES) {
                contract(simd, self.order + 1, net.as_flattened(), self.bases, vector, sums);
            }
        }
        sums
    }
}

/// The sums of one vector of each coefficient.
#[inline(always)]
fn contract<S: Simd>(
    simd: S,
    n: usize,
    net: &[f64],
    [bx, by, bz]: &[BasisAndSlopes; 3],
    vector: usize,
    sums: &mut Sums,
) {
    let zero = simd.splat_f64s(0.0);
    let (bx0, bx1) = (&bx.0[..n], &bx.1[..n]);
    let (by0, by1) = (&by.0[..n], &by.1[..n]);
    let (bz0, bz1) = (&bz.0[..n], &bz.1[..n]);
    let add = |factor: f64, value, sum| simd.mul_add_e_f64s(simd.splat_f64s(factor), value, sum);
    let mut total = [zero; 4];
    let mut at = 0;
    for (&x, &x_slope) in bx0.iter().zip(bx1) {
        let mut plane = [zero; 3];
        for (&y, &y_slope) in by0.iter().zip(by1) {
            let mut line = [zero; 2];
            for (&z, &z_slope) in bz0.iter().zip(bz1) {
                let c = load::<S>(net, at, vector);
                at += 6;
                line[0] = add(z, c, line[0]);
                line[1] = add(z_slope, c, line[1]);
            }
            plane[0] = add(y, line[0], plane[0]);
            plane[1] = add(y_slope, line[0], plane[1]);
            plane[2] = add(y, line[1], plane[2]);
        }
        total[0] = add(x, plane[0], total[0]);
        total[1] = add(x_slope, plane[0], total[1]);
        total[2] = add(x, plane[1], total[2]);
        total[3] = add(x, plane[2], total[3]);
    }
    for (sums, total) in sums.iter_mut().zip(total) {
        S::as_mut_simd_f64s(sums).0[vector] = total;
    }
}

/// One vector of the coefficient that starts at a place, and of what follows it.
#[inline(always)]
fn load<S: Simd>(net: &[f64], at: usize, vector: usize) -> S::f64s {
    match net.get(at..at + LOADED) {
        Some(loaded) => S::as_simd_f64s(loaded).0[vector],
        // Nothing follows the last.
        None => {
            let mut last = [0.0; LOADED];
            last[..6].copy_from_slice(&net[at..at + 6]);
            S::as_simd_f64s(&last).0[vector]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random_models::{Seeded, random_model, room};
    use nalgebra::Vector6;

    /// One orientation, of which no weighting decides anything, then the others in both weightings.
    fn sets() -> impl Iterator<Item = (DirectionSet, Weighting)> {
        let both = |set| [Weighting::Area, Weighting::Gnomonic].map(|weighting| (set, weighting));
        DirectionSet::ALL.into_iter().flat_map(both).skip(1)
    }

    fn vector_of(error: &PoseError) -> Vector6<f64> {
        error.values().into()
    }

    /// A step along the sphere, not off it.
    fn turned(axis: &Unit<Vector3<f64>>, tangent: &Vector3<f64>, angle: f64) -> Unit<Vector3<f64>> {
        Unit::new_normalize(axis.as_ref() * angle.cos() + tangent * angle.sin())
    }

    /// The least difference from a derivative over steps that shrink by two: truncation rules the
    /// long ones, round-off the short ones.
    fn least_difference(
        derivative: Vector6<f64>,
        scale: f64,
        difference: impl Fn(f64) -> Vector6<f64>,
    ) -> f64 {
        (4..24)
            .map(|halvings| (difference(scale * 0.5_f64.powi(halvings)) - derivative).amax())
            .fold(f64::INFINITY, f64::min)
    }

    /// Far enough from the triangle's edges for steps of 1e-3 radians to stay inside.
    fn is_off_edges(model: &DistortionModel, axis: &Unit<Vector3<f64>>) -> bool {
        let weights = model.directions().weights(axis, Weighting::Gnomonic).weights;
        model.directions() == DirectionSet::One || weights.iter().all(|&w| w > 0.02)
    }

    #[test]
    fn derivatives_are_those_of_finite_differences() {
        // Coefficients of size 1; the best central difference of a function with third
        // derivatives of size n³ is off by n (n² ε²)^(1/3), some 1e-8 at order 8.
        let mut seeded = Seeded::new(3);
        for order in 1..=8 {
            for (set, weighting) in sets() {
                let model = random_model(order, set, weighting, [1.0, 1.0], order as u64);
                let outside = OutsidePolicy::Extrapolate;
                let (p, n) = loop {
                    let pose = seeded.pose(&room(), 0.0);
                    let axis = pose.rotation * Vector3::z_axis();
                    if is_off_edges(&model, &axis) {
                        break (Point3::from(pose.translation.vector), axis);
                    }
                };
                let there = model.evaluate_with_jacobian(&p, &n, outside);
                let plain = model.evaluate(&p, &n, outside);
                assert!((vector_of(&there.at.error) - vector_of(&plain.error)).amax() < 1e-14);
                let value = |p: &Point3<f64>, n: &Unit<Vector3<f64>>| {
                    vector_of(&model.evaluate(p, n, outside).error)
                };
                for k in 0..3 {
                    let along = Vector3::ith(k, 1.0);
                    let size = room().size_mm()[k];
                    let worst = least_difference(there.by_position.column(k) * size, 1.0, |h| {
                        let step = along * (h * size);
                        (value(&(p + step), &n) - value(&(p - step), &n)) / (2.0 * h)
                    });
                    assert!(worst < 3e-8, "{order} {set:?} {weighting:?} by {k}: {worst:e}");
                }
                let reference = Unit::new_normalize(n.cross(&Vector3::new(0.3, 0.5, -0.8)));
                for tangent in [reference.into_inner(), n.cross(&reference)] {
                    let worst = least_difference(there.by_axis * tangent, 0.01, |h| {
                        let ahead = value(&p, &turned(&n, &tangent, h));
                        (ahead - value(&p, &turned(&n, &tangent, -h))) / (2.0 * h)
                    });
                    assert!(worst < 3e-8, "{order} {set:?} {weighting:?} turned: {worst:e}");
                }
                assert!((there.by_axis * n.as_ref()).amax() < 1e-13);
            }
        }
    }

    #[test]
    fn on_edges_slopes_are_those_from_inside() {
        let p = room().center_mm();
        for (set, weighting) in sets().skip(1) {
            let model = random_model(2, set, weighting, [1.0, 1.0], 5);
            for triangle in set.triangles() {
                let [a, b, c] = triangle.map(|i| set.directions()[i].into_inner());
                for axis in [a + b * 0.6, b * 0.3 + c, a] {
                    let axis = Unit::new_normalize(axis);
                    // The weights may come from the triangle on the other side.
                    let corners = set.weights(&axis, weighting).directions;
                    let middle: Vector3<f64> =
                        corners.iter().map(|&d| set.directions()[d].into_inner()).sum();
                    let inward = middle - axis.as_ref() * axis.dot(&middle);
                    let tangent = inward.normalize();
                    let there = model.evaluate_with_jacobian(&p, &axis, OutsidePolicy::Clamp);
                    let value = |angle| {
                        let axis = turned(&axis, &tangent, angle);
                        vector_of(&model.evaluate(&p, &axis, OutsidePolicy::Clamp).error)
                    };
                    // One-sided, to second order.
                    let worst = least_difference(there.by_axis * tangent, 0.01, |h| {
                        (value(h) * 4.0 - value(2.0 * h) - value(0.0) * 3.0) / (2.0 * h)
                    });
                    assert!(worst < 1e-7, "{set:?} {weighting:?}: {worst:e}");
                }
            }
        }
    }

    #[test]
    fn clamped_coordinates_have_no_slope() {
        let model = random_model(3, DirectionSet::Fourteen, Weighting::Area, [1.0, 1.0], 9);
        let axis = Unit::new_normalize(Vector3::new(0.2, 0.5, -0.4));
        let p = Point3::new(300.0, 10.0, -600.0);
        let clamped = model.evaluate_with_jacobian(&p, &axis, OutsidePolicy::Clamp);
        assert_eq!(clamped.by_position.column(0).amax(), 0.0);
        assert!(clamped.by_position.column(1).amax() > 0.0);
        assert_eq!(clamped.by_position.column(2).amax(), 0.0);
        let on = model.evaluate_with_jacobian(&p, &axis, OutsidePolicy::Extrapolate);
        assert!((0..3).all(|k| on.by_position.column(k).amax() > 0.0));
        assert!(!clamped.at.is_inside && !on.at.is_inside);
    }

    #[test]
    fn without_distortion_there_is_no_slope() {
        let model = DistortionModel::zero(room(), crate::samples::MapKind::Distortion);
        let (at, axis) = (Point3::origin(), Vector3::z_axis());
        let there = model.evaluate_with_jacobian(&at, &axis, OutsidePolicy::Clamp);
        assert_eq!(there.by_position, Matrix6x3::zeros());
        assert_eq!(there.by_axis, Matrix6x3::zeros());
        assert_eq!(there.at.error, PoseError::default());
    }
}
