//! The design as it is shown: the open one, with the tool where a trial has it, or with both bodies
//! where a tracker has them.

use crate::document::requests::OpenWorld;
use crate::document::state::WorldGeneration;
use crate::document::trials::{ModeKind, TrialChoice};
use crate::runner::results::Results;
use crate::schedule::EditorSystems;
use crate::shell::window::Workspace;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use std::collections::VecDeque;
use std::sync::Arc;
use trackwright_design::Design;
use trackwright_geometry::pose::Pose;
use trackwright_simulation::{InputTrial, trial_count, trial_offsets, trial_pose};

/// Keeps [`WantedTrial`] before and [`ShownDesign`] after [`EditorSystems::Solve`].
///
/// Whatever draws, picks or frames bodies reads [`ShownDesign`] instead of the document's own
/// design. Edits go to the document, which showing a trial does not change.
pub struct ShownPlugin;

/// When [`WantedTrial`] and [`ShownDesign`] follow.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ShownSystems {
    Want,
    Follow,
}

/// The design with the tool where the wanted trial has it, for the solver.
#[derive(Resource, Clone, Debug)]
pub struct WantedTrial {
    pub design: Arc<Design>,
    /// From 0; `None` for the design's own pose. Those of live poses begin at [`LIVE`].
    pub number: Option<usize>,
}

/// Where the tracker has the design's bodies: the newest that is known, as it is shown.
///
/// Counts as changed with every new pose.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct LivePoses {
    /// Of the poses, from 0; another number is other poses.
    pub number: usize,
    /// Compensated, in the tracker's frame; empty while nothing is received or shown.
    pub tool: Option<Pose>,
    pub crf: Option<Pose>,
}

impl LivePoses {
    pub fn is_any(&self) -> bool {
        self.tool.is_some() || self.crf.is_some()
    }
}

/// Where the numbers of live poses begin: beyond any trial's.
pub const LIVE: usize = 1 << 40;

/// Live poses whose errors are still computed: what is drawn is a few frames old at most.
const LIVE_PENDING: usize = 8;

/// Designs as they were wanted, by the number of their live poses.
#[derive(Resource, Debug, Default)]
struct LivePending(VecDeque<(usize, Arc<Design>)>);

/// The design as it is shown. Counts as changed whenever the open world does.
///
/// Another trial is shown once its errors are known: what is drawn of the tool and what is drawn
/// of its errors are never of two trials.
#[derive(Resource, Clone, Debug)]
pub struct ShownDesign {
    pub design: Arc<Design>,
    /// `None` where it is the design's own pose.
    pub trial: Option<ShownTrial>,
    /// The number of the live poses that it stands at.
    pub live: Option<usize>,
}

/// Which trial is shown.
#[derive(Clone, Debug, PartialEq)]
pub struct ShownTrial {
    /// From 0.
    pub number: usize,
    /// Trials that there are.
    pub of: usize,
    pub kind: ModeKind,
    /// How far it is from the design's own pose along the axes that move, mm or degrees.
    pub offsets: Vec<(&'static str, f64)>,
    pub pose: InputTrial,
}

impl Plugin for ShownPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<TrialChoice>()
            .init_resource::<LivePoses>()
            .init_resource::<LivePending>()
            .configure_sets(
                Update,
                (
                    ShownSystems::Want.after(EditorSystems::Edit).before(EditorSystems::Solve),
                    ShownSystems::Follow.after(EditorSystems::Solve).before(EditorSystems::Sample),
                ),
            )
            .add_systems(
                Update,
                (want.in_set(ShownSystems::Want), follow.in_set(ShownSystems::Follow)),
            );
    }
}

/// What is shown beside the design itself.
#[derive(SystemParam)]
struct LookedAt<'w> {
    workspace: Res<'w, Workspace>,
    live: Res<'w, LivePoses>,
    pending: ResMut<'w, LivePending>,
}

