//! How far a study depends on field that the environment's samples do not support: a pass of its
//! own over the trials, done only where it is requested.

use super::figures::{FigureRow, RowOf};
use super::plan::Plan;
use super::run::StudyError;
use super::scenario::{InputTrial, Mode, Scenario};
use crate::body::RigidBody;
use rayon::prelude::*;
use serde::Serialize;
use trackwright_field::{FitValidity, OutsidePolicy};
use trackwright_geometry::pose::Pose;
use trackwright_task::{Cancelled, Task};

/// Trials that are computed together before they are summed up in order.
const BATCH: usize = 4096;

/// What a study's sensors, of tool and CRF, find in the field.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SupportSurvey {
    /// Trials that were looked at: all but those left out of the statistics.
    pub trials: usize,
    /// Trials with a sensor where the samples do not support the field.
    pub unsupported: usize,
    /// Those of them with a sensor where the fit does not determine the field at all, or has no
    /// residual to estimate its noise from. Standard errors leave such sensors out.
    pub undetermined: usize,
    /// Predicted standard error of the field's position at the sensors, RMS length of a vector.
    pub std_error_mm: Spread,
    /// Likewise of its rotation; `None` where orientations were not measured.
    pub std_error_deg: Option<Spread>,
    /// Farthest that a sensor was from the samples; infinite (`null`) where an orientation has none.
    pub greatest_distance_mm: f64,
    /// Poses of sensors that were looked up.
    #[serde(skip)]
    pub evaluations: u64,
}

/// Over all sensors of all trials.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Spread {
    pub rms: f64,
    pub max: f64,
}

/// Why there is no survey.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SurveyError {
    #[error(
        "the environment {0:?} has no model validity; `fit` writes that \
         unless given --no-support, but not at order 0"
    )]
    NoSupport(String),
    #[error(transparent)]
    Study(#[from] StudyError),
}

impl From<Cancelled> for SurveyError {
    fn from(_: Cancelled) -> Self {
        Self::Study(StudyError::Cancelled)
    }
}

/// Whether the model is valid at every sensor of a body.
pub fn is_supported(support: &FitValidity, body: &RigidBody, tracker_from_body: &Pose) -> bool {
    body.sensors.iter().all(|sensor| {
        let axis = sensor.axis_in_body().map(|axis| tracker_from_body.rotation * axis);
        support.is_sensor_valid(&(tracker_from_body * sensor.position_in_body), axis.as_ref())
    })
}

/// Looks up the support of every sensor in every trial of a mode. The CRF is looked up once where
/// it stands still. The result does not depend on the number of threads.
///
/// # Errors
/// An environment without support, or a mode without trials.
pub fn survey(scenario: &Scenario, mode: &Mode, task: &Task) -> Result<SupportSurvey, SurveyError> {
    let environment = &scenario.environment;
    let support = environment
        .fit_validity
        .as_ref()
        .ok_or_else(|| SurveyError::NoSupport(environment.name.clone()))?;
    let looker = Looker::new(scenario, support);
    let plan = Plan::new(scenario, mode)?;
    let mut sum = Looked::default();
    let mut found = SupportSurvey {
        trials: 0,
        unsupported: 0,
        undetermined: 0,
        std_error_mm: Spread::default(),
        std_error_deg: None,
        greatest_distance_mm: 0.0,
        evaluations: looker.crf.map_or(0, |crf| crf.evaluations),
    };
    let all = plan.len();
    for start in (0..all).step_by(BATCH) {
        task.step(start, all)?;
        let trials: Vec<_> = (start..(start + BATCH).min(all))
            .into_par_iter()
            .map(|index| looker.trial(&plan.trial(scenario, index)))
            .collect();
        for (trial, evaluations) in trials {
            found.evaluations += evaluations;
            if scenario.outside == OutsidePolicy::Reject && trial.is_outside {
                continue;
            }
            found.trials += 1;
            found.unsupported += usize::from(trial.is_unsupported);
            found.undetermined += usize::from(trial.is_undetermined);
            sum = sum.with(&trial);
        }
    }
    if found.trials == 0 {
        return Err(StudyError::AllRejected { trials: all }.into());
    }
    let spread = |squares: f64, max: f64| Spread {
        rms: (squares / sum.determined.max(1) as f64).sqrt(),
        max,
    };
    found.std_error_mm = spread(sum.squares_mm2, sum.max_mm);
    found.std_error_deg = sum.has_angles.then(|| {
        let in_rad = spread(sum.squares_rad2, sum.max_rad);
        Spread { rms: in_rad.rms.to_degrees(), max: in_rad.max.to_degrees() }
    });
    found.greatest_distance_mm = sum.distance_mm;
    Ok(found)
}

