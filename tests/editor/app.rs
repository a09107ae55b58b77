//! A small world of its own, and an App with the fewest plugins.

use crate::support::studies;
use bevy::asset::AssetPlugin;
use bevy::input::InputPlugin;
use bevy::mesh::MeshPlugin;
use bevy::picking::DefaultPickingPlugins;
use bevy::prelude::*;
use bevy::window::{FileDragAndDrop, RequestRedraw, WindowPlugin};
use nalgebra::{Point3, Vector3};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use tempfile::TempDir;
use trackwright_design::{
    CrfPlacement, Design, DesignBody, Document, Origin, Procedure, Target, ToolPlacement, View,
};
use trackwright_editor::StatePlugin;
use trackwright_editor::document::apply::DocumentPlugin;
use trackwright_editor::document::requests::{EditRequest, OpenWorld, ViewRequest};
use trackwright_editor::layers::motion::MotionPlugin;
use trackwright_editor::layers::registry::{LayerInfo, LayerRegistry};
use trackwright_editor::layers::slice::SlicePlugin;
use trackwright_editor::layers::{GlyphsPlugin, LayersPlugin};
use trackwright_editor::runner::diagnostics::DiagnosticsPlugin;
use trackwright_editor::runner::solve::{SolverHandle, SolverPlugin};
use trackwright_editor::runner::wake::Waker;
use trackwright_editor::scene::ScenePlugin;
use trackwright_editor::scene::materials::glow::GlowMaterial;
use trackwright_editor::scene::materials::lit::LitMaterial;
use trackwright_editor::scene::materials::map::MapMaterial;
use trackwright_editor::scene::materials::paint::PaintMaterial;
use trackwright_editor::shell::dialogs::{Dialog, Dialogs, ErrorDialog};
use trackwright_editor::shell::window::ViewportRect;
use trackwright_editor::viewport::ball_handle::HandlePlugin;
use trackwright_editor::viewport::camera::CameraPlugin;
use trackwright_editor::viewport::camera_gestures::CameraGesturesPlugin;
use trackwright_editor::viewport::gizmo::GizmoPlugin;
use trackwright_editor::viewport::overlay::OverlayPlugin;
use trackwright_editor::viewport::picking::PickPlugin;
use trackwright_editor::viewport::pointer_hint::PointerHintPlugin;
use trackwright_editor::viewport::sensor_drag::DragPlugin;
use trackwright_editor::viewport::tool::ToolPlugin;
use trackwright_editor::workspaces::study::StudyPlugin;
use trackwright_field::Environment;
use trackwright_geometry::pose::Pose;
use trackwright_geometry::volume::Volume;
use trackwright_simulation::{
    AxisRange, CancelToken, Metric, Mode, Motion, Mounting, Requirement, RigidBody, Scenario,
    Sensor, Study, study,
};

/// Writes a room, whatever was there.
pub fn write_environment(file: &std::path::Path, room: &Environment) {
    let files = trackwright_project::Files::overwriting(true);
    let output = files.output(file).unwrap();
    output.write_environment(room).unwrap();
}

/// A room whose error grows along x, in the Aurora cube.
pub fn environment() -> Environment {
    let bounds = Volume::AuroraCube.bounds();
    let coefficients = (0..8)
        .map(|k: usize| {
            let x = (k >> 2) as f64;
            [0.4 + 2.0 * x, -0.3, 0.2 * x, 0.002, 0.004 * x, 0.0]
        })
        .collect();
    let model = studies::one_direction(1, bounds, coefficients);
    Environment { volume: Some(Volume::AuroraCube), ..Environment::of_model("Test room", model) }
}

fn sensor(name: &str, position: [f64; 3], axis: Vector3<f64>) -> Sensor {
    Sensor { name: name.into(), ..studies::five(position, axis.into()) }
}

fn body(name: &str, tip: Option<Point3<f64>>, sensors: Vec<Sensor>) -> DesignBody {
    DesignBody {
        reference: format!("{name}.body.ron"),
        mesh: None,
        rigid: RigidBody { name: name.into(), tip_in_body: tip, sensors },
        definition: None,
        mounting: Mounting::default(),
    }
}

