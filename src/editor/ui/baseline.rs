//! The large figure as it was before the last change, so that the change can be shown.

use super::result::headline;
use crate::editor::document::WorldGeneration;
use crate::editor::state::{EditRequest, OpenWorld, Results};
use crate::editor::study::StudyDesk;
use bevy::prelude::*;

/// Name and value of the large figure before the last edit or drag began.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub struct Baseline(pub Option<(&'static str, f64)>);

/// Notes the figure at the first edit of a step; runs before the edits are applied.
pub(super) fn note_baseline(
    mut requests: MessageReader<EditRequest>,
    world: Option<Res<OpenWorld>>,
    generation: Option<Res<WorldGeneration>>,
    results: Res<Results>,
    desk: Option<Res<StudyDesk>>,
    mut baseline: ResMut<Baseline>,
    mut last_serial: Local<u64>,
) {
    // Figures of another mode are no change of the design.
    let serial = desk.map_or(0, |desk| desk.serial());
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
                let headline = headline(&study.value.figures);
                (headline.name, headline.value)
            });
            baseline.set_if_neq(Baseline(now));
        }
    }
}
