//! Meshes for bodies: loaded, confirmed, refused, missed and found again.

use super::app::{close_dialog, dialog, error, listen, request, wait_for_answer, write};
use super::harness::{Requests, panel, use_dialog};
use bevy::prelude::*;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use std::fs;
use std::path::Path;
use std::time::Duration;
use tempfile::TempDir;
use trackwright_design::{BodyRole, Edit};
use trackwright_editor::StatePlugin;
use trackwright_editor::document::apply::DocumentPlugin;
use trackwright_editor::document::awaited_meshes::AwaitedMeshes;
use trackwright_editor::document::body_dialogs::MeshDialog;
use trackwright_editor::document::body_files::{BodyFilesPlugin, BodyLoading};
use trackwright_editor::document::dialog::DesignDialog;
use trackwright_editor::document::meshes::{MeshLoading, MeshesPlugin};
use trackwright_editor::document::requests::MeshRequest;
use trackwright_editor::document::requests::{EditRequest, FileRequest, OpenWorld};
use trackwright_editor::document::selection::{Selected, Selection};
use trackwright_editor::shell::dialogs::{DialogAnswer, Dialogs};
use trackwright_editor::workspaces::design::actions::DesignAction;
use trackwright_editor::workspaces::design::mesh_ui::{MeshView, mesh_ui};
use trackwright_geometry::mesh_reference::{MeshReference, MeshUnit};
use trackwright_geometry::pose::Pose;
use trackwright_project::MeshOwner;

/// An editor of the built-in pointer, saved to a folder of its own.
pub fn saved_app() -> (TempDir, App) {
    let folder = tempfile::tempdir().unwrap();
    let mut world = trackwright_project::open_builtin("pointer-on-head").unwrap();
    trackwright_project::save_as(&mut world, &folder.path().join("a.design.ron")).unwrap();
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, StatePlugin, DocumentPlugin));
    listen(&mut app);
    app.insert_resource(OpenWorld(world)).add_plugins((MeshesPlugin, BodyFilesPlugin));
    (folder, app)
}

/// Updates until nothing is read any more, and what was read is applied.
pub fn finish(app: &mut App) {
    app.update();
    let is_reading = |app: &App| {
        let world = app.world();
        world.resource::<MeshLoading>().of().is_some()
            || world.resource::<BodyLoading>().of().is_some()
    };
    while is_reading(app) {
        // The thread may have sent its wake before anybody waited for it.
        wait_for_answer(app, Duration::from_millis(50));
        app.update();
    }
    app.update();
}

fn request_and_wait(app: &mut App, request: MeshRequest) {
    app.world_mut().write_message(request);
    finish(app);
}

/// A closed box of these sides as OBJ, with more lines after it.
pub fn box_obj(sides: [f64; 3], more: &str) -> String {
    let mut text = String::new();
    for corner in 0..8 {
        let at = [0, 1, 2].map(|k| if corner >> k & 1 == 1 { sides[k] } else { 0.0 });
        text += &format!("v {} {} {}\n", at[0], at[1], at[2]);
    }
    for face in [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]]
    {
        text += &format!("f {} {} {} {}\n", face[0], face[1], face[2], face[3]);
    }
    text + more
}

fn world(app: &App) -> &trackwright_project::World {
    &app.world().resource::<OpenWorld>().0
}

fn reference(app: &App) -> Option<MeshReference> {
    world(app).document.design().tool.body.mesh.clone()
}

/// The section of the tool's mesh, and what it requests.
fn section(app: &App) -> (Harness<'_>, Requests<DesignAction>) {
    let (world, loading) = (world(app), app.world().resource::<MeshLoading>());
    panel([276.0, 500.0], move |ui| {
        let view = MeshView::of(world, BodyRole::Tool, loading).unwrap();
        mesh_ui(ui, &view)
    })
}

fn assert_shown(app: &App, what: &str) {
    let (mut harness, _) = section(app);
    harness.run_steps(2);
    assert!(harness.query_by_label_contains(what).is_some(), "{what:?} is not shown");
}

#[test]
fn a_loaded_mesh_is_one_undo_step() {
    let (folder, mut app) = saved_app();
    let before = reference(&app);
    let file = write(&folder, "shaft.obj", box_obj([6.0, 8.0, 150.0], ""));
    request_and_wait(&mut app, MeshRequest::load(BodyRole::Tool, file));
    assert!(app.world().resource::<Dialogs>().current.is_none());
    assert_eq!(reference(&app), Some(MeshReference::new("shaft.obj")));
    let selected = app.world().resource::<Selection>().primary();
    assert_eq!(selected, Some(Selected::Body(BodyRole::Tool)));
    assert_shown(&app, "150.0 × 8.0 × 6.0\u{2009}mm, 12 triangles");
    assert_shown(&app, "Without normals in the file");
    request(&mut app, EditRequest::Undo);
    app.update();
    assert_eq!(reference(&app), before);
    assert!(!world(&app).document.is_dirty());
}

