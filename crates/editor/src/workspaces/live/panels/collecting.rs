//! Where samples were taken, and what is still missing.

use crate::palette;
use crate::palette::ThemedColor;
use crate::widgets::basic::{THIN_SPACE, count, decimal, fact_ui, quiet_ui, section_ui, state_ui};
use crate::widgets::tooltip::button_ui;
use crate::workspaces::live::collected::Collected;
use crate::workspaces::live::requests::LiveRequest;
use crate::workspaces::live::state::LiveState;
use bevy_egui::egui::{self, Sense, Ui, vec2};
use nalgebra::{Unit, Vector3};
use trackwright_calibration::coverage::CoverageSummary;

/// Basis orientations that are named: where most are missing.
const NAMED_DIRECTIONS: usize = 6;

const COUNT_WIDTH: f32 = 36.0;

/// Draws the section.
pub fn collecting_ui(ui: &mut Ui, state: &LiveState) -> Vec<LiveRequest> {
    let mut requests = Vec::new();
    section_ui(ui, "Collecting");
    let Some(collected) = &state.collected else {
        quiet_ui(
            ui,
            "While something is recorded, the volume fills here and in the scene where samples \
             have been taken.",
        );
        return requests;
    };
    let summary = &collected.summary;
    let part = summary.cells_sampled as f32 / summary.cells.max(1) as f32;
    bar_ui(ui, part);
    let cells = format!("{} of {}", count(summary.cells_sampled), count(summary.cells));
    fact_ui(ui, "cells with samples", &cells);
    let size = collected.cell_mm;
    let cell = format!("{:.0} × {:.0} × {:.0}{THIN_SPACE}mm", size.x, size.y, size.z);
    fact_ui(ui, "a cell", &cell);
    quiet_ui(ui, "The brighter a block, the more ways turned it was sampled.");
    fact_ui(ui, "samples", &whole(summary.samples));
    fact_ui(ui, "not like one before", &whole(summary.distinct));
    if summary.outside > 0 {
        fact_ui(ui, "outside the volume", &whole(summary.outside));
    }
    missing_ui(ui, collected);
    ui.add_space(4.0);
    if button_ui(ui, "Start over", "Forgets the samples that were collected").clicked() {
        requests.push(LiveRequest::StartOver);
    }
    requests
}

fn missing_ui(ui: &mut Ui, collected: &Collected) {
    let summary = &collected.summary;
    section_ui(ui, "Still missing");
    match &collected.next_mm {
        Some(next) => {
            let at = [next.x, next.y, next.z].map(|v| decimal(v, 0));
            let at = format!("{}{THIN_SPACE}mm", at.join(", "));
            fact_ui(ui, "emptiest place, framed", &at);
        }
        None => state_ui(ui, "no place: every cell is sampled", palette::MET),
    }
    directions_ui(ui, summary);
    let order = match summary.highest_order() {
        None => "none yet".to_owned(),
        Some(order) => {
            let each = decimal(summary.samples_per_unknown(order), 1);
            format!("order {order}, {each} samples an unknown")
        }
    };
    fact_ui(ui, "enough for", &order);
}

/// The orientations with the fewest samples, as bars against the most.
fn directions_ui(ui: &mut Ui, summary: &CoverageSummary) {
    let unseen = summary.by_direction.iter().filter(|(_, n)| *n == 0).count();
    let of = summary.by_direction.len();
    fact_ui(ui, "sensor's axis never along", &format!("{unseen} of {of}"));
    let most = summary.by_direction.iter().map(|(_, n)| *n).max().unwrap_or(0);
    let mut fewest: Vec<_> = summary.by_direction.iter().collect();
    fewest.sort_by_key(|(_, n)| *n);
    quiet_ui(ui, "fewest samples with the axis along");
    for (direction, samples) in fewest.into_iter().take(NAMED_DIRECTIONS) {
        ui.horizontal(|ui| {
            let size = vec2(130.0, ui.spacing().interact_size.y);
            ui.allocate_ui_with_layout(
                size,
                egui::Layout::left_to_right(egui::Align::Center),
                |ui| {
                    ui.set_min_width(size.x);
                    ui.label(along(direction));
                },
            );
            let part = *samples as f32 / most.max(1) as f32;
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let size = vec2(COUNT_WIDTH, ui.spacing().interact_size.y);
                let layout = egui::Layout::right_to_left(egui::Align::Center);
                ui.allocate_ui_with_layout(size, layout, |ui| {
                    ui.set_min_width(COUNT_WIDTH);
                    ui.label(whole(*samples));
                });
                bar_ui(ui, part);
            });
        });
    }
}

/// How much of something there is, as wide as there is room.
fn bar_ui(ui: &mut Ui, part: f32) {
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 6.0), Sense::hover());
    let painter = ui.painter();
    painter.rect_filled(rect, 2.0, palette::LINE.color32());
    let mut full = rect;
    full.set_width(rect.width() * part.clamp(0.0, 1.0));
    painter.rect_filled(full, 2.0, palette::ACCENT.color32());
}

fn whole(number: u64) -> String {
    count(usize::try_from(number).unwrap_or(usize::MAX))
}

/// `+x`, or its components where it is along no axis.
fn along(direction: &Unit<Vector3<f64>>) -> String {
    for (name, axis) in ["x", "y", "z"].iter().zip(0..3) {
        if direction[axis].abs() > 0.999 {
            let sign = if direction[axis] > 0.0 { "+" } else { "−" };
            return format!("{sign}{name}");
        }
    }
    let parts = [0, 1, 2].map(|axis| decimal(direction[axis], 2));
    format!("({})", parts.join(", "))
}
