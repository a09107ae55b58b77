//! The large figure as it was before the last change, so that the change can be shown.

use crate::document::requests::{EditRequest, OpenWorld};
use crate::document::state::WorldGeneration;
use crate::document::trials::TrialChoice;
use crate::runner::results::Results;
use bevy::prelude::*;
use std::sync::Arc;
use trackwright_field::Environment;
use trackwright_project::World as OpenFiles;
use trackwright_simulation::{Figure, Motion};

/// The large figure before the last edit or drag began.
#[derive(Resource, Clone, Debug, Default)]
pub struct Baseline(Option<Before>);

/// A figure, and what it was of beside the design.
#[derive(Clone, Debug)]
struct Before {
    figure: Figure,
    /// Without the metal that a hand may move.
    room: Arc<Environment>,
    motion: Option<Motion>,
}

/// What the large figure differs by from what it was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// The design changed: mm or degrees more than before.
    By(f64),
    /// A smaller error in another room is no better design.
    OtherRoom,
    /// Nor is a smaller error over another range of motion.
    OtherMotion,
}

impl Baseline {
    /// The change of a large figure of the open design, where there was one of its kind.
    pub fn change(&self, world: &OpenFiles, now: &Figure) -> Option<Change> {
        let before = self.0.as_ref()?;
        if !Arc::ptr_eq(&before.room, world.bare_environment()) {
            return Some(Change::OtherRoom);
        }
        if before.motion != world.document.design().motion {
            return Some(Change::OtherMotion);
        }
        let then = before.figure;
        (then.metric == now.metric).then_some(Change::By(now.value - then.value))
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
    let are_trials_others = *last_serial != serial;
    *last_serial = serial;
    if (are_trials_others || generation.is_some_and(|g| g.is_changed())) && baseline.0.is_some() {
        baseline.0 = None;
    }
    let mut is_in_step = world.as_ref().is_some_and(|w| w.0.document.is_in_step());
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
            let figure = results.study.as_ref().and_then(|study| study.value.figures.headline());
            let now = world.as_ref().zip(figure).map(|(world, figure)| Before {
                figure: *figure,
                room: Arc::clone(world.0.bare_environment()),
                motion: world.0.document.design().motion,
            });
            baseline.0 = now;
        }
    }
}
