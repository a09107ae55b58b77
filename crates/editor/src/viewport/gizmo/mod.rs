//! Handles in the scene that move and turn what is selected.
//!
//! An own gizmo: the design is the truth, and a handle requests edits of it; where handles are and
//! what a drag of one means is computed in the core. Without a selection there is no entity.

pub mod drag;
pub mod draw;

use crate::document::requests::OpenWorld;
use crate::document::selection::{Selected, Selection};
use crate::document::shown::ShownDesign;
use crate::schedule::EditorSystems;
use crate::shell::window::{Presentation, Workspace};
use crate::viewport::tool::SceneTool;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use trackwright_design::{Design, HandleAxes, View};
use trackwright_geometry::gizmo::{Gizmo, Handle};
use trackwright_simulation::SensorOrientation;

/// Shows handles at what is selected, and drags it by them.
pub struct GizmoPlugin;

/// When [`CurrentGizmo`] follows what is selected.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct GizmoSystems;

/// Which axes handles follow.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GizmoAxes(pub HandleAxes);

/// The gizmo that is shown.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub struct CurrentGizmo(pub Option<ShownGizmo>);

/// Handles and what they move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShownGizmo {
    pub target: Selected,
    /// Those that the handles follow.
    pub axes: HandleAxes,
    pub gizmo: Gizmo,
}

/// The entity of a handle.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[require(Transform, Visibility)]
pub struct GizmoHandle(pub Handle);

/// The handle under the pointer.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HoveredHandle(pub Option<Handle>);

impl Plugin for GizmoPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<GizmoAxes>()
            .init_resource::<CurrentGizmo>()
            .init_resource::<HoveredHandle>()
            .add_plugins((draw::plugin, drag::plugin))
            .add_systems(
                Update,
                follow
                    .run_if(is_due)
                    .in_set(GizmoSystems)
                    .in_set(EditorSystems::Draw)
                    .before(draw::GizmoDrawSystems),
            );
    }
}

/// The handles of what is selected: arrows and rings of a body or a metal object, rings of a single sensor. `None`
/// where nothing is, and for what is hidden or locked.
pub fn gizmo_of(
    design: &Design,
    view: &View,
    selection: &Selection,
    axes: HandleAxes,
) -> Option<ShownGizmo> {
    let target = selection.primary()?;
    let left_alone = [&view.hidden, &view.locked];
    let mut axes = axes;
    let gizmo = match target {
        Selected::Tip(_) | Selected::Anatomy(_) => return None,
        Selected::Body(role) => {
            if left_alone.iter().any(|things| things.has_body(role)) {
                return None;
            }
            Gizmo {
                tracker_from_gizmo: design.tracker_from_body_handle(role, axes)?,
                handles: Handle::ALL,
            }
        }
        Selected::Metal(index) => {
            let name = &design.metal_object(index)?.name;
            if left_alone.iter().any(|things| things.has_metal(name)) {
                return None;
            }
            let tracker_from_gizmo = design.tracker_from_metal_handle(index, axes)?;
            Gizmo { tracker_from_gizmo, handles: Handle::ALL }
        }
        Selected::Sensor(role, index) => {
            let sensor = design.body(role)?.rigid.sensors.get(index)?;
            let is_single = selection.all().count() == 1;
            let mut things = left_alone.iter();
            if !is_single || things.any(|things| things.has_sensor(role, &sensor.name)) {
                return None;
            }
            let handles = match sensor.orientation {
                // It is dragged itself, and looks the same however it is turned.
                SensorOrientation::Marker => return None,
                SensorOrientation::FiveDof(_) => {
                    // Another frame's axes could lie along its own and turn nothing.
                    axes = HandleAxes::Own;
                    Handle::RINGS_OF_AXIS
                }
                SensorOrientation::SixDof(_) => Handle::RINGS,
            };
            Gizmo {
                tracker_from_gizmo: design.tracker_from_sensor_handle(role, index, axes)?,
                handles,
            }
        }
    };
    Some(ShownGizmo { target, axes, gizmo })
}

/// What decides which gizmo is shown.
#[derive(SystemParam)]
struct Scene<'w> {
    world: Option<Res<'w, OpenWorld>>,
    shown: Option<Res<'w, ShownDesign>>,
    selection: Res<'w, Selection>,
    axes: Res<'w, GizmoAxes>,
    workspace: Res<'w, Workspace>,
    tool: Res<'w, SceneTool>,
    presentation: Res<'w, Presentation>,
}

fn is_due(scene: Scene) -> bool {
    scene.shown.is_some_and(|shown| shown.is_changed())
        || scene.selection.is_changed()
        || scene.axes.is_changed()
        || scene.workspace.is_changed()
        || scene.tool.is_changed()
}

fn follow(scene: Scene, mut current: ResMut<CurrentGizmo>, mut hovered: ResMut<HoveredHandle>) {
    let wanted = scene.wanted();
    if wanted.map(|shown| shown.target) != current.0.map(|shown| shown.target) {
        hovered.set_if_neq(HoveredHandle(None));
    }
    current.set_if_neq(CurrentGizmo(wanted));
}

impl Scene<'_> {
    fn wanted(&self) -> Option<ShownGizmo> {
        let (world, shown) = (self.world.as_ref()?, self.shown.as_ref()?);
        // A trial is not what an edit would change, and a picture for a page has no handles.
        let is_wanted = self.workspace.has_gizmo
            && *self.tool == SceneTool::Select
            && shown.trial.is_none()
            && self.presentation.panels;
        let view = world.0.document.view();
        is_wanted.then(|| gizmo_of(&shown.design, view, &self.selection, self.axes.0)).flatten()
    }
}
