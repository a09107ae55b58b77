//! The window's own measurement, one phase after the other: start, rest, orbit.

use crate::app;
use crate::app::measure::error::MeasureError;
use crate::app::measure::presented::{Presented, PresentedPlugin};
use crate::app::measure::process::{Started, processor_time};
use crate::app::measure::worlds::{order_four, tube, with_tool_mesh};
use crate::document::requests::OpenWorld;
use crate::document::state::WorldGeneration;
use crate::layers;
use crate::layers::slice_picture;
use crate::runner::results::Results;
use crate::runner::solve::SolverHandle;
use crate::runner::wake::Waker;
use crate::viewport::camera_gestures::Turntable;
use bevy::diagnostic::DiagnosticsStore;
use bevy::prelude::*;
use bevy::render::diagnostic::RenderDiagnosticsPlugin;
use bevy::render::renderer::RenderAdapterInfo;
use bevy::window::RequestRedraw;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use trackwright_design::view::{ArrowsView, View};
use trackwright_project::World as StoreWorld;

/// Size of the window, logical pixels.
const SIZE: [u32; 2] = [1280, 720];

/// How long the window rests, and how long it is orbited.
const REST: Duration = Duration::from_secs(5);
const ORBIT: Duration = Duration::from_secs(6);

/// From the first figures to the rest that is measured: what was begun comes to an end.
const CALM: Duration = Duration::from_secs(2);

/// A tube of a million triangles.
const TUBE: [u32; 2] = [1000, 500];

/// More than ten thousand.
pub const SHOWN_ARROWS: usize = ArrowsView::PER_SIDE.end().pow(3);

/// How far the pointer would have moved between two frames, pixels.
const TURN_PX: [f64; 2] = [4.0, 0.0];

/// What the window came to.
#[derive(Clone, Debug, Default)]
pub struct WindowFigures {
    pub adapter: String,
    pub is_software: bool,
    pub first_frame: Duration,
    pub rest: Period,
    pub orbit: Period,
    /// Of the slice's picture.
    pub slice_texels: [usize; 2],
    pub triangles: usize,
    /// Time on the adapter of each pass of such a frame, milliseconds; none where it keeps no time.
    pub passes_ms: Vec<(String, f64)>,
}

/// What happened in a period of time.
#[derive(Clone, Copy, Debug, Default)]
pub struct Period {
    pub lasted: Duration,
    pub frames: u64,
    /// Of all threads; `None` where the system does not report it.
    pub processor: Option<Duration>,
}

/// Where a period began.
#[derive(Clone, Copy, Debug)]
struct Since {
    at: Instant,
    frames: u64,
    processor: Option<Duration>,
}

impl Since {
    fn now(presented: &Presented) -> Self {
        Self { at: Instant::now(), frames: presented.frames().count, processor: processor_time() }
    }

    fn until_now(self, presented: &Presented) -> Period {
        Period {
            lasted: self.at.elapsed(),
            frames: presented.frames().count - self.frames,
            processor: processor_time()
                .zip(self.processor)
                .map(|(now, then)| now.saturating_sub(then)),
        }
    }
}

/// What is going on.
#[derive(Clone, Debug)]
enum Phase {
    /// Until tool and figures are on the screen.
    Start,
    Rest(Arc<Mutex<Option<Period>>>),
    /// Everything at once is being computed.
    Prepare,
    Orbit(Since),
}

#[derive(Resource)]
struct Measurement {
    phase: Phase,
    started: Started,
    figures: WindowFigures,
    whole: Arc<Mutex<Option<WindowFigures>>>,
}

/// Opens the window, measures, and closes it.
pub fn run(started: Started) -> Result<WindowFigures, MeasureError> {
    let whole = Arc::new(Mutex::new(None));
    let world = trackwright_project::open_builtin(trackwright_project::DEFAULT_BUILTIN)?;
    let measurement = Measurement {
        phase: Phase::Start,
        started,
        figures: WindowFigures::default(),
        whole: Arc::clone(&whole),
    };
    let app = app::window(world, SIZE, |app| {
        app.add_plugins((PresentedPlugin, RenderDiagnosticsPlugin))
            .insert_resource(measurement)
            .add_systems(Last, go_on);
    });
    app::run(app)?;
    let figures = whole.lock().ok().and_then(|mut figures| figures.take());
    figures.ok_or(MeasureError::Closed)
}

/// Everything that can be shown at once.
fn everything() -> Result<StoreWorld, MeasureError> {
    let [around, along] = TUBE;
    let mut world = with_tool_mesh(&order_four()?, tube(around, along));
    let mut view: View = world.document.view().clone();
    view.layers.slice = true;
    view.layers.arrows = true;
    view.arrows.per_side = *ArrowsView::PER_SIDE.end();
    world.document.set_view(view);
    Ok(world)
}

