//! Arrows, placement and the usable region: there when they are on, no work while they are off.

use super::app::{create_scene_app_with, document, named, request, settle, wait_for_work};
use bevy::prelude::*;
use nalgebra::{Translation3, UnitQuaternion};
use trackwright_design::view::Layers;
use trackwright_design::{BodyRole, Edit, View};
use trackwright_editor::document::requests::{EditRequest, OpenWorld, ViewRequest};
use trackwright_editor::document::selection::{Selected, Selection};
use trackwright_editor::document::shown::{LivePoses, ShownDesign};
use trackwright_editor::layers::legend::Legends;
use trackwright_editor::layers::registry::are_idle;
use trackwright_editor::layers::{LayersPlugin, field_arrows, placement, region, validity};
use trackwright_editor::runner::diagnostics::Diagnostics;
use trackwright_editor::runner::results::Results;
use trackwright_editor::shell::window::Workspace;
use trackwright_editor::workspaces;
use trackwright_editor::workspaces::study::state::StudyRequest;
use trackwright_geometry::colormap::ColorMap;
use trackwright_geometry::pose::Pose;
use trackwright_simulation::{Metric, Requirement, Work};

fn app() -> App {
    app_with(|_| ())
}

/// The layers in a window that nothing paints, with more plugins.
pub fn app_with(add: impl FnOnce(&mut App)) -> App {
    let mut app = create_scene_app_with(|app| {
        app.add_plugins(LayersPlugin);
        add(app);
    });
    rest(&mut app);
    app
}

/// Until neither the solver nor a layer has anything left to do or to show.
pub fn rest(app: &mut App) {
    settle(app);
    while !are_idle(app.world()) {
        wait_for_work(app);
    }
    app.update();
    app.update();
}

fn set(app: &mut App, change: impl FnOnce(&mut Layers)) {
    change_view(app, |view| change(&mut view.layers));
}

fn work(app: &App) -> Work {
    app.world().resource::<Diagnostics>().work
}

/// Poses evaluated for the region of supported field.
fn looked_up(app: &App) -> u64 {
    app.world().resource::<Diagnostics>().support_evaluations
}

pub fn change_view(app: &mut App, change: impl FnOnce(&mut View)) {
    let mut view = document(app).view().clone();
    change(&mut view);
    app.world_mut().write_message(ViewRequest::Set(view));
    rest(app);
}

/// Shows a trial of the study.
pub fn show_trial(app: &mut App, trial: Option<usize>) {
    app.insert_resource(workspaces::study::WORKSPACE);
    app.world_mut().write_message(StudyRequest::Show(trial));
    rest(app);
}

/// Moves the tool by an edit.
fn edit(app: &mut App, x_mm: f64) {
    let pose = Pose::translation(x_mm, 0.0, 30.0);
    request(app, EditRequest::Apply(Edit::SetToolPose(pose)));
    rest(app);
}

#[test]
fn layers_that_are_off_do_no_work_at_all() {
    let mut app = app();
    edit(&mut app, 3.0);
    let done = work(&app);
    let of_layers = [done.arrow_evaluations, done.placement_evaluations, done.region_evaluations];
    assert_eq!(of_layers, [0; 3]);
    assert_eq!(looked_up(&app), 0);
    for name in ["field arrows", "placement", "usable region", "supported region"] {
        assert_eq!(named(&mut app, name), 0, "{name}");
    }
}

#[test]
fn arrows_are_sampled_once() {
    let mut app = app();
    set(&mut app, |layers| layers.arrows = true);
    assert_eq!(named(&mut app, "field arrows"), 1);
    let once = work(&app).arrow_evaluations;
    assert_eq!(once, 9 * 9 * 9);
    let legends = app.world().resource::<Legends>();
    let bar = legends.bar(field_arrows::LAYER.row.order).unwrap();
    assert!(bar.max > 0.0 && bar.max <= bar.largest);
    edit(&mut app, 3.0);
    assert_eq!(work(&app).arrow_evaluations, once);
    set(&mut app, |layers| layers.arrows = false);
    assert_eq!(named(&mut app, "field arrows"), 0);
    assert_eq!(app.world().resource::<Legends>().bar(field_arrows::LAYER.row.order), None);
}

