//! Metal in the room: added by its command, listed, moved by its handles, changed in the inspector.

use super::app::{create_scene_app_with, environment, named, settle, wait_for_work};
use super::harness::{panel, use_panel};
use super::meshes::box_obj;
use super::pointer::SimulatedPointer;
use bevy::picking::pointer::PointerButton;
use bevy::prelude::*;
use bevy_egui::egui;
use egui_kittest::kittest::Queryable;
use nalgebra::Point3;
use std::sync::Arc;
use trackwright_design::{Design, Edit, MetalEdit, Thing, View};
use trackwright_editor::document::body_files::BodyFilesPlugin;
use trackwright_editor::document::commands::{ADD_METAL, ADD_METAL_MESH, DocumentCommandsPlugin};
use trackwright_editor::document::meshes::MeshesPlugin;
use trackwright_editor::document::requests::MeshRequest;
use trackwright_editor::document::requests::{EditRequest, OpenWorld, ViewRequest};
use trackwright_editor::document::selection::{Hovered, Selected, Selection};
use trackwright_editor::runner::metal::MetalPlugin;
use trackwright_editor::runner::results::Results;
use trackwright_editor::scene::generator::CoilLines;
use trackwright_editor::scene::metal::MetalRoot;
use trackwright_editor::shell::commands::{CommandsPlugin, RunCommand};
use trackwright_editor::shell::window::{PointerHint, ViewportRect, Workspace};
use trackwright_editor::viewport::ball_handle::BallHandle;
use trackwright_editor::viewport::camera::OrbitRig;
use trackwright_editor::viewport::commands::ViewportCommandsPlugin;
use trackwright_editor::viewport::gizmo::gizmo_of;
use trackwright_editor::viewport::sensor_commands::SensorCommand;
use trackwright_editor::workspaces::design::actions::DesignAction;
use trackwright_editor::workspaces::design::metal_distance::MetalDistancePlugin;
use trackwright_editor::workspaces::design::metal_distance_mark::LeastDistanceMark;
use trackwright_editor::workspaces::design::metal_facts_ui::{MetalFacts, metal_facts_ui};
use trackwright_editor::workspaces::design::metal_ui::metal_ui;
use trackwright_editor::workspaces::design::outliner::outliner_ui;
use trackwright_editor::workspaces::design::outliner_row::OutlinerView;
use trackwright_field::generator::Generator;
use trackwright_geometry::gizmo::Handle;
use trackwright_geometry::orbit::Axis;
use trackwright_geometry::pose::Pose;
use trackwright_metal::new_object::NewShape;
use trackwright_metal::setup::{
    MaterialTolerance, MetalObject, ObjectMaterial, ObjectShape, RoomMetal,
};
use trackwright_project::MeshOwner;
use trackwright_simulation::{Metric, Requirement, Verdict};

fn metal_app() -> App {
    metal_app_with(|_| ())
}

fn metal_app_with(add: impl FnOnce(&mut App)) -> App {
    let mut app = create_scene_app_with(|app| {
        let commands = (CommandsPlugin, DocumentCommandsPlugin, ViewportCommandsPlugin);
        app.add_plugins((MetalPlugin, MeshesPlugin, BodyFilesPlugin, commands));
        add(app);
    });
    settle_metal(&mut app);
    app
}

/// Updates until the metal is solved for and the study of it is shown.
#[track_caller]
fn settle_metal(app: &mut App) {
    settle(app);
    while app.world().resource::<OpenWorld>().0.awaited_metal().is_some() {
        wait_for_work(app);
        settle(app);
    }
    // The metal may have been answered in the last frame.
    settle(app);
}

fn run(app: &mut App, name: &'static str) {
    app.world_mut().write_message(RunCommand(name));
    // The command writes an edit, which is applied in the frame after.
    app.update();
    settle_metal(app);
}

fn edit(app: &mut App, edit: MetalEdit) {
    app.world_mut().write_message(EditRequest::Apply(Edit::Metal(edit)));
    settle_metal(app);
}

