//! Commands of the 3D view: the camera, tools, handles, and what is done to the selected sensors.

use crate::document::requests::{EditRequest, OpenWorld, ViewRequest};
use crate::document::selection::Selection;
use crate::shell::commands::{AddCommand, Command, EDIT, Situation, VIEW, write};
use crate::shell::keys::Keys;
use crate::shell::mouse::{AddMouseActions, MouseAction};
use crate::viewport::gizmo::GizmoAxes;
use crate::viewport::nudge;
use crate::viewport::sensor_commands::{SensorCommand, selected_metal};
use crate::viewport::sensor_drag::FollowsSurface;
use crate::viewport::surfaces::Surfaces;
use crate::viewport::tool::{SceneTool, add_sensor_beside};
use crate::viewport::typed_move;
use bevy::prelude::*;
use trackwright_design::MirrorPlane;
use trackwright_geometry::orbit::{Axis, AxisEnd};

pub const ADD_SENSOR: Command = Command::new(
    EDIT,
    10,
    "Add sensor by click",
    "Puts a sensor where the next click meets a body; with Shift, one with every click",
)
.keys(&[Keys::plain("a")])
.available_if(is_edited);
pub const ADD_SENSOR_BESIDE: Command = Command::new(
    EDIT,
    11,
    "Add sensor beside the last",
    "Adds a sensor to the selected body, or the tool, beside its last one",
)
.available_if(is_edited);
pub const SET_TIP: Command = Command::new(
    EDIT,
    12,
    "Set the tip by click",
    "Puts the tip of a body where the next click meets it; near corners and shaft ends it snaps",
)
.keys(&[Keys::plain("t")])
.available_if(is_edited);
pub const FOLLOW_SURFACE: Command = Command::new(
    EDIT,
    13,
    "Drags follow the surface",
    "The axis of a dragged sensor turns with the surface, or again stays as it is",
)
.keys(&[Keys::plain("n")])
.available_if(is_edited);
const FRAME_SELECTION: Command = Command::new(
    VIEW,
    0,
    "Frame selection",
    "Moves the camera to what is selected, or to everything",
)
.keys(&[Keys::plain("f")]);
const FRAME_ALL: Command =
    Command::new(VIEW, 1, "Frame all", "Moves the camera to where it sees all that is shown")
        .keys(&[Keys::plain("home")]);

/// The views along the tracker's axes, in the order of [`AxisEnd::ALL`].
pub const LOOK_FROM: [(AxisEnd, Command); 6] = [
    (
        AxisEnd::new(Axis::X, true),
        Command::new(
            VIEW,
            2,
            "View from +X",
            "Looks along the tracker's x axis, from its positive end",
        )
        .keys(&[Keys::plain("1")]),
    ),
    (
        AxisEnd::new(Axis::X, false),
        Command::new(
            VIEW,
            3,
            "View from \u{2212}X",
            "Looks along the tracker's x axis, from its negative end",
        ),
    ),
    (
        AxisEnd::new(Axis::Y, true),
        Command::new(
            VIEW,
            4,
            "View from +Y",
            "Looks along the tracker's y axis, from its positive end",
        )
        .keys(&[Keys::plain("3")]),
    ),
    (
        AxisEnd::new(Axis::Y, false),
        Command::new(
            VIEW,
            5,
            "View from \u{2212}Y",
            "Looks along the tracker's y axis, from its negative end",
        ),
    ),
    (
        AxisEnd::new(Axis::Z, true),
        Command::new(
            VIEW,
            6,
            "View from +Z",
            "Looks along the tracker's z axis from below, where the generator is",
        ),
    ),
    (
        AxisEnd::new(Axis::Z, false),
        Command::new(
            VIEW,
            7,
            "View from \u{2212}Z",
            "Looks along the tracker's z axis from above, towards the generator",
        )
        .keys(&[Keys::plain("7")]),
    ),
];
pub const SWITCH_PROJECTION: Command = Command::new(
    VIEW,
    8,
    "Perspective or orthographic",
    "Orthographic shows everything at one scale, so that lengths across the view can be compared",
)
.keys(&[Keys::plain("5")]);
const TURN_GIZMO: Command = Command::new(
    VIEW,
    11,
    "Gizmo along the tracker's axes",
    "Handles along the tracker's axes, or again along those of what is selected",
)
.available_if(|now| now.workspace.has_gizmo);

