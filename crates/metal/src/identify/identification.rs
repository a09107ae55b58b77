//! What a table of measurements states about the metal in its room.

use super::held_out::{FoldSolutions, hold_out};
use super::noise::Noise;
use super::rows::Rows;
use super::search::search;
use super::solve::Solution;
use super::sources::{OF_BODY, Source, SourceModel, radius_mm};
use nalgebra::{Matrix3, Point3};
use serde::Serialize;
use trackwright_field::generator::reading::ReadingError;
use trackwright_field::generator::{Generator, GeneratorError};
use trackwright_field::harmonic::fit::check;
use trackwright_field::harmonic::rows::SolveError;
use trackwright_field::harmonic::solid_harmonics::terms;
use trackwright_field::harmonic::{HarmonicFitError, HarmonicFitSettings, HarmonicRows};
use trackwright_field::samples::{Measurement, MeasurementSet};
use trackwright_field::selection::folds::Folds;
use trackwright_field::selection::{DEFAULT_FOLDS, DEFAULT_SEED};
use trackwright_geometry::bounds::Bounds;
use trackwright_task::{Cancelled, Task};

/// Bodies that are looked for, at most.
pub const MAX_BODIES: usize = 3;

/// Fewest measurements: 80 rows in four folds for the twelve unknowns of three bodies.
pub const MIN_MEASUREMENTS: usize = 20;

/// Of a normal distribution, 95 % are within so many standard deviations.
const WITHIN_95: f64 = 1.959_964;

/// A strength that is not so many standard deviations from zero may be noise. The search takes the best
/// of some hundred independent places, whose largest by chance is 3 to 4.
pub const CLEAR_STRENGTH: f64 = 5.0;

/// A position is determined where its interval's half length, along its worst axis, is no more than this
/// part of the distance from the middle of the measurements, or of half the diagonal of their box where the
/// body is nearer than that.
pub const POSITION_LIMIT: f64 = 0.2;

/// Other bodies that explain the rows by less than this worse, in squares of noise, may be the true ones:
/// what 95 % of a χ² of four degrees of freedom are within.
const AS_GOOD: f64 = 9.49;

/// A part of the disturbance that bodies leave, of which more is no explanation.
pub const MOST_LEFT: f64 = 0.5;

/// Part of the disturbance that bodies leave beyond the noise, of which more is reported as misfit.
pub const MISFIT: f64 = 0.1;

/// A change of the noise that changes no weights to speak of.
const SAME_NOISE: f64 = 0.05;

/// Standard errors of the noise's square, as of normal numbers, up to which what is left is noise: a median
/// has 1.6 of them.
const NOISE_ERRORS: f64 = 6.0;

/// Highest degree of the harmonics that the noise is taken from first.
const NOISE_DEGREE: usize = 4;

/// Rows for each coefficient of those harmonics, at least.
const ROWS_A_COEFFICIENT: usize = 3;

/// What to look for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IdentifySettings {
    /// Bodies at most, 1 to [`MAX_BODIES`].
    pub most: usize,
    pub folds: usize,
    /// Of the random folds.
    pub seed: u64,
}

impl Default for IdentifySettings {
    fn default() -> Self {
        Self { most: MAX_BODIES, folds: DEFAULT_FOLDS, seed: DEFAULT_SEED }
    }
}

/// 95 % of repeated measurements give an interval with the true value in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    pub low: f64,
    pub high: f64,
}

impl Interval {
    pub fn contains(&self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }

    pub fn half_length(&self) -> f64 {
        0.5 * (self.high - self.low)
    }
}

/// What a body does to a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MetalKind {
    /// Eddy currents keep the field out: the strength is below zero.
    Conductor,
    /// Magnetisation draws the field in: the strength is above zero.
    Ferromagnetic,
}