fn objects(app: &App) -> Vec<MetalObject> {
    let design = app.world().resource::<OpenWorld>().0.document.design();
    design.room_metal.as_ref().map_or_else(Vec::new, |metal| metal.objects.clone())
}

/// The camera glides to what is selected, and is there.
fn frame_selection(app: &mut App) {
    app.world_mut().write_message(ViewRequest::FrameSelection);
    app.update();
    while app.world().resource::<OrbitRig>().is_gliding() {
        app.update();
    }
    settle_metal(app);
}

fn tip_rms_mm(app: &App) -> Option<f64> {
    let results = app.world().resource::<Results>();
    Some(results.study.as_ref()?.value.figures.get(Metric::TIP_RMS)?.value)
}

/// A plate with few triangles, so that tests are quick, where it disturbs the volume.
fn plate_app() -> App {
    with_plate(metal_app())
}

fn with_plate(mut app: App) -> App {
    run(&mut app, ADD_METAL[0].1.name);
    let object = objects(&app)[0].clone();
    let near = Pose::translation(380.0, 0.0, -250.0);
    let object = MetalObject { tracker_from_object: near, most_triangles: 200, ..object };
    edit(&mut app, MetalEdit::Set { index: 0, object: Box::new(object) });
    app
}

/// A room of these objects, for panels.
fn design(objects: Vec<MetalObject>) -> Design {
    let empty = RoomMetal::empty(Generator::planar_nine());
    let metal = RoomMetal { objects, ..empty };
    Design { room_metal: Some(Arc::new(metal)), ..super::app::design() }
}

fn plate() -> MetalObject {
    MetalObject {
        name: "plate".to_owned(),
        shape: NewShape::Plate.shape(),
        material: ObjectMaterial::Named("aluminium"),
        tracker_from_object: Pose::translation(400.0, 0.0, -300.0),
        most_triangles: 1000,
        tolerance: MaterialTolerance::default(),
    }
}

#[test]
fn a_plate_is_added_and_removed_by_commands() {
    let mut app = metal_app();
    let before = tip_rms_mm(&app).unwrap();
    run(&mut app, ADD_METAL[0].1.name);
    let [added] = &objects(&app)[..] else { panic!("{:?}", objects(&app)) };
    assert_eq!((added.name.as_str(), &added.shape), ("plate", &NewShape::Plate.shape()));
    let selected = |app: &App| app.world().resource::<Selection>().primary();
    assert_eq!(selected(&app), Some(Selected::Metal(0)));
    let world = &app.world().resource::<OpenWorld>().0;
    assert!(world.metal_problem().is_none() && world.metal_report().is_some());
    assert_ne!(tip_rms_mm(&app).unwrap(), before);
    assert_eq!(named(&mut app, "metal plate"), 1);
    run(&mut app, ADD_METAL[2].1.name);
    assert_eq!(selected(&app), Some(Selected::Metal(1)));
    run(&mut app, SensorCommand::Remove.command().name);
    assert_eq!((objects(&app).len(), selected(&app)), (1, None));
    for _ in 0..3 {
        app.world_mut().write_message(EditRequest::Undo);
        settle_metal(&mut app);
    }
    assert!(objects(&app).is_empty());
    assert_eq!(named(&mut app, "metal plate"), 0);
    assert_eq!(tip_rms_mm(&app), Some(before));
}

