//! Where on the selected anatomy the CRF may stand: the tools that paint the patch in the scene.

use crate::viewport::mounting::state::MountingState;
use crate::viewport::tool::SceneTool;
use crate::widgets::basic::{counted, quiet_ui, section_ui, warning_ui};
use crate::widgets::tooltip::{button_ui, checkbox_ui};
use crate::workspaces::design::actions::{DesignAction, MountingAction};
use crate::workspaces::design::mounting_ui::{PATCH_TOOLS, brush_ui, tools_ui};
use bevy_egui::egui::Ui;
use trackwright_design::{Anatomy, AnatomyEdit, Edit};

/// What the section shows.
pub struct CrfPatchView<'a> {
    /// In the design's list.
    pub index: usize,
    pub anatomy: &'a Anatomy,
    pub has_mesh: bool,
    pub state: MountingState,
    /// In hand.
    pub tool: SceneTool,
}

/// Draws the section.
pub fn crf_patch_ui(ui: &mut Ui, view: &CrfPatchView) -> Vec<DesignAction> {
    let mut actions = Vec::new();
    section_ui(ui, "CRF patch");
    let mut is_open = view.state.is_open;
    let about = "Shows where on this anatomy the CRF may stand, to be painted in the scene";
    if checkbox_ui(ui, &mut is_open, "edit patch", about).changed() {
        let state = MountingState { is_open, ..view.state };
        actions.push(DesignAction::Mounting(MountingAction::Set(state)));
    }
    let boxes = view.anatomy.crf_patch.len();
    quiet_ui(
        ui,
        match boxes {
            0 => "No patch: better places of the CRF are searched within its bounds".to_owned(),
            boxes => format!("The surface in {}", counted(boxes, "box", "boxes")),
        },
    );
    if !is_open {
        return actions;
    }
    tools_ui(ui, PATCH_TOOLS, view.tool, view.has_mesh, &mut actions);
    if !view.has_mesh {
        warning_ui(ui, "The anatomy has no mesh to draw on");
    }
    brush_ui(ui, view.state, &mut actions);
    let about = "Takes the whole patch away";
    if boxes > 0 && button_ui(ui, "Remove patch", about).clicked() {
        let edit = AnatomyEdit::SetCrfPatch { index: view.index, boxes: Vec::new() };
        actions.push(DesignAction::apply(Edit::Anatomy(edit)));
    }
    actions
}
