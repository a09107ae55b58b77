//! What a room is fitted with, and the button that fits it.

use crate::widgets::basic::{
    NumberChange, NumberField, main_button, number_ui, quiet_ui, section_ui,
};
use crate::widgets::tooltip::{Explain, button_ui};
use crate::workspaces::field::kind::FieldKind;
use crate::workspaces::field::panels::named_ui;
use crate::workspaces::field::requests::FieldRequest;
use crate::workspaces::field::state::{FieldSettings, FieldState};
use crate::workspaces::field::work::CHOOSING_PART;
use bevy_egui::egui::{ComboBox, ProgressBar, Ui};
use trackwright_calibration::room_fit::RegistrationError;
use trackwright_field::bernstein::MAX_ORDER;
use trackwright_field::environment::Jitter;
use trackwright_field::fit::FitMethod;
use trackwright_field::harmonic::solid_harmonics::MAX_DEGREE;
use trackwright_field::samples::MapKind;
use trackwright_field::selection::DEFAULT_RIDGES;
use trackwright_geometry::directions::{DirectionSet, Weighting};
use trackwright_geometry::volume::Volume;
use trackwright_project::{MOST_LAG_ROWS, MOST_SENSOR_OFFSET_MM};
use trackwright_report::selection::ridge_text;

const SELECTED: &str = "let it select";

/// Jitter of a tracker that is known to have some but not how much: that of a good one.
const FIRST_JITTER_MM: f64 = 0.1;
const FIRST_JITTER_DEG: f64 = 0.1;
const FIRST_GROWTH_MM: f64 = 300.0;

/// Draws the settings.
pub fn settings_ui(ui: &mut Ui, state: &FieldState) -> Vec<FieldRequest> {
    let mut requests = Vec::new();
    let before = state.settings;
    let mut settings = before;
    section_ui(ui, "Fit");
    kind_ui(ui, &mut settings);
    if settings.kind.is_polynomial() {
        polynomials_ui(ui, &mut settings);
    }
    map_ui(ui, &mut settings);
    choice_ui(
        ui,
        ("sensors", "what the table's quaternions mean"),
        &mut settings.has_rolls,
        &[(false, "5-DOF, an axis"), (true, "6-DOF, a rotation")],
    );
    for (label, name, unit, most, about, value) in [
        (
            "lag",
            "lag of the measured side in rows",
            "rows",
            MOST_LAG_ROWS,
            "Rows that readings are behind the ideal poses; each is put beside the pose of its moment",
            &mut settings.lag_rows,
        ),
        (
            "offset",
            "offset of the measured side along the sensor's axis",
            "mm",
            MOST_SENSOR_OFFSET_MM,
            "How far measured positions are along the sensor's z axis from ideal ones; it is taken out",
            &mut settings.sensor_offset_mm,
        ),
    ] {
        named_ui(ui, label, |ui| {
            let field = NumberField { unit, min: -most, max: most, ..NumberField::plain(name) };
            set_from(number_ui(ui, &field.about(about), *value), |set| *value = set);
        });
    }
    let volumes: Vec<_> = std::iter::once((None, "not known"))
        .chain(Volume::NAMED.map(|volume| (Some(volume), volume.name())))
        .collect();
    choice_ui(
        ui,
        ("volume", "where the tracker promises to measure"),
        &mut settings.volume,
        &volumes,
    );
    jitter_ui(ui, &mut settings.jitter);
    registration_ui(ui, &mut settings.registration);
    if settings != before {
        requests.push(FieldRequest::Set(settings));
    }
    ui.add_space(6.0);
    fit_ui(ui, state, &mut requests);
    requests
}

/// The kind of model, and the degree of a harmonic one.
fn kind_ui(ui: &mut Ui, settings: &mut FieldSettings) {
    let kinds: Vec<_> = FieldKind::all().into_iter().map(|kind| (kind, kind.label())).collect();
    choice_ui(
        ui,
        (
            "kind",
            "polynomials as published; kriging, a Gaussian process; harmonic, the generator's fields \
             disturbed by metal",
        ),
        &mut settings.kind,
        &kinds,
    );
    if let FieldKind::Harmonic(_) = settings.kind {
        let degrees: Vec<_> = std::iter::once((None, "by the number of samples".to_owned()))
            .chain((1..=MAX_DEGREE).map(|degree| (Some(degree), degree.to_string())))
            .collect();
        choice_ui(
            ui,
            (
                "degree",
                "degree of the solid harmonics; higher follows more, and needs more samples",
            ),
            &mut settings.degree,
            &degrees,
        );
    }
}

