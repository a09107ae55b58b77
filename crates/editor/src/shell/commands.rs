//! Everything that can be asked for by name, and the one place that carries it out. Menus, keys,
//! the palette and the sheet of shortcuts all read one table.

use crate::document::body_files::BodyFileRequest;
use crate::document::meshes::{MeshRequest, body_of_selection};
use crate::document::requests::{ActiveDrag, EditRequest, FileRequest, OpenWorld, ViewRequest};
use crate::document::selection::Selection;
use crate::document::trials::ModeKind;
use crate::palette::Theme;
use crate::schedule::EditorSystems;
use crate::shell::command_palette::CommandPages;
use crate::shell::command_table::COMMANDS;
use crate::shell::keys::Keys;
use crate::shell::layout::PanelsShown;
use crate::shell::preferences::InterfaceScale;
use crate::shell::window::Workspace;
use crate::viewport::gizmo::GizmoAxes;
use crate::viewport::sensor_commands::SensorCommand;
use crate::viewport::surfaces::Surfaces;
use crate::viewport::tool::{SceneTool, add_sensor_beside};
use crate::workspaces::design::row_page::RowPage;
use crate::workspaces::field::desk::TableRole;
use crate::workspaces::field::{FieldRequest, RoomToSave};
use crate::workspaces::present::PresentRequest;
use crate::workspaces::study::desk::StudyRequest;
use crate::workspaces::study::precision::PrecisionRequest;
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use trackwright_design::BodyRole;
use trackwright_design::view::{Magnification, View};
use trackwright_geometry::orbit::Axis;
use trackwright_project::MeshOwner;

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
    New,
    Open,
    Save,
    SaveAs,
    /// Uses a file as this body.
    OpenBody(BodyRole),
    /// Of the selected body, else the tool.
    SaveBody,
    /// For the selected body, else the tool.
    LoadMesh,
    Report,
    /// Shows another mesh beside the bodies.
    AddAnatomy,
    Quit,
    Undo,
    Redo,
    /// Takes the drag back that is under way.
    CancelDrag,
    /// Something done to the selected sensors.
    Sensors(SensorCommand),
    /// Takes a tool in hand, or puts it back.
    Tool(SceneTool),
    AddSensorBeside,
    FrameSelection,
    LookAlong(Axis),
    ToggleGizmoAxes,
    ToggleMagnification,
    ToggleLeft,
    ToggleRight,
    ToggleHistory,
    ToggleTheme,
    LargerInterface,
    SmallerInterface,
    PlainInterface,
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
    NextSlide,
    PreviousSlide,
    FirstSlide,
    PlayMotion,
    EditSlides,
    LeavePresentation,
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
    /// Only while slides are shown.
    Present,
    Help,
}

impl Group {
    pub const ALL: [Self; 6] =
        [Self::File, Self::Edit, Self::View, Self::Study, Self::Present, Self::Help];

    /// The one workspace in which its commands are there; their keys may be others' elsewhere.
    pub fn workspace(self) -> Option<Workspace> {
        match self {
            Self::Study => Some(Workspace::Study),
            Self::Present => Some(Workspace::Present),
            _ => None,
        }
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::File => "File",
            Self::Edit => "Edit",
            Self::View => "View",
            Self::Study => "Study",
            Self::Present => "Present",
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
            _ if self.info().group.workspace().is_some_and(|own| own != workspace) => false,
            Self::PlayMotion => document.is_some_and(|d| d.design().motion.is_some()),
            Self::Undo => document.is_some_and(|d| d.undo_label().is_some()),
            Self::Redo => document.is_some_and(|d| d.redo_label().is_some()),
            Self::Tool(_) | Self::AddSensorBeside => world.is_some() && workspace.is_edited_in(),
            Self::OpenBody(role) => document.is_some_and(|d| d.design().body(role).is_some()),
            Self::ToggleGizmoAxes => workspace == Workspace::Design,
            Self::Sensors(command) => {
                world.is_some_and(|world| command.is_available(&world.0, selection))
            }
            _ => true,
        }
    }
}

/// The command of a key with its modifiers: a workspace's own goes before one that is everywhere.
pub fn command_of(key: &str, control: bool, shift: bool, workspace: Workspace) -> Option<Command> {
    let pressed = |keys: &Keys| keys.key == key && keys.control == control && keys.shift == shift;
    let of_group = |wanted: Option<Workspace>| {
        COMMANDS
            .iter()
            .find(|info| info.group.workspace() == wanted && info.keys.iter().any(pressed))
            .map(|info| info.command)
    };
    of_group(Some(workspace)).or_else(|| of_group(None))
}

