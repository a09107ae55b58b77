//! Pictures of the 3D view without a window: PNG bytes, the same each time on one adapter.

use crate::app::offscreen;
use crate::document::requests::{EditRequest, OpenWorld};
use crate::document::selection::{Selected, Selection};
use crate::layers;
use crate::palette::Theme;
use crate::runner::metal::MetalSolver;
use crate::runner::results::Results;
use crate::runner::solve::SolverHandle;
use crate::runner::wake::Waker;
use crate::schedule::UiSystems;
use crate::shell::painted_text::{PaintedText, PaintedTexts};
use crate::shell::preferences::InterfaceScale;
use crate::shell::window::Workspace;
use crate::workspaces::decide::state::DecideState;
use crate::workspaces::decide::{self, DecideRequest};
use crate::workspaces::design::missed::Missed;
use crate::workspaces::design::placement_search::state::{PlacementSearch, PlacementSearchRequest};
use crate::workspaces::design::placement_search::wish::Wish;
use crate::workspaces::field::FieldRequest;
use crate::workspaces::field::state::{FieldState, TableRole};
use crate::workspaces::present::Presenter;
use crate::workspaces::study::state::StudyRequest;
use bevy::app::PluginsState;
use bevy::image::ImageFormat;
use bevy::prelude::*;
use bevy::render::render_resource::PollType;
use bevy::render::renderer::RenderDevice;
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured};
use bevy_egui::EguiPrimaryContextPass;
use std::io::Cursor;
use std::path::PathBuf;
use std::sync::mpsc::{self, Receiver};
use std::time::{Duration, Instant};
use trackwright_design::{BodyRole, Edit};
use trackwright_optimization::Settings;
use trackwright_project::World;

/// Longest that a picture waits for its results; a study of a million poses takes seconds.
const PATIENCE: Duration = Duration::from_secs(300);

/// Frames from the results to the picture: entities, then labels that are placed by them, then
/// what egui lays out from those.
const SETTLING_FRAMES: usize = 4;

/// Longest between looks at what is computed or read.
const NAP: Duration = Duration::from_millis(20);

/// The same during a search for better places: painting would take the processor from it.
const LONG_NAP: Duration = Duration::from_secs(2);

/// Frames from the request of a picture to its bytes.
const READBACK_FRAMES: usize = 20;

/// What stands around the 3D view, and what is shown in it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PictureSetup {
    pub has_panels: bool,
    /// Of the panels and labels.
    pub scale: InterfaceScale,
    pub workspace: Workspace,
    /// Open in the Field workspace.
    pub tables: Vec<(TableRole, PathBuf)>,
    /// In the Decide workspace.
    pub compared: ComparedDesigns,
    /// In the Design workspace: better places of this body's sensors are searched, and shown.
    pub placement_search: Option<(BodyRole, Settings)>,
    /// From 0, in the Present workspace.
    pub slide: usize,
    /// In the Study workspace; `None` is the design's own pose.
    pub trial: Option<StudyTrial>,
    pub selected: Option<Selected>,
    pub theme: Theme,
}

/// What a design is held against in the Decide workspace.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ComparedDesigns {
    /// The design that is pinned.
    pub baseline: Option<PathBuf>,
    /// Designs of the table.
    pub designs: Vec<PathBuf>,
    /// Recorded poses of the built tool.
    pub recorded: Option<PathBuf>,
}

impl ComparedDesigns {
    fn requests(self) -> impl Iterator<Item = DecideRequest> {
        let pin = self.baseline.map(DecideRequest::Pin);
        let recorded = (self.recorded).map(|file| DecideRequest::Recorded(BodyRole::Tool, file));
        let designs = self.designs.into_iter().map(DecideRequest::AddDesign);
        pin.into_iter().chain(recorded).chain(designs)
    }
}

/// A trial of the design's study.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StudyTrial {
    /// From 0.
    Number(usize),
    Worst,
}

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    #[error("no results after {} s", PATIENCE.as_secs())]
    NoResults,
    #[error("the graphics adapter gave no picture")]
    NoPicture,
    #[error("the picture cannot be written as PNG: {0}")]
    Encode(String),
}

/// The picture as the screenshot's observer leaves it.
#[derive(Resource, Default)]
struct Captured(Option<Image>);

/// Paints the world at a size, with the panels of a workspace if requested.
///
/// Call [`preflight::adapter`](crate::app::preflight::adapter) first: Bevy panics without an
/// adapter.
///
/// # Errors
/// See [`PictureError`].
pub fn png(world: World, size: [u32; 2], setup: PictureSetup) -> Result<Vec<u8>, PictureError> {
    Studio::open(world, size, setup)?.picture()?.png()
}

