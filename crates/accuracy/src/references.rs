//! The program's formulas once more, in [`High`] numbers and by the plainest way there is.

use crate::high::{High, One, Zero};
use crate::high_linear::{High3, High33, inverse33, norm, unit3, vector3};
use nalgebra::{Point3, Unit, UnitQuaternion, Vector3};
use trackwright_field::{DistortionModel, OutsidePolicy};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::directions::{DirectionSet, Weighting};

/// How far outside a triangle an axis may be for the program to have chosen it: on an edge,
/// round-off decides which side it is on, and both are right.
const ON_EDGE: f64 = 1e-13;

/// `n` over `i`.
fn binomial(n: usize, i: usize) -> f64 {
    (0..i).fold(1.0, |c, k| c * (n - k) as f64 / (k + 1) as f64)
}

fn power(x: &High, n: usize) -> High {
    (0..n).fold(High::one(), |product, _| product * x)
}

/// `C(n, i) xⁱ (1 − x)ⁿ⁻ⁱ` for all `i`.
pub fn basis(order: usize, x: &High) -> Vec<High> {
    let rest = High::one() - x;
    (0..=order).map(|i| power(x, i) * power(&rest, order - i) * binomial(order, i)).collect()
}

/// Derivatives of [`basis`] by `x`.
pub fn basis_slopes(order: usize, x: &High) -> Vec<High> {
    let lower = basis(order - 1, x);
    (0..=order)
        .map(|i| {
            let before = if i > 0 { lower[i - 1].clone() } else { High::zero() };
            let own = lower.get(i).cloned().unwrap_or_else(High::zero);
            (before - own) * order as f64
        })
        .collect()
}

/// Position in the unit cube; an axis without extent maps to 0.
pub fn unit_position(bounds: &Bounds, position_mm: &High3) -> High3 {
    High3::from_fn(|k, _| {
        let min = High::from(bounds.min_mm[k]);
        let size = High::from(bounds.max_mm[k]) - &min;
        if size.is_zero() { High::zero() } else { (&position_mm[k] - min) / size }
    })
}

fn clamped(bounds: &Bounds, position_mm: &High3) -> High3 {
    High3::from_fn(|k, _| {
        let (min, max) = (High::from(bounds.min_mm[k]), High::from(bounds.max_mm[k]));
        let x = &position_mm[k];
        if *x < min {
            min
        } else if *x > max {
            max
        } else {
            x.clone()
        }
    })
}

/// The basis orientations to all digits: each component is one of nine numbers.
pub fn directions(set: DirectionSet) -> Vec<High3> {
    let golden = (High::from(5.0).sqrt() + 1.0) * 0.5;
    let edge = (&golden * &golden + 1.0).sqrt();
    let candidates = [
        High::zero(),
        High::one(),
        High::from(0.5),
        &golden * 0.5,
        High::from(0.5) / &golden,
        High::one() / High::from(2.0).sqrt(),
        High::one() / High::from(3.0).sqrt(),
        High::one() / &edge,
        &golden / &edge,
    ];
    let exact = |component: f64| {
        let distance = |c: &High| (c.to_f64() - component.abs()).abs();
        let nearest = candidates.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
        match nearest {
            Some(c) if distance(c) < 1e-14 && component < 0.0 => -c,
            Some(c) if distance(c) < 1e-14 => c.clone(),
            _ => High::from(f64::NAN),
        }
    };
    set.directions().iter().map(|d| d.map(exact)).collect()
}

/// An axis's weights in one triangle that may hold it.
#[derive(Clone, Debug)]
pub struct HighWeights {
    pub directions: [usize; 3],
    pub weights: [High; 3],
    /// What the weights were divided by: its inverse shows how errors of the axis grow.
    pub sum: f64,
}

/// The weights in every triangle that holds the axis, edges included: one triangle almost
/// everywhere, two on an edge, more on a corner.
pub fn weights(set: DirectionSet, axis: &High3, weighting: Weighting) -> Vec<HighWeights> {
    if set == DirectionSet::One {
        return vec![HighWeights {
            directions: [0; 3],
            weights: [High::one(), High::zero(), High::zero()],
            sum: 1.0,
        }];
    }
    let corners = directions(set);
    let n = unit3(axis);
    let outside = High::from(-ON_EDGE);
    let near = n.map(|x| x.to_f64());
    set.triangles()
        .iter()
        .filter(|triangle| may_hold(set, triangle, &near))
        .filter_map(|&triangle| {
            let corners = triangle.map(|i| corners[i].clone());
            let gnomonic = inverse33(&High33::from_columns(&corners)) * &n;
            if gnomonic.iter().any(|l| *l < outside) {
                return None;
            }
            let [a, b, c] = &corners;
            let parts = match weighting {
                Weighting::Gnomonic => {
                    gnomonic.map(|l| if l.is_negative() { High::zero() } else { l }).into()
                }
                Weighting::Area => [half_area(&n, b, c), half_area(a, &n, c), half_area(a, b, &n)],
            };
            let sum: High = parts.iter().cloned().sum();
            Some(HighWeights {
                directions: triangle,
                weights: parts.map(|p| p / &sum),
                sum: sum.to_f64(),
            })
        })
        .collect()
}

