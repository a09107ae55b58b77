//! The rooms that the design could be put in, each with the error of its model on unseen data.

use crate::palette;
use crate::palette::ThemedColor;
use crate::widgets::basic::{Mark, Row, counted, length, quiet_ui, row_ui, section_ui};
use crate::widgets::tooltip::Explain;
use crate::workspaces::field::requests::FieldRequest;
use crate::workspaces::field::state::FieldState;
use bevy_egui::egui::Ui;
use trackwright_project::{RoomListing, RoomSource};
use trackwright_report::room::{MODEL_ERROR, model_error};

/// Draws the list; a click puts the design into the room.
pub fn rooms_ui(ui: &mut Ui, state: &FieldState) -> Vec<FieldRequest> {
    let mut requests = Vec::new();
    section_ui(ui, "Rooms");
    quiet_ui(ui, MODEL_ERROR);
    if state.rooms.is_empty() {
        quiet_ui(ui, if state.listing.is_some() { "reading…" } else { "none" });
    }
    for room in &state.rooms {
        let is_own = state.own.as_ref() == Some(&room.place);
        let note = match (room.summary.samples, room.summary.held_out_rms_mm) {
            (None, _) if room.summary.has_metal => "simulated".to_owned(),
            (None, _) => "ideal".to_owned(),
            (Some(_), None) => "none".to_owned(),
            (Some(_), Some(rms_mm)) => length(rms_mm),
        };
        let mark = is_own.then_some((Mark::Dot, palette::ACCENT.color32()));
        let name = match &room.place {
            RoomSource::BuiltIn(_) => format!("{} (built in)", room.summary.name),
            RoomSource::File(_) => room.summary.name.clone(),
        };
        let row = Row {
            label: &name,
            note: &note,
            is_selected: is_own,
            mark: Some(mark.unwrap_or((Mark::Dot, palette::LINE.color32()))),
            ..Row::default()
        };
        let response = row_ui(ui, &row).explained(about(room, is_own));
        if response.clicked() && !is_own {
            requests.push(FieldRequest::Assign(room.place.clone()));
        }
    }
    requests
}

/// What the row has no room for.
fn about(room: &RoomListing, is_own: bool) -> String {
    let place = match &room.place {
        RoomSource::BuiltIn(_) => "built in".to_owned(),
        RoomSource::File(path) => path.display().to_string(),
    };
    let samples = match room.summary.samples {
        None => "never measured".to_owned(),
        Some(samples) => counted(samples, "sample", "samples"),
    };
    let error = model_error(room.summary.held_out_rms_mm);
    let verb = if is_own { "The design is in this room" } else { "Puts the design into this room" };
    format!("{verb}\n{place}\n{samples}\n{error}")
}