fn want(
    mut commands: Commands,
    world: Option<Res<OpenWorld>>,
    generation: Option<Res<WorldGeneration>>,
    mut choice: ResMut<TrialChoice>,
    looked_at: LookedAt,
    wanted: Option<Res<WantedTrial>>,
    mut last_generation: Local<Option<u64>>,
) {
    let Some(world) = world else { return };
    let LookedAt { workspace, live, mut pending } = looked_at;
    let is_live_shown = workspace.shows_live;
    let is_live = is_live_shown && live.is_any();
    let is_changed = world.is_changed()
        || choice.is_changed()
        || workspace.is_changed()
        || (is_live_shown && live.is_changed());
    if !(wanted.is_none() || is_changed) {
        return;
    }
    let generation = generation.map(|generation| generation.0);
    if last_generation.is_some() && *last_generation != generation {
        choice.forget_trials();
    }
    *last_generation = generation;
    if is_live {
        let number = LIVE + live.number;
        let design = world.0.document.design();
        let design = Arc::new(design.with_bodies_at(live.tool, live.crf));
        pending.0.retain(|(n, _)| *n != number);
        pending.0.push_back((number, Arc::clone(&design)));
        while pending.0.len() > LIVE_PENDING {
            pending.0.pop_front();
        }
        let number = Some(number);
        commands.insert_resource(WantedTrial { number, design });
        return;
    }
    pending.0.clear();
    let is_looked_at = workspace.shows_trials;
    if !is_looked_at && choice.playing.is_some() {
        choice.playing = None;
    }
    let trial = (choice.trial.filter(|_| is_looked_at))
        .and_then(|number| shown_trial(&world.0, &choice, number));
    if is_looked_at && trial.is_none() && choice.trial.is_some() {
        // An edit may leave fewer trials than there were.
        choice.show(None);
    }
    commands.insert_resource(WantedTrial {
        number: trial.as_ref().map(|trial| trial.number),
        design: posed(&world.0, trial.as_ref()),
    });
}

fn follow(
    mut commands: Commands,
    world: Option<Res<OpenWorld>>,
    wanted: Option<Res<WantedTrial>>,
    choice: Res<TrialChoice>,
    pending: Res<LivePending>,
    results: Res<Results>,
    shown: Option<ResMut<ShownDesign>>,
) {
    let (Some(world), Some(wanted)) = (world, wanted) else {
        return;
    };
    if wanted.number.is_some_and(|number| number >= LIVE) {
        let live = results.pose_trial.filter(|number| *number >= LIVE);
        let known = live.and_then(|number| pending.0.iter().find(|(n, _)| *n == number));
        // Until the first is known the design stands as it stood.
        if let (Some((number, design)), Some(mut shown)) = (known, shown)
            && (shown.live != Some(*number) || world.is_changed())
        {
            *shown = ShownDesign { design: Arc::clone(design), trial: None, live: Some(*number) };
        }
        return;
    }
    // While trials play, the wanted one is always one ahead of what is known.
    let number = (results.pose_trial)
        .filter(|number| *number < LIVE && wanted.number.is_some())
        .filter(|_| results.pose_serial == choice.serial());
    let is_current = shown.as_ref().is_some_and(|shown| {
        let now = shown.trial.as_ref().map(|trial| trial.number);
        !world.is_changed() && now == number && shown.live.is_none()
    });
    if is_current {
        return;
    }
    let trial = number.and_then(|number| shown_trial(&world.0, &choice, number));
    let new = ShownDesign { design: posed(&world.0, trial.as_ref()), trial, live: None };
    match shown {
        Some(mut shown) => *shown = new,
        None => commands.insert_resource(new),
    }
}

fn shown_trial(
    world: &trackwright_project::World,
    choice: &TrialChoice,
    number: usize,
) -> Option<ShownTrial> {
    let design = world.document.design();
    let kind = choice.kind(design.motion.is_some());
    if kind == ModeKind::Single {
        return None;
    }
    let scenario = trackwright_project::resolve(design, &world.environment);
    let mode = choice.mode(&scenario);
    Some(ShownTrial {
        number,
        of: trial_count(&scenario, &mode)?,
        kind,
        offsets: trial_offsets(&scenario, &mode, number),
        pose: trial_pose(&scenario, &mode, number)?,
    })
}

fn posed(world: &trackwright_project::World, trial: Option<&ShownTrial>) -> Arc<Design> {
    let Some(trial) = trial else {
        return world.document.shared_design();
    };
    let mut posed = world.document.design().clone();
    posed.tool.crf_from_tool = trial.pose.crf_from_tool;
    if let (Some(crf), Some(tracker_from_crf)) = (&mut posed.crf, trial.pose.tracker_from_crf) {
        crf.tracker_from_crf = tracker_from_crf;
    }
    Arc::new(posed)
}
