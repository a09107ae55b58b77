//! The panel of the search for better places: what may move, what is made least, start and stop.

use crate::widgets::basic::{
    NumberField, count, main_button, quiet_ui, section_ui, short_name, typed_number_ui, warning_ui,
};
use crate::widgets::tooltip::{Explain, button_ui, checkbox_ui};
use crate::workspaces::design::placement_search::charts_ui::{curve_ui, objective_text};
use crate::workspaces::design::placement_search::kinds_ui::kinds_ui;
use crate::workspaces::design::placement_search::result_ui::result_ui;
use crate::workspaces::design::placement_search::state::{
    PlacementSearch, PlacementSearchRequest, Running,
};
use crate::workspaces::design::placement_search::wish::{MOST_SENSORS, Reach, Wish, has_crf_patch};
use crate::workspaces::design::rows::{INDENT, row_ui};
use bevy_egui::egui::{Align, ComboBox, Label, Layout, RichText, Ui};
use trackwright_design::{BodyRole, Design};
use trackwright_optimization::{BuiltError, OverRooms};
use trackwright_simulation::METRICS;

const TITLE: &str = "Find better places";
const TITLE_SIZE: f32 = 15.0;

/// Settings above a search or a result are a line, until they are to be changed.
pub const UNFOLD: &str = "Show settings";
pub const FOLD: &str = "Fold settings";

/// Letters of a sensor's name in its row.
const NAME_CHARS: usize = 26;

/// Width of a field; two stand in a row.
const NARROW: f32 = 66.0;
const CHOICE_WIDTH: f32 = 164.0;

/// Draws the panel.
pub fn placement_search_ui(
    ui: &mut Ui,
    design: &Design,
    search: &PlacementSearch,
) -> Vec<PlacementSearchRequest> {
    let mut requests = Vec::new();
    ui.add_space(6.0);
    ui.horizontal(|ui| {
        ui.label(RichText::new(TITLE).size(TITLE_SIZE));
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let about = "Shows the inspector again; a search that runs goes on";
            if button_ui(ui, "Close", about).clicked() {
                requests.push(PlacementSearchRequest::Close);
            }
        });
    });
    let first;
    let wish = match &search.wish {
        Some(wish) => wish,
        None => {
            first = Wish::of(design);
            &first
        }
    };
    let mut edited = wish.clone();
    if search.is_folded() {
        quiet_ui(ui, wish.summary(design));
    } else {
        if search.has_outcome() && button_ui(ui, FOLD, "Folds them into a line").clicked() {
            requests.push(PlacementSearchRequest::ShowSettings(false));
        }
        ui.add_enabled_ui(search.running.is_none(), |ui| {
            moves_ui(ui, design, &mut edited);
            goal_ui(ui, design, &mut edited);
        });
    }
    if edited != *wish {
        requests.push(PlacementSearchRequest::Set(edited));
    }
    ui.add_space(6.0);
    match &search.running {
        Some(running) => running_ui(ui, search, running, &mut requests),
        None => start_ui(ui, search, wish.refusal(design), &mut requests),
    }
    if let Some(problem) = &search.problem {
        warning_ui(ui, problem);
    }
    if let Some((searched, result)) = &search.result {
        requests.extend(result_ui(ui, search, searched, result));
    }
    requests
}

fn moves_ui(ui: &mut Ui, design: &Design, wish: &mut Wish) {
    section_ui(ui, "May move");
    for (role, name) in
        [(BodyRole::Tool, "Sensors of the tool"), (BodyRole::Crf, "Sensors of the CRF")]
    {
        body_ui(ui, design, role, name, wish);
    }
    if design.crf.is_some() {
        let about = match has_crf_patch(design) {
            true => "The CRF over the patch of the anatomy; tool and anatomy stay where they are",
            false => {
                "The CRF on the patient, in its own axes; tool and anatomy stay where they are"
            }
        };
        reach_ui(ui, ("CRF on the patient", "CRF"), about, &mut wish.crf_pose);
    }
    let about = "The field generator in the room, in its own axes; its field goes with it";
    reach_ui(ui, ("Field generator", "generator"), about, &mut wish.generator);
    counts_ui(ui, design, wish);
    ui.scope(|ui| kinds_ui(ui, design, wish));
}

