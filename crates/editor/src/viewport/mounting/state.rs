//! Whose mounting regions are edited, and with what.

use crate::document::requests::{ActiveDrag, OpenWorld};
use crate::document::selection::{Selected, Selection};
use crate::scene::BodyRoot;
use crate::schedule::EditorSystems;
use crate::shell::window::Workspace;
use crate::viewport::camera_gestures::Gesture;
use crate::viewport::surfaces::Surfaces;
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
    /// Whether the regions of the selected body, or the patch of the selected anatomy, are shown to be
    /// edited.
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

/// What something may be mounted on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MountingOwner {
    /// Sensors.
    Body(BodyRole),
    /// The CRF; by its place in the design's list.
    Anatomy(usize),
}

impl MountingOwner {
    pub fn body(self) -> Option<BodyRole> {
        match self {
            Self::Body(role) => Some(role),
            Self::Anatomy(_) => None,
        }
    }

    /// Anatomy is painted and nothing else.
    fn takes(self, tool: SceneTool) -> bool {
        let is_brush = matches!(tool, SceneTool::PaintPatch | SceneTool::ErasePatch);
        is_brush || (tool.is_for_mounting() && self.body().is_some())
    }
}

/// The body, or the anatomy, whose mounting regions are edited.
#[derive(SystemParam)]
pub struct EditedBody<'w> {
    state: Option<Res<'w, MountingState>>,
    selection: Res<'w, Selection>,
    workspace: Res<'w, Workspace>,
}

impl EditedBody<'_> {
    pub fn get(&self) -> Option<BodyRole> {
        self.owner()?.body()
    }

    pub fn owner(&self) -> Option<MountingOwner> {
        let is_open = self.state.as_ref().is_some_and(|state| state.is_open);
        if !(is_open && self.workspace.edits_design) {
            return None;
        }
        match self.selection.primary()? {
            Selected::Body(role) => Some(MountingOwner::Body(role)),
            Selected::Anatomy(index) => Some(MountingOwner::Anatomy(index)),
            Selected::Sensor(..) | Selected::Tip(_) | Selected::Metal(_) => None,
        }
    }

    pub fn is_changed(&self) -> bool {
        self.state.as_ref().is_some_and(|state| state.is_changed())
            || self.selection.is_changed()
            || self.workspace.is_changed()
    }
}

/// What a tool for mounting regions is used on: nothing else is picked.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub struct MountingTarget(pub MountingOwner);

/// Clicks on it.
#[derive(SystemParam)]
pub(super) struct TargetClicks<'w, 's> {
    targets: Query<'w, 's, &'static MountingTarget>,
    active: Res<'w, ActiveDrag>,
    camera: Option<Res<'w, Gesture>>,
}

impl TargetClicks<'_, '_> {
    /// What is clicked on, unless it is the end of a drag of something or of the camera.
    pub fn owner(&self, click: &On<Pointer<Click>>) -> Option<MountingOwner> {
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

fn is_due(edited: EditedBody, tool: Res<SceneTool>, world: Option<Res<OpenWorld>>) -> bool {
    edited.is_changed() || tool.is_changed() || world.is_some_and(|world| world.is_changed())
}

/// Without something to paint there is no painting.
fn end_tool(edited: EditedBody, mut tool: ResMut<SceneTool>) {
    let is_taken = edited.owner().is_some_and(|owner| owner.takes(*tool));
    if tool.is_for_mounting() && !is_taken {
        *tool = SceneTool::Select;
    }
}

/// A body is a target where it is drawn; anatomy, which is not picked, has an entity for it, and a
/// surface only as long as that is there.
fn place_target(
    mut commands: Commands,
    (edited, tool): (EditedBody, Res<SceneTool>),
    world: Option<Res<OpenWorld>>,
    surfaces: Option<ResMut<Surfaces>>,
    roots: Query<(Entity, &BodyRoot)>,
    targets: Query<(Entity, &MountingTarget)>,
) {
    let owner = edited.owner().filter(|_| tool.is_for_mounting());
    if targets.iter().next().map(|(_, target)| target.0) != owner {
        for (entity, target) in &targets {
            match target.0 {
                MountingOwner::Body(_) => {
                    commands.entity(entity).remove::<MountingTarget>();
                }
                MountingOwner::Anatomy(_) => commands.entity(entity).despawn(),
            }
        }
        match owner {
            Some(MountingOwner::Body(role)) => {
                let root = roots.iter().find(|(_, root)| root.0 == role);
                if let Some((entity, _)) = root {
                    commands.entity(entity).insert(MountingTarget(MountingOwner::Body(role)));
                }
            }
            Some(anatomy) => {
                commands.spawn((Name::new("painted anatomy"), MountingTarget(anatomy)));
            }
            None => {}
        }
    }
    let mesh = match (owner, world.as_ref()) {
        (Some(MountingOwner::Anatomy(index)), Some(world)) => {
            let anatomy = world.0.document.design().anatomy.get(index);
            anatomy.and_then(|anatomy| world.0.anatomy_mesh(&anatomy.mesh))
        }
        _ => None,
    };
    if let Some(mut surfaces) = surfaces {
        surfaces.bypass_change_detection().keep_anatomy(mesh);
    }
}