#[test]
fn a_body_is_painted_while_its_sensor_is_selected() {
    let mut app = app();
    set(&mut app, |layers| layers.placement = true);
    assert_eq!(named(&mut app, "placement"), 0, "nothing is selected");
    assert_eq!(work(&app).placement_evaluations, 0);
    let sensor = Selected::Sensor(BodyRole::Tool, 0);
    *app.world_mut().resource_mut::<Selection>() = Selection::of(Some(sensor));
    rest(&mut app);
    assert!(named(&mut app, "placement") > 0);
    let bar = app.world().resource::<Legends>().bar(placement::LAYER.row.order).cloned().unwrap();
    // The sensor sits on the body now, so what is there now is within what could be.
    assert!(bar.min > 0.0 && bar.min < bar.max && bar.max <= bar.largest);
    assert!(work(&app).placement_evaluations > 0);
    *app.world_mut().resource_mut::<Selection>() = Selection::default();
    rest(&mut app);
    assert_eq!(named(&mut app, "placement"), 0);
    // On a slide, where nothing can be selected, the tool's first sensor stands for it.
    app.insert_resource(workspaces::present::WORKSPACE);
    rest(&mut app);
    let on_slide = app.world().resource::<Legends>().bar(placement::LAYER.row.order).cloned();
    assert_eq!(on_slide, Some(bar));
    app.insert_resource(workspaces::design::WORKSPACE);
    rest(&mut app);
    assert_eq!(named(&mut app, "placement"), 0);
}

#[test]
fn the_usable_region_shows_its_share() {
    let mut app = app();
    // Loose enough for a part of the volume to be within it with 95 %.
    let loose = Requirement::at_most([(Metric::TIP_RMS, 1.2)]);
    let loosen = Edit::SetRequirement(Some(loose));
    request(&mut app, EditRequest::Apply(loosen));
    set(&mut app, |layers| layers.region = true);
    assert_eq!(named(&mut app, "usable region"), 1);
    let region = app.world().resource::<Legends>().words(region::LEGEND_ORDER).unwrap();
    let is_one_figure =
        region.starts_with("requirement met with 95 % in ") && region.ends_with(" cm³");
    assert!(is_one_figure, "{region}");
    request(&mut app, EditRequest::Apply(Edit::SetRequirement(None)));
    rest(&mut app);
    assert_eq!(named(&mut app, "usable region"), 0);
    let region = app.world().resource::<Legends>().words(region::LEGEND_ORDER).unwrap();
    assert_eq!(region, "no usable region: the design has no requirement");
}

#[test]
fn new_colours_need_no_new_samples() {
    let mut app = app();
    set(&mut app, |layers| layers.arrows = true);
    let once = work(&app).arrow_evaluations;
    change_view(&mut app, |view| {
        view.slice.color_map = ColorMap::Inferno;
        view.arrows.range_mm = Some(1.5);
    });
    let bar =
        app.world().resource::<Legends>().bar(field_arrows::LAYER.row.order).cloned().unwrap();
    assert_eq!((bar.map, bar.max), (ColorMap::Inferno, 1.5));
    assert_eq!(work(&app).arrow_evaluations, once);
}

#[test]
fn tool_arrows_follow_the_shown_trial() {
    let mut app = app();
    let sensor = Selected::Sensor(BodyRole::Tool, 0);
    *app.world_mut().resource_mut::<Selection>() = Selection::of(Some(sensor));
    change_view(&mut app, |view| {
        view.layers.arrows = true;
        view.layers.placement = true;
        view.arrows.of_tool = true;
    });
    let before = work(&app);
    show_trial(&mut app, Some(5));
    let shown = app.world().resource::<ShownDesign>();
    assert_eq!(shown.trial.as_ref().map(|trial| trial.number), Some(5));
    let after = work(&app);
    assert_eq!(after.arrow_evaluations, 2 * before.arrow_evaluations);
    assert_eq!(after.placement_evaluations, before.placement_evaluations);
    assert!(named(&mut app, "placement") > 0);
    // Those of an imagined sensor have nothing to do with the tool.
    change_view(&mut app, |view| view.arrows.of_tool = false);
    let before = work(&app).arrow_evaluations;
    show_trial(&mut app, Some(9));
    assert_eq!(work(&app).arrow_evaluations, before);
}

