//! The magnification of errors: fitted once, and then nobody's but the person's.

use super::app::{create_scene_app_with, request, settle};
use super::field_layers::show_trial;
use bevy::prelude::*;
use bevy_egui::egui;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use std::cell::RefCell;
use trackwright_design::Edit;
use trackwright_design::view::{Magnification, View};
use trackwright_editor::document::commands::{DocumentCommandsPlugin, MAGNIFY};
use trackwright_editor::document::requests::{ActiveDrag, EditRequest, OpenWorld, ViewRequest};
use trackwright_editor::document::state::WorldGeneration;
use trackwright_editor::layers::commands::LayersCommandsPlugin;
use trackwright_editor::layers::magnification::{
    FIT, MagnificationFit, ShownMagnification, magnification_ui,
};
use trackwright_editor::shell::commands::{CommandsPlugin, RunCommand};
use trackwright_editor::viewport::camera::OrbitRig;
use trackwright_geometry::pose::Pose;

fn app() -> App {
    let mut app = create_scene_app_with(|app| {
        app.add_plugins((CommandsPlugin, DocumentCommandsPlugin, LayersCommandsPlugin));
    });
    settle(&mut app);
    app.update();
    app
}

fn times(app: &App) -> f64 {
    app.world().resource::<ShownMagnification>().times
}

fn view(app: &App) -> View {
    app.world().resource::<OpenWorld>().0.document.view().clone()
}

fn zoom(app: &mut App, by: f64) {
    app.world_mut().resource_mut::<OrbitRig>().camera.distance_mm *= by;
    settle(app);
}

fn move_tool(app: &mut App, x_mm: f64) {
    let pose = Pose::translation(x_mm, -55.0, 25.0);
    request(app, EditRequest::Apply(Edit::SetToolPose(pose)));
    settle(app);
}

fn run(app: &mut App, name: &'static str) {
    app.world_mut().write_message(RunCommand(name));
    app.update();
    settle(app);
}

#[test]
fn drags_zoom_and_trials_leave_the_magnification() {
    let mut app = app();
    let fitted = times(&app);
    // The tip's error is a part of a millimetre.
    assert!(fitted >= 10.0, "{fitted}");
    zoom(&mut app, 6.0);
    assert_eq!(times(&app), fitted);
    app.insert_resource(ActiveDrag(true));
    move_tool(&mut app, 80.0);
    assert_eq!(times(&app), fitted);
    app.insert_resource(ActiveDrag(false));
    settle(&mut app);
    assert_eq!(times(&app), fitted, "after the drop");
    for trial in [0, 7, 2000] {
        show_trial(&mut app, Some(trial));
        assert_eq!(times(&app), fitted, "trial {trial}");
    }
    assert_eq!(view(&app).magnification, Magnification::Auto, "the file stays as it was");
}

#[test]
fn fit_changes_the_magnification_and_keeps_it() {
    let mut app = app();
    let first = times(&app);
    zoom(&mut app, 6.0);
    let fit = app.world().resource::<MagnificationFit>().0.unwrap();
    assert!(fit > first, "{fit} from farther away, {first} before");
    run(&mut app, FIT.name);
    assert_eq!((times(&app), view(&app).magnification), (fit, Magnification::Times(fit)));
    zoom(&mut app, 1.0 / 6.0);
    assert_eq!(times(&app), fit);
    // True size and back is no fit.
    run(&mut app, MAGNIFY.name);
    assert_eq!(times(&app), 1.0);
    run(&mut app, MAGNIFY.name);
    assert_eq!(times(&app), fit);
}

#[test]
fn another_design_is_fitted_anew() {
    let mut app = app();
    let fitted = times(&app);
    zoom(&mut app, 6.0);
    let again = trackwright_project::open_builtin(trackwright_project::DEFAULT_BUILTIN).unwrap();
    app.insert_resource(OpenWorld(again));
    app.world_mut().resource_mut::<WorldGeneration>().0 += 1;
    settle(&mut app);
    app.update();
    assert_eq!(times(&app), fitted);
    let mut own = view(&app);
    own.magnification = Magnification::Times(30.0);
    app.world_mut().write_message(ViewRequest::Set(own));
    settle(&mut app);
    assert_eq!(times(&app), 30.0);
}

#[test]
fn the_panel_fits_and_sets_the_magnification() {
    let shown = ShownMagnification { times: 50.0, is_capped: false };
    let set = RefCell::new(View::default());
    let mut harness = Harness::builder().with_size(egui::vec2(230.0, 80.0)).build_ui(|ui| {
        let fit = MagnificationFit(Some(200.0));
        magnification_ui(ui, &mut set.borrow_mut(), shown, fit);
    });
    harness.run_steps(2);
    assert_eq!(set.borrow().magnification, Magnification::Auto);
    harness.get_by_label("Fit").click();
    harness.run_steps(2);
    assert_eq!(set.borrow().magnification, Magnification::Times(200.0));
}
