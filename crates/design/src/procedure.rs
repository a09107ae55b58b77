//! Where a design stands in the paper's procedure: the further rooms that it is judged in, and what
//! was decided at each step, saved with the design and edited like it.

use super::day::Day;
use trackwright_geometry::limits::short;
use trackwright_procedure::{
    DecidedFigures, DecidedRecording, DecidedRow, DecidedStudies, DecisionBasis, RoomName, Step,
};
use trackwright_simulation::judgement::Verdict;
use trackwright_simulation::requirement::Requirement;

/// What a design file keeps of the procedure.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Procedure {
    /// Environment files as written in the design, relative to it. The design's own room is always
    /// judged, and is none of them.
    pub further_rooms: Vec<String>,
    pub crf: Option<Decision>,
    pub tool: Option<Decision>,
    pub built: Option<Decision>,
}

/// The decision that a step is good enough to go on, and the figures that it rests on.
#[derive(Clone, Debug, PartialEq)]
pub struct Decision {
    pub date: Day,
    /// In the words of who decided; may be empty.
    pub note: String,
    pub basis: DecisionBasis,
}

/// What no decision can be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DecisionError {
    #[error("the {step} is decided on {expected}, found {found}")]
    Basis { step: Step, found: &'static str, expected: &'static str },
    #[error("{field} is {found}, expected {expected}")]
    Field { field: String, found: String, expected: &'static str },
}

impl Procedure {
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    pub fn decision(&self, step: Step) -> Option<&Decision> {
        match step {
            Step::Crf => self.crf.as_ref(),
            Step::Tool => self.tool.as_ref(),
            Step::Built => self.built.as_ref(),
        }
    }

    /// The steps that were decided, in their order.
    pub fn decisions(&self) -> impl Iterator<Item = (Step, &Decision)> {
        let each = Step::ALL.into_iter();
        each.filter_map(|step| self.decision(step).map(|decision| (step, decision)))
    }

    /// Every file that it refers to, to be rewritten where the design moves.
    pub fn references_mut(&mut self) -> impl Iterator<Item = &mut String> {
        let decisions = [&mut self.crf, &mut self.tool, &mut self.built];
        let of_decisions =
            decisions.into_iter().flatten().flat_map(|decision| decision.basis.references_mut());
        self.further_rooms.iter_mut().chain(of_decisions)
    }

    pub(super) fn decision_mut(&mut self, step: Step) -> &mut Option<Decision> {
        match step {
            Step::Crf => &mut self.crf,
            Step::Tool => &mut self.tool,
            Step::Built => &mut self.built,
        }
    }
}

impl Decision {
    /// Whether this can have been decided at a step.
    ///
    /// # Errors
    /// The basis of another step, figures that are none, or that contradict each other.
    pub fn check(&self, step: Step) -> Result<(), DecisionError> {
        const STUDIES: &str = "studies";
        const RECORDING: &str = "a recording";
        match (step, &self.basis) {
            (Step::Crf | Step::Tool, DecisionBasis::Studies(studies)) => check_studies(studies),
            (Step::Built, DecisionBasis::Recording(recording)) => check_recording(recording),
            (_, basis) => {
                let (found, expected) = match basis {
                    DecisionBasis::Studies(_) => (STUDIES, RECORDING),
                    DecisionBasis::Recording(_) => (RECORDING, STUDIES),
                };
                Err(DecisionError::Basis { step, found, expected })
            }
        }
    }
}

/// Beyond this no figure was computed: a thousand kilometres, or as many degrees.
const MAX_FIGURE: f64 = 1e9;

fn wrong<T>(field: &str, found: impl ToString, expected: &'static str) -> Result<T, DecisionError> {
    Err(DecisionError::Field { field: field.to_owned(), found: found.to_string(), expected })
}

