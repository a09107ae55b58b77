//! Arrow keys move the selected sensors along that axis of their body which points most in the arrow's
//! direction on the screen.

use crate::document::requests::{EditRequest, OpenWorld};
use crate::document::selection::Selection;
use crate::shell::commands::{AddCommand, Command, EDIT, Situation};
use crate::shell::keys::Keys;
use crate::viewport::camera::OrbitRig;
use crate::widgets::basic::counted;
use bevy::prelude::*;
use nalgebra::Vector3;

const STEP_MM: f64 = 1.0;
const FINE_STEP_MM: f64 = 0.1;

/// An arrow: to the right and up on the screen, how far, and its command.
type Nudge = ([f64; 2], f64, Command);

pub const NUDGES: [Nudge; 8] = [
    nudge(
        120,
        [1.0, 0.0],
        STEP_MM,
        "Nudge sensors right",
        "Moves the selected sensors by 1 mm along the axis of their body that points right",
        &[Keys::plain("right")],
    ),
    nudge(
        121,
        [-1.0, 0.0],
        STEP_MM,
        "Nudge sensors left",
        "Moves the selected sensors by 1 mm along the axis of their body that points left",
        &[Keys::plain("left")],
    ),
    nudge(
        122,
        [0.0, 1.0],
        STEP_MM,
        "Nudge sensors up",
        "Moves the selected sensors by 1 mm along the axis of their body that points up",
        &[Keys::plain("up")],
    ),
    nudge(
        123,
        [0.0, -1.0],
        STEP_MM,
        "Nudge sensors down",
        "Moves the selected sensors by 1 mm along the axis of their body that points down",
        &[Keys::plain("down")],
    ),
    nudge(
        124,
        [1.0, 0.0],
        FINE_STEP_MM,
        "Nudge sensors right finely",
        "Moves the selected sensors by 0.1 mm along the axis of their body that points right",
        &[Keys::shift("right")],
    ),
    nudge(
        125,
        [-1.0, 0.0],
        FINE_STEP_MM,
        "Nudge sensors left finely",
        "Moves the selected sensors by 0.1 mm along the axis of their body that points left",
        &[Keys::shift("left")],
    ),
    nudge(
        126,
        [0.0, 1.0],
        FINE_STEP_MM,
        "Nudge sensors up finely",
        "Moves the selected sensors by 0.1 mm along the axis of their body that points up",
        &[Keys::shift("up")],
    ),
    nudge(
        127,
        [0.0, -1.0],
        FINE_STEP_MM,
        "Nudge sensors down finely",
        "Moves the selected sensors by 0.1 mm along the axis of their body that points down",
        &[Keys::shift("down")],
    ),
];

const fn nudge(
    order: u16,
    on_screen: [f64; 2],
    step_mm: f64,
    name: &'static str,
    about: &'static str,
    keys: &'static [Keys],
) -> Nudge {
    let command = Command::new(EDIT, order, name, about).keys(keys).available_if(is_available);
    (on_screen, step_mm, command)
}

pub(super) fn plugin(app: &mut App) {
    for (on_screen, step_mm, command) in NUDGES {
        let run = move |world: Option<Res<OpenWorld>>,
                        (selection, rig): (Res<Selection>, Option<Res<OrbitRig>>),
                        mut edits: MessageWriter<EditRequest>| {
            let (Some(world), Some(rig)) = (world, rig) else { return };
            let camera = rig.camera.tracker_from_camera().rotation;
            let in_tracker = camera * Vector3::new(on_screen[0], on_screen[1], 0.0);
            let Some((role, indices)) = selection.sensors() else { return };
            let design = world.0.document.design();
            let label = format!("Move {}", counted(indices.len(), "sensor", "sensors"));
            let moved = design.nudged_sensors(role, &indices, &in_tracker, step_mm);
            edits.write_batch(EditRequest::step(label, moved));
        };
        app.add_command(command, run);
    }
}

/// Whether sensors are selected that may be moved.
fn is_available(now: &Situation) -> bool {
    now.world.is_some() && now.workspace.edits_design && now.selection.sensors().is_some()
}
