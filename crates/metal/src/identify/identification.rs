//! What a table of measurements states about the metal in its room.

use super::found_body::{BodyDoubt, FoundBody, found_bodies};
use super::held_out::{Candidate, FoldSolutions, Found, hold_out, is_clearly_more};
use super::noise::{Noise, losses};
use super::rows::Rows;
use super::solve::{Bodies, Solution};
use super::sources::SourceModel;
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
use trackwright_task::{Cancelled, Task};

/// Bodies that are looked for, at most.
pub const MAX_BODIES: usize = 3;

/// Fewest measurements: 80 rows in four folds for the twelve unknowns of three bodies.
pub const MIN_MEASUREMENTS: usize = 20;

/// A part of the disturbance that bodies leave, of which more is no explanation.
pub const MOST_LEFT: f64 = 0.5;

/// Part of the disturbance that bodies leave beyond the noise, of which more is reported as misfit.
pub const MISFIT: f64 = 0.05;

/// Weight of a measurement that is wrong, and the part of the measurements that may be.
const WRONG: f64 = 0.3;
const FEW: f64 = 0.03;

/// A change of the noise that changes no weights to speak of.
const SAME_NOISE: f64 = 0.05;

/// Standard errors of the noise's square, as of normal numbers, up to which what is left is noise: a median
/// has 1.6 of them.
const NOISE_ERRORS: f64 = 6.0;

/// Highest degree of the harmonics that the noise is taken from first.
const NOISE_DEGREE: usize = 6;

/// Degrees of harmonics that a disturbance is seen by where no bodies explain one, and standard errors of the difference
/// of what they and what nothing leaves.
const DISTURBANCE_DEGREE: usize = 3;
const CLEAR_DISTURBANCE: f64 = 3.0;

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
    pub model: SourceModel,
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
    pub(super) without: Vec<Bodies>,
}

