//! Effects that no field has, in the whole of a table: another point or another axis of the sensor on one side, a
//! scale, readings that are late along a path, and a field that changes while it is measured.
//!
//! The field is taken for a polynomial of place and axis, even in the axis: a coil turned round reads the same.
//! What the readings differ by beside it is compared with the sensor's axes, the path's speed and time,
//! robustly; standard errors are by leaving out pieces of the table (delete-a-group jackknife), since what
//! polynomials leave is alike from row to row.

use super::mistake::Mistake;
use super::{Explained, Suspicion};
use crate::lag::LONGEST_STEP;
use crate::robust::median;
use nalgebra::{DMatrix, DVector, Vector3};
use trackwright_field::samples::{
    MapKind, Measurement, MeasurementContent, MeasurementSet, PoseError,
};
use trackwright_geometry::bounds::Bounds;

/// Part of what the sides differ by in the first degree of place that a scale has to explain, and what it moves
/// positions by, RMS: good tables have up to 1.94 mm, those beyond 1.1 mm with a third of it at most.
const SCALE_PART: f64 = 0.6;
const LEAST_SCALED_MM: f64 = 3.0;

/// Offsets and angles of a sensor from which one is reported: good tables have 0.12 mm and 0.1° at most.
const LEAST_OFFSET_MM: f64 = 0.5;
const LEAST_TILT_RAD: f64 = 0.01;

/// Part of a sensor's axes that the field's terms have to leave: within a cone they look alike.
const LEAST_OWN_PART: f64 = 0.1;

/// Pieces of the table, one of which is left out in turn.
const PIECES: usize = 16;

/// Rows for each term of the polynomials.
const ROWS_A_TERM: usize = 4;

/// Standard errors beyond which something is reported: every table is looked at.
const STANDARD_ERRORS: f64 = 5.0;

/// Part of the RMS of what is left beside it from which a lag, or a change of the field, is reported.
const LEAST_PART: f64 = 0.1;

/// A table is a path where the median step is a smaller part of its extent: a lag is a time.
const PATH_STEP: f64 = 0.05;

/// Weight in rows of the prior that each term of the field is nothing: without it the polynomials follow a
/// path that hardly meets itself, and leave nothing to its speed. That of noise of 0.3 mm beside terms of 1 mm.
pub(super) const PRIOR: f64 = 0.1;

/// Part of the time's square that place and axis have to leave: a grid that is measured line by line, or a path,
/// has its time in its places, and what the polynomials miss of the field looks like a change with time.
const LEAST_OWN_PART_OF_TIME: f64 = 0.3;

/// Where more than so many times the median is left of a row, it counts less: of normal errors a seventh is beyond.
const MOST_LEFT: f64 = 1.5;

/// Solutions at most, and the change of that bound at which no more are made.
const MOST_ROUNDS: usize = 50;
const SAME_BOUND: f64 = 1e-3;

/// Terms of place of the second degree and the third, those of the first degree first.
const PLACE_TERMS: usize = 10;
pub(super) const CUBIC_PLACE_TERMS: usize = 20;

/// Terms of the axis, which are even in it: a coil turned round reads the same.
const AXIS_TERMS: usize = 6;

/// Terms of a whole rotation beside them, each with the places of the first degree: a tool's own coils lie
/// beside its origin.
const ROTATION_TERMS: usize = 9;
const LINEAR_PLACE_TERMS: usize = 4;

/// What a unit of an effect moves each row's reading by.
pub(super) type Effect = Vec<Vector3<f64>>;

/// An effect's size, its standard error, and the part of its square that place and axis do not explain.
struct Estimate {
    value: f64,
    standard_error: f64,
    own_part: f64,
}

/// The rows in their order, and the field's terms at each.
#[derive(Clone)]
struct Rows {
    errors: Vec<Vector3<f64>>,
    weights: Vec<f64>,
    terms: Vec<DVector<f64>>,
    /// Of the box of all rows.
    longest_edge_mm: f64,
}

/// Readings of earlier rows, or of later ones; `stride` is how many rows of the table lie between two.
pub(super) fn lag(
    rows: &[Measurement],
    content: MeasurementContent,
    stride: usize,
) -> Option<Suspicion> {
    Rows::of(rows, content)?.lag(rows, stride)
}

/// A field that grows or shrinks, or an origin that moves, from the first row to the last.
pub(super) fn change(rows: &[Measurement], content: MeasurementContent) -> Option<Suspicion> {
    Rows::of(rows, content)?.change()
}