/// What the mouse does to things in the scene.
const MOUSE: [MouseAction; 10] = [
    MouseAction::new("left click; left drag", "select; move what is under the pointer"),
    MouseAction::new("Ctrl or Shift + click on a sensor", "select it with the others, or not"),
    MouseAction::new("right click on a sensor", "what can be done to it"),
    MouseAction::new("Shift during a drag", "move finely"),
    MouseAction::new("Ctrl during a drag", "snap (handles: whole millimetres and 5°)"),
    MouseAction::new("Alt during a drag of a sensor", "leave the surface"),
    MouseAction::new(
        "Alt while the tip is set or dragged",
        "no snapping to corners and shaft ends",
    ),
    MouseAction::new("Alt while a mounting patch is painted", "erase what the brush covers"),
    MouseAction::new("Esc during a drag", "cancel it"),
    MouseAction::new("Shift + click after A", "add one sensor with every click"),
];

/// What is done to the selected sensors, in the order of menus.
pub const SENSOR_COMMANDS: [(SensorCommand, Command); 14] = [
    (
        SensorCommand::Duplicate,
        Command::new(
            EDIT,
            20,
            "Duplicate sensors",
            "Copies the selected sensors in place, to be moved from there",
        )
        .keys(&[Keys::control("d")])
        .available_if(|now| allows(now, SensorCommand::Duplicate)),
    ),
    (
        SensorCommand::Row,
        Command::new(
            EDIT,
            21,
            "Row of sensors…",
            "Makes each selected sensor the first of a row at equal distances",
        )
        .available_if(|now| allows(now, SensorCommand::Row)),
    ),
    (
        SensorCommand::Remove,
        Command::new(
            EDIT,
            22,
            "Delete sensors",
            "Takes the selected sensors off their body, which keeps one at least, or the selected metal \
             object out of the room",
        )
        .keys(&[Keys::plain("delete")])
        .labelled(|now| {
            let metal = now.world.and_then(|world| selected_metal(&world.0, now.selection));
            match metal {
                Some(_) => "Remove metal object".to_owned(),
                None => "Delete sensors".to_owned(),
            }
        })
        .available_if(|now| allows(now, SensorCommand::Remove)),
    ),
    (
        SensorCommand::Mirror(MirrorPlane::X),
        Command::new(
            EDIT,
            30,
            "Mirror sensors at x = 0",
            "Moves the selected sensors to the other side of their body's plane x = 0",
        )
        .available_if(|now| allows(now, SensorCommand::Mirror(MirrorPlane::X))),
    ),
    (
        SensorCommand::Mirror(MirrorPlane::Y),
        Command::new(
            EDIT,
            31,
            "Mirror sensors at y = 0",
            "Moves the selected sensors to the other side of their body's plane y = 0",
        )
        .available_if(|now| allows(now, SensorCommand::Mirror(MirrorPlane::Y))),
    ),
    (
        SensorCommand::Mirror(MirrorPlane::Z),
        Command::new(
            EDIT,
            32,
            "Mirror sensors at z = 0",
            "Moves the selected sensors to the other side of their body's plane z = 0",
        )
        .available_if(|now| allows(now, SensorCommand::Mirror(MirrorPlane::Z))),
    ),
    (
        SensorCommand::MirrorCopy(MirrorPlane::X),
        Command::new(
            EDIT,
            40,
            "Mirror copy at x = 0",
            "Puts copies on the other side of the body's plane x = 0",
        )
        .available_if(|now| allows(now, SensorCommand::MirrorCopy(MirrorPlane::X))),
    ),
    (
        SensorCommand::MirrorCopy(MirrorPlane::Y),
        Command::new(
            EDIT,
            41,
            "Mirror copy at y = 0",
            "Puts copies on the other side of the body's plane y = 0",
        )
        .available_if(|now| allows(now, SensorCommand::MirrorCopy(MirrorPlane::Y))),
    ),
    (
        SensorCommand::MirrorCopy(MirrorPlane::Z),
        Command::new(
            EDIT,
            42,
            "Mirror copy at z = 0",
            "Puts copies on the other side of the body's plane z = 0",
        )
        .available_if(|now| allows(now, SensorCommand::MirrorCopy(MirrorPlane::Z))),
    ),
    (
        SensorCommand::MakeFiveDof,
        Command::new(
            EDIT,
            50,
            "Make sensors 5-DOF",
            "Leaves the selected sensors their z axis, which is all that a single coil measures",
        )
        .available_if(|now| allows(now, SensorCommand::MakeFiveDof)),
    ),
    (
        SensorCommand::MakeSixDof,
        Command::new(
            EDIT,
            51,
            "Make sensors 6-DOF",
            "Gives the selected sensors a full rotation with their axis as z",
        )
        .available_if(|now| allows(now, SensorCommand::MakeSixDof)),
    ),
    (
        SensorCommand::MakeMarker,
        Command::new(
            EDIT,
            52,
            "Make sensors markers",
            "Leaves the selected sensors their positions, which is all that an optical tracker measures of a marker",
        )
        .available_if(|now| allows(now, SensorCommand::MakeMarker)),
    ),
    (
        SensorCommand::AlongNormal,
        Command::new(
            EDIT,
            53,
            "Axis along the surface normal",
            "Turns each axis out of the body, straight through its surface",
        )
        .available_if(|now| allows(now, SensorCommand::AlongNormal)),
    ),
    (
        SensorCommand::AlongShaft,
        Command::new(
            EDIT,
            54,
            "Axis along the shaft",
            "Turns each axis along the surface, in the direction in which the body is longest",
        )
        .available_if(|now| allows(now, SensorCommand::AlongShaft)),
    ),
];

