//! A table's errors beside a smooth field: how large some effects are in them, by how much they are known, and what
//! is left.
//!
//! The field is taken for a polynomial of place and axis, even in the axis: a coil turned round reads the same.
//! Effects are found robustly; their standard errors are by leaving out pieces of the table (delete-a-group
//! jackknife), since what polynomials leave is alike from row to row.

use crate::robust::median;
use nalgebra::{DMatrix, DVector, Vector3};
use trackwright_field::samples::{Measurement, MeasurementContent};
use trackwright_geometry::bounds::Bounds;

/// Pieces of the table, one of which is left out in turn.
const PIECES: usize = 16;

/// Rows for each term of the polynomials.
pub(super) const ROWS_A_TERM: usize = 4;

/// Standard errors beyond which something is reported: every table is looked at.
pub(super) const STANDARD_ERRORS: f64 = 5.0;

/// Weight in rows of the prior that each term of the field is nothing: without it the polynomials follow a
/// path that hardly meets itself, and leave nothing to its speed. That of noise of 0.3 mm beside terms of 1 mm.
const PRIOR: f64 = 0.1;

/// Where more than so many times the median is left of a row, it counts less: of normal errors a seventh is beyond.
const MOST_LEFT: f64 = 1.5;

/// Solutions at most, and the change of that bound at which no more are made.
const MOST_ROUNDS: usize = 50;
const SAME_BOUND: f64 = 1e-3;

/// Terms of place of the second degree and the third, those of the first degree first.
pub(super) const PLACE_TERMS: usize = 10;
pub(super) const CUBIC_PLACE_TERMS: usize = 20;

/// Terms of the axis, which are even in it: a coil turned round reads the same.
pub(super) const AXIS_TERMS: usize = 6;

/// Terms of a whole rotation beside them, each with the places of the first degree: a tool's own coils lie
/// beside its origin.
const ROTATION_TERMS: usize = 9;
const LINEAR_PLACE_TERMS: usize = 4;

/// What a unit of an effect moves each row's reading by.
pub(super) type Effect = Vec<Vector3<f64>>;

/// An effect's size, its standard error, and the part of its square that place and axis do not explain.
pub(super) struct Estimate {
    pub value: f64,
    pub standard_error: f64,
    pub own_part: f64,
}

/// The rows in their order, and the field's terms at each.
#[derive(Clone)]
pub(super) struct Rows {
    pub errors: Vec<Vector3<f64>>,
    weights: Vec<f64>,
    pub terms: Vec<DVector<f64>>,
}

pub(super) fn place(m: &Measurement) -> Vector3<f64> {
    m.tracker_from_ideal.translation.vector
}

/// The field's terms at each row, the most that the number of rows allows; those of whole rotations on request.
pub(super) fn field_terms(
    rows: &[Measurement],
    content: MeasurementContent,
    most_places: usize,
    with_rotations: bool,
) -> Option<Vec<DVector<f64>>> {
    let axis_terms = if content == MeasurementContent::PositionOnly { 1 } else { AXIS_TERMS };
    let tried = [
        (CUBIC_PLACE_TERMS, axis_terms),
        (PLACE_TERMS, axis_terms),
        (LINEAR_PLACE_TERMS, axis_terms),
        (LINEAR_PLACE_TERMS, 1),
    ];
    let of_rotations = match with_rotations && content == MeasurementContent::SixDof {
        true => LINEAR_PLACE_TERMS * ROTATION_TERMS,
        false => 0,
    };
    let fits = |(places, axes): &(usize, usize)| {
        *places <= most_places && rows.len() >= ROWS_A_TERM * (places * axes + of_rotations)
    };
    let (places, axes) = tried.into_iter().find(fits)?;
    let bounds = Bounds::around(rows.iter().map(|m| place(m).into()))?;
    let middle = bounds.center_mm().coords;
    // A table in one plane has a box without thickness.
    let half = bounds.size_mm().map(|edge| (0.5 * edge).max(f64::EPSILON));
    let of_axes = places * axes;
    let terms = rows.iter().map(|m| {
        let u = (place(m) - middle).component_div(&half);
        let [x, y, z] = [u.x, u.y, u.z];
        let square = [x * x, y * y, z * z, x * y, y * z, z * x];
        let [xx, yy, zz, xy, _, _] = square;
        let cube = [xx * x, yy * y, zz * z, xx * y, xx * z, yy * x, yy * z, zz * x, zz * y, xy * z];
        let of_place = [&[1.0, x, y, z][..], &square, &cube].concat();
        let rotation = m.tracker_from_ideal.rotation.to_rotation_matrix();
        let n = rotation * Vector3::z();
        let of_axis: [f64; AXIS_TERMS] =
            [1.0, n.x * n.y, n.y * n.z, n.z * n.x, n.x * n.x - n.y * n.y, n.z * n.z - 1.0 / 3.0];
        DVector::from_fn(of_axes + of_rotations, |k, _| match k.checked_sub(of_axes) {
            None => of_place[k % places] * of_axis[k / places],
            Some(k) => of_place[k % LINEAR_PLACE_TERMS] * rotation.matrix()[k / LINEAR_PLACE_TERMS],
        })
    });
    Some(terms.collect())
}