fn place(m: &Measurement) -> Vector3<f64> {
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

fn error(m: &Measurement) -> Vector3<f64> {
    m.tracker_from_measured.translation.vector - place(m)
}

/// Positions that are so many times as far from the origin, where that is nearly all that the sides differ by in
/// the first degree of place.
pub(super) fn scale(rows: &[Measurement]) -> Option<Suspicion> {
    let terms = rows.iter().map(|m| {
        let p = place(m);
        DVector::from_column_slice(&[100.0, p.x, p.y, p.z]) / 100.0
    });
    let all = Rows {
        errors: rows.iter().map(error).collect(),
        weights: vec![1.0; rows.len()],
        terms: terms.collect(),
        longest_edge_mm: 0.0,
    };
    let linear = all.weighted(&[])?.fitted(&[])?;
    let squares = |by: f64| -> f64 {
        rows.iter().zip(&linear).map(|(m, of)| (of - place(m) * by).norm_squared()).sum()
    };
    let of_places: f64 = rows.iter().map(|m| place(m).norm_squared()).sum();
    let by = rows.iter().zip(&linear).map(|(m, of)| of.dot(&place(m))).sum::<f64>() / of_places;
    let part = 1.0 - squares(by) / squares(0.0);
    let moved_mm = by.abs() * (of_places / rows.len() as f64).sqrt();
    let apart = |by: f64| {
        median(&mut rows.iter().map(|m| (error(m) - place(m) * by).norm()).collect::<Vec<_>>())
    };
    let explained = Explained { before: apart(0.0)?, after: apart(by)?, is_certain: false };
    let is_it =
        part > SCALE_PART && moved_mm > LEAST_SCALED_MM && explained.after < explained.before;
    is_it.then_some(Suspicion::Mistake { mistake: Mistake::Scale(1.0 + by), part: None, explained })
}

/// Another point or another axis of the sensor on one side.
pub(super) fn of_sensor(rows: &[Measurement], content: MeasurementContent) -> Option<Suspicion> {
    if content == MeasurementContent::PositionOnly {
        return None;
    }
    let terms = field_terms(rows, content, PLACE_TERMS, false)?;
    let along = |axis: usize| -> Effect {
        rows.iter().map(|m| m.tracker_from_ideal.rotation * Vector3::ith(axis, 1.0)).collect()
    };
    let set = MeasurementSet { measurements: rows.to_vec(), content };
    let errors: Vec<PoseError> =
        set.samples(MapKind::Distortion).samples.iter().map(|sample| sample.error).collect();
    let of = |errors: Effect| Rows {
        errors,
        weights: vec![1.0; rows.len()],
        terms: terms.clone(),
        longest_edge_mm: 0.0,
    };
    let axes = if content == MeasurementContent::SixDof { vec![0, 1, 2] } else { vec![2] };
    let effects: Vec<Effect> = axes.iter().map(|axis| along(*axis)).collect();
    let positions = of(errors.iter().map(|e| e.position_mm).collect());
    let (found, _) = positions.estimates(&effects)?;
    let offset = Vector3::from_fn(|k, _| {
        axes.iter().position(|axis| *axis == k).map_or(0.0, |at| found[at].value)
    });
    let standard_error_mm = found.iter().map(|e| e.standard_error.powi(2)).sum::<f64>().sqrt();
    let own = found.iter().map(|e| e.own_part).fold(1.0, f64::min);
    let apart = |errors: &Effect, effects: &[Effect], by: &[f64]| {
        let each = (0..rows.len()).map(|i| {
            effects.iter().zip(by).fold(errors[i], |left, (of, by)| left - of[i] * *by).norm()
        });
        median(&mut each.collect::<Vec<_>>())
    };
    let explained = |errors: &Effect, effects: &[Effect], found: &[Estimate]| {
        let by: Vec<f64> = found.iter().map(|e| e.value).collect();
        let [before, after] = [apart(errors, effects, &[])?, apart(errors, effects, &by)?];
        Some(Explained { before, after, is_certain: false })
    };
    if offset.norm() > STANDARD_ERRORS * standard_error_mm
        && offset.norm() > LEAST_OFFSET_MM
        && own > LEAST_OWN_PART
    {
        let mistake = Mistake::SensorOffset { offset_mm: offset.into(), standard_error_mm };
        let explained = explained(&positions.errors, &effects, &found)?;
        return Some(Suspicion::Mistake { mistake, part: None, explained });
    }
    let rotations = of(errors.iter().map(|e| e.rotation_rad).collect());
    let effects = [along(0), along(1)];
    let (found, _) = rotations.estimates(&effects)?;
    let angle_rad = found[0].value.hypot(found[1].value);
    let error_rad = found[0].standard_error.hypot(found[1].standard_error);
    if angle_rad > STANDARD_ERRORS * error_rad
        && angle_rad > LEAST_TILT_RAD
        && found.iter().all(|e| e.own_part > LEAST_OWN_PART)
    {
        let explained = explained(&rotations.errors, &effects, &found)?;
        let mistake = Mistake::SensorTilt { angle_rad };
        return Some(Suspicion::Mistake { mistake, part: None, explained });
    }
    None
}

impl Rows {
    fn of(rows: &[Measurement], content: MeasurementContent) -> Option<Self> {
        let terms = field_terms(rows, content, PLACE_TERMS, true)?;
        let axis_terms = if content == MeasurementContent::PositionOnly { 1 } else { AXIS_TERMS };
        // With fewer terms a lag or a change would be what they miss.
        if terms[0].len() < PLACE_TERMS * axis_terms {
            return None;
        }
        let bounds = Bounds::around(rows.iter().map(|m| place(m).into()))?;
        Some(Self {
            errors: rows.iter().map(error).collect(),
            weights: vec![1.0; rows.len()],
            terms,
            longest_edge_mm: bounds.size_mm().max(),
        })
    }

    fn of_rows(&self, rows: &[usize]) -> Self {
        Self {
            errors: rows.iter().map(|&k| self.errors[k]).collect(),
            weights: rows.iter().map(|&k| self.weights[k]).collect(),
            terms: rows.iter().map(|&k| self.terms[k].clone()).collect(),
            ..*self
        }
    }

    /// With the weights of Huber's estimate (Huber, Robust Statistics, 1981, 7.8). Least squares would follow the
    /// rows at which the tracker has another solution, or the field is steep.
    fn weighted(&self, effects: &[Effect]) -> Option<Self> {
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
    fn fitted(&self, effects: &[Effect]) -> Option<Vec<Vector3<f64>>> {
        let solution = Sums::of(self, effects, 0..self.errors.len()).solution()?;
        let row = |(i, terms): (usize, &DVector<f64>)| {
            let of_field = Vector3::from_fn(|c, _| terms.dot(&solution.field.column(c)));
            let of_effects = effects.iter().zip(&solution.values);
            of_effects.fold(of_field, |sum, (effect, value)| sum + effect[i] * *value)
        };
        Some(self.terms.iter().enumerate().map(row).collect())
    }

    fn lag(&self, rows: &[Measurement], stride: usize) -> Option<Suspicion> {
        let last = rows.len() - 1;
        let step = |k: usize| (place(&rows[k + 1]) - place(&rows[k])).norm();
        let typical = median(&mut (0..last).map(step).collect::<Vec<f64>>())?;
        if typical > PATH_STEP * self.longest_edge_mm {
            return None;
        }
        // Where readings are missing the path's speed is not known.
        let goes_on = |k: usize| step(k) <= LONGEST_STEP * typical;
        let known: Vec<usize> = (1..last).filter(|k| goes_on(k - 1) && goes_on(*k)).collect();
        if known.len() < ROWS_A_TERM * self.terms[0].len() {
            return None;
        }
        // Without the row itself: its own jitter is in its error.
        let speed = |k: &usize| (place(&rows[k - 1]) - place(&rows[k + 1])) / 2.0;
        let effects = [known.iter().map(speed).collect()];
        let (found, left_mm) = self.of_rows(&known).estimates(&effects)?;
        let moved_mm = found[0].value.abs() * rms(&effects[0]);
        is_reported(&found[0], moved_mm, left_mm).then(|| Suspicion::Lag {
            rows: found[0].value * stride as f64,
            standard_error: found[0].standard_error * stride as f64,
            moved_mm,
            left_mm,
        })
    }

    fn change(&self) -> Option<Suspicion> {
        let count = self.errors.len();
        let time = |k: usize| 2.0 * k as f64 / (count - 1) as f64 - 1.0;
        let of_field = self.weighted(&[])?.fitted(&[])?;
        let grown = |of_time: fn(f64) -> f64| -> Effect {
            of_field.iter().enumerate().map(|(k, e)| e * of_time(time(k))).collect()
        };
        let moved =
            |axis: usize| -> Effect { (0..count).map(|k| Vector3::ith(axis, time(k))).collect() };
        let curved: fn(f64) -> f64 = |t| 1.5 * t * t - 0.5;
        let mut effects = vec![grown(|t| t), grown(curved)];
        effects.extend((0..3).map(moved));
        let (found, left_mm) = self.estimates(&effects)?;
        // The field times the time is of a higher degree than the terms: the time itself decides.
        if found.last()?.own_part < LEAST_OWN_PART_OF_TIME {
            return None;
        }
        let size_mm = |k: usize| found[k].value.abs() * rms(&effects[k]);
        let largest = (0..found.len()).max_by(|a, b| size_mm(*a).total_cmp(&size_mm(*b)))?;
        is_reported(&found[largest], size_mm(largest), left_mm).then(|| Suspicion::Drift {
            of_field: largest < 2,
            changed_mm: size_mm(largest),
            left_mm,
        })
    }

    /// The effects beside the field, and the RMS of what counts of what is left beside both.
    fn estimates(&self, effects: &[Effect]) -> Option<(Vec<Estimate>, f64)> {
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

fn is_reported(found: &Estimate, size_mm: f64, left_mm: f64) -> bool {
    found.value.abs() > STANDARD_ERRORS * found.standard_error && size_mm > LEAST_PART * left_mm
}

fn rms(vectors: &[Vector3<f64>]) -> f64 {
    (vectors.iter().map(Vector3::norm_squared).sum::<f64>() / vectors.len() as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::UnitQuaternion;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use trackwright_geometry::pose::{Pose, pose_from_parts};

    const ROWS: usize = 1_500;

    /// Where a hand is at a row: some sines.
    fn hand(row: f64) -> Pose {
        let t = row / ROWS as f64;
        let wave = |a: f64, b: f64| (a * t).sin() + 0.4 * (b * t + a).cos();
        let position = Vector3::new(wave(13.0, 51.0), wave(17.0, 37.0), wave(22.0, 43.0)) * 90.0;
        let turn = Vector3::new(wave(11.0, 29.0), wave(19.0, 31.0), 0.3);
        pose_from_parts(position, UnitQuaternion::from_scaled_axis(turn))
    }

    /// A smooth field of 2 mm that no polynomial of the second degree has, and noise of 0.1 mm.
    fn readings(
        ideal: impl Fn(usize) -> Pose,
        read_at: impl Fn(usize) -> Pose,
        gain: impl Fn(f64) -> f64,
    ) -> Vec<Suspicion> {
        let mut random = ChaCha8Rng::seed_from_u64(4);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        let row = |k: usize| {
            let at = read_at(k);
            let (p, n) = (at.translation.vector / 150.0, at.rotation * Vector3::z());
            let field = Vector3::new(p.x.sin() * p.z, n.z * n.x + p.y, (1.0 + p.x * p.y).ln_1p());
            let noise = Vector3::from_fn(|_, _| 0.1 * normal());
            let moved = field * (2.0 * gain(k as f64 / ROWS as f64)) + noise;
            Measurement {
                tracker_from_ideal: ideal(k),
                tracker_from_measured: pose_from_parts(at.translation.vector + moved, at.rotation),
            }
        };
        let rows: Vec<Measurement> = (0..ROWS).map(row).collect();
        let content = MeasurementContent::FiveDof;
        lag(&rows, content, 1).into_iter().chain(change(&rows, content)).collect()
    }

    #[test]
    fn a_lag_is_found_with_its_sign_and_size() {
        for lag in [0.7, 2.0, -1.3] {
            let ideal = |k: usize| hand(k as f64);
            let found = readings(ideal, |k| hand(k as f64 - lag), |_| 1.0);
            let Some(Suspicion::Lag { rows, standard_error, .. }) = found.first() else {
                panic!("{lag}: {found:?}");
            };
            // Within four standard errors, beside what a lag of some rows is not linear in.
            assert!((rows - lag).abs() < 4.0 * standard_error + 0.02, "{lag}: {found:?}");
        }
    }

    #[test]
    fn a_lag_is_found_beside_another_solution() {
        // Some 80 mm off, as where the tracker's equations have two solutions.
        let gain = |t: f64| if (0.2..0.23).contains(&t) { 40.0 } else { 1.0 };
        let found = readings(|k| hand(k as f64), |k| hand(k as f64 - 1.0), gain);
        let [Suspicion::Lag { rows, standard_error, left_mm, .. }] = found[..] else {
            panic!("{found:?}");
        };
        assert!((rows - 1.0).abs() < 4.0 * standard_error && left_mm < 1.0, "{found:?}");
    }

    #[test]
    fn a_table_that_agrees_in_time_has_no_suspicion() {
        let ideal = |k: usize| hand(k as f64);
        assert_eq!(readings(ideal, ideal, |_| 1.0), []);
        // Rows in no order: from one to the next is nothing that a lag could be of.
        let mixed = |k: usize| hand(((k * 739) % ROWS) as f64);
        assert_eq!(readings(mixed, mixed, |_| 1.0), []);
    }

    #[test]
    fn a_field_that_changes_is_reported() {
        let mixed = |k: usize| hand(((k * 739) % ROWS) as f64);
        let found = readings(mixed, mixed, |t| 0.8 + 0.4 * t);
        let [Suspicion::Drift { of_field: true, changed_mm, .. }] = found[..] else {
            panic!("{found:?}");
        };
        // A fifth of 2 mm times the field, over the root of three.
        assert!((0.1..0.4).contains(&changed_mm), "{changed_mm}");
    }
}
