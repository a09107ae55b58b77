//! Runs a study: every trial of a mode on all cores, summed up in the same order each time.

use super::figures::{FreeAxis, FreeRotation, RoomFieldFigures, Worst};
use super::metric::Statistics;
use super::plan::{Plan, each_trial};
use super::requirement::Within;
use super::scenario::{Mode, Scenario};
use super::tool_in_crf::ErrorVectors;
use super::trial::{Simulator, Trial};
use super::weak_rotation::WeakRotation;
use super::work::Work;
use trackwright_field::OutsidePolicy;
use trackwright_task::CancelToken;

pub use super::study_error::StudyError;

/// Most trials for which a third figure is kept beside the two. Where more need one, a second
/// pass keeps the memory at 16 bytes a trial.
const KEEP_THIRD: usize = 1 << 22;

/// A study by the room's model alone, and what it cost.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    pub room_field: RoomFieldFigures,
    pub work: Work,
}

/// Simulates every trial of a mode; `log` gets them in order.
///
/// Memory is 24 bytes a trial, 32 where a rotation is free and trials are few enough. The result does not depend on the number of threads.
///
/// # Errors
/// See [`StudyError`].
pub fn run(
    scenario: &Scenario,
    mode: &Mode,
    cancel: &CancelToken,
    log: Option<&mut dyn FnMut(&Trial)>,
) -> Result<Outcome, StudyError> {
    Ok(Prepared::new(scenario, mode)?.run(cancel, log)?.0)
}

/// A mode of a scenario made ready to be run.
pub(super) struct Prepared<'a> {
    pub scenario: &'a Scenario,
    /// What is taken out of the errors of trials before they are summed up.
    pub less: Option<&'a Less<'a>>,
    pub mode: &'a Mode,
    pub plan: Plan,
    pub simulator: Simulator<'a>,
}

/// Takes a part out of the errors at trials of these numbers.
pub type Less<'a> = dyn Fn(&[usize], &mut [ErrorVectors]) + Sync + 'a;

/// The errors of the trials of a study by the room's model alone, those that are left out not among them.
#[derive(Default)]
pub(super) struct TrialErrors {
    /// Numbers of the trials, where some are left out.
    numbers: Option<Vec<u32>>,
    /// Tip in mm and angle in degrees.
    pub errors: Vec<[f64; 2]>,
    /// Places of those with a sensor where the room states no field.
    pub without_field: Vec<u32>,
}

impl TrialErrors {
    fn with_capacity(trials: usize) -> Self {
        Self { errors: Vec::with_capacity(trials), ..Self::default() }
    }

    fn push(&mut self, number: usize, error: [f64; 2]) {
        if self.numbers.is_none() && number != self.errors.len() {
            self.numbers = Some((0..self.errors.len() as u32).collect());
        }
        if let Some(numbers) = &mut self.numbers {
            numbers.push(number as u32);
        }
        self.errors.push(error);
    }

    /// Replaces the errors by those of which a part is taken out.
    fn replace(&mut self, vectors: &mut [ErrorVectors], less: &Less) {
        let numbers: Vec<usize> = (0..vectors.len()).map(|place| self.number(place)).collect();
        less(&numbers, vectors);
        self.errors = vectors.iter().map(ErrorVectors::sizes).collect();
    }

    /// Whether no trial was left out.
    pub fn are_all(&self) -> bool {
        self.numbers.is_none()
    }

    /// The number of the trial at a place.
    pub fn number(&self, place: usize) -> usize {
        self.numbers.as_ref().map_or(place, |numbers| numbers[place] as usize)
    }

    /// The values of one component: the tip's, or the angle's.
    pub fn component(&self, k: usize) -> Vec<f64> {
        self.errors.iter().map(|error| error[k]).collect()
    }

    /// Places of the largest values of one component, the largest first; of equal ones the first.
    pub fn largest(&self, component: usize, most: usize) -> Vec<usize> {
        let mut order: Vec<u32> = (0..self.errors.len() as u32).collect();
        let value = |place: &u32| self.errors[*place as usize][component];
        let by_size = |a: &u32, b: &u32| value(b).total_cmp(&value(a)).then(a.cmp(b));
        if most < order.len() {
            order.select_nth_unstable_by(most, by_size);
            order.truncate(most);
        }
        order.sort_unstable_by(by_size);
        order.into_iter().map(|place| place as usize).collect()
    }

    /// The errors at some places.
    pub fn at(&self, places: &[usize]) -> Vec<[f64; 2]> {
        places.iter().map(|&place| self.errors[place]).collect()
    }

