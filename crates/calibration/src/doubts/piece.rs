//! Rows in one piece of the table that are of another kind than the others, as where recordings are joined.
//!
//! What moves the rows of one piece alone is not the field's, and shows where it moves them by less than a group of
//! scattered rows has to be moved by. Each piece is tried that begins and ends at one of some rows.

use super::beside_field::{
    CUBIC_PLACE_TERMS, Effect, Rows as OfField, STANDARD_ERRORS, field_terms,
};
use super::mistake::Mistake;
use super::parts::{Rows, spread_sample};
use super::{Explained, Part, Suspicion};
use crate::robust::median;
use nalgebra::{DMatrix, DVector, Vector3};
use trackwright_field::samples::{
    MapKind, Measurement, MeasurementContent, MeasurementSet, PoseError,
};

/// Cells of the table at which a piece may begin and end.
const CELLS: usize = 100;

/// Part of the piece itself, and of the effect's square, that place and axis have to leave: along a path, and in a
/// grid that is measured line by line, a piece is a place, and what the polynomials miss of the field is an effect.
const LEAST_OWN_PART: f64 = 0.3;

/// Part of the RMS of what is left from which an effect is reported, and what it moves all rows by in the mean.
const LEAST_OF_LEFT: f64 = 0.5;
const LEAST_MM: f64 = 0.2;
const LEAST_RAD: f64 = 0.008;

/// Rows whose sides are exchanged have this part of the field with the other sign at least, and at most.
const EXCHANGED: std::ops::Range<f64> = 0.6..1.4;

/// What may be wrong with the rows of a piece.
struct Kind {
    errors: Effect,
    effects: Vec<Effect>,
    least: f64,
    mistake: fn(&[f64]) -> Option<Mistake>,
}

pub(super) fn in_one_piece(rows: Rows, content: MeasurementContent) -> Option<Suspicion> {
    let rows = spread_sample(rows);
    let measurements: Vec<Measurement> = rows.iter().map(|(_, m)| *m).collect();
    let terms = field_terms(&measurements, content, CUBIC_PLACE_TERMS, false)?;
    let found = kinds(&measurements, content, &terms)?.into_iter().filter_map(|kind| {
        let of_field = OfField::new(kind.errors.clone(), terms.clone());
        let (piece, left) = best_piece(&of_field, &kind.effects)?;
        Some((suspicion(&rows, &of_field, &kind, piece)?, left))
    });
    let (best, _) = found.min_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(best)
}

fn kinds(
    rows: &[Measurement],
    content: MeasurementContent,
    terms: &[DVector<f64>],
) -> Option<Vec<Kind>> {
    let set = MeasurementSet { measurements: rows.to_vec(), content };
    let errors: Vec<PoseError> =
        set.samples(MapKind::Distortion).samples.iter().map(|s| s.error).collect();
    let positions: Effect = errors.iter().map(|e| e.position_mm).collect();
    let of = |direction: &dyn Fn(&Measurement) -> Vector3<f64>| -> Effect {
        rows.iter().map(direction).collect()
    };
    let along = |axis: usize| of(&move |m| m.tracker_from_ideal.rotation * Vector3::ith(axis, 1.0));
    let constant = |axis: usize| of(&move |_| Vector3::ith(axis, 1.0));
    let field = OfField::new(positions.clone(), terms.to_vec()).weighted(&[])?.fitted(&[])?;
    let of_positions =
        |effects, mistake| Kind { errors: positions.clone(), effects, least: LEAST_MM, mistake };
    let mut all = vec![
        of_positions(vec![of(&|m| m.tracker_from_ideal.translation.vector)], |by| {
            Some(Mistake::Scale(1.0 + by[0]))
        }),
        of_positions([0, 1, 2].map(constant).to_vec(), |by| {
            Some(Mistake::Frame { angle_rad: 0.0, shift: Vector3::from_column_slice(by).norm() })
        }),
        of_positions(vec![field.iter().map(|e| e * -2.0).collect()], |by| {
            EXCHANGED.contains(&by[0]).then_some(Mistake::Exchanged)
        }),
    ];
    if content != MeasurementContent::PositionOnly {
        all.push(of_positions(vec![along(2)], |by| {
            Some(Mistake::SensorOffset { offset_mm: [0.0, 0.0, by[0]], standard_error_mm: None })
        }));
        all.push(Kind {
            errors: errors.iter().map(|e| e.rotation_rad).collect(),
            effects: vec![along(0), along(1)],
            least: LEAST_RAD,
            mistake: |by| Some(Mistake::SensorTilt { angle_rad: by[0].hypot(by[1]) }),
        });
    }
    Some(all)
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
fn best_piece(of_field: &OfField, effects: &[Effect]) -> Option<(std::ops::Range<usize>, f64)> {
    let count = of_field.errors.len();
    let weighted = of_field.weighted(&[])?;
    let basis = weighted.basis()?;
    let roots: Vec<f64> = weighted.weights().iter().map(|w| w.sqrt()).collect();
    let matrix = |rows: &[Vector3<f64>]| DMatrix::from_fn(count, 3, |i, c| roots[i] * rows[i][c]);
    let errors = matrix(&of_field.errors);
    let left = &errors - &basis * basis.tr_mul(&errors);
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
    of_field: &OfField,
    kind: &Kind,
    piece: std::ops::Range<usize>,
) -> Option<Suspicion> {
    let of_piece = |(i, v): (usize, &Vector3<f64>)| {
        if piece.contains(&i) { *v } else { Vector3::zeros() }
    };
    let effects: Vec<Effect> =
        kind.effects.iter().map(|of| of.iter().enumerate().map(of_piece).collect()).collect();
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
        && rms * piece.len() as f64 > kind.least * rows.len() as f64;
    let mistake = (kind.mistake)(&by).filter(|_| is_it)?;
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
