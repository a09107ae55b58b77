//! Everything that can be asked for by name: one table for menus, keys, the palette and the sheet
//! of shortcuts, and the one place that carries commands out.

use super::field::{FieldRequest, RoomToSave, TableRole};
pub use super::keys::Keys;
use super::palette::Theme;
use super::pick::Surfaces;
use super::precision::PrecisionRequest;
use super::sensor_commands::SensorCommand;
use super::state::{
    ActiveDrag, EditRequest, EditorSystems, FileRequest, OpenWorld, Selection, ViewRequest,
    Workspace,
};
use super::study::{ModeKind, StudyRequest};
use super::ui::PanelsShown;
use super::ui::command_ui::CommandPages;
use super::ui::row_page::RowPage;
use crate::design::MirrorPlane;
use crate::design::view::{Magnification, View};
use crate::geometry::orbit::Axis;
use bevy::prelude::*;
use bevy::window::RequestRedraw;

/// Carries [`RunCommand`] out, in [`EditorSystems::Input`].
pub struct CommandsPlugin;

/// When commands are carried out.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct CommandsSystems;

/// Asks for a command.
#[derive(Message, Clone, Copy, Debug, PartialEq, Eq)]
pub struct RunCommand(pub Command);

/// What can be asked for by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Command {
    Open,
    Save,
    SaveAs,
    Quit,
    Undo,
    Redo,
    /// Takes the drag back that is under way.
    CancelDrag,
    /// Something done to the selected sensors.
    Sensors(SensorCommand),
    FrameSelection,
    LookAlong(Axis),
    ToggleMagnification,
    ToggleLeft,
    ToggleRight,
    ToggleHistory,
    ToggleTheme,
    OpenMeasurements(TableRole),
    FitRoom,
    UseRoom,
    ShowWorkspace(Workspace),
    ChooseMode(ModeKind),
    ReadInput,
    /// Plays trials one after the other, or pauses.
    PlayTrials,
    NextTrial,
    PreviousTrial,
    WorstTrial,
    /// Back from a trial to the design's own pose.
    OwnPose,
    WriteLog,
    ShowPrecision,
    ShowPalette,
    ShowShortcuts,
}

/// Where a command stands in menus and lists.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Group {
    File,
    Edit,
    View,
    /// Only in the Study workspace.
    Study,
    Help,
}

impl Group {
    pub const ALL: [Self; 5] = [Self::File, Self::Edit, Self::View, Self::Study, Self::Help];

    pub fn name(self) -> &'static str {
        match self {
            Self::File => "File",
            Self::Edit => "Edit",
            Self::View => "View",
            Self::Study => "Study",
            Self::Help => "Help",
        }
    }
}

/// What a person reads of a command.
#[derive(Clone, Copy, Debug)]
pub struct CommandInfo {
    pub command: Command,
    pub group: Group,
    pub name: &'static str,
    /// What it does and what for, for tooltips and the palette.
    pub about: &'static str,
    /// The first is the one that is shown.
    pub keys: &'static [Keys],
}

const fn info(
    command: Command,
    group: Group,
    name: &'static str,
    keys: &'static [Keys],
    about: &'static str,
) -> CommandInfo {
    CommandInfo {
        command,
        group,
        name,
        about,
        keys,
    }
}