/// All sensors of a body, and each.
fn body_ui(ui: &mut Ui, design: &Design, role: BodyRole, name: &str, wish: &mut Wish) {
    let Some(body) = design.body(role).filter(|body| !body.rigid.sensors.is_empty()) else {
        return;
    };
    let all = 0..body.rigid.sensors.len();
    let numbers = wish.numbers_mut(role);
    let mut are_all = all.clone().all(|number| numbers.contains(&number));
    if checkbox_ui(ui, &mut are_all, name, "All of them, or none").changed() {
        *numbers = if are_all { all.collect() } else { Default::default() };
    }
    for (number, sensor) in body.rigid.sensors.iter().enumerate() {
        ui.push_id((role, number), |ui| {
            ui.horizontal(|ui| {
                ui.add_space(INDENT);
                let mut is_free = numbers.contains(&number);
                let short = short_name(&sensor.name, NAME_CHARS);
                let about = format!("Whether {} may be elsewhere on its body", sensor.name);
                if checkbox_ui(ui, &mut is_free, &short, about).changed() {
                    match is_free {
                        true => numbers.insert(number),
                        false => numbers.remove(&number),
                    };
                }
            });
        });
    }
}

/// A pose, and how far to either side.
fn reach_ui(ui: &mut Ui, (name, short): (&str, &str), about: &str, reach: &mut Reach) {
    checkbox_ui(ui, &mut reach.is_free, name, about);
    if !reach.is_free {
        return;
    }
    ui.horizontal(|ui| {
        ui.add_space(INDENT);
        quiet_ui(ui, "at most ±");
        let name = format!("{short} at most");
        length_and_angle_ui(ui, (&name, 1), &mut reach.shift_mm, &mut reach.turn_deg);
    });
}

/// Two fields with so many decimals, neither below zero.
fn length_and_angle_ui(
    ui: &mut Ui,
    (name, decimals): (&str, usize),
    length_mm: &mut f64,
    angle_deg: &mut f64,
) {
    let [in_mm, in_deg] = ["mm", "degrees"].map(|unit| format!("{name} in {unit}"));
    let fields = [
        (NumberField { max: 1000.0, ..NumberField::length(&in_mm) }, length_mm),
        (NumberField { max: 180.0, ..NumberField::angle(&in_deg) }, angle_deg),
    ];
    for (field, value) in fields {
        let field = NumberField { decimals, ..field.positive().width(NARROW) };
        if let Some(typed) = typed_number_ui(ui, &field, *value) {
            *value = typed;
        }
    }
}

fn counts_ui(ui: &mut Ui, design: &Design, wish: &mut Wish) {
    let Some(role) = wish.counted() else { return };
    let sensors = design.body(role).map_or(0, |body| body.rigid.sensors.len());
    let fixed = sensors - wish.numbers(role).iter().filter(|number| **number < sensors).count();
    let mut is_free = wish.counts.is_some();
    let about = "Whether sensors may be added or taken away: the best of each number is shown";
    if checkbox_ui(ui, &mut is_free, "Number of sensors", about).changed() {
        let [least, most] = [(fixed + 1).max(sensors.saturating_sub(1)), sensors + 1];
        wish.counts = is_free.then_some([least, most]);
    }
    let Some([least, most]) = &mut wish.counts else {
        return;
    };
    ui.horizontal(|ui| {
        ui.add_space(INDENT);
        let field = |name, min: usize, max: usize| NumberField {
            unit: "",
            decimals: 0,
            speed: 0.05,
            min: min as f64,
            max: max as f64,
            ..NumberField::length(name).width(40.0)
        };
        if let Some(new) =
            typed_number_ui(ui, &field("fewest sensors", fixed + 1, *most), *least as f64)
        {
            *least = new.round() as usize;
        }
        quiet_ui(ui, "to");
        let limit = MOST_SENSORS.max(sensors + 1);
        if let Some(new) = typed_number_ui(ui, &field("most sensors", *least, limit), *most as f64)
        {
            *most = new.round() as usize;
        }
        quiet_ui(
            ui,
            match role {
                BodyRole::Tool => "on the tool",
                BodyRole::Crf => "on the CRF",
            },
        );
    });
}

