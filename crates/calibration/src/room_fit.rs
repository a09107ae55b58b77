//! A room from measurements: the model, its validity, and its fit quality on held-out
//! measurements.

use super::room_model::{
    HarmonicOrder, HarmonicReport, RoomModel, RoomModelError, fit_harmonic, fit_kriging,
};
use super::room_process::{Refit, room_process};
use super::shared_rows::shared_rows;
use std::sync::Arc;
use trackwright_field::environment::{HoldoutProvenance, Jitter, Provenance};
use trackwright_field::fit::{Fit, FitError, FitSettings, factor, residuals};
use trackwright_field::gaussian::{GaussianError, GaussianField, Registration};
use trackwright_field::model::OutsidePolicy;
use trackwright_field::samples::SampleSet;
use trackwright_field::selection::sensors::SensorSpread;
use trackwright_field::validity::FitValidityError;
use trackwright_field::{DistortionModel, Environment, FitValidity};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::volume::Volume;
use trackwright_task::Task;

/// Part of a fit's time that reducing its samples takes, for progress only.
const FACTORING_PART: f64 = 0.8;

/// What a room is made of.
#[derive(Clone, Copy, Debug)]
pub struct RoomOrder<'a> {
    pub name: &'a str,
    pub table: RoomTable<'a>,
    /// Measurements that are not fitted, to judge the model on.
    pub held_out: Option<RoomTable<'a>>,
    pub model: &'a RoomModel,
    /// Of polynomials; of any model, the map.
    pub settings: FitSettings,
    /// The box of a polynomial model; that of the samples where there is none.
    pub bounds: Option<Bounds>,
    pub volume: Option<Volume>,
    pub jitter: Option<Jitter>,
    /// Whether the room shall keep model validity.
    pub with_support: bool,
    /// What sensors differ by among themselves, where several were measured with.
    pub sensors: Option<SensorSpread>,
    /// How well the reference's frame is known in the tracker's, where that is stated.
    pub registration: Option<RegistrationError>,
}

/// Standard deviations of what the reference's frame is off by: of each component of the place of the
/// measurements' middle, and of each angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegistrationError {
    pub position_mm: f64,
    pub angle_rad: f64,
}

impl RegistrationError {
    fn about(self, measured: &Bounds) -> Registration {
        Registration {
            position_std_mm: self.position_mm,
            angle_std_rad: self.angle_rad,
            center_mm: measured.center_mm().coords.into(),
        }
    }
}

#[derive(Clone, Copy, Debug)]
pub struct RoomTable<'a> {
    pub name: &'a str,
    pub samples: &'a SampleSet,
}

#[derive(Clone, Debug, PartialEq)]
pub struct FittedRoom {
    pub environment: Environment,
    pub fit: Fit,
    /// Why the room has no model validity, where that is too large to keep.
    pub support_left_out: Option<FitValidityError>,
    pub harmonic: Option<HarmonicReport>,
}

/// The stages of work on a room, each with its progress from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RoomStage {
    Fitting,
    FitValidity,
    /// What the measurements leave open of the field.
    Process,
}

#[derive(Debug, thiserror::Error)]
pub enum RoomError {
    #[error(transparent)]
    Fit(#[from] FitError),
    #[error(transparent)]
    FitValidity(FitValidityError),
    #[error(transparent)]
    Model(#[from] RoomModelError),
    #[error(
        "{held_out} shares {shared} of its {rows} rows with {table}, which the model is fitted to; expected other measurements (select holds out rows of one table)"
    )]
    SharedRows { held_out: String, table: String, shared: usize, rows: usize },
}

impl RoomError {
    /// Whether the work was stopped by whoever requested it.
    pub fn is_cancelled(&self) -> bool {
        match self {
            Self::Fit(FitError::Cancelled(_))
            | Self::FitValidity(
                FitValidityError::Cancelled(_) | FitValidityError::Fit(FitError::Cancelled(_)),
            ) => true,
            Self::Model(error) => error.is_cancelled(),
            _ => false,
        }
    }
}

/// Fits a room and judges it; `task_of` gives each stage its task.
pub fn fit_room(
    order: &RoomOrder,
    mut task_of: impl FnMut(RoomStage) -> Task,
) -> Result<FittedRoom, RoomError> {
    let (samples, settings) = (order.table.samples, &order.settings);
    if let Some(held_out) = &order.held_out {
        let shared = shared_rows(samples, held_out.samples);
        if shared > 0 {
            return Err(RoomError::SharedRows {
                held_out: held_out.name.to_owned(),
                table: order.table.name.to_owned(),
                shared,
                rows: held_out.samples.samples.len(),
            });
        }
    }
    let made = match order.model {
        RoomModel::Bernstein { is_symmetric } => polynomials(order, *is_symmetric, &mut task_of)?,
        RoomModel::Kriging => kriging(order, &mut task_of)?,
        RoomModel::Harmonic(harmonic) => harmonics(order, harmonic, &mut task_of)?,
    };
    let fit = made.fit;
    let process = made.process.map(|process| {
        if order.sensors.is_none() && order.registration.is_none() {
            return process;
        }
        Arc::new(GaussianField {
            sensor_variance: order.sensors.as_ref().map(SensorSpread::of_another),
            registration: order.registration.map(|of| of.about(fit.model.bounds())),
            ..GaussianField::clone(&process)
        })
    });
    let environment = Environment {
        name: order.name.to_owned(),
        model: fit.model.clone(),
        volume: order.volume,
        jitter: order.jitter,
        fit_validity: made.fit_validity,
        process,
        metal: None,
        provenance: Some(Provenance {
            data: order.table.name.to_owned(),
            samples: samples.samples.len(),
            method: settings.method,
            ridge: made.harmonic.as_ref().map_or(settings.ridge, |of| of.settings.ridge),
            train_before: fit.before,
            train_after: fit.after,
            holdout: order.held_out.map(|table| judge(&fit.model, table)),
        }),
    };
    Ok(FittedRoom {
        environment,
        fit,
        support_left_out: made.support_left_out,
        harmonic: made.harmonic,
    })
}

