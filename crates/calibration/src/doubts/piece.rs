//! Rows in one piece of the table that are of another kind than the others, as where recordings are joined.
//!
//! What moves the rows of one piece alone is not the field's, and shows where it moves them by less than a group of
//! scattered rows has to be moved by. Each piece is tried that begins and ends at one of some rows.

use super::beside_field::{
    CUBIC_PLACE_TERMS, Effect, Rows as OfField, STANDARD_ERRORS, field_terms,
};
use super::effects::{Effects, LEAST_MM, LEAST_RAD, effects, errors};
use super::mistake::Mistake;
use super::parts::{Rows, spread_sample};
use super::{Explained, Part, Suspicion};
use crate::robust::median;
use nalgebra::{DMatrix, DVector, Vector3};
use trackwright_field::samples::{Measurement, MeasurementContent};

/// Cells of the table at which a piece may begin and end.
const CELLS: usize = 100;

/// Part of the piece itself, and of the effect's square, that place and axis have to leave: along a path, and in a
/// grid that is measured line by line, a piece is a place, and what the polynomials miss of the field is an effect.
const LEAST_OWN_PART: f64 = 0.3;

/// Part of the RMS of what is left from which an effect is reported.
const LEAST_OF_LEFT: f64 = 0.5;

/// Rows whose sides are exchanged have this part of the field with the other sign at least, and at most.
const EXCHANGED: std::ops::Range<f64> = 0.6..1.4;

/// Errors beside a smooth field, which all effects on them have in common.
struct OfErrors {
    of_field: OfField,
    weighted: OfField,
    basis: DMatrix<f64>,
    least: f64,
}

impl OfErrors {
    fn new(errors: Effect, terms: &[DVector<f64>], least: f64) -> Option<Self> {
        let of_field = OfField::new(errors, terms.to_vec());
        let weighted = of_field.weighted(&[])?;
        let basis = weighted.basis()?;
        Some(Self { of_field, weighted, basis, least })
    }
}

pub(super) fn in_one_piece(rows: Rows, content: MeasurementContent) -> Option<Suspicion> {
    let rows = spread_sample(rows);
    let measurements: Vec<Measurement> = rows.iter().map(|(_, m)| *m).collect();
    let terms = field_terms(&measurements, content, CUBIC_PLACE_TERMS, false)?;
    let [positions, rotations] = errors(&measurements, content);
    let positions = OfErrors::new(positions, &terms, LEAST_MM)?;
    let rotations = OfErrors::new(rotations, &terms, LEAST_RAD)?;
    let field = positions.weighted.fitted(&[])?;
    let exchanged = Effects {
        of_angles: false,
        each: vec![field.iter().map(|error| error * -2.0).collect()],
        mistake: |_| Mistake::Exchanged,
    };
    let all = effects(&measurements, content).into_iter().chain([exchanged]);
    let found = all.filter_map(|effects| {
        let of = if effects.of_angles { &rotations } else { &positions };
        let (piece, left) = best_piece(of, &effects.each)?;
        Some((suspicion(&rows, of, &effects, piece)?, left))
    });
    let (best, _) = found.min_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(best)
}

/// Sums over the rows before a cell: of the field's basis with each effect, of effects among themselves and with
/// what the field leaves.
#[derive(Clone)]
struct Sums {
    with_basis: DMatrix<f64>,
    own: DMatrix<f64>,
    with_left: DVector<f64>,
    /// Of the basis with the rows themselves, and of their weights.
    of_rows: DVector<f64>,
    weight: f64,
}

