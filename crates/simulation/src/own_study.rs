//! A design's own study in one room: its figures, and whether the room has a field where it is
//! used.

use super::expected::{BoundVerdict, Expected, expected_where_measured, study_verdict};
use super::figures::{Figures, with_separators};
use super::run::{StudyError, is_rejected, run};
use super::scenario::{Mode, Scenario};
use super::trial::Trial;
use std::collections::BTreeSet;
use trackwright_task::{CancelToken, Cancelled};

/// What a design's study visits: its range of motion, or where it has none its own pose.
pub fn mode_of(scenario: &Scenario) -> Mode {
    match scenario.motion {
        Some(_) => Mode::Motion,
        None => Mode::Single,
    }
}

/// A study with what its figures do not state about the trials.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnStudy {
    pub figures: Figures,
    /// Expected figures with their intervals, where the room has measurements to draw fields from.
    pub expected: Option<Expected>,
    /// Trials with a sensor where the room has no field: outside the model's box or out of the
    /// tracker's volume.
    pub without_field: usize,
    /// The trials with the largest errors of tip and of angle, each once, in their order.
    pub extremes: Vec<usize>,
}

impl OwnStudy {
    /// Whether the requirement is met, as far as the room determines it; `None` without one.
    pub fn verdict(&self) -> Option<BoundVerdict> {
        study_verdict(&self.figures, self.expected.as_ref())
    }
}

/// Why there are no figures of a design in a room.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoFigures {
    #[error(
        "the room does not reach: of {trials} trials, {outside} have a sensor outside the model's box and \
         {out_of_volume} one out of the tracker's volume"
    )]
    NoOverlap { trials: usize, outside: usize, out_of_volume: usize },
    #[error(transparent)]
    Study(StudyError),
    /// The room itself is not to be had.
    #[error("{0}")]
    Room(String),
}

/// Runs a mode. A study without a single trial in the room's field has no figures.
///
/// # Errors
/// [`Cancelled`].
pub fn own_study(
    scenario: &Scenario,
    mode: &Mode,
    cancel: &CancelToken,
) -> Result<Result<OwnStudy, NoFigures>, Cancelled> {
    let mut seen = Seen::default();
    let mut visit = |trial: &Trial| seen.visit(trial, scenario);
    let outcome = match run(scenario, mode, cancel, Some(&mut visit)) {
        Ok(outcome) => Some(outcome),
        Err(StudyError::AllRejected { .. }) => None,
        Err(StudyError::Cancelled) => return Err(Cancelled),
        Err(error) => return Ok(Err(NoFigures::Study(error))),
    };
    let Some(outcome) = outcome.filter(|_| seen.without_field < seen.trials) else {
        return Ok(Err(NoFigures::NoOverlap {
            trials: seen.trials,
            outside: seen.outside,
            out_of_volume: seen.out_of_volume,
        }));
    };
    Ok(Ok(OwnStudy {
        figures: outcome.figures,
        expected: expected_where_measured(scenario, mode, cancel)?,
        without_field: seen.without_field,
        extremes: seen.extremes(),
    }))
}

/// What has to be known of a study before its figures are read.
pub fn study_notes(figures: &Figures, without_field: usize) -> Vec<String> {
    let mut notes = Vec::new();
    if without_field > 0 {
        notes.push(format!(
            "{} of {} trials have a sensor where the room has no field ({} outside the model's box, {} out of \
             the tracker's volume)",
            with_separators(without_field),
            with_separators(figures.trials),
            with_separators(figures.outside),
            with_separators(figures.out_of_volume)
        ));
    }
    if figures.rejected > 0 {
        notes.push(format!(
            "{} of {} trials were left out of its figures",
            with_separators(figures.rejected),
            with_separators(figures.trials)
        ));
    }
    if let Some(free) = &figures.free_axis {
        notes.push(free.statement());
    }
    if let Some(weak) = &figures.barely_determined {
        notes.push(weak.statement());
    } else if figures.poorly_determined && figures.free_axis.is_none() {
        notes.push("a rotation is so weakly determined that noise decides it".to_owned());
    }
    notes
}

#[derive(Default)]
struct Seen {
    trials: usize,
    outside: usize,
    out_of_volume: usize,
    without_field: usize,
    largest_tip: Largest,
    largest_angle: Largest,
}

/// So many of a study's worst poses are kept, of tip and of angle each: in a field that is a little
/// another one, one of them is the worst.
const MOST_EXTREMES: usize = 16;

/// The trials of the largest values, the largest first.
#[derive(Default)]
struct Largest(Vec<(f64, usize)>);

impl Largest {
    fn note(&mut self, value: f64, trial: usize) {
        let after = self.0.partition_point(|(other, _)| *other >= value);
        if after < MOST_EXTREMES {
            self.0.truncate(MOST_EXTREMES - 1);
            self.0.insert(after, (value, trial));
        }
    }
}

impl Seen {
    fn visit(&mut self, trial: &Trial, scenario: &Scenario) {
        let (outside, out_of_volume) = (trial.outside > 0, trial.out_of_volume > 0);
        self.outside += usize::from(outside);
        self.out_of_volume += usize::from(out_of_volume);
        self.without_field += usize::from(outside || out_of_volume);
        if !is_rejected(trial, scenario.outside) {
            self.largest_tip.note(trial.tip_error_mm, self.trials);
            self.largest_angle.note(trial.angle_error_deg, self.trials);
        }
        self.trials += 1;
    }

    fn extremes(&self) -> Vec<usize> {
        let each = self.largest_tip.0.iter().chain(&self.largest_angle.0);
        let trials: BTreeSet<usize> = each.map(|(_, trial)| *trial).collect();
        trials.into_iter().collect()
    }
}