#[test]
fn dragging_metal_by_its_handle_changes_figures() {
    let mut pointer = SimulatedPointer { app: plate_app() };
    pointer.select(Some(Selected::Metal(0)));
    let app = &mut pointer.app;
    // What the camera sees has the plate in its middle.
    frame_selection(app);
    let (before, far_mm) = (pointer.design(), tip_rms_mm(&pointer.app).unwrap());
    let document = &pointer.resource::<OpenWorld>().0.document;
    let selection = pointer.resource::<Selection>();
    let shown = gizmo_of(document.design(), document.view(), selection, default()).unwrap();
    assert_eq!(shown.gizmo.handles, Handle::ALL);
    let rig = pointer.resource::<OrbitRig>();
    let arrows = [Axis::X, Axis::Y, Axis::Z].map(Handle::arrow);
    let usable = arrows.into_iter().find_map(|handle| {
        let grip = shown.gizmo.grip_px(handle, &rig.eye())?;
        Some((handle, grip))
    });
    let (handle, [x, y]) = usable.expect("a handle within reach");
    let project = |point: Point3<f64>| rig.camera.project(&point, rig.view_px).unwrap();
    let axis = shown.gizmo.axis(handle.axis).into_inner();
    let (from, to) =
        (project(shown.gizmo.pivot_mm()), project(shown.gizmo.pivot_mm() + axis * 10.0));
    let by = Vec2::new((to[0] - from[0]) as f32, (to[1] - from[1]) as f32).normalize() * 25.0;
    let at = pointer.resource::<ViewportRect>().min + Vec2::new(x as f32, y as f32);

    pointer.drag(at, by, PointerButton::Primary);
    let hint = pointer.resource::<PointerHint>().0.clone().unwrap();
    assert!(hint.contains("Esc takes the drag back") && hint.contains("figures follow"), "{hint}");
    pointer.release(at + by, PointerButton::Primary);
    settle_metal(&mut pointer.app);
    assert_eq!(pointer.undo_label().as_deref(), Some("Move plate"));
    let moved = objects(&pointer.app)[0].tracker_from_object.translation.vector;
    let was = before.metal_object(0).unwrap().tracker_from_object.translation.vector;
    assert!((moved - was).dot(&axis) > 1.0, "{moved}");
    assert!((moved - was).cross(&axis).norm() < 1e-9);
    assert_ne!(tip_rms_mm(&pointer.app).unwrap(), far_mm);
    pointer.request(EditRequest::Undo);
    settle_metal(&mut pointer.app);
    assert_eq!(pointer.design(), before);
    assert_eq!(tip_rms_mm(&pointer.app), Some(far_mm));

    pointer.drag(at, by, PointerButton::Primary);
    pointer.escape();
    assert_eq!(pointer.design(), before);
    pointer.release(at + by, PointerButton::Primary);
    assert_eq!(pointer.design(), before);
}

#[test]
fn metal_in_the_volumes_middle_has_no_figures() {
    let mut app = plate_app();
    let near_mm = tip_rms_mm(&app);
    let volume = app.world().resource::<OpenWorld>().0.bare_environment().volume;
    let middle = volume.expect("a measurement volume").bounds().center_mm();
    let tracker_from_object = Pose::translation(middle.x, middle.y, middle.z);
    edit(&mut app, MetalEdit::SetPose { index: 0, tracker_from_object });
    let problem = app.world().resource::<Results>().problem.clone();
    let expected = "plate is in the middle of the measurement volume";
    assert_eq!(problem.as_deref(), Some(expected));
    assert_eq!(tip_rms_mm(&app), None);
    let facts = MetalFacts::of(&app.world().resource::<OpenWorld>().0, 0).unwrap();
    assert_eq!((facts.problem.as_deref(), facts.report), (Some(expected), None));
    app.world_mut().write_message(EditRequest::Undo);
    settle_metal(&mut app);
    assert_eq!(app.world().resource::<Results>().problem, None);
    assert_eq!(tip_rms_mm(&app), near_mm);
}

