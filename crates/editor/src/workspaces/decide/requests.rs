//! The Decide workspace as the shell registers it, and the requests to it.

use crate::shell::keys::Keys;
use crate::shell::window::Workspace;
use crate::widgets::theme;
use crate::workspaces::decide::table::AddedDesign;
use bevy::prelude::*;
use std::path::PathBuf;
use trackwright_calibration::agreement::BuiltRecording;
use trackwright_design::BodyRole;
use trackwright_procedure::Step;
use trackwright_project::RoomSource;

pub const WORKSPACE: Workspace = Workspace {
    name: "Decide",
    order: 4,
    command: "Decide workspace",
    about: "The design beside a baseline, and designs and rooms in one table",
    keys: &[Keys::control("5")],
    has_gizmo: false,
    shows_baseline: true,
    side_widths: [theme::RIGHT_WIDTH, theme::FIELD_WIDTH],
    ..Workspace::NONE
};

/// A request to the workspace.
#[derive(Message, Clone, Debug, PartialEq)]
pub enum DecideRequest {
    /// Holds the design against what it is now.
    PinHere,
    /// Shows the dialog that chooses a design to be held against.
    ShowPin,
    Pin(PathBuf),
    Unpin,
    /// Shows the dialog that chooses designs for the table.
    ShowAddDesign,
    AddDesign(PathBuf),
    AddDesigns(Vec<PathBuf>),
    AddBuiltIn(&'static str),
    RemoveDesign(AddedDesign),
    /// Judges the design in a further room, which is kept in the design.
    AddRoom(RoomSource),
    /// By how the design refers to it.
    RemoveRoom(String),
    /// Shows the dialog that chooses a recording of the built tool, or of its CRF beside it.
    ShowRecorded(BodyRole),
    Recorded(BodyRole, PathBuf),
    /// How the recording is to be taken.
    SetRecorded(BuiltRecording),
    CloseRecorded,
    /// Shows the recording pose by pose in the Study workspace.
    ShowPoses,
    /// What is typed as the reason of a decision.
    SetNote(Step, String),
    Decide(Step),
    Withdraw(Step),
    Compare,
    CancelCompare,
    /// Opens what a row of the table is of.
    OpenRow(usize),
    /// All figures of the difference, or those that a requirement can be about.
    ShowAllFigures(bool),
}

/// What the person is at, as a run condition.
pub fn is_shown(workspace: Res<Workspace>) -> bool {
    *workspace == WORKSPACE
}
