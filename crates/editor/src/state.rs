//! What the editor's plugins share: the open world, the selection, requests, results.
//!
//! The document in [`OpenWorld`] is the only truth. Plugins read it, ask for changes by writing
//! [`EditRequest`], [`ViewRequest`] or [`FileRequest`], and never change it themselves.

pub use super::selection::Selection;
use super::solver::{Extent, Scatter};
use super::study::{ModeKind, ShownPlugin};
use bevy::prelude::*;
use std::path::PathBuf;
use std::time::Duration;
use trackwright_design::view::{ColorMap, View};
use trackwright_design::{BodyRole, Edit};
pub use trackwright_geometry::orbit::Axis;
use trackwright_project::{Starter, World as StoreWorld};
use trackwright_simulation::{ChartedProfile, Expected, Outcome, PoseDetail, SliceOutcome};

/// Phases of a frame, in order, chained in [`Update`].
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum EditorSystems {
    /// Turns keys and pointer into requests.
    Input,
    /// Applies requests to the open document.
    Edit,
    /// Hands changed designs to the solver thread and takes its results.
    Solve,
    /// Turns results into what glyphs and maps are made of.
    Sample,
    /// Writes entities, cameras and meshes.
    Draw,
}

/// The one open document with its room and meshes.
#[derive(Resource)]
pub struct OpenWorld(pub StoreWorld);

/// What the pointer is over, in the scene or in the outliner.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Hovered(pub Option<Selected>);

/// A thing that can be selected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Selected {
    Body(BodyRole),
    Sensor(BodyRole, usize),
    Tip(BodyRole),
    /// By its place in the design's list.
    Anatomy(usize),
}

/// Asks for a change of the design; the only way in which it changes.
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

/// Asks for a change of how the design is looked at.
#[expect(
    clippy::large_enum_variant,
    reason = "a view is asked for some sixty times a second at most"
)]
#[derive(Message, Clone, Debug, PartialEq)]
pub enum ViewRequest {
    Set(View),
    /// The camera glides to what is selected, or to everything.
    FrameSelection,
    LookAlong(Axis),
}

/// Asks for work with files; what may lose something asks the person first.
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
    /// Reads the design again: somebody else changed its files.
    Reload,
    /// Goes on with what is open although its files were changed; the next save writes over them.
    KeepMine,
    /// Saves over files that somebody else changed.
    SaveOver,
    /// Shows the dialog that chooses a table of poses.
    ShowReadInput,
    ReadInput(PathBuf),
    /// Shows the dialog that chooses where the log of the study goes.
    ShowWriteLog,
    WriteLog(PathBuf),
    /// Shows the dialog that chooses where the design's report goes.
    ShowWriteReport,
    WriteReport(PathBuf),
}

/// What becomes of a changed body that other designs use too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SharedChoice {
    /// The body's file changes, for all of them.
    Overwrite,
    /// This design gets a body file of its own.
    Copy,
}

/// The newest results that the panels and the scene show.
#[derive(Resource, Default)]
pub struct Results {
    pub study: Option<Stamped<Outcome>>,
    /// What is to be expected of the study, of its revision or an older one; its value is `None` where
    /// the room keeps no measurements to draw fields from.
    pub expected: Option<Stamped<Option<Box<Expected>>>>,
    /// What the study's figures are of.
    pub extent: Option<Extent>,
    /// The mode that the study's figures are of.
    pub mode: Option<ModeKind>,
    /// The study trial by trial; `None` outside the Study workspace, and where there are too many
    /// trials. While something is dragged it stays what it was.
    pub profile: Option<Stamped<ChartedProfile>>,
    /// Of the shown trial, or of the design's own pose.
    pub pose: Option<Stamped<PoseDetail>>,
    /// The trial that `pose` is of, from 0; `None` for the design's own pose.
    pub pose_trial: Option<usize>,
    /// Which trials `pose_trial` counts; that of the desk where they are still looked at.
    pub pose_serial: u64,
    /// Of the same pose; `None` while its layer is off.
    pub scatter: Option<Scatter>,
    pub slice: Option<Stamped<SliceOutcome>>,
    /// Why there are no figures, in words.
    pub problem: Option<String>,
}

impl Results {
    /// Whether the study's figures are of all its trials.
    pub fn is_whole(&self) -> bool {
        self.extent == Some(Extent::Whole)
    }

