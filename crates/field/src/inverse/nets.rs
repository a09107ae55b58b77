//! The coefficients of a model over a part of its box, and the bounds that they give of the errors
//! there.

use super::slopes::{Slopes, by_axis, by_position};
use super::triangles::Triangles;
use crate::DistortionModel;
use crate::bernstein::MAX_ORDER;
use crate::evaluation::Coefficient;
use nalgebra::Vector3;

/// The bounds of the errors that the coefficients give.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Errors {
    pub least_mm: Vector3<f64>,
    pub largest_mm: Vector3<f64>,
    pub largest_rad: f64,
}

impl Errors {
    pub fn of(coefficients: &[Coefficient]) -> Self {
        let mut errors =
            Self { least_mm: Vector3::zeros(), largest_mm: Vector3::zeros(), largest_rad: 0.0 };
        if let Some(first) = coefficients.first() {
            errors.least_mm = Vector3::new(first[0], first[1], first[2]);
            errors.largest_mm = errors.least_mm;
        }
        for c in coefficients {
            let position = Vector3::new(c[0], c[1], c[2]);
            errors.least_mm = errors.least_mm.inf(&position);
            errors.largest_mm = errors.largest_mm.sup(&position);
            errors.largest_rad = errors.largest_rad.max(Vector3::new(c[3], c[4], c[5]).norm());
        }
        errors
    }

    pub fn hull(self, other: Self) -> Self {
        Self {
            least_mm: self.least_mm.inf(&other.least_mm),
            largest_mm: self.largest_mm.sup(&other.largest_mm),
            largest_rad: self.largest_rad.max(other.largest_rad),
        }
    }
}

/// The coefficients of all orientations over a part of the box.
pub(super) struct Nets {
    order: usize,
    pub of_direction: Vec<Vec<Coefficient>>,
}

impl Nets {
    /// Over the given interval of each unit coordinate.
    pub fn of(model: &DistortionModel, intervals: [[f64; 2]; 3]) -> Self {
        let order = model.order();
        let n = order + 1;
        let restrictions = intervals.map(|interval| restriction(order, interval));
        let of_direction = (0..model.directions().len())
            .map(|d| {
                let mut net = model.of_direction(d).to_vec();
                for (axis, rows) in restrictions.iter().enumerate() {
                    net = along(&net, n, n.pow(2 - axis as u32), rows);
                }
                net
            })
            .collect();
        Self { order, of_direction }
    }

    pub fn errors(&self) -> Errors {
        let each = self.of_direction.iter().map(|net| Errors::of(net));
        each.reduce(Errors::hull).unwrap_or(Errors::of(&[]))
    }

    /// Of each triangle.
    pub fn all_slopes(&self, triangles: &Triangles, size_mm: &Vector3<f64>) -> Vec<Slopes> {
        let positions: Vec<_> =
            self.of_direction.iter().map(|net| by_position(net, self.order, size_mm)).collect();
        triangles
            .corners
            .iter()
            .zip(&triangles.steepest)
            .map(|(t, steepest)| {
                let nets = t.map(|d| self.of_direction[d].as_slice());
                let [pn, nn] = by_axis(nets, steepest);
                let largest =
                    |half: usize| t.iter().map(|&d| positions[d][half]).fold(0.0, f64::max);
                Slopes { pp: largest(0), pn, np: largest(1), nn }
            })
            .collect()
    }
}

type Rows = [[f64; MAX_ORDER + 1]; MAX_ORDER + 1];

/// What takes coefficients over `[0, 1]` to those over an interval: row i is the polar form at
/// `n - i` times the lower end and `i` times the upper.
fn restriction(order: usize, [low, high]: [f64; 2]) -> Rows {
    let mut rows = [[0.0; MAX_ORDER + 1]; MAX_ORDER + 1];
    for (i, row) in rows.iter_mut().enumerate().take(order + 1) {
        for (column, entry) in row.iter_mut().enumerate().take(order + 1) {
            let mut values = [0.0; MAX_ORDER + 1];
            values[column] = 1.0;
            for step in 0..order {
                let t = if step < order - i { low } else { high };
                for k in 0..order - step {
                    values[k] = (1.0 - t) * values[k] + t * values[k + 1];
                }
            }
            *entry = values[0];
        }
    }
    rows
}

