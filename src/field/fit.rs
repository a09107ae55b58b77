//! Fits a distortion model to samples (4): per direction, as the paper does, or jointly on (8).

use super::bernstein::{MAX_ORDER, coefficient_count, push_products};
use super::least_squares::{Decomposition, LeastSquares, NoConvergence, Triangle};
use super::model::{Coefficient, DistortionModel, ModelError, OutsidePolicy};
use super::samples::{MapKind, Sample, SampleSet};
use crate::geometry::bounds::Bounds;
use crate::geometry::directions::{DirectionSet, DirectionWeights, Weighting};
use crate::task::{Cancelled, Task};
use nalgebra::Vector3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Singular values below this part of the largest count as zero unless told otherwise.
pub const DEFAULT_RCOND: f64 = 1e-10;

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
}

/// Root mean squares of the errors' norms.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Residuals {
    pub position_rms_mm: f64,
    /// `None` where orientations were not measured.
    pub angle_rms_rad: Option<f64>,
}

/// A fitted model, and everything that says how far to trust it.
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
    Model(#[from] ModelError),
}

/// Samples reduced to what their fit hangs on. Systems over disjoint samples add up, and every
/// ridge and cutoff is solved from here without the samples.
#[derive(Clone, Debug)]
pub struct Factored {
    pub settings: FitSettings,
    pub bounds: Bounds,
    pub samples: usize,
    /// As the method has them; none at order 0.
    parts: Vec<Triangle>,
}

/// [`Factored`] after the singular value decomposition of its systems.
#[derive(Clone, Debug)]
pub struct Decomposed {
    pub settings: FitSettings,
    pub bounds: Bounds,
    /// One an orientation, or one for a joint fit; none at order 0.
    pub systems: Vec<Decomposition>,
}

/// A model and what its systems were like, before it is judged on samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Solved {
    pub model: DistortionModel,
    /// One an orientation, or one for a joint fit; none at order 0.
    pub systems: Vec<SystemReport>,
}

/// [`fit_with`] for a fit that nobody waits for.
///
/// # Errors
/// See [`FitError`].
pub fn fit(
    set: &SampleSet,
    settings: &FitSettings,
    bounds: Option<Bounds>,
) -> Result<Fit, FitError> {
    fit_with(set, settings, bounds, &Task::default())
}

/// Fits a model in the samples' bounding box, or in `bounds` where given.
///
/// # Errors
/// See [`FitError`]. Too few samples are no error: the solution of least norm is given, and
/// [`Fit::systems`] says so.
pub fn fit_with(
    set: &SampleSet,
    settings: &FitSettings,
    bounds: Option<Bounds>,
    task: &Task,
) -> Result<Fit, FitError> {
    let solved = factor(set, settings, bounds, task)?.solve(settings.rcond, settings.ridge)?;
    Ok(solved.judged(set))
}

/// Reduces samples to their systems, in the samples' bounding box or in `bounds` where given.
/// Ridge and rcond of the settings are not used yet, only checked.
///
/// # Errors
/// See [`FitError`].
pub fn factor(
    set: &SampleSet,
    settings: &FitSettings,
    bounds: Option<Bounds>,
    task: &Task,
) -> Result<Factored, FitError> {
    check(set, settings)?;
    let bounds = bounds
        .or_else(|| Bounds::around(set.samples.iter().map(|s| s.position_mm)))
        .ok_or(FitError::NoSamples)?;
    let parts = if settings.order == 0 {
        Vec::new()
    } else {
        let rows = weighted_rows(&set.samples, settings, &bounds);
        match settings.method {
            FitMethod::PerDirection => factor_each_direction(&rows, settings, task)?,
            FitMethod::Joint => vec![factor_jointly(&rows, settings, task)?],
        }
    };
    Ok(Factored {
        settings: *settings,
        bounds,
        samples: set.samples.len(),
        parts,
    })
}

impl Factored {
    /// The systems of the samples of all parts together, in the order given. The parts must have
    /// the same order, orientations, method, weighting and box; `None` without any, or where they
    /// differ.
    pub fn merged<'a>(parts: impl IntoIterator<Item = &'a Self>) -> Option<Self> {
        let parts: Vec<_> = parts.into_iter().collect();
        let first = *parts.first()?;
        let is_alike = |other: &&Self| {
            let (a, b) = (&first.settings, &other.settings);
            (a.order, a.directions, a.method) == (b.order, b.directions, b.method)
                && (a.weighting, a.map) == (b.weighting, b.map)
                && first.bounds == other.bounds
        };
        parts.iter().all(is_alike).then(|| Self {
            settings: first.settings,
            bounds: first.bounds,
            samples: parts.iter().map(|p| p.samples).sum(),
            parts: (0..first.parts.len())
                .into_par_iter()
                .filter_map(|i| Triangle::merged(parts.iter().map(|p| &p.parts[i])))
                .collect(),
        })
    }

    /// The triangle of each system: one an orientation, or one for a joint fit; none at order 0.
    pub fn systems(&self) -> Vec<Triangle> {
        self.parts.clone()
    }

    /// The singular value decomposition of each system, from which every ridge and cutoff is
    /// cheap. One of a joint fit has as many rows and columns as all orientations together.
    ///
    /// # Errors
    /// [`FitError::NoConvergence`].
    pub fn decompose(&self) -> Result<Decomposed, FitError> {
        let systems = self.systems();
        Ok(Decomposed {
            settings: self.settings,
            bounds: self.bounds,
            systems: systems
                .par_iter()
                .map(Triangle::decompose)
                .collect::<Result<_, _>>()?,
        })
    }

    /// The model for one ridge and cutoff.
    ///
    /// # Errors
    /// [`FitError::NoConvergence`], or a ridge or cutoff that is none.
    pub fn solve(&self, rcond: f64, ridge: f64) -> Result<Solved, FitError> {
        self.decompose()?.solve(rcond, ridge)
    }
}