/// All commands, in the order of menus.
pub const COMMANDS: &[CommandInfo] = &[
    info(
        Command::Open,
        Group::File,
        "Open…",
        &[Keys::control("o")],
        "Opens a design with its bodies, meshes and room",
    ),
    info(
        Command::Save,
        Group::File,
        "Save",
        &[Keys::control("s")],
        "Writes the design, and the bodies that changed",
    ),
    info(
        Command::SaveAs,
        Group::File,
        "Save as…",
        &[Keys::control_shift("s")],
        "Writes the design to another file",
    ),
    info(
        Command::OpenMeasurements(TableRole::Training),
        Group::File,
        "Open measurements…",
        &[],
        "Opens a measurement table in the Field workspace, to fit a room to",
    ),
    info(
        Command::OpenMeasurements(TableRole::HeldOut),
        Group::File,
        "Open held-out measurements…",
        &[],
        "Opens a second table in the Field workspace, to judge the fit on",
    ),
    info(
        Command::UseRoom,
        Group::File,
        "Use the fitted room…",
        &[],
        "Saves the room that was fitted last and puts the design into it",
    ),
    info(
        Command::Quit,
        Group::File,
        "Quit",
        &[Keys::control("q")],
        "Closes the window, and asks first where something is not saved",
    ),
    info(
        Command::Undo,
        Group::Edit,
        "Undo",
        &[Keys::control("z")],
        "Takes the last change of the design back",
    ),
    info(
        Command::Redo,
        Group::Edit,
        "Redo",
        &[Keys::control_shift("z"), Keys::control("y")],
        "Does again what was undone last",
    ),
    info(
        Command::CancelDrag,
        Group::Edit,
        "Take the drag back",
        &[Keys::plain("escape")],
        "Ends a drag as if it had never been",
    ),
    info(
        Command::Sensors(SensorCommand::Duplicate),
        Group::Edit,
        "Duplicate sensors",
        &[Keys::control("d")],
        "Copies the selected sensors in place, to be moved from there",
    ),
    info(
        Command::Sensors(SensorCommand::Row),
        Group::Edit,
        "Row of sensors…",
        &[],
        "Makes each selected sensor the first of a row at equal distances",
    ),
    info(
        Command::Sensors(SensorCommand::Remove),
        Group::Edit,
        "Delete sensors",
        &[Keys::plain("delete")],
        "Takes the selected sensors off their body, which keeps one at least",
    ),
    info(
        Command::Sensors(SensorCommand::Mirror(MirrorPlane::X)),
        Group::Edit,
        "Mirror sensors at x = 0",
        &[],
        "Moves the selected sensors to the other side of their body's plane x = 0",
    ),
    info(
        Command::Sensors(SensorCommand::Mirror(MirrorPlane::Y)),
        Group::Edit,
        "Mirror sensors at y = 0",
        &[],
        "Moves the selected sensors to the other side of their body's plane y = 0",
    ),
    info(
        Command::Sensors(SensorCommand::Mirror(MirrorPlane::Z)),
        Group::Edit,
        "Mirror sensors at z = 0",
        &[],
        "Moves the selected sensors to the other side of their body's plane z = 0",
    ),
    info(
        Command::Sensors(SensorCommand::MirrorCopy(MirrorPlane::X)),
        Group::Edit,
        "Mirror copy at x = 0",
        &[],
        "Puts copies on the other side of the body's plane x = 0",
    ),
    info(
        Command::Sensors(SensorCommand::MirrorCopy(MirrorPlane::Y)),
        Group::Edit,
        "Mirror copy at y = 0",
        &[],
        "Puts copies on the other side of the body's plane y = 0",
    ),
    info(
        Command::Sensors(SensorCommand::MirrorCopy(MirrorPlane::Z)),
        Group::Edit,
        "Mirror copy at z = 0",
        &[],
        "Puts copies on the other side of the body's plane z = 0",
    ),
    info(
        Command::Sensors(SensorCommand::MakeFiveDof),
        Group::Edit,
        "Make sensors 5-DOF",
        &[],
        "Leaves the selected sensors their z axis, which is all that a single coil measures",
    ),
    info(
        Command::Sensors(SensorCommand::MakeSixDof),
        Group::Edit,
        "Make sensors 6-DOF",
        &[],
        "Gives the selected sensors a full rotation with their axis as z",
    ),
    info(
        Command::Sensors(SensorCommand::AlongNormal),
        Group::Edit,
        "Axis along the surface normal",
        &[],
        "Turns each axis out of the body, straight through its surface",
    ),
    info(
        Command::Sensors(SensorCommand::AlongShaft),
        Group::Edit,
        "Axis along the shaft",
        &[],
        "Turns each axis along the surface, in the direction in which the body is longest",
    ),
    info(
        Command::FitRoom,
        Group::Edit,
        "Fit a room",
        &[],
        "Fits a room to the measurements that are open in the Field workspace",
    ),
    info(
        Command::FrameSelection,
        Group::View,
        "Frame selection",
        &[Keys::plain("f")],
        "Moves the camera to what is selected, or to everything",
    ),
    info(
        Command::LookAlong(Axis::X),
        Group::View,
        "Look along x",
        &[Keys::plain("1")],
        "Looks along the tracker's x axis",
    ),
    info(
        Command::LookAlong(Axis::Y),
        Group::View,
        "Look along y",
        &[Keys::plain("3")],
        "Looks along the tracker's y axis",
    ),
    info(
        Command::LookAlong(Axis::Z),
        Group::View,
        "Look along z",
        &[Keys::plain("7")],
        "Looks along the tracker's z axis, which points from volume to generator",
    ),
    info(
        Command::ToggleMagnification,
        Group::View,
        "Errors at true size",
        &[Keys::plain("m")],
        "Draws errors at true size, or magnified again",
    ),
    info(
        Command::ShowWorkspace(Workspace::Design),
        Group::View,
        "Design workspace",
        &[Keys::control("1")],
        "Bodies, sensors and the result",
    ),
    info(
        Command::ShowWorkspace(Workspace::Field),
        Group::View,
        "Field workspace",
        &[Keys::control("2")],
        "The room: its measurements, their fit, and what that is worth",
    ),
    info(
        Command::ShowWorkspace(Workspace::Study),
        Group::View,
        "Study workspace",
        &[Keys::control("3")],
        "Trial by trial: the motion, the plots, the log",
    ),
    info(
        Command::ChooseMode(ModeKind::Single),
        Group::Study,
        "Single pose",
        &[],
        "Studies the design's own pose alone",
    ),
    info(
        Command::ChooseMode(ModeKind::Motion),
        Group::Study,
        "Range of motion",
        &[],
        "Studies every pose of the design's range of motion",
    ),
    info(
        Command::ChooseMode(ModeKind::Input),
        Group::Study,
        "Input data",
        &[],
        "Studies the poses of a table that was read",
    ),
    info(
        Command::ReadInput,
        Group::Study,
        "Read input data…",
        &[],
        "Reads a table of poses (CSV); one can also be dropped onto the window",
    ),
    info(
        Command::PlayTrials,
        Group::Study,
        "Play or pause",
        &[Keys::plain("space")],
        "Moves the tool through the trials, one after the other",
    ),
    info(
        Command::PreviousTrial,
        Group::Study,
        "Previous trial",
        &[Keys::plain("left")],
        "Shows the tool one trial earlier",
    ),
    info(
        Command::NextTrial,
        Group::Study,
        "Next trial",
        &[Keys::plain("right")],
        "Shows the tool one trial later",
    ),
    info(
        Command::WorstTrial,
        Group::Study,
        "Worst trial",
        &[Keys::plain("w")],
        "Shows the tool in the trial with the largest tip error",
    ),
    info(
        Command::OwnPose,
        Group::Study,
        "The design's own pose",
        &[Keys::plain("home")],
        "Puts the tool back where the design has it",
    ),
    info(
        Command::WriteLog,
        Group::Study,
        "Write the log…",
        &[],
        "Writes every trial's poses and errors to a table (CSV)",
    ),
    info(
        Command::ShowPrecision,
        Group::View,
        "Error against run time…",
        &[],
        "Measures what each way of computing costs in time and error, for this design",
    ),
    info(
        Command::ToggleLeft,
        Group::View,
        "Fold the outliner",
        &[],
        "Shows or hides the panels at the left",
    ),
    info(
        Command::ToggleRight,
        Group::View,
        "Fold the inspector",
        &[],
        "Shows or hides the panels at the right",
    ),
    info(
        Command::ToggleHistory,
        Group::View,
        "History",
        &[],
        "Lists every step since the design was opened; a click goes there",
    ),
    info(
        Command::ToggleTheme,
        Group::View,
        "Light or dark",
        &[],
        "Dark for a dim room, light for daylight and for paper",
    ),
    info(
        Command::ShowPalette,
        Group::Help,
        "All commands…",
        &[Keys::control_shift("p")],
        "Finds a command by a part of its name",
    ),
    info(
        Command::ShowShortcuts,
        Group::Help,
        "Keyboard shortcuts…",
        &[Keys::plain("f1")],
        "Lists every key, with a field to search in",
    ),
];

