//! The panels of the Study workspace as systems.

use crate::document::requests::OpenWorld;
use crate::document::shown::{LIVE, ShownDesign};
use crate::document::trials::TrialChoice;
use crate::runner::results::Results;
use crate::shell::commands::RunCommand;
use crate::shell::requests::Requests;
use crate::shell::window::{StatusNote, Workspace};
use crate::widgets::theme;
use crate::widgets::tooltip::Explain;
use crate::workspaces::design::result::are_figures_old;
use crate::workspaces::study::log::LogJob;
use crate::workspaces::study::state::{Side, StudyRequest, StudyState};
use crate::workspaces::study::study_charts_ui::{StudyChartsView, study_charts_ui};
use crate::workspaces::study::timeline_ui::{TimelineAction, TimelineView, timeline_ui};
use crate::workspaces::study::trial_ui::{TrialView, trial_ui};
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_egui::egui::{Button, Margin, Panel, Ui};
use trackwright_project::MeasuredError;
use trackwright_simulation::figures::trial_number;

/// What the panels show.
#[derive(SystemParam)]
pub(crate) struct Shown<'w> {
    world: Res<'w, OpenWorld>,
    results: Res<'w, Results>,
    choice: Res<'w, TrialChoice>,
    state: Res<'w, StudyState>,
    trial: Option<Res<'w, ShownDesign>>,
}

impl Shown<'_> {
    /// What was measured at each trial, where they are a recording of the built tool.
    fn measured(&self) -> Option<&[MeasuredError]> {
        self.choice.measured(self.world.0.document.design().motion.is_some())
    }
}

/// The modes, the buttons that go through trials, and a chart of all of them.
pub(crate) fn timeline_panel(
    mut ui: InMut<Ui>,
    shown: Shown,
    log: Res<LogJob>,
    mut study: Requests<StudyRequest>,
    mut run: Requests<RunCommand>,
) {
    let (document, results, choice) = (&shown.world.0.document, &*shown.results, &*shown.choice);
    let figures = results.study.as_ref();
    let profile = results.profile.as_ref();
    let has_motion = document.design().motion.is_some();
    // During a drag the trials that are charted stay what they were.
    let are_old = are_figures_old(document, results, choice)
        || !results.is_whole()
        || profile.is_some_and(|profile| profile.revision != document.revision());
    let view = TimelineView {
        kind: choice.kind(has_motion),
        has_motion,
        input: choice.input().map(|input| input.name.as_str()),
        trials: figures.map_or(0, |study| study.value.room_field.trials),
        shown: shown.trial.as_ref().and_then(|shown| shown.trial.as_ref()),
        profile: profile.map(|profile| &profile.value),
        measured: shown.measured(),
        is_computing: results.problem.is_none() && are_old,
        is_playing: choice.is_playing(),
        rate_per_s: shown.state.rate_per_s,
        log_part: log.part(),
    };
    for action in timeline_ui(&mut ui, &view) {
        match action {
            TimelineAction::Study(request) => study.write(request),
            TimelineAction::Run(command) => run.write(RunCommand(command)),
        }
    }
}

/// The shown trial in numbers, and charts of all of them.
pub(crate) fn trials_panel(mut ui: InMut<Ui>, shown: Shown, mut requests: Requests<StudyRequest>) {
    let (design, results) = (shown.world.0.document.design(), &shown.results);
    let view = TrialView {
        trial: results.pose.as_ref().map(|pose| &pose.value.trial),
        title: match results.pose_trial.filter(|number| *number < LIVE) {
            Some(number) => format!("Trial {}", trial_number(number)),
            None => "The design's own pose".to_owned(),
        },
        columns: ["true", "simulated"],
        rotation: shown.state.rotation,
        has_crf: design.crf.is_some(),
        sources: &results.sources,
        measured: shown.measured().zip(results.pose_trial).and_then(|(all, trial)| all.get(trial)),
    };
    requests.write_all(trial_ui(&mut ui, &view));
    let Some(profile) = &results.profile else { return };
    let trial = shown.trial.as_ref().and_then(|shown| shown.trial.as_ref());
    let view = StudyChartsView {
        charted: &profile.value,
        axis: shown.state.axis,
        shown: trial.map(|trial| trial.number),
    };
    requests.write_all(study_charts_ui(&mut ui, &view));
}

/// Which of two things stands above the result.
pub(crate) fn sides_panel(
    mut ui: InMut<Ui>,
    state: Res<StudyState>,
    mut requests: Requests<StudyRequest>,
) {
    let sides = Panel::top("sides")
        .resizable(false)
        .show_separator_line(false)
        .frame(theme::panel_frame(Margin::symmetric(10, 4)));
    sides.show(&mut ui, |ui| {
        ui.horizontal(|ui| {
            for (side, name, about) in [
                (Side::Trials, "Trials", "The shown trial in numbers, and charts of all trials"),
                (Side::Inspector, "Inspector", "What is selected, to be edited"),
            ] {
                let tab = Button::selectable(side == state.side, name);
                if ui.add(tab).explained(about).clicked() && side != state.side {
                    requests.write(StudyRequest::ShowSide(side));
                }
            }
        });
    });
}

/// The timeline names the trial that the scene shows; the status line does not repeat it.
pub(crate) fn clear_note(workspace: Res<Workspace>, mut note: ResMut<StatusNote>) {
    if !workspace.shows_live {
        note.set_if_neq(StatusNote(None));
    }
}
