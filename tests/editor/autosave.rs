//! Recovery files of an app without a window.

use crate::copied::Copied;
use bevy::prelude::*;
use trackwright_design::{BodyRole, Edit};
use trackwright_editor::StatePlugin;
use trackwright_editor::document::apply::DocumentPlugin;
use trackwright_editor::document::autosave::{AutosavePlugin, RecoveryFolder};
use trackwright_editor::document::requests::{EditRequest, OpenWorld};
use trackwright_editor::document::state::Notice;

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

#[test]
fn an_app_that_ends_keeps_its_newest_edit() {
    let copy = Copied::new("pointer-on-head");
    let folder = tempfile::tempdir().unwrap();
    let mut app = app(&copy, folder.path());
    move_sensor(&mut app, 70.0);
    move_sensor(&mut app, 71.5);
    // As after a lost graphics adapter: no dialog was shown, and no frame follows.
    drop(app);
    let left = trackwright_project::leftovers(folder.path()).unwrap();
    assert_eq!(left.len(), 1);
    let world = left[0].open().unwrap();
    let body = world.document.design().body(BodyRole::Tool).unwrap();
    assert_eq!(body.rigid.sensors[0].position_in_body.z, 71.5);
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
