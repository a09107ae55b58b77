//! Fits a distortion model to samples (4): per direction, as the paper does, or jointly on (8).

use super::batch::Batch;
use super::bernstein::MAX_ORDER;
use super::evaluation::OutsidePolicy;
use super::factored::factor_in;
pub use super::factored::{Decomposed, Factored, Solved, factor};
use super::joint::JointError;
use super::least_squares::NoConvergence;
use super::model::{DistortionModel, ModelError};
use super::rows::TooManySamples;
pub use super::samples::Residuals;
use super::samples::{MapKind, Sample, SampleSet};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::directions::{DirectionSet, Weighting};
use trackwright_task::{Cancelled, Task};

/// Singular values below this part of the largest count as zero by default.
pub const DEFAULT_RCOND: f64 = 1e-10;

/// Part of a fit's time that reducing its samples takes, for progress only.
const FACES_PART: f64 = 0.6;

/// Samples whose residuals are found at a time: enough to fill the lanes of each triangle, and no
/// copy of all samples.
const JUDGED_TOGETHER: usize = 16_384;

/// How the orientations share the samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum FitMethod {
    /// Each basis orientation by itself, over the samples with weight on it, rows scaled by that
    /// weight: the paper's.
    #[default]
    PerDirection,
    /// All orientations at once, on equation (8) itself.
    Joint,
}

/// What to fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitSettings {
    pub order: usize,
    pub directions: DirectionSet,
    pub method: FitMethod,
    pub map: MapKind,
    pub weighting: Weighting,
    pub ridge: f64,
    pub rcond: f64,
}

impl FitSettings {
    /// The paper's method for an order and a set, without ridge.
    pub fn new(order: usize, directions: DirectionSet) -> Self {
        Self {
            order,
            directions,
            method: FitMethod::default(),
            map: MapKind::Distortion,
            weighting: Weighting::default(),
            ridge: 0.0,
            rcond: DEFAULT_RCOND,
        }
    }

    /// Of kinds of models that have neither order nor orientations.
    pub fn without_polynomials(map: MapKind) -> Self {
        Self { map, ..Self::new(0, DirectionSet::One) }
    }
}

/// A fitted model, and everything that describes its fit quality.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    pub model: DistortionModel,
    pub samples: usize,
    pub before: Residuals,
    pub after: Residuals,
    /// One an orientation, or one for a joint fit; none at order 0.
    pub systems: Vec<SystemReport>,
    /// Samples with opposite axes.
    pub ambiguous: usize,
}

/// One least-squares system of a fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SystemReport {
    pub samples: usize,
    pub unknowns: usize,
    pub rank: usize,
    /// Largest singular value over the smallest kept; 0 where nothing was kept.
    pub condition: f64,
}

impl SystemReport {
    /// Whether there are fewer samples than unknowns.
    pub fn is_underdetermined(&self) -> bool {
        self.samples < self.unknowns
    }
}

