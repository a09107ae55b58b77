//! The design's anatomy: added by its file, listed, changed, and drawn where its frame has it.

use super::app::{change_view, create_scene_app, environment, named, request, settle};
use super::harness::{panel, use_dialog};
use super::meshes::{box_obj, finish, saved_app};
use bevy::prelude::*;
use egui_kittest::kittest::Queryable;
use std::fs;
use trackwright_design::{Anatomy, AnatomyEdit, AnatomyFrame, Design, Edit, View};
use trackwright_editor::document::body_dialogs::MeshDialog;
use trackwright_editor::document::commands::ADD_ANATOMY;
use trackwright_editor::document::requests::MeshRequest;
use trackwright_editor::document::requests::{EditRequest, OpenWorld, ViewRequest};
use trackwright_editor::document::selection::{Selected, Selection};
use trackwright_editor::scene::anatomy::AnatomyRoot;
use trackwright_editor::shell::dialogs::DialogAnswer;
use trackwright_editor::workspaces::design::actions::DesignAction;
use trackwright_editor::workspaces::design::anatomy_ui::anatomy_ui;
use trackwright_editor::workspaces::design::outliner::outliner_ui;
use trackwright_editor::workspaces::design::outliner_row::OutlinerView;
use trackwright_geometry::mesh_reference::MeshReference;
use trackwright_geometry::pose::Pose;
use trackwright_project::MeshOwner;

pub fn anatomy(name: &str, file: &str) -> Anatomy {
    Anatomy {
        name: name.to_owned(),
        mesh: MeshReference::new(file),
        on: AnatomyFrame::Crf,
        frame_from_mesh: Pose::identity(),
        color: None,
        crf_patch: Vec::new(),
    }
}

pub fn add(anatomy: Anatomy) -> EditRequest {
    EditRequest::Apply(Edit::Anatomy(AnatomyEdit::Add(Box::new(anatomy))))
}

fn open_design(app: &App) -> &Design {
    app.world().resource::<OpenWorld>().0.document.design()
}

#[test]
fn a_file_becomes_anatomy_on_the_crf() {
    let (folder, mut app) = saved_app();
    let file = folder.path().join("head.obj");
    fs::write(&file, box_obj([160.0, 200.0, 230.0], "")).unwrap();
    let mut view = View::default();
    view.layers.anatomy = false;
    app.world_mut().write_message(ViewRequest::Set(view));
    app.update();
    let new = MeshOwner::Anatomy(None);
    for _ in 0..2 {
        app.world_mut().write_message(MeshRequest::load(new, file.clone()));
        finish(&mut app);
        app.update();
    }
    let expected = [anatomy("head", "head.obj"), anatomy("head 2", "head.obj")];
    assert_eq!(open_design(&app).anatomy, expected);
    let world = &app.world().resource::<OpenWorld>().0;
    assert!(world.document.view().layers.anatomy);
    assert!(world.anatomy_mesh(&expected[0].mesh).is_some());
    let selection = app.world().resource::<Selection>();
    assert_eq!(selection.primary(), Some(Selected::Anatomy(1)));
    // Taken back, nothing is selected that is not there.
    request(&mut app, EditRequest::Undo);
    app.update();
    assert_eq!(open_design(&app).anatomy.len(), 1);
    assert_eq!(app.world().resource::<Selection>().primary(), None);
}

#[test]
fn a_dropped_mesh_may_become_anatomy() {
    for has_crf in [true, false] {
        let dialog = MeshDialog::Whose { file: "/x/head.stl".into(), has_crf };
        let answer = use_dialog(dialog, |harness| {
            assert_eq!(harness.query_by_label("The CRF's").is_some(), has_crf);
            harness.get_by_label("Anatomy").click();
        });
        let load = MeshRequest::load(MeshOwner::Anatomy(None), "/x/head.stl".into());
        assert_eq!(answer, Some(DialogAnswer::Request(load)));
    }
}

