//! The Design workspace as the shell registers it.

use crate::shell::keys::Keys;
use crate::shell::window::Workspace;

pub const WORKSPACE: Workspace = Workspace {
    name: "Design",
    order: 0,
    command: "Design workspace",
    about: "Bodies, sensors and the result",
    keys: &[Keys::control("1")],
    ..Workspace::NONE
};
