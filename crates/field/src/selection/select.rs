//! Tries every candidate in every hold-out, and chooses.

use super::choice::{Contender, choose};
use super::cross_validation::{self, Outcome, Problem, Split, System};
use super::folds::numbered;
use super::hold_outs::{AllFolds, HoldOut, HoldOutBy, HoldOuts};
use super::scoring::{HeldOutScores, Scores};
use super::sensors::{SensorSpread, sensor_spread};
use super::settings::{Candidate, SelectError, SelectSettings, check};
use crate::fit::FitMethod;
use crate::samples::SampleSet;
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::directions::DirectionSet;
use trackwright_task::Task;

/// A candidate and how it did.
#[derive(Clone, Debug, PartialEq)]
pub struct Scored {
    pub candidate: Candidate,
    /// Rows held out one by one.
    pub by_row: Option<Scores>,
    /// Rows held out with all of their group.
    pub by_group: Option<Scores>,
    /// Rows held out with all of their sensor.
    pub by_sensor: Option<Scores>,
    /// The scores that decide, with those of each fold.
    pub deciding: HeldOutScores,
    /// Whether the model has fewer coefficients an orientation than the places it was fitted to
    /// (clusters of positions count once). Else only the ridge determines the field between them.
    pub is_determined: bool,
    /// Orientations with fewer places than coefficients, of all rows.
    pub under_sampled: usize,
}

impl Scored {
    /// The scores that decide: by group where groups are known and no hold-out was requested.
    pub fn deciding(&self) -> &Scores {
        &self.deciding.overall
    }

    /// The scores of a hold-out, where rows were held out so.
    pub fn held_out_by(&self, by: HoldOutBy) -> Option<&Scores> {
        match by {
            HoldOutBy::Rows => self.by_row.as_ref(),
            HoldOutBy::Groups => self.by_group.as_ref(),
            HoldOutBy::Sensors => self.by_sensor.as_ref(),
        }
    }

    /// Whether most of the orientations have fewer places than coefficients.
    pub fn is_under_sampled(&self) -> bool {
        2 * self.under_sampled > self.candidate.directions.len()
    }

    /// Whether the samples determine the model, all of it: else it is chosen only where nothing
    /// else is tried.
    pub fn is_admissible(&self) -> bool {
        self.is_determined && !self.is_under_sampled()
    }

    fn contender(&self) -> Contender<'_> {
        Contender {
            size: self.candidate.coefficients(),
            is_regularised: self.candidate.ridge > 0.0,
            is_admissible: self.is_admissible(),
            scores: &self.deciding,
        }
    }
}

/// Everything that was tried, and the choice.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    /// By order, then orientations, then ridge.
    pub table: Vec<Scored>,
    /// The chosen one's place in the table.
    pub best: usize,
    /// The place of the one with the least RMS of all that may be chosen; it may be larger.
    pub least: usize,
    /// The place of the one that would have been chosen by position alone, where another one is
    /// as good within the noise of the folds and better in angle.
    pub instead_of: Option<usize>,
    /// Number of groups, where rows were grouped.
    pub groups: Option<usize>,
    /// Every way in which rows were held out, rows first.
    pub hold_outs: Vec<HoldOut>,
    /// Which of them decides.
    pub decided_by: HoldOutBy,
    /// What sensors differ by among themselves, where they were held out.
    pub sensors: Option<SensorSpread>,
    /// Systems that were not tried, since the rows do not determine them: order, orientations.
    pub left_out: Vec<(usize, DirectionSet)>,
}

impl Selection {
    /// The chosen candidate.
    pub fn best(&self) -> &Scored {
        &self.table[self.best]
    }

    /// The candidate with the least RMS of those that may be chosen.
    pub fn least(&self) -> &Scored {
        &self.table[self.least]
    }

    /// For each order with each set of orientations the place of the ridge that would be chosen
    /// if there were no other models.
    pub fn best_of_each_system(&self) -> Vec<usize> {
        let system = |row: &Scored| (row.candidate.order, row.candidate.directions);
        let mut places = Vec::new();
        let mut start = 0;
        for same in self.table.chunk_by(|a, b| system(a) == system(b)) {
            let end = start + same.len();
            let contenders: Vec<_> = same.iter().map(Scored::contender).collect();
            places.extend(choose(&contenders).map(|choice| start + choice.best));
            start = end;
        }
        places
    }
}

/// [`select_by`] with groups that decide where there are any.
pub fn select(
    set: &SampleSet,
    groups: Option<&[usize]>,
    settings: &SelectSettings,
    task: &Task,
) -> Result<Selection, SelectError> {
    let hold_outs = HoldOuts { groups, ..HoldOuts::default() };
    select_by(set, &hold_outs, settings, task)
}

