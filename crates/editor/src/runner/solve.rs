//! Hands changed designs to the solver and shows what comes back, never an older result over a
//! newer one.

use crate::document::requests::{ActiveDrag, OpenWorld};
use crate::document::shown::{LIVE, WantedTrial};
use crate::document::state::WorldGeneration;
use crate::document::trials::{ModeKind, TrialChoice};
use crate::runner::diagnostics::{Diagnostics, Explain};
use crate::runner::jobs::{JobInfo, Runner};
use crate::runner::results::{Results, Stamped};
use crate::runner::solved::{Extent, PoseWish, SliceWish, Solved, StudyOf, StudyWish};
use crate::runner::wake::Waker;
use crate::schedule::EditorSystems;
use crate::shell::window::Workspace;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use std::sync::Arc;
use std::time::Duration;
use trackwright_design::view::View;
use trackwright_field::Environment;
pub use trackwright_scene::slice_plan;
use trackwright_simulation::preview::preview;
use trackwright_simulation::{CancelToken, Quantity, SlicePlan, StudyError};

/// How long a running study is left alone although a newer one waits: short studies then finish
/// while the hand moves, and their figures follow it instead of standing still until it rests.
pub const PATIENCE: Duration = Duration::from_millis(100);

/// What a result belongs to. Generations count the worlds that were opened.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Stamp {
    pub generation: u64,
    pub revision: u64,
}

/// Computes in the background what the open design comes to.
///
/// Runs in [`EditorSystems::Solve`]; needs [`OpenWorld`], and does nothing until there is one.
pub struct SolverPlugin;

/// Systems that hand over work and show what comes back.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct SolverSystems;

/// The solver, and what was requested of it last.
#[derive(Resource)]
pub struct SolverHandle {
    pub solver: Runner<Stamp, Solved>,
    submitted: Option<Submitted>,
    /// The room that was submitted last.
    room: Option<Arc<Environment>>,
    slice: Option<SliceKey>,
    newest: Newest,
}

/// What pose and study were requested last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Submitted {
    stamp: Stamp,
    wish: PoseWish,
    extent: Extent,
    /// Whether the study is kept trial by trial.
    profile: bool,
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
    wish: SliceWish,
    /// The design's, for a quantity that depends on it.
    revision: Option<u64>,
}

impl PartialEq for SliceKey {
    fn eq(&self, other: &Self) -> bool {
        self.generation == other.generation
            && Arc::ptr_eq(&self.environment, &other.environment)
            && self.wish == other.wish
            && self.revision == other.revision
    }
}

/// Kinds of work, the first first: a pose is cheap, and the hand feels it.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Pose,
    Study,
    Slice,
}

impl SolverHandle {
    /// States why there are no figures, in the place of those of before.
    fn has_no_figures(&mut self, problem: String, results: &mut ResMut<Results>) {
        if self.submitted.is_none() && results.problem.as_ref() == Some(&problem) {
            return;
        }
        for kind in [Kind::Pose, Kind::Study, Kind::Slice] {
            self.solver.give_up(kind as u8);
        }
        (self.submitted, self.room, self.slice) = (None, None, None);
        **results = Results { problem: Some(problem), ..Results::default() };
    }

    fn submit(
        &mut self,
        kind: Kind,
        stamp: Stamp,
        work: impl FnOnce(&CancelToken) -> Solved + Send + 'static,
    ) {
        let is_same_world = self.submitted.is_none_or(|s| s.stamp.generation == stamp.generation);
        let patience = match kind {
            Kind::Study if is_same_world => PATIENCE,
            _ => Duration::ZERO,
        };
        let info = JobInfo { kind: kind as u8, patience, ..JobInfo::default() };
        self.solver.submit(info, stamp, Box::new(move |task, _| Some(work(&task.cancel))));
    }
}

impl Plugin for SolverPlugin {
    fn build(&self, app: &mut App) {
        let waker = app.world_mut().get_resource_or_init::<Waker>().clone();
        app.insert_resource(SolverHandle {
            solver: Runner::new("solver", waker),
            submitted: None,
            room: None,
            slice: None,
            newest: Newest::default(),
        })
        // Answers are shown before new work is handed over: what a frame shows then never
        // depends on whether a short job was faster than the frame that requested it.
        .add_systems(
            Update,
            (show, submit).chain().in_set(SolverSystems).in_set(EditorSystems::Solve),
        );
    }
}

/// What is wanted, and in which workspace.
#[derive(SystemParam)]
struct Wishes<'w> {
    choice: Res<'w, TrialChoice>,
    wanted: Option<Res<'w, WantedTrial>>,
    workspace: Res<'w, Workspace>,
}

