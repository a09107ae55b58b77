//! Where a step stands in a line, the same on the command line and in the editor.

use super::decided::Step;
use super::status::{State, StepStatus, StudiesStatus};

/// The state of a step with what it is about: `missed in 1 of 3 rooms`.
pub fn headline(found: &StepStatus, step: Step) -> String {
    let state = found.state(step);
    let studies = match step {
        Step::Crf => &found.crf,
        Step::Tool => &found.tool,
        Step::Built => return built(state),
    };
    let text = match state {
        State::DoesNotApply => return "does not apply, the design has no CRF".to_owned(),
        State::NoFigures => return "no figures in any room".to_owned(),
        State::NoRequirement => "there is no requirement to hold it against".to_owned(),
        State::Met | State::Missed | State::CannotTell => verdicts(studies),
        _ => match studies.rows.iter().any(|row| row.verdict().is_some()) {
            true => format!("{}; {}", state.words(), verdicts(studies)),
            false => state.words().to_owned(),
        },
    };
    let without = studies.rows.len() - studies.counts().with_figures;
    let text = match without {
        0 => text,
        1 => format!("{text}; one has no figures"),
        without => format!("{text}; {without} have no figures"),
    };
    match (step, found.crf.state) {
        // Its figures are of this CRF, which the procedure would have designed anew.
        (Step::Tool, State::Missed) => format!("{text}; the CRF alone does not satisfy yet"),
        _ => text,
    }
}

fn built(state: State) -> String {
    match state {
        State::NotRecorded => "nothing recorded yet".to_owned(),
        State::Compared => {
            "measured and predicted errors are compared, nothing is decided".to_owned()
        }
        State::NoFigures => "the recording gives no figures".to_owned(),
        state => state.words().to_owned(),
    }
}

/// Rows are rooms, or rooms and targets.
fn verdicts(studies: &StudiesStatus) -> String {
    let counts = studies.counts();
    let all = counts.with_figures;
    let rows = match studies.rows.iter().any(|row| row.target.is_some()) {
        true => "targets and rooms",
        false if all == 1 => "room",
        false => "rooms",
    };
    match (counts.missed, counts.cannot_tell) {
        (0, 0) => format!("met in {all} of {all} {rows}"),
        (0, open) => format!("cannot tell in {open} of {all} {rows}"),
        (missed, 0) => format!("missed in {missed} of {all} {rows}"),
        (missed, open) => format!("missed in {missed} of {all} {rows}, cannot tell in {open}"),
    }
}
