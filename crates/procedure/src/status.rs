//! Where each step stands: its rows, and what they come to.

use super::changes::{Change, recording_changes, study_changes};
use super::decided::{DecidedFigures, DecidedRow, DecidedStudies, DecisionBasis, RoomName, Step};
use super::plan::{Plan, Recording, Room};
use serde::Serialize;
use trackwright_simulation::judgement::Verdict;
use trackwright_simulation::requirement::Requirement;
use trackwright_simulation::scenario::Scenario;
use trackwright_simulation::study::{NoFigures, Study, mode_of, study_with_figures};
use trackwright_task::{Cancelled, Task};

/// Where a design stands.
#[derive(Clone, Debug, PartialEq)]
pub struct StepStatus {
    pub crf: StudiesStatus,
    pub tool: StudiesStatus,
    pub built: BuiltStatus,
}

/// What a step comes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// The design has no CRF.
    DoesNotApply,
    /// Nothing recorded of the built tool is given.
    NotRecorded,
    /// No room reaches the design, or can be read; the recording cannot be used.
    NoFigures,
    /// There are figures, and nothing to hold them against.
    NoRequirement,
    /// In one row at least.
    Missed,
    /// In no row, and in one at least the measurements of the room do not settle it.
    CannotTell,
    /// In every row that has figures.
    Met,
    /// Measured and predicted errors of the built tool are beside each other; that is for people
    /// to judge.
    Compared,
    /// On the figures that there are.
    Decided,
    /// The design, a room or the recording has changed since.
    DecidedOnOtherFigures,
}

/// The CRF alone, or the tool.
#[derive(Clone, Debug, PartialEq)]
pub struct StudiesStatus {
    pub state: State,
    /// What the figures are held against.
    pub requirement: Option<Requirement>,
    /// One a room, of a CRF one a room and target; none where the step does not apply.
    pub rows: Vec<Row>,
    /// Since it was decided.
    pub changes: Vec<Change>,
}

/// Rows by what is known of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RowCounts {
    pub with_figures: usize,
    /// Those that miss the requirement.
    pub missed: usize,
    /// Those whose room does not settle it.
    pub cannot_tell: usize,
}

/// A study in one room.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    pub room: RoomName,
    /// The room is no part of the design.
    pub is_for_now: bool,
    /// Of a CRF; `None` at its tip or origin.
    pub target: Option<String>,
    pub studied: Result<Study, NoFigures>,
}

/// The built tool.
#[derive(Clone, Debug, PartialEq)]
pub struct BuiltStatus {
    pub state: State,
    /// Or why there are no figures; `None` where nothing is recorded.
    pub recording: Option<Result<Recording, String>>,
    /// Since it was decided.
    pub changes: Vec<Change>,
}

/// Why a step cannot be decided on.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Undecidable {
    #[error("the design has no CRF, so that there is nothing to decide on it")]
    DoesNotApply,
    #[error("nothing recorded of the built tool is given, expected its table")]
    NotRecorded,
    #[error("there are no figures to decide on: {why}")]
    NoFigures { why: String },
}

/// Computes every step. What stands in the way of one row is that row's.
///
/// # Errors
/// [`Cancelled`].
pub fn step_status(plan: Plan, task: &Task) -> Result<StepStatus, Cancelled> {
    let of_crf = plan.rooms.len() * plan.crf_targets.len();
    let all = (of_crf + plan.rooms.len()).max(1) as f64;
    let middle = of_crf as f64 / all;
    let crf = match plan.crf_targets[..] {
        [] => StudiesStatus {
            state: State::DoesNotApply,
            requirement: None,
            rows: Vec::new(),
            changes: Vec::new(),
        },
        _ => {
            let rows = crf_rows(&plan, &task.subtask(0.0, middle))?;
            studies_status(rows, plan.crf_requirement, plan.decided_crf.as_ref())
        }
    };
    let rows = tool_rows(&plan, &task.subtask(middle, 1.0))?;
    Ok(StepStatus {
        crf,
        tool: studies_status(rows, plan.requirement, plan.decided_tool.as_ref()),
        built: built_status(plan.recording, plan.decided_built.as_ref()),
    })
}

