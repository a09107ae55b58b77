//! Rows that are of another kind than the others of their table.
//!
//! Where a mistake moves readings by more than any field does, each row shows it by itself. Where it moves them as
//! a field may, the rows are two groups beside a smooth field: one moved by an effect with the same parameters
//! throughout, one not moved. Groups, parameters and field are found in turns (Lloyd, IEEE Transactions on
//! Information Theory 28, 1982, with the field in the place of the two means).

use super::beside_field::{CUBIC_PLACE_TERMS, Effect, basis, field_terms};
use super::effects::{LEAST_MM, LEAST_RAD, effects, errors};
use super::mistake::Mistake;
use super::{Explained, Part, Suspicion};
use crate::robust::median;
use nalgebra::{DMatrix, DVector, Vector3};
use trackwright_field::samples::{Measurement, MeasurementContent};

/// A row is far where its sides differ by more than this and by so many times what the better quarter of the rows
/// do: good tables have 50 mm and 19 times at most.
pub(super) const FAR_MM: f64 = 60.0;
const FAR_RAD: f64 = 0.52;
pub(super) const FAR_RATIO: f64 = 20.0;

/// A far row is explained where so many times the median of the rows that are not far is left of it.
const AS_NEAR: f64 = 5.0;

/// A less simple mistake has to explain so many times the rows.
const MORE: f64 = 1.2;

/// Rows that are looked at, from all over the table.
const MOST_ROWS: usize = 1024;

/// Fewest rows of a group.
const LEAST_GROUP: usize = 5;

/// How many times less the effect has to leave of its group. Of normal residuals the outermost hundredth shows 2.
const GROUP_RATIO: f64 = 3.0;

/// A row is like those of a group where it differs by this part of the effect; it is of it where that part of the
/// effect is left.
const DEVIANT_PART: f64 = 0.5;
const EXPLAINED_PART: f64 = 0.35;

/// A group of a large effect has this part of the rows like it: the others are outliers of other causes. Good tables
/// have 0.5 at most.
const MEMBERS_PART: f64 = 0.6;

/// A group that leaves less than so many times the squares of the rows without it needs a smaller part of the rows
/// like it, with one parameter a still smaller one. Good tables of this many rows have 0.73 at least (JHU's, of
/// positions alone), of so many 0.74, and with one parameter 0.75.
const BETTER: f64 = 0.715;
const BETTER_OF_MANY: f64 = 0.735;
const SOME_PART: f64 = 0.3;
const SOME_PART_OF_ONE: f64 = 0.15;
const MANY_ROWS: usize = 500;
const LEAST_ROWS: usize = 200;

/// An effect that moves its group by more than this is large.
const LARGE_MM: f64 = 20.0;
const LARGE_RAD: f64 = 0.7;

/// Turns at most, and the parts of the rows that a group may be at the start.
const MOST_TURNS: usize = 12;
const STARTS: [f64; 3] = [0.5, 0.15, 0.02];

/// Residuals beyond so many times the median do not count for an effect's parameters.
const TRIMMED: f64 = 6.0;

/// An effect with more parameters has to leave so many times less for each of them.
const BY_PARAMETER: f64 = 1.1;

/// Rows with their places in the table.
pub(super) type Rows<'a> = &'a [(usize, Measurement)];

/// Which rows are far, and what they are where one mistake explains half of them at least.
pub(super) struct FarRows {
    pub is_far: Vec<bool>,
    /// What is left of a row that is explained, at most.
    pub near: f64,
    pub found: Option<Suspicion>,
}

pub(super) fn far_positions(rows: Rows) -> FarRows {
    far(rows, Mistake::of_positions(), FAR_MM, |m| {
        let (ideal, measured) = super::whole::positions(m);
        (measured - ideal).norm()
    })
}

pub(super) fn far_orientations(rows: Rows) -> FarRows {
    far(rows, Mistake::of_orientations(), FAR_RAD, angle)
}

/// Between the sensor's axes of both sides.
pub(super) fn angle(m: &Measurement) -> f64 {
    let [a, b] = [m.tracker_from_ideal, m.tracker_from_measured].map(|p| p.rotation * Vector3::z());
    a.angle(&b)
}

