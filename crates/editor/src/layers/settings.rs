//! What settings of several layers are made of.

use crate::widgets::basic::{NumberChange, NumberField, number_ui, quiet_ui};
use crate::widgets::tooltip::Explain;
use bevy_egui::egui::{self, ComboBox, Ui};
use trackwright_design::view::{ColorMap, View};

/// Before a setting's name, and what the name takes.
pub(crate) const INDENT: f32 = 16.0;
const NAME_WIDTH: f32 = 66.0;

/// Width of a range's number.
const RANGE_WIDTH: f32 = 62.0;

const AUTOMATIC: &str =
    "Automatic: up to the 95th percentile, so that one bad corner does not take all colours";

pub(crate) const AXIS_NAMES: [&str; 3] = ["x", "y", "z"];

/// Which way the imagined sensor points.
pub fn sensor_axis_ui(ui: &mut Ui, sensor_axis: &mut [f64; 3]) {
    row_ui(ui, "sensor along", |ui| {
        for (k, name) in AXIS_NAMES.into_iter().enumerate() {
            let mut along = [0.0; 3];
            along[k] = 1.0;
            if ui.selectable_label(*sensor_axis == along, name).clicked() {
                *sensor_axis = along;
            }
        }
    });
}

/// The map of a coloured layer. A person chooses that of the first one; another scale has another map,
/// which is only named.
pub fn map_ui(ui: &mut Ui, view: &mut View, of_layer: ColorMap) {
    if of_layer == view.slice.color_map {
        color_map_ui(ui, &mut view.slice.color_map);
        return;
    }
    row_ui(ui, "colours", |ui| {
        quiet_ui(ui, format!("{}, as another scale", of_layer.name()));
    });
}

/// The map that the first of the coloured layers has.
fn color_map_ui(ui: &mut Ui, color_map: &mut ColorMap) {
    row_ui(ui, "colours", |ui| {
        ComboBox::from_id_salt("color map")
            .selected_text(color_map.name())
            .width(90.0)
            .show_ui(ui, |ui| {
                for map in ColorMap::ALL {
                    ui.selectable_value(color_map, map, map.name());
                }
            })
            .response
            .explained("Of every coloured layer; one with another scale takes another map");
    });
}

/// Where colours end: by themselves, or at a number in the field's unit.
pub fn range_ui(ui: &mut Ui, field: &NumberField, largest: Option<f64>, range: &mut Option<f64>) {
    let step = 10f64.powi(-(field.decimals as i32));
    let field = NumberField { min: step, speed: step, width: RANGE_WIDTH, ..*field };
    row_ui(ui, "up to", |ui| {
        if let Some(value) = *range {
            set_from(number_ui(ui, &field, value), |v| {
                *range = Some(v);
            });
        }
        let mut is_automatic = range.is_none();
        // Beside a number there is no room for the word.
        let name = if is_automatic { "automatic" } else { "" };
        let automatic = ui.checkbox(&mut is_automatic, name).explained(AUTOMATIC);
        ui.ctx().accesskit_node_builder(automatic.id, |node| {
            node.set_label("automatic".to_owned());
        });
        if automatic.changed() {
            // What can be typed, so that the number stays as it is shown.
            let round = |value: f64| (value / step).ceil() * step;
            *range = (!is_automatic).then(|| largest.filter(|m| *m > 0.0).map_or(1.0, round));
        }
    });
}

pub(crate) fn set_from(changes: Vec<NumberChange>, mut set: impl FnMut(f64)) {
    for change in changes {
        if let NumberChange::Set(value) = change {
            set(value);
        }
    }
}

/// A setting: its name, set back from the layers' own, and what it can be set with.
pub fn row_ui<R>(ui: &mut Ui, name: &str, add: impl FnOnce(&mut Ui) -> R) {
    ui.horizontal(|ui| {
        ui.add_space(INDENT);
        ui.allocate_ui_with_layout(
            egui::vec2(NAME_WIDTH, ui.spacing().interact_size.y),
            egui::Layout::left_to_right(egui::Align::Center),
            |ui| {
                ui.set_min_width(NAME_WIDTH);
                quiet_ui(ui, name);
            },
        );
        add(ui);
    });
}