impl SensorCommand {
    /// What is known of it as a command.
    pub fn command(self) -> &'static Command {
        let own = SENSOR_COMMANDS.iter().find(|(own, _)| *own == self);
        &own.unwrap_or(&SENSOR_COMMANDS[0]).1
    }
}

/// Registers the commands. That of a row belongs to its page.
pub struct ViewportCommandsPlugin;

impl Plugin for ViewportCommandsPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins((nudge::plugin, typed_move::plugin));
        app.add_mouse_actions(&MOUSE)
            .add_command(ADD_SENSOR, take(SceneTool::AddSensor))
            .add_command(ADD_SENSOR_BESIDE, add_beside)
            .add_command(SET_TIP, take(SceneTool::SetTip))
            .add_command(FOLLOW_SURFACE, |follows: Option<ResMut<FollowsSurface>>| {
                if let Some(mut follows) = follows {
                    follows.0 = !follows.0;
                }
            })
            .add_command(FRAME_SELECTION, write(ViewRequest::FrameSelection))
            .add_command(FRAME_ALL, write(ViewRequest::FrameAll))
            .add_command(SWITCH_PROJECTION, write(ViewRequest::SwitchProjection))
            .add_command(TURN_GIZMO, |mut axes: ResMut<GizmoAxes>| axes.0 = axes.0.other());
        for (end, command) in LOOK_FROM {
            app.add_command(command, write(ViewRequest::LookFrom(end)));
        }
        for (own, command) in SENSOR_COMMANDS {
            if own != SensorCommand::Row {
                app.add_command(command, change_sensors(own));
            }
        }
    }
}

fn is_edited(now: &Situation) -> bool {
    now.world.is_some() && now.workspace.edits_design
}

fn allows(now: &Situation, command: SensorCommand) -> bool {
    now.world.is_some_and(|world| command.is_available(&world.0, now.selection))
}

/// A tool taken in hand, or put back.
fn take(tool: SceneTool) -> impl FnMut(ResMut<SceneTool>) {
    move |mut own: ResMut<SceneTool>| *own = own.toggled(tool)
}

fn add_beside(
    world: Option<Res<OpenWorld>>,
    selection: Res<Selection>,
    mut edits: MessageWriter<EditRequest>,
) {
    let design = world.as_ref().map(|world| world.0.document.design());
    let edit = design.and_then(|design| add_sensor_beside(design, &selection));
    edits.write_batch(edit.map(EditRequest::Apply));
}

#[expect(clippy::type_complexity, reason = "the parameters of a system")]
fn change_sensors(
    command: SensorCommand,
) -> impl FnMut(Option<Res<OpenWorld>>, Res<Selection>, Option<Res<Surfaces>>, MessageWriter<EditRequest>)
{
    move |world: Option<Res<OpenWorld>>,
          selection: Res<Selection>,
          surfaces: Option<Res<Surfaces>>,
          mut edits: MessageWriter<EditRequest>| {
        let Some(world) = world else { return };
        let body = selection.sensors().map(|(body, _)| body);
        let surfaces = surfaces.as_ref().zip(body);
        let surface = surfaces.and_then(|(surfaces, body)| surfaces.of(body));
        edits.write_batch(command.requests(&world.0, &selection, surface.map(|s| &**s)));
    }
}
