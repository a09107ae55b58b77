//! The section of mounting regions as a panel: what it reads of the open design and its surfaces. Of
//! anatomy it is the section of the patch that the CRF may stand on.

use crate::document::requests::OpenWorld;
use crate::document::selection::{Selected, Selection};
use crate::shell::window::Workspace;
use crate::viewport::mounting::state::MountingState;
use crate::viewport::surfaces::Surfaces;
use crate::viewport::tool::SceneTool;
use crate::workspaces::design::WORKSPACE;
use crate::workspaces::design::actions::DesignRequests;
use crate::workspaces::design::crf_patch_ui::{CrfPatchView, crf_patch_ui};
use crate::workspaces::design::mounting_ui::{MountingView, mounting_ui};
use bevy::prelude::*;
use bevy_egui::egui::Ui;
use trackwright_simulation::channel_of;

/// Whether the section is about something.
pub(crate) fn is_owner_selected(world: &World) -> bool {
    let selection = world.get_resource::<Selection>();
    let is_owner = |what| matches!(what, Selected::Body(_) | Selected::Anatomy(_));
    selection.and_then(Selection::primary).is_some_and(is_owner)
}

/// Regions are edited where the section is.
pub(crate) fn close_elsewhere(workspace: Res<Workspace>, state: Option<ResMut<MountingState>>) {
    let Some(mut state) = state.filter(|state| state.is_open) else {
        return;
    };
    if *workspace != WORKSPACE {
        state.is_open = false;
    }
}

pub(crate) fn mounting_panel(
    mut ui: InMut<Ui>,
    (world, selection): (Res<OpenWorld>, Res<Selection>),
    (state, tool): (Option<Res<MountingState>>, Option<Res<SceneTool>>),
    surfaces: Option<Res<Surfaces>>,
    mut requests: DesignRequests,
) {
    let (Some(state), Some(tool)) = (state, tool) else {
        return;
    };
    let design = world.0.document.design();
    if let Some(Selected::Anatomy(index)) = selection.primary() {
        let anatomy = design.anatomy.get(index).filter(|_| design.crf.is_some());
        requests.write(anatomy.map_or_else(Vec::new, |anatomy| {
            let has_mesh = world.0.anatomy_mesh(&anatomy.mesh).is_some();
            let view = CrfPatchView { index, anatomy, has_mesh, state: *state, tool: *tool };
            crf_patch_ui(&mut ui, &view)
        }));
        return;
    }
    let Some(Selected::Body(role)) = selection.primary() else {
        return;
    };
    let Some(body) = design.body(role) else {
        return;
    };
    let mesh = world.0.mesh(role);
    let surface = surfaces.as_ref().and_then(|surfaces| surfaces.of(role));
    let view = MountingView {
        body: role,
        mounting: &body.mounting,
        sensors: &body.rigid.sensors,
        mesh: mesh.map(|mesh| &**mesh),
        state: *state,
        tool: *tool,
        channel_from_mesh: &|| channel_of(surface?, &mesh?.long_axis()),
    };
    requests.write(mounting_ui(&mut ui, &view));
}