impl Command {
    /// What a person reads of it. Every command stands in the table.
    pub fn info(self) -> &'static CommandInfo {
        let own = COMMANDS.iter().find(|info| info.command == self);
        own.unwrap_or(&COMMANDS[0])
    }

    /// What cannot be done now is shown, but cannot be chosen.
    pub fn is_available(
        self,
        world: Option<&OpenWorld>,
        selection: &Selection,
        is_dragging: bool,
        workspace: Workspace,
    ) -> bool {
        let document = world.map(|world| &world.0.document);
        match self {
            Self::CancelDrag => is_dragging,
            // Nothing else happens in the middle of a drag.
            _ if is_dragging => false,
            _ if self.info().group == Group::Study => workspace == Workspace::Study,
            Self::Undo => document.is_some_and(|d| d.undo_label().is_some()),
            Self::Redo => document.is_some_and(|d| d.redo_label().is_some()),
            Self::Sensors(command) => {
                world.is_some_and(|world| command.is_available(&world.0, selection))
            }
            _ => true,
        }
    }
}

/// The command of a key with its modifiers.
pub fn command_of(key: &str, control: bool, shift: bool) -> Option<Command> {
    let pressed = |keys: &Keys| keys.key == key && keys.control == control && keys.shift == shift;
    COMMANDS
        .iter()
        .find(|info| info.keys.iter().any(pressed))
        .map(|info| info.command)
}