/// Why a body is not determined.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum BodyDoubt {
    #[error(
        "its strength is {deviations:.1} standard deviations from zero, expected {CLEAR_STRENGTH}"
    )]
    Strength { deviations: f64 },
    #[error("its position is known to ±{half_length_mm:.0} mm only, expected ±{limit_mm:.0} mm")]
    Position { half_length_mm: f64, limit_mm: f64 },
    #[error(
        "it may as well be at ({:.0}, {:.0}, {:.0}) mm", other_mm.x, other_mm.y, other_mm.z
    )]
    Elsewhere { other_mm: Point3<f64> },
    #[error("the measurements do not determine it")]
    NotDetermined,
}

/// A body that explains a part of the disturbance.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundBody {
    pub source: Source,
    pub kind: MetalKind,
    /// Covariance of the middle in the tracker frame.
    pub center_cov_mm2: Matrix3<f64>,
    /// 95 % intervals of x, y and z.
    pub center_mm: [Interval; 3],
    /// Half length of the 95 % interval along the axis of which least is known.
    pub half_length_mm: f64,
    pub strength_mm3: Interval,
    /// Of the equivalent sphere, see [`Source::radius_mm`].
    pub radius_mm: Interval,
    /// From the middle to the nearest true position measured.
    pub nearest_mm: f64,
    /// `None` where it is determined.
    pub doubt: Option<BodyDoubt>,
}

/// What is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// At least one body is determined.
    Found,
    /// No bodies explain measurements held out better than none.
    NothingFound,
    /// There is a disturbance, and none of the bodies that explain it is determined.
    CannotTell,
    /// There is a disturbance that up to so many compact bodies do not explain.
    NotCompact,
}

/// How a number of bodies did.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Tried {
    pub bodies: usize,
    /// Mean loss of a row held out, in squares of noise: 1 where only noise is left.
    pub held_out_loss: f64,
    /// Standard deviation of what is left of all rows, relative to the noise.
    pub left: f64,
}

/// The metal that explains a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Identification {
    pub verdict: Verdict,
    /// By strength, the strongest first; those that are not determined among them.
    pub bodies: Vec<FoundBody>,
    /// What the bodies are modelled as: whichever explains more.
    pub model: SourceModel,
    pub measurements: usize,
    /// Measurements that count for less, since they contradict the others.
    pub down_weighted: usize,
    pub noise: Noise,
    /// RMS of what metal adds to position and rotation, noise taken out.
    pub disturbance: Noise,
    /// Part of the disturbance that the bodies leave, noise taken out.
    pub unexplained: f64,
    /// For none to [`IdentifySettings::most`] bodies.
    pub tried: Vec<Tried>,
    /// Bodies found without each fold, of the number found with all, for [`super::compare`].
    pub(super) without: Vec<(SourceModel, Vec<Source>)>,
}

impl Identification {
    /// The bodies that are determined.
    pub fn determined(&self) -> impl Iterator<Item = &FoundBody> {
        self.bodies.iter().filter(|body| body.doubt.is_none())
    }

    /// Whether the bodies leave more than noise, so that their intervals are too short.
    pub fn is_misfit(&self) -> bool {
        self.unexplained > MISFIT
    }
}

