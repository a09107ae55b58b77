//! Runs a study: every trial of a mode on all cores, summed up in the same order each time.

use super::figures::{Figures, FreeAxis, Worst};
use super::motion::{MotionError, MotionGrid};
use super::scenario::{InputTrial, Mode, Scenario};
use super::statistics::Statistics;
use super::trial::{Simulator, Trial};
use super::work::Work;
use crate::field::OutsidePolicy;
use crate::task::CancelToken;
use rayon::prelude::*;
use std::sync::Arc;

/// Trials that are computed together before they are summed up and logged.
const BATCH: usize = 8192;

/// Trials that one core does before it looks whether anyone still wants them: some 0.5 ms.
const CHUNK: usize = 128;

/// A study's figures, and what they cost.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    pub figures: Figures,
    pub work: Work,
}

/// Why a study has no outcome.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StudyError {
    #[error("cancelled")]
    Cancelled,
    #[error("the design has no range of motion")]
    NoMotion,
    #[error(transparent)]
    Motion(#[from] MotionError),
    #[error("no poses to simulate")]
    NoTrials,
    #[error("all {trials} trials were left out: each has a sensor outside the model's box")]
    AllRejected { trials: usize },
    #[error("{body} has no sensors")]
    NoSensors { body: String },
}

/// Simulates every trial of a mode; `log` gets them in order.
///
/// Memory is 16 bytes a trial. The result does not depend on the number of threads.
///
/// # Errors
/// See [`StudyError`].
pub fn run(
    scenario: &Scenario,
    mode: &Mode,
    cancel: &CancelToken,
    mut log: Option<&mut dyn FnMut(&Trial)>,
) -> Result<Outcome, StudyError> {
    check(scenario)?;
    let plan = Plan::new(scenario, mode)?;
    let simulator = Simulator::new(scenario);
    let trials = plan.len();
    let mut tally = Tally::default();
    let mut position_mm = Vec::with_capacity(trials);
    let mut angle_deg = Vec::with_capacity(trials);
    each_trial(&plan, &simulator, cancel, |index, trial| {
        if let Some(log) = log.as_deref_mut() {
            log(trial);
        }
        if tally.count(index, trial, scenario.outside) {
            position_mm.push(trial.tip_error_mm);
            angle_deg.push(trial.angle_error_deg);
        }
    })?;
    let free = simulator.free_motion();
    let all_rejected = StudyError::AllRejected { trials };
    let angle_deg = {
        let mut values = angle_deg;
        Statistics::of(&mut values).ok_or(all_rejected.clone())?
    };
    let position_statistics = Statistics::of(&mut position_mm).ok_or(all_rejected.clone())?;
    let mut work = simulator.own_work() + plan.work(&simulator);
    // A second pass keeps the memory at its bound in the rare case that needs a third figure.
    let position_mm_determined = match &free {
        None => None,
        Some(_) => {
            position_mm.clear();
            each_trial(&plan, &simulator, cancel, |_, trial| {
                if !is_rejected(trial, scenario.outside) {
                    position_mm.extend(trial.determined_mm);
                }
            })?;
            work += plan.work(&simulator);
            Some(Statistics::of(&mut position_mm).ok_or(all_rejected)?)
        }
    };
    let checks = scenario
        .requirement
        .map(|r| r.checks(&position_statistics, &angle_deg))
        .unwrap_or_default();
    Ok(Outcome {
        figures: Figures {
            trials,
            outside: tally.outside,
            out_of_volume: tally.out_of_volume,
            rejected: tally.rejected,
            position_mm: position_statistics,
            angle_deg,
            worst: tally.worst,
            checks,
            free_axis: free.map(|(body, free)| FreeAxis {
                body,
                axis_in_body: free.axis.map(|a| a.into_inner().into()),
            }),
            position_mm_determined,
            poorly_determined: simulator.is_poorly_determined(),
        },
        work,
    })
}