impl Decomposed {
    /// The model for one ridge and cutoff.
    ///
    /// # Errors
    /// A ridge or cutoff that is none.
    pub fn solve(&self, rcond: f64, ridge: f64) -> Result<Solved, FitError> {
        check_damping(rcond, ridge)?;
        let (solutions, systems): (Vec<_>, Vec<_>) = self
            .systems
            .iter()
            .map(|system| {
                let solution = system.solve(rcond, ridge);
                let report = SystemReport {
                    samples: system.rows,
                    unknowns: solution.unknowns.len(),
                    rank: solution.rank,
                    condition: solution.condition,
                };
                (solution.unknowns, report)
            })
            .unzip();
        Ok(Solved {
            model: model(&self.settings, self.bounds, solutions.concat())?,
            systems,
        })
    }
}

impl Solved {
    /// The fit with its residuals on the samples that it was made from.
    pub fn judged(self, set: &SampleSet) -> Fit {
        let zero = DistortionModel::zero(*self.model.bounds(), self.model.map());
        Fit {
            samples: set.samples.len(),
            before: residuals(&zero, set, OutsidePolicy::Clamp),
            after: residuals(&self.model, set, OutsidePolicy::Clamp),
            model: self.model,
            systems: self.systems,
            ambiguous: set.ambiguous,
        }
    }
}

/// What a model leaves of the samples' errors.
pub fn residuals(model: &DistortionModel, set: &SampleSet, outside: OutsidePolicy) -> Residuals {
    let squares = set.samples.iter().fold((0.0, 0.0), |sum, s| {
        let e = model.evaluate(&s.position_mm, &s.axis, outside).error;
        (
            sum.0 + (s.error.position_mm - e.position_mm).norm_squared(),
            sum.1 + (s.error.rotation_rad - e.rotation_rad).norm_squared(),
        )
    });
    let n = set.samples.len() as f64;
    Residuals {
        position_rms_mm: (squares.0 / n).sqrt(),
        angle_rms_rad: set.has_rotations.then(|| (squares.1 / n).sqrt()),
    }
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

fn check_damping(rcond: f64, ridge: f64) -> Result<(), FitError> {
    if !(ridge.is_finite() && ridge >= 0.0) {
        return Err(FitError::Ridge(ridge));
    }
    if !(0.0..1.0).contains(&rcond) {
        return Err(FitError::Rcond(rcond));
    }
    Ok(())
}

fn model(
    settings: &FitSettings,
    bounds: Bounds,
    coefficients: Vec<Coefficient>,
) -> Result<DistortionModel, FitError> {
    if settings.order == 0 {
        return Ok(DistortionModel::zero(bounds, settings.map));
    }
    Ok(DistortionModel::new(
        settings.order,
        settings.directions,
        settings.weighting,
        settings.map,
        bounds,
        coefficients,
    )?)
}

/// A sample as a row wants it.
struct WeightedRow {
    unit_position: Vector3<f64>,
    weights: DirectionWeights,
    values: [f64; 6],
}

fn weighted_rows(samples: &[Sample], settings: &FitSettings, bounds: &Bounds) -> Vec<WeightedRow> {
    samples
        .iter()
        .map(|s| {
            let (p, r) = (s.error.position_mm, s.error.rotation_rad);
            WeightedRow {
                unit_position: bounds.to_unit(&s.position_mm),
                weights: settings.directions.weights(&s.axis, settings.weighting),
                values: [p.x, p.y, p.z, r.x, r.y, r.z],
            }
        })
        .collect()
}

fn factor_each_direction(
    rows: &[WeightedRow],
    settings: &FitSettings,
    task: &Task,
) -> Result<Vec<Triangle>, FitError> {
    let unknowns = coefficient_count(settings.order);
    let (done, all) = (AtomicUsize::new(0), settings.directions.len());
    (0..all)
        .into_par_iter()
        .map(|direction| {
            task.step(done.load(Ordering::Relaxed), all)?;
            let mut system = LeastSquares::new(unknowns);
            for row in rows {
                let w = row.weights.of(direction);
                if w > 0.0 {
                    system.push(
                        |out| push_scaled(settings.order, row, w, out),
                        row.values.map(|v| w * v),
                    );
                }
            }
            task.step(done.fetch_add(1, Ordering::Relaxed) + 1, all)?;
            Ok(system.into_triangle())
        })
        .collect()
}

fn factor_jointly(
    rows: &[WeightedRow],
    settings: &FitSettings,
    task: &Task,
) -> Result<Triangle, FitError> {
    let per_direction = coefficient_count(settings.order);
    let unknowns = settings.directions.len() * per_direction;
    let mut system = LeastSquares::new(unknowns);
    for (i, row) in rows.iter().enumerate() {
        let fill = |out: &mut Vec<f64>| {
            let start = out.len();
            out.resize(start + unknowns, 0.0);
            let mut products = Vec::with_capacity(per_direction);
            push_scaled(settings.order, row, 1.0, &mut products);
            for (&direction, &w) in row.weights.directions.iter().zip(&row.weights.weights) {
                let block = &mut out[start + direction * per_direction..][..per_direction];
                for (entry, product) in block.iter_mut().zip(&products) {
                    *entry += w * product;
                }
            }
        };
        system.push(fill, row.values);
        task.step(i + 1, rows.len())?;
    }
    Ok(system.into_triangle())
}

fn push_scaled(order: usize, row: &WeightedRow, weight: f64, out: &mut Vec<f64>) {
    let start = out.len();
    push_products(order, &row.unit_position, out);
    for entry in &mut out[start..] {
        *entry *= weight;
    }
}
