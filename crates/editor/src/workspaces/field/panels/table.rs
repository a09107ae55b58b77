//! The measurement tables: what is in them, and how their samples are shown.

use crate::layers::slice_picture::ColorScale;
use crate::palette::ThemedColor;
use crate::palette::{self, Rgb};
use crate::widgets::basic::{
    THIN_SPACE, count, counted, decimal, fact_ui, length, quiet_ui, section_ui, warning_ui,
};
use crate::widgets::theme;
use crate::widgets::tooltip::{Explain, button_ui, checkbox_ui};
use crate::workspaces::field::requests::FieldRequest;
use crate::workspaces::field::samples::{SampleScale, stride};
use crate::workspaces::field::state::{FieldState, SamplesShown, TableRole};
use crate::workspaces::field::state::{SampleValue, Table};
use bevy_egui::egui::{
    self, Align, ComboBox, Layout, Mesh, ProgressBar, RichText, Sense, Shape, Ui,
};
use bevy_egui::egui::{pos2, vec2};
use trackwright_formats::printable::printable;
use trackwright_project::file_name;

const BAR_HEIGHT: f32 = 8.0;

/// Draws both tables and how their samples are shown.
pub fn tables_ui(ui: &mut Ui, state: &FieldState, scale: SampleScale) -> Vec<FieldRequest> {
    let mut requests = Vec::new();
    if state.is_drop_near {
        drop_ui(ui);
    }
    table_ui(ui, state, TableRole::Training, &mut requests);
    table_ui(ui, state, TableRole::HeldOut, &mut requests);
    samples_ui(ui, state, scale, &mut requests);
    requests
}

fn drop_ui(ui: &mut Ui) {
    egui::Frame::new()
        .stroke(egui::Stroke::new(1.0, palette::ACCENT.color32()))
        .corner_radius(3.0)
        .inner_margin(8.0)
        .show(ui, |ui| {
            ui.set_width(ui.available_width());
            ui.label("Drop to open these measurements");
        });
}

fn table_ui(ui: &mut Ui, state: &FieldState, role: TableRole, requests: &mut Vec<FieldRequest>) {
    let (title, button, what) = match role {
        TableRole::Training => (
            "Measurements",
            "Open measurements…",
            "Drop a measurement table (CSV) onto the window, or open one",
        ),
        TableRole::HeldOut => (
            "Held-out measurements",
            "Open held-out…",
            "A second table judges the fit on what it has not seen",
        ),
    };
    section_ui(ui, title);
    let slot = state.slot(role);
    match (&slot.table, &slot.reading) {
        (Some(table), _) => {
            facts_ui(ui, table, role, requests);
            as_is_ui(ui, table, state.as_is.contains(&table.file), requests);
        }
        (None, Some(_)) => {}
        (None, None) => {
            ui.add(egui::Label::new(quiet(what)).wrap());
        }
    }
    if let Some(reading) = &slot.reading {
        quiet_ui(ui, format!("reading {}", file_name(&reading.file)));
        ui.horizontal(|ui| {
            let part = reading.job.progress() as f32;
            ui.add(ProgressBar::new(part).desired_width(ui.available_width() - 62.0));
            if button_ui(ui, "Cancel", "Stops reading the table").clicked() {
                requests.push(FieldRequest::Close(role));
            }
        });
    } else if slot.table.is_none()
        && button_ui(ui, button, "Opens a table of measurements; one can also be dropped here")
            .clicked()
    {
        requests.push(FieldRequest::ShowOpen(role));
    }
}

fn quiet(text: &str) -> RichText {
    RichText::new(text).font(theme::label_font()).color(palette::TEXT_QUIET.color32())
}

fn facts_ui(ui: &mut Ui, table: &Table, role: TableRole, requests: &mut Vec<FieldRequest>) {
    ui.horizontal(|ui| {
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let close = ui.small_button("✖").explained("Puts the table away");
            if close.clicked() {
                requests.push(FieldRequest::Close(role));
            }
            let other = ui.small_button("…").explained("Opens another table");
            if other.clicked() {
                requests.push(FieldRequest::ShowOpen(role));
            }
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                let name =
                    RichText::new(printable(&table.name())).color(palette::TEXT_STRONG.color32());
                ui.add(egui::Label::new(name).truncate())
                    .explained(table.file.display().to_string());
            });
        });
    });
    let set = &table.samples;
    let samples = counted(set.samples.len(), "sample", "samples");
    let orientations = match (set.has_rotations, table.reading.has_rolls) {
        (false, _) => "no orientations",
        (true, false) => "5-DOF axes",
        (true, true) => "6-DOF rotations",
    };
    fact_ui(ui, &samples, orientations);
    // The model's box is that of the samples it is fitted to.
    if let Some(bounds) = table.bounds.as_ref().filter(|_| role == TableRole::Training) {
        for (k, name) in ["x", "y", "z"].into_iter().enumerate() {
            let range = range(bounds.min_mm[k], bounds.max_mm[k]);
            fact_ui(ui, name, &range);
        }
    }
    fact_ui(ui, "measured error RMS", &length(table.measured.rms.position_rms_mm));
    match &table.groups {
        Ok(None) => {}
        Ok(Some(groups)) => {
            fact_ui(ui, "groups", &format!("{} by {}", count(groups.count), groups.column.name));
        }
        Err(error) => {
            warning_ui(ui, &format!("no groups: {error}"));
        }
    }
    for suspicion in &table.suspicions {
        warning_ui(ui, &suspicion.to_string());
    }
    if set.ambiguous > 0 {
        warning_ui(
            ui,
            &format!(
                "{} opposite axes: their orientation error is ambiguous",
                counted(set.ambiguous, "sample has", "samples have")
            ),
        );
    }
}

