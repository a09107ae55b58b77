//! What was tried by cross-validation: the paper's Fig. 3, and its table.

use crate::palette;
use crate::palette::ThemedColor;
use crate::widgets::basic::{quiet_ui, section_ui};
use crate::widgets::chart::chart_ui;
use crate::widgets::tooltip::button_ui;
use crate::workspaces::field::requests::FieldRequest;
use crate::workspaces::field::state::Fitted;
use bevy_egui::egui::{self, Align, Context, Grid, Label, Layout, RichText, ScrollArea, Ui};
use trackwright_report::selection::{head, notes, reason, rows};
use trackwright_report::selection_chart::chart;

const CHART_TITLE: &str = "Model error on unseen data, by order";

const PANEL_HEIGHT: f32 = 210.0;
const WINDOW_WIDTH: f32 = 760.0;
const WINDOW_CHART_HEIGHT: f32 = 300.0;
const TABLE_HEIGHT: f32 = 240.0;
const TITLE_SIZE: f32 = 15.0;

/// Draws Fig. 3 as large as a panel allows.
pub fn selection_ui(ui: &mut Ui, fitted: &Fitted) -> Vec<FieldRequest> {
    let mut requests = Vec::new();
    let Some(chosen) = &fitted.decided.chosen else {
        return requests;
    };
    section_ui(ui, CHART_TITLE);
    let mut figure = chart(&fitted.training.name(), &chosen.selection);
    // The axes' names take a third of a panel's width; they stand in the window.
    figure.x.label = "order".to_owned();
    figure.y.label = "position RMS, mm".to_owned();
    chart_ui(ui, &figure, PANEL_HEIGHT);
    if button_ui(ui, "Figure and table…", "Shows the figure large, with its numbers").clicked() {
        requests.push(FieldRequest::ShowSelection(true));
    }
    requests
}

/// Shows Fig. 3 with its table in a window over the scene; the person's requests, and where the
/// window stands. It takes some frames until it stands where its contents want it.
pub fn selection_window(ctx: &Context, fitted: &Fitted) -> (Vec<FieldRequest>, Option<egui::Rect>) {
    let mut requests = Vec::new();
    let mut is_open = true;
    let window = egui::Window::new(RichText::new(CHART_TITLE).size(TITLE_SIZE))
        .id(egui::Id::new("selection window"))
        .open(&mut is_open)
        .default_width(WINDOW_WIDTH)
        .resizable(false)
        .collapsible(false)
        .anchor(egui::Align2::CENTER_CENTER, egui::Vec2::ZERO)
        .show(ctx, |ui| page_ui(ui, fitted));
    if !is_open {
        requests.push(FieldRequest::ShowSelection(false));
    }
    (requests, window.map(|window| window.response.rect))
}

fn page_ui(ui: &mut Ui, fitted: &Fitted) {
    let Some(chosen) = &fitted.decided.chosen else { return };
    let selection = &chosen.selection;
    ui.set_width(WINDOW_WIDTH);
    chart_ui(ui, &chart(&fitted.training.name(), selection), WINDOW_CHART_HEIGHT);
    ui.add_space(8.0);
    ScrollArea::vertical().max_height(TABLE_HEIGHT).auto_shrink([false, true]).show(ui, |ui| {
        Grid::new("selection").striped(true).spacing([14.0, 2.0]).show(ui, |ui| {
            for name in head(selection) {
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                    quiet_ui(ui, name.trim());
                });
            }
            ui.end_row();
            for row in rows(selection) {
                let color = match row.is_chosen {
                    true => palette::MET,
                    false => palette::TEXT,
                };
                for cell in row.cells {
                    crate::workspaces::field::panels::cell_ui(
                        ui,
                        with_thin_spaces(&cell),
                        color.color32(),
                    );
                }
                let mark = if row.is_chosen { "chosen" } else { "" };
                ui.label(RichText::new(mark).color(color.color32()));
                ui.end_row();
            }
        });
    });
    ui.add_space(6.0);
    for note in notes(selection) {
        quiet_ui(ui, note);
    }
    let why = reason(selection, chosen.by.as_deref(), chosen.tried.folds);
    ui.add(Label::new(why).wrap());
}

/// Units as this interface writes them.
fn with_thin_spaces(cell: &str) -> String {
    cell.replace(" mm", "\u{2009}mm").replace(" °", "°")
}
