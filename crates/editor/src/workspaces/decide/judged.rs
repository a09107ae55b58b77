//! Where the design stands in its procedure: every step in every room, computed anew once edits rest.

use crate::document::requests::{ActiveDrag, OpenWorld};
use crate::document::state::WorldGeneration;
use crate::runner::jobs::Newest;
use crate::runner::wake::Waker;
use crate::schedule::request_then_receive;
use crate::workspaces::decide::requests::is_shown;
use crate::workspaces::decide::state::DecideState;
use bevy::prelude::*;
use std::cell::RefCell;
use trackwright_calibration::agreement::BuiltRecording;
use trackwright_procedure::StepStatus;
use trackwright_project::{BuiltToolNote, Files, ProcedureRequest};

/// Judges while the workspace is shown.
pub struct JudgedPlugin;

/// The newest status.
#[derive(Resource)]
pub struct Judged(Newest<JudgedKey, Found>);

/// Where the design stands, and what there is to know of the built tool's tables beside their figures.
struct Found {
    status: StepStatus,
    notes: Vec<String>,
}

/// What a status depends on.
#[derive(Clone, Debug, PartialEq)]
pub struct JudgedKey {
    pub generation: u64,
    pub revision: u64,
    /// Tables of the built tool, where others are looked at than those that it was decided on.
    pub recorded: Option<BuiltRecording>,
}

impl Judged {
    /// What was found last, and whether it is of the design as it is.
    pub fn found(&self) -> Option<(&StepStatus, bool)> {
        let (key, found) = self.0.found()?;
        Some((&found.status, self.0.requested() == Some(key)))
    }

    /// What there is to know of the built tool's tables.
    pub fn notes(&self) -> &[String] {
        self.0.found().map_or(&[], |(_, found)| &found.notes)
    }

    /// Whether nothing is computed or waits.
    pub fn is_idle(&self) -> bool {
        self.0.is_idle()
    }
}

impl FromWorld for Judged {
    fn from_world(world: &mut World) -> Self {
        let waker = world.get_resource_or_init::<Waker>().clone();
        Self(Newest::new("procedure", waker))
    }
}

impl Plugin for JudgedPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Judged>().add_systems(
            Update,
            request_then_receive(
                request.run_if(resource_exists::<OpenWorld>.and_then(is_shown)),
                receive.run_if(is_requested),
            ),
        );
    }
}

fn is_requested(judged: Res<Judged>) -> bool {
    judged.0.requested().is_some()
}

fn request(
    mut judged: ResMut<Judged>,
    mut state: ResMut<DecideState>,
    world: Res<OpenWorld>,
    generation: Res<WorldGeneration>,
    drag: Res<ActiveDrag>,
) {
    // Looked at in every frame, so nothing is copied before something changed.
    let is_requested = judged.0.requested().is_some_and(|key| {
        key.generation == generation.0
            && key.revision == world.0.document.revision()
            && key.recorded == state.recorded
    });
    if drag.0 || is_requested {
        return;
    }
    let key = JudgedKey {
        generation: generation.0,
        revision: world.0.document.revision(),
        recorded: state.recorded.clone(),
    };
    let is_other = (judged.0.requested()).is_some_and(|old| old.generation != key.generation);
    if is_other {
        judged.0.forget();
    }
    let open = world.0.clone();
    let wish = ProcedureRequest { recording: key.recorded.clone(), ..ProcedureRequest::default() };
    state.bypass_change_detection().counts.statuses += 1;
    judged.0.request(key, move |task, _| {
        let notes = RefCell::new(Vec::new());
        let note = |note: BuiltToolNote| notes.borrow_mut().push(note.to_string());
        let status =
            trackwright_project::procedure(&Files::default(), &open, &wish, task, &note).ok()?;
        let notes = notes.into_inner();
        Some(Found { status, notes })
    });
}

fn receive(mut judged: ResMut<Judged>) {
    if judged.bypass_change_detection().0.receive(|_| ()) {
        judged.set_changed();
    }
}