fn go_on(world: &mut World) {
    // It comes back unless everything is measured.
    let Some(mut measurement) = world.remove_resource::<Measurement>() else {
        return;
    };
    match measurement.step(world) {
        Ok(true) => {
            if let Ok(mut whole) = measurement.whole.lock() {
                *whole = Some(measurement.figures);
            }
            world.write_message(AppExit::Success);
        }
        Ok(false) => world.insert_resource(measurement),
        Err(error) => {
            error!("{error}");
            world.write_message(AppExit::error());
        }
    }
}

impl Measurement {
    /// Whether that was the last one.
    fn step(&mut self, world: &mut World) -> Result<bool, MeasureError> {
        let presented = world.resource::<Presented>().clone();
        match &self.phase {
            Phase::Start => {
                if let Some(first) = presented.frames().first_with_figures {
                    self.figures.first_frame = self.started.until(first);
                    self.adapter(world);
                    self.phase = Phase::Rest(watch_rest(world, presented));
                } else if world.resource::<Results>().study.is_some() {
                    // The frame in question may be the last one for now.
                    world.write_message(RequestRedraw);
                }
            }
            Phase::Rest(period) => {
                let period = period.lock().ok().and_then(|period| *period);
                if let Some(period) = period {
                    self.figures.rest = period;
                    self.open(everything()?, world);
                    self.phase = Phase::Prepare;
                    world.write_message(RequestRedraw);
                }
            }
            Phase::Prepare => {
                world.write_message(RequestRedraw);
                if is_ready(world) {
                    if let Some(slice) = &world.resource::<Results>().slice {
                        self.figures.slice_texels = slice_picture::size(&slice.value);
                    }
                    world.insert_resource(Turntable(Some(TURN_PX)));
                    self.phase = Phase::Orbit(Since::now(&presented));
                }
            }
            Phase::Orbit(since) => {
                if since.at.elapsed() >= ORBIT {
                    self.figures.orbit = since.until_now(&presented);
                    self.figures.passes_ms = passes_ms(world);
                    return Ok(true);
                }
            }
        }
        Ok(false)
    }

    fn adapter(&mut self, world: &World) {
        if let Some(adapter) = world.get_resource::<RenderAdapterInfo>() {
            self.figures.adapter = adapter.name.clone();
            self.figures.is_software = adapter.device_type == wgpu::DeviceType::Cpu;
        }
    }

    fn open(&mut self, opened: StoreWorld, world: &mut World) {
        let tool = opened.mesh(trackwright_design::BodyRole::Tool);
        self.figures.triangles =
            tool.map_or(0, |mesh| mesh.parts.iter().map(|part| part.triangles.len()).sum());
        world.resource_mut::<OpenWorld>().0 = opened;
        world.resource_mut::<WorldGeneration>().0 += 1;
    }
}

/// Whether slice, arrows and figures are there.
fn is_ready(world: &World) -> bool {
    let revision = world.resource::<OpenWorld>().0.document.revision();
    let results = world.resource::<Results>();
    let has_figures = results.study.as_ref().is_some_and(|s| s.revision == revision);
    let is_solved =
        world.get_resource::<SolverHandle>().is_none_or(|handle| handle.solver.is_idle());
    has_figures && results.slice.is_some() && is_solved && layers::registry::are_idle(world)
}

/// Watches the window while nothing happens, from outside: the frame that would look is none that
/// a person causes. Wakes it when that is done.
#[expect(clippy::disallowed_methods, reason = "time is what is waited for")]
fn watch_rest(world: &mut World, presented: Presented) -> Arc<Mutex<Option<Period>>> {
    let waker = world.get_resource_or_init::<Waker>().clone();
    let found = Arc::new(Mutex::new(None));
    let result = Arc::clone(&found);
    std::thread::spawn(move || {
        std::thread::sleep(CALM);
        let since = Since::now(&presented);
        std::thread::sleep(REST);
        let period = since.until_now(&presented);
        if let Ok(mut result) = result.lock() {
            *result = Some(period);
        }
        waker.wake();
    });
    found
}

/// The adapter's own time of each pass.
fn passes_ms(world: &World) -> Vec<(String, f64)> {
    let Some(store) = world.get_resource::<DiagnosticsStore>() else {
        return Vec::new();
    };
    let mut passes: Vec<(String, f64)> = store
        .iter()
        .filter_map(|diagnostic| {
            let pass = diagnostic.path().as_str().strip_prefix("render/")?;
            let pass = pass.strip_suffix("/elapsed_gpu")?;
            Some((pass.replace('_', " "), diagnostic.average()?))
        })
        .collect();
    passes.sort_by(|a, b| b.1.total_cmp(&a.1));
    passes
}
