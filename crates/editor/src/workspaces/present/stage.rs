//! Looks at the design as the slide on the screen does. The design's own view is kept for the end,
//! and is what is saved meanwhile.

use crate::document::requests::OpenWorld;
use crate::document::selection::Selection;
use crate::document::state::WorldGeneration;
use crate::document::trials::TrialChoice;
use crate::shell::window::Workspace;
use crate::viewport::camera::OrbitRig;
use crate::workspaces::present::first::slide_of;
use crate::workspaces::present::requests::Presenter;
use bevy::picking::PickingSettings;
use bevy::prelude::*;
use trackwright_design::{Document, View};
use trackwright_geometry::orbit::OrbitCamera;

/// What was put on the screen.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct Stage {
    shown: Option<Shown>,
    before: Option<Before>,
}

/// What the window showed before the presentation, and shows again after it.
#[derive(Clone, Debug, PartialEq)]
struct Before {
    generation: u64,
    camera: Option<OrbitCamera>,
    selection: Selection,
    trial: Option<usize>,
    /// See [`TrialChoice::serial`].
    trials: u64,
}

/// A slide's view is put on the screen once; then one may look around.
#[derive(Clone, Debug, PartialEq)]
struct Shown {
    generation: u64,
    slide: usize,
    view: View,
}

impl Stage {
    pub fn is_empty(&self) -> bool {
        self.shown.is_none()
    }

    /// The slide is shown as it is kept, wherever one has looked.
    pub(crate) fn forget(&mut self) {
        if let Some(shown) = &mut self.shown {
            // No design has this number.
            shown.generation = u64::MAX;
        }
    }
}

/// Where a presentation is left to.
pub(crate) fn remember_origin(
    workspace: Res<Workspace>,
    mut presenter: ResMut<Presenter>,
    mut last: Local<Workspace>,
) {
    if *workspace != *last {
        if workspace.is_presentation {
            presenter.from = *last;
        }
        *last = *workspace;
    }
}

/// What a presentation changes of everything else while it lasts.
#[derive(bevy::ecs::system::SystemParam)]
pub(crate) struct Surroundings<'w> {
    generation: Res<'w, WorldGeneration>,
    choice: ResMut<'w, TrialChoice>,
    selection: ResMut<'w, Selection>,
    picking: Option<ResMut<'w, PickingSettings>>,
    rig: Option<ResMut<'w, OrbitRig>>,
}

impl Surroundings<'_> {
    /// Nothing is selected and nothing can be picked; the tool stands where it is designed.
    fn clear(&mut self) -> Before {
        let before = Before {
            generation: self.generation.0,
            camera: self.rig.as_ref().map(|rig| rig.destination()),
            selection: self.selection.clone(),
            trial: self.choice.trial(),
            trials: self.choice.serial(),
        };
        self.choice.show(None);
        self.selection.set_if_neq(Selection::default());
        self.enable_picking(false);
        before
    }

    /// What belongs to another design stays as it is now, and so does a camera that the design's
    /// own view sets.
    fn restore(&mut self, before: Before, has_own_camera: bool) {
        self.enable_picking(true);
        if !has_own_camera && let (Some(rig), Some(camera)) = (&mut self.rig, before.camera) {
            rig.return_to(camera);
        }
        if before.generation != self.generation.0 {
            return;
        }
        self.selection.set_if_neq(before.selection);
        if before.trials == self.choice.serial() {
            self.choice.show(before.trial);
        }
    }

    fn enable_picking(&mut self, is_enabled: bool) {
        if let Some(picking) = &mut self.picking {
            picking.is_enabled = is_enabled;
        }
    }
}

/// Whether anything changed that determines what is to be on the screen.
pub(crate) fn may_differ(
    workspace: Res<Workspace>,
    generation: Res<WorldGeneration>,
    presenter: Res<Presenter>,
    stage: Res<Stage>,
    world: Option<Res<OpenWorld>>,
) -> bool {
    workspace.is_changed()
        || generation.is_changed()
        || presenter.is_changed()
        || stage.is_changed()
        || world.is_some_and(|world| world.is_changed())
}

/// Puts the slide on the screen that is to be there, or gives the design's own view back.
pub(crate) fn follow(
    workspace: Res<Workspace>,
    presenter: Res<Presenter>,
    mut stage: ResMut<Stage>,
    mut surroundings: Surroundings,
    world: Option<ResMut<OpenWorld>>,
) {
    let Some(mut world) = world else { return };
    if !workspace.is_presentation {
        // To look is no change, which would make the next frame look again.
        if !stage.is_empty() {
            stage.shown = None;
            world.0.document.present(None);
            if let Some(before) = stage.before.take() {
                surroundings.restore(before, world.0.document.view().camera.is_some());
            }
        }
        return;
    }
    let wanted = wanted(&world.0.document, presenter.slide, surroundings.generation.0);
    if stage.shown.as_ref() == Some(&wanted) {
        return;
    }
    if stage.is_empty() {
        stage.before = Some(surroundings.clear());
    }
    let mut view = wanted.view.clone();
    // A slide without a camera is seen from where one is.
    view.camera = view.camera.or(world.0.document.view().camera);
    world.0.document.present(Some(view));
    stage.shown = Some(wanted);
}

fn wanted(document: &Document, slide: usize, generation: u64) -> Shown {
    let slides = &document.design().slides;
    let slide = slide.min(slides.len().saturating_sub(1));
    let view = match slides.get(slide) {
        Some(slide) => slide.view.clone(),
        None => slide_of(document).view,
    };
    Shown { generation, slide, view }
}
