//! The open document, and requests to change it, its view or its files.
//!
//! The document in [`OpenWorld`] is the only truth. Plugins read it and write [`EditRequest`],
//! [`ViewRequest`] or [`FileRequest`]; they never change it themselves.

use bevy::prelude::*;
use std::path::PathBuf;
use trackwright_design::view::View;
use trackwright_design::{BodyRole, Design, Edit, Origin};
use trackwright_formats::tool_definition::OnMismatch;
use trackwright_geometry::mesh_reference::MeshUnit;
use trackwright_geometry::orbit::AxisEnd;
use trackwright_project::{MeshOwner, RoomSource, Starter, World as StoreWorld};

/// The one open document with its room and meshes.
#[derive(Resource)]
pub struct OpenWorld(pub StoreWorld);

/// Requests a change of the design; the only way in which it changes.
#[expect(clippy::large_enum_variant, reason = "an edit is requested once a frame at most")]
#[derive(Message, Clone, Debug, PartialEq)]
pub enum EditRequest {
    /// Opens an undo step of many edits (a drag), with the label that undo shows.
    Begin(String),
    Apply(Edit),
    /// Closes the undo step.
    Commit,
    /// Takes back everything since `Begin`, to the bit.
    Cancel,
    Undo,
    Redo,
    /// Undoes or redoes until the design is in this state of its history.
    JumpTo(usize),
}

impl EditRequest {
    /// Edits that are one undo step.
    pub fn step(
        label: impl Into<String>,
        edits: impl IntoIterator<Item = Edit>,
    ) -> impl Iterator<Item = Self> {
        let edits = edits.into_iter().map(Self::Apply);
        [Self::Begin(label.into())].into_iter().chain(edits).chain([Self::Commit])
    }
}

/// Requests a change of the design's view.
#[expect(
    clippy::large_enum_variant,
    reason = "a view is requested some sixty times a second at most"
)]
#[derive(Message, Clone, Debug, PartialEq)]
pub enum ViewRequest {
    Set(View),
    /// The camera glides to what is selected, or to everything.
    FrameSelection,
    /// The camera glides to where it sees both bodies.
    FrameAll,
    /// Turns to look from the end of a tracker axis.
    LookFrom(AxisEnd),
    /// Between perspective and orthographic projection.
    SwitchProjection,
    /// Turns by a drag in pixels.
    Orbit([f64; 2]),
    /// What turned it has let go: the view is kept.
    EndOrbit,
}

/// Requests work with files; what may lose something is confirmed by the person first.
#[derive(Message, Clone, Debug, PartialEq)]
pub enum FileRequest {
    /// Shows what a new design can begin as.
    ShowNew,
    /// Opens a new design that was never saved.
    New(Starter),
    /// Shows the dialog that chooses a file to open.
    ShowOpen,
    Open(PathBuf),
    OpenBuiltIn(String),
    /// Opens a saved design and changes it in one undo step.
    OpenEdited {
        of: Origin,
        label: String,
        edits: Vec<Edit>,
    },
    /// Opens another state of a design as a document of its own that was never saved.
    OpenVariant {
        of: Origin,
        design: Box<Design>,
        /// Of the file's name.
        suffix: String,
    },
    Save,
    /// Shows the dialog that chooses where to save.
    ShowSaveAs,
    SaveAs(PathBuf),
    /// Closes the window.
    Quit,
    /// Goes on with what would lose the open document: the person gave it up.
    Discard(Box<FileRequest>),
    /// Saves, and goes on once that is done.
    SaveThen(Box<FileRequest>),
    /// Saves although other designs use a body that changed.
    SaveShared(SharedChoice),
    /// Opens the newest of what crashed sessions left.
    Recover,
    /// Gives the newest of it up.
    DropLeftover,
    /// Reads the design again: another program changed its files.
    Reload,
    /// Goes on with what is open although its files were changed; the next save writes over them.
    KeepMine,
    /// Saves over files that another program changed.
    SaveOver,
    /// Puts the design into another room.
    AssignRoom(RoomSource),
    /// Shows the dialog that chooses a table of poses.
    ShowReadInput,
    ReadInput(PathBuf),
    /// Shows the dialog that chooses where the log of the study goes.
    ShowWriteLog,
    WriteLog(PathBuf),
    /// Shows the dialog that chooses where the design's report goes.
    ShowWriteReport,
    WriteReport(PathBuf),
    /// Opens the report that was written last, in the browser.
    OpenReport,
    /// Shows the dialog that chooses where something goes for other programs.
    ShowExport(Export),
    Export(Export, PathBuf),
    /// Stops writing a report or a file for other programs.
    CancelWriting,
}

/// What is written for other programs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Export {
    /// The error of the room on a lattice.
    Field,
    /// The tips of the design's study, true and simulated.
    Tips,
    /// The 3D view.
    Scene,
}

impl Export {
    /// The command of the program that writes it, and the end of the file's name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Field => "field",
            Self::Tips => "tips",
            Self::Scene => "scene",
        }
    }
}

/// What becomes of a changed body that other designs use too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SharedChoice {
    /// The body's file changes, for all of them.
    Overwrite,
    /// This design gets a body file of its own.
    Copy,
}

/// Whether a drag in the scene is under way.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ActiveDrag(pub bool);

/// Registers requests to the open document.
pub struct RequestsPlugin;

impl Plugin for RequestsPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<ActiveDrag>()
            .add_message::<EditRequest>()
            .add_message::<ViewRequest>()
            .add_message::<FileRequest>();
    }
}

/// A request about a body file or a tool definition.
#[derive(Message, Clone, Debug, PartialEq)]
pub enum BodyFileRequest {
    /// Shows the dialog that chooses a file to be the tool or the CRF.
    ShowOpen(BodyRole),
    /// A file was dropped: for the body under selection, or whichever the person chooses.
    Drop(PathBuf),
    Open {
        body: BodyRole,
        file: PathBuf,
        on_mismatch: OnMismatch,
    },
    /// Gives the reading up.
    GiveUp,
    /// Shows the dialog that chooses where a body is written, and as what.
    ShowSave(BodyRole),
    /// Reports what is lost, or writes where nothing is.
    Save {
        body: BodyRole,
        file: PathBuf,
    },
    /// Writes: the person knows what is lost.
    Write {
        body: BodyRole,
        file: PathBuf,
    },
}

impl BodyFileRequest {
    pub fn open(body: BodyRole, file: PathBuf) -> Self {
        Self::Open { body, file, on_mismatch: OnMismatch::Refuse }
    }
}

/// A request about a mesh.
#[derive(Message, Clone, Debug, PartialEq)]
pub enum MeshRequest {
    /// Shows the dialog that chooses a file.
    ShowLoad(MeshOwner),
    /// A file was dropped: for the body under selection, or whichever the person chooses.
    Drop(PathBuf),
    Load {
        whose: MeshOwner,
        file: PathBuf,
        /// `None` is that of the format, and confirmed where the size is doubtful.
        unit: Option<MeshUnit>,
    },
    /// Reads the present mesh in another unit, or in that of its format.
    SetUnit { whose: MeshOwner, unit: Option<MeshUnit> },
    /// Gives the reading up.
    GiveUp,
}

impl MeshRequest {
    pub fn load(whose: impl Into<MeshOwner>, file: PathBuf) -> Self {
        Self::Load { whose: whose.into(), file, unit: None }
    }
}
