//! The tracker's server, what is sent on, and the recording.

use crate::palette;
use crate::palette::ThemedColor;
use crate::widgets::basic::{
    THIN_SPACE, count, counted, fact_ui, quiet_ui, section_ui, state_ui, warning_ui,
};
use crate::widgets::tooltip::{Explain, button_ui, main_button_ui};
use crate::workspaces::design::rows::text_row_ui;
use crate::workspaces::live::requests::LiveRequest;
use crate::workspaces::live::state::LiveState;
use bevy_egui::egui::{self, DragValue, Ui};
use trackwright_openigtlink::codec::DEFAULT_PORT;
use trackwright_openigtlink::session::{Link, SessionState};
use trackwright_project::file_name;

/// Where poses are sent on at first: the port after the tracker's, which is taken on one machine.
const FIRST_PORT: u16 = DEFAULT_PORT + 1;

/// Draws the connection and its state.
pub fn tracker_ui(ui: &mut Ui, state: &LiveState) -> Vec<LiveRequest> {
    let mut requests = Vec::new();
    section_ui(ui, "Tracker");
    let is_connected = state.is_connected();
    ui.add_enabled_ui(!is_connected, |ui| {
        if let Some(server) = text_row_ui(ui, "server", &state.server) {
            requests.push(LiveRequest::SetServer(server));
        }
        requests.extend(port_ui(ui, state.port));
    });
    ui.add_space(4.0);
    if is_connected {
        if button_ui(ui, "Disconnect", "Receives no more poses").clicked() {
            requests.push(LiveRequest::Disconnect);
        }
    } else if main_button_ui(ui, "Connect", "Receives poses from the server").clicked() {
        requests.push(LiveRequest::Connect);
    }
    if let Some(problem) = &state.problem {
        warning_ui(ui, problem);
    }
    match &state.seen {
        Some(seen) if is_connected => link_ui(ui, seen),
        _ => {
            quiet_ui(ui, "Receives poses over OpenIGTLink, as PLUS and 3D Slicer send them.");
        }
    }
    requests
}

fn port_ui(ui: &mut Ui, port: Option<u16>) -> Option<LiveRequest> {
    let mut is_sent = port.is_some();
    let mut request = None;
    ui.horizontal(|ui| {
        let about = "Compensated poses for 3D Slicer or any other client on this machine";
        if ui.checkbox(&mut is_sent, "send on at port").explained(about).changed() {
            request = Some(LiveRequest::SetPort(is_sent.then_some(FIRST_PORT)));
        }
        let mut number = port.unwrap_or(FIRST_PORT);
        let field = DragValue::new(&mut number).range(1024..=u16::MAX).speed(0.2);
        let about = "The port of this machine at which clients find the poses";
        if ui.add_enabled(is_sent, field).explained(about).changed() {
            request = Some(LiveRequest::SetPort(Some(number)));
        }
    });
    request
}

fn link_ui(ui: &mut Ui, seen: &SessionState) {
    match &seen.link {
        Link::Connecting => state_ui(ui, "connecting…", palette::TEXT),
        Link::Connected { server, .. } => {
            state_ui(ui, &format!("connected to {server}"), palette::MET);
        }
        Link::Lost { why, .. } => {
            state_ui(ui, &format!("lost: {why}; it is tried again"), palette::MISSED);
        }
    }
    let messages = usize::try_from(seen.counts.messages).unwrap_or(usize::MAX);
    fact_ui(ui, "messages", &count(messages));
    let dropped: u64 = seen.counts.dropped.values().sum();
    if dropped > 0 {
        let dropped = usize::try_from(dropped).unwrap_or(usize::MAX);
        let reasons: Vec<String> = (seen.counts.dropped.iter())
            .map(|(reason, n)| {
                format!("{}: {reason}", count(usize::try_from(*n).unwrap_or(usize::MAX)))
            })
            .collect();
        let fact = ui.scope(|ui| fact_ui(ui, "poses that were not good", &count(dropped)));
        fact.response.explained(reasons.join("\n"));
    }
    if let Some((address, clients)) = &seen.serving {
        let clients = counted(*clients, "client", "clients");
        fact_ui(ui, "sent on at", &address.to_string());
        fact_ui(ui, "to", &clients);
        if seen.latency.count > 0 {
            let median_ms = 1e3 * seen.latency.median_s;
            let p99_ms = 1e3 * seen.latency.p99_s;
            let text = format!("{median_ms:.1}, 99 % {p99_ms:.1}{THIN_SPACE}ms");
            fact_ui(ui, "adds, median", &text);
        }
    }
}

/// Draws the recording.
pub fn recording_ui(ui: &mut Ui, state: &LiveState) -> Vec<LiveRequest> {
    let mut requests = Vec::new();
    section_ui(ui, "Recording");
    let recording = (state.seen.as_ref())
        .and_then(|seen| seen.recording.as_ref())
        .filter(|_| state.is_connected());
    let is_growing = recording.is_some_and(|recording| recording.failed.is_none());
    if is_growing {
        if button_ui(ui, "Stop recording", "Closes the file").clicked() {
            requests.push(LiveRequest::StopRecording);
        }
    } else {
        ui.add_enabled_ui(state.is_connected(), |ui| {
            let about = "Poses as they are measured, a line each, whole whatever happens";
            if ui.button("Record…").explained(about).clicked() {
                requests.push(LiveRequest::ShowRecord);
            }
        });
    }
    let Some(recording) = recording else {
        return requests;
    };
    let name = file_name(&recording.file);
    ui.horizontal(|ui| {
        if is_growing {
            let (rect, _) = ui.allocate_exact_size(egui::vec2(12.0, 12.0), egui::Sense::hover());
            ui.painter().circle_filled(rect.center(), 4.0, palette::MISSED.color32());
        }
        ui.add(egui::Label::new(name).truncate()).explained(recording.file.display().to_string());
    });
    let samples = usize::try_from(recording.samples).unwrap_or(usize::MAX);
    fact_ui(ui, "samples", &count(samples));
    if let Some(why) = &recording.failed {
        warning_ui(ui, &format!("Nothing more is recorded: {why}"));
    }
    requests
}
