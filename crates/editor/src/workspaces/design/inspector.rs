//! Numbers of what is selected, each of which can be typed.

use crate::document::selection::{Selected, Selection};
use crate::viewport::coil_fit::ShownFindings;
use crate::viewport::troubles::{detail, determination_text, sensor_trouble};
use crate::widgets::basic::{NumberField, length, number_ui, quiet_ui, section_ui, warning_ui};
use crate::widgets::tooltip::Explain;
use crate::workspaces::design::actions::{DesignAction, number_edits};
use crate::workspaces::design::anatomy_ui::anatomy_ui;
use crate::workspaces::design::chosen_sensors::ChosenSensors;
use crate::workspaces::design::crf_study_ui::crf_study_ui;
use crate::workspaces::design::metal_ui::metal_ui;
use crate::workspaces::design::motion_ui::{MotionOf, motion_ui, requirement_ui};
use crate::workspaces::design::rows::{right_ui, rotation_ui, row_ui, text_row_ui, vector_ui};
use crate::workspaces::design::sensor_numbers::sensor_numbers_ui;
use crate::workspaces::design::sensor_ui::{IsAvailable, sensor_buttons_ui};
use bevy_egui::egui::Ui;
use nalgebra::Point3;
use trackwright_design::{BodyRole, Design, DesignBody, Edit};
use trackwright_field::environment::{OrientationWeight, OrientationWeightSource};
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_simulation::figures::capitalised;
use trackwright_simulation::{BodyDetail, PoseDetail};

/// What the inspector shows.
pub struct InspectorView<'a> {
    pub design: &'a Design,
    pub selection: &'a Selection,
    pub is_available: IsAvailable<'a>,
    pub pose: Option<&'a PoseDetail>,
    /// Coils that do not fit.
    pub coils: ShownFindings<'a>,
    /// The weight that counts where the design states none.
    pub derived_weight: OrientationWeight,
}

/// Draws what is selected, or the design where nothing is.
pub fn inspector_ui(ui: &mut Ui, inspector: &InspectorView) -> Vec<DesignAction> {
    let mut actions = Vec::new();
    match inspector.selection.primary() {
        None => design_ui(ui, inspector, &mut actions),
        Some(Selected::Body(role)) => body_ui(ui, inspector, role, &mut actions),
        Some(Selected::Sensor(role, index)) => sensor_ui(ui, inspector, role, index, &mut actions),
        Some(Selected::Tip(role)) => tip_ui(ui, inspector.design, role, &mut actions),
        Some(Selected::Anatomy(index)) => {
            anatomy_ui(ui, inspector.design, index, &mut actions);
        }
        Some(Selected::Metal(index)) => metal_ui(ui, inspector.design, index, &mut actions),
    }
    actions
}

fn design_ui(ui: &mut Ui, inspector: &InspectorView, actions: &mut Vec<DesignAction>) {
    let design = inspector.design;
    section_ui(ui, "Design");
    if let Some(name) = text_row_ui(ui, "name", &design.name) {
        actions.push(DesignAction::apply(Edit::SetName(name)));
    }
    weight_ui(ui, inspector, actions);
    actions.extend(requirement_ui(ui, BodyRole::Tool, design.requirement.as_ref()));
    let tool = MotionOf {
        role: BodyRole::Tool,
        body: &design.tool.body.rigid,
        reference_word: if design.crf.is_some() { "CRF" } else { "tracker" },
    };
    actions.extend(motion_ui(ui, &tool, design.motion.as_ref()));
}

fn weight_ui(ui: &mut Ui, inspector: &InspectorView, actions: &mut Vec<DesignAction>) {
    let weight_mm = inspector.design.orientation_weight_mm;
    ui.horizontal(|ui| {
        let mut is_set = weight_mm.is_some();
        let box_ = ui
            .checkbox(&mut is_set, "orientation weight")
            .explained("How much an axis counts against a position in frame fitting");
        if box_.changed() {
            let weight = is_set.then_some(inspector.derived_weight.value_mm);
            actions.push(DesignAction::apply(Edit::SetOrientationWeight(weight)));
        }
        match weight_mm {
            Some(weight_mm) => {
                let field = NumberField::length("orientation weight in mm")
                    .about("What an axis counts against a position in frame fitting")
                    .positive();
                let changes = right_ui(ui, |ui| number_ui(ui, &field, weight_mm));
                number_edits(&changes, actions, "Change orientation weight", |v| {
                    Some(Edit::SetOrientationWeight(Some(v)))
                });
            }
            None => {
                let derived_mm = inspector.derived_weight.value_mm;
                right_ui(ui, |ui| quiet_ui(ui, length(derived_mm)));
            }
        }
    });
    if weight_mm.is_none() {
        quiet_ui(ui, weight_source(inspector.derived_weight.source));
    }
}

/// Where the weight comes from that counts while the design states none.
fn weight_source(source: OrientationWeightSource) -> &'static str {
    match source {
        OrientationWeightSource::Jitter => {
            "derived from the room's jitter, position by orientation"
        }
        OrientationWeightSource::Default | OrientationWeightSource::Design => {
            "the default: the room states no jitter"
        }
    }
}