/// A switch for a table that is not fitted otherwise.
fn as_is_ui(ui: &mut Ui, table: &Table, mut is_taken: bool, requests: &mut Vec<FieldRequest>) {
    if !table.is_beyond_doubt() {
        return;
    }
    let switch = ui
        .checkbox(&mut is_taken, "take it as it stands")
        .explained("Fits it although no tracker's table is like it");
    if switch.changed() {
        requests.push(FieldRequest::TakeAsIs(table.file.clone(), is_taken));
    }
}

/// `−250.0 to 250.0 mm`.
fn range(min_mm: f64, max_mm: f64) -> String {
    format!("{} to {}{THIN_SPACE}mm", decimal(min_mm, 1), decimal(max_mm, 1))
}

fn samples_ui(
    ui: &mut Ui,
    state: &FieldState,
    SampleScale(scale): SampleScale,
    requests: &mut Vec<FieldRequest>,
) {
    let has = |role| state.slot(role).table.is_some();
    let Some(scale) = scale.filter(|_| TableRole::ALL.into_iter().any(has)) else {
        return;
    };
    section_ui(ui, "Samples in the view");
    let before = state.shown;
    let mut shown = before;
    ui.horizontal(|ui| {
        ui.add_enabled_ui(has(TableRole::Training), |ui| {
            checkbox_ui(ui, &mut shown.training, "fitted", "Draws the samples that are fitted");
        });
        ui.add_enabled_ui(has(TableRole::HeldOut), |ui| {
            let about = "Draws the samples that are held out to judge the fit";
            checkbox_ui(ui, &mut shown.held_out, "held out", about);
        });
    });
    let can_be_left = state.fitted.as_ref().is_some_and(|fitted| {
        let tables = TableRole::ALL.map(|role| state.slot(role).table.as_ref());
        tables.into_iter().flatten().any(|table| fitted.left_on(table).is_some())
    });
    value_ui(ui, can_be_left, &mut shown);
    bar_ui(ui, scale);
    for role in TableRole::ALL {
        let samples = state.slot(role).table.as_ref();
        let step = samples.map_or(1, |table| stride(table.samples.samples.len()));
        if step > 1 && state.shown.is_shown(role) {
            quiet_ui(ui, format!("every {}th sample is drawn", count(step)));
        }
    }
    if shown != before {
        requests.push(FieldRequest::Show(shown));
    }
}

fn value_ui(ui: &mut Ui, can_be_left: bool, shown: &mut SamplesShown) {
    let name = |value| match value {
        SampleValue::Measured => "error as measured",
        SampleValue::Left => "error left by the fit",
    };
    let is_shown = match can_be_left {
        true => shown.value,
        false => SampleValue::Measured,
    };
    let choice = ComboBox::from_id_salt("sample value")
        .selected_text(name(is_shown))
        .width(ui.available_width() - 8.0)
        .show_ui(ui, |ui| {
            ui.selectable_value(
                &mut shown.value,
                SampleValue::Measured,
                name(SampleValue::Measured),
            );
            ui.add_enabled_ui(can_be_left, |ui| {
                ui.selectable_value(&mut shown.value, SampleValue::Left, name(SampleValue::Left))
                    .on_disabled_hover_text("Fit these measurements first");
            });
        });
    choice.response.explained("What the colour and the length of a sample's arrow show");
}

/// The colours with the values at their ends.
fn bar_ui(ui: &mut Ui, scale: ColorScale) {
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), BAR_HEIGHT), Sense::hover());
    let columns = rect.width().round().max(1.0) as usize;
    let mut mesh = Mesh::default();
    for k in 0..columns {
        let color = Rgb::same(scale.map.srgb((k as f64 + 0.5) / columns as f64));
        let x = |k: usize| rect.left() + rect.width() * k as f32 / columns as f32;
        let column =
            egui::Rect::from_min_max(pos2(x(k), rect.top()), pos2(x(k + 1), rect.bottom()));
        mesh.add_colored_rect(column, color.color32());
    }
    ui.painter().add(Shape::mesh(mesh));
    ui.horizontal(|ui| {
        quiet_ui(ui, "0");
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            quiet_ui(ui, format!("{} and more", length(scale.max_mm)));
        });
    });
}
