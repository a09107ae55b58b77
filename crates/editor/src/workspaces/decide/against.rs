//! Holds the open design against the baseline in its room: once edits rest, with what of each difference
//! is one; while a hand moves something, by their figures alone.

use crate::document::requests::{ActiveDrag, OpenWorld};
use crate::document::state::WorldGeneration;
use crate::runner::jobs::Newest;
use crate::runner::wake::Waker;
use crate::schedule::request_then_receive;
use crate::workspaces::decide::requests::is_shown;
use crate::workspaces::decide::state::DecideState;
use bevy::prelude::*;
use std::sync::Arc;
use trackwright_design::Design;
use trackwright_field::OutsidePolicy;
use trackwright_simulation::comparison::{Comparison, Settings, compare};
use trackwright_simulation::{PoseDetail, simulate_pose};

/// Compares while the workspace is shown and something is pinned.
pub struct AgainstPlugin;

/// The newest comparison with the baseline.
#[derive(Resource)]
pub struct Against(Newest<Key, Found>);

/// What a comparison depends on.
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
    /// Row 0 is the baseline, row 1 the design.
    pub comparison: Comparison,
    /// The design as it was compared.
    pub design: Arc<Design>,
    /// The baseline at its own pose.
    pub pose: PoseDetail,
}

impl Against {
    /// What was found last for this baseline, perhaps of an older state of the design.
    pub fn found(&self, serial: u64) -> Option<(Key, &Found)> {
        let (key, found) = self.0.found()?;
        (key.serial == serial).then_some((*key, found))
    }

    /// Whether nothing is computed or waits.
    pub fn is_idle(&self) -> bool {
        self.0.is_idle()
    }
}

impl FromWorld for Against {
    fn from_world(world: &mut World) -> Self {
        let waker = world.get_resource_or_init::<Waker>().clone();
        Self(Newest::new("baseline", waker))
    }
}

impl Plugin for AgainstPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Against>().add_systems(
            Update,
            request_then_receive(
                request.run_if(resource_exists::<OpenWorld>.and_then(is_shown)),
                receive.run_if(is_requested),
            ),
        );
    }
}

fn is_requested(against: Res<Against>) -> bool {
    against.0.requested().is_some()
}

fn request(
    mut against: ResMut<Against>,
    mut state: ResMut<DecideState>,
    world: Res<OpenWorld>,
    generation: Res<WorldGeneration>,
    drag: Res<ActiveDrag>,
) {
    let Some(pinned) = &state.pinned else {
        if against.0.requested().is_some() {
            against.0.give_up();
        }
        return;
    };
    let key = Key {
        generation: generation.0,
        revision: world.0.document.revision(),
        serial: pinned.serial,
    };
    if drag.0 || against.0.requested() == Some(&key) {
        return;
    }
    let designs = [Arc::clone(&pinned.design), Arc::new(world.0.document.design().clone())];
    let environment = Arc::clone(&world.0.environment);
    state.counts.baselines += 1;
    against.0.request(key, move |task, _| {
        let pose = simulate_pose(&trackwright_project::resolve(&designs[0], &environment));
        let plan = trackwright_project::comparison_plan(
            &[&designs[0], &designs[1]],
            vec![environment],
            |_| vec![0],
            0,
            OutsidePolicy::default(),
        );
        let comparison = compare(&plan, &Settings::default(), task).ok()?;
        let [_, design] = designs;
        Some(Found { comparison, design, pose })
    });
}

fn receive(mut against: ResMut<Against>) {
    if against.bypass_change_detection().0.receive(|_| ()) {
        against.set_changed();
    }
}