pub fn design() -> Design {
    let range = |min, max, step| Some(AxisRange { min, max, step });
    Design {
        name: "Test design".into(),
        environment: "room.env.ron".into(),
        room_metal: None,
        crf: Some(CrfPlacement {
            body: body(
                "Head frame",
                None,
                vec![
                    sensor("left", [-60.0, 0.0, 0.0], Vector3::x()),
                    sensor("right", [60.0, 0.0, 0.0], Vector3::y()),
                    sensor("top", [0.0, 50.0, 20.0], Vector3::z()),
                ],
            ),
            tracker_from_crf: Pose::translation(-40.0, 0.0, -300.0),
            targets: vec![Target {
                name: "left sinus".into(),
                position_in_crf: Point3::new(20.0, -40.0, -60.0),
            }],
            motion: None,
            requirement: None,
        }),
        tool: ToolPlacement {
            body: body(
                "Pointer",
                Some(Point3::origin()),
                vec![
                    sensor("shaft", [0.0, 0.0, 120.0], Vector3::z()),
                    sensor("grip", [12.0, 0.0, 150.0], Vector3::x()),
                ],
            ),
            crf_from_tool: Pose::translation(0.0, 0.0, 30.0),
        },
        motion: Some(Motion {
            x: range(-50.0, 50.0, 50.0),
            rz: range(-90.0, 90.0, 45.0),
            ..Motion::default()
        }),
        orientation_weight_mm: None,
        requirement: Some(Requirement::at_most([(Metric::TIP_RMS, 1.0)])),
        procedure: Procedure::default(),
        anatomy: Vec::new(),
        slides: Vec::new(),
    }
}

pub fn world() -> trackwright_project::World {
    let document = Document::new(design(), View::default(), Origin::File("test.design.ron".into()));
    trackwright_project::World::new(document, Arc::new(environment()), None, None)
}

/// An App with the document and the solver, without window or renderer.
pub fn create_app() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, StatePlugin, DocumentPlugin, SolverPlugin))
        .insert_resource(OpenWorld(world()));
    listen(&mut app);
    app
}

/// Every layer that registers, in the order of the list.
pub fn layers() -> Vec<LayerInfo> {
    let mut app = create_scene_app_with(|app| {
        app.add_plugins((LayersPlugin, OverlayPlugin));
    });
    app.world_mut().remove_resource::<LayerRegistry>().unwrap().layers
}

/// The open design's document.
pub fn document(app: &App) -> &Document {
    &app.world().resource::<OpenWorld>().0.document
}

/// The open design in its room.
pub fn scenario(app: &App) -> Scenario {
    let world = &app.world().resource::<OpenWorld>().0;
    trackwright_project::resolve(world.document.design(), &world.environment)
}

/// All that a study of its own states of a scenario.
pub fn studied(scenario: &Scenario, mode: &Mode) -> Study {
    study(scenario, mode, &CancelToken::default(), None).unwrap()
}

/// The open dialog, where it is of this kind.
pub fn dialog<D: Dialog>(app: &App) -> Option<&D> {
    app.world().resource::<Dialogs>().get()
}

/// The open dialog, which is an error's.
#[track_caller]
pub fn error(app: &App) -> &ErrorDialog {
    let current = &app.world().resource::<Dialogs>().current;
    dialog(app).unwrap_or_else(|| panic!("no error, {current:?}"))
}

pub fn close_dialog(app: &mut App) {
    app.world_mut().resource_mut::<Dialogs>().current = None;
}

/// A file in a folder of the test's own.
pub fn write(folder: &TempDir, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
    let file = folder.path().join(name);
    std::fs::create_dir_all(file.parent().unwrap()).unwrap();
    std::fs::write(&file, content).unwrap();
    file
}