/// What is written in the picture that [`png`] paints.
///
/// # Errors
/// See [`PictureError`].
pub fn texts(
    world: World,
    size: [u32; 2],
    setup: PictureSetup,
) -> Result<Vec<PaintedText>, PictureError> {
    let mut studio = Studio::open(world, size, setup)?;
    studio.app.init_resource::<PaintedTexts>();
    for _ in 0..SETTLING_FRAMES {
        frame(&mut studio.app);
    }
    Ok(std::mem::take(&mut studio.app.world_mut().resource_mut::<PaintedTexts>().0))
}

/// The editor without a window, with all results, from which pictures are taken.
pub(crate) struct Studio {
    pub app: App,
    target: Handle<Image>,
    answers: Receiver<()>,
}

/// A picture as the adapter painted it.
pub struct Picture(Image);

impl Studio {
    /// Paints until everything is known that the picture shows.
    ///
    /// # Errors
    /// [`PictureError::NoResults`].
    pub fn open(world: World, size: [u32; 2], setup: PictureSetup) -> Result<Self, PictureError> {
        let trial = setup.trial;
        let has_table = setup.compared.baseline.is_some() || !setup.compared.designs.is_empty();
        let (app, target, answers) = start(world, size, setup);
        let mut studio = Self { app, target, answers };
        wait_for_results(&mut studio.app, &studio.answers)?;
        if has_table {
            // What is pinned is read by now.
            studio.request(DecideRequest::Compare)?;
        }
        if let Some(trial) = trial {
            studio.show(match trial {
                StudyTrial::Number(number) => StudyRequest::Show(Some(number)),
                StudyTrial::Worst => StudyRequest::ShowWorst,
            })?;
        }
        Ok(studio)
    }

    /// Shows another trial, and waits for what there is to know of it.
    ///
    /// # Errors
    /// [`PictureError::NoResults`].
    pub fn show(&mut self, trial: StudyRequest) -> Result<(), PictureError> {
        self.request(trial)
    }

    /// Edits the design.
    ///
    /// # Errors
    /// [`PictureError::NoResults`].
    pub fn edit(&mut self, edit: Edit) -> Result<(), PictureError> {
        self.request(EditRequest::Apply(edit))
    }

    fn request(&mut self, message: impl Message) -> Result<(), PictureError> {
        self.app.world_mut().write_message(message);
        frame(&mut self.app);
        wait_for_results(&mut self.app, &self.answers)
    }

    /// What is to be seen now.
    ///
    /// # Errors
    /// [`PictureError::NoPicture`].
    pub fn picture(&mut self) -> Result<Picture, PictureError> {
        let app = &mut self.app;
        for _ in 0..SETTLING_FRAMES {
            frame(app);
        }
        app.world_mut().spawn(Screenshot::image(self.target.clone())).observe(
            |on: On<ScreenshotCaptured>, mut captured: ResMut<Captured>| {
                captured.0 = Some(on.image.clone());
            },
        );
        for _ in 0..READBACK_FRAMES {
            frame(app);
            if let Some(image) = app.world_mut().resource_mut::<Captured>().0.take() {
                return Ok(Picture(image));
            }
        }
        Err(PictureError::NoPicture)
    }
}

impl Picture {
    /// As a PNG file, without opacity.
    ///
    /// # Errors
    /// [`PictureError::Encode`].
    pub fn png(self) -> Result<Vec<u8>, PictureError> {
        encode(self.0)
    }

    /// Red, green, blue and opacity of each pixel, eight bits each, from the upper left.
    ///
    /// # Errors
    /// [`PictureError::Encode`].
    pub fn rgba(self) -> Result<Vec<u8>, PictureError> {
        let picture = self.0.try_into_dynamic();
        let picture = picture.map_err(|error| PictureError::Encode(error.to_string()))?;
        Ok(picture.to_rgba8().into_raw())
    }
}