    /// Whether the room states its field at the trial of each place.
    pub fn is_known(&self, place: usize) -> bool {
        self.without_field.binary_search(&(place as u32)).is_err()
    }
}

impl<'a> Prepared<'a> {
    /// # Errors
    /// A body without sensors, a mode without trials.
    pub fn new(scenario: &'a Scenario, mode: &'a Mode) -> Result<Self, StudyError> {
        check(scenario)?;
        let plan = Plan::new(scenario, mode)?;
        Ok(Self { scenario, less: None, mode, plan, simulator: Simulator::new(scenario) })
    }

    /// The outcome, and the errors of each trial.
    pub fn run(
        &self,
        cancel: &CancelToken,
        mut log: Option<&mut dyn FnMut(&Trial)>,
    ) -> Result<(Outcome, TrialErrors), StudyError> {
        let Self { scenario, plan, simulator, less, .. } = self;
        let tip = simulator.tip_in_tool();
        let mut vectors = Vec::new();
        let trials = plan.len();
        let mut tally = Tally::default();
        let mut of_trials = TrialErrors::with_capacity(trials);
        let free = simulator.free_motion();
        let keeps_third = free.is_some() && trials <= KEEP_THIRD;
        let mut determined_mm = Vec::with_capacity(if keeps_third { trials } else { 0 });
        let mut work = simulator.own_work();
        work += each_trial(plan, simulator, cancel, |index, trial| {
            if let Some(log) = log.as_deref_mut() {
                log(trial);
            }
            let is_known = trial.has_field(&scenario.environment);
            if tally.count(index, trial, is_known, scenario.outside) {
                if !is_known {
                    of_trials.without_field.push(of_trials.errors.len() as u32);
                }
                of_trials.push(index, [trial.tip_error_mm, trial.angle_error_deg]);
                if less.is_some() {
                    let simulated = &trial.crf_from_tool_simulated;
                    vectors.push(ErrorVectors::of(&trial.crf_from_tool, simulated, tip));
                }
                if keeps_third {
                    determined_mm.extend(trial.determined_mm);
                }
            }
        })?;
        if let Some(less) = less {
            of_trials.replace(&mut vectors, less);
        }
        let all_rejected = StudyError::AllRejected { trials };
        let angle_deg = Statistics::of(&mut of_trials.component(1)).ok_or(all_rejected.clone())?;
        let mut tip_mm = of_trials.component(0);
        let within = (scenario.requirement.as_ref()).and_then(|r| Within::of(&tip_mm, r));
        let position_mm = Statistics::of(&mut tip_mm).ok_or(all_rejected.clone())?;
        let position_mm_determined = match &free {
            None => None,
            Some(_) if keeps_third => Some(Statistics::of(&mut determined_mm).ok_or(all_rejected)?),
            Some(_) => {
                tip_mm.clear();
                work += each_trial(plan, simulator, cancel, |_, trial| {
                    if !is_rejected(trial, scenario.outside) {
                        tip_mm.extend(trial.determined_mm);
                    }
                })?;
                Some(Statistics::of(&mut tip_mm).ok_or(all_rejected)?)
            }
        };
        let room_field = RoomFieldFigures {
            trials,
            outside: tally.outside,
            in_metal: tally.in_metal,
            out_of_volume: tally.out_of_volume,
            without_field: tally.without_field,
            rejected: tally.rejected,
            position_mm,
            angle_deg,
            worst: tally.worst,
            within,
            free_axis: free.map(|(body, free)| FreeRotation {
                free: FreeAxis::of(body, free.axis, scenario),
                reach_mm: tally.free_reach_mm,
            }),
            position_mm_determined,
            poorly_determined: simulator.is_poorly_determined(),
            barely_determined: WeakRotation::of(scenario),
        };
        Ok((Outcome { room_field, work }, of_trials))
    }
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
    in_metal: usize,
    out_of_volume: usize,
    without_field: usize,
    rejected: usize,
    worst: Worst,
    has_worst: bool,
    free_reach_mm: f64,
}

impl Tally {
    /// Whether the trial enters the statistics.
    fn count(
        &mut self,
        index: usize,
        trial: &Trial,
        is_known: bool,
        outside: OutsidePolicy,
    ) -> bool {
        self.outside += usize::from(trial.outside > 0);
        self.in_metal += usize::from(trial.in_metal > 0);
        self.out_of_volume += usize::from(trial.out_of_volume > 0);
        self.without_field += usize::from(!is_known);
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
