//! Holds the open design against the baseline in its room: once edits rest, with what of each difference
//! is one; while a hand moves something, by their figures alone.

use super::desk::DecideDesk;
use super::is_shown;
use crate::editor::document::WorldGeneration;
use crate::editor::layers::latest::Latest;
use crate::editor::state::{ActiveDrag, EditorSystems, OpenWorld};
use crate::editor::wake::Waker;
use crate::field::OutsidePolicy;
use crate::store;
use crate::study::comparison::{Comparison, Settings, compare};
use crate::study::{PoseDetail, look};
use bevy::prelude::*;
use std::sync::Arc;

/// Compares while the workspace is shown and something is pinned.
pub struct AgainstPlugin;

/// The newest comparison with the baseline.
#[derive(Resource)]
pub struct Against {
    latest: Latest<Found>,
    key: Option<Key>,
    found: Option<Found>,
}

/// What a comparison hangs on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key {
    pub generation: u64,
    pub revision: u64,
    /// Of the pinned design.
    pub serial: u64,
}

/// The baseline in the design's room, and the design against it.
#[derive(Clone, Debug)]
pub struct Found {
    pub key: Key,
    /// Row 0 is the baseline, row 1 the design.
    pub comparison: Comparison,
    /// The baseline at its own pose.
    pub pose: PoseDetail,
}

impl Against {
    /// What was found last for this baseline, perhaps of an older state of the design.
    pub fn found(&self, serial: u64) -> Option<&Found> {
        self.found.as_ref().filter(|f| f.key.serial == serial)
    }

    /// Whether nothing is computed or waits.
    pub fn is_idle(&self) -> bool {
        self.latest.is_idle()
    }
}

impl FromWorld for Against {
    fn from_world(world: &mut World) -> Self {
        let waker = world.get_resource_or_init::<Waker>().clone();
        Self {
            latest: Latest::new("baseline", waker),
            key: None,
            found: None,
        }
    }
}

impl Plugin for AgainstPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Against>()
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

fn is_asked(against: Res<Against>) -> bool {
    against.key.is_some()
}

fn ask(
    mut against: ResMut<Against>,
    mut desk: ResMut<DecideDesk>,
    world: Res<OpenWorld>,
    generation: Res<WorldGeneration>,
    drag: Res<ActiveDrag>,
) {
    let Some(pinned) = &desk.pinned else {
        if against.key.is_some() {
            against.latest.give_up();
            against.key = None;
            against.found = None;
        }
        return;
    };
    let key = Key {
        generation: generation.0,
        revision: world.0.document.revision(),
        serial: pinned.serial,
    };
    if drag.0 || against.bypass_change_detection().key == Some(key) {
        return;
    }
    against.key = Some(key);
    let designs = [
        Arc::clone(&pinned.design),
        Arc::new(world.0.document.design().clone()),
    ];
    let environment = Arc::clone(&world.0.environment);
    let work = move |task: &crate::task::Task, found: &mut dyn FnMut(Found)| {
        let pose = look(&store::resolve(&designs[0], &environment));
        let plan = store::comparison_plan(
            &[&designs[0], &designs[1]],
            vec![environment],
            |_| vec![0],
            0,
            OutsidePolicy::default(),
        );
        // Given up: the wish that took its place is answered.
        if let Ok(comparison) = compare(&plan, &Settings::default(), task) {
            found(Found {
                key,
                comparison,
                pose,
            });
        }
    };
    desk.counts.baselines += 1;
    if let Err(error) = against.latest.wish(Box::new(work)) {
        warn!("no thread for the comparison with the baseline: {error}");
    }
}

fn hear(mut against: ResMut<Against>) {
    let answers = against.bypass_change_detection().latest.answers();
    if let Some(found) = answers.into_iter().next_back() {
        against.found = Some(found);
    }
}
