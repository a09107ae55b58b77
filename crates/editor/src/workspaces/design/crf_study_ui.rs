//! The CRF's own study: the places that matter on the patient, where it is judged, and its
//! requirement there.

use crate::widgets::basic::{quiet_ui, section_ui};
use crate::widgets::tooltip::{Explain, button_ui};
use crate::workspaces::design::actions::DesignAction;
use crate::workspaces::design::motion_ui::{MotionOf, motion_ui, requirement_ui};
use crate::workspaces::design::rows::{text_row_ui, vector_ui};
use bevy_egui::egui::Ui;
use nalgebra::Point3;
use trackwright_design::{BodyRole, CrfPlacement, Edit, Target};
use trackwright_formats::printable::printable;

/// Draws the targets, the bounds and the motion of the CRF alone.
pub fn crf_study_ui(ui: &mut Ui, crf: &CrfPlacement, actions: &mut Vec<DesignAction>) {
    section_ui(ui, "Targets");
    if crf.targets.is_empty() {
        quiet_ui(ui, "None: the CRF alone is judged at its tip or origin");
    }
    for (index, target) in crf.targets.iter().enumerate() {
        ui.push_id(("target", index), |ui| {
            target_ui(ui, index, target, actions);
        });
    }
    if ui
        .button("Add target")
        .explained("A place on the patient, fixed to the CRF, where its error is judged")
        .clicked()
    {
        actions.push(DesignAction::apply(Edit::AddTarget(new_target(crf))));
    }
    actions.extend(requirement_ui(ui, BodyRole::Crf, crf.requirement.as_ref()));
    let of = MotionOf { role: BodyRole::Crf, body: &crf.body.rigid, reference_word: "tracker" };
    actions.extend(motion_ui(ui, &of, crf.motion.as_ref()));
}

fn target_ui(ui: &mut Ui, index: usize, target: &Target, actions: &mut Vec<DesignAction>) {
    let set = |target: Target| Edit::SetTarget { index, target };
    if let Some(name) = text_row_ui(ui, "name", &target.name) {
        let renamed = Target { name, ..target.clone() };
        actions.push(DesignAction::apply(set(renamed)));
    }
    let label = format!("Move target {}", target.name);
    let at = &target.position_in_crf.coords;
    vector_ui(ui, &target.name, at, actions, &label, |v| {
        Some(set(Target { position_in_crf: v.into(), ..target.clone() }))
    });
    let remove = format!("Remove {}", printable(&target.name));
    if button_ui(ui, &remove, "Takes the target out of the design").clicked() {
        actions.push(DesignAction::apply(Edit::RemoveTarget { index }));
    }
    ui.add_space(4.0);
}

/// At the CRF's origin, under a name that no other has.
fn new_target(crf: &CrfPlacement) -> Target {
    let is_free = |name: &String| crf.targets.iter().all(|target| target.name != *name);
    let mut names = (1..).map(|number| format!("target {number}"));
    Target { name: names.find(is_free).unwrap_or_default(), position_in_crf: Point3::origin() }
}