fn far(
    rows: Rows,
    mistakes: impl Iterator<Item = Mistake>,
    least: f64,
    apart: impl Fn(&Measurement) -> f64,
) -> FarRows {
    let before: Vec<f64> = rows.iter().map(|(_, m)| apart(m)).collect();
    let mut sorted = before.clone();
    sorted.sort_by(f64::total_cmp);
    let limit = least.max(FAR_RATIO * sorted.get(rows.len() / 4).copied().unwrap_or(0.0));
    let is_far: Vec<bool> = before.iter().map(|apart| *apart > limit).collect();
    let far: Vec<usize> = (0..rows.len()).filter(|&k| is_far[k]).collect();
    let near = AS_NEAR * sorted.get((rows.len() - far.len()) / 2).copied().unwrap_or(0.0);
    let explained = |mistake: &Mistake| -> Vec<usize> {
        let is_it = |&k: &usize| apart(&mistake.undone(&rows[k].1)) <= near;
        match mistake.is_plausible(rows, &is_far) {
            true => far.iter().copied().filter(is_it).collect(),
            false => Vec::new(),
        }
    };
    let mut best: Option<(Mistake, Vec<usize>)> = None;
    for mistake in mistakes.filter(|_| !far.is_empty()) {
        let members = explained(&mistake);
        let least = best.as_ref().map_or(0.0, |best| MORE * best.1.len() as f64);
        if members.len() as f64 > least {
            best = Some((mistake, members));
        }
    }
    let found = best.filter(|(_, members)| 2 * members.len() >= far.len());
    let found = found.and_then(|(mistake, members)| {
        let of = |value: &dyn Fn(usize) -> f64| {
            median(&mut members.iter().map(|&k| value(k)).collect::<Vec<_>>())
        };
        let after = of(&|k| apart(&mistake.undone(&rows[k].1)))?;
        let explained = Explained::new(of(&|k| before[k])?, after, least, least)?;
        let first_row = rows[*members.first()?].0 + 1;
        let part = Some(Part { count: members.len(), of: rows.len(), first_row });
        Some(Suspicion::Mistake { mistake, part, explained })
    });
    FarRows { is_far, near, found }
}

/// A group of rows that one effect moves.
struct Group {
    mistake: Mistake,
    members: Vec<usize>,
    before: f64,
    after: f64,
    /// What is left of the squares of all rows, as a part of that without the group, each parameter paid for.
    left: f64,
}

/// Rows that an effect as large as a field's moves, and the effect.
pub(super) fn moved(rows: Rows, content: MeasurementContent) -> Option<Suspicion> {
    let rows = spread_sample(rows);
    let measurements: Vec<Measurement> = rows.iter().map(|(_, m)| *m).collect();
    let terms = field_terms(&measurements, content, CUBIC_PLACE_TERMS, false)?;
    let beside = Beside::new(&terms)?;
    let [positions, rotations] =
        errors(&measurements, content).map(|errors| matrix(errors.into_iter()));
    let groups = effects(&measurements, content).into_iter().map(|of| match of.of_angles {
        false => group(&beside, &positions, &of.each, [LEAST_MM, LARGE_MM], of.mistake),
        true => group(&beside, &rotations, &of.each, [LEAST_RAD, LARGE_RAD], of.mistake),
    });
    let groups = groups.chain([exchanged(&beside, &positions)]);
    let best = groups.flatten().min_by(|a, b| a.left.total_cmp(&b.left))?;
    let count = best.members.len();
    let explained = Explained { before: best.before, after: best.after, is_certain: false };
    let part = Some(Part { count, of: rows.len(), first_row: rows[*best.members.first()?].0 + 1 });
    Some(Suspicion::Mistake { mistake: best.mistake, part, explained })
}

/// Rows from all over the table in no rhythm that a mistake in every so many-th row may have.
pub(super) fn spread_sample(rows: Rows) -> Vec<(usize, Measurement)> {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    if rows.len() <= MOST_ROWS {
        return rows.to_vec();
    }
    let mut chosen: Vec<usize> = (0..MOST_ROWS)
        .map(|k| ((k as f64 * GOLDEN).fract() * rows.len() as f64) as usize)
        .collect();
    chosen.sort_unstable();
    chosen.dedup();
    chosen.into_iter().map(|k| rows[k]).collect()
}

fn matrix(rows: impl ExactSizeIterator<Item = Vector3<f64>>) -> DMatrix<f64> {
    let count = rows.len();
    let mut all = DMatrix::zeros(count, 3);
    for (k, row) in rows.enumerate() {
        all.row_mut(k).copy_from(&row.transpose());
    }
    all
}

/// A smooth field, by an orthogonal basis of its terms at the rows.
struct Beside {
    basis: DMatrix<f64>,
}

impl Beside {
    fn new(terms: &[DVector<f64>]) -> Option<Self> {
        let basis = basis(DMatrix::from_fn(terms.len(), terms[0].len(), |i, k| terms[i][k]))?;
        Some(Self { basis })
    }

    fn fitted(&self, values: &DMatrix<f64>) -> DMatrix<f64> {
        &self.basis * self.basis.tr_mul(values)
    }

    fn left(&self, values: &DMatrix<f64>) -> DMatrix<f64> {
        values - self.fitted(values)
    }
}

