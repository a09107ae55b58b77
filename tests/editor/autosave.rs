//! Recovery files of an app without a window.

use super::harness::use_open_dialog;
use crate::copied::Copied;
use bevy::prelude::*;
use bevy_egui::egui;
use trackwright_design::{BodyRole, Edit};
use trackwright_editor::StatePlugin;
use trackwright_editor::document::apply::DocumentPlugin;
use trackwright_editor::document::autosave::{AutosavePlugin, RecoveryFolder};
use trackwright_editor::document::requests::{EditRequest, OpenWorld};
use trackwright_editor::document::state::Notice;
use trackwright_editor::shell::dialogs::{Dialogs, Outcome};

fn app(copy: &Copied, folder: &std::path::Path) -> App {
    let mut app = App::new();
    app.add_plugins(MinimalPlugins)
        .insert_resource(RecoveryFolder(folder.to_owned()))
        .add_plugins((StatePlugin, DocumentPlugin, AutosavePlugin))
        .insert_resource(OpenWorld(trackwright_project::open_design(&copy.design).unwrap()));
    app.update();
    app
}

fn move_sensor(app: &mut App, z_mm: f64) {
    let design = app.world().resource::<OpenWorld>().0.document.design();
    let mut sensor = design.tool.body.rigid.sensors[0].clone();
    sensor.position_in_body.z = z_mm;
    app.world_mut().write_message(EditRequest::Apply(Edit::SetSensor {
        body: BodyRole::Tool,
        index: 0,
        sensor,
    }));
    app.update();
}

/// Where the moved sensor is in the one recovery file of a folder.
#[track_caller]
fn kept_z_mm(folder: &std::path::Path) -> f64 {
    let left = trackwright_project::leftovers(folder).unwrap();
    assert_eq!(left.len(), 1);
    let world = left[0].open().unwrap();
    world.document.design().tool.body.rigid.sensors[0].position_in_body.z
}

#[test]
fn an_app_that_ends_keeps_its_newest_edit() {
    let copy = Copied::new("pointer-on-head");
    let folder = tempfile::tempdir().unwrap();
    let mut app = app(&copy, folder.path());
    move_sensor(&mut app, 70.0);
    move_sensor(&mut app, 71.5);
    // As after a lost graphics adapter: no dialog was shown, and no frame follows.
    drop(app);
    assert_eq!(kept_z_mm(folder.path()), 71.5);
}

#[test]
fn without_a_recovery_folder_a_notice_is_shown() {
    let copy = Copied::new("pointer-on-head");
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a file");
    std::fs::write(&file, "").unwrap();
    let mut app = app(&copy, &file.join("recovery"));
    let notice = app.world().resource::<Notice>().clone();
    let Notice::Refused(text) = notice else {
        panic!("{notice:?}");
    };
    assert!(text.starts_with("Unsaved changes are not kept for a crash"), "{text}");
    // The edit counts all the same.
    move_sensor(&mut app, 70.0);
    let design = app.world().resource::<OpenWorld>().0.document.design();
    assert_eq!(design.tool.body.rigid.sensors[0].position_in_body.z, 70.0);
}

/// The next start after a crash, with a key pressed in the dialog that it shows.
fn restart(copy: &Copied, folder: &std::path::Path, key: egui::Key) -> App {
    let mut crashed = app(copy, folder);
    move_sensor(&mut crashed, 71.5);
    drop(crashed);
    let mut app = app(copy, folder);
    let shown = app.world_mut().resource_mut::<Dialogs>().current.take();
    let mut dialog = shown.expect("a dialog");
    assert_eq!(dialog.name(), "recover");
    match use_open_dialog(dialog.as_mut(), |harness| harness.key_press(key)) {
        Some(Outcome::Request(write)) => {
            write(&mut app.world_mut().commands());
            app.world_mut().flush();
        }
        Some(Outcome::Close) => {}
        Some(Outcome::Become(other)) => panic!("{other:?}"),
        None => panic!("the dialog stays open"),
    }
    app.update();
    app
}

fn is_edit_open(app: &App) -> bool {
    let design = app.world().resource::<OpenWorld>().0.document.design();
    design.tool.body.rigid.sensors[0].position_in_body.z == 71.5
}

#[test]
fn enter_recovers_unsaved_changes() {
    let copy = Copied::new("pointer-on-head");
    let folder = tempfile::tempdir().unwrap();
    let app = restart(&copy, folder.path(), egui::Key::Enter);
    assert!(is_edit_open(&app));
    assert!(app.world().resource::<OpenWorld>().0.document.is_dirty());
}

#[test]
fn escape_keeps_the_recovery_file() {
    let copy = Copied::new("pointer-on-head");
    let folder = tempfile::tempdir().unwrap();
    let app = restart(&copy, folder.path(), egui::Key::Escape);
    assert!(!is_edit_open(&app));
    drop(app);
    assert_eq!(kept_z_mm(folder.path()), 71.5);
}