#[test]
fn tool_arrows_follow_a_live_pose() {
    let mut app = app();
    change_view(&mut app, |view| {
        view.layers.arrows = true;
        view.arrows.of_tool = true;
    });
    let once = work(&app).arrow_evaluations;
    app.insert_resource(Workspace { shows_live: true, ..Workspace::NONE });
    let turned = |k: usize| {
        let turn = UnitQuaternion::from_euler_angles(0.5 * k as f64, 0.2, 0.0);
        Pose::from_parts(Translation3::new(0.0, 0.0, -300.0), turn)
    };
    for number in 1..4 {
        app.insert_resource(LivePoses { number, tool: Some(turned(number)), crf: None });
        rest(&mut app);
        app.update();
        rest(&mut app);
        let shown = app.world().resource::<ShownDesign>().live;
        assert!(shown.is_some(), "{number}");
        assert_eq!(work(&app).arrow_evaluations, (1 + number as u64) * once);
    }
}

#[test]
fn trials_leave_the_arrows_magnification() {
    let mut app = app();
    change_view(&mut app, |view| {
        view.layers.arrows = true;
        view.arrows.of_tool = true;
    });
    let label = |app: &App| {
        let legends = app.world().resource::<Legends>();
        let label = &legends.bar(field_arrows::LAYER.row.order).unwrap().label;
        label.split_once("arrows").unwrap().1.to_owned()
    };
    let first = label(&app);
    assert!(first.ends_with("× larger"), "{first}");
    for trial in [0, 1500, 3374] {
        show_trial(&mut app, Some(trial));
        assert_eq!(label(&app), first);
    }
}

#[test]
fn model_validity_is_independent_of_the_tool() {
    let mut app = app();
    let hatched = |app: &App| {
        let results = app.world().resource::<Results>();
        results.slice.as_ref().map(|s| s.value.is_supported.len())
    };
    set(&mut app, |layers| layers.slice = true);
    assert_eq!(hatched(&app), Some(0), "off costs nothing");
    set(&mut app, |layers| layers.support = true);
    assert_eq!(named(&mut app, "supported region"), 1);
    assert!(hatched(&app) > Some(0));
    let words = app.world().resource::<Legends>().words(validity::LAYER.row.order).unwrap();
    assert!(words.starts_with("field supported in "), "{words}");
    let once = looked_up(&app);
    assert_eq!(once, 13 * 13 * 13 + 33 * 33 * 33);
    edit(&mut app, 3.0);
    assert_eq!(looked_up(&app), once);
    // A sensor that points elsewhere has other samples to lean on.
    change_view(&mut app, |view| view.slice.sensor_axis = [1.0, 0.0, 0.0]);
    assert_eq!(looked_up(&app), 2 * once);
    set(&mut app, |layers| layers.support = false);
    assert_eq!(named(&mut app, "supported region"), 0);
    assert_eq!(hatched(&app), Some(0));
    assert_eq!(app.world().resource::<Legends>().words(validity::LAYER.row.order), None);
}

#[test]
fn a_room_that_does_not_know_its_reach_shows_none() {
    let mut app = app();
    app.insert_resource(OpenWorld(super::app::world()));
    set(&mut app, |layers| {
        layers.slice = true;
        layers.support = true;
    });
    assert_eq!(named(&mut app, "supported region"), 0);
    assert_eq!(looked_up(&app), 0);
    let results = app.world().resource::<Results>();
    assert!(results.slice.as_ref().unwrap().value.is_supported.is_empty());
}