fn check_studies(studies: &DecidedStudies) -> Result<(), DecisionError> {
    let bounds = studies.requirement.iter().flat_map(|r| r.bounds());
    for (metric, bound) in bounds {
        if let Some(expected) = Requirement::bound_problem(metric, bound) {
            return wrong(&format!("requirement.{}", metric.name()), short(bound), expected);
        }
    }
    if studies.rows.iter().all(|row| row.figures.is_err()) {
        return wrong("rows", "without figures", "those of a room at least");
    }
    for (index, row) in studies.rows.iter().enumerate() {
        check_row(row, studies).map_err(|error| within(&format!("rows[{index}]"), error))?;
    }
    Ok(())
}

fn within(place: &str, error: DecisionError) -> DecisionError {
    match error {
        DecisionError::Field { field, found, expected } => {
            DecisionError::Field { field: format!("{place}.{field}"), found, expected }
        }
        other => other,
    }
}

fn check_row(row: &DecidedRow, studies: &DecidedStudies) -> Result<(), DecisionError> {
    check_room(&row.room)?;
    let Ok(figures) = &row.figures else {
        return Ok(());
    };
    let DecidedFigures { trials, without_field, verdict, .. } = *figures;
    if trials == 0 {
        return wrong("trials", trials, "one at least");
    }
    if without_field >= trials {
        return wrong("without_field", without_field, "fewer than the trials");
    }
    for (metric, value) in figures.values.iter() {
        let field = format!("{}.{}", metric.of.key(), metric.summary.key());
        check_not_negative(&field, value)?;
    }
    let is_beyond = |(metric, limit)| figures.values.get(metric).is_some_and(|value| value > limit);
    let mut bounds = studies.requirement.iter().flat_map(|r| r.bounds()).peekable();
    let is_required = bounds.peek().is_some();
    // A figure lies in its interval.
    match (verdict, is_required) {
        (None, false) | (Some(Verdict::CannotTell), true) => Ok(()),
        (Some(found), true) if bounds.any(is_beyond) == (found == Verdict::Missed) => Ok(()),
        (Some(found), true) => wrong("verdict", found.label(), "what its figures allow"),
        (Some(found), false) => wrong("verdict", found.label(), "none without a requirement"),
        (None, true) => wrong("verdict", "absent", "whether the requirement was met"),
    }
}

fn check_recording(decided: &DecidedRecording) -> Result<(), DecisionError> {
    check_room(&decided.room)?;
    let recording = &decided.recording;
    let files = [("table", Some(&recording.table)), ("crf_table", recording.crf_table.as_ref())];
    for (name, file) in files {
        if file.is_some_and(|file| file.trim().is_empty()) {
            return wrong(name, "empty", "a file");
        }
    }
    if recording.averaged == 0 {
        return wrong("averaged", 0, "one reading at least");
    }
    if decided.used > decided.poses {
        return wrong("used", decided.used, "no more than poses");
    }
    for (name, value) in [
        ("truth_mm", recording.truth_std_mm),
        ("measured_rms", decided.measured_rms_mm),
        ("predicted_rms", decided.predicted_rms_mm),
        ("residual_rms", decided.residual_rms_mm),
    ] {
        check_not_negative(name, value)?;
    }
    for (name, value) in [("explained", decided.explained), ("slope", decided.slope)] {
        let Some(value) = value else { continue };
        if !value.is_finite() {
            return wrong(name, value, "a finite number");
        }
        if value.abs() > MAX_FIGURE {
            return wrong(name, short(value), "at most 1e9 either way");
        }
    }
    Ok(())
}

fn check_room(room: &RoomName) -> Result<(), DecisionError> {
    if room.file.trim().is_empty() {
        return wrong("file", "empty", "a file");
    }
    Ok(())
}

fn check_not_negative(field: &str, value: f64) -> Result<(), DecisionError> {
    if !(value.is_finite() && value >= 0.0) {
        return wrong(field, short(value), "zero or more");
    }
    if value > MAX_FIGURE {
        return wrong(field, short(value), "at most 1e9");
    }
    Ok(())
}