fn body_ui(
    ui: &mut Ui,
    inspector: &InspectorView,
    role: BodyRole,
    actions: &mut Vec<DesignAction>,
) {
    let design = inspector.design;
    let Some(body) = design.body(role) else {
        return;
    };
    section_ui(ui, &body.rigid.name);
    if let Some(name) = text_row_ui(ui, "name", &body.rigid.name) {
        actions.push(DesignAction::apply(Edit::SetBodyName { body: role, name }));
    }
    quiet_ui(ui, &body.reference);
    let (title, pose) = match (role, &design.crf) {
        (BodyRole::Crf, Some(crf)) => ("Pose in the tracker frame", crf.tracker_from_crf),
        (_, None) => ("Pose in the tracker frame", design.tool.crf_from_tool),
        (_, Some(_)) => ("Pose in the CRF", design.tool.crf_from_tool),
    };
    section_ui(ui, title);
    pose_ui(ui, role, &pose, actions);
    tip_of_body_ui(ui, role, body, actions);
    if let Some(detail) = detail(inspector.pose, role) {
        determination_ui(ui, detail);
    }
    if let (BodyRole::Crf, Some(crf)) = (role, &design.crf) {
        crf_study_ui(ui, crf, actions);
    }
}

fn pose_ui(ui: &mut Ui, role: BodyRole, pose: &Pose, actions: &mut Vec<DesignAction>) {
    let label = format!("Move {}", role.name());
    let edit = |pose: Pose| match role {
        BodyRole::Tool => Edit::SetToolPose(pose),
        BodyRole::Crf => Edit::SetCrfPose(pose),
    };
    vector_ui(ui, "position", &pose.translation.vector, actions, &label, |v| {
        Some(edit(pose_from_parts(v, pose.rotation)))
    });
    rotation_ui(ui, &pose.rotation, actions, &label, |rotation| {
        edit(pose_from_parts(pose.translation.vector, rotation))
    });
}

fn tip_of_body_ui(ui: &mut Ui, role: BodyRole, body: &DesignBody, actions: &mut Vec<DesignAction>) {
    section_ui(ui, "Tip");
    let mut has_tip = body.rigid.tip_in_body.is_some();
    if ui
        .checkbox(&mut has_tip, "judged at a tip")
        .explained("Without a tip the body is judged at its origin")
        .changed()
    {
        actions.push(DesignAction::apply(Edit::SetTip {
            body: role,
            tip_in_body: has_tip.then(Point3::origin),
        }));
    }
    if let Some(tip) = &body.rigid.tip_in_body {
        tip_fields_ui(ui, role, tip, actions);
    }
}

fn tip_ui(ui: &mut Ui, design: &Design, role: BodyRole, actions: &mut Vec<DesignAction>) {
    let Some(body) = design.body(role) else {
        return;
    };
    section_ui(ui, &format!("Tip of the {}", role.name()));
    if let Some(tip) = &body.rigid.tip_in_body {
        tip_fields_ui(ui, role, tip, actions);
    }
}

fn tip_fields_ui(
    ui: &mut Ui,
    role: BodyRole,
    tip_in_body: &Point3<f64>,
    actions: &mut Vec<DesignAction>,
) {
    let label = format!("Move {} tip", role.name());
    vector_ui(ui, "position", &tip_in_body.coords, actions, &label, |v| {
        Some(Edit::SetTip { body: role, tip_in_body: Some(v.into()) })
    });
}

fn sensor_ui(
    ui: &mut Ui,
    inspector: &InspectorView,
    role: BodyRole,
    index: usize,
    actions: &mut Vec<DesignAction>,
) {
    let selected = inspector.selection.sensors();
    let indices = selected.map_or_else(|| vec![index], |(_, indices)| indices);
    let Some(chosen) = ChosenSensors::new(inspector.design, role, &indices) else {
        return;
    };
    sensor_numbers_ui(ui, role, &chosen, actions);
    for finding in indices.iter().flat_map(|index| inspector.coils.of(role, *index)) {
        warning_ui(ui, &capitalised(&finding.statement()));
    }
    if chosen.single().is_some()
        && let Some(detail) = detail(inspector.pose, role)
    {
        reading_ui(ui, detail, index);
    }
    sensor_buttons_ui(ui, inspector.is_available, actions);
}

/// What the tracker makes of a sensor at the design's own pose.
fn reading_ui(ui: &mut Ui, detail: &BodyDetail, index: usize) {
    let Some(sensor) = detail.sensors.get(index) else {
        return;
    };
    section_ui(ui, "At this pose");
    row_ui(ui, "position error", |ui| {
        ui.label(length(sensor.error.position_mm.norm()));
    });
    if let Some(trouble) = sensor_trouble(detail, index) {
        let text = match sensor.is_in_volume {
            true => format!("The sensor is {trouble} of measured samples: a guess"),
            false => format!("The sensor is {trouble}: the tracker does not see it"),
        };
        warning_ui(ui, &text);
    }
}

fn determination_ui(ui: &mut Ui, detail: &BodyDetail) {
    if let Some(text) = determination_text(detail) {
        ui.add_space(6.0);
        warning_ui(ui, &text);
    }
}