struct Made {
    fit: Fit,
    fit_validity: Option<FitValidity>,
    support_left_out: Option<FitValidityError>,
    process: Option<Arc<GaussianField>>,
    harmonic: Option<HarmonicReport>,
}

fn polynomials(
    order: &RoomOrder,
    is_symmetric: bool,
    task_of: &mut impl FnMut(RoomStage) -> Task,
) -> Result<Made, RoomError> {
    let settings = &order.settings;
    let measured = order.table.samples;
    let turned = is_symmetric.then(|| measured.with_turned_axes());
    let samples = turned.as_ref().unwrap_or(measured);
    let fitting = task_of(RoomStage::Fitting);
    let factored = factor(samples, settings, order.bounds, &fitting.subtask(0.0, FACTORING_PART))?;
    let solved = factored.solve_with(
        settings.rcond,
        settings.ridge,
        &fitting.subtask(FACTORING_PART, 1.0),
    )?;
    let fit = solved.judged(samples);
    let (support, support_left_out) = match order.with_support {
        true => kept(FitValidity::of_fit(
            samples,
            &factored,
            &fit.model,
            &task_of(RoomStage::FitValidity),
        ))?,
        false => (None, None),
    };
    let refit = Refit::Polynomials { settings, is_symmetric };
    let process = kept_process(order, &fit, &refit, task_of)?;
    Ok(Made { fit, fit_validity: support, support_left_out, process, harmonic: None })
}

fn kriging(
    order: &RoomOrder,
    task_of: &mut impl FnMut(RoomStage) -> Task,
) -> Result<Made, RoomError> {
    let task = task_of(RoomStage::Process);
    let (fit, process) = fit_kriging(order.table.samples, order.settings.map, &task)?;
    let process = Some(process);
    Ok(Made { fit, fit_validity: None, support_left_out: None, process, harmonic: None })
}

fn harmonics(
    order: &RoomOrder,
    harmonic: &HarmonicOrder,
    task_of: &mut impl FnMut(RoomStage) -> Task,
) -> Result<Made, RoomError> {
    let samples = order.table.samples;
    let fitting = task_of(RoomStage::Fitting);
    let (fit, report, table) = fit_harmonic(samples, harmonic, order.settings.map, &fitting)?;
    let refit = Refit::Harmonic { table: &table, settings: report.settings };
    let process = kept_process(order, &fit, &refit, task_of)?;
    let harmonic = Some(report);
    Ok(Made { fit, fit_validity: None, support_left_out: None, process, harmonic })
}

/// A support that is too large to keep is left out, and this is reported.
fn kept(
    support: Result<FitValidity, FitValidityError>,
) -> Result<(Option<FitValidity>, Option<FitValidityError>), RoomError> {
    match support {
        Ok(support) => Ok((Some(support), None)),
        Err(FitValidityError::NoOrder) => Ok((None, None)),
        Err(
            error @ (FitValidityError::TooLarge { .. } | FitValidityError::TooManyUnknowns { .. }),
        ) => Ok((None, Some(error))),
        Err(error @ (FitValidityError::Cancelled(_) | FitValidityError::Fit(_))) => {
            Err(RoomError::FitValidity(error))
        }
    }
}

/// Measurements that are too few, or all the same, have no process.
fn kept_process(
    order: &RoomOrder,
    fit: &Fit,
    refit: &Refit,
    task_of: &mut impl FnMut(RoomStage) -> Task,
) -> Result<Option<Arc<GaussianField>>, RoomError> {
    if !order.with_support {
        return Ok(None);
    }
    match room_process(order.table.samples, fit, refit, &task_of(RoomStage::Process)) {
        Ok(process) => Ok(Some(Arc::new(process))),
        Err(GaussianError::Cancelled(cancelled)) => Err(FitError::Cancelled(cancelled).into()),
        Err(_) => Ok(None),
    }
}

fn judge(model: &DistortionModel, table: RoomTable) -> HoldoutProvenance {
    let zero = DistortionModel::zero(*model.bounds(), model.map());
    HoldoutProvenance {
        data: table.name.to_owned(),
        samples: table.samples.samples.len(),
        before: residuals(&zero, table.samples, OutsidePolicy::Clamp),
        after: residuals(model, table.samples, OutsidePolicy::Clamp),
    }
}
