//! The design procedure, step by step: where the design stands, on what each step was decided, and what
//! has changed since.

use crate::palette;
use crate::palette::ThemedColor;
use crate::widgets::basic::right_text_ui;
use crate::widgets::basic::{
    MET_SIGN, MISSED_SIGN, count, decimal, fact_ui, main_button, quiet_ui, section_ui, short_name,
    warning_ui, with_unit,
};
use crate::widgets::theme;
use crate::widgets::tooltip::{Explain, button_ui};
use crate::widgets::verdict::verdict_mark;
use crate::workspaces::decide::panels::DecideView;
use crate::workspaces::decide::panels::recorded_ui::recorded_ui;
use crate::workspaces::decide::requests::DecideRequest;
use bevy_egui::egui::{Align, Color32, Grid, Label, Layout, RichText, TextEdit, Ui};
use trackwright_design::Decision;
use trackwright_formats::printable::printable;
use trackwright_procedure::{BuiltStatus, State, Step, StepStatus, StudiesStatus, headline};
use trackwright_project::RoomSource;
use trackwright_simulation::Metric;
use trackwright_simulation::figures::with_minus_signs;

/// Longest name that a row shows whole.
const MOST_CHARS: usize = 20;

/// Changes since a decision that are listed one by one.
const MOST_CHANGES: usize = 4;

/// Draws the rooms and the steps.
pub fn steps_ui(ui: &mut Ui, view: &DecideView) -> Vec<DecideRequest> {
    let mut requests = Vec::new();
    section_ui(ui, "Rooms");
    rooms_ui(ui, view, &mut requests);
    let status = view.status();
    for step in Step::ALL {
        ui.add_space(8.0);
        let state = status.map(|status| status.state(step));
        head_ui(ui, step, state);
        if let Some(status) = status {
            quiet_ui(ui, headline(status, step));
        }
        match (status, step) {
            (None, _) => {
                quiet_ui(ui, "computing…");
            }
            (Some(status), Step::Crf) => studies_ui(ui, "crf", &status.crf),
            (Some(status), Step::Tool) => studies_ui(ui, "tool", &status.tool),
            (Some(status), Step::Built) => built_ui(ui, view, &status.built, &mut requests),
        }
        if let Some(status) = status {
            decision_ui(ui, view, (step, status), &mut requests);
        }
    }
    requests
}

/// What a step is called where there is room.
fn title(step: Step) -> &'static str {
    match step {
        Step::Crf => "CRF alone",
        Step::Tool => "Tool",
        Step::Built => "Built tool",
    }
}

fn head_ui(ui: &mut Ui, step: Step, state: Option<State>) {
    ui.horizontal(|ui| {
        let name = format!("{}  {}", step.number(), title(step));
        let name = RichText::new(name).color(palette::TEXT_STRONG.color32());
        ui.label(name.strong());
        let Some(state) = state else { return };
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let (sign, color) = badge(state);
            let text = match sign {
                Some(sign) => format!("{sign} {}", state.words()),
                None => state.words().to_owned(),
            };
            ui.label(RichText::new(text).color(color));
        });
    });
}

fn badge(state: State) -> (Option<char>, Color32) {
    match state {
        State::Met | State::Decided => (Some(MET_SIGN), theme::verdict_color(Some(true))),
        State::Missed | State::DecidedOnOtherFigures => {
            (Some(MISSED_SIGN), theme::verdict_color(Some(false)))
        }
        _ => (None, palette::TEXT_QUIET.color32()),
    }
}

/// The design's own room, and the further ones that it is judged in.
fn rooms_ui(ui: &mut Ui, view: &DecideView, requests: &mut Vec<DecideRequest>) {
    ui.add(Label::new(printable(view.environment)).wrap()).explained("The design's own room");
    for file in &view.document.design().procedure.further_rooms {
        ui.horizontal(|ui| {
            let named = view.status().and_then(|status| {
                let rows = &status.tool.rows;
                rows.iter().find(|row| row.room.file == *file)
            });
            let name = named.map_or(file.as_str(), |row| row.room.name.as_str());
            let name = if name.is_empty() { file } else { name };
            ui.add(Label::new(printable(name)).truncate()).explained(printable(file));
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                let remove = ui.small_button("×").explained("No longer judged in it");
                if remove.clicked() {
                    requests.push(DecideRequest::RemoveRoom(file.clone()));
                }
            });
        });
    }
    let menu = ui.menu_button("Add room…", |ui| {
        if view.rooms.is_empty() {
            quiet_ui(
                ui,
                match view.is_listing {
                    true => "reading…",
                    false => "no rooms beside the design or built in",
                },
            );
        }
        for room in view.rooms {
            let about = match &room.place {
                RoomSource::BuiltIn(_) => "built in".to_owned(),
                RoomSource::File(file) => file.display().to_string(),
            };
            let name = printable(&room.summary.name);
            if ui.button(name).explained(about).clicked() {
                requests.push(DecideRequest::AddRoom(room.place.clone()));
                ui.close();
            }
        }
    });
    menu.response.explained("Judges the design in a further room as well");
}

