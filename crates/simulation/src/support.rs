//! How far a study depends on field that the environment's samples do not support: a pass of its
//! own over the trials, done only where it is requested.

use super::plan::Plan;
use super::run::StudyError;
use super::scenario::{InputTrial, Mode, Scenario};
use crate::body::RigidBody;
use rayon::prelude::*;
use serde::Serialize;
use trackwright_field::OutsidePolicy;
use trackwright_field::validity::{ModelValidity, SensorPlace};
use trackwright_geometry::pose::Pose;
use trackwright_result::{Section, count, data, number};
use trackwright_task::{Cancelled, Task};

/// Trials that are computed together before they are summed up in order.
const BATCH: usize = 4096;

/// What a study's sensors, of tool and CRF, find in the field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SupportSurvey {
    /// Trials that were looked at: all but those left out of the statistics.
    pub trials: usize,
    /// Trials with a sensor where the samples do not support the field.
    pub unsupported: usize,
    /// Those of them with a sensor where the fit does not determine the field at all, or has no
    /// residual to estimate its noise from. Standard errors leave such sensors out.
    pub undetermined: usize,
    /// Predicted standard error of the field's position at the sensors, RMS length of a vector; of models that
    /// are no polynomials with their misfit.
    pub std_error_mm: Spread,
    /// Likewise of its rotation; `None` where orientations were not measured.
    pub std_error_deg: Option<Spread>,
    /// Farthest that a sensor was from the samples; infinite (`null`) where an orientation has none.
    pub greatest_distance_mm: f64,
    /// Poses of sensors that were looked up.
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
        "the environment {0:?} has no model validity; `fit` writes that unless given --no-support"
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
pub fn is_supported(validity: &ModelValidity, body: &RigidBody, tracker_from_body: &Pose) -> bool {
    let sensors: Vec<_> = sensor_places(body, *tracker_from_body).collect();
    validity.is_supported(&sensors).into_iter().all(|is_supported| is_supported)
}