    /// What is to be expected of the study that is shown, once that is known.
    pub fn expected_of_study(&self) -> Option<&Expected> {
        let (study, expected) = self.study.as_ref().zip(self.expected.as_ref())?;
        let is_of_it = self.is_whole() && study.revision == expected.revision;
        expected.value.as_deref().filter(|_| is_of_it)
    }
}

/// A result and what it belongs to.
#[derive(Clone, Debug)]
pub struct Stamped<T> {
    /// The document's revision that it was computed for.
    pub revision: u64,
    pub value: T,
    pub took: Duration,
}

/// The hole between the panels, in logical pixels of the window: the 3D view.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct ViewportRect {
    pub min: Vec2,
    pub size: Vec2,
}

/// The number next to the pointer while something is dragged.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct DragReadout(pub Option<DragText>);

/// A line of text at a place in the window, logical pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct DragText {
    pub at: Vec2,
    pub text: String,
}

/// What the pointer can do now, where what it is over does not say so by itself: for the status
/// line.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct PointerHint(pub Option<String>);

/// Whether a drag in the scene is under way.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ActiveDrag(pub bool);

/// The magnification of errors, ghost and vectors as drawn.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct ShownMagnification {
    pub times: f64,
    /// The ghost's turn would be too large and is drawn smaller.
    pub is_capped: bool,
}

/// The colour scale of the error map as drawn.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct ColorScale {
    pub map: ColorMap,
    pub max_mm: f64,
}

/// A colour bar in the legend.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorBar {
    pub label: String,
    pub unit: &'static str,
    pub map: ColorMap,
    /// Where the colours begin and end.
    pub min: f64,
    pub max: f64,
    /// The largest value there is, which may be beyond the end.
    pub largest: f64,
    /// Digits after the point of single values.
    pub decimals: usize,
    /// What the requirement says about such a value.
    pub limit: Option<f64>,
}

/// The scene's 3D camera.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct MainCamera;

/// What is drawn: a window with panels, or an offscreen picture.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub struct Presentation {
    pub panels: bool,
    pub window: bool,
}

impl Default for Presentation {
    fn default() -> Self {
        Self { panels: true, window: true }
    }
}

/// What the person is at: which panels stand around the 3D view.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Workspace {
    /// Bodies, sensors, the result.
    #[default]
    Design,
    /// The room: measurements, their fit, its quality.
    Field,
    /// Trials one by one: the motion, plots, the log.
    Study,
    /// A tracker over the network: its tools, a recording, where samples are missing.
    Live,
    /// The design beside a baseline, and designs and rooms in one table.
    Decide,
    /// What is shown to people who do not design it: slides, without panels.
    Present,
}

impl Workspace {
    pub const ALL: [Self; 6] =
        [Self::Design, Self::Field, Self::Study, Self::Live, Self::Decide, Self::Present];

    pub fn is_live(self) -> bool {
        self == Self::Live
    }

    /// Whether a hand in the scene changes the design.
    pub fn is_edited_in(self) -> bool {
        matches!(self, Self::Design | Self::Study | Self::Decide)
    }

    /// Whether the tool can stand where a trial has it.
    pub fn shows_trials(self) -> bool {
        matches!(self, Self::Study | Self::Present)
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::Design => "Design",
            Self::Field => "Field",
            Self::Study => "Study",
            Self::Live => "Live",
            Self::Decide => "Decide",
            Self::Present => "Present",
        }
    }
}

/// Registers the shared resources and messages.
pub struct StatePlugin;

impl Plugin for StatePlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(ShownPlugin)
            .init_resource::<Selection>()
            .init_resource::<Hovered>()
            .init_resource::<Results>()
            .init_resource::<DragReadout>()
            .init_resource::<PointerHint>()
            .init_resource::<ActiveDrag>()
            .init_resource::<Presentation>()
            .init_resource::<Workspace>()
            .add_message::<EditRequest>()
            .add_message::<ViewRequest>()
            .add_message::<FileRequest>()
            .configure_sets(
                Update,
                (
                    EditorSystems::Input,
                    EditorSystems::Edit,
                    EditorSystems::Solve,
                    EditorSystems::Sample,
                    EditorSystems::Draw,
                )
                    .chain(),
            );
    }
}
