//! What the panels of the Study workspace are drawn from, put together.

use crate::document::shown::{LIVE, ShownTrial};
use crate::document::trials::{ModeKind, TrialChoice};
use crate::runner::results::Results;
use crate::shell::PanelAction;
use crate::widgets::basic::count;
use crate::workspaces::study::desk::{Side, StudyDesk, StudyRequest};
use crate::workspaces::study::log::LogJob;
use crate::workspaces::study::study_charts_ui::{StudyChartsView, study_charts_ui};
use crate::workspaces::study::timeline_ui::{TimelineView, timeline_ui};
use crate::workspaces::study::trial_ui::{TrialView, trial_ui};
use bevy_egui::egui::{Button, Ui};
use trackwright_design::{Design, Document};

/// Everything that they read.
pub struct StudyPanels<'a> {
    pub document: &'a Document,
    pub results: &'a Results,
    pub choice: &'a TrialChoice,
    pub desk: &'a StudyDesk,
    /// The trial that the scene shows.
    pub trial: Option<&'a ShownTrial>,
    pub log: &'a LogJob,
}

impl StudyPanels<'_> {
    fn design(&self) -> &Design {
        self.document.design()
    }

    fn kind(&self) -> ModeKind {
        self.choice.kind(self.design().motion.is_some())
    }

    fn pose_title(&self) -> String {
        match self.results.pose_trial.filter(|number| *number < LIVE) {
            Some(number) => format!("Trial {}", count(number + 1)),
            None => "The design's own pose".to_owned(),
        }
    }

    /// The panel at the bottom.
    pub fn timeline(&self, ui: &mut Ui) -> Vec<PanelAction> {
        let study = self.results.study.as_ref();
        let profile = self.results.profile.as_ref();
        timeline_ui(
            ui,
            &TimelineView {
                kind: self.kind(),
                has_motion: self.design().motion.is_some(),
                input: self.choice.input().map(|input| input.name.as_str()),
                trials: study.map_or(0, |study| study.value.figures.trials),
                shown: self.trial,
                profile: profile.map(|profile| &profile.value),
                is_computing: self.results.problem.is_none() && self.are_trials_old(),
                is_playing: self.choice.is_playing(),
                rate_per_s: self.desk.rate_per_s,
                log_part: self.log.part(),
            },
        )
    }

    /// The shown trial in numbers, and charts of all of them.
    pub fn trials(&self, ui: &mut Ui) -> Vec<PanelAction> {
        let requirement = self.design().requirement;
        let mut actions = trial_ui(
            ui,
            &TrialView {
                trial: self.results.pose.as_ref().map(|pose| &pose.value.trial),
                title: self.pose_title(),
                columns: ["true", "simulated"],
                rotation: self.desk.rotation,
                has_crf: self.design().crf.is_some(),
                limit_mm: requirement.and_then(|r| Some(r.single_position_mm()?.1)),
            },
        );
        if let Some(profile) = &self.results.profile {
            actions.extend(study_charts_ui(
                ui,
                &StudyChartsView {
                    charted: &profile.value,
                    axis: self.desk.axis,
                    shown: self.trial.map(|trial| trial.number),
                },
            ));
        }
        actions
    }

    /// Whether the figures are of the design as it was, or of another mode.
    pub fn are_figures_old(&self) -> bool {
        let revision = self.document.revision();
        let study = self.results.study.as_ref();
        study.is_none_or(|study| study.revision != revision)
            || self.results.mode != Some(self.kind())
    }

    /// Whether the trials that are charted are; during a drag they stay what they were.
    fn are_trials_old(&self) -> bool {
        let revision = self.document.revision();
        let profile = self.results.profile.as_ref();
        self.are_figures_old()
            || !self.results.is_whole()
            || profile.is_some_and(|profile| profile.revision != revision)
    }
}

/// Which of two things stands above the result.
pub fn sides_ui(ui: &mut Ui, shown: Side) -> Vec<PanelAction> {
    let mut actions = Vec::new();
    ui.horizontal(|ui| {
        for (side, name, about) in [
            (Side::Trials, "Trials", "The shown trial in numbers, and charts of all trials"),
            (Side::Inspector, "Inspector", "What is selected, to be edited"),
        ] {
            let tab = Button::selectable(side == shown, name);
            if ui.add(tab).on_hover_text(about).clicked() && side != shown {
                actions.push(PanelAction::Study(StudyRequest::ShowSide(side)));
            }
        }
    });
    actions
}
