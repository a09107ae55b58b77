//! The tools that are received: which bodies they are, and how good.

use crate::palette;
use crate::palette::ThemedColor;
use crate::widgets::basic::{quiet_ui, section_ui, state_ui};
use crate::widgets::tooltip::Explain;
use crate::workspaces::live::requests::LiveRequest;
use crate::workspaces::live::state::LiveState;
use bevy_egui::egui::{self, ComboBox, RichText, Ui};
use trackwright_design::{BodyRole, Design};
use trackwright_formats::printable::printable;
use trackwright_openigtlink::relay::ToolState;
use trackwright_openigtlink::roles::base_name;
use trackwright_openigtlink::session::ToolView;

/// Draws the list.
pub fn tools_ui(ui: &mut Ui, state: &LiveState, design: &Design) -> Vec<LiveRequest> {
    let mut requests = Vec::new();
    let Some(seen) = state.seen.as_ref().filter(|_| state.is_connected()) else {
        return requests;
    };
    section_ui(ui, "Tools received");
    if seen.tools.is_empty() {
        quiet_ui(ui, "none yet");
    }
    for (name, view) in &seen.tools {
        let assigned = state.assigned.get(name);
        ui.horizontal(|ui| {
            let shown = printable(base_name(name)).into_owned();
            let label = RichText::new(shown).color(palette::TEXT_STRONG.color32());
            ui.add(egui::Label::new(label).truncate()).explained(printable(name).into_owned());
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                requests.extend(role_ui(ui, name, view.role, assigned, design));
            });
        });
        tool_state_ui(ui, view);
        ui.add_space(4.0);
    }
    let is_tool_received = seen.tools.values().any(|view| view.role == Some(BodyRole::Tool));
    if !seen.tools.is_empty() && !is_tool_received {
        let name = &design.tool.body.rigid.name;
        quiet_ui(ui, format!("None is called like the design's tool, {name}: choose which it is."));
    }
    requests
}

fn tool_state_ui(ui: &mut Ui, view: &ToolView) {
    match view.state {
        ToolState::Good => {
            state_ui(ui, "good", palette::MET);
            let shift_ms = 1e3 * view.clock.shift_s;
            if shift_ms >= 1.0 {
                quiet_ui(ui, format!("clock shift {shift_ms:.0} ms: may be latency"));
            }
        }
        ToolState::NotGood(reason) => {
            state_ui(ui, &format!("not good: {reason}"), palette::MISSED);
        }
    }
}

/// Which body it is; the body with its name unless the person chose another.
fn role_ui(
    ui: &mut Ui,
    tool: &str,
    role: Option<BodyRole>,
    assigned: Option<&Option<BodyRole>>,
    design: &Design,
) -> Option<LiveRequest> {
    let words = |role: Option<BodyRole>| match role {
        Some(BodyRole::Tool) => "the tool",
        Some(BodyRole::Crf) => "the CRF",
        None => "no body",
    };
    let shown = match assigned {
        Some(assigned) => words(*assigned),
        None => words(role),
    };
    let mut request = None;
    let combo = ComboBox::from_id_salt(("role", tool)).width(84.0).selected_text(shown);
    let combo = combo.show_ui(ui, |ui| {
        let choices = [Some(BodyRole::Tool), Some(BodyRole::Crf), None];
        for choice in choices {
            if choice == Some(BodyRole::Crf) && design.crf.is_none() {
                continue;
            }
            let is_chosen = assigned == Some(&choice);
            if ui.selectable_label(is_chosen, words(choice)).clicked() {
                request = Some(LiveRequest::Assign(tool.to_owned(), Some(choice)));
            }
        }
        if ui.selectable_label(assigned.is_none(), "by its name").clicked() {
            request = Some(LiveRequest::Assign(tool.to_owned(), None));
        }
    });
    combo.response.explained("Which body of the design the tracker's tool is");
    request
}
