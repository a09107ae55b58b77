//! The panels around the 3D view. Each panel is a pure function from a view of the state to
//! what the person asked for; `layout` alone knows Bevy.

pub mod command_palette;
pub mod command_table;
pub mod commands;
pub mod dialogs;
pub mod drop_plate;
pub mod keys;
pub mod layout;
pub mod preferences;
pub mod requests;
pub mod shortcuts;
pub mod status_bar;
pub mod system_dialog;
pub mod top_bar;
pub mod window;
pub mod windows;
pub mod workspaces;

use crate::document::body_files::BodyFileRequest;
use crate::document::meshes::MeshRequest;
use crate::document::requests::{EditRequest, FileRequest, ViewRequest};
use crate::document::selection::Selected;
use crate::shell::commands::Command;
use crate::widgets::basic::NumberChange;
use crate::workspaces::decide::DecideRequest;
use crate::workspaces::field::FieldRequest;
use crate::workspaces::live::LiveRequest;
use crate::workspaces::present::PresentRequest;
use crate::workspaces::study::desk::StudyRequest;
use trackwright_design::Edit;

/// What a person asked a panel for.
#[derive(Clone, Debug, PartialEq)]
pub enum PanelAction {
    Edit(EditRequest),
    View(ViewRequest),
    File(FileRequest),
    Field(FieldRequest),
    Mesh(MeshRequest),
    Live(LiveRequest),
    BodyFile(BodyFileRequest),
    Run(Command),
    Study(StudyRequest),
    Present(PresentRequest),
    Decide(DecideRequest),
    Select(Option<Selected>),
    /// Selects it with what is selected, or takes it away.
    SelectAlso(Selected),
    Hover(Selected),
}

impl PanelAction {
    /// One edit that is one undo step.
    pub fn apply(edit: Edit) -> Self {
        Self::Edit(EditRequest::Apply(edit))
    }
}

/// Turns what a number field reported into requests; `edit` makes the edit of a value.
pub(crate) fn number_edits(
    changes: &[NumberChange],
    actions: &mut Vec<PanelAction>,
    label: &str,
    edit: impl Fn(f64) -> Option<Edit>,
) {
    for change in changes {
        match change {
            NumberChange::Begin => {
                actions.push(PanelAction::Edit(EditRequest::Begin(label.to_owned())));
            }
            NumberChange::Set(value) => actions.extend(edit(*value).map(PanelAction::apply)),
            NumberChange::Commit => actions.push(PanelAction::Edit(EditRequest::Commit)),
        }
    }
}
