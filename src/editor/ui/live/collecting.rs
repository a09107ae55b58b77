//! Where samples were taken, and what is still missing.

use super::{fact_ui, state_ui};
use crate::calibration::coverage::CoverageSummary;
use crate::editor::live::collected::Collected;
use crate::editor::live::{LiveDesk, LiveRequest};
use crate::editor::palette;
use crate::editor::ui::widgets::{THIN_SPACE, count, decimal, quiet_ui, section_ui};
use bevy_egui::egui::{self, ProgressBar, Ui};
use nalgebra::{Unit, Vector3};

/// Basis orientations that are named: where most are missing.
const NAMED_DIRECTIONS: usize = 6;

/// Draws the section.
pub fn collecting_ui(ui: &mut Ui, desk: &LiveDesk) -> Vec<LiveRequest> {
    let mut asked = Vec::new();
    section_ui(ui, "Collecting");
    let Some(collected) = &desk.collected else {
        quiet_ui(
            ui,
            "While something is recorded, the volume fills here and in the scene where samples \
             have been taken.",
        );
        return asked;
    };
    let summary = &collected.summary;
    let part = summary.cells_sampled as f32 / summary.cells.max(1) as f32;
    let text = format!(
        "{} of {} cells",
        count(summary.cells_sampled),
        count(summary.cells)
    );
    ui.add(ProgressBar::new(part).text(text).desired_height(18.0));
    let size = collected.cell_mm;
    let cell = format!(
        "{:.0} × {:.0} × {:.0}{THIN_SPACE}mm",
        size.x, size.y, size.z
    );
    fact_ui(ui, "a cell", &cell);
    fact_ui(ui, "samples", &whole(summary.samples));
    fact_ui(ui, "not like one before", &whole(summary.distinct));
    if summary.outside > 0 {
        fact_ui(ui, "outside the volume", &whole(summary.outside));
    }
    missing_ui(ui, collected);
    ui.add_space(4.0);
    if ui.button("Start over").clicked() {
        asked.push(LiveRequest::StartOver);
    }
    asked
}

fn missing_ui(ui: &mut Ui, collected: &Collected) {
    let summary = &collected.summary;
    section_ui(ui, "Still missing");
    match &collected.next_mm {
        Some(next) => {
            let at = format!("{:.0}, {:.0}, {:.0}{THIN_SPACE}mm", next.x, next.y, next.z);
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
    fact_ui(
        ui,
        "sensor's axis never along",
        &format!("{unseen} of {of}"),
    );
    let most = summary
        .by_direction
        .iter()
        .map(|(_, n)| *n)
        .max()
        .unwrap_or(0);
    let mut fewest: Vec<_> = summary.by_direction.iter().collect();
    fewest.sort_by_key(|(_, n)| *n);
    quiet_ui(ui, "fewest samples with the axis along");
    for (direction, samples) in fewest.into_iter().take(NAMED_DIRECTIONS) {
        ui.horizontal(|ui| {
            let size = egui::vec2(130.0, ui.spacing().interact_size.y);
            ui.allocate_ui_with_layout(
                size,
                egui::Layout::left_to_right(egui::Align::Center),
                |ui| {
                    ui.set_min_width(size.x);
                    ui.label(along(direction));
                },
            );
            let part = *samples as f32 / most.max(1) as f32;
            ui.add(
                ProgressBar::new(part)
                    .text(whole(*samples))
                    .desired_height(14.0),
            );
        });
    }
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