fn crf_rows(plan: &Plan, task: &Task) -> Result<Vec<Row>, Cancelled> {
    let mut wanted: Vec<(&Room, Option<String>, Result<&Scenario, &String>)> = Vec::new();
    for room in &plan.rooms {
        match &room.studies {
            Err(why) => {
                let targets = plan.crf_targets.iter();
                wanted.extend(targets.map(|target| (room, target.clone(), Err(why))));
            }
            Ok(studies) => wanted
                .extend((studies.crf.iter()).map(|at| (room, at.target.clone(), Ok(&at.scenario)))),
        }
    }
    rows(wanted, task)
}

fn tool_rows(plan: &Plan, task: &Task) -> Result<Vec<Row>, Cancelled> {
    let each = plan.rooms.iter();
    let wanted = each.map(|room| (room, None, room.studies.as_ref().map(|s| &s.tool)));
    rows(wanted.collect(), task)
}

/// A study runs on all cores, so that they run one after the other.
fn rows(
    wanted: Vec<(&Room, Option<String>, Result<&Scenario, &String>)>,
    task: &Task,
) -> Result<Vec<Row>, Cancelled> {
    let all = wanted.len();
    let mut rows = Vec::with_capacity(all);
    for (room, target, scenario) in wanted {
        task.step(rows.len(), all)?;
        let studied = match scenario {
            Err(why) => Err(NoFigures::Room(why.clone())),
            Ok(scenario) => study_with_figures(scenario, &mode_of(scenario), &task.cancel)?,
        };
        rows.push(Row { room: room.name.clone(), is_for_now: room.is_for_now, target, studied });
    }
    task.step(all, all)?;
    Ok(rows)
}

fn studies_status(
    rows: Vec<Row>,
    requirement: Option<Requirement>,
    decided: Option<&DecidedStudies>,
) -> StudiesStatus {
    let lasting = rows.iter().filter(|row| !row.is_for_now);
    let changes = decided
        .map_or_else(Vec::new, |decided| study_changes(decided, requirement.as_ref(), lasting));
    let verdict = Verdict::of_all(rows.iter().filter_map(Row::verdict));
    let state = match decided {
        Some(_) => State::of_decided(&changes),
        None if rows.iter().all(|row| row.studied.is_err()) => State::NoFigures,
        None => match verdict {
            None => State::NoRequirement,
            Some(Verdict::Met) => State::Met,
            Some(Verdict::Missed) => State::Missed,
            Some(Verdict::CannotTell) => State::CannotTell,
        },
    };
    StudiesStatus { state, requirement, rows, changes }
}

fn built_status(
    recording: Option<Result<Recording, String>>,
    decided: Option<&super::decided::DecidedRecording>,
) -> BuiltStatus {
    let changes = match (decided, &recording) {
        (Some(decided), Some(found)) => {
            let now = found.as_ref().map(|r| &r.found).map_err(String::as_str);
            recording_changes(decided, now)
        }
        _ => Vec::new(),
    };
    let state = match (decided, &recording) {
        (Some(_), _) => State::of_decided(&changes),
        (None, None) => State::NotRecorded,
        (None, Some(Err(_))) => State::NoFigures,
        (None, Some(Ok(_))) => State::Compared,
    };
    BuiltStatus { state, recording, changes }
}

impl State {
    fn of_decided(changes: &[Change]) -> Self {
        match changes {
            [] => Self::Decided,
            _ => Self::DecidedOnOtherFigures,
        }
    }

    /// In a word or a few.
    pub fn words(self) -> &'static str {
        match self {
            Self::DoesNotApply => "does not apply",
            Self::NotRecorded => "not recorded yet",
            Self::NoFigures => "no figures",
            Self::NoRequirement => "has no requirement",
            Self::Missed => "missed",
            Self::CannotTell => "cannot tell",
            Self::Met => "met",
            Self::Compared => "compared",
            Self::Decided => "decided",
            Self::DecidedOnOtherFigures => "decided on other figures",
        }
    }
}

