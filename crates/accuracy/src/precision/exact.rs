//! Equation (8) in double-double arithmetic, weights included: what the field's ways of
//! computing it are held against.

use super::double_double::DoubleDouble;
use nalgebra::{Point3, Unit, Vector3};
use trackwright_field::DistortionModel;
use trackwright_geometry::directions::Weighting;

/// The six values of (8) at a position in the model's box, for the axis as its three numbers are.
pub fn evaluate(
    model: &DistortionModel,
    position_mm: &Point3<f64>,
    axis: &Unit<Vector3<f64>>,
) -> [DoubleDouble; 6] {
    let mut total = [DoubleDouble::ZERO; 6];
    if model.order() == 0 {
        return total;
    }
    let n = model.order() + 1;
    let at = model.bounds().clamp(position_mm);
    let [bx, by, bz] = [0, 1, 2].map(|k| {
        let (min, max) = (model.bounds().min_mm[k], model.bounds().max_mm[k]);
        let unit = if max > min {
            (dd(at[k]) - dd(min)) / (dd(max) - dd(min))
        } else {
            DoubleDouble::ZERO
        };
        basis(model.order(), unit)
    });
    let (directions, weights) = weights(model, axis);
    for (direction, weight) in directions.into_iter().zip(weights) {
        let start = direction * n * n * n;
        let own = &model.coefficients()[start..start + n * n * n];
        for (i, &x) in bx.iter().enumerate() {
            for (j, &y) in by.iter().enumerate() {
                let outer = weight * x * y;
                for (k, &z) in bz.iter().enumerate() {
                    let product = outer * z;
                    for (sum, &c) in total.iter_mut().zip(&own[(i * n + j) * n + k]) {
                        *sum += product * dd(c);
                    }
                }
            }
        }
    }
    total
}

/// Length of the difference from a position error, in millimetres.
pub fn position_difference_mm(exact: &[DoubleDouble; 6], found: &Vector3<f64>) -> f64 {
    Vector3::from_fn(|k, _| (dd(found[k]) - exact[k]).to_f64()).norm()
}

fn dd(value: f64) -> DoubleDouble {
    DoubleDouble::from(value)
}

fn basis(order: usize, x: DoubleDouble) -> Vec<DoubleDouble> {
    let rest = DoubleDouble::ONE - x;
    let mut b = vec![DoubleDouble::ONE];
    for _ in 0..order {
        let mut carried = DoubleDouble::ZERO;
        for value in &mut b {
            let old = *value;
            *value = carried + rest * old;
            carried = x * old;
        }
        b.push(carried);
    }
    b
}

/// Corners and weights. Which triangle it is, `f64` knows well enough: on an edge both sides give
/// the same area weights to round-off where the triangles are alike.
fn weights(model: &DistortionModel, axis: &Unit<Vector3<f64>>) -> (Vec<usize>, Vec<DoubleDouble>) {
    let set = model.directions();
    if set.len() == 1 {
        return (vec![0], vec![DoubleDouble::ONE]);
    }
    let corners = set.weights(axis, model.weighting()).directions;
    let vector = |v: &Unit<Vector3<f64>>| [dd(v.x), dd(v.y), dd(v.z)];
    let [a, b, c] = corners.map(|i| vector(&set.directions()[i]));
    let n = vector(axis);
    let parts = match model.weighting() {
        Weighting::Area => [half_area(n, b, c), half_area(a, n, c), half_area(a, b, n)],
        Weighting::Gnomonic => [triple(n, b, c), triple(a, n, c), triple(a, b, n)]
            .map(|t| if t.is_negative() { DoubleDouble::ZERO } else { t }),
    };
    let sum = parts[0] + parts[1] + parts[2];
    (corners.to_vec(), parts.map(|p| p / sum).to_vec())
}

type Triad = [DoubleDouble; 3];

fn dot(a: Triad, b: Triad) -> DoubleDouble {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn triple(a: Triad, b: Triad, c: Triad) -> DoubleDouble {
    let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
    dot(a, cross)
}

/// Half of a spherical triangle's area (Van Oosterom & Strackee, IEEE TBME 30(2), 1983).
fn half_area(a: Triad, b: Triad, c: Triad) -> DoubleDouble {
    DoubleDouble::atan2(
        triple(a, b, c).abs(),
        DoubleDouble::ONE + dot(a, b) + dot(b, c) + dot(c, a),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::precision::sampling::poses;
    use crate::precision::testing;
    use trackwright_field::OutsidePolicy;
    use trackwright_geometry::directions::DirectionSet;

    #[test]
    fn the_programs_answers_are_these_to_round_off() {
        for weighting in [Weighting::Area, Weighting::Gnomonic] {
            for set in DirectionSet::ALL {
                let model = testing::model(4, set, weighting);
                let largest = testing::largest_mm(&model);
                for (position, axis) in poses(model.bounds(), 50, 3) {
                    let exact = evaluate(&model, &position, &axis);
                    let found = model.evaluate(&position, &axis, OutsidePolicy::Clamp);
                    let off = position_difference_mm(&exact, &found.error.position_mm);
                    // Three directions, three sums of five terms: some tens of roundings.
                    assert!(off < 100.0 * f64::EPSILON * largest, "{set:?} {off:e}");
                }
            }
        }
    }

    #[test]
    fn a_linear_field_is_exact() {
        let model = testing::linear_model(4);
        let exact = evaluate(&model, &Point3::new(0.0, 25.0, -150.0), &Vector3::z_axis());
        assert!((exact[0] - dd(0.5)).abs().to_f64() < 1e-30);
        assert!((exact[1] - dd(0.75)).abs().to_f64() < 1e-30);
    }
}
