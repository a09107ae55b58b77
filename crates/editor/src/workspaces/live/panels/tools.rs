//! The tools that are heard: which bodies they are, and how good.

use crate::palette;
use crate::palette::ThemedColor;
use crate::widgets::basic::{quiet_ui, section_ui, state_ui};
use crate::workspaces::live::requests::LiveRequest;
use crate::workspaces::live::state::LiveState;
use bevy_egui::egui::{self, ComboBox, RichText, Ui};
use trackwright_design::{BodyRole, Design};
use trackwright_formats::printable::printable;
use trackwright_openigtlink::relay::ToolState;
use trackwright_openigtlink::roles::base_name;
use trackwright_openigtlink::session::ToolView;

/// Draws the list.
pub fn tools_ui(ui: &mut Ui, desk: &LiveState, design: &Design) -> Vec<LiveRequest> {
    let mut asked = Vec::new();
    let Some(seen) = desk.seen.as_ref().filter(|_| desk.is_connected()) else {
        return asked;
    };
    section_ui(ui, "Tools heard");
    if seen.tools.is_empty() {
        quiet_ui(ui, "none yet");
    }
    for (name, view) in &seen.tools {
        let said = desk.assigned.get(name);
        ui.horizontal(|ui| {
            let shown = printable(base_name(name)).into_owned();
            let label = RichText::new(shown).color(palette::TEXT_STRONG.color32());
            ui.add(egui::Label::new(label).truncate()).on_hover_text(printable(name).into_owned());
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                asked.extend(role_ui(ui, name, view.role, said, design));
            });
        });
        tool_state_ui(ui, view);
        ui.add_space(4.0);
    }
    let is_tool_heard = seen.tools.values().any(|view| view.role == Some(BodyRole::Tool));
    if !seen.tools.is_empty() && !is_tool_heard {
        let name = &design.tool.body.rigid.name;
        quiet_ui(ui, format!("None is called like the design's tool, {name}: say which it is."));
    }
    asked
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

/// Which body it is; what its name says unless the person says otherwise.
fn role_ui(
    ui: &mut Ui,
    tool: &str,
    role: Option<BodyRole>,
    said: Option<&Option<BodyRole>>,
    design: &Design,
) -> Option<LiveRequest> {
    let words = |role: Option<BodyRole>| match role {
        Some(BodyRole::Tool) => "the tool",
        Some(BodyRole::Crf) => "the CRF",
        None => "no body",
    };
    let shown = match said {
        Some(said) => words(*said),
        None => words(role),
    };
    let mut asked = None;
    let combo = ComboBox::from_id_salt(("role", tool)).width(84.0).selected_text(shown);
    combo.show_ui(ui, |ui| {
        let choices = [Some(BodyRole::Tool), Some(BodyRole::Crf), None];
        for choice in choices {
            if choice == Some(BodyRole::Crf) && design.crf.is_none() {
                continue;
            }
            let is_chosen = said == Some(&choice);
            if ui.selectable_label(is_chosen, words(choice)).clicked() {
                asked = Some(LiveRequest::Assign(tool.to_owned(), Some(choice)));
            }
        }
        if ui.selectable_label(said.is_none(), "by its name").clicked() {
            asked = Some(LiveRequest::Assign(tool.to_owned(), None));
        }
    });
    asked
}
