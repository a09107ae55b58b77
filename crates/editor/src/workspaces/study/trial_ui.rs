//! The shown trial in numbers: where the tool is, where it seems to be, and how far that is off.

use crate::palette;
use crate::palette::ThemedColor;
use crate::widgets::basic::{decimal, length, quiet_ui, section_ui, with_unit};
use crate::widgets::tooltip::Explain;
use crate::workspaces::study::state::{RotationForm, StudyRequest};
use bevy_egui::egui::{self, Align, Grid, Label, Layout, RichText, Ui};
use trackwright_geometry::pose::{Pose, pose_to_array};
use trackwright_geometry::rotation::log_quaternion;
use trackwright_project::MeasuredError;
use trackwright_simulation::{Trial, TrialSource, source_words};

/// What the panel shows.
pub struct TrialView<'a> {
    /// `None` while it is computed.
    pub trial: Option<&'a Trial>,
    /// Whose pose it is.
    pub title: String,
    /// What the trial's true and simulated poses are called.
    pub columns: [&'static str; 2],
    pub rotation: RotationForm,
    /// Poses are relative to the CRF, or to the tracker where there is none.
    pub has_crf: bool,
    /// What each sensor contributes to the tip error; empty where that is not looked at.
    pub sources: &'a [TrialSource],
    /// What was measured there, where the trials are a recording of the built tool.
    pub measured: Option<&'a MeasuredError>,
}

const COLUMN_WIDTH: f32 = 84.0;

/// Draws the panel.
pub fn trial_ui(ui: &mut Ui, view: &TrialView) -> Vec<StudyRequest> {
    let mut actions = Vec::new();
    let frame = if view.has_crf { "CRF" } else { "tracker" };
    section_ui(ui, &format!("{} in the {frame}", view.title));
    // Everything of a trial is to be seen at once, with the charts below it.
    ui.spacing_mut().item_spacing.y = 1.0;
    ui.spacing_mut().interact_size.y = 18.0;
    let Some(trial) = view.trial else {
        quiet_ui(ui, "computing…");
        return actions;
    };
    let poses = [&trial.crf_from_tool, &trial.crf_from_tool_simulated];
    Grid::new("trial")
        .num_columns(3)
        .min_col_width(COLUMN_WIDTH)
        .spacing([6.0, 0.0])
        .show(ui, |ui| {
            form_ui(ui, view.rotation, &mut actions);
            for (name, pose) in view.columns.into_iter().zip(poses) {
                right_ui(ui, |ui| {
                    quiet_ui(ui, name).explained(quaternion(pose));
                });
            }
            ui.end_row();
            let position = |pose: &Pose| pose.translation.vector;
            row_ui(ui, ["x", "y", "z"], poses.map(|p| position(p).into()), length);
            let names = match view.rotation {
                RotationForm::EulerAngles => ["rx", "ry", "rz"],
                RotationForm::Rodrigues => ["rotation x", "rotation y", "rotation z"],
            };
            let rotation = poses.map(|pose| degrees(pose, view.rotation));
            row_ui(ui, names, rotation, |v| with_unit(&decimal(v, 3), "°"));
        })
        .response
        .explained(format!(
            "{} {}\n{} {}",
            view.columns[0],
            quaternion(poses[0]),
            view.columns[1],
            quaternion(poses[1])
        ));
    errors_ui(ui, trial);
    sources_ui(ui, view.sources);
    if let Some(measured) = view.measured {
        measured_ui(ui, measured);
    }
    actions
}

/// How rotations are written, as two buttons in the head of the table.
fn form_ui(ui: &mut Ui, shown: RotationForm, actions: &mut Vec<StudyRequest>) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 0.0;
        ui.spacing_mut().button_padding.x = 4.0;
        for (form, name, about) in [
            (
                RotationForm::EulerAngles,
                "Euler",
                "Rotations as Euler angles rx, ry, rz about the axes x, y and z, in this order",
            ),
            (
                RotationForm::Rodrigues,
                "vector",
                "Rotations as Rodrigues vectors: the axis of rotation times its angle",
            ),
        ] {
            let name = RichText::new(name).font(crate::widgets::theme::label_font());
            let label = egui::Button::selectable(form == shown, name);
            if ui.add(label).explained(about).clicked() {
                actions.push(StudyRequest::ShowRotation(form));
            }
        }
    });
}

