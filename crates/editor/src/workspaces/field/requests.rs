//! The Field workspace as the shell registers it, and the requests to it.

use crate::shell::keys::Keys;
use crate::shell::window::Workspace;
use crate::widgets::theme;
use crate::workspaces::field::metal::GeneratorSource;
use crate::workspaces::field::state::{FieldSettings, SamplesShown, TableRole};
use bevy::prelude::*;
use std::path::PathBuf;
use trackwright_project::RoomSource;

pub const WORKSPACE: Workspace = Workspace {
    name: "Field",
    order: 1,
    command: "Field workspace",
    about: "The room: its measurements, their fit, and its quality",
    keys: &[Keys::control("2")],
    shows_samples: true,
    drop_verb: Some("Read measurements from"),
    side_widths: [theme::LEFT_WIDTH, theme::FIELD_WIDTH],
    ..Workspace::VIEWED
};

/// A request to the workspace.
#[derive(Message, Clone, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "one is written a click")]
pub enum FieldRequest {
    /// Shows the dialog that chooses a table.
    ShowOpen(TableRole),
    Open(TableRole, PathBuf),
    /// A file was dropped: the first table, or whichever the person chooses.
    Drop(PathBuf),
    /// Puts a table away, or gives its reading up.
    Close(TableRole),
    /// Takes a table that is suspected of being another one as it stands, or no longer.
    TakeAsIs(PathBuf, bool),
    Set(FieldSettings),
    Show(SamplesShown),
    Fit,
    CancelFit,
    /// Shows or hides the window with Fig. 3 and its table.
    ShowSelection(bool),
    /// Computes the design's figures in the fitted room, without changing the design.
    Try,
    CancelTry,
    /// Shows the dialog that chooses a file of a field generator.
    ShowOpenGenerator,
    /// Chooses the generator that the search for metal takes.
    UseGenerator(GeneratorSource),
    /// Looks for the metal that disturbs the measurements.
    FindMetal,
    /// Compares the metal that was found with other models of the same measurements.
    CompareMetal,
    /// Stops looking, or comparing.
    CancelMetal,
    /// Shows the dialog that chooses where a room is saved.
    ShowSave(RoomToSave),
    /// Saves a room and assigns it to the design.
    Save(RoomToSave, PathBuf),
    /// Puts the design into a room, as one undo step.
    Assign(RoomSource),
}

/// A room that is no file of its own yet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RoomToSave {
    /// The newest fit.
    Fitted,
    /// The metal that was found.
    Metal,
}

/// What the person is at, as a run condition.
pub fn is_shown(workspace: Res<Workspace>) -> bool {
    *workspace == WORKSPACE
}
