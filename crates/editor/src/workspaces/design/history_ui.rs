//! The steps of a document as a list: where it is, what is saved, and a click to go elsewhere.

use crate::document::requests::EditRequest;
use crate::widgets::basic::{Row, quiet_ui, row_ui, section_ui};
use crate::widgets::theme;
use bevy_egui::egui::{Id, Margin, Panel, Response, ScrollArea, Ui};
use trackwright_design::{HistoryList, HistoryState};

/// So many states are seen at once; more scroll.
const SEEN: f32 = 8.5;

/// Draws the list at the lower end of a column, the oldest state first.
pub fn history_ui(ui: &mut Ui, history: &HistoryList) -> Vec<EditRequest> {
    Panel::bottom("history")
        .resizable(false)
        .frame(theme::panel_frame(Margin::symmetric(0, 6)))
        .show(ui, |ui| list_ui(ui, history))
        .inner
}

fn list_ui(ui: &mut Ui, history: &HistoryList) -> Vec<EditRequest> {
    let mut actions = Vec::new();
    section_ui(ui, "History");
    // The list follows the present when that moves, and stays where it was scrolled to else.
    let followed = Id::new("followed state");
    let is_new = ui.data(|data| data.get_temp::<usize>(followed)) != Some(history.present);
    ui.data_mut(|data| data.insert_temp(followed, history.present));
    let top = (history.present as f32 - 4.0).max(0.0) * theme::ROW_HEIGHT;
    let mut area = ScrollArea::vertical()
        .id_salt("history")
        .max_height(SEEN * theme::ROW_HEIGHT)
        // A panel is first as low as it can be, and takes its height from what is in it.
        .min_scrolled_height(SEEN.min(history.states.len() as f32) * theme::ROW_HEIGHT)
        .auto_shrink([false, true]);
    if is_new {
        area = area.vertical_scroll_offset(top);
    }
    ui.spacing_mut().item_spacing.y = 0.0;
    area.show_rows(ui, theme::ROW_HEIGHT, history.states.len(), |ui, shown| {
        for index in shown {
            let Some(state) = history.states.get(index) else {
                continue;
            };
            if state_ui(ui, state, index, history.present).clicked() && index != history.present {
                actions.push(EditRequest::JumpTo(index));
            }
        }
    });
    if history.states.len() == 1 {
        quiet_ui(ui, "no step yet");
    }
    actions
}

fn state_ui(ui: &mut Ui, state: &HistoryState, index: usize, present: usize) -> Response {
    let note = match (state.is_saved, index > present) {
        (true, _) => "saved",
        (false, true) => "undone",
        (false, false) => "",
    };
    let row = Row {
        label: state.label.unwrap_or("Beginning"),
        note,
        is_selected: index == present,
        ..Row::default()
    };
    row_ui(ui, &row)
}
