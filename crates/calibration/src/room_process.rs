//! The process of a room's field: around the model where held-out rows show that this is better,
//! else by itself.

use super::room_model::{HarmonicTable, RoomModelError, predicted};
use rayon::prelude::*;
use trackwright_field::DistortionModel;
use trackwright_field::batch::Batch;
use trackwright_field::fit::{Fit, FitError, FitSettings, fit_with};
use trackwright_field::gaussian::{GaussianError, GaussianField};
use trackwright_field::harmonic::{HarmonicFitError, HarmonicFitSettings, HarmonicModel};
use trackwright_field::model::OutsidePolicy;
use trackwright_field::samples::{PoseError, Sample, SampleSet};
use trackwright_field::selection::folds::Folds;
use trackwright_field::selection::{DEFAULT_FOLDS, DEFAULT_SEED};
use trackwright_geometry::bounds::Bounds;
use trackwright_task::{Cancelled, Task};

/// A model is the trend where what the process leaves around it is less than this part of what it
/// leaves without: a choice within the noise of both is the simpler one.
const BETTER: f64 = 0.95;

/// Groups of measurements that a harmonic model is fitted without in turn: their differences have as many
/// degrees of freedom less one.
const GROUPS: usize = 8;

/// Pieces of a table, in the order of its rows, that a group has. What changes slowly while a table is
/// measured (drift, lag, a path) is the same within a piece, and not from piece to piece.
const PIECES: usize = 8;

/// Rows an unknown below which a model's residuals are not representative.
const ROWS_AN_UNKNOWN: usize = 3;

