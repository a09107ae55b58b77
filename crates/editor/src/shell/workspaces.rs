//! The side panels of the workspaces that have their own: Field, Live, Decide.

use crate::layers::layers_ui::Listed;
use crate::shell::PanelAction;
use crate::shell::layout::Desk;
use crate::widgets::theme;
use crate::workspaces::decide::panels::DecideView;
use crate::workspaces::decide::panels::baseline_ui::baseline_ui;
use crate::workspaces::decide::panels::steps_ui::steps_ui;
use crate::workspaces::design::result::brief_result_ui;
use crate::workspaces::field::panels::rooms::rooms_ui;
use crate::workspaces::field::panels::selection::selection_ui;
use crate::workspaces::field::panels::settings::settings_ui;
use crate::workspaces::field::panels::table::tables_ui;
use crate::workspaces::field::panels::worth::{comparison_ui, worth_ui};
use crate::workspaces::live::panels::panels::LivePanels;
use bevy_egui::egui::{self, Margin, Panel, ScrollArea};

impl Desk<'_> {
    /// The design's figures stand below the rooms: a click on a room shows what it does to them.
    pub(crate) fn field_left_ui(&self, ui: &mut egui::Ui, actions: &mut Vec<PanelAction>) {
        Panel::bottom("result in room")
            .resizable(false)
            .frame(theme::panel_frame(Margin::symmetric(0, 8)))
            .show(ui, |ui| brief_result_ui(ui, &self.result_view()));
        let desk = &self.shown.field;
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            let mut asked = tables_ui(ui, desk, *self.shown.sample_scale);
            asked.extend(rooms_ui(ui, desk));
            actions.extend(asked.into_iter().map(PanelAction::Field));
            actions.extend(self.layers_ui(ui, Listed::OfTheRoom));
            ui.add_space(8.0);
        });
    }

    pub(crate) fn field_right_ui(&self, ui: &mut egui::Ui, actions: &mut Vec<PanelAction>) {
        let desk = &self.shown.field;
        // The panel is as wide as it is, whatever is in it.
        ui.set_min_width(ui.available_width());
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            let mut asked = settings_ui(ui, desk);
            asked.extend(worth_ui(ui, desk));
            if let Some(comparison) = &desk.comparison {
                let is_current = comparison.generation == self.shown.generation.0
                    && comparison.revision == self.world.document.revision();
                comparison_ui(ui, comparison, is_current);
            }
            if let Some(fitted) = &desk.fitted {
                asked.extend(selection_ui(ui, fitted));
            }
            actions.extend(asked.into_iter().map(PanelAction::Field));
            ui.add_space(8.0);
        });
    }

    /// The tracker above what is drawn of it.
    pub(crate) fn live_left_ui(&self, ui: &mut egui::Ui, actions: &mut Vec<PanelAction>) {
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            actions.extend(self.live().left(ui));
            actions.extend(self.layers_ui(ui, Listed::All));
            ui.add_space(8.0);
        });
    }

    /// What the panels of the Live workspace are drawn from.
    pub(crate) fn live(&self) -> LivePanels<'_> {
        LivePanels {
            desk: &self.shown.live,
            design: self.design(),
            results: &self.shown.results,
            rotation: self.shown.desk.rotation,
        }
    }

    /// What the panels of the Decide workspace are drawn from.
    pub(crate) fn decide(&self) -> DecideView<'_> {
        DecideView {
            document: &self.world.document,
            generation: self.shown.generation.0,
            results: &self.shown.results,
            desk: &self.shown.decide,
            against: self.shown.against.as_deref(),
            judged: self.shown.judged.as_deref(),
            environment: &self.environment().name,
            rooms: &self.shown.field.rooms,
            is_listing: self.shown.field.listing.is_some(),
        }
    }

    /// The procedure.
    pub(crate) fn decide_left_ui(&self, ui: &mut egui::Ui, actions: &mut Vec<PanelAction>) {
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            let asked = steps_ui(ui, &self.decide());
            actions.extend(asked.into_iter().map(PanelAction::Decide));
            ui.add_space(8.0);
        });
    }

    pub(crate) fn decide_right_ui(&self, ui: &mut egui::Ui, actions: &mut Vec<PanelAction>) {
        Panel::bottom("result")
            .resizable(false)
            .frame(crate::workspaces::design::result::frame())
            .show(ui, |ui| brief_result_ui(ui, &self.result_view()));
        egui::Frame::new().inner_margin(Margin::symmetric(12, 0)).show(ui, |ui| {
            ui.set_min_width(ui.available_width());
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                let asked = baseline_ui(ui, &self.decide());
                actions.extend(asked.into_iter().map(PanelAction::Decide));
                ui.add_space(8.0);
            });
        });
    }
}