impl Plugin for CommandsPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<ActiveDrag>()
            .init_resource::<PanelsShown>()
            .init_resource::<Workspace>()
            .init_resource::<Theme>()
            .init_resource::<InterfaceScale>()
            .init_resource::<CommandPages>()
            .init_resource::<RowPage>()
            .init_resource::<Selection>()
            .init_resource::<SceneTool>()
            .init_resource::<GizmoAxes>()
            .add_message::<RunCommand>()
            .add_message::<EditRequest>()
            .add_message::<ViewRequest>()
            .add_message::<FileRequest>()
            .add_message::<PrecisionRequest>()
            .add_message::<StudyRequest>()
            .add_message::<PresentRequest>()
            .add_message::<FieldRequest>()
            .add_message::<MeshRequest>()
            .add_message::<BodyFileRequest>()
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
    present: MessageWriter<'w, PresentRequest>,
    fields: MessageWriter<'w, FieldRequest>,
    meshes: MessageWriter<'w, MeshRequest>,
    body_files: MessageWriter<'w, BodyFileRequest>,
    scale: ResMut<'w, InterfaceScale>,
    panels: ResMut<'w, PanelsShown>,
    theme: ResMut<'w, Theme>,
    workspace: ResMut<'w, Workspace>,
    pages: ResMut<'w, CommandPages>,
    row: ResMut<'w, RowPage>,
    selection: Res<'w, Selection>,
    tool: ResMut<'w, SceneTool>,
    gizmo: ResMut<'w, GizmoAxes>,
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
            Command::New => self.file(FileRequest::ShowNew),
            Command::Open => self.file(FileRequest::ShowOpen),
            Command::Save => self.file(FileRequest::Save),
            Command::SaveAs => self.file(FileRequest::ShowSaveAs),
            Command::OpenBody(body) => {
                self.body_files.write(BodyFileRequest::ShowOpen(body));
            }
            Command::SaveBody => {
                let body = body_of_selection(&self.selection);
                self.body_files.write(BodyFileRequest::ShowSave(body));
            }
            Command::LoadMesh => {
                let body = body_of_selection(&self.selection);
                self.meshes.write(MeshRequest::ShowLoad(body.into()));
            }
            Command::AddAnatomy => {
                let new = MeshOwner::Anatomy(None);
                self.meshes.write(MeshRequest::ShowLoad(new));
            }
            Command::Report => self.file(FileRequest::ShowWriteReport),
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
            Command::Tool(tool) => *self.tool = self.tool.toggled(tool),
            Command::AddSensorBeside => {
                let design = world.map(|world| world.0.document.design());
                let edit = design.and_then(|design| add_sensor_beside(design, &self.selection));
                self.edits.write_batch(edit.map(EditRequest::Apply));
            }
            Command::FrameSelection => self.view(ViewRequest::FrameSelection),
            Command::LookAlong(axis) => self.view(ViewRequest::LookAlong(axis)),
            Command::ToggleGizmoAxes => self.gizmo.0 = self.gizmo.0.other(),
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
            Command::LargerInterface => self.scale.step(1),
            Command::SmallerInterface => self.scale.step(-1),
            Command::PlainInterface => *self.scale = InterfaceScale::default(),
            Command::ShowWorkspace(Workspace::Present) if *self.workspace == Workspace::Present => {
                self.present(PresentRequest::Leave);
            }
            Command::ShowWorkspace(workspace) => {
                self.workspace.set_if_neq(workspace);
            }
            Command::NextSlide => self.present(PresentRequest::Step(1)),
            Command::PreviousSlide => self.present(PresentRequest::Step(-1)),
            Command::FirstSlide => self.present(PresentRequest::Show(0)),
            Command::PlayMotion => self.study(StudyRequest::TogglePlay),
            Command::EditSlides => self.present(PresentRequest::ToggleEditing),
            Command::LeavePresentation => self.present(PresentRequest::Leave),
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

    fn present(&mut self, request: PresentRequest) {
        self.present.write(request);
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
    View { magnification, ..view.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shift_tells_redo_from_undo() {
        let command = |key, control, shift| command_of(key, control, shift, Workspace::Design);
        assert_eq!(command("z", true, false), Some(Command::Undo));
        assert_eq!(command("z", true, true), Some(Command::Redo));
        assert_eq!(command("y", true, false), Some(Command::Redo));
        assert_eq!(command("z", false, false), None);
    }

    #[test]
    fn a_key_is_the_shown_workspaces_own_before_it_is_anybodys() {
        let command = |key, workspace| command_of(key, false, false, workspace);
        assert_eq!(command("right", Workspace::Study), Some(Command::NextTrial));
        assert_eq!(command("right", Workspace::Present), Some(Command::NextSlide));
        assert_eq!(command("right", Workspace::Design), None);
        let leave = Some(Command::LeavePresentation);
        assert_eq!(command("escape", Workspace::Present), leave);
        assert_eq!(command("escape", Workspace::Field), Some(Command::CancelDrag));
    }

    #[test]
    fn no_two_commands_share_a_name_or_in_one_workspace_a_key() {
        for (i, a) in COMMANDS.iter().enumerate() {
            for b in &COMMANDS[i + 1..] {
                assert_ne!(a.command, b.command);
                assert_ne!((a.group, a.name), (b.group, b.name));
                if a.group.workspace() != b.group.workspace() {
                    continue;
                }
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