/// Changes the open design's view, and lets the solver follow.
pub fn change_view(app: &mut App, change: impl FnOnce(&mut View)) {
    let mut view = document(app).view().clone();
    change(&mut view);
    app.world_mut().write_message(ViewRequest::Set(view));
    settle(app);
}

/// Lets tests wait for whatever wakes the window.
pub fn listen(app: &mut App) {
    let (sender, wakes) = channel();
    app.init_resource::<Waker>();
    app.world().resource::<Waker>().wake_with(move || {
        // A test that has ended no longer listens.
        let _ = sender.send(());
    });
    app.insert_resource(Wakes(Mutex::new(wakes)));
}

/// An App with the built-in world in a window that nothing paints: scene, glyphs, picking, drags.
pub fn create_scene_app() -> App {
    create_scene_app_with(|_| ())
}

/// The same with more plugins.
pub fn create_scene_app_with(add: impl FnOnce(&mut App)) -> App {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        TransformPlugin,
        AssetPlugin::default(),
        MeshPlugin,
        InputPlugin,
        WindowPlugin { exit_condition: bevy::window::ExitCondition::DontExit, ..default() },
        DefaultPickingPlugins,
    ))
    .init_asset::<Image>()
    .init_asset::<LitMaterial>()
    .init_asset::<MapMaterial>()
    .init_asset::<PaintMaterial>()
    .init_asset::<GlowMaterial>()
    .init_asset::<GizmoAsset>()
    .add_message::<RequestRedraw>()
    .add_plugins((
        StatePlugin,
        DocumentPlugin,
        SolverPlugin,
        (CameraPlugin, CameraGesturesPlugin),
        PickPlugin,
        DragPlugin,
        (GizmoPlugin, ToolPlugin, PointerHintPlugin),
        ScenePlugin,
        GlyphsPlugin,
        (HandlePlugin, MotionPlugin, SlicePlugin),
        StudyPlugin,
        DiagnosticsPlugin,
    ))
    .insert_resource(ViewportRect { min: Vec2::new(240.0, 36.0), size: Vec2::new(900.0, 700.0) })
    .insert_resource(OpenWorld(
        trackwright_project::open_builtin(trackwright_project::DEFAULT_BUILTIN).unwrap(),
    ));
    listen(&mut app);
    add(&mut app);
    app.finish();
    app.cleanup();
    app
}

/// How many entities have a name.
pub fn named(app: &mut App, name: &str) -> usize {
    let world = app.world_mut();
    let mut names = world.query::<&Name>();
    names.iter(world).filter(|n| n.as_str() == name).count()
}

/// What the window would be woken with.
#[derive(Resource)]
struct Wakes(Mutex<Receiver<()>>);

/// Drops a file onto the window.
pub fn drop_on_window(app: &mut App, file: &Path) {
    let (window, path_buf) = (Entity::PLACEHOLDER, file.to_owned());
    app.world_mut().write_message(FileDragAndDrop::DroppedFile { window, path_buf });
}

/// Waits for work that has to come to something, and shows it.
#[track_caller]
pub fn wait_for_work(app: &mut App) {
    let wakes = app.world().resource::<Wakes>().0.lock().unwrap();
    wakes.recv_timeout(Duration::from_secs(300)).expect("something of what is under way");
    drop(wakes);
    app.update();
}

/// Waits until the solver has an answer, or so long.
pub fn wait_for_answer(app: &App, at_most: Duration) {
    let wakes = app.world().resource::<Wakes>().0.lock().unwrap();
    // Nothing within the time is what the caller allows for.
    let _ = wakes.recv_timeout(at_most);
}

pub fn request(app: &mut App, request: EditRequest) {
    app.world_mut().write_message(request);
}

/// Updates until the solver has nothing left to do and its last answer is shown.
pub fn settle(app: &mut App) {
    let start = Instant::now();
    app.update();
    while !app.world().resource::<SolverHandle>().solver.is_idle() {
        assert!(start.elapsed() < Duration::from_secs(30), "never idle");
        wait_for_answer(app, Duration::from_millis(2));
        app.update();
    }
    app.update();
}