#[test]
fn metal_is_hovered_and_selected_by_its_surface() {
    let mut pointer = SimulatedPointer { app: plate_app() };
    pointer.select(Some(Selected::Metal(0)));
    frame_selection(&mut pointer.app);
    // Without handles, which are before everything.
    pointer.select(None);
    let at_mm = objects(&pointer.app)[0].tracker_from_object * Point3::new(60.0, 60.0, 0.0);
    let rig = pointer.resource::<OrbitRig>();
    let [x, y] = rig.camera.project(&at_mm, rig.view_px).unwrap();
    let at = pointer.resource::<ViewportRect>().min + Vec2::new(x as f32, y as f32);
    pointer.move_to(at);
    pointer.app.update();
    pointer.app.update();
    assert_eq!(pointer.resource::<Hovered>().0, Some(Selected::Metal(0)));
    pointer.click(at);
    assert_eq!(pointer.resource::<Selection>().primary(), Some(Selected::Metal(0)));
    // What is hidden is neither drawn nor picked.
    pointer.select(None);
    super::app::change_view(&mut pointer.app, |view| {
        view.hidden.toggle(Thing::Metal("plate".to_owned()));
    });
    assert_eq!(named(&mut pointer.app, "metal plate"), 0);
    pointer.click(at);
    assert_ne!(pointer.resource::<Selection>().primary(), Some(Selected::Metal(0)));
}

#[test]
fn a_closed_mesh_becomes_metal() {
    let mut app = metal_app();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("block.obj");
    std::fs::write(&file, box_obj([80.0, 60.0, 40.0], "")).unwrap();
    app.world_mut().write_message(MeshRequest::load(MeshOwner::NewMetal, file));
    super::meshes::finish(&mut app);
    app.update();
    settle_metal(&mut app);
    let [block] = &objects(&app)[..] else { panic!("{:?}", objects(&app)) };
    assert_eq!(block.name, "block");
    assert!(matches!(block.shape, ObjectShape::Mesh(_)));
    let mut roots = app.world_mut().query::<&MetalRoot>();
    assert_eq!(roots.iter(app.world()).copied().collect::<Vec<_>>(), [MetalRoot(0)]);
}

#[test]
fn coils_are_drawn_where_the_room_states_them() {
    let mut app = metal_app();
    let coils = |app: &mut App| {
        let mut lines = app.world_mut().query::<&CoilLines>();
        lines.iter(app.world()).count()
    };
    let show = |app: &mut App, is_on| {
        super::app::change_view(app, |view| view.layers.generator = is_on);
    };
    // Those that the built-in room was measured with.
    show(&mut app, true);
    assert_eq!(coils(&mut app), 1);
    show(&mut app, false);
    assert_eq!(coils(&mut app), 0);
    // A room of polynomials has none until there is metal in it.
    app.insert_resource(OpenWorld(super::app::world()));
    show(&mut app, true);
    assert_eq!(coils(&mut app), 0);
    run(&mut app, ADD_METAL[2].1.name);
    assert_eq!(coils(&mut app), 1);
}

/// Where the mark of the least distance is.
fn least_distance_mm(app: &mut App) -> Option<Point3<f64>> {
    let world = app.world_mut();
    let mut marks = world.query_filtered::<&BallHandle, With<LeastDistanceMark>>();
    marks.iter(world).next().map(|ball| ball.at_mm)
}

#[test]
fn a_click_puts_metal_at_its_least_distance() {
    let mut app = with_plate(metal_app_with(|app| {
        app.add_plugins(MetalDistancePlugin);
    }));
    app.insert_resource(Workspace { has_gizmo: false, ..Workspace::NONE });
    // It may be nearer: half as much again is allowed.
    let results = app.world().resource::<Results>().study.as_ref().unwrap();
    let high_mm = results.value.figures.get(Metric::TIP_RMS).unwrap().high.unwrap();
    let limit = Requirement::at_most([(Metric::TIP_RMS, 1.5 * high_mm)]);
    app.world_mut().write_message(EditRequest::Apply(Edit::SetRequirement(Some(limit))));
    settle_metal(&mut app);
    frame_selection(&mut app);
    while least_distance_mm(&mut app).is_none() {
        wait_for_work(&mut app);
    }
    let (least_mm, before) = (least_distance_mm(&mut app).unwrap(), objects(&app)[0].clone());
    let nearer_mm = before.tracker_from_object.translation.vector - least_mm.coords;
    assert!(nearer_mm.norm() > 1.0, "{nearer_mm}");
    let rig = app.world().resource::<OrbitRig>();
    let view = app.world().resource::<ViewportRect>();
    let [x, y] = rig.camera.project(&least_mm, rig.view_px).unwrap();
    let at = view.min + Vec2::new(x as f32, y as f32);
    let mut pointer = SimulatedPointer { app };
    pointer.click(at);
    settle_metal(&mut pointer.app);
    let after = objects(&pointer.app)[0].clone();
    assert!((after.tracker_from_object.translation.vector - least_mm.coords).norm() < 1e-9);
    assert_eq!(after.tracker_from_object.rotation, before.tracker_from_object.rotation);
    let results = pointer.app.world().resource::<Results>().study.as_ref().unwrap();
    let verdict = results.value.figures.requirement.as_ref().map(|judged| judged.verdict);
    assert_eq!(verdict, Some(Verdict::Met));
    assert_eq!(least_distance_mm(&mut pointer.app), None);
}

