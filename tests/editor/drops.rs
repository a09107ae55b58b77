//! Files dropped onto the window: what is reported of them, and who gets them.

use super::app::{dialog, drop_on_window, request};
use super::meshes::{box_obj, finish, saved_app};
use bevy::prelude::*;
use std::fs;
use std::path::Path;
use trackwright_design::{BodyRole, Edit};
use trackwright_editor::document::body_dialogs::MeshDialog;
use trackwright_editor::document::dialog::DesignDialog;
use trackwright_editor::document::drops::{DropsPlugin, HoveringFiles, words};
use trackwright_editor::document::requests::{EditRequest, OpenWorld};
use trackwright_editor::document::selection::{Selected, Selection};
use trackwright_editor::document::state::{Notice, WorldGeneration};
use trackwright_editor::shell::dialogs::Dialogs;
use trackwright_editor::workspaces;
use trackwright_editor::workspaces::field::FieldPlugin;
use trackwright_geometry::pose::Pose;

pub fn app() -> (tempfile::TempDir, App) {
    let (folder, mut app) = saved_app();
    app.add_plugins((FieldPlugin, DropsPlugin));
    (folder, app)
}

pub fn drop_file(app: &mut App, file: &Path) {
    drop_on_window(app, file);
    finish(app);
}

#[test]
fn a_dropped_design_opens_a_dialog_after_changes() {
    let (folder, mut app) = app();
    let file = folder.path().join("b.design.ron");
    let mut other = trackwright_project::open_builtin("endoscope").unwrap();
    trackwright_project::save_as(&mut other, &file).unwrap();
    drop_file(&mut app, &file);
    assert_eq!(app.world().resource::<WorldGeneration>().0, 1);
    let pose = Edit::SetToolPose(Pose::translation(9.0, 0.0, 30.0));
    request(&mut app, EditRequest::Apply(pose));
    app.update();
    drop_file(&mut app, &folder.path().join("a.design.ron"));
    assert!(matches!(dialog(&app), Some(DesignDialog::Unsaved { .. })));
    assert_eq!(app.world().resource::<WorldGeneration>().0, 1);
}

#[test]
fn a_dropped_room_is_used_as_one_undo_step() {
    let (folder, mut app) = app();
    let room = folder.path().join("other.env.ron");
    let mut environment = (*app.world().resource::<OpenWorld>().0.environment).clone();
    environment.name = "Other room".into();
    super::app::write_environment(&room, &environment);
    drop_file(&mut app, &room);
    let world = &app.world().resource::<OpenWorld>().0;
    assert_eq!(world.environment.name, "Other room");
    let label = world.document.undo_label();
    assert_eq!(label, Some("Use room Other room"));
}

#[test]
fn a_dropped_mesh_belongs_to_the_selected_body() {
    let (folder, mut app) = app();
    let file = folder.path().join("block.OBJ");
    fs::write(&file, box_obj([20.0, 30.0, 40.0], "")).unwrap();
    drop_file(&mut app, &file);
    assert!(matches!(dialog(&app), Some(MeshDialog::Whose { .. })));
    app.world_mut().resource_mut::<Dialogs>().current = None;
    let sensor = Selection::of(Some(Selected::Sensor(BodyRole::Crf, 0)));
    app.insert_resource(sensor);
    drop_file(&mut app, &file);
    let design = app.world().resource::<OpenWorld>().0.document.design();
    let mesh = design.body(BodyRole::Crf).unwrap().mesh.as_ref();
    assert_eq!(mesh.unwrap().file, "block.OBJ");
}

#[test]
fn a_useless_file_lists_what_can_be_dropped() {
    let (folder, mut app) = app();
    for (name, reason) in [
        ("notes.pdf", "meshes (.glb, .gltf, .stl, .obj)"),
        ("probe.rom.zip", "tool definitions (.rom, .tool, .ini, .json)"),
        ("table.csv", "Field workspace"),
    ] {
        drop_file(&mut app, &folder.path().join(name));
        let notice = app.world().resource::<Notice>();
        let Notice::Refused(text) = notice else {
            panic!("{name}: {notice:?}");
        };
        assert!(text.starts_with(name) && text.contains(reason), "{text}");
    }
}

#[test]
fn hovering_files_show_what_will_happen() {
    let (_folder, mut app) = app();
    app.insert_resource(workspaces::study::WORKSPACE);
    for name in ["/x/poses.csv", "/x/grip.stl"] {
        app.world_mut().write_message(FileDragAndDrop::HoveredFile {
            window: Entity::PLACEHOLDER,
            path_buf: name.into(),
        });
    }
    app.update();
    let lines = ["Read poses from poses.csv", "Use grip.stl as a mesh of tool, CRF or anatomy"];
    assert_eq!(app.world().resource::<HoveringFiles>().0, lines);
    let window = Entity::PLACEHOLDER;
    app.world_mut().write_message(FileDragAndDrop::HoveredFileCanceled { window });
    app.update();
    assert_eq!(*app.world().resource::<HoveringFiles>(), HoveringFiles::default());
    let tip = Selection::of(Some(Selected::Tip(BodyRole::Crf)));
    let text = words(Path::new("a/b.glb"), workspaces::design::WORKSPACE, &tip, true);
    assert_eq!(text, "Use b.glb as the CRF's mesh");
    for (name, selection, has_crf, expected) in [
        ("a/8700339.ROM", &tip, true, "Use 8700339.ROM as the CRF"),
        ("p.tool", &Selection::default(), true, "Use p.tool as the tool or the CRF"),
        ("p.ini", &Selection::default(), false, "Use p.ini as the tool"),
        ("p.json", &Selection::default(), false, "Use p.json as the tool"),
        ("p.body.ron", &tip, true, "Use p.body.ron as the CRF"),
    ] {
        let words = words(Path::new(name), workspaces::field::WORKSPACE, selection, has_crf);
        assert_eq!(words, expected);
    }
}
