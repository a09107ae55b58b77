//! Rows of the inspector: a name at the left, fields at the right.

use crate::widgets::basic::{NumberField, number_ui};
use crate::workspaces::design::actions::{DesignAction, number_edits};
use bevy_egui::egui::{self, TextEdit, Ui};
use nalgebra::{UnitQuaternion, Vector3};
use trackwright_design::Edit;

pub(crate) const AXES: [&str; 3] = ["x", "y", "z"];

/// Before what belongs to the row above it.
pub(crate) const INDENT: f32 = 18.0;

/// What stands at the right end of a row, the last of it first.
pub(crate) fn right_ui<R>(ui: &mut Ui, add: impl FnOnce(&mut Ui) -> R) -> R {
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), add).inner
}

/// A row with its name at the left and its fields at the right.
pub(crate) fn row_ui<R>(ui: &mut Ui, name: &str, add: impl FnOnce(&mut Ui) -> R) -> R {
    ui.horizontal(|ui| {
        ui.label(name);
        right_ui(ui, add)
    })
    .inner
}

/// Three lengths, each a row.
pub(crate) fn vector_ui(
    ui: &mut Ui,
    what: &str,
    value_mm: &Vector3<f64>,
    actions: &mut Vec<DesignAction>,
    label: &str,
    edit: impl Fn(Vector3<f64>) -> Option<Edit>,
) {
    for (k, axis) in AXES.into_iter().enumerate() {
        row_ui(ui, axis, |ui| {
            let name = format!("{what} {axis} in mm");
            let changes = number_ui(ui, &NumberField::length(&name), value_mm[k]);
            number_edits(&changes, actions, label, |v| {
                let mut value_mm = *value_mm;
                value_mm[k] = v;
                edit(value_mm)
            });
        });
    }
}

/// Turns about x, then y, then z, shown in degrees.
pub(crate) fn rotation_ui(
    ui: &mut Ui,
    rotation: &UnitQuaternion<f64>,
    actions: &mut Vec<DesignAction>,
    label: &str,
    edit: impl Fn(UnitQuaternion<f64>) -> Edit,
) {
    let (rx, ry, rz) = rotation.euler_angles();
    let angles = [rx, ry, rz];
    for (k, axis) in ["rx", "ry", "rz"].into_iter().enumerate() {
        row_ui(ui, axis, |ui| {
            let name = format!("rotation {axis} in degrees");
            let changes = number_ui(ui, &NumberField::angle(&name), angles[k].to_degrees());
            number_edits(&changes, actions, label, |v| {
                let mut angles = angles;
                angles[k] = v.to_radians();
                let [rx, ry, rz] = angles;
                Some(edit(UnitQuaternion::from_euler_angles(rx, ry, rz)))
            });
        });
    }
}

/// A row with text; the new text once it was entered.
pub(crate) fn text_row_ui(ui: &mut Ui, name: &str, value: &str) -> Option<String> {
    row_ui(ui, name, |ui| {
        let id = ui.make_persistent_id((name, value));
        let mut text =
            ui.data(|data| data.get_temp::<String>(id)).unwrap_or_else(|| value.to_owned());
        let response = ui.add(
            TextEdit::singleline(&mut text).id(id.with("edit")).desired_width(ui.available_width()),
        );
        response.widget_info(|| {
            egui::WidgetInfo::labeled(egui::WidgetType::TextEdit, ui.is_enabled(), name)
        });
        if response.lost_focus() {
            ui.data_mut(|data| data.remove::<String>(id));
            let is_given_up = ui.input(|i| i.key_pressed(egui::Key::Escape));
            return (!is_given_up && text != value).then_some(text);
        }
        if response.has_focus() {
            ui.data_mut(|data| data.insert_temp(id, text));
        }
        None
    })
}
