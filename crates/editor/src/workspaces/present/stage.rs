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
    /// From where one looked before.
    before: Option<OrbitCamera>,
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
pub(crate) struct House<'w> {
    choice: ResMut<'w, TrialChoice>,
    selection: ResMut<'w, Selection>,
    picking: Option<ResMut<'w, PickingSettings>>,
    rig: Option<ResMut<'w, OrbitRig>>,
}

impl House<'_> {
    /// Nothing is selected, and no hand takes hold of anything; the tool stands where it is designed.
    fn open(&mut self) {
        self.choice.show(None);
        self.selection.set_if_neq(Selection::default());
        self.let_pick(false);
    }

    fn let_pick(&mut self, is_enabled: bool) {
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
    generation: Res<WorldGeneration>,
    presenter: Res<Presenter>,
    mut stage: ResMut<Stage>,
    mut house: House,
    world: Option<ResMut<OpenWorld>>,
) {
    let Some(mut world) = world else { return };
    if !workspace.is_presentation {
        // To look is no change, which would make the next frame look again.
        if !stage.is_empty() {
            stage.shown = None;
            world.0.document.present(None);
            house.let_pick(true);
            // A view that has no camera is looked at from wherever one is.
            let is_anywhere = world.0.document.view().camera.is_none();
            let before = stage.before.take().filter(|_| is_anywhere);
            if let (Some(rig), Some(before)) = (&mut house.rig, before) {
                rig.return_to(before);
            }
        }
        return;
    }
    let wanted = wanted(&world.0.document, presenter.slide, generation.0);
    if stage.shown.as_ref() == Some(&wanted) {
        return;
    }
    if stage.is_empty() {
        house.open();
        stage.before = house.rig.as_ref().map(|rig| rig.destination());
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