fn submit(
    mut handle: ResMut<SolverHandle>,
    world: Option<Res<OpenWorld>>,
    generation: Res<WorldGeneration>,
    drag: Res<ActiveDrag>,
    wishes: Wishes,
    mut results: ResMut<Results>,
) {
    let Some(world) = world else { return };
    if let Some(problem) = world.0.metal_problem() {
        handle.has_no_figures(problem.to_string(), &mut results);
        return;
    }
    let environment = &world.0.environment;
    let is_room_same = handle.room.as_ref().is_some_and(|room| Arc::ptr_eq(room, environment));
    if world.0.awaited_metal().is_some() && is_room_same {
        // Figures in the room as it was would be replaced at once.
        return;
    }
    handle.room = Some(Arc::clone(environment));
    let Wishes { choice, wanted, workspace } = wishes;
    let document = &world.0.document;
    let stamp = Stamp { generation: generation.0, revision: document.revision() };
    let trial = wanted.as_ref().and_then(|wanted| wanted.number);
    let wish = PoseWish {
        scatter: document.view().layers.tip_scatter && world.0.environment.jitter.is_some(),
        // Only the Study workspace lists them, of the trial that it shows.
        sources: trial.is_some_and(|number| number < LIVE),
        trial,
        serial: choice.serial(),
    };
    let profile = workspace.charts_trials;
    let last = handle.submitted;
    let is_new = last.is_none_or(|s| s.stamp != stamp);
    let is_wish_new = last.is_none_or(|s| s.wish != wish);
    let is_study_new = last.is_none_or(|s| s.wish.serial != wish.serial || (profile && !s.profile));
    if !profile && last.is_some_and(|s| s.profile) {
        // What is not looked at is not kept.
        results.profile = None;
    }
    // The preview of a drag that has ended gives way to the whole.
    // After Escape the button may still be down, and nothing moves any more.
    let is_moving = drag.0 && document.is_in_step();
    let is_preview_old =
        !is_moving && last.is_some_and(|s| matches!(s.extent, Extent::PreviewOf(_)));
    let key = slice_key(stamp, &world.0.environment, document.view());
    let is_slice_new = handle.slice != key;
    let is_run = is_new || is_study_new || is_preview_old;
    if !(is_run || is_wish_new || is_slice_new) {
        if let Some(submitted) = &mut handle.submitted {
            submitted.profile = profile;
        }
        return;
    }
    let scenario = Arc::new(trackwright_project::resolve(document.design(), &world.0.environment));
    if last.is_some_and(|s| s.stamp.generation != stamp.generation) {
        *results = Results::default();
        handle.newest = Newest::default();
    }
    if is_new || is_wish_new {
        let posed = match (&wanted, wish.trial) {
            (Some(wanted), Some(_)) => {
                Arc::new(trackwright_project::resolve(&wanted.design, &world.0.environment))
            }
            _ => Arc::clone(&scenario),
        };
        handle.submit(Kind::Pose, stamp, move |_| Solved::pose(&posed, wish));
    }
    let mut extent = last.map_or(Extent::Whole, |s| s.extent);
    if is_run {
        let kind = choice.kind(scenario.motion.is_some());
        let is_previewed = is_moving && kind == ModeKind::Motion;
        let part = is_previewed.then(|| preview(&scenario)).flatten();
        let (mode, whole) = match part {
            Some(part) => (part.mode, Extent::PreviewOf(part.whole_trials)),
            None => (choice.mode(&scenario), Extent::Whole),
        };
        extent = whole;
        let wish = StudyWish {
            mode,
            of: StudyOf { kind, extent },
            // A preview's trials are not those of the whole.
            profile: profile && extent == Extent::Whole,
        };
        let of = Arc::clone(&scenario);
        handle.submit(Kind::Study, stamp, move |cancel| Solved::study(&of, &wish, cancel));
    }
    handle.submitted = Some(Submitted { stamp, wish, extent, profile });
    if is_slice_new {
        match &key {
            Some(key) => {
                let wish = key.wish;
                handle.submit(Kind::Slice, stamp, move |cancel| {
                    Solved::slice(&scenario, &wish, cancel)
                });
            }
            None => {
                // A layer that is off costs nothing, not even the memory of its map.
                handle.solver.give_up(Kind::Slice as u8);
                results.slice = None;
            }
        }
        handle.slice = key;
    }
}

