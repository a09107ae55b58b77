//! The panels of the Live workspace: systems over pure functions from its state to requests.

pub mod collecting;
pub mod tools;
pub mod tracker;

use crate::document::requests::OpenWorld;
use crate::document::shown::LIVE;
use crate::runner::results::Results;
use crate::shell::requests::Requests;
use crate::shell::window::{StatusNote, Workspace};
use crate::workspaces::live::panels::collecting::collecting_ui;
use crate::workspaces::live::panels::tools::tools_ui;
use crate::workspaces::live::panels::tracker::{recording_ui, tracker_ui};
use crate::workspaces::live::requests::LiveRequest;
use crate::workspaces::live::state::LiveState;
use crate::workspaces::study::state::{StudyRequest, StudyState};
use crate::workspaces::study::trial_ui::{TrialView, trial_ui};
use bevy::prelude::*;
use bevy_egui::egui::Ui;
use trackwright_design::BodyRole;
use trackwright_openigtlink::relay::ToolState;
use trackwright_openigtlink::roles::base_name;

/// The tracker, its tools, the recording.
pub(crate) fn tracker_panel(
    mut ui: InMut<Ui>,
    world: Res<OpenWorld>,
    live: Res<LiveState>,
    mut requests: Requests<LiveRequest>,
) {
    requests.write_all(tracker_ui(&mut ui, &live));
    requests.write_all(tools_ui(&mut ui, &live, world.0.document.design()));
    requests.write_all(recording_ui(&mut ui, &live));
}

/// The tool at the pose that was received, and beside it why it is not there now.
pub(crate) fn pose_panel(
    mut ui: InMut<Ui>,
    (world, results): (Res<OpenWorld>, Res<Results>),
    live: Res<LiveState>,
    study: Res<StudyState>,
    mut requests: Requests<StudyRequest>,
) {
    let is_live = results.pose_trial.is_some_and(|number| number >= LIVE);
    let Some(pose) = results.pose.as_ref().filter(|_| is_live) else {
        return;
    };
    let design = world.0.document.design();
    let troubles = live.troubles(design);
    let is_now = troubles.iter().all(|(role, _)| *role != BodyRole::Tool);
    let view = TrialView {
        trial: Some(&pose.value.trial),
        title: if is_now { "The tool now" } else { "The tool at its last good pose" }.to_owned(),
        columns: ["compensated", "measured"],
        rotation: study.rotation,
        has_crf: design.crf.is_some(),
        sources: &[],
        measured: None,
    };
    requests.write_all(trial_ui(&mut ui, &view));
}

/// Where samples were taken.
pub(crate) fn collecting_panel(
    mut ui: InMut<Ui>,
    live: Res<LiveState>,
    mut requests: Requests<LiveRequest>,
) {
    requests.write_all(collecting_ui(&mut ui, &live));
}

/// The status line shows the state of the tools that are the design's bodies.
pub(crate) fn note_tools(
    live: Res<LiveState>,
    workspace: Res<Workspace>,
    mut note: ResMut<StatusNote>,
) {
    if !workspace.shows_live {
        return;
    }
    let seen = live.seen.iter().filter(|_| live.is_connected()).flat_map(|seen| &seen.tools);
    let of_bodies = seen.filter(|(_, view)| view.role.is_some());
    let words: Vec<String> = of_bodies
        .map(|(name, view)| match view.state {
            ToolState::Good => format!("{} good", base_name(name)),
            ToolState::NotGood(reason) => format!("{} not good: {reason}", base_name(name)),
        })
        .collect();
    note.set_if_neq(StatusNote((!words.is_empty()).then(|| words.join(" · "))));
}