#[test]
fn what_is_wrong_with_a_mesh_is_shown_next_to_it() {
    let (folder, mut app) = saved_app();
    let sides = [6.0, 8.0, 150.0];
    for (more, expected) in [
        ("v nan 0 0\nf 1 2 9\n", "1 triangle was left out"),
        ("f 1 2 8\n", "more than two triangles"),
        ("v 9 9 9\nf 1 2 9\n", "a triangle on one side only"),
        ("f 1 1 2\n", "no area"),
    ] {
        let file = write(&folder, "shaft.obj", box_obj(sides, more));
        request_and_wait(&mut app, MeshRequest::load(BodyRole::Tool, file));
        assert!(app.world().resource::<Dialogs>().current.is_none(), "{more}");
        assert_shown(&app, expected);
    }
}

#[test]
fn an_invalid_mesh_leaves_the_design() {
    let (folder, mut app) = saved_app();
    let before = reference(&app);
    for (name, text, expected) in [
        ("empty.obj", "", "found no triangles"),
        ("nan.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "no numbers"),
        ("far.obj", "v 0 0 0\nv 1e12 0 0\nv 0 1 0\nf 1 2 3\n", "1.000e12 mm from the origin"),
        ("short.stl", "solid", "short.stl"),
        ("broken.glb", "glTF", "broken.glb"),
    ] {
        let file = write(&folder, name, text);
        request_and_wait(&mut app, MeshRequest::load(BodyRole::Tool, file));
        let text = &error(&app).text;
        assert!(text.contains(expected), "{name}: {text}");
        close_dialog(&mut app);
    }
    let gone = folder.path().join("gone.stl");
    request_and_wait(&mut app, MeshRequest::load(BodyRole::Tool, gone));
    assert!(error(&app).text.contains("File not found"));
    assert_eq!(reference(&app), before);
    assert_eq!(world(&app).document.undo_label(), None);
}

#[test]
fn a_wrong_unit_opens_one_dialog() {
    let (folder, mut app) = saved_app();
    let before = reference(&app);
    let file = write(&folder, "metres.obj", box_obj([0.006, 0.008, 0.15], ""));
    request_and_wait(&mut app, MeshRequest::load(BodyRole::Tool, file.clone()));
    assert_eq!(reference(&app), before);
    let question: MeshDialog = dialog(&app).cloned().unwrap();
    let answer = use_dialog(question, |harness| {
        for size in [
            "in m: 150.00\u{2009}mm",
            "in mm: 0.15\u{2009}mm",
            "in cm: 1.50\u{2009}mm",
            "in inch: 3.81\u{2009}mm",
        ] {
            assert!(harness.query_by_label(size).is_some(), "no button {size:?}");
        }
        harness.get_by_label("in m: 150.00\u{2009}mm").click();
    });
    let load =
        MeshRequest::Load { whose: BodyRole::Tool.into(), file, unit: Some(MeshUnit::Metre) };
    assert_eq!(answer, Some(DialogAnswer::Request(load.clone())));
    close_dialog(&mut app);
    request_and_wait(&mut app, load);
    assert!(app.world().resource::<Dialogs>().current.is_none());
    assert_eq!(reference(&app).unwrap().unit, Some(MeshUnit::Metre));
    assert_shown(&app, "150.0 × 8.0 × 6.0\u{2009}mm");
    // A size that the person chose needs no confirmation, however odd.
    let set = MeshRequest::SetUnit { whose: BodyRole::Tool.into(), unit: Some(MeshUnit::Inch) };
    request_and_wait(&mut app, set);
    assert!(app.world().resource::<Dialogs>().current.is_none());
    assert_shown(&app, "3.8 × 0.2 × 0.2\u{2009}mm");
    assert_shown(&app, "is the file in m rather than inch?");
    request(&mut app, EditRequest::Undo);
    request(&mut app, EditRequest::Undo);
    app.update();
    assert_eq!(reference(&app), before);
}

#[test]
fn a_lost_mesh_keeps_its_reference() {
    let (folder, mut app) = saved_app();
    let file = write(&folder, "shaft.obj", box_obj([6.0, 8.0, 150.0], ""));
    request_and_wait(&mut app, MeshRequest::load(BodyRole::Tool, file.clone()));
    app.world_mut().write_message(FileRequest::Save);
    app.update();
    let other = folder.path().join("moved.obj");
    fs::rename(&file, &other).unwrap();
    app.world_mut().write_message(FileRequest::Reload);
    app.update();
    assert_eq!(reference(&app), Some(MeshReference::new("shaft.obj")));
    assert_shown(&app, "File not found");
    let (mut harness, requests) = section(&app);
    harness.get_by_label("Find it…").click();
    harness.run_steps(2);
    drop(harness);
    let show = MeshRequest::ShowLoad(BodyRole::Tool.into());
    assert_eq!(*requests.borrow(), [DesignAction::Mesh(show.clone())]);
    request_and_wait(&mut app, show);
    let Some(MeshDialog::Load { files, .. }) = dialog(&app) else {
        panic!("no dialog");
    };
    let canonical = |path: &Path| path.canonicalize().unwrap();
    assert_eq!(canonical(&files.folder), canonical(folder.path()));
    assert!(files.entries.iter().any(|entry| entry.name() == "moved.obj"));
    request_and_wait(&mut app, MeshRequest::load(BodyRole::Tool, other));
    assert!(world(&app).mesh_problems().is_empty());
    assert_shown(&app, "moved.obj");
}

#[test]
fn a_body_may_be_left_without_a_mesh() {
    let (_folder, mut app) = saved_app();
    let (mut harness, requests) = section(&app);
    harness.get_by_label("No mesh").click();
    harness.run_steps(2);
    drop(harness);
    let edit = Edit::SetMesh { body: BodyRole::Tool, mesh: None };
    assert_eq!(*requests.borrow(), [DesignAction::apply(edit.clone())]);
    request(&mut app, EditRequest::Apply(edit));
    app.update();
    assert!(world(&app).mesh(BodyRole::Tool).is_none());
    assert_shown(&app, "none: a rod");
}

#[test]
fn a_mesh_of_a_closed_design_is_dropped() {
    let (folder, mut app) = saved_app();
    let file = write(&folder, "shaft.obj", box_obj([6.0, 8.0, 150.0], ""));
    let load = MeshRequest::load(BodyRole::Tool, file);
    app.world_mut().write_message(load);
    let open = FileRequest::OpenBuiltIn("endoscope".into());
    app.world_mut().write_message(open);
    finish(&mut app);
    assert_eq!(world(&app).document.undo_label(), None);
    assert!(!world(&app).document.is_dirty());
}

#[test]
fn a_large_mesh_is_read_after_its_design_is_open() {
    let (folder, mut app) = saved_app();
    let large = "# nothing\n".repeat(200_000);
    let file = write(&folder, "shaft.obj", box_obj([6.0, 8.0, 150.0], &large));
    request_and_wait(&mut app, MeshRequest::load(BodyRole::Tool, file));
    app.world_mut().write_message(FileRequest::Save);
    app.update();
    app.world_mut().write_message(FileRequest::Reload);
    app.update();
    // The design is there and can be edited, with a rod in the place of the tool.
    assert!(world(&app).mesh(BodyRole::Tool).is_none());
    assert!(world(&app).mesh(BodyRole::Crf).is_some());
    assert_shown(&app, "Being read");
    let name = Edit::SetName("while it is read".into());
    request(&mut app, EditRequest::Apply(name));
    app.update();
    assert_eq!(world(&app).document.design().name, "while it is read");
    while app.world().resource::<AwaitedMeshes>().is_reading() {
        // The thread may have sent its wake before anybody waited for it.
        wait_for_answer(&app, Duration::from_millis(50));
        app.update();
    }
    assert!(world(&app).mesh(BodyRole::Tool).is_some());
    assert_shown(&app, "150.0 × 8.0 × 6.0\u{2009}mm, 12 triangles");
    request(&mut app, EditRequest::Undo);
    app.update();
    assert!(!world(&app).document.is_dirty(), "reading is no change of the design");
}

#[test]
fn a_mesh_begins_a_design_after_the_question() {
    let (folder, mut app) = saved_app();
    let file = write(&folder, "probe.obj", box_obj([6.0, 8.0, 150.0], ""));
    request(&mut app, EditRequest::Apply(Edit::SetToolPose(Pose::translation(1.0, 2.0, 3.0))));
    app.update();
    app.world_mut().write_message(MeshRequest::load(MeshOwner::NewTool, file));
    finish(&mut app);
    app.update();
    // The open design has changes: they come first.
    let Some(DesignDialog::Unsaved { then, .. }) = dialog(&app) else { panic!("no question") };
    let discard = FileRequest::Discard(Box::new(then.clone()));
    app.world_mut().write_message(discard);
    for _ in 0..3 {
        app.update();
    }
    let design = world(&app).document.design();
    assert_eq!(design.name, "probe");
    let selected = app.world().resource::<Selection>().primary();
    assert_eq!(selected, Some(Selected::Body(BodyRole::Tool)));
    assert!(world(&app).mesh(BodyRole::Tool).is_some() && world(&app).document.is_dirty());
    assert_eq!(world(&app).document.undo_label(), Some("New tool from probe.obj"));
    let tip = design.tool.body.rigid.tip_in_body.unwrap();
    let size = world(&app).mesh(BodyRole::Tool).unwrap().body_bounds().unwrap();
    assert!(
        (size.min_mm.z - tip.z).abs().min((size.max_mm.z - tip.z).abs()) < 1e-9,
        "{tip} {size:?}"
    );
}
