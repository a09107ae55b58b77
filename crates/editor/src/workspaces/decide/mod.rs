//! The Decide workspace: the design beside a pinned baseline, and designs and rooms in one table.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`state`] | the state: the baseline, the table's designs and rooms, what is under way |
//! | `answer` | carries out the panels' requests, or starts the thread that does |
//! | [`against`] | keeps the design's figures beside the baseline's, once edits rest |
//! | [`baseline_ghost`] | draws the baseline's tool as the tracker reports it |
//! | `kept_baseline` | keeps the baseline beside the design's file |
//! | [`judged`] | keeps where the design stands in its procedure, once edits rest |
//! | [`table`] | what the table's thread does |
//! | [`sweep_table`] | the rows of a sweep as a table |

pub mod against;
pub mod answer;
pub mod baseline_ghost;
pub mod dialog;
pub mod judged;
mod kept_baseline;
pub mod panels;
pub mod requests;
pub mod state;
pub mod sweep_table;
pub mod table;

pub use requests::{DecideRequest, WORKSPACE, is_shown};

use crate::document::requests::OpenWorld;
use crate::document::state::WorldGeneration;
use crate::schedule::EditorSystems;
use crate::shell::commands::CommandsSystems;
use crate::shell::registry::{AddToShell, PanelInfo, Side};
use crate::widgets::theme;
use crate::workspaces::decide::panels::systems::{baseline_panel, steps_panel, table_panel};
use crate::workspaces::decide::state::DecideState;
use crate::workspaces::decide::sweep_table::{SweepTablePlugin, is_closed};
use crate::workspaces::design::panels::brief_result_panel;
use crate::workspaces::field::FieldRequest;
use crate::workspaces::study::state::StudyRequest;
use bevy::prelude::*;

/// Compares on [`DecideRequest`], and holds the design against the baseline while the workspace
/// is shown; nothing is read or computed before.
pub struct DecidePlugin;

/// Whether nothing is computed for the workspace.
pub fn is_idle(world: &World) -> bool {
    let against = world.get_resource::<against::Against>();
    let judged = world.get_resource::<judged::Judged>();
    against.is_none_or(|of| of.is_idle()) && judged.is_none_or(|of| of.is_idle())
}

fn is_busy(state: Res<DecideState>) -> bool {
    state.is_busy()
}

impl Plugin for DecidePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<DecideState>()
            .add_message::<DecideRequest>()
            .add_message::<FieldRequest>()
            .add_message::<StudyRequest>()
            .add_plugins((against::AgainstPlugin, judged::JudgedPlugin, kept_baseline::plugin))
            .add_plugins(SweepTablePlugin)
            .add_workspace(WORKSPACE)
            .add_panel(
                PanelInfo::new(WORKSPACE, Side::Bottom).high(table_height).shown_if(is_closed),
                table_panel,
            )
            .add_panel(PanelInfo::new(WORKSPACE, Side::Left), steps_panel)
            .add_panel(PanelInfo::new(WORKSPACE, Side::Right).fixed(), brief_result_panel)
            .add_panel(PanelInfo::new(WORKSPACE, Side::Right), baseline_panel)
            .add_systems(
                Update,
                (
                    (
                        // First, since requests are for the design that is open.
                        answer::turn_to_opened.run_if(
                            resource_exists::<OpenWorld>
                                .and_then(resource_changed::<WorldGeneration>),
                        ),
                        answer::follow_to_folder.run_if(resource_exists_and_changed::<OpenWorld>),
                        answer::answer.run_if(on_message::<DecideRequest>),
                    )
                        .chain()
                        .after(CommandsSystems)
                        .in_set(EditorSystems::Input),
                    answer::receive_results.run_if(is_busy).in_set(EditorSystems::Solve),
                ),
            );
    }
}

/// The table is higher once there is one.
fn table_height(world: &World) -> f32 {
    let state = world.get_resource::<DecideState>();
    match state.is_some_and(|state| state.compared.is_some()) {
        true => theme::TABLE_HEIGHT,
        false => theme::TABLE_HEAD_HEIGHT,
    }
}
