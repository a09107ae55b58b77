//! What goes to the graphics card: nothing for layers that are off, nothing while nothing changes.

use super::app::{change_view, create_scene_app, request, settle};
use bevy::prelude::*;
use trackwright_design::Edit;
use trackwright_design::view::Layers;
use trackwright_editor::document::requests::EditRequest;
use trackwright_editor::runner::diagnostics::Diagnostics;
use trackwright_geometry::pose::Pose;

fn app() -> App {
    let mut app = create_scene_app();
    settle(&mut app);
    app.update();
    app
}

fn uploads(app: &App) -> u64 {
    app.world().resource::<Diagnostics>().uploads
}

fn set_layers(app: &mut App, change: impl FnOnce(&mut Layers)) {
    change_view(app, |view| change(&mut view.layers));
    app.update();
}

/// What one more edit of the tool's pose sends to the card.
fn uploads_of_an_edit(app: &mut App, x_mm: f64) -> u64 {
    let before = uploads(app);
    let pose = Pose::translation(x_mm, 0.0, 30.0);
    request(app, EditRequest::Apply(Edit::SetToolPose(pose)));
    settle(app);
    app.update();
    uploads(app) - before
}

#[test]
fn nothing_is_uploaded_while_nothing_changes() {
    let mut app = app();
    let before = uploads(&app);
    assert!(before > 0, "a scene has meshes");
    for _ in 0..20 {
        app.update();
    }
    assert_eq!(uploads(&app), before);
}

#[test]
fn an_edit_uploads_only_visible_errors() {
    let mut app = app();
    set_layers(&mut app, |layers| layers.sensor_errors = true);
    let all = uploads_of_an_edit(&mut app, 1.0);
    assert!(all > 0, "vectors are drawn anew");
    set_layers(&mut app, |layers| {
        layers.sensor_errors = false;
        layers.tip_error = false;
    });
    assert_eq!(uploads_of_an_edit(&mut app, 2.0), 0);
    set_layers(&mut app, |layers| layers.sensor_errors = true);
    let sensors = uploads_of_an_edit(&mut app, 3.0);
    assert!(sensors > 0 && sensors < all, "{sensors} of {all}");
}
