//! Hands changed designs to the solver and shows what comes back, never an older result over a
//! newer one.

use super::diagnostics::{Diagnostics, Explain};
use super::document::WorldGeneration;
use super::solver::{Answer, Extent, Job, PoseWish, Solved, Solver, Stamp};
use super::state::{ActiveDrag, EditorSystems, OpenWorld, Results, Stamped};
use super::wake::Waker;
use crate::design::view::{SliceView, View};
use crate::field::Environment;
use crate::store;
use crate::study::preview::preview;
use crate::study::{Mode, Quantity, Scenario, SlicePlan, SlicePlane, StudyError, figure_rows};
use bevy::prelude::*;
use nalgebra::{Unit, Vector3};
use std::sync::Arc;

/// Points of the slice along the longer side of the model's box.
pub const SLICE_POINTS: usize = 81;

/// Computes in the background what the open design comes to.
///
/// Runs in [`EditorSystems::Solve`]; needs [`OpenWorld`], and does nothing until there is one.
pub struct SolverPlugin;

/// The solver thread, and what it was asked for last.
#[derive(Resource)]
pub struct SolverHandle {
    pub solver: Solver,
    submitted: Option<Submitted>,
    slice: Option<SliceKey>,
    newest: Newest,
}

/// What pose and study were last asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Submitted {
    stamp: Stamp,
    wish: PoseWish,
    extent: Extent,
}

/// The revisions of the newest pose and study that were answered, errors included.
#[derive(Clone, Copy, Debug, Default)]
struct Newest {
    pose: u64,
    study: u64,
}

/// What a slice depends on: equal keys have equal slices.
#[derive(Clone, Debug)]
struct SliceKey {
    generation: u64,
    environment: Arc<Environment>,
    plan: SlicePlan,
    quantity: Quantity,
    /// The design's, for a quantity that hangs on it.
    revision: Option<u64>,
}

impl PartialEq for SliceKey {
    fn eq(&self, other: &Self) -> bool {
        self.generation == other.generation
            && Arc::ptr_eq(&self.environment, &other.environment)
            && self.plan == other.plan
            && self.quantity == other.quantity
            && self.revision == other.revision
    }
}

impl Plugin for SolverPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Diagnostics>()
            .init_resource::<Results>()
            .init_resource::<ActiveDrag>()
            .init_resource::<WorldGeneration>()
            .init_resource::<Waker>();
        match Solver::start() {
            Ok(solver) => {
                let waker = app.world().resource::<Waker>().clone();
                if waker.is_any() {
                    solver.wake_with(Box::new(move || waker.wake()));
                }
                app.insert_resource(SolverHandle {
                    solver,
                    submitted: None,
                    slice: None,
                    newest: Newest::default(),
                })
                // Answers are shown before new work is handed over: what a frame shows then never
                // hangs on whether a short job was faster than the frame that asked for it.
                .add_systems(Update, (show, submit).chain().in_set(EditorSystems::Solve));
            }
            Err(error) => {
                let problem = format!("cannot start the solver's thread: {error}");
                app.world_mut().resource_mut::<Results>().problem = Some(problem);
            }
        }
    }
}

fn submit(
    mut handle: ResMut<SolverHandle>,
    world: Option<Res<OpenWorld>>,
    generation: Res<WorldGeneration>,
    drag: Res<ActiveDrag>,
    mut results: ResMut<Results>,
) {
    let Some(world) = world else { return };
    let document = &world.0.document;
    let stamp = Stamp {
        generation: generation.0,
        revision: document.revision(),
    };
    let wish = PoseWish {
        scatter: document.view().layers.tip_scatter && world.0.environment.jitter.is_some(),
    };
    let last = handle.submitted;
    let is_new = last.is_none_or(|s| s.stamp != stamp);
    let is_wish_new = last.is_none_or(|s| s.wish != wish);
    // The preview of a drag that has ended gives way to the whole.
    let is_preview_old = !drag.0 && last.is_some_and(|s| matches!(s.extent, Extent::PreviewOf(_)));
    let key = slice_key(stamp, &world.0.environment, document.view());
    let is_slice_new = handle.slice != key;
    if !(is_new || is_wish_new || is_preview_old || is_slice_new) {
        return;
    }
    let scenario = Arc::new(store::resolve(document.design(), &world.0.environment));
    if last.is_some_and(|s| s.stamp.generation != stamp.generation) {
        *results = Results::default();
        handle.newest = Newest::default();
    }
    if is_new || is_wish_new {
        let job = Job::Pose(Arc::clone(&scenario), wish);
        handle.solver.submit(stamp, job);
    }
    let mut extent = last.map_or(Extent::Whole, |s| s.extent);
    if is_new || is_preview_old {
        let part = drag.0.then(|| preview(&scenario)).flatten();
        let study = match part {
            Some(part) => (part.mode, Extent::PreviewOf(part.whole_trials)),
            None => (mode(&scenario), Extent::Whole),
        };
        extent = study.1;
        let job = Job::Study(Arc::clone(&scenario), study.0, study.1);
        handle.solver.submit(stamp, job);
    }
    handle.submitted = Some(Submitted {
        stamp,
        wish,
        extent,
    });
    if is_slice_new {
        match &key {
            Some(key) => {
                let job = Job::Slice(scenario, key.plan, key.quantity);
                handle.solver.submit(stamp, job);
            }
            None => {
                // A layer that is off costs nothing, not even the memory of its map.
                handle.solver.drop_slice();
                results.slice = None;
            }
        }
        handle.slice = key;
    }
}