fn goal_ui(ui: &mut Ui, design: &Design, wish: &mut Wish) {
    section_ui(ui, "Made least");
    const RATIO: &str = "ratio to the requirement";
    row_ui(ui, "figure", |ui| {
        let selected = wish.figure.map_or(RATIO, |metric| metric.label());
        let choice = ComboBox::from_id_salt("figure made least")
            .selected_text(selected)
            .width(CHOICE_WIDTH)
            .show_ui(ui, |ui| {
                ui.selectable_value(&mut wish.figure, None, RATIO);
                for metric in METRICS {
                    ui.selectable_value(&mut wish.figure, Some(metric), metric.label());
                }
            });
        choice.response.explained("The largest ratio of a figure to its bound, or one figure");
    });
    ui.horizontal(|ui| {
        ui.label("built within ±").explained(
            "What built sensors are off by along and about each axis, standard deviations: places \
             that this spoils count for less",
        );
        let BuiltError { position_mm, angle_deg } = &mut wish.built;
        length_and_angle_ui(ui, ("building error", 2), position_mm, angle_deg);
    });
    if design.procedure.further_rooms.is_empty() {
        return;
    }
    row_ui(ui, "rooms", |ui| {
        let words = |rooms: OverRooms| match rooms {
            OverRooms::Worst => "the worst of them",
            OverRooms::Mean => "the mean over them",
        };
        let choice = ComboBox::from_id_salt("rooms of the search")
            .selected_text(words(wish.rooms))
            .width(CHOICE_WIDTH)
            .show_ui(ui, |ui| {
                for rooms in [OverRooms::Worst, OverRooms::Mean] {
                    ui.selectable_value(&mut wish.rooms, rooms, words(rooms));
                }
            });
        choice.response.explained("How the rooms count that the design is judged in");
    });
}

fn start_ui(
    ui: &mut Ui,
    search: &PlacementSearch,
    refusal: Option<String>,
    requests: &mut Vec<PlacementSearchRequest>,
) {
    ui.horizontal(|ui| {
        let start = ui.add_enabled(refusal.is_none(), main_button("Start"));
        let about = "Searches in the background; nothing changes before an answer is taken";
        if start.explained(about).clicked() {
            requests.push(PlacementSearchRequest::Start);
        }
        unfold_ui(ui, search, requests);
    });
    if let Some(refusal) = refusal {
        warning_ui(ui, &refusal);
    }
}

/// Beside what starts or ends a search, where the settings are a line.
fn unfold_ui(ui: &mut Ui, search: &PlacementSearch, requests: &mut Vec<PlacementSearchRequest>) {
    let about = "Shows what may move and what is made least, to be changed";
    if search.is_folded() && button_ui(ui, UNFOLD, about).clicked() {
        requests.push(PlacementSearchRequest::ShowSettings(true));
    }
}

fn running_ui(
    ui: &mut Ui,
    search: &PlacementSearch,
    running: &Running,
    requests: &mut Vec<PlacementSearchRequest>,
) {
    let is_stopping = running.enough.is_cancelled();
    ui.horizontal(|ui| {
        let stop = ui.add_enabled(!is_stopping, main_button("Stop"));
        if stop.explained("Ends the search with the best so far").clicked() {
            requests.push(PlacementSearchRequest::Stop);
        }
        unfold_ui(ui, search, requests);
    });
    let words = match (&running.best, is_stopping) {
        (_, true) => "Stopping: the best so far is being judged".to_owned(),
        (None, false) => "Searching: nothing better than the start so far".to_owned(),
        (Some(best), false) => format!(
            "Searching: {} after {} layouts",
            objective_text(running.of.goal, best.objective),
            count(usize::try_from(running.evaluations).unwrap_or(usize::MAX)),
        ),
    };
    ui.add(Label::new(words).wrap());
    if !search.is_current {
        quiet_ui(ui, "The design has changed since the start: the search is of the one before");
    }
    curve_ui(ui, running.of.goal, &search.curve, None, None);
}