impl Identification {
    /// The bodies that are determined.
    pub fn determined(&self) -> impl Iterator<Item = &FoundBody> {
        self.bodies.iter().filter(|body| body.known.is_ok())
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
    let found =
        Found::new(&task.subtask(0.0, 0.2), &rows_mm.over_noise(&first), settings.most, None)?;
    // Bodies may leave less than harmonics of a low degree.
    let best = found.candidates().into_iter().filter_map(|candidate| found.best(candidate));
    let noise = best.fold(first, |noise, best| noise.min(&noise_left(&rows_mm, best)));
    let is_same = |old: f64, new: f64| (new / old - 1.0).abs() < SAME_NOISE;
    let (noise, found) = match is_same(first.position_mm, noise.position_mm)
        && is_same(first.rotation_rad, noise.rotation_rad)
    {
        true => (first, found),
        false => {
            let rows = rows_mm.over_noise(&noise);
            let again = Found::new(&task.subtask(0.2, 0.4), &rows, settings.most, Some(&found))?;
            (noise, again)
        }
    };
    let rows = rows_mm.over_noise(&noise);
    let folds = Folds::of_rows(rows.len(), settings.folds, settings.seed);
    let FoldSolutions { without, mean_losses, chosen } =
        hold_out(&task.subtask(0.4, 1.0), &rows, &folds, &found)?;
    let candidates = found.candidates();
    let Candidate { bodies: count, .. } = candidates[chosen];
    let solutions = found.of(candidates[chosen]).map_or(&[][..], |solutions| solutions);
    let none = &found.compact[0][0];
    let (best, others) = solutions.split_first().unwrap_or((none, &[]));
    let disturbance = noise_left_squares(&rows_mm, none, &noise, 0.0);
    let left = noise_left_squares(&rows_mm, best, &noise, FEW);
    let unexplained = unexplained(&noise, rows.len(), left, disturbance);
    let mut bodies = found_bodies(&rows, best, others, unexplained > MISFIT);
    let is_phantom = |body: &FoundBody| body.doubt().is_some_and(BodyDoubt::is_phantom);
    // What stands for something else makes the others doubtful.
    if bodies.iter().any(is_phantom) {
        bodies.clear();
    }
    let verdict = match count {
        0 if is_disturbed(task, generator, set, &rows, &folds)? => Verdict::NotCompact,
        0 => Verdict::NothingFound,
        _ if unexplained > MOST_LEFT || bodies.is_empty() => Verdict::NotCompact,
        _ if bodies.iter().all(|body| body.known.is_err()) => Verdict::CannotTell,
        _ => Verdict::Found,
    };
    let tried = |(candidate, loss): (&Candidate, &f64)| Tried {
        bodies: candidate.bodies,
        model: found.best(*candidate).map_or(SourceModel::Dipoles, |best| best.model),
        held_out_loss: *loss,
        left: found.best(*candidate).map_or(f64::NAN, |best| best.variance(rows.dof).sqrt()),
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
        tried: candidates.iter().zip(&mean_losses).map(tried).collect(),
        without: without.into_iter().map(|mut fold| fold.swap_remove(chosen)).collect(),
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

/// Whether harmonics of a low degree explain rows held out better than nothing does.
pub(super) fn is_disturbed(
    task: &Task,
    generator: &Generator,
    set: &MeasurementSet,
    rows: &Rows,
    folds: &Folds,
) -> Result<bool, IdentifyError> {
    let quiet = Task::cancelled_by(task.cancel.clone());
    let harmonics = HarmonicRows::new(&quiet, generator, set, DISTURBANCE_DEGREE)?;
    let zero = losses(rows, &rows.right);
    for degree in 1..=DISTURBANCE_DEGREE {
        let mut held_out = vec![0.0; rows.len()];
        for out in &folds.rows {
            let rest: Vec<usize> =
                (0..rows.len()).filter(|m| out.binary_search(m).is_err()).collect();
            let fitted = harmonics.fit(&quiet, Some(&rest), &HarmonicFitSettings::new(degree))?;
            let out_rows = rows.some(out);
            let explained = out_rows.explained(|p, fields| {
                fitted.model.disturbance(p, fields);
                true
            });
            let left = explained.map_or_else(|| out_rows.right.clone(), |e| out_rows.left(&e));
            for (m, loss) in out.iter().zip(losses(&out_rows, &left)) {
                held_out[*m] = loss;
            }
        }
        if is_clearly_more(&zero, &held_out, CLEAR_DISTURBANCE) {
            return Ok(true);
        }
    }
    Ok(false)
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
    let explained = solution.bodies().explained(rows_mm);
    explained.map_or_else(|| rows_mm.right.clone(), |e| rows_mm.left(&e))
}

fn noise_left(rows_mm: &Rows, solution: &Solution) -> Noise {
    Noise::of(&left_mm(rows_mm, solution), rows_mm.dof, solution.unknowns)
}

/// Mean squares of position and rotation that are left beyond the noise, weighted as in the solution; without those that
/// are wrong, where they are a part of at most `few`.
fn noise_left_squares(rows_mm: &Rows, solution: &Solution, noise: &Noise, few: f64) -> [f64; 2] {
    let left = left_mm(rows_mm, solution);
    let wrong = solution.weights.iter().filter(|weight| **weight < WRONG).count();
    let least = if wrong as f64 <= few * rows_mm.len() as f64 { WRONG } else { 0.0 };
    let weights =
        || solution.weights.iter().map(|weight| if *weight < least { 0.0 } else { *weight });
    let mut squares = [0.0; 2];
    for (r, weight) in left.chunks_exact(rows_mm.dof).zip(weights()) {
        let (position, rotation) = r.split_at(super::rows::POSITION_ROWS);
        for (sum, values) in squares.iter_mut().zip([position, rotation]) {
            *sum += weight * values.iter().map(|v| v * v).sum::<f64>();
        }
    }
    let lever = trackwright_field::generator::reading::LEVER_MM;
    let rotations = (rows_mm.dof - super::rows::POSITION_ROWS) as f64;
    let of_noise = [3.0 * noise.position_mm.powi(2), rotations * noise.rotation_rad.powi(2)];
    let weights: f64 = weights().sum();
    let means = [squares[0] / weights, squares[1] / weights / (lever * lever)];
    [0, 1].map(|k| (means[k] - of_noise[k]).max(0.0))
}