/// Whether an axis is in a triangle or not far outside it: spares high precision the rest.
fn may_hold(set: DirectionSet, triangle: &[usize; 3], axis: &Vector3<f64>) -> bool {
    let [a, b, c] = triangle.map(|i| set.directions()[i].into_inner());
    let sides = [b.cross(&c), c.cross(&a), a.cross(&b)];
    sides.iter().all(|normal| normal.dot(axis) > -1e-6)
}

/// Half the area of a spherical triangle (Van Oosterom & Strackee).
fn half_area(a: &High3, b: &High3, c: &High3) -> High {
    a.dot(&b.cross(c)).abs().atan2(&(a.dot(b) + b.dot(c) + c.dot(a) + 1.0))
}

/// Equation (8) and how its answer reacts to its inputs.
#[derive(Clone, Debug)]
pub struct HighEvaluation {
    pub values: [High; 6],
    /// For position and rotation: how many times its own relative error an answer of the size of
    /// the largest coefficient gains from errors of coefficients, position and axis.
    pub conditions: [f64; 2],
    /// Largest coefficient of position and rotation.
    pub scales: [f64; 2],
}

/// Equation (8), once for each triangle that may hold the axis.
pub fn evaluate(
    model: &DistortionModel,
    position_mm: &High3,
    axis: &High3,
    outside: OutsidePolicy,
) -> Vec<HighEvaluation> {
    let at = match outside {
        OutsidePolicy::Extrapolate => position_mm.clone(),
        OutsidePolicy::Clamp | OutsidePolicy::Reject => clamped(model.bounds(), position_mm),
    };
    let order = model.order();
    let n = order + 1;
    let unit = unit_position(model.bounds(), &at);
    let [bases, slopes] = [basis, basis_slopes].map(|of| [0, 1, 2].map(|k| of(order, &unit[k])));
    let scales = [0, 3].map(|first| {
        let parts = |c: &[f64; 6]| c[first..first + 3].iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        model.coefficients().iter().map(parts).fold(0.0, f64::max)
    });
    weights(model.directions(), axis, model.weighting())
        .iter()
        .map(|w| {
            let mut values: [High; 6] = std::array::from_fn(|_| High::zero());
            // Sum of absolute values, and the slopes along x, y and z, to f64 only.
            let mut parts = [[0.0; 4]; 6];
            for (&direction, weight) in w.directions.iter().zip(&w.weights) {
                if weight.is_zero() {
                    continue;
                }
                let weight_f64 = weight.to_f64();
                for index in 0..n * n * n {
                    let place = [index / (n * n), index / n % n, index % n];
                    let factors: [&High; 3] = std::array::from_fn(|k| &bases[k][place[k]]);
                    let product = factors[0] * factors[1] * factors[2] * weight;
                    let size = product.to_f64().abs();
                    let steep: [f64; 3] = std::array::from_fn(|k| {
                        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                        slopes[k][place[k]].to_f64() * factors[i].to_f64() * factors[j].to_f64()
                    });
                    let c = &model.coefficients()[direction * n * n * n + index];
                    for ((value, part), &c) in values.iter_mut().zip(&mut parts).zip(c) {
                        *value += &product * c;
                        part[0] += size * c.abs();
                        for k in 0..3 {
                            part[k + 1] += weight_f64 * steep[k] * c;
                        }
                    }
                }
            }
            let u = unit.map(|u| u.to_f64().abs());
            let conditions = [0, 3].map(|first| {
                let own = parts[first..first + 3]
                    .iter()
                    .map(|p| p[0] + (0..3).map(|k| u[k] * p[k + 1].abs()).sum::<f64>())
                    .fold(0.0, f64::max);
                own / scales[first / 3].max(f64::MIN_POSITIVE) + 1.0 / w.sum
            });
            HighEvaluation { values, conditions, scales }
        })
        .collect()
}

