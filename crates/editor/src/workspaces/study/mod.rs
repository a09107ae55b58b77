//! Trial by trial: which study there is, which trial is shown, playing, input data and the log.

pub mod commands;
pub mod dialog;
pub mod input;
pub mod log;
pub mod measured_ghost;
pub mod play;
pub mod precision;
pub mod precision_ui;
pub mod state;
pub mod study_charts_ui;
pub mod study_panels;
pub mod timeline_ui;
pub mod trial_ui;

pub use state::WORKSPACE;

use crate::schedule::EditorSystems;
use crate::shell::registry::{AddToShell, PanelInfo, Side};
use crate::shell::window::Workspace;
use crate::widgets::theme;
use crate::workspaces::design::is_history_shown;
use crate::workspaces::design::panels::{
    history_panel, inspector_panel, outliner_panel, result_panel,
};
use crate::workspaces::layers_panel::layers_panel;
use crate::workspaces::study::state::StudyState;
use crate::workspaces::study::study_panels::{
    clear_note, sides_panel, timeline_panel, trials_panel,
};
use bevy::prelude::*;

/// What a person does in the Study workspace.
///
/// Answers [`StudyRequest`](state::StudyRequest) and plays trials in [`EditorSystems::Edit`], reads
/// input data and writes logs.
pub struct StudyPlugin;

impl Plugin for StudyPlugin {
    fn build(&self, app: &mut App) {
        let left = PanelInfo::new(WORKSPACE, Side::Left);
        let right = PanelInfo::new(WORKSPACE, Side::Right);
        let bottom = PanelInfo::new(WORKSPACE, Side::Bottom).high(|_| theme::TIMELINE_HEIGHT);
        app.add_plugins((play::plugin, input::plugin, log::plugin, commands::plugin))
            .add_workspace(WORKSPACE)
            .add_panel(bottom, timeline_panel)
            .add_panel(left.fixed().shown_if(is_history_shown), history_panel)
            .add_panel(left, outliner_panel)
            .add_panel(left, layers_panel)
            .add_panel(right.fixed(), sides_panel)
            .add_panel(right.fixed(), result_panel)
            .add_panel(right.shown_if(is_trials), trials_panel)
            .add_panel(right.shown_if(is_inspector), inspector_panel)
            .add_systems(Update, clear_note.in_set(EditorSystems::Draw));
    }
}

fn is_trials(world: &World) -> bool {
    world.get_resource::<StudyState>().is_some_and(|state| state.side == state::Side::Trials)
}

fn is_inspector(world: &World) -> bool {
    !is_trials(world)
}

fn are_trials_shown(workspace: Option<Res<Workspace>>) -> bool {
    workspace.is_some_and(|workspace| workspace.shows_trials)
}