/// How a room's model is fitted again to some of its rows.
pub enum Refit<'a> {
    Polynomials { settings: &'a FitSettings, is_symmetric: bool },
    Harmonic { table: &'a HarmonicTable, settings: HarmonicFitSettings },
}

/// Fits the process of a room's field to the samples that its model was fitted to.
///
/// The model's residuals at its own samples are smaller than elsewhere, so that kernel and variance
/// are found from residuals of folds that a model has not seen.
pub fn room_process(
    samples: &SampleSet,
    fit: &Fit,
    refit: &Refit,
    task: &Task,
) -> Result<GaussianField, GaussianError> {
    if let Refit::Harmonic { table, settings } = refit {
        // What a generator's fields leave is small beside the errors, so that it is their trend always.
        let own = trend(&fit.model, samples);
        let refits = refits(samples, table, settings, &task.subtask(0.0, 0.6))?;
        let task = task.subtask(0.6, 1.0);
        let Some(Refits { models, held_out }) = refits else {
            return GaussianField::fit(samples, Some(&own), &task);
        };
        let around = GaussianField::fit(samples, Some(&held_out), &task)?;
        return Ok(GaussianField { refits: models, ..around.with_trend(samples, &own) });
    }
    let alone = GaussianField::fit(samples, None, &task.subtask(0.0, 0.5))?;
    let is_determined = fit.systems.iter().all(|system| {
        system.samples >= ROWS_AN_UNKNOWN * system.unknowns && system.rank == system.unknowns
    });
    if fit.model.is_zero() || !is_determined {
        return Ok(alone);
    }
    let Some(held_out) = held_out(samples, refit, &fit.model, task)? else {
        return Ok(alone);
    };
    let around = GaussianField::fit(samples, Some(&held_out), &task.subtask(0.5, 1.0))?;
    if around.left_out_rms_mm < BETTER * alone.left_out_rms_mm {
        Ok(around.with_trend(samples, &trend(&fit.model, samples)))
    } else {
        Ok(alone)
    }
}

/// What a model gives at the samples' poses.
fn trend(model: &DistortionModel, samples: &SampleSet) -> Vec<PoseError> {
    let points: Vec<_> = samples.samples.iter().map(Sample::point).collect();
    let mut evaluations = Vec::new();
    Batch::default().evaluate_points(model, &points, OutsidePolicy::Clamp, &mut evaluations);
    evaluations.iter().map(|e| e.error).collect()
}

/// What models of the other folds give at each sample; `None` where a fold cannot be fitted.
fn held_out(
    samples: &SampleSet,
    refit: &Refit,
    model: &DistortionModel,
    task: &Task,
) -> Result<Option<Vec<PoseError>>, GaussianError> {
    let rows = samples.samples.len();
    if rows < DEFAULT_FOLDS {
        return Ok(None);
    }
    let folds = Folds::of_rows(rows, DEFAULT_FOLDS, DEFAULT_SEED);
    let mut given = vec![PoseError::default(); rows];
    for out in &folds.rows {
        let rest: Vec<usize> = (0..rows).filter(|i| out.binary_search(i).is_err()).collect();
        let Some(errors) = refit.at(samples, out, &rest, model.bounds(), task)? else {
            return Ok(None);
        };
        for (&i, error) in out.iter().zip(errors) {
            given[i] = error;
        }
    }
    Ok(Some(given))
}

/// The harmonic model without each group of the measurements, and what these models give at the rows of
/// their group.
struct Refits {
    models: Vec<HarmonicModel>,
    held_out: Vec<PoseError>,
}

/// Fits the model without each group; a learned generator is learned again without the group. `None` where one cannot be fitted.
fn refits(
    samples: &SampleSet,
    table: &HarmonicTable,
    settings: &HarmonicFitSettings,
    task: &Task,
) -> Result<Option<Refits>, GaussianError> {
    let rows = samples.samples.len();
    if rows < GROUPS * PIECES {
        return Ok(None);
    }
    let pieces: Vec<usize> = (0..rows).map(|row| row * GROUPS * PIECES / rows).collect();
    let groups = Folds::of_groups(&pieces, GROUPS * PIECES, GROUPS, DEFAULT_SEED);
    let quiet = Task::cancelled_by(task.cancel.clone());
    let without = |out: &Vec<usize>| -> Result<HarmonicModel, RoomModelError> {
        let rest: Vec<usize> = (0..rows).filter(|row| out.binary_search(row).is_err()).collect();
        let fitted = match &table.learned {
            None => table.fit(Some(&rest), settings, &quiet)?,
            Some(learned) => {
                let degree = settings.degree;
                HarmonicTable::learned_again(samples, &rest, learned, degree, &quiet)?.fit(
                    Some(&rest),
                    settings,
                    &quiet,
                )?
            }
        };
        Ok(fitted.model)
    };
    let fitted: Result<Vec<HarmonicModel>, RoomModelError> =
        groups.rows.par_iter().map(without).collect();
    let models = match fitted {
        Ok(models) => models,
        Err(error) if error.is_cancelled() => return Err(Cancelled.into()),
        Err(_) => return Ok(None),
    };
    let mut given = vec![PoseError::default(); rows];
    for (out, model) in groups.rows.iter().zip(&models) {
        for &row in out {
            given[row] = predicted(model, &samples.samples[row]);
        }
    }
    Ok(Some(Refits { models, held_out: given }))
}

impl Refit<'_> {
    /// What a model of some rows gives at others; `None` where it cannot be fitted.
    pub(super) fn at(
        &self,
        samples: &SampleSet,
        out: &[usize],
        rest: &[usize],
        bounds: &Bounds,
        task: &Task,
    ) -> Result<Option<Vec<PoseError>>, GaussianError> {
        let quiet = Task::cancelled_by(task.cancel.clone());
        match *self {
            Self::Polynomials { settings, is_symmetric } => {
                let mut known = samples.of_rows(rest);
                if is_symmetric {
                    known = known.with_turned_axes();
                }
                match fit_with(&known, settings, Some(*bounds), &quiet) {
                    Ok(fitted) => Ok(Some(trend(&fitted.model, &samples.of_rows(out)))),
                    Err(FitError::Cancelled(cancelled)) => Err(cancelled.into()),
                    Err(_) => Ok(None),
                }
            }
            Self::Harmonic { table, settings } => match table.fit(Some(rest), &settings, &quiet) {
                Ok(fitted) => {
                    let each = out.iter().map(|&i| &samples.samples[i]);
                    Ok(Some(each.map(|s| predicted(&fitted.model, s)).collect()))
                }
                Err(HarmonicFitError::Cancelled(cancelled)) => Err(cancelled.into()),
                Err(_) => Ok(None),
            },
        }
    }
}