/// The piece in which effects of their own explain most, as rows, and the part of the squares that is left.
fn best_piece(of: &OfErrors, effects: &[Effect]) -> Option<(std::ops::Range<usize>, f64)> {
    let OfErrors { of_field, weighted, basis, .. } = of;
    let count = of_field.errors.len();
    let roots: Vec<f64> = weighted.weights().iter().map(|w| w.sqrt()).collect();
    let matrix = |rows: &[Vector3<f64>]| DMatrix::from_fn(count, 3, |i, c| roots[i] * rows[i][c]);
    let errors = matrix(&of_field.errors);
    let left = &errors - basis * basis.tr_mul(&errors);
    let effects: Vec<DMatrix<f64>> = effects.iter().map(|effect| matrix(effect)).collect();
    let number = effects.len();
    let mut sums = vec![Sums {
        with_basis: DMatrix::zeros(basis.ncols(), 3 * number),
        own: DMatrix::zeros(number, number),
        with_left: DVector::zeros(number),
        of_rows: DVector::zeros(basis.ncols()),
        weight: 0.0,
    }];
    let edge = |cell: usize| cell * count / CELLS;
    for cell in 0..CELLS {
        let mut sum = sums[cell].clone();
        let (first, rows) = (edge(cell), edge(cell + 1) - edge(cell));
        let of_cell = |all: &DMatrix<f64>| all.rows(first, rows).into_owned();
        for (i, root) in roots.iter().enumerate().skip(first).take(rows) {
            sum.of_rows += basis.row(i).transpose() * *root;
            sum.weight += root * root;
        }
        for (a, effect) in effects.iter().enumerate() {
            let own = of_cell(effect);
            let mut with_basis = sum.with_basis.columns_mut(3 * a, 3);
            with_basis += basis.rows(first, rows).tr_mul(&own);
            sum.with_left[a] += own.dot(&of_cell(&left));
            for (b, other) in effects.iter().enumerate() {
                sum.own[(a, b)] += own.dot(&of_cell(other));
            }
        }
        sums.push(sum);
    }
    let total = left.norm_squared();
    let gain = |from: &Sums, to: &Sums| -> Option<f64> {
        let with_basis = &to.with_basis - &from.with_basis;
        let of_effects = &to.own - &from.own;
        let with_left = &to.with_left - &from.with_left;
        let beside = DMatrix::from_fn(number, number, |a, b| {
            of_effects[(a, b)] - with_basis.columns(3 * a, 3).dot(&with_basis.columns(3 * b, 3))
        });
        let explained = (&to.of_rows - &from.of_rows).norm_squared();
        if (to.weight - from.weight) * (1.0 - LEAST_OWN_PART) < explained {
            return None;
        }
        let is_own = (0..number).all(|k| beside[(k, k)] > LEAST_OWN_PART * of_effects[(k, k)]);
        let by = is_own.then(|| beside.cholesky())??.solve(&with_left);
        Some(by.dot(&with_left))
    };
    let mut best = (0..0, 0.0);
    for first in 0..CELLS {
        for end in first + 1..=(first + CELLS / 2).min(CELLS) {
            if let Some(gain) = gain(&sums[first], &sums[end]).filter(|gain| *gain > best.1) {
                best = (edge(first)..edge(end), gain);
            }
        }
    }
    (!best.0.is_empty()).then(|| (best.0, 1.0 - best.1 / total))
}

fn suspicion(
    rows: Rows,
    of: &OfErrors,
    made: &Effects,
    piece: std::ops::Range<usize>,
) -> Option<Suspicion> {
    let of_field = &of.of_field;
    let of_piece = |(i, v): (usize, &Vector3<f64>)| {
        if piece.contains(&i) { *v } else { Vector3::zeros() }
    };
    let effects: Vec<Effect> =
        made.each.iter().map(|of| of.iter().enumerate().map(of_piece).collect()).collect();
    let (found, rms_left) = of_field.estimates(&effects)?;
    let norm = |value: &dyn Fn(usize) -> f64| {
        (0..found.len()).map(|k| value(k).powi(2)).sum::<f64>().sqrt()
    };
    let by: Vec<f64> = found.iter().map(|e| e.value).collect();
    let moved = |i: usize| -> Vector3<f64> {
        effects.iter().zip(&by).map(|(effect, by)| effect[i] * *by).sum()
    };
    let squared: f64 = piece.clone().map(|i| moved(i).norm_squared()).sum();
    let rms = (squared / piece.len() as f64).sqrt();
    let is_it = norm(&|k| by[k]) > STANDARD_ERRORS * norm(&|k| found[k].standard_error)
        && rms > LEAST_OF_LEFT * rms_left
        && rms * piece.len() as f64 > of.least * rows.len() as f64;
    let mistake = (made.mistake)(&by);
    if !is_it || mistake == Mistake::Exchanged && !EXCHANGED.contains(&by[0]) {
        return None;
    }
    let fitted = of_field.weighted(&effects)?.fitted(&effects)?;
    let left = |i: usize| of_field.errors[i] - fitted[i];
    let typical =
        |of: &dyn Fn(usize) -> f64| median(&mut piece.clone().map(of).collect::<Vec<_>>());
    let explained = Explained {
        before: typical(&|i| (left(i) + moved(i)).norm())?,
        after: typical(&|i| left(i).norm())?,
        is_certain: false,
    };
    let first_row = rows[piece.start].0 + 1;
    let part = Some(Part { count: piece.len(), of: rows.len(), first_row });
    Some(Suspicion::Mistake { mistake, part, explained })
}