fn slice_key(stamp: Stamp, environment: &Arc<Environment>, view: &View) -> Option<SliceKey> {
    view.layers.slice.then(|| SliceKey {
        generation: stamp.generation,
        environment: Arc::clone(environment),
        wish: SliceWish {
            plan: slice_plan(environment, &view.slice),
            quantity: view.slice.quantity,
            support: view.layers.support && environment.has_validity(),
        },
        revision: view.slice.quantity.needs_tool().then_some(stamp.revision),
    })
}

fn show(
    mut handle: ResMut<SolverHandle>,
    world: Option<Res<OpenWorld>>,
    generation: Res<WorldGeneration>,
    mut results: ResMut<Results>,
    mut diagnostics: ResMut<Diagnostics>,
    mut explain: Option<ResMut<Explain>>,
) {
    // Of a room whose metal cannot be where it is now there are none.
    let has_problem = world.is_some_and(|world| world.0.metal_problem().is_some());
    for answer in handle.solver.answers() {
        if has_problem {
            diagnostics.dropped += 1;
            continue;
        }
        let (stamp, took) = (answer.key, answer.took);
        let solved = match answer.value {
            Ok(solved) => solved,
            Err(lost) => {
                results.problem = Some(lost.to_string());
                continue;
            }
        };
        let wanted = Wanted {
            slice: (handle.slice.as_ref()).map(|key| (key.wish.plan, key.wish.quantity)),
            profile: handle.submitted.is_some_and(|s| s.profile),
        };
        let is_study = matches!(solved, Solved::Study(Ok(_), _));
        count(&solved, &mut diagnostics);
        let is_shown = stamp.generation == generation.0
            && accept(solved, stamp.revision, took, wanted, &mut handle.newest, &mut results);
        if !is_shown {
            diagnostics.dropped += 1;
        }
        if let Some(explain) = explain.as_deref_mut() {
            if is_shown
                && is_study
                && let Some(study) = &results.study
            {
                explain.figures(stamp.revision, &study.value.figures);
            }
            explain.counters(&diagnostics);
        }
    }
}

fn count(solved: &Solved, diagnostics: &mut Diagnostics) {
    match solved {
        Solved::Pose(solved, _) => {
            diagnostics.poses += 1;
            diagnostics.work += solved.detail.work;
            if let Some(Ok(scatter)) = &solved.scatter {
                diagnostics.work += scatter.work;
            }
        }
        Solved::Study(Ok((value, profile)), _) => {
            diagnostics.studies += 1;
            diagnostics.profiles += u64::from(profile.is_some());
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

/// What is wanted now, whatever it was when an answer was requested.
struct Wanted {
    slice: Option<(SlicePlan, Quantity)>,
    profile: bool,
}

/// Takes an answer unless a newer one is shown.
fn accept(
    solved: Solved,
    revision: u64,
    took: Duration,
    wanted: Wanted,
    newest: &mut Newest,
    results: &mut Results,
) -> bool {
    let stamped_is_new = |newest: &mut u64| {
        let is_new = revision >= *newest;
        *newest = revision.max(*newest);
        is_new
    };
    match solved {
        Solved::Pose(solved, wish) => {
            let is_new = stamped_is_new(&mut newest.pose);
            if is_new {
                results.scatter = solved.scatter;
                results.sources = solved.sources;
                results.pose_trial = wish.trial;
                results.pose_serial = wish.serial;
                results.pose = Some(Stamped { revision, value: solved.detail, took });
            }
            is_new
        }
        Solved::Study(Err(StudyError::Cancelled), _) | Solved::Slice(Err(_), _) => false,
        Solved::Study(result, of) => {
            let is_new = stamped_is_new(&mut newest.study);
            if is_new {
                results.extent = Some(of.extent);
                results.mode = Some(of.kind);
                results.problem = result.as_ref().err().map(ToString::to_string);
                let (study, profile) = result.ok().unzip();
                // A preview leaves the profile as it was: it has none of its own.
                if of.extent == Extent::Whole {
                    let profile = profile.flatten().filter(|_| wanted.profile);
                    results.profile =
                        profile.map(|value| Stamped { revision, value: *value, took });
                }
                results.study = study.map(|value| Stamped { revision, value: *value, took });
            }
            is_new
        }
        Solved::Slice(Ok(None), quantity) => {
            let is_wanted = wanted.slice.is_some_and(|(_, q)| q == quantity);
            if is_wanted {
                results.slice = None;
            }
            is_wanted
        }
        Solved::Slice(Ok(Some(value)), quantity) => {
            let is_wanted = wanted.slice == Some((value.plan, quantity));
            if is_wanted {
                results.slice = Some(Stamped { revision, value: *value, took });
            }
            is_wanted
        }
    }
}