/// An orthogonal basis of terms, whose columns they are, beside their prior.
pub(super) fn basis(terms: DMatrix<f64>) -> Option<DMatrix<f64>> {
    let mut normal = terms.tr_mul(&terms);
    for k in 0..normal.nrows() {
        normal[(k, k)] += PRIOR;
    }
    let inverse = normal.cholesky()?.l().try_inverse()?;
    Some(terms * inverse.transpose())
}

pub(super) fn error(m: &Measurement) -> Vector3<f64> {
    m.tracker_from_measured.translation.vector - place(m)
}

impl Rows {
    pub(super) fn new(errors: Vec<Vector3<f64>>, terms: Vec<DVector<f64>>) -> Self {
        Self { weights: vec![1.0; errors.len()], errors, terms }
    }

    pub(super) fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// An orthogonal basis of the field at the rows, each times the root of its weight.
    pub(super) fn basis(&self) -> Option<DMatrix<f64>> {
        basis(DMatrix::from_fn(self.terms.len(), self.terms[0].len(), |i, k| {
            self.weights[i].sqrt() * self.terms[i][k]
        }))
    }

    pub(super) fn of_rows(&self, rows: &[usize]) -> Self {
        Self {
            errors: rows.iter().map(|&k| self.errors[k]).collect(),
            weights: rows.iter().map(|&k| self.weights[k]).collect(),
            terms: rows.iter().map(|&k| self.terms[k].clone()).collect(),
        }
    }

    /// With the weights of Huber's estimate (Huber, Robust Statistics, 1981, 7.8). Least squares would follow the
    /// rows at which the tracker has another solution, or the field is steep.
    pub(super) fn weighted(&self, effects: &[Effect]) -> Option<Self> {
        let mut rows = self.clone();
        let mut bound_mm = f64::INFINITY;
        for _ in 0..MOST_ROUNDS {
            let fitted = rows.fitted(effects)?;
            let left =
                self.errors.iter().zip(&fitted).map(|(error, fitted)| (error - fitted).norm());
            let left_mm: Vec<f64> = left.collect();
            let last_mm =
                std::mem::replace(&mut bound_mm, MOST_LEFT * median(&mut left_mm.clone())?);
            rows.weights = left_mm.iter().map(|mm| (bound_mm / mm).min(1.0)).collect();
            if (last_mm - bound_mm).abs() <= SAME_BOUND * bound_mm {
                break;
            }
        }
        Some(rows)
    }

    /// What field and effects give at each row.
    pub(super) fn fitted(&self, effects: &[Effect]) -> Option<Vec<Vector3<f64>>> {
        let solution = Sums::of(self, effects, 0..self.errors.len()).solution()?;
        let row = |(i, terms): (usize, &DVector<f64>)| {
            let of_field = Vector3::from_fn(|c, _| terms.dot(&solution.field.column(c)));
            let of_effects = effects.iter().zip(&solution.values);
            of_effects.fold(of_field, |sum, (effect, value)| sum + effect[i] * *value)
        };
        Some(self.terms.iter().enumerate().map(row).collect())
    }

