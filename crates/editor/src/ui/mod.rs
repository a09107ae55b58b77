//! The panels around the 3D view. Each panel is a pure function from a view of the state to
//! what the person asked for; `layout` alone knows Bevy.

pub mod anatomy_ui;
mod asked;
pub mod baseline;
pub mod body_file_ui;
pub mod chart_ui;
pub mod command_ui;
pub mod crf_study_ui;
pub mod decide;
pub mod dialogs;
pub mod drop_plate;
pub mod few_marks;
pub mod field;
pub mod folder;
pub mod history_ui;
pub mod inspector;
pub mod layer_settings;
pub mod layers_ui;
mod layout;
pub mod live;
pub mod mesh_ui;
pub mod motion_ui;
pub mod outliner;
pub mod precision_ui;
pub mod present;
pub mod result;
pub mod row_page;
pub mod scene_menu;
pub mod sensor_ui;
pub mod slice_ui;
pub mod status_bar;
pub mod study_charts_ui;
pub mod study_panels;
pub mod switch;
pub mod theme;
pub mod timeline_ui;
pub mod top_bar;
pub mod trial_ui;
pub(super) mod verdict;
pub mod widgets;
mod windows;
mod workspaces;

pub use layout::{PanelsShown, UiPlugin, UiSystems};

use super::body_files::BodyFileRequest;
use super::commands::Command;
use super::decide::DecideRequest;
use super::field::FieldRequest;
use super::live::LiveRequest;
use super::meshes::MeshRequest;
use super::present::PresentRequest;
use super::state::{EditRequest, FileRequest, Selected, ViewRequest};
use super::study::StudyRequest;
use trackwright_design::Edit;
use widgets::NumberChange;

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
fn number_edits(
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
