//! Whose mounting regions are edited, and with what.

use crate::document::requests::ActiveDrag;
use crate::document::selection::{Selected, Selection};
use crate::scene::BodyRoot;
use crate::schedule::EditorSystems;
use crate::shell::window::Workspace;
use crate::viewport::camera_gestures::Gesture;
use crate::viewport::tool::SceneTool;
use bevy::ecs::system::SystemParam;
use bevy::picking::events::{Click, Pointer};
use bevy::picking::pointer::PointerButton;
use bevy::prelude::*;
use trackwright_design::BodyRole;

/// Edge of a brush that nobody set.
const BRUSH_MM: f64 = 5.0;

/// What the section *Mounting* of the inspector is set to.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct MountingState {
    /// Whether the regions of the selected body are shown to be edited.
    pub is_open: bool,
    /// The patch that the brush paints, by its place in the body's list.
    pub patch: Option<usize>,
    /// Edge of the brush, and of a box that is drawn by a click.
    pub brush_mm: f64,
}

impl Default for MountingState {
    fn default() -> Self {
        Self { is_open: false, patch: None, brush_mm: BRUSH_MM }
    }
}

/// The body whose mounting regions are edited.
#[derive(SystemParam)]
pub struct EditedBody<'w> {
    state: Option<Res<'w, MountingState>>,
    selection: Res<'w, Selection>,
    workspace: Res<'w, Workspace>,
}

impl EditedBody<'_> {
    pub fn get(&self) -> Option<BodyRole> {
        let is_open = self.state.as_ref().is_some_and(|state| state.is_open);
        match self.selection.primary() {
            Some(Selected::Body(role)) if is_open && self.workspace.edits_design => Some(role),
            _ => None,
        }
    }

    pub fn is_changed(&self) -> bool {
        self.state.as_ref().is_some_and(|state| state.is_changed())
            || self.selection.is_changed()
            || self.workspace.is_changed()
    }
}

/// The body that a tool for mounting regions is used on: nothing else is picked.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub struct MountingTarget(pub BodyRole);

/// Clicks on that body.
#[derive(SystemParam)]
pub(super) struct BodyClicks<'w, 's> {
    targets: Query<'w, 's, &'static MountingTarget>,
    active: Res<'w, ActiveDrag>,
    camera: Option<Res<'w, Gesture>>,
}

impl BodyClicks<'_, '_> {
    /// The body of one that is not the end of a drag of something or of the camera.
    pub fn body(&self, click: &On<Pointer<Click>>) -> Option<BodyRole> {
        let target = self.targets.get(click.entity).ok()?;
        let has_turned = self.camera.as_ref().is_some_and(|camera| camera.has_moved());
        let counts = click.button == PointerButton::Primary && !self.active.0 && !has_turned;
        counts.then_some(target.0)
    }
}

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<MountingState>().add_systems(
        Update,
        (end_tool, place_target).chain().run_if(is_due).in_set(EditorSystems::Draw),
    );
}

fn is_due(edited: EditedBody, tool: Res<SceneTool>) -> bool {
    edited.is_changed() || tool.is_changed()
}

/// Without a body there is nothing to paint.
fn end_tool(edited: EditedBody, mut tool: ResMut<SceneTool>) {
    if tool.is_for_mounting() && edited.get().is_none() {
        *tool = SceneTool::Select;
    }
}

fn place_target(
    mut commands: Commands,
    edited: EditedBody,
    tool: Res<SceneTool>,
    roots: Query<(Entity, &BodyRoot, Has<MountingTarget>)>,
) {
    let role = edited.get().filter(|_| tool.is_for_mounting());
    for (entity, root, is_target) in &roots {
        match (role == Some(root.0), is_target) {
            (true, false) => {
                commands.entity(entity).insert(MountingTarget(root.0));
            }
            (false, true) => {
                commands.entity(entity).remove::<MountingTarget>();
            }
            _ => {}
        }
    }
}