fn polynomials_ui(ui: &mut Ui, settings: &mut FieldSettings) {
    let model = &mut settings.model;
    let orders: Vec<(Option<usize>, String)> = std::iter::once((None, SELECTED.to_owned()))
        .chain((0..=MAX_ORDER).map(|order| {
            let text = match order {
                0 => "0, no correction".to_owned(),
                order => order.to_string(),
            };
            (Some(order), text)
        }))
        .collect();
    choice_ui(
        ui,
        ("order", "order of the polynomials; higher follows more, and needs more samples"),
        &mut model.order,
        &orders,
    );
    let sets: Vec<(Option<DirectionSet>, String)> = std::iter::once((None, SELECTED.to_owned()))
        .chain(DirectionSet::ALL.map(|set| {
            let text = match set.len() {
                1 => "1, orientation ignored".to_owned(),
                count => count.to_string(),
            };
            (Some(set), text)
        }))
        .collect();
    choice_ui(
        ui,
        ("orientations", "basis orientations, between which axes are weighted"),
        &mut model.directions,
        &sets,
    );
    let is_open = model.order.is_none() || model.directions.is_none();
    // Where nothing is open, no ridge is the default.
    if !is_open && model.ridge == Some(0.0) {
        model.ridge = None;
    }
    let ridges: Vec<(Option<f64>, String)> =
        std::iter::once((None, if is_open { SELECTED } else { "none" }.to_owned()))
            .chain(DEFAULT_RIDGES.iter().filter(|r| is_open || **r > 0.0).map(|&ridge| {
                let text = match ridge {
                    0.0 => "none".to_owned(),
                    ridge => ridge_text(ridge),
                };
                (Some(ridge), text)
            }))
            .collect();
    choice_ui(
        ui,
        (
            "ridge",
            "keeps coefficients small that the measurements hardly determine; part of the largest singular value",
        ),
        &mut model.ridge,
        &ridges,
    );
    choice_ui(
        ui,
        ("method", "each orientation by itself as in the paper, or all at once"),
        &mut model.method,
        &[(FitMethod::PerDirection, "per direction"), (FitMethod::Joint, "joint")],
    );
    choice_ui(
        ui,
        ("weighting", "how an axis is shared among the three orientations around it"),
        &mut model.weighting,
        &[(Weighting::Area, "areas"), (Weighting::Gnomonic, "gnomonic, continuous")],
    );
}

fn map_ui(ui: &mut Ui, settings: &mut FieldSettings) {
    choice_ui(
        ui,
        ("map", "a function of the ideal pose to simulate, of the measured one to compensate"),
        &mut settings.model.map,
        &[(MapKind::Distortion, "distortion"), (MapKind::Correction, "correction")],
    );
}

/// A name with a list to choose from.
pub(super) fn choice_ui<T: Clone + PartialEq>(
    ui: &mut Ui,
    (name, about): (&str, &str),
    value: &mut T,
    choices: &[(T, impl AsRef<str>)],
) {
    named_ui(ui, name, |ui| {
        let shown = choices.iter().find(|(choice, _)| choice == value);
        let response = ComboBox::from_id_salt(name)
            .selected_text(shown.map_or("", |(_, text)| text.as_ref()))
            .width(ui.available_width() - 8.0)
            .show_ui(ui, |ui| {
                for (choice, text) in choices {
                    ui.selectable_value(value, choice.clone(), text.as_ref());
                }
            })
            .response;
        let id = response.id;
        ui.ctx().accesskit_node_builder(id, |node| node.set_label(name));
        response.explained(about);
    });
}

fn jitter_ui(ui: &mut Ui, jitter: &mut Option<Jitter>) {
    let mut is_known = jitter.is_some();
    named_ui(ui, "jitter", |ui| {
        let switch = ui.checkbox(&mut is_known, "known");
        switch.explained("What a still sensor's readings scatter by, a standard deviation");
    });
    if !is_known {
        *jitter = None;
        return;
    }
    let mut known = jitter
        .unwrap_or_else(|| Jitter::stated(FIRST_JITTER_MM, FIRST_JITTER_DEG.to_radians(), None));
    named_ui(ui, "   position", |ui| {
        let field = NumberField {
            decimals: 3,
            speed: 0.005,
            ..NumberField::length("jitter of the position in mm").positive()
        };
        set_from(number_ui(ui, &field, known.position_mm), |v| {
            known.position_mm = v;
        });
        quiet_ui(ui, "per axis");
    });
    named_ui(ui, "   angle", |ui| {
        let field = NumberField {
            decimals: 3,
            speed: 0.005,
            ..NumberField::angle("jitter of the angle in degrees").positive()
        };
        let angle_deg = known.angle_rad.to_degrees();
        set_from(number_ui(ui, &field, angle_deg), |v| {
            known.angle_rad = v.to_radians();
        });
        quiet_ui(ui, "per component");
    });
    growth_ui(ui, &mut known);
    *jitter = Some(known);
}

