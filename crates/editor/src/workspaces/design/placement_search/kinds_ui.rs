//! The kinds of sensors that a search may take, each with what one costs.

use crate::widgets::basic::{NumberField, quiet_ui, typed_number_ui};
use crate::widgets::tooltip::{Explain, button_ui, checkbox_ui, labelled};
use crate::workspaces::design::placement_search::wish::{MOST_COST, MOST_KINDS, Wish};
use crate::workspaces::design::rows::{INDENT, right_ui};
use crate::workspaces::design::sensor_numbers::NEW_COIL;
use bevy_egui::egui::{ComboBox, Ui};
use trackwright_design::Design;
use trackwright_optimization::SensorChoice;

const MENU_WIDTH: f32 = 58.0;
const NARROW: f32 = 62.0;

/// Draws the list, and what adds to it.
pub fn kinds_ui(ui: &mut Ui, design: &Design, wish: &mut Wish) {
    if wish.counted().is_none() {
        return;
    }
    let mut is_chosen = !wish.kinds.is_empty();
    let about = "Whether sensors may be of other kinds, each with a cost: the best of each cost is \
                 shown. Sensors that are not chosen above keep their kinds";
    if checkbox_ui(ui, &mut is_chosen, "Kinds of sensors", about).changed() {
        match is_chosen {
            true => wish.add_kind(design),
            false => wish.kinds.clear(),
        }
    }
    if !is_chosen {
        return;
    }
    ui.spacing_mut().item_spacing.x = 4.0;
    let mut removed = None;
    let first_coil = wish.first_moving(design).and_then(|sensor| sensor.coil);
    for (number, kind) in wish.kinds.iter_mut().enumerate() {
        ui.push_id(("kind", number), |ui| {
            let name = format!("kind {}", number + 1);
            ui.horizontal(|ui| {
                ui.add_space(INDENT);
                kind_ui(ui, &name, kind);
                let remove =
                    right_ui(ui, |ui| button_ui(ui, "Remove", "Takes the kind from the list"));
                labelled(ui, &remove, &format!("Remove {name}"));
                if remove.clicked() {
                    removed = Some(number);
                }
            });
            ui.horizontal(|ui| {
                ui.add_space(INDENT);
                let own = first_coil.unwrap_or(NEW_COIL);
                let mut is_stated = kind.coil.is_some();
                let about = "Whether sensors of this kind have a coil of their own size";
                let stated = checkbox_ui(ui, &mut is_stated, "coil", about);
                labelled(ui, &stated, &format!("coil of {name}"));
                if stated.changed() {
                    kind.coil = is_stated.then_some(own);
                }
                coil_ui(ui, &name, kind);
            });
        });
    }
    if let Some(number) = removed {
        wish.kinds.remove(number);
    }
    ui.horizontal(|ui| {
        ui.add_space(INDENT);
        let is_short = wish.kinds.len() < MOST_KINDS;
        let about = "Adds a kind that may be used";
        if ui.add_enabled_ui(is_short, |ui| button_ui(ui, "Add kind", about)).inner.clicked() {
            wish.add_kind(design);
        }
        quiet_ui(ui, "cost in a unit of your own");
    });
}

fn kind_ui(ui: &mut Ui, name: &str, kind: &mut SensorChoice) {
    let words = |degrees: u8| format!("{degrees}-DOF");
    let menu = ComboBox::from_id_salt("degrees of freedom")
        .selected_text(words(kind.degrees_of_freedom))
        .width(MENU_WIDTH)
        .show_ui(ui, |ui| {
            for degrees in [5, 6] {
                ui.selectable_value(&mut kind.degrees_of_freedom, degrees, words(degrees));
            }
        });
    let menu = menu.response.explained("5 with one axis, 6 with a full rotation");
    labelled(ui, &menu, &format!("degrees of freedom of {name}"));
    quiet_ui(ui, "cost");
    let field_name = format!("cost of {name}");
    let field = NumberField {
        unit: "",
        decimals: 2,
        speed: 1.0,
        max: MOST_COST,
        ..NumberField::length(&field_name).positive().width(NARROW)
    };
    if let Some(cost) = typed_number_ui(ui, &field, kind.cost) {
        kind.cost = cost;
    }
}

/// Diameter and length, or what holds without them.
fn coil_ui(ui: &mut Ui, name: &str, kind: &mut SensorChoice) {
    let Some(coil) = &mut kind.coil else {
        quiet_ui(ui, "as the sensor has it");
        return;
    };
    let names = ["diameter", "length"].map(|of| format!("coil {of} of {name} in mm"));
    let sizes = [&mut coil.diameter_mm, &mut coil.length_mm];
    for (number, (name, size_mm)) in names.iter().zip(sizes).enumerate() {
        if number > 0 {
            quiet_ui(ui, "×");
        }
        let field = NumberField { min: 0.01, max: 1000.0, ..NumberField::length(name) };
        if let Some(typed_mm) = typed_number_ui(ui, &field.width(NARROW), *size_mm) {
            *size_mm = typed_mm;
        }
    }
}
