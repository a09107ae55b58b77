//! The page of error against run time: a family at a time, as chart and table.

use crate::palette;
use crate::palette::ThemedColor;
use crate::widgets::basic::{quiet_ui, warning_ui};
use crate::widgets::chart::chart_ui;
use crate::widgets::tooltip::button_ui;
use crate::workspaces::study::precision::{PrecisionPage, PrecisionRequest};
use bevy_egui::egui::{self, Align, Context, Grid, Layout, ProgressBar, RichText, ScrollArea, Ui};
use trackwright_accuracy::precision::{Family, Row, page};

const WIDTH: f32 = 720.0;
const TITLE_SIZE: f32 = 15.0;
const CHART_HEIGHT: f32 = 260.0;
const TABLE_HEIGHT: f32 = 180.0;

/// As [`page::cells`] has them.
const COLUMNS: [&str; 8] = ["", "method", "order", "orientations", "size", "time", "each", "error"];

/// Draws the page as a window of its own; the person's requests.
pub fn precision_window(
    ctx: &Context,
    page: &PrecisionPage,
    is_current: bool,
) -> Vec<PrecisionRequest> {
    let mut requests = Vec::new();
    let mut is_open = true;
    egui::Window::new(RichText::new("Error against run time").size(TITLE_SIZE))
        .id(egui::Id::new("precision"))
        .open(&mut is_open)
        .default_width(WIDTH)
        .resizable(false)
        .collapsible(false)
        .anchor(egui::Align2::CENTER_CENTER, egui::Vec2::ZERO)
        .show(ctx, |ui| {
            ui.set_width(WIDTH);
            requests.extend(precision_ui(ui, page, is_current));
        });
    if !is_open {
        requests.push(PrecisionRequest::Close);
    }
    requests
}

/// The page's inside. `is_current`: the open design is still the measured one.
pub fn precision_ui(ui: &mut Ui, page: &PrecisionPage, is_current: bool) -> Vec<PrecisionRequest> {
    let mut requests = Vec::new();
    head_ui(ui, page, is_current, &mut requests);
    ui.separator();
    if page.families.is_empty() {
        quiet_ui(
            ui,
            "How much error each way of computing costs, and how much time it saves, for this \
             design in this room on this machine. Measuring takes about a minute.",
        );
        return requests;
    }
    ui.horizontal(|ui| {
        for family in &page.families {
            let is_shown = family.what == page.shown;
            if ui.selectable_label(is_shown, family.what.title()).clicked() {
                requests.push(PrecisionRequest::Show(family.what));
            }
        }
    });
    let shown = page.families.iter().find(|f| f.what == page.shown);
    if let Some(family) = shown.or(page.families.first()) {
        family_ui(ui, family);
    }
    requests
}

fn head_ui(
    ui: &mut Ui,
    shown: &PrecisionPage,
    is_current: bool,
    requests: &mut Vec<PrecisionRequest>,
) {
    ui.horizontal(|ui| {
        match &shown.of {
            None => quiet_ui(ui, "not measured yet"),
            Some((design, ..)) => quiet_ui(ui, design),
        };
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| match shown.part() {
            Some(part) => {
                if button_ui(ui, "Cancel", "Stops measuring").clicked() {
                    requests.push(PrecisionRequest::Cancel);
                }
                ui.add(ProgressBar::new(part as f32).desired_width(180.0));
            }
            None => {
                let text = match shown.families.is_empty() {
                    true => "Measure",
                    false => "Measure again",
                };
                let about = "Computes the study in each way, with its error and its run time";
                if button_ui(ui, text, about).clicked() {
                    requests.push(PrecisionRequest::Measure);
                }
            }
        });
    });
    if let Some(machine) = &shown.machine {
        quiet_ui(ui, page::machine(machine));
    }
    if shown.of.is_some() && !is_current {
        warning_ui(ui, "The design has changed since it was measured");
    }
    if let Some(problem) = &shown.problem {
        warning_ui(ui, problem);
    }
}

fn family_ui(ui: &mut Ui, family: &Family) {
    if let Some(reason) = &family.left_out {
        quiet_ui(ui, format!("Left out: {reason}"));
        return;
    }
    ui.label(RichText::new(&family.about).color(palette::TEXT_QUIET.color32()));
    ui.add_space(4.0);
    chart_ui(ui, &page::chart(family), CHART_HEIGHT);
    ui.add_space(4.0);
    ScrollArea::vertical()
        .max_height(TABLE_HEIGHT)
        // The window keeps its size from one family to the next.
        .min_scrolled_height(TABLE_HEIGHT)
        .auto_shrink(false)
        .show(ui, |ui| {
            Grid::new(("precision", family.what))
                .striped(true)
                .num_columns(COLUMNS.len())
                .spacing([16.0, 3.0])
                .show(ui, |ui| {
                    for problem in page::problems(family) {
                        ui.label("");
                        ui.label(RichText::new(problem).color(palette::TEXT_STRONG.color32()));
                        ui.end_row();
                        for name in COLUMNS {
                            quiet_ui(ui, name);
                        }
                        ui.end_row();
                        for row in page::rows_of(family, problem) {
                            row_ui(ui, row);
                        }
                    }
                });
        });
}

fn row_ui(ui: &mut Ui, row: &Row) {
    let color = match row.is_default {
        true => palette::TEXT_STRONG,
        false => palette::TEXT,
    };
    for cell in page::cells(row) {
        ui.label(RichText::new(cell).color(color.color32()));
    }
    ui.end_row();
}