fn registration_ui(ui: &mut Ui, registration: &mut Option<RegistrationError>) {
    let mut is_known = registration.is_some();
    named_ui(ui, "registration", |ui| {
        let switch = ui.checkbox(&mut is_known, "error known");
        switch.explained(
            "How far the reference's frame is off, standard deviations; intervals of figures then include it",
        );
    });
    if !is_known {
        *registration = None;
        return;
    }
    let first = RegistrationError { position_mm: 0.3, angle_rad: 0.1_f64.to_radians() };
    let mut known = registration.unwrap_or(first);
    named_ui(ui, "   position", |ui| {
        let field = NumberField::length("registration error of the position in mm").positive();
        set_from(number_ui(ui, &field, known.position_mm), |v| known.position_mm = v);
        quiet_ui(ui, "per axis");
    });
    named_ui(ui, "   angle", |ui| {
        let field = NumberField {
            speed: 0.005,
            max: 180.0,
            ..NumberField::angle("registration error of the angle in degrees").positive()
        };
        let angle_deg = known.angle_rad.to_degrees();
        set_from(number_ui(ui, &field, angle_deg), |v| known.angle_rad = v.to_radians());
        quiet_ui(ui, "per axis");
    });
    *registration = Some(known);
}

fn growth_ui(ui: &mut Ui, known: &mut Jitter) {
    named_ui(ui, "   grows", |ui| {
        let mut is_growing = known.growth.is_some();
        let switch = ui.checkbox(&mut is_growing, "");
        switch.explained(
            "Grows away from the generator as a dipole's field fades: by √2 at this distance",
        );
        let mut distance_mm = match (is_growing, known.growth) {
            (false, _) => {
                known.growth = None;
                quiet_ui(ui, "the same everywhere");
                return;
            }
            (true, growth) => growth.map_or(FIRST_GROWTH_MM, |growth| growth.distance_mm),
        };
        let field = NumberField {
            decimals: 0,
            speed: 1.0,
            min: 1.0,
            ..NumberField::length("distance in mm where the jitter has grown")
        };
        set_from(number_ui(ui, &field, distance_mm), |v| distance_mm = v);
        if known.growth.is_none_or(|g| g.distance_mm != distance_mm) {
            *known = Jitter::stated(known.position_mm, known.angle_rad, Some(distance_mm));
        }
    });
}

fn set_from(changes: Vec<NumberChange>, mut set: impl FnMut(f64)) {
    for change in changes {
        if let NumberChange::Set(value) = change {
            set(value);
        }
    }
}

fn fit_ui(ui: &mut Ui, state: &FieldState, requests: &mut Vec<FieldRequest>) {
    if let Some(job) = &state.fitting {
        let part = job.progress();
        let doing = match state.settings.is_open() && part < CHOOSING_PART {
            true => "cross-validating",
            false => "fitting",
        };
        ui.horizontal(|ui| {
            let width = ui.available_width() - 62.0;
            let bar = ProgressBar::new(part as f32).desired_width(width);
            ui.add(bar.text(format!("{doing} {:.0}\u{2009}%", part * 100.0)));
            if button_ui(ui, "Cancel", "Stops the fit; the room stays as it was").clicked() {
                requests.push(FieldRequest::CancelFit);
            }
        });
        return;
    }
    let hindrance = state.hindrance();
    let text = if state.settings.is_open() { "Select and fit" } else { "Fit" };
    ui.horizontal(|ui| {
        let about = "Fits a model of the room to the measurements, as set above";
        let button = ui.add_enabled(hindrance.is_none(), main_button(text)).explained(about);
        if button.clicked() {
            requests.push(FieldRequest::Fit);
        }
        if let Some(why) = hindrance {
            quiet_ui(ui, why);
        }
    });
}
