//! Which recording of the built tool is looked at, and what its tables do not state themselves.

use crate::widgets::basic::{NumberChange, NumberField, number_ui, quiet_ui};
use crate::widgets::tooltip::{Explain, button_ui};
use crate::workspaces::decide::panels::DecideView;
use crate::workspaces::decide::requests::DecideRequest;
use bevy_egui::egui::{Align, Layout, Ui};
use trackwright_calibration::agreement::{BuiltRecording, RecordedFrame};
use trackwright_design::BodyRole;

/// More readings than anybody averages.
const MOST_READINGS: f64 = 1e6;

/// Draws what chooses a recording, and what is to be known of the chosen one.
pub(crate) fn recorded_ui(ui: &mut Ui, view: &DecideView, requests: &mut Vec<DecideRequest>) {
    let recorded = view.state.recorded.as_ref();
    ui.horizontal(|ui| {
        let open = ui.button("Recorded poses…").explained(
            "A table of the built tool's true and measured poses, as `characterize` writes it",
        );
        if open.clicked() {
            requests.push(DecideRequest::ShowRecorded(BodyRole::Tool));
        }
        if recorded.is_some() && button_ui(ui, "Close", "Puts the recording away").clicked() {
            requests.push(DecideRequest::CloseRecorded);
        }
        if recorded.is_some() {
            let about = "Shows the tool at each recorded pose in the Study workspace, with the error that \
                         was measured beside the one that is predicted";
            if ui.button("Pose by pose").on_hover_text(about).clicked() {
                requests.push(DecideRequest::ShowPoses);
            }
        }
    });
    let Some(recorded) = recorded else { return };
    quiet_ui(ui, short_path(&recorded.table)).explained(&recorded.table);
    let mut changed = recorded.clone();
    if view.document.design().crf.is_some() {
        frame_ui(ui, &mut changed, requests);
    }
    ui.checkbox(&mut changed.is_registered, "registered to these poses")
        .explained(
            "The true poses were registered to this very recording, which took up a part of the error: the same \
             part is taken out of the prediction",
        );
    let readings = NumberField {
        decimals: 0,
        speed: 0.1,
        min: 1.0,
        max: MOST_READINGS,
        ..NumberField::plain("readings averaged")
    };
    let about = "Readings that each recorded pose is the mean of: the tracker's jitter is smaller by their root";
    if let Some(count) = labelled_ui(ui, &readings, about, f64::from(changed.averaged)) {
        // Within the field's bounds.
        changed.averaged = count.round() as u32;
    }
    let truth = NumberField::length("true tip known to").positive();
    let about = "Standard deviation of the true position of the tip, an axis: of the reference tracker, the \
                 phantom, the divot";
    if let Some(std_mm) = labelled_ui(ui, &truth, about, changed.truth_std_mm) {
        changed.truth_std_mm = std_mm;
    }
    if changed != *recorded {
        requests.push(DecideRequest::SetRecorded(changed));
    }
}

/// In which frame the poses are: the CRF's, or the tracker's with the CRF's own poses beside them or
/// without.
fn frame_ui(ui: &mut Ui, changed: &mut BuiltRecording, requests: &mut Vec<DecideRequest>) {
    if let Some(table) = changed.crf_table.clone() {
        ui.horizontal(|ui| {
            quiet_ui(ui, format!("CRF: {}", short_path(&table))).explained(&table);
            let about = "Without it errors are in the tracker's frame";
            if ui.small_button("×").explained(about).clicked() {
                changed.crf_table = None;
            }
        });
        return;
    }
    let mut is_in_crf = changed.frame == RecordedFrame::Crf;
    ui.checkbox(&mut is_in_crf, "in the CRF's frame").explained("Else in the tracker's");
    changed.frame = match is_in_crf {
        true => RecordedFrame::Crf,
        false => RecordedFrame::Tracker,
    };
    if !is_in_crf {
        let about = "The same table of the CRF, with a row for every row of the tool's: errors are then those \
                     of the tool in the CRF";
        if ui.button("CRF's poses…").explained(about).clicked() {
            requests.push(DecideRequest::ShowRecorded(BodyRole::Crf));
        }
    }
}

/// A number behind what it is; what it becomes.
fn labelled_ui(ui: &mut Ui, field: &NumberField, about: &str, value: f64) -> Option<f64> {
    let row = ui.horizontal(|ui| {
        quiet_ui(ui, field.name).explained(about);
        let right = Layout::right_to_left(Align::Center);
        ui.with_layout(right, |ui| number_ui(ui, field, value)).inner
    });
    let changes = row.inner.into_iter().rev();
    changes.into_iter().find_map(|change| match change {
        NumberChange::Set(value) => Some(value),
        NumberChange::Begin | NumberChange::Commit => None,
    })
}

/// The end of a path, which identifies it better than its beginning.
fn short_path(path: &str) -> String {
    const MOST: usize = 30;
    let count = path.chars().count();
    match count > MOST {
        false => path.to_owned(),
        true => format!("…{}", path.chars().skip(count + 1 - MOST).collect::<String>()),
    }
}