/// Why samples cannot be fitted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FitError {
    #[error("no samples to fit")]
    NoSamples,
    #[error("sample {0} (counted from 0) has a number that is not finite, or an axis of no length")]
    NotFinite(usize),
    #[error("order is {0}, expected 0 to {MAX_ORDER}")]
    Order(usize),
    #[error(
        "the samples have no orientations, so {0} basis orientations cannot be fitted, expected 1"
    )]
    NeedsOneDirection(usize),
    #[error("ridge is {0}, expected a finite number of zero or more")]
    Ridge(f64),
    #[error("rcond is {0}, expected a number from 0 to below 1")]
    Rcond(f64),
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    #[error(transparent)]
    NoConvergence(#[from] NoConvergence),
    #[error(transparent)]
    TooManySamples(#[from] TooManySamples),
    #[error(transparent)]
    Model(#[from] ModelError),
}

impl From<JointError> for FitError {
    fn from(error: JointError) -> Self {
        match error {
            JointError::Cancelled(cause) => cause.into(),
            JointError::NoConvergence(cause) => cause.into(),
        }
    }
}

/// [`fit_with`] for a fit that nobody waits for.
pub fn fit(
    set: &SampleSet,
    settings: &FitSettings,
    bounds: Option<Bounds>,
) -> Result<Fit, FitError> {
    fit_with(set, settings, bounds, &Task::default())
}

/// Fits a model in the samples' bounding box, or in `bounds` where given. The result does not
/// depend on the number of threads.
///
/// # Errors
/// See [`FitError`]. Too few samples are no error: the solution of least norm is given, and
/// [`Fit::systems`] shows it.
pub fn fit_with(
    set: &SampleSet,
    settings: &FitSettings,
    bounds: Option<Bounds>,
    task: &Task,
) -> Result<Fit, FitError> {
    let bounds = checked_bounds(set, settings, bounds)?;
    let factored = factor_in(bounds, set, settings, &task.subtask(0.0, FACES_PART))?;
    let task = task.subtask(FACES_PART, 1.0);
    let solved = factored.solve_with(settings.rcond, settings.ridge, &task)?;
    Ok(solved.judged(set))
}

/// What a model leaves of one sample's error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Remainder {
    pub position_mm: f64,
    /// Means nothing where orientations were not measured.
    pub angle_rad: f64,
}

/// What a model leaves of the samples' errors.
pub fn residuals(model: &DistortionModel, set: &SampleSet, outside: OutsidePolicy) -> Residuals {
    let (mut position, mut angle) = (0.0, 0.0);
    each_remainder(model, set, outside, |position_mm, rotation_rad| {
        position += position_mm.norm_squared();
        angle += rotation_rad.norm_squared();
    });
    let n = set.samples.len() as f64;
    Residuals {
        position_rms_mm: (position / n).sqrt(),
        angle_rms_rad: set.has_rotations.then(|| (angle / n).sqrt()),
    }
}

/// What a model leaves of each sample's error.
pub fn remainders(
    model: &DistortionModel,
    set: &SampleSet,
    outside: OutsidePolicy,
) -> Vec<Remainder> {
    let mut remainders = Vec::with_capacity(set.samples.len());
    each_remainder(model, set, outside, |position_mm, rotation_rad| {
        remainders
            .push(Remainder { position_mm: position_mm.norm(), angle_rad: rotation_rad.norm() });
    });
    remainders
}

/// Calls with what is left of each sample's position and rotation, in order.
fn each_remainder(
    model: &DistortionModel,
    set: &SampleSet,
    outside: OutsidePolicy,
    mut left: impl FnMut(Vector3<f64>, Vector3<f64>),
) {
    let (mut batch, mut evaluations) = (Batch::default(), Vec::new());
    for samples in set.samples.chunks(JUDGED_TOGETHER) {
        let points: Vec<_> = samples.iter().map(Sample::point).collect();
        batch.evaluate_points(model, &points, outside, &mut evaluations);
        for (s, e) in samples.iter().zip(&evaluations) {
            left(
                s.error.position_mm - e.error.position_mm,
                s.error.rotation_rad - e.error.rotation_rad,
            );
        }
    }
}

pub(super) fn checked_bounds(
    set: &SampleSet,
    settings: &FitSettings,
    bounds: Option<Bounds>,
) -> Result<Bounds, FitError> {
    check(set, settings)?;
    bounds
        .or_else(|| Bounds::around(set.samples.iter().map(|s| s.position_mm)))
        .ok_or(FitError::NoSamples)
}

fn check(set: &SampleSet, settings: &FitSettings) -> Result<(), FitError> {
    if set.samples.is_empty() {
        return Err(FitError::NoSamples);
    }
    if let Some(i) = set.samples.iter().position(|s| !s.is_usable()) {
        return Err(FitError::NotFinite(i));
    }
    if settings.order > MAX_ORDER {
        return Err(FitError::Order(settings.order));
    }
    if !set.has_rotations && settings.directions != DirectionSet::One {
        return Err(FitError::NeedsOneDirection(settings.directions.len()));
    }
    check_damping(settings.rcond, settings.ridge)
}

pub(crate) fn check_damping(rcond: f64, ridge: f64) -> Result<(), FitError> {
    if !(ridge.is_finite() && ridge >= 0.0) {
        return Err(FitError::Ridge(ridge));
    }
    if !(0.0..1.0).contains(&rcond) {
        return Err(FitError::Rcond(rcond));
    }
    Ok(())
}