fn errors_ui(ui: &mut Ui, trial: &Trial) {
    ui.add_space(4.0);
    let e = trial.tip_error_in_crf_mm;
    let axes = [e.x, e.y, e.z].map(|v| decimal(v, 2)).join(", ");
    let angle = with_unit(&decimal(trial.angle_error_deg, 3), "°");
    let rows = ui.vertical(|ui| {
        figure_ui(ui, "tip error x, y, z", &with_unit(&axes, "mm"), palette::TEXT);
        figure_ui(ui, "tip error", &length(trial.tip_error_mm), palette::TEXT_STRONG);
        figure_ui(ui, "angle error", &angle, palette::TEXT);
    });
    rows.response.explained(
        "Errors of this pose by the room's model alone. The design's figures are expected values, which \
         include what the measurements leave open",
    );
}

/// Sensors that are listed; a body of many would push the charts out of the panel.
const MOST_SOURCES: usize = 6;

/// What each sensor contributes to the tip error, as one paragraph: the panel is narrow, and names
/// are as long as a person made them.
fn sources_ui(ui: &mut Ui, sources: &[TrialSource]) {
    if sources.is_empty() {
        return;
    }
    let words = source_words(sources, MOST_SOURCES, "\u{2009}").join(", ");
    let text =
        RichText::new(format!("tip error from {words}")).color(palette::TEXT_QUIET.color32());
    ui.add(Label::new(text).wrap()).explained(
        "What each sensor contributes along the tip error: in first order they add up to it. A \
         negative one cancels a part of the others'",
    );
}

/// What the built tool was off there, in the same axes.
fn measured_ui(ui: &mut Ui, measured: &MeasuredError) {
    let e = measured.tip_error_in_crf_mm;
    let axes = [e.x, e.y, e.z].map(|v| decimal(v, 2)).join(", ");
    figure_ui(ui, "measured x, y, z", &with_unit(&axes, "mm"), palette::TEXT);
    figure_ui(ui, "measured tip error", &length(e.norm()), palette::MEASURED);
    if let Some(angle_deg) = measured.angle_error_deg {
        let angle = with_unit(&decimal(angle_deg, 3), "°");
        figure_ui(ui, "measured angle error", &angle, palette::TEXT);
    }
}

fn figure_ui(ui: &mut Ui, name: &str, value: &str, color: palette::Rgb) {
    ui.horizontal(|ui| {
        ui.label(RichText::new(name).color(palette::TEXT_QUIET.color32()));
        right_ui(ui, |ui| {
            ui.label(RichText::new(value).color(color.color32()));
        });
    });
}

fn right_ui(ui: &mut Ui, add: impl FnOnce(&mut Ui)) {
    ui.with_layout(Layout::right_to_left(Align::Center), add);
}

/// Three lines of a name and the two poses' values.
fn row_ui(ui: &mut Ui, names: [&str; 3], values: [[f64; 3]; 2], text: impl Fn(f64) -> String) {
    for (k, name) in names.into_iter().enumerate() {
        ui.label(RichText::new(name).color(palette::TEXT_QUIET.color32()));
        for of_pose in values {
            right_ui(ui, |ui| {
                ui.label(text(of_pose[k]));
            });
        }
        ui.end_row();
    }
}

fn degrees(pose: &Pose, form: RotationForm) -> [f64; 3] {
    match form {
        RotationForm::EulerAngles => {
            let (rx, ry, rz) = pose.rotation.euler_angles();
            [rx, ry, rz].map(f64::to_degrees)
        }
        RotationForm::Rodrigues => {
            <[f64; 3]>::from(log_quaternion(&pose.rotation)).map(f64::to_degrees)
        }
    }
}

fn quaternion(pose: &Pose) -> String {
    let [.., w, x, y, z] = pose_to_array(pose);
    let parts = [w, x, y, z].map(|v| decimal(v, 6)).join(", ");
    format!("quaternion w, x, y, z: {parts}")
}