#[test]
fn the_outliner_lists_metal() {
    let ball = MetalObject { name: "ball".to_owned(), ..plate() };
    let metal = design(vec![plate(), ball]);
    let (environment, view) = (environment(), View::default());
    let selection = Selection::default();
    let (mut harness, requests) = panel([300.0, 1300.0], |ui| {
        let view = OutlinerView::new(&metal, &environment, &view, &selection);
        outliner_ui(ui, &view)
    });
    for label in ["ball", "Add metal plate", "Add metal mesh…"] {
        harness.get_by_label(label).click();
        harness.run_steps(2);
    }
    let select = DesignAction::Select(Some(Selected::Metal(1)));
    let runs = [ADD_METAL[0].1.name, ADD_METAL_MESH.name].map(DesignAction::Run);
    for wanted in [select].into_iter().chain(runs) {
        assert!(requests.borrow().contains(&wanted), "{:?}", requests.borrow());
    }
    // A room without metal whose coils are not known has no such section.
    let bare = super::app::design();
    let (harness, _) = panel([300.0, 1300.0], |ui| {
        let view = OutlinerView::new(&bare, &environment, &view, &selection);
        outliner_ui(ui, &view)
    });
    assert!(harness.query_by_label("Add metal plate").is_none());
}

#[test]
fn metal_inputs_are_edits() {
    let design = design(vec![plate()]);
    let ui = |ui: &mut egui::Ui| {
        let mut actions = Vec::new();
        metal_ui(ui, &design, 0, &mut actions);
        actions
    };
    let requests = use_panel([300.0, 1300.0], ui, |harness| {
        let role = egui::accesskit::Role::ComboBox;
        harness.get_by_role_and_label(role, "material").click();
        harness.run_steps(3);
        harness.get_by_label("Copper").click();
        harness.run_steps(3);
        harness.get_by_label("Remove metal object").click();
    });
    let object = MetalObject { material: ObjectMaterial::Named("copper"), ..plate() };
    let set = Edit::Metal(MetalEdit::Set { index: 0, object: Box::new(object) });
    let remove = Edit::Metal(MetalEdit::Remove { index: 0 });
    assert_eq!(requests, [set, remove].map(DesignAction::apply));
}

#[test]
fn the_inspector_states_how_metal_is_simulated() {
    let app = plate_app();
    let facts = MetalFacts::of(&app.world().resource::<OpenWorld>().0, 0).unwrap();
    let report = facts.report.clone().unwrap();
    assert!((1..=200).contains(&report.triangles), "{report:?}");
    let (harness, _) = panel([300.0, 600.0], |ui| {
        metal_facts_ui(ui, &facts);
        Vec::<()>::new()
    });
    // Aluminium at 10 kHz.
    let depth = format!("{:.2}\u{2009}mm", facts.skin_depth_mm);
    assert_eq!(depth, "0.82\u{2009}mm");
    assert!(harness.query_by_label(&depth).is_some());
    let triangles = format!("{} triangles", report.triangles);
    assert!(harness.query_by_label(&triangles).is_some());
}
