//! Requests and what they do to the open document.

use super::app::{create_app, design, request};
use bevy::prelude::*;
use trackwright_design::{BodyRole, Edit};
use trackwright_editor::document::apply::title;
use trackwright_editor::document::dialog::DesignDialog;
use trackwright_editor::document::requests::{EditRequest, FileRequest, OpenWorld};
use trackwright_editor::document::selection::{Selected, Selection};
use trackwright_editor::document::state::WorldGeneration;
use trackwright_editor::runner::results::Results;
use trackwright_editor::shell::dialogs::{Dialogs, ErrorDialog};
use trackwright_geometry::pose::Pose;

fn move_sensor(app: &mut App, z_mm: f64) {
    let mut sensor = design().tool.body.rigid.sensors[0].clone();
    sensor.position_in_body.z = z_mm;
    request(app, EditRequest::Apply(Edit::SetSensor { body: BodyRole::Tool, index: 0, sensor }));
}

fn sensor_z(app: &App) -> f64 {
    let document = &app.world().resource::<OpenWorld>().0.document;
    document.design().tool.body.rigid.sensors[0].position_in_body.z
}

fn drag(app: &mut App) {
    request(app, EditRequest::Begin("Move sensor shaft".into()));
    for k in 1..=20 {
        move_sensor(app, 120.0 + 0.3 * f64::from(k));
        app.update();
    }
}

#[test]
fn a_drag_is_one_undo_step() {
    let mut app = create_app();
    drag(&mut app);
    request(&mut app, EditRequest::Commit);
    app.update();
    assert_eq!(sensor_z(&app), 126.0);
    let document = &app.world().resource::<OpenWorld>().0.document;
    assert_eq!(document.undo_label(), Some("Move sensor shaft"));
    request(&mut app, EditRequest::Undo);
    app.update();
    let document = &app.world().resource::<OpenWorld>().0.document;
    assert_eq!(*document.design(), design());
    assert_eq!(document.undo_label(), None);
    request(&mut app, EditRequest::Redo);
    app.update();
    assert_eq!(sensor_z(&app), 126.0);
}

#[test]
fn a_cancelled_drag_leaves_every_bit_as_it_was() {
    let mut app = create_app();
    drag(&mut app);
    request(&mut app, EditRequest::Cancel);
    app.update();
    let document = &app.world().resource::<OpenWorld>().0.document;
    let before = design().tool.body.rigid.sensors[0].position_in_body;
    let after = document.design().tool.body.rigid.sensors[0].position_in_body;
    let bits = |p: nalgebra::Point3<f64>| [p.x, p.y, p.z].map(f64::to_bits);
    assert_eq!(bits(after), bits(before));
    assert_eq!(document.undo_label(), None);
    assert!(!document.is_dirty());
}

#[test]
fn undo_drops_the_selection_of_what_is_gone() {
    let mut app = create_app();
    let mut sensor = design().tool.body.rigid.sensors[0].clone();
    sensor.name = "third".into();
    request(&mut app, EditRequest::Apply(Edit::AddSensor { body: BodyRole::Tool, sensor }));
    app.update();
    let third = Some(Selected::Sensor(BodyRole::Tool, 2));
    assert_eq!(app.world().resource::<Selection>().primary(), third);
    request(&mut app, EditRequest::Undo);
    app.update();
    assert_eq!(app.world().resource::<Selection>().primary(), None);
}

#[test]
fn a_failed_open_leaves_the_document() {
    let mut app = create_app();
    app.world_mut().write_message(FileRequest::Open("/no/such/design.design.ron".into()));
    app.update();
    let Some(ErrorDialog { text, .. }) = app.world().resource::<Dialogs>().get() else {
        panic!("no error dialog");
    };
    assert!(text.starts_with("/no/such/design.design.ron: "), "{text}");
    assert_eq!(app.world().resource::<WorldGeneration>().0, 0);
    assert_eq!(*app.world().resource::<OpenWorld>().0.document.design(), design());
}

#[test]
fn opening_over_unsaved_changes_opens_a_dialog() {
    let mut app = create_app();
    request(&mut app, EditRequest::Apply(Edit::SetToolPose(Pose::translation(9.0, 0.0, 30.0))));
    app.update();
    let open = FileRequest::OpenBuiltIn("endoscope".into());
    app.world_mut().write_message(open.clone());
    app.update();
    let Some(DesignDialog::Unsaved { then, .. }) = app.world().resource::<Dialogs>().get() else {
        panic!("no question");
    };
    assert_eq!(*then, open);
}

#[test]
fn closing_opens_a_dialog_only_after_changes() {
    let mut app = create_app();
    request(&mut app, EditRequest::Apply(Edit::SetToolPose(Pose::translation(9.0, 0.0, 30.0))));
    app.world_mut().write_message(FileRequest::Quit);
    app.update();
    assert!(app.should_exit().is_none());
    app.world_mut().write_message(FileRequest::Discard(Box::new(FileRequest::Quit)));
    app.update();
    assert_eq!(app.should_exit(), Some(AppExit::Success));
}

#[test]
fn a_saved_design_is_clean_and_reads_back_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("mine");
    let mut app = create_app();
    // A design of the disk needs its environment there.
    let environment = super::app::environment();
    let room = folder.path().join("room.env.ron");
    super::app::write_environment(&room, &environment);
    request(&mut app, EditRequest::Apply(Edit::SetToolPose(Pose::translation(9.0, 0.0, 30.0))));
    app.world_mut().write_message(FileRequest::SaveAs(file));
    app.update();
    app.update();
    let dialog = &app.world().resource::<Dialogs>().current;
    assert!(dialog.is_none(), "{dialog:?}");
    let document = &app.world().resource::<OpenWorld>().0.document;
    assert!(!document.is_dirty());
    assert_eq!(title(document, &Results::default()), "mine.design.ron — trackwright");
}
