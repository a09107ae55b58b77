//! Trial by trial: which study there is, which trial is shown, playing, input data and the log.

mod desk;
mod input;
mod log;
mod play;
mod shown;

pub use desk::{ModeKind, PLAY_RATES, RotationForm, Side, StudyDesk, StudyRequest};
pub use log::LogJob;
pub use shown::{LIVE, ShownDesign, ShownPlugin, ShownSystems, ShownTrial, WantedTrial};

use super::state::Workspace;
use bevy::prelude::*;

/// What a person does in the Study workspace.
///
/// Answers [`StudyRequest`] and plays trials in [`EditorSystems::Edit`](super::state::EditorSystems),
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
