//! The metal that disturbs the measurements: the search for it, and what was found.

use crate::palette;
use crate::palette::ThemedColor;
use crate::widgets::basic::{
    count, decimal, fact_ui, length, quiet_ui, section_ui, warning_ui, with_unit,
};
use crate::widgets::theme;
use crate::widgets::tooltip::{Explain, button_ui};
use crate::workspaces::field::metal::{FoundMetal, GeneratorSource};
use crate::workspaces::field::panels::cell_ui;
use crate::workspaces::field::panels::settings::choice_ui;
use crate::workspaces::field::requests::{FieldRequest, RoomToSave};
use crate::workspaces::field::state::FieldState;
use bevy_egui::egui::{Button, Label, ProgressBar, RichText, Ui};
use trackwright_field::generator::{BUILT_IN, Generator};
use trackwright_metal::identify::{FoundBody, Interval};
use trackwright_project::file_name;
use trackwright_report::found_metal::{
    compared_rows, form_line, kind_name, misfit_line, verdict_line,
};

/// Draws the section while a table is open; `of_room` is the generator of the design's room.
pub fn metal_ui(ui: &mut Ui, state: &FieldState, of_room: Option<&Generator>) -> Vec<FieldRequest> {
    let mut requests = Vec::new();
    if state.training.table.is_none() {
        return requests;
    }
    section_ui(ui, "Metal");
    let about =
        "Finds one to three compact pieces of metal that explain the errors of the measurements";
    ui.add(Label::new(quiet(about)).wrap());
    let source = state.metal.generator(of_room);
    generator_ui(ui, source.as_ref(), of_room, &mut requests);
    search_ui(ui, state, source.as_ref(), &mut requests);
    if let Some(found) = &state.metal.found {
        ui.add_space(4.0);
        found_ui(ui, found);
        next_ui(ui, found, state.metal.searching.is_none(), &mut requests);
    }
    requests
}

fn quiet(text: &str) -> RichText {
    RichText::new(text).font(theme::label_font()).color(palette::TEXT_QUIET.color32())
}

/// Where the field generator comes from.
fn generator_ui(
    ui: &mut Ui,
    source: Option<&GeneratorSource>,
    of_room: Option<&Generator>,
    requests: &mut Vec<FieldRequest>,
) {
    let mut choices: Vec<(Option<GeneratorSource>, String)> = Vec::new();
    if source.is_none() {
        choices.push((None, "not chosen".to_owned()));
    }
    let built_in = BUILT_IN.map(|name| (Some(GeneratorSource::BuiltIn(name)), name.to_owned()));
    choices.extend(built_in);
    let room = of_room.map(|of_room| format!("{}, of the design's room", of_room.name));
    choices.extend(room.map(|text| (Some(GeneratorSource::Room), text)));
    if let Some(GeneratorSource::File(file)) = source {
        choices.push((source.cloned(), file_name(file)));
    }
    let mut chosen = source.cloned();
    let about = "The tracker's own, exactly; one that was learned from these measurements has the metal's \
         part in it";
    choice_ui(ui, ("generator", about), &mut chosen, &choices);
    if let Some(chosen) = chosen.filter(|chosen| Some(chosen) != source) {
        requests.push(FieldRequest::UseGenerator(chosen));
    }
    let about = "Takes the tracker's field generator from a file (*.generator.ron)";
    if button_ui(ui, "Generator from a file…", about).clicked() {
        requests.push(FieldRequest::ShowOpenGenerator);
    }
}

fn search_ui(
    ui: &mut Ui,
    state: &FieldState,
    source: Option<&GeneratorSource>,
    requests: &mut Vec<FieldRequest>,
) {
    if let Some(searching) = &state.metal.searching {
        let part = searching.job.progress();
        let doing = if searching.is_comparison { "comparing" } else { "looking for metal" };
        ui.horizontal(|ui| {
            let bar = ProgressBar::new(part as f32).desired_width(ui.available_width() - 62.0);
            ui.add(bar.text(format!("{doing} {:.0}\u{2009}%", part * 100.0)));
            if button_ui(ui, "Cancel", "Stops this; everything stays as it was").clicked() {
                requests.push(FieldRequest::CancelMetal);
            }
        });
        return;
    }
    let hindrance = state.metal_hindrance(source);
    ui.horizontal(|ui| {
        let about = "Looks for the metal that disturbs the measurements";
        let button = ui.add_enabled(hindrance.is_none(), Button::new("Find metal"));
        if button.explained(about).clicked() {
            requests.push(FieldRequest::FindMetal);
        }
        if let Some(why) = hindrance {
            quiet_ui(ui, why);
        }
    });
}