/// Applies a restriction along the axis whose neighbours are `stride` apart.
fn along(net: &[Coefficient], n: usize, stride: usize, rows: &Rows) -> Vec<Coefficient> {
    let mut out = vec![[0.0; 6]; net.len()];
    for (index, out) in out.iter_mut().enumerate() {
        let i = index / stride % n;
        let start = index - i * stride;
        for (column, factor) in rows[i][..n].iter().enumerate() {
            for (sum, value) in out.iter_mut().zip(&net[start + column * stride]) {
                *sum += factor * value;
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::OutsidePolicy;
    use crate::random_models::{Seeded, random_model, room};
    use trackwright_geometry::directions::{DirectionSet, Weighting};

    /// A model over a part of its box, as a model of that part's own unit cube.
    fn part(model: &DistortionModel, intervals: [[f64; 2]; 3]) -> DistortionModel {
        let bounds = model.bounds();
        let at = |end: usize| {
            let unit = Vector3::from(intervals.map(|interval| interval[end]));
            bounds.min_mm + bounds.size_mm().component_mul(&unit)
        };
        let bounds = trackwright_geometry::bounds::Bounds { min_mm: at(0), max_mm: at(1) };
        let net = Nets::of(model, intervals).of_direction.concat();
        model.with_coefficients(model.order(), bounds, net).unwrap()
    }

    #[test]
    fn a_part_of_the_box_has_the_same_polynomial() {
        let mut seeded = Seeded::new(2);
        for order in 1..=8 {
            let model = random_model(order, DirectionSet::Six, Weighting::Area, [1.0, 1.0], 7);
            // The last goes beyond the box, where coefficients grow by 2ⁿ an axis.
            for intervals in
                [[[0.0, 1.0]; 3], [[0.25, 0.5], [0.0, 0.125], [0.875, 1.0]], [[-0.25, 1.25]; 3]]
            {
                let part = part(&model, intervals);
                for _ in 0..10 {
                    let place = seeded.pose(&room(), 0.0);
                    let (p, n) =
                        (place.translation.vector.into(), place.rotation * Vector3::z_axis());
                    let whole = model.evaluate(&p, &n, OutsidePolicy::Extrapolate).error;
                    let again = part.evaluate(&p, &n, OutsidePolicy::Extrapolate).error;
                    let off = (whole.position_mm - again.position_mm).amax();
                    // Far from a small part its basis is as large as (1 / size)ⁿ.
                    let magnified = if intervals[0] == [0.25, 0.5] {
                        15.0_f64.powi(3 * order as i32)
                    } else {
                        8.0_f64.powi(order as i32)
                    };
                    assert!(off < 1e-15 * magnified, "{order} {intervals:?} {off:e}");
                }
            }
        }
    }

    #[test]
    fn coefficients_bound_errors_and_slopes() {
        let mut seeded = Seeded::new(5);
        for (set, weighting) in [
            (DirectionSet::One, Weighting::Area),
            (DirectionSet::Six, Weighting::Area),
            (DirectionSet::Fourteen, Weighting::Gnomonic),
            (DirectionSet::FortyTwo, Weighting::Area),
        ] {
            for order in [1, 2, 4] {
                let model = random_model(order, set, weighting, [10.0, 0.3], order as u64);
                let nets = Nets::of(&model, [[0.0, 1.0]; 3]);
                let (errors, triangles) = (nets.errors(), Triangles::of(&model));
                let slopes = nets.all_slopes(&triangles, &room().size_mm());
                let bound = slopes.into_iter().reduce(Slopes::max).unwrap();
                let mut largest = Slopes::default();
                for _ in 0..2000 {
                    let pose = seeded.pose(&room(), 0.0);
                    let n = pose.rotation * Vector3::z_axis();
                    let p = pose.translation.vector.into();
                    let there = model.evaluate_with_jacobian(&p, &n, OutsidePolicy::Clamp);
                    let e = there.at.error;
                    assert!(e.position_mm >= errors.least_mm && e.position_mm <= errors.largest_mm);
                    assert!(e.rotation_rad.norm() <= errors.largest_rad);
                    let norm = |m: &crate::evaluation::Matrix6x3, half: usize| {
                        m.fixed_rows::<3>(half).into_owned().singular_values().max()
                    };
                    largest = largest.max(Slopes {
                        pp: norm(&there.by_position, 0),
                        pn: norm(&there.by_axis, 0),
                        np: norm(&there.by_position, 3),
                        nn: norm(&there.by_axis, 3),
                    });
                }
                for (found, bound) in [
                    (largest.pp, bound.pp),
                    (largest.pn, bound.pn),
                    (largest.np, bound.np),
                    (largest.nn, bound.nn),
                ] {
                    assert!(found <= bound, "{set:?} {order}: {found} > {bound}");
                    // And it is no idle bound.
                    assert!(bound <= 20.0 * found, "{set:?} {order}: {bound} for {found}");
                }
            }
        }
    }
}