#[test]
fn the_outliner_lists_anatomy() {
    let mut design = super::app::design();
    let mut table = anatomy("table", "table.stl");
    table.on = AnatomyFrame::Tracker;
    design.anatomy = vec![anatomy("head", "head.stl"), table];
    let (environment, view) = (environment(), View::default());
    let selection = Selection::default();
    let (mut harness, requests) = panel([300.0, 1100.0], |ui| {
        let view = OutlinerView::new(&design, &environment, &view, &selection);
        outliner_ui(ui, &view)
    });
    harness.get_by_label("table").click();
    harness.run_steps(2);
    harness.get_by_label("Add anatomy…").click();
    harness.run_steps(2);
    let select = DesignAction::Select(Some(Selected::Anatomy(1)));
    for wanted in [select, DesignAction::Run(ADD_ANATOMY.name)] {
        assert!(requests.borrow().contains(&wanted), "{:?}", requests.borrow());
    }
}

#[test]
fn anatomy_inputs_are_edits() {
    let mut design = super::app::design();
    design.anatomy = vec![anatomy("head", "head.stl")];
    let (mut harness, requests) = panel([300.0, 1100.0], |ui| {
        let mut actions = Vec::new();
        anatomy_ui(ui, &design, 0, &mut actions);
        actions
    });
    harness.get_by_label("skin").click();
    harness.run_steps(2);
    harness.get_by_label("Remove anatomy").click();
    harness.run_steps(2);
    let requests = requests.borrow();
    let [colored, removed] = &requests[..] else {
        panic!("{requests:?}");
    };
    let DesignAction::Edit(EditRequest::Apply(Edit::Anatomy(AnatomyEdit::Set { index, anatomy }))) =
        colored
    else {
        panic!("{colored:?}");
    };
    assert!(*index == 0 && anatomy.color.is_some());
    assert_eq!(anatomy.frame_from_mesh, design.anatomy[0].frame_from_mesh);
    let remove = Edit::Anatomy(AnatomyEdit::Remove { index: 0 });
    assert_eq!(*removed, DesignAction::apply(remove));
}

#[test]
fn anatomy_is_drawn_in_its_frame() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("head.obj");
    fs::write(&file, box_obj([160.0, 200.0, 230.0], "")).unwrap();
    let file = file.to_str().unwrap();
    let mut app = create_scene_app();
    settle(&mut app);
    let mut fixed = anatomy("table", file);
    fixed.on = AnatomyFrame::Tracker;
    request(&mut app, add(anatomy("head", file)));
    request(&mut app, add(fixed));
    settle(&mut app);
    let places = |app: &mut App| -> Vec<Vec3> {
        let world = app.world_mut();
        let mut roots = world.query::<(&AnatomyRoot, &Transform)>();
        let mut found: Vec<_> =
            (roots.iter(world)).map(|(root, place)| (root.0, place.translation)).collect();
        found.sort_by_key(|(index, _)| *index);
        found.into_iter().map(|(_, place)| place).collect()
    };
    let moved = Pose::translation(12.0, -7.0, -250.0);
    request(&mut app, EditRequest::Apply(Edit::SetCrfPose(moved)));
    settle(&mut app);
    assert_eq!(places(&mut app), [Vec3::new(12.0, -7.0, -250.0), Vec3::ZERO]);
    change_view(&mut app, |view| view.layers.anatomy = false);
    assert!(places(&mut app).is_empty());
    change_view(&mut app, |view| view.layers.anatomy = true);
    assert_eq!(places(&mut app).len(), 2);
    let remove = Edit::Anatomy(AnatomyEdit::Remove { index: 0 });
    request(&mut app, EditRequest::Apply(remove));
    settle(&mut app);
    assert_eq!(places(&mut app), [Vec3::ZERO]);
    assert_eq!((named(&mut app, "anatomy head"), named(&mut app, "anatomy table")), (0, 1));
}