impl Plugin for CommandsPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<ActiveDrag>()
            .init_resource::<PanelsShown>()
            .init_resource::<Workspace>()
            .init_resource::<Theme>()
            .init_resource::<CommandPages>()
            .init_resource::<RowPage>()
            .init_resource::<Selection>()
            .add_message::<RunCommand>()
            .add_message::<EditRequest>()
            .add_message::<ViewRequest>()
            .add_message::<FileRequest>()
            .add_message::<PrecisionRequest>()
            .add_message::<StudyRequest>()
            .add_message::<FieldRequest>()
            .add_message::<RequestRedraw>()
            .add_systems(
                Update,
                run_commands
                    .run_if(on_message::<RunCommand>)
                    .in_set(CommandsSystems)
                    .in_set(EditorSystems::Input),
            );
    }
}

/// What decides which commands can be chosen now.
#[derive(bevy::ecs::system::SystemParam)]
pub struct Availability<'w> {
    world: Option<Res<'w, OpenWorld>>,
    selection: Res<'w, Selection>,
    drag: Res<'w, ActiveDrag>,
    workspace: Res<'w, Workspace>,
}

impl Availability<'_> {
    pub fn of(&self, command: Command) -> bool {
        let world = self.world.as_deref();
        command.is_available(world, &self.selection, self.drag.0, *self.workspace)
    }
}

/// Where commands go.
#[derive(bevy::ecs::system::SystemParam)]
struct Asked<'w> {
    edits: MessageWriter<'w, EditRequest>,
    views: MessageWriter<'w, ViewRequest>,
    files: MessageWriter<'w, FileRequest>,
    precision: MessageWriter<'w, PrecisionRequest>,
    study: MessageWriter<'w, StudyRequest>,
    fields: MessageWriter<'w, FieldRequest>,
    panels: ResMut<'w, PanelsShown>,
    theme: ResMut<'w, Theme>,
    workspace: ResMut<'w, Workspace>,
    pages: ResMut<'w, CommandPages>,
    row: ResMut<'w, RowPage>,
    selection: Res<'w, Selection>,
    surfaces: Option<Res<'w, Surfaces>>,
    redraw: MessageWriter<'w, RequestRedraw>,
}

fn run_commands(
    mut commands: MessageReader<RunCommand>,
    drag: Res<ActiveDrag>,
    world: Option<Res<OpenWorld>>,
    mut asked: Asked,
) {
    for RunCommand(command) in commands.read() {
        let is_available =
            command.is_available(world.as_deref(), &asked.selection, drag.0, *asked.workspace);
        if is_available {
            asked.run(*command, world.as_deref());
        }
    }
}