fn check(scenario: &Scenario) -> Result<(), StudyError> {
    let bodies = [Some(&scenario.tool), scenario.crf.as_ref().map(|c| &c.body)];
    match bodies.into_iter().flatten().find(|b| b.sensors.is_empty()) {
        Some(body) => Err(StudyError::NoSensors {
            body: body.name.clone(),
        }),
        None => Ok(()),
    }
}

/// Which trials a mode visits.
enum Plan {
    Single,
    Motion(Box<MotionGrid>),
    Input(Arc<[InputTrial]>),
}

impl Plan {
    fn new(scenario: &Scenario, mode: &Mode) -> Result<Self, StudyError> {
        Ok(match mode {
            Mode::Single => Self::Single,
            Mode::Motion => {
                let motion = scenario.motion.ok_or(StudyError::NoMotion)?;
                Self::Motion(Box::new(motion.grid(&scenario.crf_from_tool)?))
            }
            Mode::Input(trials) if trials.is_empty() => return Err(StudyError::NoTrials),
            Mode::Input(trials) => Self::Input(trials.clone()),
        })
    }

    fn len(&self) -> usize {
        match self {
            Self::Single => 1,
            Self::Motion(grid) => grid.trials(),
            Self::Input(trials) => trials.len(),
        }
    }

    fn trial(&self, simulator: &Simulator, index: usize) -> Trial {
        match self {
            Self::Single => simulator.trial(&simulator.design_crf_from_tool()),
            Self::Motion(grid) => simulator.trial(&grid.pose(index)),
            Self::Input(trials) => {
                let t = &trials[index];
                match &t.tracker_from_crf {
                    Some(crf) => simulator.trial_with_crf_at(crf, &t.crf_from_tool),
                    None => simulator.trial(&t.crf_from_tool),
                }
            }
        }
    }

    fn work(&self, simulator: &Simulator) -> Work {
        let moving_crf = match self {
            Self::Input(trials) => trials
                .iter()
                .filter(|t| t.tracker_from_crf.is_some())
                .count(),
            Self::Single | Self::Motion(_) => 0,
        };
        simulator.trial_work(false) * (self.len() - moving_crf) as u64
            + simulator.trial_work(true) * moving_crf as u64
    }
}

/// Computes batches in parallel and visits their trials in order.
fn each_trial(
    plan: &Plan,
    simulator: &Simulator,
    cancel: &CancelToken,
    mut visit: impl FnMut(usize, &Trial),
) -> Result<(), StudyError> {
    let mut batch = Vec::with_capacity(BATCH.min(plan.len()));
    for start in (0..plan.len()).step_by(BATCH) {
        let end = (start + BATCH).min(plan.len());
        (start..end)
            .into_par_iter()
            .with_min_len(CHUNK)
            .map(|index| (!cancel.is_cancelled()).then(|| plan.trial(simulator, index)))
            .collect_into_vec(&mut batch);
        for (offset, trial) in batch.iter().enumerate() {
            match trial {
                Some(trial) => visit(start + offset, trial),
                None => return Err(StudyError::Cancelled),
            }
        }
    }
    Ok(())
}

fn is_rejected(trial: &Trial, outside: OutsidePolicy) -> bool {
    outside == OutsidePolicy::Reject && trial.outside > 0
}

/// What is counted over all trials.
#[derive(Default)]
struct Tally {
    outside: usize,
    out_of_volume: usize,
    rejected: usize,
    worst: Worst,
    has_worst: bool,
}

impl Tally {
    /// Whether the trial enters the statistics.
    fn count(&mut self, index: usize, trial: &Trial, outside: OutsidePolicy) -> bool {
        self.outside += usize::from(trial.outside > 0);
        self.out_of_volume += usize::from(trial.out_of_volume > 0);
        if is_rejected(trial, outside) {
            self.rejected += 1;
            return false;
        }
        if !self.has_worst || trial.tip_error_mm > self.worst.position_mm {
            self.has_worst = true;
            self.worst = Worst {
                trial: index,
                position_mm: trial.tip_error_mm,
                angle_deg: trial.angle_error_deg,
            };
        }
        true
    }
}