/// Cross-validates every candidate in every hold-out and chooses by the one that decides: see
/// [`choose`].
///
/// The box is that of all samples, as it is for whoever fits the chosen model to them. The result
/// does not depend on the number of threads.
pub fn select_by(
    set: &SampleSet,
    hold_outs: &HoldOuts,
    settings: &SelectSettings,
    task: &Task,
) -> Result<Selection, SelectError> {
    check(set, settings)?;
    let rows = set.samples.len();
    let folds = AllFolds::new(hold_outs, rows, settings)?;
    let listed = folds.list();
    let decided_by = folds.deciding;
    let sensor_folds = folds.sensors.as_ref().map(|(folds, _)| folds.clone());
    let by_row = folds.rows.map(|folds| Split::new(set, folds));
    let by_group = folds.groups.map(|(folds, _)| Split::new(set, folds));
    let by_sensor = folds.sensors.map(|(folds, _)| Split::new(set, folds));
    let bounds =
        Bounds::around(set.samples.iter().map(|s| s.position_mm)).ok_or(SelectError::NoSamples)?;
    let problem = Problem::new(set, bounds);
    let (systems, left_out) = affordable(systems(settings), &problem, settings);
    let progress = cross_validation::progress(task, &systems, listed.len());
    let mut table = Vec::new();
    for system in &systems {
        let of = |split| cross_validation::scores(&problem, system, split, settings, &progress);
        let by_row = by_row.as_ref().map(of).transpose()?;
        let by_group = by_group.as_ref().map(of).transpose()?;
        let by_sensor = by_sensor.as_ref().map(of).transpose()?;
        let deciding = match decided_by {
            HoldOutBy::Rows => &by_row,
            HoldOutBy::Groups => &by_group,
            HoldOutBy::Sensors => &by_sensor,
        };
        // What decides is held out always.
        let Some(deciding) = deciding else {
            return Err(SelectError::NothingToHoldOut("rows"));
        };
        let under_sampled = problem.under_sampled(system, settings);
        let overall = |outcome: &Outcome, i: usize| outcome.scores[i].overall;
        for (i, &ridge) in system.ridges.iter().enumerate() {
            table.push(Scored {
                candidate: system.candidate(ridge),
                by_row: by_row.as_ref().map(|outcome| overall(outcome, i)),
                by_group: by_group.as_ref().map(|outcome| overall(outcome, i)),
                by_sensor: by_sensor.as_ref().map(|outcome| overall(outcome, i)),
                deciding: deciding.scores[i].clone(),
                is_determined: deciding.is_determined,
                under_sampled,
            });
        }
    }
    let contenders: Vec<_> = table.iter().map(Scored::contender).collect();
    let choice = choose(&contenders).ok_or(SelectError::NothingToTry("models"))?;
    let sensors = match (&sensor_folds, &by_sensor, hold_outs.sensors) {
        (Some(folds), Some(split), Some(labels)) => {
            let candidate = &table[choice.best].candidate;
            let quiet = Task::cancelled_by(task.cancel.clone());
            let left = cross_validation::residuals(&problem, candidate, split, settings, &quiet)?;
            let poses = hold_outs.groups.map(|groups| numbered(groups).0);
            let sensors = numbered(labels).0;
            sensor_spread(&left, &sensors, poses.as_deref(), folds, set.has_rotations).ok()
        }
        _ => None,
    };
    Ok(Selection {
        best: choice.best,
        least: choice.least,
        instead_of: choice.instead_of,
        table,
        groups: by_group.and(listed.iter().find(|h| h.by == HoldOutBy::Groups).map(|h| h.count)),
        hold_outs: listed,
        decided_by,
        sensors,
        left_out: left_out.iter().map(|system| (system.order, system.directions)).collect(),
    })
}

/// Parts systems that could not be chosen from the others, where others are determined: joint ones with
/// at least as many unknowns as rows, which take hours, and on request all that are under-sampled.
fn affordable(
    systems: Vec<System>,
    problem: &Problem,
    settings: &SelectSettings,
) -> (Vec<System>, Vec<System>) {
    let is_hopeless = |system: &System| {
        let candidate = system.candidate(0.0);
        let is_short = 2 * problem.under_sampled(system, settings) > candidate.directions.len();
        match settings.method {
            FitMethod::Joint => candidate.coefficients() >= problem.rows(),
            FitMethod::PerDirection => settings.only_contenders && is_short,
        }
    };
    let all_are = systems.iter().all(|system| system.order == 0 || is_hopeless(system));
    if all_are && !settings.only_contenders {
        return (systems, Vec::new());
    }
    systems.into_iter().partition(|system| !is_hopeless(system))
}

/// Every order with every set of orientations, order 0 once.
fn systems(settings: &SelectSettings) -> Vec<System> {
    let mut orders = settings.orders.clone();
    orders.sort_unstable();
    orders.dedup();
    let mut sets = settings.direction_sets.clone();
    sets.sort_unstable_by_key(|set| set.len());
    sets.dedup();
    let mut ridges = settings.ridges.clone();
    ridges.sort_unstable_by(f64::total_cmp);
    ridges.dedup();
    let mut systems = Vec::new();
    for order in orders {
        if order == 0 {
            systems.push(System { order, directions: DirectionSet::One, ridges: vec![0.0] });
            continue;
        }
        systems.extend(sets.iter().map(|&directions| System {
            order,
            directions,
            ridges: ridges.clone(),
        }));
    }
    systems
}
