//! The Live workspace as the shell registers it, and the requests to it.

use crate::shell::keys::Keys;
use crate::shell::window::Workspace;
use bevy::prelude::*;
use std::path::PathBuf;
use trackwright_design::BodyRole;

pub const WORKSPACE: Workspace = Workspace {
    name: "Live",
    order: 3,
    command: "Live workspace",
    about: "A tracker over the network: its tools, a recording, where samples are missing",
    keys: &[Keys::control("4")],
    shows_live: true,
    ..Workspace::VIEWED
};

/// A request to the workspace.
#[derive(Message, Clone, Debug, PartialEq)]
pub enum LiveRequest {
    /// `HOST:PORT` of the tracker's server.
    SetServer(String),
    /// The port that poses are sent on at; `None` sends none on.
    SetPort(Option<u16>),
    Connect,
    Disconnect,
    /// Which body a tool is, none of them, or (`None`) the body with its name.
    Assign(String, Option<Option<BodyRole>>),
    /// Shows the dialog that chooses where the recording goes.
    ShowRecord,
    Record(PathBuf),
    StopRecording,
    /// Forgets where samples were taken.
    StartOver,
}

/// What the person is at, as a run condition.
pub fn is_shown(workspace: Res<Workspace>) -> bool {
    *workspace == WORKSPACE
}