/// Looks up the support of every sensor in every trial of a mode. The CRF is looked up once where
/// it stands still. The result does not depend on the number of threads.
///
/// # Errors
/// An environment without support, or a mode without trials.
pub fn survey(scenario: &Scenario, mode: &Mode, task: &Task) -> Result<SupportSurvey, SurveyError> {
    let looker = Looker::new(scenario)?;
    let plan = Plan::new(scenario, mode)?;
    let still = looker.still_crf();
    let mut sum = Looked::default();
    let mut found = SupportSurvey {
        trials: 0,
        unsupported: 0,
        undetermined: 0,
        std_error_mm: Spread::default(),
        std_error_deg: None,
        greatest_distance_mm: 0.0,
        evaluations: still.map_or(0, |crf| crf.evaluations),
    };
    let all = plan.len();
    for start in (0..all).step_by(BATCH) {
        task.step(start, all)?;
        let trials: Vec<_> = (start..(start + BATCH).min(all))
            .into_par_iter()
            .map(|index| {
                let trial = plan.trial(scenario, index);
                (trial.tracker_from_crf.is_some(), looker.sensors(&trial))
            })
            .collect();
        let sensors: Vec<SensorPlace> =
            trials.iter().flat_map(|(_, sensors)| sensors).copied().collect();
        let mut looked = looker.looked(&sensors).into_iter();
        for (is_moved, sensors) in &trials {
            let of_trial = looked.by_ref().take(sensors.len());
            let crf = if *is_moved { None } else { still };
            let trial = of_trial.fold(crf.unwrap_or_default(), Looked::with);
            found.evaluations += sensors.len() as u64;
            if scenario.outside == OutsidePolicy::Reject && trial.is_outside {
                continue;
            }
            found.trials += 1;
            found.unsupported += usize::from(trial.is_unsupported);
            found.undetermined += usize::from(trial.is_undetermined);
            sum = sum.with(trial);
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

impl SupportSurvey {
    /// All that was found, to stand below a study's figures.
    pub fn section(&self) -> Section {
        let deg = self.std_error_deg.unwrap_or_default();
        let has_deg = self.std_error_deg.is_some();
        let mm = |key, label, value| number(key, label, value, 4, "mm");
        let angle = |key, label, value| number(key, label, value, 4, "°").shown_if(has_deg);
        Section::of([
            data("trials", self.trials),
            mm("std_error_mm.rms", "field std error RMS at the sensors", self.std_error_mm.rms),
            mm("std_error_mm.max", "field std error max at the sensors", self.std_error_mm.max),
            angle("", "field angle std error RMS", deg.rms),
            angle("", "field angle std error max", deg.max),
            data("std_error_deg", self.std_error_deg),
            mm("greatest_distance_mm", "farthest from the samples", self.greatest_distance_mm),
            count("unsupported", "trials on poorly supported field", self.unsupported),
            count("undetermined", "trials on undetermined field", self.undetermined),
        ])
        .named("support")
    }
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
    /// One sensor with these standard errors.
    fn of(position_mm: f64, angle_rad: Option<f64>) -> Self {
        let angle = angle_rad.unwrap_or(0.0);
        let is_determined = position_mm.is_finite() && angle.is_finite();
        let [mm, rad] = if is_determined { [position_mm, angle] } else { [0.0; 2] };
        Self {
            determined: u64::from(is_determined),
            squares_mm2: mm * mm,
            max_mm: mm,
            has_angles: angle_rad.is_some(),
            squares_rad2: rad * rad,
            max_rad: rad,
            is_undetermined: !is_determined,
            evaluations: 1,
            ..Self::default()
        }
    }

    fn with(self, other: Self) -> Self {
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

/// Looks up sensors.
struct Looker<'a> {
    scenario: &'a Scenario,
    validity: ModelValidity<'a>,
}

impl<'a> Looker<'a> {
    fn new(scenario: &'a Scenario) -> Result<Self, SurveyError> {
        let validity = scenario.environment.model_validity(scenario.outside);
        let no_support = || SurveyError::NoSupport(scenario.environment.name.clone());
        Ok(Self { scenario, validity: validity.ok_or_else(no_support)? })
    }

    /// The CRF where it stands.
    fn still_crf(&self) -> Option<Looked> {
        let crf = self.scenario.crf.as_ref()?;
        let sensors: Vec<_> = sensor_places(&crf.body, crf.tracker_from_crf).collect();
        Some(self.looked(&sensors).into_iter().fold(Looked::default(), Looked::with))
    }

    /// The sensors of a trial; those of a CRF that stands still are not among them.
    fn sensors(&self, trial: &InputTrial) -> Vec<SensorPlace> {
        let InputTrial { tracker_from_crf: moved_crf, crf_from_tool } = *trial;
        let tool = &self.scenario.tool;
        let Some(crf) = &self.scenario.crf else {
            return sensor_places(tool, crf_from_tool).collect();
        };
        let tracker_from_crf = moved_crf.unwrap_or(crf.tracker_from_crf);
        let of_tool = sensor_places(tool, tracker_from_crf * crf_from_tool);
        let of_crf = moved_crf.iter().flat_map(|moved| sensor_places(&crf.body, *moved));
        of_tool.chain(of_crf).collect()
    }

    fn looked(&self, sensors: &[SensorPlace]) -> Vec<Looked> {
        let bounds = self.scenario.environment.model.bounds();
        let found = self.validity.at(sensors);
        let each = sensors.par_iter().zip(found).map(|(sensor, at)| Looked {
            distance_mm: self.validity.distance_mm(sensor),
            is_unsupported: !at.is_supported,
            is_outside: !bounds.contains(&sensor.0),
            ..Looked::of(at.position_error_mm, at.angle_error_rad)
        });
        each.collect()
    }
}

/// Where the sensors of a body are.
pub(crate) fn sensor_places(
    body: &RigidBody,
    tracker_from_body: Pose,
) -> impl Iterator<Item = SensorPlace> {
    body.sensors.iter().map(move |sensor| {
        let axis = sensor.axis_in_body().map(|axis| tracker_from_body.rotation * axis);
        (tracker_from_body * sensor.position_in_body, axis)
    })
}