fn studies_ui(ui: &mut Ui, id: &str, status: &StudiesStatus) {
    if status.state == State::DoesNotApply {
        quiet_ui(ui, "The design has no CRF");
        return;
    }
    Grid::new(("status", id)).num_columns(4).spacing([8.0, 2.0]).show(ui, |ui| {
        quiet_ui(ui, "");
        for head in ["RMS", "max", ""] {
            right_text_ui(ui, head, palette::TEXT_QUIET.color32());
        }
        ui.end_row();
        let mut last_room = None;
        for row in &status.rows {
            let room = match row.room.name.trim() {
                "" => &row.room.file,
                name => name,
            };
            // Targets stand below the room that they are judged in.
            if row.target.is_some() && last_room != Some(&row.room.file) {
                last_room = Some(&row.room.file);
                quiet_ui(ui, short_name(room, MOST_CHARS));
                ui.end_row();
            }
            let name = match &row.target {
                Some(target) => target.as_str(),
                None => room,
            };
            let about = format!("{room}\n{}", row.room.file);
            let label = Label::new(
                RichText::new(short_name(name, MOST_CHARS)).color(palette::TEXT.color32()),
            );
            match &row.studied {
                Err(why) => {
                    ui.add(label).explained(format!("{about}\n{why}"));
                    right_text_ui(ui, "none", palette::MISSED.color32());
                    right_text_ui(ui, "none", palette::MISSED.color32());
                }
                Ok(studied) => {
                    let figures = &studied.figures;
                    let words = figures.bounded().map(|figure| {
                        format!("\n{} {}", figure.metric.label(), figure.words(4, " "))
                    });
                    ui.add(label).explained(format!("{about}{}", words.collect::<String>()));
                    for metric in [Metric::TIP_RMS, Metric::TIP_MAX] {
                        let value = figures.get(metric).map(|figure| figure.value_text(2));
                        let text = with_unit(&value.unwrap_or_default(), "mm");
                        right_text_ui(ui, &text, palette::TEXT_STRONG.color32());
                    }
                }
            }
            match row.verdict() {
                None => {
                    quiet_ui(ui, "");
                }
                Some(verdict) => {
                    let (sign, color) = verdict_mark(verdict);
                    ui.label(RichText::new(sign).color(color)).explained(verdict.label());
                }
            }
            ui.end_row();
        }
    });
}

fn built_ui(
    ui: &mut Ui,
    view: &DecideView,
    status: &BuiltStatus,
    requests: &mut Vec<DecideRequest>,
) {
    match &status.recording {
        None => {
            quiet_ui(ui, "Its measured poses beside the predicted ones");
        }
        Some(Err(why)) => {
            warning_ui(ui, why);
        }
        Some(Ok(recording)) => {
            let found = &recording.found;
            for (name, value_mm) in [
                ("measured RMS", found.measured_rms_mm),
                ("predicted RMS", found.predicted_rms_mm),
                ("difference RMS", found.residual_rms_mm),
            ] {
                fact_ui(ui, name, &with_unit(&decimal(value_mm, 3), "mm"));
            }
            let poses = format!("{} of {}", count(found.used), count(found.poses));
            fact_ui(ui, "poses", &poses);
            let words = with_minus_signs(&found.statement);
            let words = RichText::new(words).color(palette::TEXT.color32());
            ui.add(Label::new(words).wrap());
        }
    }
    for note in view.notes() {
        warning_ui(ui, note);
    }
    recorded_ui(ui, view, requests);
}

/// What was decided, or what can be.
fn decision_ui(
    ui: &mut Ui,
    view: &DecideView,
    (step, status): (Step, &StepStatus),
    requests: &mut Vec<DecideRequest>,
) {
    if let Some(decision) = view.document.design().procedure.decision(step) {
        decided_ui(ui, decision);
        let changes = status.changes(step);
        for change in changes.iter().take(MOST_CHANGES) {
            warning_ui(ui, &change.to_string());
        }
        if changes.len() > MOST_CHANGES {
            quiet_ui(ui, format!("and {} more", changes.len() - MOST_CHANGES));
        }
    }
    let hindrance = hindrance(view, step, status);
    if matches!(&hindrance, Some(Hindrance::Nothing)) {
        return;
    }
    let mut note = view.state.note(step).to_owned();
    let field = TextEdit::singleline(&mut note)
        .hint_text("Why, in your words")
        .desired_width(f32::INFINITY);
    if ui.add(field).changed() {
        requests.push(DecideRequest::SetNote(step, note));
    }
    ui.horizontal(|ui| {
        let is_decided = view.document.design().procedure.decision(step).is_some();
        let name = if is_decided { "Decide anew" } else { "Decide" };
        let button = ui.add_enabled(hindrance.is_none(), main_button(name));
        let button = match &hindrance {
            Some(Hindrance::Note(objection)) => {
                button.explained(format!("A reason is needed: {objection}"))
            }
            _ => {
                button.explained("Keeps these figures, their rooms and today's date in the design")
            }
        };
        if button.clicked() {
            requests.push(DecideRequest::Decide(step));
        }
        if is_decided && button_ui(ui, "Withdraw", "Takes the decision out of the design").clicked()
        {
            requests.push(DecideRequest::Withdraw(step));
        }
    });
}

fn decided_ui(ui: &mut Ui, decision: &Decision) {
    let note = match decision.note.trim() {
        "" => String::new(),
        note => format!(": {note}"),
    };
    let text = format!("Decided on {}{note}", decision.date);
    let color = palette::TEXT.color32();
    ui.add(Label::new(RichText::new(text).color(color)).wrap());
}

/// What stands in the way of a decision.
enum Hindrance {
    /// There is nothing to decide on.
    Nothing,
    /// What is not met for certain is decided with a reason only.
    Note(&'static str),
}

fn hindrance(view: &DecideView, step: Step, status: &StepStatus) -> Option<Hindrance> {
    match status.basis(step) {
        Err(_) => Some(Hindrance::Nothing),
        Ok(_) => match view.state.note(step).trim() {
            "" => status.objection(step).map(Hindrance::Note),
            _ => None,
        },
    }
}
