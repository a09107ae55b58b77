//! The design as it is shown: the open one, or with the tool where a trial has it.

use super::desk::{ModeKind, StudyDesk};
use crate::design::Design;
use crate::editor::document::WorldGeneration;
use crate::editor::state::{EditorSystems, OpenWorld, Workspace};
use crate::store;
use crate::study::{InputTrial, trial_count, trial_offsets, trial_pose};
use bevy::prelude::*;
use std::sync::Arc;

/// Keeps [`ShownDesign`], between [`EditorSystems::Edit`] and [`EditorSystems::Solve`].
///
/// Whatever draws, picks or frames bodies reads it instead of the document's own design. Edits go
/// to the document, which showing a trial does not change.
pub struct ShownPlugin;

/// When [`ShownDesign`] follows.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ShownSystems;

/// The design as it is shown. Counts as changed whenever the open world does.
#[derive(Resource, Clone, Debug)]
pub struct ShownDesign {
    pub design: Arc<Design>,
    /// `None` where it is the design's own pose.
    pub trial: Option<ShownTrial>,
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
        app.init_resource::<StudyDesk>()
            .init_resource::<Workspace>()
            .configure_sets(
                Update,
                ShownSystems
                    .after(EditorSystems::Edit)
                    .before(EditorSystems::Solve),
            )
            .add_systems(Update, keep.in_set(ShownSystems));
    }
}

fn keep(
    mut commands: Commands,
    world: Option<Res<OpenWorld>>,
    generation: Option<Res<WorldGeneration>>,
    workspace: Res<Workspace>,
    mut desk: ResMut<StudyDesk>,
    shown: Option<ResMut<ShownDesign>>,
    mut last_generation: Local<Option<u64>>,
) {
    let Some(world) = world else { return };
    if !(shown.is_none() || world.is_changed() || desk.is_changed() || workspace.is_changed()) {
        return;
    }
    let generation = generation.map(|generation| generation.0);
    if last_generation.is_some() && *last_generation != generation {
        desk.forget_trials();
    }
    *last_generation = generation;
    let is_looked_at = *workspace == Workspace::Study;
    if !is_looked_at && desk.playing.is_some() {
        desk.playing = None;
    }
    let trial = desk.trial.filter(|_| is_looked_at).and_then(|number| {
        let trial = shown_trial(&world.0, &desk, number);
        if trial.is_none() {
            // An edit may leave fewer trials than there were.
            desk.show(None);
        }
        trial
    });
    let document = &world.0.document;
    let new = ShownDesign {
        design: match &trial {
            None => document.shared_design(),
            Some(trial) => Arc::new(posed(document.design(), &trial.pose)),
        },
        trial,
    };
    match shown {
        None => commands.insert_resource(new),
        Some(mut shown) if world.is_changed() || shown.trial != new.trial => *shown = new,
        Some(_) => {}
    }
}

fn shown_trial(world: &store::World, desk: &StudyDesk, number: usize) -> Option<ShownTrial> {
    let design = world.document.design();
    let kind = desk.kind(design.motion.is_some());
    if kind == ModeKind::Single {
        return None;
    }
    let scenario = store::resolve(design, &world.environment);
    let mode = desk.mode(&scenario);
    Some(ShownTrial {
        number,
        of: trial_count(&scenario, &mode)?,
        kind,
        offsets: trial_offsets(&scenario, &mode, number),
        pose: trial_pose(&scenario, &mode, number)?,
    })
}

fn posed(design: &Design, pose: &InputTrial) -> Design {
    let mut posed = design.clone();
    posed.tool.crf_from_tool = pose.crf_from_tool;
    if let (Some(crf), Some(tracker_from_crf)) = (&mut posed.crf, pose.tracker_from_crf) {
        crf.tracker_from_crf = tracker_from_crf;
    }
    posed
}
