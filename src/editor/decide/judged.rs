//! Where the design stands in its procedure: every step in every room, computed anew once edits rest.

use super::desk::DecideDesk;
use super::is_shown;
use crate::editor::document::WorldGeneration;
use crate::editor::layers::latest::Latest;
use crate::editor::state::{ActiveDrag, EditorSystems, OpenWorld};
use crate::editor::wake::Waker;
use crate::store::{self, ProcedureWish};
use crate::study::agreement::BuiltRecording;
use crate::study::procedure::Standing;
use crate::task::Task;
use bevy::prelude::*;

/// Judges while the workspace is shown.
pub struct JudgedPlugin;

/// The newest standing.
#[derive(Resource)]
pub struct Judged {
    latest: Latest<(JudgedKey, Standing)>,
    key: Option<JudgedKey>,
    found: Option<(JudgedKey, Standing)>,
}

/// What a standing hangs on.
#[derive(Clone, Debug, PartialEq)]
pub struct JudgedKey {
    pub generation: u64,
    pub revision: u64,
    /// Tables of the built tool, where others are looked at than those that it was decided on.
    pub recorded: Option<BuiltRecording>,
}

impl Judged {
    /// What was found last, and whether it is of the design as it is.
    pub fn found(&self) -> Option<(&Standing, bool)> {
        let (key, standing) = self.found.as_ref()?;
        Some((standing, self.key.as_ref() == Some(key)))
    }

    /// Whether nothing is computed or waits.
    pub fn is_idle(&self) -> bool {
        self.latest.is_idle()
    }
}

impl FromWorld for Judged {
    fn from_world(world: &mut World) -> Self {
        let waker = world.get_resource_or_init::<Waker>().clone();
        Self {
            latest: Latest::new("procedure", waker),
            key: None,
            found: None,
        }
    }
}

impl Plugin for JudgedPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Judged>()
            .init_resource::<ActiveDrag>()
            .add_systems(
                Update,
                (
                    ask.run_if(resource_exists::<OpenWorld>.and_then(is_shown)),
                    hear.run_if(is_asked),
                )
                    .chain()
                    .in_set(EditorSystems::Solve),
            );
    }
}

fn is_asked(judged: Res<Judged>) -> bool {
    judged.key.is_some()
}

fn ask(
    mut judged: ResMut<Judged>,
    mut desk: ResMut<DecideDesk>,
    world: Res<OpenWorld>,
    generation: Res<WorldGeneration>,
    drag: Res<ActiveDrag>,
) {
    let key = JudgedKey {
        generation: generation.0,
        revision: world.0.document.revision(),
        recorded: desk.recorded.clone(),
    };
    if drag.0 || judged.bypass_change_detection().key.as_ref() == Some(&key) {
        return;
    }
    let is_other = judged
        .key
        .as_ref()
        .is_some_and(|old| old.generation != key.generation);
    if is_other {
        judged.found = None;
    }
    judged.key = Some(key.clone());
    let open = world.0.clone();
    let work = move |task: &Task, found: &mut dyn FnMut((JudgedKey, Standing))| {
        let wish = ProcedureWish {
            recording: key.recorded.clone(),
            ..ProcedureWish::default()
        };
        // What there is to know of tables beside their figures is the command's to print.
        let standing = store::procedure(&open, &wish, task, &|_| ());
        // Given up: the wish that took its place is answered.
        if let Ok(standing) = standing {
            found((key, standing));
        }
    };
    desk.bypass_change_detection().counts.standings += 1;
    if let Err(error) = judged.latest.wish(Box::new(work)) {
        warn!("no thread for the procedure: {error}");
    }
}

fn hear(mut judged: ResMut<Judged>) {
    let answers = judged.bypass_change_detection().latest.answers();
    if let Some(found) = answers.into_iter().next_back() {
        judged.found = Some(found);
    }
}