impl Asked<'_> {
    fn run(&mut self, command: Command, world: Option<&OpenWorld>) {
        match command {
            Command::Open => self.file(FileRequest::ShowOpen),
            Command::Save => self.file(FileRequest::Save),
            Command::SaveAs => self.file(FileRequest::ShowSaveAs),
            Command::Quit => self.file(FileRequest::Quit),
            Command::Undo => self.edit(EditRequest::Undo),
            Command::Redo => self.edit(EditRequest::Redo),
            Command::CancelDrag => self.edit(EditRequest::Cancel),
            Command::Sensors(SensorCommand::Row) => self.row.is_open = true,
            Command::Sensors(command) => {
                if let Some(world) = world {
                    self.sensors(command, world);
                }
            }
            Command::FrameSelection => self.view(ViewRequest::FrameSelection),
            Command::LookAlong(axis) => self.view(ViewRequest::LookAlong(axis)),
            Command::ToggleMagnification => {
                if let Some(world) = world {
                    let view = toggled_magnification(world.0.document.view());
                    self.view(ViewRequest::Set(view));
                }
            }
            Command::ToggleLeft => self.panels.left = !self.panels.left,
            Command::ToggleRight => self.panels.right = !self.panels.right,
            Command::ToggleHistory => {
                self.panels.history = !self.panels.history;
                self.panels.left |= self.panels.history;
            }
            Command::ToggleTheme => {
                *self.theme = self.theme.other();
                self.theme.apply();
            }
            Command::ShowWorkspace(workspace) => {
                self.workspace.set_if_neq(workspace);
            }
            Command::ChooseMode(kind) => self.study(StudyRequest::Choose(kind)),
            Command::ReadInput => self.file(FileRequest::ShowReadInput),
            Command::PlayTrials => self.study(StudyRequest::TogglePlay),
            Command::NextTrial => self.study(StudyRequest::Step(1)),
            Command::PreviousTrial => self.study(StudyRequest::Step(-1)),
            Command::WorstTrial => self.study(StudyRequest::ShowWorst),
            Command::OwnPose => self.study(StudyRequest::Show(None)),
            Command::WriteLog => self.file(FileRequest::ShowWriteLog),
            Command::OpenMeasurements(role) => self.field(FieldRequest::ShowOpen(role)),
            Command::FitRoom => self.field(FieldRequest::Fit),
            Command::UseRoom => self.field(FieldRequest::ShowSave(RoomToSave::Fitted)),
            Command::ShowPrecision => {
                self.precision.write(PrecisionRequest::Open);
            }
            Command::ShowPalette => self.pages.show_palette(),
            Command::ShowShortcuts => self.pages.show_shortcuts(),
        }
        self.redraw.write(RequestRedraw);
    }

    fn sensors(&mut self, command: SensorCommand, world: &OpenWorld) {
        let body = self.selection.sensors().map(|(body, _)| body);
        let surfaces = self.surfaces.as_ref().zip(body);
        let surface = surfaces.and_then(|(surfaces, body)| surfaces.of(body));
        let requests = command.requests(&world.0, &self.selection, surface.map(|s| &**s));
        self.edits.write_batch(requests);
    }

    fn edit(&mut self, request: EditRequest) {
        self.edits.write(request);
    }

    fn view(&mut self, request: ViewRequest) {
        self.views.write(request);
    }

    fn study(&mut self, request: StudyRequest) {
        self.study.write(request);
    }

    /// Where what comes of it can be seen.
    fn field(&mut self, request: FieldRequest) {
        self.workspace.set_if_neq(Workspace::Field);
        self.fields.write(request);
    }

    fn file(&mut self, request: FileRequest) {
        self.files.write(request);
    }
}

/// The view with errors at true size, or magnified again where they were at true size.
fn toggled_magnification(view: &View) -> View {
    let magnification = match view.magnification {
        Magnification::Times(1.0) => Magnification::Auto,
        _ => Magnification::Times(1.0),
    };
    View {
        magnification,
        ..view.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shift_tells_redo_from_undo() {
        assert_eq!(command_of("z", true, false), Some(Command::Undo));
        assert_eq!(command_of("z", true, true), Some(Command::Redo));
        assert_eq!(command_of("y", true, false), Some(Command::Redo));
        assert_eq!(command_of("z", false, false), None);
    }

    #[test]
    fn no_two_commands_share_a_key_or_a_name() {
        for (i, a) in COMMANDS.iter().enumerate() {
            for b in &COMMANDS[i + 1..] {
                assert_ne!(a.command, b.command);
                assert_ne!((a.group, a.name), (b.group, b.name));
                let shared = a.keys.iter().find(|keys| b.keys.contains(keys));
                assert_eq!(shared, None, "{} and {}", a.name, b.name);
            }
        }
    }

    #[test]
    fn keys_read_as_people_write_them() {
        let shown = |command: Command| command.info().keys[0].to_string();
        assert_eq!(shown(Command::Redo), "Ctrl+Shift+Z");
        assert_eq!(shown(Command::CancelDrag), "Esc");
        assert_eq!(shown(Command::ShowShortcuts), "F1");
    }
}
