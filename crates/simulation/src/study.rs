//! A study: what is known of a design's figures in one room, beside the paper's simulation.

use super::figure::Figures;
use super::figures::RoomFieldFigures;
use super::run::{Less, Outcome, Prepared, StudyError, TrialErrors};
use super::scenario::{Mode, Scenario};
use super::trial::Trial;
use super::work::Work;
use std::collections::BTreeSet;
use trackwright_result::with_separators;
use trackwright_task::{CancelToken, Cancelled};

/// What a design's study visits: its range of motion, or where it has none its own pose.
pub fn mode_of(scenario: &Scenario) -> Mode {
    match scenario.motion {
        Some(_) => Mode::Motion,
        None => Mode::Single,
    }
}

/// A mode of a scenario, simulated.
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    /// What is known of its figures, and of the requirement.
    pub figures: Figures,
    /// The paper's simulation: the room's model taken for its field.
    pub room_field: RoomFieldFigures,
    /// The trials with the largest errors of tip and of angle by the room's model alone, each once, in their
    /// order.
    pub extremes: Vec<usize>,
    pub work: Work,
}

/// Why there are no figures of a design in a room.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoFigures {
    #[error(
        "the room does not reach: of {} trials, {} have a sensor outside the model's box{}, and {} one out of \
         the tracker's volume",
        with_separators(*.trials), with_separators(*.outside), of_these_in_metal(*.in_metal),
        with_separators(*.out_of_volume)
    )]
    NoOverlap { trials: usize, outside: usize, in_metal: usize, out_of_volume: usize },
    #[error(transparent)]
    Study(StudyError),
    /// The room itself is not to be had.
    #[error("{0}")]
    Room(String),
}

/// Of trials with a sensor where the model has no reading.
fn of_these_in_metal(trials: usize) -> String {
    match trials {
        0 => String::new(),
        trials => format!(" or in metal ({} in metal)", with_separators(trials)),
    }
}

/// Runs a mode; `log` gets its trials in order, by the room's model alone. The result does not depend on the
/// number of threads.
///
/// # Errors
/// See [`StudyError`].
pub fn study(
    scenario: &Scenario,
    mode: &Mode,
    cancel: &CancelToken,
    log: Option<&mut dyn FnMut(&Trial)>,
) -> Result<Study, StudyError> {
    Prepared::new(scenario, mode)?.study(cancel, log)
}

/// The same of errors from which a part is taken out, by the room's model alone as in every drawn one.
///
/// # Errors
/// See [`StudyError`].
pub fn study_less(
    scenario: &Scenario,
    mode: &Mode,
    less: &Less,
    cancel: &CancelToken,
) -> Result<Study, StudyError> {
    Prepared { less: Some(less), ..Prepared::new(scenario, mode)? }.study(cancel, None)
}

impl Prepared<'_> {
    fn study(
        &self,
        cancel: &CancelToken,
        log: Option<&mut dyn FnMut(&Trial)>,
    ) -> Result<Study, StudyError> {
        let (outcome, errors) = self.run(cancel, log)?;
        let figures = Figures::of(self, &outcome, &errors, cancel)?;
        let Outcome { room_field, work } = outcome;
        Ok(Study { figures, room_field, extremes: extremes(&errors), work })
    }
}

/// The same, where a study without figures is no error.
///
/// # Errors
/// [`Cancelled`].
pub fn study_with_figures(
    scenario: &Scenario,
    mode: &Mode,
    cancel: &CancelToken,
) -> Result<Result<Study, NoFigures>, Cancelled> {
    match study(scenario, mode, cancel, None) {
        Err(StudyError::Cancelled) => Err(Cancelled),
        Err(StudyError::AllRejected { trials }) => {
            Ok(Err(NoFigures::NoOverlap { trials, outside: trials, in_metal: 0, out_of_volume: 0 }))
        }
        Err(error) => Ok(Err(NoFigures::Study(error))),
        Ok(found) => Ok(match found.no_overlap() {
            None => Ok(found),
            Some(none) => Err(none),
        }),
    }
}

impl Study {
    /// Why there are no figures, where no trial is in the room's field.
    pub fn no_overlap(&self) -> Option<NoFigures> {
        let RoomFieldFigures { trials, outside, in_metal, out_of_volume, .. } = self.room_field;
        let none = NoFigures::NoOverlap { trials, outside, in_metal, out_of_volume };
        self.figures.all.is_empty().then_some(none)
    }

    /// What has to be known before the figures are read.
    pub fn notes(&self) -> Vec<String> {
        let found = &self.room_field;
        let mut notes = Vec::new();
        if found.without_field > 0 {
            notes.push(format!(
                "{} of {} trials have a sensor where the room states no field ({} outside the model's box{}, {} \
                 out of the tracker's volume)",
                with_separators(found.without_field),
                with_separators(found.trials),
                with_separators(found.outside),
                of_these_in_metal(found.in_metal),
                with_separators(found.out_of_volume)
            ));
        }
        if found.rejected > 0 {
            notes.push(format!(
                "{} of {} trials were left out of its figures",
                with_separators(found.rejected),
                with_separators(found.trials)
            ));
        }
        if let Some(free) = &found.free_axis {
            notes.push(free.statement());
        }
        if let Some(weak) = &found.barely_determined {
            notes.push(weak.statement());
        } else if found.poorly_determined && found.free_axis.is_none() {
            notes.push("a rotation is so weakly determined that noise decides it".to_owned());
        }
        notes
    }
}

/// So many of a study's worst poses are kept, of tip and of angle each: in a field that is a little
/// another one, one of them is the worst.
const MOST_EXTREMES: usize = 16;

fn extremes(errors: &TrialErrors) -> Vec<usize> {
    let mut trials = BTreeSet::new();
    for component in 0..2 {
        let largest = errors.largest(component, MOST_EXTREMES);
        trials.extend(largest.into_iter().map(|place| errors.number(place)));
    }
    trials.into_iter().collect()
}