    /// The effects beside the field, and the RMS of what counts of what is left beside both.
    pub(super) fn estimates(&self, effects: &[Effect]) -> Option<(Vec<Estimate>, f64)> {
        let count = self.errors.len();
        let rows = self.weighted(effects)?;
        let pieces: Vec<Sums> = (0..PIECES)
            .map(|piece| {
                let range = piece * count / PIECES..(piece + 1) * count / PIECES;
                Sums::of(&rows, effects, range)
            })
            .collect();
        let none = Sums::none(&rows, effects);
        let all = pieces.iter().fold(none, |sum, piece| sum.plus(piece, 1.0));
        let whole = all.solution()?;
        let without: Option<Vec<DVector<f64>>> =
            pieces.iter().map(|piece| Some(all.plus(piece, -1.0).solution()?.values)).collect();
        let without = without?;
        // The weights would change with the rows that are left out (Huber, 7.6).
        let full = rows.weights.iter().filter(|weight| **weight == 1.0).count();
        let by_weights = rows.weights.iter().sum::<f64>() / full as f64;
        let estimate = |k: usize| {
            let mean = without.iter().map(|of| of[k]).sum::<f64>() / PIECES as f64;
            let squared: f64 = without.iter().map(|of| (of[k] - mean).powi(2)).sum();
            let part = (PIECES - 1) as f64 / PIECES as f64;
            Estimate {
                value: whole.values[k],
                standard_error: (part * squared).sqrt() * by_weights,
                own_part: whole.own_parts[k],
            }
        };
        let left_mm = (whole.squared_left.max(0.0) / rows.weights.iter().sum::<f64>()).sqrt();
        Some(((0..effects.len()).map(estimate).collect(), left_mm))
    }
}

/// Field and effects by least squares.
struct Solution {
    /// A column for each component of the error.
    field: DMatrix<f64>,
    values: DVector<f64>,
    own_parts: Vec<f64>,
    squared_left: f64,
}

/// Sums over rows from which the effects follow.
struct Sums {
    /// Of the field's terms among themselves.
    field: DMatrix<f64>,
    /// Of the field's terms with each effect and the errors, a component after the other.
    across: DMatrix<f64>,
    /// Of effects and errors among themselves.
    own: DMatrix<f64>,
}

impl Sums {
    fn none(rows: &Rows, effects: &[Effect]) -> Self {
        let (terms, own) = (rows.terms[0].len(), effects.len() + 1);
        Self {
            field: DMatrix::zeros(terms, terms),
            across: DMatrix::zeros(terms, 3 * own),
            own: DMatrix::zeros(own, own),
        }
    }

    fn of(rows: &Rows, effects: &[Effect], range: std::ops::Range<usize>) -> Self {
        let mut sums = Self::none(rows, effects);
        for i in range {
            let (terms, weight) = (&rows.terms[i], rows.weights[i]);
            sums.field.ger(weight, terms, terms, 1.0);
            let each: Vec<Vector3<f64>> =
                effects.iter().map(|of| of[i]).chain([rows.errors[i]]).collect();
            let flat =
                DVector::from_iterator(3 * each.len(), each.iter().flat_map(|v| v.iter().copied()));
            sums.across.ger(weight, terms, &flat, 1.0);
            for (a, first) in each.iter().enumerate() {
                for (b, second) in each.iter().enumerate() {
                    sums.own[(a, b)] += weight * first.dot(second);
                }
            }
        }
        sums
    }

    fn plus(&self, other: &Self, sign: f64) -> Self {
        Self {
            field: &self.field + &other.field * sign,
            across: &self.across + &other.across * sign,
            own: &self.own + &other.own * sign,
        }
    }

    fn solution(&self) -> Option<Solution> {
        let of_each = solved(self.field.clone(), &self.across, PRIOR)?;
        let explained = self.across.transpose() * &of_each;
        let count = self.own.nrows();
        // What the field does not explain, summed over components.
        let left = DMatrix::from_fn(count, count, |a, b| {
            let of_field: f64 = (0..3).map(|c| explained[(3 * a + c, 3 * b + c)]).sum();
            self.own[(a, b)] - of_field
        });
        let own = left.view((0, 0), (count - 1, count - 1)).into_owned();
        let with_errors = left.view((0, count - 1), (count - 1, 1)).into_owned();
        let values = match count {
            1 => DVector::zeros(0),
            _ => solved(own, &with_errors, 0.0)?.column(0).into_owned(),
        };
        let of_errors = of_each.columns(3 * (count - 1), 3).into_owned();
        let beside = |field, (k, value): (usize, &f64)| field - of_each.columns(3 * k, 3) * *value;
        Some(Solution {
            field: values.iter().enumerate().fold(of_errors, beside),
            squared_left: left[(count - 1, count - 1)] - values.dot(&with_errors.column(0)),
            own_parts: (0..count - 1).map(|k| left[(k, k)] / self.own[(k, k)]).collect(),
            values,
        })
    }
}

/// The solution of normal equations with a prior of so many rows; `None` where they do not determine it.
fn solved(mut normal: DMatrix<f64>, right: &DMatrix<f64>, prior: f64) -> Option<DMatrix<f64>> {
    for k in 0..normal.nrows() {
        normal[(k, k)] += prior;
    }
    Some(normal.cholesky()?.solve(right))
}