impl Row {
    /// Whether the requirement is met, as far as the room determines it; `None` without one, or
    /// without figures.
    pub fn verdict(&self) -> Option<Verdict> {
        Some(self.studied.as_ref().ok()?.figures.requirement.as_ref()?.verdict)
    }
}

impl StudiesStatus {
    /// How many rows have figures, and what is known of them.
    pub fn counts(&self) -> RowCounts {
        let rows = &self.rows;
        let of = |verdict| rows.iter().filter(|row| row.verdict() == Some(verdict)).count();
        RowCounts {
            with_figures: rows.iter().filter(|row| row.studied.is_ok()).count(),
            missed: of(Verdict::Missed),
            cannot_tell: of(Verdict::CannotTell),
        }
    }

    /// What a decision would be on. Rooms that are looked at this once are no part of it.
    ///
    /// # Errors
    /// See [`Undecidable`].
    pub fn basis(&self) -> Result<DecisionBasis, Undecidable> {
        if self.state == State::DoesNotApply {
            return Err(Undecidable::DoesNotApply);
        }
        let lasting = self.rows.iter().filter(|row| !row.is_for_now);
        let rows: Vec<DecidedRow> = lasting
            .map(|row| DecidedRow {
                room: row.room.clone(),
                target: row.target.clone(),
                figures: match &row.studied {
                    Ok(studied) => Ok(DecidedFigures::of(studied)),
                    Err(why) => Err(why.to_string()),
                },
            })
            .collect();
        if rows.iter().any(|row| row.figures.is_ok()) {
            return Ok(DecisionBasis::Studies(DecidedStudies {
                requirement: self.requirement,
                rows,
            }));
        }
        let mut why = rows.into_iter().filter_map(|row| row.figures.err());
        Err(Undecidable::NoFigures { why: why.next().unwrap_or_default() })
    }
}

impl BuiltStatus {
    /// What a decision would be on.
    ///
    /// # Errors
    /// See [`Undecidable`].
    pub fn basis(&self) -> Result<DecisionBasis, Undecidable> {
        match &self.recording {
            None => Err(Undecidable::NotRecorded),
            Some(Err(why)) => Err(Undecidable::NoFigures { why: why.clone() }),
            Some(Ok(recording)) => Ok(DecisionBasis::Recording(Box::new(recording.found.clone()))),
        }
    }
}

impl StepStatus {
    pub fn state(&self, step: Step) -> State {
        match step {
            Step::Crf => self.crf.state,
            Step::Tool => self.tool.state,
            Step::Built => self.built.state,
        }
    }

    /// What has changed since a step was decided.
    pub fn changes(&self, step: Step) -> &[Change] {
        match step {
            Step::Crf => &self.crf.changes,
            Step::Tool => &self.tool.changes,
            Step::Built => &self.built.changes,
        }
    }

    /// What a decision on a step would be on.
    ///
    /// # Errors
    /// See [`Undecidable`].
    pub fn basis(&self, step: Step) -> Result<DecisionBasis, Undecidable> {
        match step {
            Step::Crf => self.crf.basis(),
            Step::Tool => self.tool.basis(),
            Step::Built => self.built.basis(),
        }
    }

    /// States that a step is decided on what is there.
    pub fn decide(&mut self, step: Step) {
        let (state, changes) = match step {
            Step::Crf => (&mut self.crf.state, &mut self.crf.changes),
            Step::Tool => (&mut self.tool.state, &mut self.tool.changes),
            Step::Built => (&mut self.built.state, &mut self.built.changes),
        };
        *state = State::Decided;
        changes.clear();
    }

    /// What a decision has to give a reason for, decided or not: a requirement of the step that is
    /// missed, or that a room does not settle; `None` where it is met or there is none.
    pub fn objection(&self, step: Step) -> Option<&'static str> {
        let counts = match step {
            Step::Crf => self.crf.counts(),
            Step::Tool => self.tool.counts(),
            Step::Built => return None,
        };
        match (counts.missed, counts.cannot_tell) {
            (0, 0) => None,
            (0, _) => Some("it is not determined whether the requirement is met"),
            _ => Some("the requirement is missed"),
        }
    }
}
