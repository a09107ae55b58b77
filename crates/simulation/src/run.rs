//! Runs a study: every trial of a mode on all cores, summed up in the same order each time.

use super::figures::{Figures, FreeAxis, FreeRotation, Worst};
use super::metric::Statistics;
use super::motion::MotionError;
use super::plan::{Plan, each_trial};
use super::requirement::Within;
use super::scenario::{Mode, Scenario};
use super::trial::{Simulator, Trial};
use super::weak_rotation::WeakRotation;
use super::work::Work;
use trackwright_field::OutsidePolicy;
use trackwright_task::CancelToken;

/// Most trials for which a third figure is kept beside the two. Where more need one, a second
/// pass keeps the memory at 16 bytes a trial.
const KEEP_THIRD: usize = 1 << 22;

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
/// Memory is 16 bytes a trial, 24 where a rotation is free and trials are few enough. The result does not depend on the number of threads.
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
    let free = simulator.free_motion();
    let keeps_third = free.is_some() && trials <= KEEP_THIRD;
    let mut determined_mm = Vec::with_capacity(if keeps_third { trials } else { 0 });
    let mut work = simulator.own_work();
    work += each_trial(&plan, &simulator, cancel, |index, trial| {
        if let Some(log) = log.as_deref_mut() {
            log(trial);
        }
        if tally.count(index, trial, scenario.outside) {
            position_mm.push(trial.tip_error_mm);
            angle_deg.push(trial.angle_error_deg);
            if keeps_third {
                determined_mm.extend(trial.determined_mm);
            }
        }
    })?;
    let all_rejected = StudyError::AllRejected { trials };
    let angle_deg = {
        let mut values = angle_deg;
        Statistics::of(&mut values).ok_or(all_rejected.clone())?
    };
    let within = (scenario.requirement.as_ref()).and_then(|r| Within::of(&position_mm, r));
    let position_statistics = Statistics::of(&mut position_mm).ok_or(all_rejected.clone())?;
    let position_mm_determined = match &free {
        None => None,
        Some(_) if keeps_third => Some(Statistics::of(&mut determined_mm).ok_or(all_rejected)?),
        Some(_) => {
            position_mm.clear();
            work += each_trial(&plan, &simulator, cancel, |_, trial| {
                if !is_rejected(trial, scenario.outside) {
                    position_mm.extend(trial.determined_mm);
                }
            })?;
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
            within,
            checks,
            free_axis: free.map(|(body, free)| FreeRotation {
                free: FreeAxis::of(body, free.axis, scenario),
                reach_mm: tally.free_reach_mm,
            }),
            position_mm_determined,
            poorly_determined: simulator.is_poorly_determined(),
            barely_determined: WeakRotation::of(scenario),
        },
        work,
    })
}

pub fn check(scenario: &Scenario) -> Result<(), StudyError> {
    let bodies = [Some(&scenario.tool), scenario.crf.as_ref().map(|c| &c.body)];
    match bodies.into_iter().flatten().find(|b| b.sensors.is_empty()) {
        Some(body) => Err(StudyError::NoSensors { body: body.name.clone() }),
        None => Ok(()),
    }
}

/// Whether a trial is left out of the figures.
pub fn is_rejected(trial: &Trial, outside: OutsidePolicy) -> bool {
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
    free_reach_mm: f64,
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
        self.free_reach_mm = self.free_reach_mm.max(trial.free_reach_mm);
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