/// Why nothing can be looked for.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum IdentifyError {
    #[error("{0} bodies requested, expected 1 to {MAX_BODIES}")]
    Bodies(usize),
    #[error("folds are {0}, expected 2 up to the number of measurements")]
    Folds(usize),
    #[error("{0} measurements, expected at least {MIN_MEASUREMENTS}")]
    TooFew(usize),
    #[error(
        "the measurements have no orientations; the fields that a sensor measures depend on its axis"
    )]
    PositionOnly,
    #[error("measurement {0} (counted from 0) has a number that is not finite")]
    NotFinite(usize),
    #[error("measurement {measurement} (counted from 0): {cause}")]
    Reading { measurement: usize, cause: ReadingError },
    #[error("the measured poses are the true ones: there is no disturbance and no noise")]
    NoErrors,
    #[error(transparent)]
    Generator(#[from] GeneratorError),
    #[error(transparent)]
    Harmonic(HarmonicFitError),
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<HarmonicFitError> for IdentifyError {
    fn from(error: HarmonicFitError) -> Self {
        match error {
            HarmonicFitError::PositionOnly => Self::PositionOnly,
            HarmonicFitError::NoMeasurements => Self::TooFew(0),
            HarmonicFitError::NotFinite(index) => Self::NotFinite(index),
            HarmonicFitError::Reading { measurement, cause } => {
                Self::Reading { measurement, cause }
            }
            HarmonicFitError::Generator(error) => Self::Generator(error),
            HarmonicFitError::Cancelled(cancelled) => Self::Cancelled(cancelled),
            other => Self::Harmonic(other),
        }
    }
}

/// Finds the bodies that explain measurements in a room which has no other metal, and how well they are
/// determined.
///
/// Noise is that of the measured poses, the same in all measurements; a few that are wrong count for
/// less. The generator is the tracker's, exactly.
///
/// # Errors
/// See [`IdentifyError`].
pub fn identify(
    task: &Task,
    generator: &Generator,
    set: &MeasurementSet,
    settings: &IdentifySettings,
) -> Result<Identification, IdentifyError> {
    check_all(generator, set, settings)?;
    let rows_mm = Rows::new(task, generator, set).map_err(of_solve)?;
    let first = noise_of_harmonics(task, generator, set, &rows_mm)?;
    let found = search(&task.subtask(0.0, 0.2), &rows_mm.over_noise(&first), settings.most, &[])?;
    // Bodies may leave less than harmonics of a low degree.
    let best = found.iter().filter_map(|solutions| solutions.first());
    let least = best.min_by(|a, b| a.loss.total_cmp(&b.loss));
    let noise = least.map_or(first, |solution| first.min(&noise_left(&rows_mm, solution)));
    let is_same = |old: f64, new: f64| (new / old - 1.0).abs() < SAME_NOISE;
    let (noise, found) = match is_same(first.position_mm, noise.position_mm)
        && is_same(first.rotation_rad, noise.rotation_rad)
    {
        true => (first, found),
        false => {
            let rows = rows_mm.over_noise(&noise);
            (noise, search(&task.subtask(0.2, 0.4), &rows, settings.most, &found)?)
        }
    };
    let rows = rows_mm.over_noise(&noise);
    let folds = Folds::of_rows(rows.len(), settings.folds, settings.seed);
    let FoldSolutions { without, mean_losses, bodies: count } =
        hold_out(&task.subtask(0.4, 1.0), &rows, &folds, settings.most, &found)?;
    let count = count.min(found.len() - 1);
    let best = &found[count][0];
    let others = &found[count][1..];
    let bodies = found_bodies(&rows, best, others);
    let disturbance = noise_left_squares(&rows_mm, &found[0][0], &noise);
    let left = noise_left_squares(&rows_mm, best, &noise);
    let unexplained = unexplained(&noise, rows.len(), left, disturbance);
    let verdict = match count {
        0 => Verdict::NothingFound,
        _ if unexplained > MOST_LEFT => Verdict::NotCompact,
        _ if bodies.iter().all(|body| body.doubt.is_some()) => Verdict::CannotTell,
        _ => Verdict::Found,
    };
    let dof = rows.dof;
    let tried = |(bodies, loss): (usize, &f64)| Tried {
        bodies,
        held_out_loss: *loss,
        left: found.get(bodies).map_or(f64::NAN, |s| s[0].variance(dof).sqrt()),
    };
    Ok(Identification {
        verdict,
        bodies,
        model: best.model,
        measurements: rows.len(),
        down_weighted: best.weights.iter().filter(|w| **w < 1.0).count(),
        noise,
        disturbance: Noise {
            position_mm: disturbance[0].sqrt(),
            rotation_rad: disturbance[1].sqrt(),
        },
        unexplained,
        tried: mean_losses.iter().enumerate().take(found.len()).map(tried).collect(),
        without: without.into_iter().map(|mut fold| fold.swap_remove(count)).collect(),
    })
}

fn check_all(
    generator: &Generator,
    set: &MeasurementSet,
    settings: &IdentifySettings,
) -> Result<(), IdentifyError> {
    let count = set.measurements.len();
    if !(1..=MAX_BODIES).contains(&settings.most) {
        return Err(IdentifyError::Bodies(settings.most));
    }
    if let Some(problem) = generator.problem() {
        return Err(problem.into());
    }
    check(set)?;
    if count < MIN_MEASUREMENTS {
        return Err(IdentifyError::TooFew(count));
    }
    if !(2..=count).contains(&settings.folds) {
        return Err(IdentifyError::Folds(settings.folds));
    }
    let is_exact = |m: &Measurement| m.tracker_from_ideal == m.tracker_from_measured;
    // Noise is taken from medians.
    if set.measurements.iter().filter(|m| is_exact(m)).count() > count / 2 {
        return Err(IdentifyError::NoErrors);
    }
    Ok(())
}

fn of_solve(error: SolveError) -> IdentifyError {
    match error {
        SolveError::Reading { measurement, cause } => IdentifyError::Reading { measurement, cause },
        SolveError::Cancelled => IdentifyError::Cancelled(Cancelled),
        // Rows alone are always determined.
        SolveError::NotDetermined => IdentifyError::TooFew(0),
    }
}

/// What harmonics of a degree that the rows determine leave.
fn noise_of_harmonics(
    task: &Task,
    generator: &Generator,
    set: &MeasurementSet,
    rows_mm: &Rows,
) -> Result<Noise, IdentifyError> {
    let quiet = Task::cancelled_by(task.cancel.clone());
    let coefficients = |degree: usize| generator.coils.len() * terms(degree);
    let is_determined =
        |degree: &usize| ROWS_A_COEFFICIENT * coefficients(*degree) <= rows_mm.right.len();
    let Some(degree) = (1..=NOISE_DEGREE).rev().find(is_determined) else {
        return Ok(Noise::of(&rows_mm.right, rows_mm.dof, 0.0));
    };
    let fitted = HarmonicRows::new(&quiet, generator, set, degree)?.fit(
        &quiet,
        None,
        &HarmonicFitSettings::new(degree),
    )?;
    let explained = rows_mm.explained(|p, fields| {
        fitted.model.disturbance(p, fields);
        true
    });
    let left = explained.map_or_else(|| rows_mm.right.clone(), |e| rows_mm.left(&e));
    Ok(Noise::of(&left, rows_mm.dof, fitted.effective_parameters))
}

/// The larger part that is left of position and rotation, of mean squares beyond the noise. What the noise
/// is not known to is none.
fn unexplained(noise: &Noise, measurements: usize, left: [f64; 2], all: [f64; 2]) -> f64 {
    let part = |k: usize, noise: f64| {
        let std_error = (2.0 / (3.0 * measurements as f64)).sqrt();
        let unseen = 3.0 * noise * noise * NOISE_ERRORS * std_error;
        if left[k] > unseen && all[k] > 0.0 { (left[k] / all[k]).sqrt().min(1.0) } else { 0.0 }
    };
    part(0, noise.position_mm).max(part(1, noise.rotation_rad))
}

fn left_mm(rows_mm: &Rows, solution: &Solution) -> Vec<f64> {
    let explained = solution.model.explained(rows_mm, &solution.sources);
    explained.map_or_else(|| rows_mm.right.clone(), |e| rows_mm.left(&e))
}

fn noise_left(rows_mm: &Rows, solution: &Solution) -> Noise {
    let unknowns = (OF_BODY * solution.sources.len()) as f64;
    Noise::of(&left_mm(rows_mm, solution), rows_mm.dof, unknowns)
}

/// Mean squares of position and rotation that are left beyond the noise, weighted as in the solution.
fn noise_left_squares(rows_mm: &Rows, solution: &Solution, noise: &Noise) -> [f64; 2] {
    let left = left_mm(rows_mm, solution);
    let weights: f64 = solution.weights.iter().sum();
    let mut squares = [0.0; 2];
    for (r, weight) in left.chunks_exact(rows_mm.dof).zip(&solution.weights) {
        let (position, rotation) = r.split_at(super::rows::POSITION_ROWS);
        for (sum, values) in squares.iter_mut().zip([position, rotation]) {
            *sum += weight * values.iter().map(|v| v * v).sum::<f64>();
        }
    }
    let lever = trackwright_field::generator::reading::LEVER_MM;
    let rotations = (rows_mm.dof - super::rows::POSITION_ROWS) as f64;
    let of_noise = [3.0 * noise.position_mm.powi(2), rotations * noise.rotation_rad.powi(2)];
    let means = [squares[0] / weights, squares[1] / weights / (lever * lever)];
    [0, 1].map(|k| (means[k] - of_noise[k]).max(0.0))
}

/// The bodies of a solution with their intervals, and what makes each doubtful.
pub(super) fn found_bodies(rows: &Rows, best: &Solution, others: &[Solution]) -> Vec<FoundBody> {
    let covariance = best.covariance(rows.dof);
    let bounds = Bounds::around(rows.positions_mm.iter().copied());
    let variance = best.variance(rows.dof).max(1.0);
    let rival = others.iter().find(|other| other.loss - best.loss < AS_GOOD * variance);
    let body = |(k, source): (usize, &Source)| {
        let block = covariance.as_ref().map(|all| all.view((4 * k, 4 * k), (4, 4)).into_owned());
        let cov = match &block {
            Some(block) => block.fixed_view::<3, 3>(0, 0).into_owned(),
            None => Matrix3::from_diagonal_element(f64::INFINITY),
        };
        let log_std_dev = block.as_ref().map_or(f64::INFINITY, |block| block[(3, 3)].sqrt());
        let largest = match &block {
            Some(_) => cov.symmetric_eigenvalues().max(),
            None => f64::INFINITY,
        };
        let half_length_mm = WITHIN_95 * largest.sqrt();
        let (half_mm, middle_mm) =
            bounds.map_or((0.0, source.center_mm), |b| (0.5 * b.diagonal_mm(), b.center_mm()));
        let limit_mm = POSITION_LIMIT * (source.center_mm - middle_mm).norm().max(half_mm);
        let deviations = 1.0 / log_std_dev;
        let other = rival.and_then(|rival| elsewhere(source, half_length_mm, rival));
        let doubt = if block.is_none() {
            Some(BodyDoubt::NotDetermined)
        } else if half_length_mm > limit_mm {
            Some(BodyDoubt::Position { half_length_mm, limit_mm })
        } else if deviations < CLEAR_STRENGTH {
            Some(BodyDoubt::Strength { deviations })
        } else {
            other.map(|other_mm| BodyDoubt::Elsewhere { other_mm })
        };
        let axis = |axis: usize| {
            let half = WITHIN_95 * cov[(axis, axis)].sqrt();
            let middle = source.center_mm[axis];
            Interval { low: middle - half, high: middle + half }
        };
        let factor = (WITHIN_95 * log_std_dev).exp();
        let ends = [source.strength_mm3 / factor, source.strength_mm3 * factor];
        let nearest = rows.positions_mm.iter().map(|p| (p - source.center_mm).norm());
        FoundBody {
            source: *source,
            kind: match source.strength_mm3 < 0.0 {
                true => MetalKind::Conductor,
                false => MetalKind::Ferromagnetic,
            },
            center_cov_mm2: cov,
            center_mm: [0, 1, 2].map(axis),
            half_length_mm,
            strength_mm3: Interval { low: ends[0].min(ends[1]), high: ends[0].max(ends[1]) },
            radius_mm: Interval { low: radius_mm(ends[0]), high: radius_mm(ends[1]) },
            nearest_mm: nearest.fold(f64::INFINITY, f64::min),
            doubt,
        }
    };
    let mut bodies: Vec<FoundBody> = best.sources.iter().enumerate().map(body).collect();
    bodies.sort_by(|a, b| b.source.strength_mm3.abs().total_cmp(&a.source.strength_mm3.abs()));
    bodies
}

/// Where another solution has a body instead, farther than a body's interval.
fn elsewhere(source: &Source, half_length_mm: f64, rival: &Solution) -> Option<Point3<f64>> {
    let distance = |other: &&Source| (other.center_mm - source.center_mm).norm();
    let nearest = rival.sources.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
    (distance(&nearest) > 2.0 * half_length_mm).then_some(nearest.center_mm)
}
