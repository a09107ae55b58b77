//! The Design workspace: bodies, sensors, the result.

pub mod actions;
pub mod anatomy_ui;
pub mod baseline;
pub mod body_file_ui;
pub mod chosen_sensors;
pub mod crf_patch_ui;
pub mod crf_study_ui;
pub mod history_ui;
pub mod inspector;
pub mod mesh_ui;
pub mod metal_distance;
pub mod metal_distance_mark;
pub mod metal_facts_ui;
pub mod metal_ui;
pub mod missed;
pub mod motion_ui;
pub mod mounting_panel;
pub mod mounting_ui;
pub mod outliner;
pub mod outliner_row;
pub mod panels;
pub mod pivot_ui;
pub mod placement_search;
pub mod result;
pub mod row_page;
pub(crate) mod rows;
pub mod scene_menu;
pub mod sensor_numbers;
pub mod sensor_ui;
pub(crate) mod workspace;

pub use workspace::WORKSPACE;

use crate::schedule::EditorSystems;
use crate::shell::registry::{AddToShell, PanelInfo, Side};
use crate::shell::window::{PanelsShown, Workspace};
use crate::workspaces::design::actions::{HoveredRow, forget_hovered_row};
use crate::workspaces::design::baseline::{Baseline, note_baseline};
use crate::workspaces::design::metal_distance::{
    MetalDistancePlugin, is_metal_selected, metal_distance_panel,
};
use crate::workspaces::design::missed::MissedPlugin;
use crate::workspaces::design::mounting_panel::{
    close_elsewhere, is_owner_selected, mounting_panel,
};
use crate::workspaces::design::panels::{
    history_panel, inspector_panel, outliner_panel, result_panel,
};
use crate::workspaces::design::placement_search::{PlacementSearchPlugin, is_closed};
use crate::workspaces::layers_panel::layers_panel;
use bevy::prelude::*;

/// The Design workspace, the menu of a sensor in the scene, and the page of a row of sensors.
pub struct DesignPlugin;

impl Plugin for DesignPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Baseline>()
            .init_resource::<HoveredRow>()
            .add_plugins((MissedPlugin, MetalDistancePlugin, row_page::plugin, scene_menu::plugin))
            .add_workspace(WORKSPACE)
            .add_panel(
                PanelInfo::new(WORKSPACE, Side::Left).fixed().shown_if(is_history_shown),
                history_panel,
            )
            .add_panel(PanelInfo::new(WORKSPACE, Side::Left), outliner_panel)
            .add_panel(PanelInfo::new(WORKSPACE, Side::Left), layers_panel)
            .add_panel(PanelInfo::new(WORKSPACE, Side::Right).fixed(), result_panel)
            .add_panel(PanelInfo::new(WORKSPACE, Side::Right).shown_if(is_closed), inspector_panel)
            .add_panel(
                PanelInfo::new(WORKSPACE, Side::Right).shown_if(is_mounting_shown),
                mounting_panel,
            )
            .add_panel(
                PanelInfo::new(WORKSPACE, Side::Right).shown_if(is_metal_selected),
                metal_distance_panel,
            )
            // Its panel stands in the place of the inspector.
            .add_plugins(PlacementSearchPlugin)
            .add_systems(
                Update,
                (
                    note_baseline.before(EditorSystems::Edit),
                    close_elsewhere
                        .run_if(resource_changed::<Workspace>)
                        .in_set(EditorSystems::Input),
                    forget_hovered_row
                        .run_if(
                            resource_changed::<Workspace>.or_else(resource_changed::<PanelsShown>),
                        )
                        .in_set(EditorSystems::Input),
                ),
            );
    }
}

fn is_mounting_shown(world: &World) -> bool {
    is_closed(world) && is_owner_selected(world)
}

pub(crate) fn is_history_shown(world: &World) -> bool {
    world.resource::<PanelsShown>().history
}
