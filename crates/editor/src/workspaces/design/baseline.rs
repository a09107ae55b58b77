//! The large figure as it was before the last change, so that the change can be shown.

use crate::document::requests::{EditRequest, OpenWorld};
use crate::document::state::WorldGeneration;
use crate::document::trials::TrialChoice;
use crate::runner::results::Results;
use bevy::prelude::*;
use trackwright_simulation::{Headline, headline};

/// The large figure before the last edit or drag began, of the room's own field and as it was to be
/// expected: while something is dragged the one is shown, and then the other.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub struct Baseline(pub Option<[Headline; 2]>);

impl Baseline {
    /// The value that a large figure is a change from, if there is one of its kind.
    pub fn before(&self, now: &Headline) -> Option<f64> {
        let is_of_kind = |then: &&Headline| {
            then.metric == now.metric && then.interval.is_some() == now.interval.is_some()
        };
        let then = self.0.as_ref()?.iter().find(is_of_kind)?;
        Some(then.value)
    }
}

/// Notes the figure at the first edit of a step; runs before the edits are applied.
pub(crate) fn note_baseline(
    mut requests: MessageReader<EditRequest>,
    world: Option<Res<OpenWorld>>,
    generation: Option<Res<WorldGeneration>>,
    results: Res<Results>,
    choice: Option<Res<TrialChoice>>,
    mut baseline: ResMut<Baseline>,
    mut last_serial: Local<u64>,
) {
    // Figures of another mode are no change of the design.
    let serial = choice.map_or(0, |choice| choice.serial());
    if *last_serial != serial {
        *last_serial = serial;
        baseline.set_if_neq(Baseline(None));
    }
    if generation.is_some_and(|g| g.is_changed()) {
        baseline.set_if_neq(Baseline(None));
    }
    let mut is_in_step = world.is_some_and(|w| w.0.document.is_in_step());
    for request in requests.read() {
        let begins = match request {
            EditRequest::Begin(_) => {
                is_in_step = true;
                true
            }
            EditRequest::Apply(_) => !is_in_step,
            EditRequest::Commit | EditRequest::Cancel => {
                is_in_step = false;
                false
            }
            EditRequest::Undo | EditRequest::Redo | EditRequest::JumpTo(_) => true,
        };
        if begins {
            let now = results.study.as_ref().map(|study| {
                let of = |expected| headline(&study.value.figures, expected);
                [of(None), of(results.expected_of_study())]
            });
            baseline.set_if_neq(Baseline(now));
        }
    }
}