fn norm(rows: &DMatrix<f64>, k: usize) -> f64 {
    rows.row(k).norm()
}

/// The best of the groups that an effect makes, where it explains its group.
fn group(
    beside: &Beside,
    values: &DMatrix<f64>,
    effects: &[Effect],
    least: [f64; 2],
    mistake: impl Fn(&[f64]) -> Mistake,
) -> Option<Group> {
    let count = values.nrows();
    let effects: Vec<DMatrix<f64>> =
        effects.iter().map(|effect| matrix(effect.iter().copied())).collect();
    let left = beside.left(values);
    // How much of the effects each row shows by itself, along the direction in which that varies most.
    let shown = DMatrix::from_fn(count, effects.len(), |i, k| {
        left.row(i).dot(&effects[k].row(i))
            / effects[k].row(i).norm_squared().max(f64::MIN_POSITIVE)
    });
    let along = shown.tr_mul(&shown).symmetric_eigen();
    let main = along.eigenvectors.column(along.eigenvalues.imax()).into_owned();
    let shown = &shown * main;
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|a, b| shown[*a].total_cmp(&shown[*b]));
    let mut best: Option<Group> = None;
    for part in STARTS {
        let size = ((part * count as f64) as usize).max(LEAST_GROUP);
        for members in [&order[..size], &order[count - size..]] {
            let found = settled(beside, values, &effects, members, least, &mistake);
            if let Some(found) = found
                && best.as_ref().is_none_or(|best| found.left < best.left)
            {
                best = Some(found);
            }
        }
    }
    best
}

fn settled(
    beside: &Beside,
    values: &DMatrix<f64>,
    effects: &[DMatrix<f64>],
    start: &[usize],
    least: [f64; 2],
    mistake: impl Fn(&[f64]) -> Mistake,
) -> Option<Group> {
    let count = values.nrows();
    let of_field = beside.left(values);
    let mut is_member = vec![false; count];
    start.iter().for_each(|&k| is_member[k] = true);
    let mut is_counted = vec![true; count];
    let mut by = DVector::zeros(effects.len());
    let (mut without, mut with) = (Vec::new(), Vec::new());
    for _ in 0..MOST_TURNS {
        let own: Vec<DMatrix<f64>> = effects
            .iter()
            .map(|effect| {
                let mut of_members = effect.clone();
                for k in (0..count).filter(|&k| !is_member[k]) {
                    of_members.row_mut(k).fill(0.0);
                }
                beside.left(&of_members)
            })
            .collect();
        let sum = |a: &DMatrix<f64>, b: &DMatrix<f64>| -> f64 {
            (0..count).filter(|&k| is_counted[k]).map(|k| a.row(k).dot(&b.row(k))).sum()
        };
        let normal = DMatrix::from_fn(own.len(), own.len(), |a, b| sum(&own[a], &own[b]));
        let right = DVector::from_fn(own.len(), |k, _| sum(&own[k], &of_field));
        by = normal.cholesky()?.solve(&right);
        let mut left = of_field.clone();
        for (own, by) in own.iter().zip(by.iter()) {
            left -= own * *by;
        }
        let mut moved = DMatrix::zeros(count, 3);
        for (effect, by) in effects.iter().zip(by.iter()) {
            moved += effect * *by;
        }
        let unmoved = DMatrix::from_fn(count, 3, |i, c| {
            left[(i, c)] + if is_member[i] { moved[(i, c)] } else { 0.0 }
        });
        without = (0..count).map(|k| norm(&unmoved, k)).collect::<Vec<f64>>();
        with = (0..count).map(|k| (unmoved.row(k) - moved.row(k)).norm()).collect::<Vec<f64>>();
        let nearest: Vec<f64> = (0..count).map(|k| with[k].min(without[k])).collect();
        let noise = median(&mut nearest.clone())?;
        let size = moved.row_iter().map(|row| row.norm()).fold(0.0, f64::max);
        if size < GROUP_RATIO * noise {
            return None;
        }
        let bound = TRIMMED * noise;
        let now: Vec<bool> = (0..count).map(|k| with[k] < without[k]).collect();
        let counted: Vec<bool> = nearest.iter().map(|left| *left <= bound).collect();
        if now == is_member && counted == is_counted {
            break;
        }
        (is_member, is_counted) = (now, counted);
    }
    let sizes: Vec<f64> = (0..count)
        .map(|k| {
            let moved = |sum: Vector3<f64>, (effect, by): (&DMatrix<f64>, &f64)| {
                sum + effect.row(k).transpose() * *by
            };
            effects.iter().zip(by.iter()).fold(Vector3::zeros(), moved).norm()
        })
        .collect();
    let mut found =
        Split { with, without, sizes, left_before: left_without(&of_field)?, is_of_signs: false }
            .group(least, effects.len())?;
    let larger_is_rest = 2 * found.members.len() > count;
    if larger_is_rest {
        found.members = (0..count).filter(|&k| !is_member[k]).collect();
    }
    let by: Vec<f64> = by.iter().map(|by| if larger_is_rest { -by } else { *by }).collect();
    Some(Group { mistake: mistake(&by), ..found })
}

