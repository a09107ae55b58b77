//! The panels of the workspace, put together.

use crate::document::shown::LIVE;
use crate::runner::results::Results;
use crate::shell::PanelAction;
use crate::workspaces::live::desk::LiveDesk;
use crate::workspaces::live::panels::collecting::collecting_ui;
use crate::workspaces::live::panels::tools::tools_ui;
use crate::workspaces::live::panels::tracker::{recording_ui, tracker_ui};
use crate::workspaces::study::desk::RotationForm;
use crate::workspaces::study::trial_ui::{TrialView, trial_ui};
use bevy_egui::egui::{ScrollArea, Ui};
use trackwright_design::{BodyRole, Design};
use trackwright_openigtlink::relay::ToolState;
use trackwright_openigtlink::roles::base_name;

/// Everything that they show.
pub struct LivePanels<'a> {
    pub desk: &'a LiveDesk,
    pub design: &'a Design,
    pub results: &'a Results,
    pub rotation: RotationForm,
}

impl LivePanels<'_> {
    /// The tracker, its tools, the recording.
    pub fn left(&self, ui: &mut Ui) -> Vec<PanelAction> {
        let mut asked = tracker_ui(ui, self.desk);
        asked.extend(tools_ui(ui, self.desk, self.design));
        asked.extend(recording_ui(ui, self.desk));
        asked.into_iter().map(PanelAction::Live).collect()
    }

    /// Where the tool is, and where samples were taken.
    pub fn right(&self, ui: &mut Ui) -> Vec<PanelAction> {
        // The panel is as wide as it is, whatever is in it.
        ui.set_min_width(ui.available_width());
        let area = ScrollArea::vertical().auto_shrink(false);
        let shown = area.show(ui, |ui| {
            let mut actions = self.pose().map_or_else(Vec::new, |view| trial_ui(ui, &view));
            let asked = collecting_ui(ui, self.desk);
            actions.extend(asked.into_iter().map(PanelAction::Live));
            ui.add_space(8.0);
            actions
        });
        shown.inner
    }

    /// The tool where it was heard; what is told of it beside where that puts it.
    fn pose(&self) -> Option<TrialView<'_>> {
        let is_heard = self.results.pose_trial.is_some_and(|number| number >= LIVE);
        let pose = self.results.pose.as_ref().filter(|_| is_heard)?;
        let troubles = self.desk.troubles(self.design);
        let is_now = troubles.iter().all(|(role, _)| *role != BodyRole::Tool);
        let title = if is_now { "The tool now" } else { "The tool at its last good pose" };
        Some(TrialView {
            trial: Some(&pose.value.trial),
            title: title.to_owned(),
            columns: ["compensated", "measured"],
            rotation: self.rotation,
            has_crf: self.design.crf.is_some(),
            limit_mm: None,
        })
    }

    /// How the tools that are the design's bodies are, for the status line.
    pub fn words(&self) -> Option<String> {
        let seen = (self.desk.seen.as_ref()).filter(|_| self.desk.is_connected())?;
        let of_bodies = seen.tools.iter().filter(|(_, view)| view.role.is_some());
        let words: Vec<String> = of_bodies
            .map(|(name, view)| match view.state {
                ToolState::Good => format!("{} good", base_name(name)),
                ToolState::NotGood(reason) => format!("{} not good: {reason}", base_name(name)),
            })
            .collect();
        (!words.is_empty()).then(|| words.join(" · "))
    }
}