/// The app with everything in it that the setup requests; no frame is painted yet.
fn start(world: World, size: [u32; 2], setup: PictureSetup) -> (App, Handle<Image>, Receiver<()>) {
    setup.theme.apply();
    let (mut app, target) = offscreen(world, UVec2::from(size), setup.has_panels, |app| {
        app.insert_resource(setup.theme)
            .insert_resource(setup.scale)
            .insert_resource(setup.workspace)
            .insert_resource(Selection::of(setup.selected))
            .insert_resource(Presenter { slide: setup.slide, ..Presenter::default() })
            .init_resource::<Captured>();
    });
    for (role, file) in setup.tables {
        app.world_mut().write_message(FieldRequest::Open(role, file));
    }
    for request in setup.compared.requests() {
        app.world_mut().write_message(request);
    }
    if let Some((body, settings)) = setup.placement_search {
        let design = app.world().resource::<OpenWorld>().0.document.design();
        let wish = Wish::of_body(design, body);
        app.world_mut().resource_mut::<PlacementSearch>().settings = settings;
        app.world_mut().write_message(PlacementSearchRequest::Open);
        app.world_mut().write_message(PlacementSearchRequest::Set(wish));
        app.world_mut().write_message(PlacementSearchRequest::Start);
    }
    // Letters enter the font's texture in the order in which they are first shown, and their
    // edges depend on their place there by the last bit: nothing is written before everything
    // is known, whichever answer comes first.
    app.configure_sets(
        EguiPrimaryContextPass,
        (UiSystems::Panels, UiSystems::Overlay).run_if(is_complete),
    );
    let answers = wake_on_answers(&mut app);
    while app.plugins_state() == PluginsState::Adding {
        bevy::tasks::tick_global_task_pools_on_main_thread();
    }
    app.finish();
    app.cleanup();
    (app, target, answers)
}

/// A channel that gets a word whenever a thread has an answer.
fn wake_on_answers(app: &mut App) -> Receiver<()> {
    let (sender, receiver) = mpsc::channel();
    let waker = app.world_mut().get_resource_or_init::<Waker>().clone();
    waker.wake_with(move || {
        // Nobody listens any more once the picture is made.
        let _ = sender.send(());
    });
    receiver
}

fn wait_for_results(app: &mut App, answers: &Receiver<()>) -> Result<(), PictureError> {
    let start = Instant::now();
    loop {
        frame(app);
        if is_complete(app.world()) {
            return Ok(());
        }
        if start.elapsed() > PATIENCE {
            return Err(PictureError::NoResults);
        }
        if is_reading(app.world()) {
            // The next frame receives what was read.
            let _ = answers.recv_timeout(if is_searching(app.world()) { LONG_NAP } else { NAP });
        }
        // Painting more frames would take the cores from the solver.
        while start.elapsed() < PATIENCE && !is_idle(app.world()) {
            let _ = answers.recv_timeout(NAP);
        }
    }
}

/// Whether tables, rooms, designs or places are on their way to the panels.
fn is_reading(world: &bevy::prelude::World) -> bool {
    let is_field = world.get_resource::<FieldState>();
    let is_decide = world.get_resource::<DecideState>();
    is_field.is_some_and(FieldState::is_busy)
        || is_decide.is_some_and(DecideState::is_busy)
        || is_searching(world)
}

fn is_searching(world: &bevy::prelude::World) -> bool {
    world.get_resource::<PlacementSearch>().is_some_and(|search| search.running.is_some())
}

fn is_idle(world: &bevy::prelude::World) -> bool {
    world.get_resource::<SolverHandle>().is_none_or(|handle| handle.solver.is_idle())
        && world.get_resource::<MetalSolver>().is_none_or(MetalSolver::is_idle)
        && layers::registry::are_idle(world)
        && decide::is_idle(world)
        && world.get_resource::<Missed>().is_none_or(Missed::is_idle)
}

fn is_complete(world: &bevy::prelude::World) -> bool {
    let results = world.resource::<Results>();
    let has_slice =
        results.slice.is_some() || !world.resource::<OpenWorld>().0.document.view().layers.slice;
    let has_figures = results.study.is_some() && results.pose.is_some();
    let is_read = !is_reading(world)
        && world.resource::<Messages<FieldRequest>>().is_empty()
        && world.resource::<Messages<DecideRequest>>().is_empty()
        && world.resource::<Messages<PlacementSearchRequest>>().is_empty();
    let is_answered = world.get_resource::<Missed>().is_none_or(Missed::is_answered);
    let is_room_solved = world.resource::<OpenWorld>().0.awaited_metal().is_none();
    is_read
        && is_room_solved
        && is_answered
        && is_idle(world)
        && (results.problem.is_some() || has_figures && has_slice)
}

fn frame(app: &mut App) {
    app.update();
    // A device that is lost shows as a picture that never comes.
    let _ =
        app.world().resource::<RenderDevice>().wgpu_device().poll(PollType::wait_indefinitely());
}

fn encode(image: Image) -> Result<Vec<u8>, PictureError> {
    let error = |error: &dyn std::fmt::Display| PictureError::Encode(error.to_string());
    let picture = image.try_into_dynamic().map_err(|e| error(&e))?.to_rgb8();
    let mut bytes = Cursor::new(Vec::new());
    let format =
        ImageFormat::Png.as_image_crate_format().ok_or_else(|| error(&"this build has no PNG"))?;
    picture.write_to(&mut bytes, format).map_err(|e| error(&e))?;
    Ok(bytes.into_inner())
}
