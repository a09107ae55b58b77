//! Why the requirement is missed: where the error of the study comes from, computed once edits rest.

use crate::document::requests::{ActiveDrag, OpenWorld};
use crate::document::state::WorldGeneration;
use crate::document::trials::TrialChoice;
use crate::runner::jobs::Newest;
use crate::runner::results::Results;
use crate::runner::wake::Waker;
use crate::schedule::EditorSystems;
use crate::workspaces::design::result::are_figures_old;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use trackwright_simulation::{ErrorSources, Verdict, error_sources};

/// Looks for the sources of the error while a bound is missed; nothing is computed elsewhere.
pub struct MissedPlugin;

/// The newest sources that were found.
#[derive(Resource)]
pub struct Missed(Newest<MissedKey, Option<ErrorSources>>);

/// What sources depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MissedKey {
    pub generation: u64,
    pub revision: u64,
    /// Of the trials.
    pub serial: u64,
}

impl Missed {
    /// The sources of the error of the study that is shown, where they are known.
    pub fn sources(&self) -> Option<&ErrorSources> {
        let (key, found) = self.0.found()?;
        found.as_ref().filter(|_| self.0.requested() == Some(key))
    }

    /// Whether nothing is computed or waits.
    pub fn is_idle(&self) -> bool {
        self.0.is_idle()
    }

    /// Whether what was requested is there, if anything was.
    pub fn is_answered(&self) -> bool {
        self.0.requested() == self.0.found().map(|(key, _)| key)
    }
}

impl FromWorld for Missed {
    fn from_world(world: &mut World) -> Self {
        let waker = world.get_resource_or_init::<Waker>().clone();
        Self(Newest::new("sources of the error", waker))
    }
}

impl Plugin for MissedPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Missed>().add_systems(
            Update,
            (
                request
                    .run_if(
                        resource_exists::<OpenWorld>
                            .and_then(resource_exists::<WorldGeneration>)
                            .and_then(resource_exists::<TrialChoice>),
                    )
                    .run_if(
                        resource_exists_and_changed::<Results>
                            .or_else(resource_exists_and_changed::<OpenWorld>),
                    ),
                receive.run_if(is_requested),
            )
                .chain()
                .in_set(EditorSystems::Sample),
        );
    }
}

fn is_requested(missed: Res<Missed>) -> bool {
    missed.0.requested().is_some()
}

/// What is studied.
#[derive(SystemParam)]
struct Studied<'w> {
    world: Res<'w, OpenWorld>,
    generation: Res<'w, WorldGeneration>,
    choice: Res<'w, TrialChoice>,
    results: Res<'w, Results>,
    drag: Option<Res<'w, ActiveDrag>>,
}

impl Studied<'_> {
    /// Of the study that is shown, where it is the design's own and misses a bound.
    fn key(&self) -> Option<MissedKey> {
        let (document, results) = (&self.world.0.document, &*self.results);
        let is_shown = results.is_whole() && !are_figures_old(document, results, &self.choice);
        let study = results.study.as_ref().filter(|_| is_shown)?;
        let requirement = study.value.figures.requirement.as_ref()?;
        (requirement.verdict == Verdict::Missed).then(|| MissedKey {
            generation: self.generation.0,
            revision: document.revision(),
            serial: self.choice.serial(),
        })
    }
}

fn request(mut missed: ResMut<Missed>, studied: Studied) {
    if studied.drag.as_ref().is_some_and(|drag| drag.0) {
        return;
    }
    let Some(key) = studied.key() else {
        if missed.0.requested().is_some() {
            missed.0.give_up();
        }
        return;
    };
    if missed.0.requested() == Some(&key) {
        return;
    }
    let world = &studied.world.0;
    let scenario = trackwright_project::resolve(world.document.design(), &world.environment);
    let mode = studied.choice.mode(&scenario);
    missed.0.request(key, move |task, _| Some(error_sources(&scenario, &mode, &task.cancel).ok()));
}

fn receive(mut missed: ResMut<Missed>) {
    if missed.bypass_change_detection().0.receive(|_| ()) {
        missed.set_changed();
    }
}
