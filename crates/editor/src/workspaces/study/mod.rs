//! Trial by trial: which study there is, which trial is shown, playing, input data and the log.

pub mod desk;
pub mod input;
pub mod log;
pub mod play;
pub mod precision;
pub mod precision_ui;
pub mod study_charts_ui;
pub mod study_panels;
pub mod timeline_ui;
pub mod trial_ui;

use crate::shell::window::Workspace;
use bevy::prelude::*;

/// What a person does in the Study workspace.
///
/// Answers [`StudyRequest`] and plays trials in [`EditorSystems::Edit`](crate::schedule::EditorSystems),
/// reads input data and writes logs.
pub struct StudyPlugin;

impl Plugin for StudyPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins((play::plugin, input::plugin, log::plugin));
    }
}

fn are_trials_shown(workspace: Option<Res<Workspace>>) -> bool {
    workspace.is_some_and(|workspace| workspace.shows_trials())
}

fn is_study_shown(workspace: Option<Res<Workspace>>) -> bool {
    workspace.is_some_and(|workspace| *workspace == Workspace::Study)
}
