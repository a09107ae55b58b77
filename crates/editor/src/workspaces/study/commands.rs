//! Commands of the Study workspace.

use crate::document::requests::FileRequest;
use crate::document::trials::ModeKind;
use crate::shell::commands::{AddCommand, Command, Group, write};
use crate::shell::keys::Keys;
use crate::workspaces::study::state::StudyRequest;
use crate::workspaces::study::state::WORKSPACE;
use bevy::prelude::*;

const STUDY: Group = Group { order: 3, name: "Study", workspace: Some(WORKSPACE.name) };

/// Of the modes, in the order of [`ModeKind::ALL`].
const MODES: [Command; 3] = [
    Command::new(STUDY, 100, "Single pose", "Studies the design's own pose alone"),
    Command::new(
        STUDY,
        101,
        "Range of motion",
        "Studies every pose of the design's range of motion",
    ),
    Command::new(STUDY, 102, "Input data", "Studies the poses of a table that was read"),
];
pub const READ_INPUT: Command = Command::new(
    STUDY,
    103,
    "Read input data…",
    "Reads a table of poses (CSV); one can also be dropped onto the window",
);
pub const PLAY: Command = Command::new(
    STUDY,
    104,
    "Play or pause",
    "Moves the tool through the trials, one after the other",
)
.keys(&[Keys::plain("space")]);
pub const PREVIOUS: Command =
    Command::new(STUDY, 105, "Previous trial", "Shows the tool one trial earlier")
        .keys(&[Keys::plain("left")]);
pub const NEXT: Command = Command::new(STUDY, 106, "Next trial", "Shows the tool one trial later")
    .keys(&[Keys::plain("right")]);
pub const WORST: Command = Command::new(
    STUDY,
    107,
    "Worst trial",
    "Shows the tool in the trial with the largest tip error",
)
.keys(&[Keys::plain("w")]);
pub const OWN_POSE: Command =
    Command::new(STUDY, 108, "The design's own pose", "Puts the tool back where the design has it")
        .keys(&[Keys::plain("home")]);
pub const WRITE_LOG: Command = Command::new(
    STUDY,
    109,
    "Save all trials…",
    "Writes every trial's poses and errors to a table (CSV)",
);

/// The command that chooses a mode.
pub fn choose(kind: ModeKind) -> &'static Command {
    match kind {
        ModeKind::Single => &MODES[0],
        ModeKind::Motion => &MODES[1],
        ModeKind::Input => &MODES[2],
    }
}

pub(crate) fn plugin(app: &mut App) {
    for kind in ModeKind::ALL {
        app.add_command(*choose(kind), write(StudyRequest::Choose(kind)));
    }
    app.add_command(READ_INPUT, write(FileRequest::ShowReadInput))
        .add_command(PLAY, write(StudyRequest::TogglePlay))
        .add_command(NEXT, write(StudyRequest::Step(1)))
        .add_command(PREVIOUS, write(StudyRequest::Step(-1)))
        .add_command(WORST, write(StudyRequest::ShowWorst))
        .add_command(OWN_POSE, write(StudyRequest::Show(None)))
        .add_command(WRITE_LOG, write(FileRequest::ShowWriteLog));
}