/// `[w, x, y, z]` of a rotation vector.
pub fn exp(vector: &High3) -> [High; 4] {
    let angle = norm(vector);
    if angle.is_zero() {
        return [High::one(), High::zero(), High::zero(), High::zero()];
    }
    let half = &angle * 0.5;
    let [x, y, z] = (vector * (half.sin() / angle)).into();
    [half.cos(), x, y, z]
}

/// Rotation vector of a quaternion of any length, angle in `[0, π]`.
pub fn log(quaternion: &[High; 4]) -> High3 {
    let [w, x, y, z] = quaternion.clone();
    let v = High3::new(x, y, z);
    let sine = norm(&v);
    if sine.is_zero() {
        return v;
    }
    let (w, v) = if w.is_negative() { (-w, -v) } else { (w, v) };
    v * (sine.atan2(&w) * 2.0 / sine)
}

/// `[w, x, y, z]` of a rotation.
pub fn quaternion(rotation: &UnitQuaternion<f64>) -> [High; 4] {
    let q = rotation.quaternion();
    [q.w, q.i, q.j, q.k].map(High::from)
}

/// Rotation matrix of a quaternion of any length.
pub fn matrix([w, x, y, z]: &[High; 4]) -> High33 {
    // R = (w² - |v|²) I + 2 w [v]x + 2 v vᵀ, for a unit quaternion.
    let v = High3::new(x.clone(), y.clone(), z.clone());
    let (along, square) = (w * w, v.dot(&v));
    let turned = (cross_matrix(&v) * w.clone() + &v * v.transpose()) * High::from(2.0);
    (High33::identity() * (&along - &square) + turned) / (along + square)
}

/// `[x]` with `[x] y = x × y`.
pub fn cross_matrix(x: &High3) -> High33 {
    High33::from_columns(&[0, 1, 2].map(|k| x.cross(&High3::ith(k, High::one()))))
}

/// The smallest rotation from one axis to another, of any lengths.
pub fn axis_rotation(from: &High3, to: &High3) -> High3 {
    let cross = from.cross(to);
    let sine = norm(&cross);
    if sine.is_zero() {
        return cross;
    }
    cross * (sine.atan2(&from.dot(to)) / sine)
}

/// Length of the difference, in `f64`.
pub fn distance<'a>(found: &[f64], expected: impl IntoIterator<Item = &'a High>) -> f64 {
    let difference: Vec<High> =
        found.iter().zip(expected).map(|(&f, e)| High::from(f) - e).collect();
    norm(&difference).to_f64()
}

/// A point as it is.
pub fn point3(point: &Point3<f64>) -> High3 {
    vector3(point.coords.into())
}

/// An axis as its three numbers are.
pub fn axis3(axis: &Unit<Vector3<f64>>) -> High3 {
    vector3(axis.into_inner().into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_basis_component_is_known() {
        for set in DirectionSet::ALL {
            for (exact, own) in directions(set).iter().zip(set.directions()) {
                assert!(distance(own.as_slice(), exact) < 3e-16, "{set:?} {own:?}");
                assert!((norm(exact) - 1.0).abs() < High::from(1e-50));
            }
        }
    }

    #[test]
    fn logarithm_undoes_the_exponential() {
        for size in [1e-20, 1e-3, 1.0, 3.0] {
            let v = vector3([0.3, -0.5, 0.7]) * High::from(size);
            let off = log(&exp(&v)) - &v;
            assert!(off.iter().zip(&v).all(|(off, v)| off.abs() <= v.abs() * 1e-50));
        }
    }

    #[test]
    fn the_matrix_of_a_turn_about_z_is_the_textbooks() {
        let m = matrix(&exp(&vector3([0.0, 0.0, 0.5])));
        let (c, s) = (High::from(0.5).cos(), High::from(0.5).sin());
        let none = High::zero;
        let expected = [[c.clone(), -&s, none()], [s, c, none()], [none(), none(), High::one()]];
        let expected = High33::from_fn(|i, j| expected[i][j].clone());
        assert!((m - expected).iter().all(|off| off.abs() < High::from(1e-50)));
    }

    #[test]
    fn slopes_are_the_limits_of_differences() {
        let (x, step) = (High::from(0.3), High::from(1e-20));
        let (a, b) = (basis(5, &x), basis(5, &(&x + &step)));
        for ((a, b), slope) in a.iter().zip(&b).zip(basis_slopes(5, &x)) {
            assert!(((b - a) / &step - slope).abs() < High::from(1e-17));
        }
    }
}
