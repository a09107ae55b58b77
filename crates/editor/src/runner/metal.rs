//! Solves for the metal of the open design's room, on a thread of its own, and puts the room that it makes
//! in the place of the one before.
//!
//! While a hand moves metal there is always a newer place of it; what was solved for is shown all the same,
//! so that figures follow the hand.

use crate::document::requests::OpenWorld;
use crate::document::state::WorldGeneration;
use crate::runner::diagnostics::{Diagnostics, Explain};
use crate::runner::jobs::{JobInfo, Runner};
use crate::runner::solve::{PATIENCE, SolverSystems};
use crate::runner::wake::Waker;
use crate::schedule::EditorSystems;
use bevy::prelude::*;
use std::sync::{Arc, Mutex, PoisonError};
use trackwright_metal::furnished::Furnisher;
use trackwright_metal::setup::RoomMetal;
use trackwright_project::MetalAnswer;

/// Solves for metal in the background.
///
/// Runs in [`EditorSystems::Solve`]; needs [`OpenWorld`], and does nothing in rooms without metal.
pub struct MetalPlugin;

/// The thread, what it keeps, and what was requested of it last.
#[derive(Resource)]
pub struct MetalSolver {
    runner: Runner<u64, MetalAnswer>,
    furnisher: Arc<Mutex<Furnisher>>,
    requested: Option<Requested>,
}

#[derive(PartialEq)]
struct Requested {
    generation: u64,
    metal: Option<Arc<RoomMetal>>,
}

impl Plugin for MetalPlugin {
    fn build(&self, app: &mut App) {
        let waker = app.world_mut().get_resource_or_init::<Waker>().clone();
        app.insert_resource(MetalSolver {
            runner: Runner::new("metal", waker),
            furnisher: Arc::default(),
            requested: None,
        })
        .add_systems(
            Update,
            (receive, request)
                .chain()
                .in_set(EditorSystems::Solve)
                .before(SolverSystems)
                .run_if(resource_exists::<OpenWorld>),
        );
    }
}

fn receive(
    solver: Res<MetalSolver>,
    generation: Res<WorldGeneration>,
    mut world: ResMut<OpenWorld>,
    mut diagnostics: ResMut<Diagnostics>,
    mut explain: Option<ResMut<Explain>>,
) {
    for answer in solver.runner.answers() {
        let Ok(value) = answer.value else { continue };
        if answer.key != generation.0 || !world.0.receive_metal(value) {
            continue;
        }
        diagnostics.rooms += 1;
        if let Some(explain) = explain.as_deref_mut() {
            let problem = world.0.metal_problem().map(ToString::to_string);
            let revision = world.0.document.revision();
            explain.line(&match problem {
                Some(problem) => format!("room revision={revision} problem={problem:?}"),
                None => format!("room revision={revision} solved"),
            });
        }
    }
}

fn request(
    mut solver: ResMut<MetalSolver>,
    generation: Res<WorldGeneration>,
    world: Res<OpenWorld>,
) {
    let Some(awaited) = world.0.awaited_metal() else {
        return;
    };
    let metal = world.0.document.design().room_metal.clone();
    let requested = Requested { generation: generation.0, metal };
    if solver.requested.as_ref() == Some(&requested) {
        return;
    }
    solver.requested = Some(requested);
    let furnisher = Arc::clone(&solver.furnisher);
    // One that runs is left to end: what it finds is shown while the hand moves on.
    let info = JobInfo { patience: PATIENCE, ..JobInfo::default() };
    let work = Box::new(move |task: &trackwright_task::Task, _: &mut dyn FnMut(MetalAnswer)| {
        let mut furnisher = furnisher.lock().unwrap_or_else(PoisonError::into_inner);
        awaited.solve(&mut furnisher, task)
    });
    solver.runner.submit(info, generation.0, work);
}
