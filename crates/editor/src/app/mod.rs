//! Puts the editor together, for a window or for a picture.

pub mod film;
pub mod lost_device;
pub mod measure;
pub mod picture;
pub mod preflight;

use crate::EditorPlugins;
use crate::app::lost_device::Failure;
use crate::app::preflight::BACKENDS;
use crate::document::apply;
use crate::document::autosave::RecoveryFolder;
use crate::document::recent::RecentDesigns;
use crate::document::requests::OpenWorld;
use crate::runner::diagnostics::{Explain, ExplainLine};
use crate::runner::results::Results;
use crate::shell::egui_camera::EguiTarget;
use crate::shell::explain_controls::ExplainControls;
use crate::shell::preferences::Recalled;
use crate::shell::window::{Presentation, ViewportRect};
use crate::viewport::camera::SceneTarget;
use bevy::app::{AppExit, TerminalCtrlCHandlerPlugin};
use bevy::camera::RenderTarget;
use bevy::light::cluster::GlobalClusterSettings;
use bevy::log::{Level, LogPlugin};
use bevy::pbr::PbrPlugin;
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::pipelined_rendering::PipelinedRenderingPlugin;
use bevy::render::render_resource::TextureFormat;
use bevy::render::settings::{RenderCreation, WgpuSettings};
use bevy::window::{ExitCondition, PrimaryWindow, WindowResolution};
use bevy::winit::{UpdateMode, WinitPlugin, WinitSettings};
use bevy_egui::EguiPlugin;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use trackwright_design::Origin;
use trackwright_project::World;

/// Size of a new window, logical pixels.
const WINDOW_SIZE: [u32; 2] = [1440, 900];

/// Below this the panels leave no room for the scene.
const LEAST_SIZE: [f32; 2] = [960.0, 600.0];

/// Why the editor ended otherwise than by closing its window.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum EditorError {
    #[error("{0}; what was not saved is offered at the next start")]
    Failed(String),
    /// Where there is no folder to keep it in.
    #[error("{0}; what was not saved is lost: there is no folder for recovery files")]
    FailedUnkept(String),
    #[error("the editor failed with code {0}")]
    Code(u8),
}

/// Opens the editor and stays until its window closes. Call
/// [`preflight::window`] first: Bevy panics without a display. `explain` gets what is drawn and
/// computed, with names and places of the controls if requested.
///
/// # Errors
/// See [`EditorError`].
pub fn edit(
    world: World,
    explain: Option<ExplainLine>,
    do_explain_controls: bool,
) -> Result<(), EditorError> {
    let file = match world.document.origin() {
        Origin::File(file) => Some(file.clone()),
        Origin::BuiltIn(_) => None,
    };
    let recalled = trackwright_project::state_folder().map(Recalled::in_folder);
    let left = recalled.as_ref().map(|recalled| &recalled.preferences);
    let size = left.and_then(|left| left.window).unwrap_or(WINDOW_SIZE);
    let is_maximised = left.is_some_and(|left| left.is_maximised);
    let missing = apply::what_is_missing(&world);
    run(window(world, size, |app| {
        app.insert_resource(missing);
        if let Some(folder) = trackwright_project::recovery_folder() {
            app.insert_resource(RecoveryFolder(folder));
        }
        if let Some(folder) = trackwright_project::state_folder() {
            let mut recent = RecentDesigns::in_folder(folder);
            if let Some(file) = file {
                recent.remember(&file);
            }
            app.insert_resource(recent);
        }
        if let Some(recalled) = recalled {
            app.insert_resource(recalled);
        }
        if is_maximised {
            app.add_systems(Startup, maximise);
        }
        if let Some(line) = explain {
            app.insert_resource(Explain(line));
        }
        if do_explain_controls {
            app.init_resource::<ExplainControls>();
        }
    }))
}

/// Runs until the window closes.
///
/// A device that goes away within a frame makes the renderer panic before its own error handler
/// receives it, on a thread of its own where frames overlap. The app is dropped on the way here,
/// which writes what is unsaved.
pub(crate) fn run(mut app: App) -> Result<(), EditorError> {
    let failure = app.world_mut().get_resource_or_init::<Failure>().clone();
    failure.keep_panics();
    let failed = match app.world().contains_resource::<RecoveryFolder>() {
        true => EditorError::Failed,
        false => EditorError::FailedUnkept,
    };
    let exit = catch_unwind(AssertUnwindSafe(|| app.run()));
    match (exit, failure.reason()) {
        (Ok(AppExit::Success), _) => Ok(()),
        (_, Some(reason)) => Err(failed(reason)),
        (Ok(AppExit::Error(code)), None) => Err(match failure.panic() {
            Some(reason) => failed(reason),
            None => EditorError::Code(code.get()),
        }),
        (Err(panic), None) => Err(failed(lost_device::panic_in_words(&*panic))),
    }
}