/// The study that the result panel is about: the range of motion where the design has one.
pub fn mode(scenario: &Scenario) -> Mode {
    match scenario.motion {
        Some(_) => Mode::Motion,
        None => Mode::Single,
    }
}

fn slice_key(stamp: Stamp, environment: &Arc<Environment>, view: &View) -> Option<SliceKey> {
    view.layers.slice.then(|| SliceKey {
        generation: stamp.generation,
        environment: Arc::clone(environment),
        plan: slice_plan(environment, &view.slice),
        quantity: view.slice.quantity,
        revision: view.slice.quantity.needs_tool().then_some(stamp.revision),
    })
}

/// The lattice of a slice: over the model's box, its cells as square as the counts allow.
pub fn slice_plan(environment: &Environment, slice: &SliceView) -> SlicePlan {
    let plane = SlicePlane::Across {
        normal_axis: slice.axis.index(),
        position_mm: slice.position_mm,
        bounds: *environment.model.bounds(),
    };
    SlicePlan {
        plane,
        sensor_axis: Unit::try_new(Vector3::from(slice.sensor_axis), 1e-12)
            .unwrap_or_else(Vector3::z_axis),
        counts: plane.square_counts(SLICE_POINTS),
    }
}

fn show(
    mut handle: ResMut<SolverHandle>,
    generation: Res<WorldGeneration>,
    mut results: ResMut<Results>,
    mut diagnostics: ResMut<Diagnostics>,
    mut explain: Option<ResMut<Explain>>,
) {
    for answer in handle.solver.answers() {
        let stamp = answer.stamp;
        let wanted = handle.slice.as_ref().map(|key| (key.plan, key.quantity));
        let is_study = matches!(answer.result, Solved::Study(Ok(_), _));
        count(&answer, &mut diagnostics);
        let is_shown = stamp.generation == generation.0
            && accept(answer, wanted, &mut handle.newest, &mut results);
        if !is_shown {
            diagnostics.dropped += 1;
        }
        if let Some(explain) = explain.as_deref_mut() {
            if is_shown
                && is_study
                && let Some(study) = &results.study
            {
                explain.figures(stamp.revision, &figure_rows(&study.value.figures));
            }
            explain.counters(&diagnostics);
        }
    }
}

fn count(answer: &Answer, diagnostics: &mut Diagnostics) {
    match &answer.result {
        Solved::Pose(value, scatter) => {
            diagnostics.poses += 1;
            diagnostics.work += value.work;
            if let Some(Ok(scatter)) = scatter.as_deref() {
                diagnostics.work += scatter.work;
            }
        }
        Solved::Study(Ok(value), _) => {
            diagnostics.studies += 1;
            diagnostics.work += value.work;
        }
        Solved::Study(Err(StudyError::Cancelled), _) => diagnostics.studies_cancelled += 1,
        Solved::Study(Err(_), _) | Solved::Slice(Err(_) | Ok(None), _) => {}
        Solved::Slice(Ok(Some(value)), _) => {
            diagnostics.slices += 1;
            diagnostics.work += value.work;
        }
    }
}

/// Takes an answer unless a newer one is shown; `wanted` is the slice that is wanted now.
fn accept(
    answer: Answer,
    wanted: Option<(SlicePlan, Quantity)>,
    newest: &mut Newest,
    results: &mut Results,
) -> bool {
    let revision = answer.stamp.revision;
    let took = answer.took;
    let stamped_is_new = |newest: &mut u64| {
        let is_new = revision >= *newest;
        *newest = revision.max(*newest);
        is_new
    };
    match answer.result {
        Solved::Pose(value, scatter) => {
            let is_new = stamped_is_new(&mut newest.pose);
            if is_new {
                results.scatter = scatter.map(|scatter| *scatter);
                results.pose = Some(Stamped {
                    revision,
                    value: *value,
                    took,
                });
            }
            is_new
        }
        Solved::Study(Err(StudyError::Cancelled), _) | Solved::Slice(Err(_), _) => false,
        Solved::Study(result, extent) => {
            let is_new = stamped_is_new(&mut newest.study);
            if is_new {
                results.extent = Some(extent);
                results.problem = result.as_ref().err().map(ToString::to_string);
                results.study = result.ok().map(|value| Stamped {
                    revision,
                    value,
                    took,
                });
            }
            is_new
        }
        Solved::Slice(Ok(None), quantity) => {
            let is_wanted = wanted.is_some_and(|(_, q)| q == quantity);
            if is_wanted {
                results.slice = None;
            }
            is_wanted
        }
        Solved::Slice(Ok(Some(value)), quantity) => {
            let is_wanted = wanted == Some((value.plan, quantity));
            if is_wanted {
                results.slice = Some(Stamped {
                    revision,
                    value,
                    took,
                });
            }
            is_wanted
        }
    }
}