/// The survey as rows of label, value and unit, to stand below a study's figures.
pub fn support_rows(survey: &SupportSurvey) -> Vec<FigureRow> {
    let row = |label: &str, value: f64, unit| FigureRow {
        of: RowOf::Other,
        label: label.to_owned(),
        value: if value.is_finite() { format!("{value:.4}") } else { "none".to_owned() },
        unit,
    };
    let mut rows = vec![
        row("field std error RMS at the sensors", survey.std_error_mm.rms, "mm"),
        row("field std error max at the sensors", survey.std_error_mm.max, "mm"),
    ];
    if let Some(deg) = &survey.std_error_deg {
        rows.push(row("field angle std error RMS", deg.rms, "°"));
        rows.push(row("field angle std error max", deg.max, "°"));
    }
    rows.push(row("farthest from the samples", survey.greatest_distance_mm, "mm"));
    rows.push(FigureRow::count("trials on poorly supported field", survey.unsupported));
    rows.push(FigureRow::count("trials on undetermined field", survey.undetermined));
    rows
}

/// What sensors found, of one body, one trial or all.
#[derive(Clone, Copy, Debug, Default)]
struct Looked {
    determined: u64,
    squares_mm2: f64,
    max_mm: f64,
    has_angles: bool,
    squares_rad2: f64,
    max_rad: f64,
    distance_mm: f64,
    is_unsupported: bool,
    is_undetermined: bool,
    is_outside: bool,
    evaluations: u64,
}

impl Looked {
    fn with(self, other: &Self) -> Self {
        Self {
            determined: self.determined + other.determined,
            squares_mm2: self.squares_mm2 + other.squares_mm2,
            max_mm: self.max_mm.max(other.max_mm),
            has_angles: self.has_angles || other.has_angles,
            squares_rad2: self.squares_rad2 + other.squares_rad2,
            max_rad: self.max_rad.max(other.max_rad),
            distance_mm: self.distance_mm.max(other.distance_mm),
            is_unsupported: self.is_unsupported || other.is_unsupported,
            is_undetermined: self.is_undetermined || other.is_undetermined,
            is_outside: self.is_outside || other.is_outside,
            evaluations: self.evaluations + other.evaluations,
        }
    }
}

/// Looks up trials; the CRF where it stands is looked up once.
struct Looker<'a> {
    scenario: &'a Scenario,
    support: &'a FitValidity,
    crf: Option<Looked>,
}

impl<'a> Looker<'a> {
    fn new(scenario: &'a Scenario, support: &'a FitValidity) -> Self {
        let mut looker = Self { scenario, support, crf: None };
        let crf = scenario.crf.as_ref();
        looker.crf = crf.map(|crf| looker.body(&crf.body, &crf.tracker_from_crf));
        looker
    }

    /// One trial, and how many look-ups it cost.
    fn trial(&self, trial: &InputTrial) -> (Looked, u64) {
        let InputTrial { tracker_from_crf: moved_crf, crf_from_tool } = *trial;
        let Some(crf) = &self.scenario.crf else {
            let tool = self.body(&self.scenario.tool, &crf_from_tool);
            return (tool, tool.evaluations);
        };
        let tracker_from_crf = moved_crf.unwrap_or(crf.tracker_from_crf);
        let tool = self.body(&self.scenario.tool, &(tracker_from_crf * crf_from_tool));
        match (moved_crf, &self.crf) {
            (None, Some(still)) => (tool.with(still), tool.evaluations),
            _ => {
                let both = tool.with(&self.body(&crf.body, &tracker_from_crf));
                (both, both.evaluations)
            }
        }
    }

    fn body(&self, body: &RigidBody, tracker_from_body: &Pose) -> Looked {
        let model = &self.scenario.environment.model;
        body.sensors.iter().fold(Looked::default(), |sum, sensor| {
            let position = tracker_from_body * sensor.position_in_body;
            let axis = sensor.axis_in_body().map(|axis| tracker_from_body.rotation * axis);
            let at = self.support.at_sensor(&position, axis.as_ref(), self.scenario.outside);
            let angle = at.angle_std_error_rad.unwrap_or(0.0);
            let is_determined = at.position_std_error_mm.is_finite() && angle.is_finite();
            let [mm, rad] = match is_determined {
                true => [at.position_std_error_mm, angle],
                false => [0.0; 2],
            };
            sum.with(&Looked {
                determined: u64::from(is_determined),
                squares_mm2: mm * mm,
                max_mm: mm,
                has_angles: at.angle_std_error_rad.is_some(),
                squares_rad2: rad * rad,
                max_rad: rad,
                distance_mm: at.distance_mm,
                is_unsupported: !at.is_valid,
                is_undetermined: !is_determined,
                is_outside: !model.bounds().contains(&position),
                evaluations: 1,
            })
        })
    }
}