/// The verdict, and each body.
fn found_ui(ui: &mut Ui, metal: &FoundMetal) {
    let found = &metal.found;
    let verdict = RichText::new(verdict_line(found)).color(palette::TEXT_STRONG.color32());
    ui.add(Label::new(verdict).wrap());
    for (number, body) in (1..).zip(&found.bodies) {
        body_ui(ui, number, body);
    }
    if let Some(misfit) = misfit_line(found) {
        warning_ui(ui, &misfit);
    }
    ui.add_space(4.0);
    fact_ui(ui, "generator", &metal.generator.name);
    let pair = |mm: f64, rad: f64| format!("{}, {}", length(mm), angle(rad));
    let (noise, disturbance) = (&found.noise, &found.disturbance);
    fact_ui(ui, "disturbance RMS", &pair(disturbance.position_mm, disturbance.rotation_rad));
    fact_ui(ui, "noise a component", &pair(noise.position_mm, noise.rotation_rad));
    if found.down_weighted > 0 {
        fact_ui(ui, "samples that contradict others", &count(found.down_weighted));
    }
}

fn angle(angle_rad: f64) -> String {
    with_unit(&decimal(angle_rad.to_degrees(), 2), "°")
}

fn body_ui(ui: &mut Ui, number: usize, body: &FoundBody) {
    ui.add_space(4.0);
    let known = match &body.known {
        Ok(known) => known,
        Err(doubt) => {
            warning_ui(ui, &format!("{number}  cannot tell: {doubt}"));
            return;
        }
    };
    let name = RichText::new(format!("{number}  {}", kind_name(body.kind)));
    ui.label(name.color(palette::FOUND_METAL.color32()));
    for (k, name) in ["x", "y", "z"].into_iter().enumerate() {
        let half = decimal(known.center_mm[k].half_length(), 1);
        let value = format!("{} ± {half}", decimal(body.source.center_mm[k], 1));
        fact_ui(ui, name, &with_unit(&value, "mm"));
    }
    let Interval { low, high } = known.radius_mm;
    let radius = with_unit(&decimal(body.source.radius_mm(), 1), "mm");
    let interval = format!("{} to {}", decimal(low, 1), decimal(high, 1));
    fact_ui(ui, "equivalent radius", &format!("{radius} ({interval})"));
    if let Some(form) = &known.form {
        quiet_ui(ui, form_line(form));
    }
    fact_ui(ui, "nearest sample", &with_unit(&decimal(body.nearest_mm, 0), "mm"));
}

/// What can be done with what was found.
fn next_ui(ui: &mut Ui, metal: &FoundMetal, is_idle: bool, requests: &mut Vec<FieldRequest>) {
    if metal.found.determined().next().is_some() {
        quiet_ui(ui, "± and to: 95 % intervals");
    }
    if !metal.compared.is_empty() {
        section_ui(ui, &format!("Errors held out by row, {} folds", metal.settings.folds));
        for [name, position, angle] in compared_rows(&metal.compared) {
            ui.horizontal(|ui| {
                quiet_ui(ui, name);
                let errors = [with_unit(&position, "mm"), with_unit(&angle, "°")].join(", ");
                cell_ui(ui, errors, palette::TEXT.color32());
            });
        }
    }
    ui.add_space(6.0);
    if metal.room.is_some() {
        let about = "Saves a room with the bodies that are determined, as spheres, and puts the design into it";
        if button_ui(ui, "Use as room with metal…", about).clicked() {
            requests.push(FieldRequest::ShowSave(RoomToSave::Metal));
        }
    }
    if metal.compared.is_empty() {
        let about = "Errors held out of the bodies found, beside those of other models; it takes longer than \
             the search";
        let button = ui.add_enabled(is_idle, Button::new("Compare with other models"));
        if button.explained(about).clicked() {
            requests.push(FieldRequest::CompareMetal);
        }
    }
}
