//! What to try in a selection, and why nothing can be chosen.

use crate::bernstein::{MAX_ORDER, coefficient_count};
use crate::fit::{DEFAULT_RCOND, FitError, FitMethod, FitSettings, check_damping};
use crate::least_squares::NoConvergence;
use crate::samples::{MapKind, Sample, SampleSet};
use trackwright_geometry::directions::{DirectionSet, Weighting};
use trackwright_task::Cancelled;

/// Parts that the rows are split into by default.
pub const DEFAULT_FOLDS: usize = 5;

/// Seed of the folds by default.
pub const DEFAULT_SEED: u64 = 1;

/// Ridges that are tried by default: none, then half decades. Below the least nothing
/// changes at condition numbers that occur; the largest halves even what is determined best.
pub const DEFAULT_RIDGES: [f64; 14] = [
    0.0,
    1e-6,
    3.162_277_660_168_379e-6,
    1e-5,
    3.162_277_660_168_379e-5,
    1e-4,
    3.162_277_660_168_379e-4,
    1e-3,
    3.162_277_660_168_379e-3,
    1e-2,
    3.162_277_660_168_379e-2,
    1e-1,
    3.162_277_660_168_379e-1,
    1.0,
];

/// What to try, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct SelectSettings {
    /// Order 0, no correction, is one model whatever the orientations and ridges.
    pub orders: Vec<usize>,
    pub direction_sets: Vec<DirectionSet>,
    pub ridges: Vec<f64>,
    pub folds: usize,
    pub seed: u64,
    pub method: FitMethod,
    pub map: MapKind,
    pub weighting: Weighting,
    pub rcond: f64,
    /// Whether what cannot be chosen is not tried to the end, which takes the most time: models that most of
    /// their orientations have too few places for, and kinds of models that are clearly behind.
    pub only_contenders: bool,
}

impl SelectSettings {
    /// Orders 0 to 6 with every set of orientations that such samples can distinguish.
    pub fn for_samples(set: &SampleSet) -> Self {
        Self {
            orders: (0..=6).collect(),
            direction_sets: if set.has_rotations {
                DirectionSet::ALL.to_vec()
            } else {
                vec![DirectionSet::One]
            },
            ridges: DEFAULT_RIDGES.to_vec(),
            folds: DEFAULT_FOLDS,
            seed: DEFAULT_SEED,
            method: FitMethod::default(),
            map: MapKind::Distortion,
            weighting: Weighting::default(),
            rcond: DEFAULT_RCOND,
            only_contenders: false,
        }
    }

    /// What fits one of the candidates.
    pub fn fit_settings(&self, candidate: &Candidate) -> FitSettings {
        FitSettings {
            order: candidate.order,
            directions: candidate.directions,
            method: self.method,
            map: self.map,
            weighting: self.weighting,
            ridge: candidate.ridge,
            rcond: self.rcond,
        }
    }
}

/// One model that could be fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    pub order: usize,
    pub directions: DirectionSet,
    pub ridge: f64,
}

impl Candidate {
    /// Coefficients of one value: the model's size.
    pub fn coefficients(&self) -> usize {
        match self.order {
            0 => 0,
            order => self.directions.len() * coefficient_count(order),
        }
    }
}

/// Why nothing can be chosen.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SelectError {
    #[error("no samples to choose a model by")]
    NoSamples,
    #[error("folds are {0}, expected at least 2")]
    Folds(usize),
    #[error("found {rows} rows for {folds} folds, expected at least as many rows as folds")]
    FewerRowsThanFolds { rows: usize, folds: usize },
    #[error(
        "found {groups} groups of rows for {folds} folds, expected at least as many groups as folds"
    )]
    FewerGroupsThanFolds { groups: usize, folds: usize },
    #[error("found groups for {found} rows, expected them for {expected}")]
    GroupCount { found: usize, expected: usize },
    #[error("found {0} sensor, expected at least 2 to hold one out")]
    FewSensors(usize),
    #[error("found no {0} to hold out")]
    NothingToHoldOut(&'static str),
    #[error("found no {0} to try, expected at least one")]
    NothingToTry(&'static str),
    #[error("sample {0} is not finite")]
    NotFinite(usize),
    #[error(transparent)]
    NoConvergence(#[from] NoConvergence),
    #[error(transparent)]
    Fit(FitError),
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<FitError> for SelectError {
    fn from(error: FitError) -> Self {
        match error {
            FitError::Cancelled(cancelled) => Self::Cancelled(cancelled),
            FitError::NoConvergence(cause) => Self::NoConvergence(cause),
            other => Self::Fit(other),
        }
    }
}

pub(super) fn check(set: &SampleSet, settings: &SelectSettings) -> Result<(), SelectError> {
    let rows = set.samples.len();
    if rows == 0 {
        return Err(SelectError::NoSamples);
    }
    if settings.folds < 2 {
        return Err(SelectError::Folds(settings.folds));
    }
    if rows < settings.folds {
        return Err(SelectError::FewerRowsThanFolds { rows, folds: settings.folds });
    }
    for (is_empty, what) in [
        (settings.orders.is_empty(), "orders"),
        (settings.direction_sets.is_empty(), "sets of orientations"),
        (settings.ridges.is_empty(), "ridges"),
    ] {
        if is_empty {
            return Err(SelectError::NothingToTry(what));
        }
    }
    if let Some(&order) = settings.orders.iter().find(|&&order| order > MAX_ORDER) {
        return Err(FitError::Order(order).into());
    }
    if !set.has_rotations
        && let Some(sets) = settings.direction_sets.iter().find(|&&sets| sets != DirectionSet::One)
    {
        return Err(FitError::NeedsOneDirection(sets.len()).into());
    }
    for &ridge in &settings.ridges {
        check_damping(settings.rcond, ridge)?;
    }
    let is_finite = |s: &Sample| {
        let values =
            [s.position_mm.coords, s.axis.into_inner(), s.error.position_mm, s.error.rotation_rad];
        values.iter().all(|v| v.iter().all(|x| x.is_finite()))
    };
    match set.samples.iter().position(|s| !is_finite(s)) {
        Some(row) => Err(SelectError::NotFinite(row)),
        None => Ok(()),
    }
}
