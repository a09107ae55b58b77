//! The plate that shows what will happen with files that hover over the window.

use crate::document::drops::HoveringFiles;
use crate::palette;
use crate::palette::ThemedColor;
use crate::schedule::UiSystems;
use crate::widgets::basic::counted;
use crate::widgets::theme;
use bevy::prelude::*;
use bevy_egui::egui::{self, Align2, Area, Context, Id, Margin, Order, RichText, Stroke};
use bevy_egui::{EguiContexts, EguiPrimaryContextPass};

/// Files that are named.
const MOST_LINES: usize = 4;

const WIDTH: f32 = 460.0;

pub(crate) fn plugin(app: &mut App) {
    app.add_systems(
        EguiPrimaryContextPass,
        plate.run_if(are_files_hovering).in_set(UiSystems::Dialogs),
    );
}

fn are_files_hovering(hovering: Option<Res<HoveringFiles>>) -> bool {
    hovering.is_some_and(|hovering| !hovering.0.is_empty())
}

fn plate(mut contexts: EguiContexts, hovering: Res<HoveringFiles>) -> Result {
    drop_plate_ui(contexts.ctx_mut()?, &hovering);
    Ok(())
}

/// Draws the plate in the middle of the window while files hover.
pub fn drop_plate_ui(ctx: &Context, hovering: &HoveringFiles) {
    let files = &hovering.0;
    if files.is_empty() {
        return;
    }
    Area::new(Id::new("drop plate"))
        .order(Order::Tooltip)
        .anchor(Align2::CENTER_CENTER, [0.0, 0.0])
        .interactable(false)
        .show(ctx, |ui| {
            egui::Frame::new()
                .fill(palette::PANEL.color32())
                .stroke(Stroke::new(1.0, palette::ACCENT.color32()))
                .corner_radius(6.0)
                .inner_margin(Margin::symmetric(22, 16))
                .show(ui, |ui| {
                    ui.set_max_width(WIDTH);
                    for line in files.iter().take(MOST_LINES) {
                        let text = RichText::new(line).color(palette::TEXT_STRONG.color32());
                        ui.add(egui::Label::new(text).wrap());
                    }
                    if files.len() > MOST_LINES {
                        let more = counted(files.len() - MOST_LINES, "more file", "more files");
                        let text = RichText::new(format!("and {more}"))
                            .font(theme::label_font())
                            .color(palette::TEXT_QUIET.color32());
                        ui.label(text);
                    }
                });
        });
}