/// What is left of each row without the effect and with it, and the effect's size.
struct Split {
    with: Vec<f64>,
    without: Vec<f64>,
    sizes: Vec<f64>,
    /// What is left of all rows without any group.
    left_before: f64,
    is_of_signs: bool,
}

impl Split {
    /// The rows that the effect explains, where these are most of the rows that differ by about as much.
    fn group(&self, [least, large]: [f64; 2], parameters: usize) -> Option<Group> {
        let Self { with, without, sizes, .. } = self;
        let count = with.len();
        let nearest: Vec<f64> = (0..count).map(|k| with[k].min(without[k])).collect();
        let noise = median(&mut nearest.clone())?;
        let is_deviant = |k: &usize| {
            let size = sizes[*k];
            size > GROUP_RATIO * noise && without[*k] > DEVIANT_PART * size
        };
        let deviants: Vec<usize> = (0..count).filter(is_deviant).collect();
        let members: Vec<usize> =
            deviants.iter().copied().filter(|&k| with[k] < EXPLAINED_PART * sizes[k]).collect();
        let of = |all: &[f64]| median(&mut members.iter().map(|&k| all[k]).collect::<Vec<_>>());
        let (before, after) = (of(without)?, of(with)?);
        let parameters_paid = BY_PARAMETER.powi(parameters as i32);
        let left = trimmed_squares(&nearest)? * parameters_paid / self.left_before;
        let part = members.len() as f64 / deviants.len() as f64;
        let has_one = parameters == 1;
        let better = if has_one || count >= MANY_ROWS { BETTER_OF_MANY } else { BETTER };
        let some = if has_one { SOME_PART_OF_ONE } else { SOME_PART };
        let is_better = count >= LEAST_ROWS && left < better && part > some;
        let is_large = !self.is_of_signs && part > MEMBERS_PART && before > large;
        let is_it = members.len() >= LEAST_GROUP
            && before * members.len() as f64 > least * count as f64
            && before > GROUP_RATIO * after
            && (is_better || is_large);
        is_it.then_some(Group { mistake: Mistake::Exchanged, members, before, after, left })
    }
}

fn left_without(left: &DMatrix<f64>) -> Option<f64> {
    trimmed_squares(&(0..left.nrows()).map(|k| norm(left, k)).collect::<Vec<_>>())
}

/// Sum of the squares without the outliers; the more of these, the more each of the others counts.
fn trimmed_squares(left: &[f64]) -> Option<f64> {
    let bound = TRIMMED * median(&mut left.to_vec())?;
    let counted: Vec<f64> = left.iter().copied().filter(|left| *left <= bound).collect();
    let by_rest = (left.len() as f64 / counted.len() as f64).powi(2);
    Some(counted.iter().map(|left| left.powi(2)).sum::<f64>() * by_rest)
}

/// Rows whose error is the field's with the other sign.
fn exchanged(beside: &Beside, values: &DMatrix<f64>) -> Option<Group> {
    let count = values.nrows();
    let left_before = left_without(&beside.left(values))?;
    let mut best: Option<Group> = None;
    // From all rows where fewer than half are exchanged, and from one half of the table alone.
    for start in [0..count, 0..count / 2, count / 2..count] {
        let mut signs: Vec<f64> =
            (0..count).map(|k| if start.contains(&k) { 1.0 } else { 0.0 }).collect();
        let (mut with, mut without) = (Vec::new(), Vec::new());
        let mut fitted = DMatrix::zeros(count, 3);
        for _ in 0..MOST_TURNS {
            let signed = DMatrix::from_fn(count, 3, |i, c| signs[i] * values[(i, c)]);
            fitted = beside.fitted(&signed);
            without = (0..count).map(|k| (values.row(k) - fitted.row(k)).norm()).collect();
            with = (0..count).map(|k| (values.row(k) + fitted.row(k)).norm()).collect();
            let now: Vec<f64> =
                (0..count).map(|k| if with[k] < without[k] { -1.0 } else { 1.0 }).collect();
            if now == signs {
                break;
            }
            signs = now;
        }
        let sizes = (0..count).map(|k| 2.0 * norm(&fitted, k)).collect();
        if let Some(found) = (Split { with, without, sizes, left_before, is_of_signs: true })
            .group([LEAST_MM, LARGE_MM], 0)
            && best.as_ref().is_none_or(|best| found.left < best.left)
        {
            best = Some(found);
        }
    }
    best
}