/// An app with a window of a size in logical pixels; `prepare` adds what the editor's own plugins
/// are to find. By itself it leaves nothing on the disk.
pub(crate) fn window(
    world: World,
    [width, height]: [u32; 2],
    prepare: impl FnOnce(&mut App),
) -> App {
    let mut app = App::new();
    let title = apply::title(&world.document, &Results::default());
    let window = WindowPlugin {
        primary_window: Some(Window {
            title,
            name: Some("trackwright".to_owned()),
            resolution: WindowResolution::new(width, height),
            resize_constraints: bevy::window::WindowResizeConstraints {
                min_width: LEAST_SIZE[0],
                min_height: LEAST_SIZE[1],
                ..default()
            },
            ..default()
        }),
        // The document offers to save first.
        close_when_requested: false,
        exit_condition: ExitCondition::OnPrimaryClosed,
        ..default()
    };
    let plugins = DefaultPlugins
        .set(window)
        .set(render())
        .set(meshes())
        .set(log())
        // It answers Ctrl+C in the next frame, and a window that sleeps has none.
        .disable::<TerminalCtrlCHandlerPlugin>();
    app.add_plugins(plugins)
        // Sleeps until something happens, and never ticks by itself.
        .insert_resource(WinitSettings {
            focused_mode: UpdateMode::reactive_low_power(Duration::MAX),
            unfocused_mode: UpdateMode::reactive_low_power(Duration::MAX),
        });
    prepare(&mut app);
    add_editor(&mut app, world, Presentation::default());
    app
}

fn maximise(window: Option<Single<&mut Window, With<PrimaryWindow>>>) {
    if let Some(mut window) = window {
        window.set_maximized(true);
    }
}

/// An app without a window that paints into an image, to be driven by hand; `prepare` as for
/// [`window`].
pub(crate) fn offscreen(
    world: World,
    size: UVec2,
    has_panels: bool,
    prepare: impl FnOnce(&mut App),
) -> (App, Handle<Image>) {
    let mut app = App::new();
    let window =
        WindowPlugin { primary_window: None, exit_condition: ExitCondition::DontExit, ..default() };
    let plugins = DefaultPlugins
        .set(window)
        .set(render())
        .set(meshes())
        // It panics where there is no display.
        .disable::<WinitPlugin>()
        // It would take Ctrl+C and a request to end for the rest of the process, and answer them in
        // a runner that an app driven by hand does not have.
        .disable::<TerminalCtrlCHandlerPlugin>()
        // One frame after the other, so that the last one requested is the one captured.
        .disable::<PipelinedRenderingPlugin>();
    app.add_plugins(match HAS_LOG.swap(true, Ordering::Relaxed) {
        false => plugins.set(log()),
        true => plugins.disable::<LogPlugin>(),
    });
    let image = Image::new_target_texture(size.x, size.y, TextureFormat::Rgba8UnormSrgb, None);
    let image = app.world_mut().resource_mut::<Assets<Image>>().add(image);
    let target = RenderTarget::Image(image.clone().into());
    app.insert_resource(SceneTarget(target.clone())).insert_resource(EguiTarget(target));
    if !has_panels {
        app.insert_resource(ViewportRect { min: Vec2::ZERO, size: size.as_vec2() });
    }
    let presentation = Presentation { panels: has_panels, window: false };
    prepare(&mut app);
    add_editor(&mut app, world, presentation);
    (app, image)
}

fn add_editor(app: &mut App, world: World, presentation: Presentation) {
    app.add_plugins(EguiPlugin::default())
        .insert_resource(presentation)
        .insert_resource(OpenWorld(world))
        .add_plugins(EditorPlugins)
        .add_systems(PreStartup, without_clusters)
        // What goes wrong in one system is reported and does not end a person's work.
        .set_error_handler(bevy::ecs::error::warn);
}

fn render() -> RenderPlugin {
    RenderPlugin {
        render_creation: RenderCreation::Automatic(Box::new(WgpuSettings {
            backends: Some(BACKENDS),
            ..default()
        })),
        // Otherwise things stay missing until the next event: nothing wakes a sleeping window
        // when a pipeline is ready.
        synchronous_pipeline_compilation: true,
        ..default()
    }
}

/// Without what only lamps and shadows need: the scene has none, and a software renderer pays for
/// each pass that finds nothing to do.
fn meshes() -> PbrPlugin {
    PbrPlugin { prepass_enabled: false, add_default_deferred_lighting_plugin: false, ..default() }
}

/// No lamps, nothing to sort into clusters.
fn without_clusters(mut settings: ResMut<GlobalClusterSettings>) {
    settings.gpu_clustering = None;
}

/// Whether an App has set up the log, of which a program has one however many pictures it paints.
static HAS_LOG: AtomicBool = AtomicBool::new(false);

fn log() -> LogPlugin {
    LogPlugin {
        level: Level::WARN,
        // Drivers and window systems log more than anyone can act on.
        filter: "wgpu=error,naga=error,winit=error,bevy_winit=error,bevy_render::renderer=error,bevy_egui=error,calloop=error,rfd=off"
            .to_owned(),
        ..default()
    }
}
