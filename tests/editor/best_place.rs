//! The best place for a sensor: marked in the scene, and what it promises is what a click gives.

use super::app::{named, request};
use super::field_layers::{app_with, rest};
use super::pointer::SimulatedPointer;
use bevy::prelude::*;
use trackwright_design::view::{CoilDepth, Layers};
use trackwright_design::{BodyRole, Design, Edit};
use trackwright_editor::document::requests::{EditRequest, OpenWorld, ViewRequest};
use trackwright_editor::document::selection::{Selected, Selection};
use trackwright_editor::layers::best_place::{BestPlaceMark, LEGEND_ORDER, MOVE_TO_BEST};
use trackwright_editor::layers::commands::{LayersCommandsPlugin, PLACE_IN_BORE};
use trackwright_editor::layers::legend::Legends;
use trackwright_editor::layers::placement;
use trackwright_editor::runner::results::Results;
use trackwright_editor::shell::commands::{CommandsPlugin, RunCommand};
use trackwright_editor::shell::window::Workspace;
use trackwright_simulation::{BestPlace, Coil, Metric};

const SENSOR: usize = 1;

/// The layer with a sensor in the bore selected, and no handles over the mark.
fn app() -> App {
    let mut app = app_with(|app| {
        app.add_plugins((CommandsPlugin, LayersCommandsPlugin));
    });
    app.insert_resource(Workspace { has_gizmo: false, ..Workspace::NONE });
    let mut view = app.world().resource::<OpenWorld>().0.document.view().clone();
    view.layers = Layers { placement: true, ..Layers::none() };
    view.placement_depth = CoilDepth::Own;
    app.world_mut().write_message(ViewRequest::Set(view));
    let sensor = Selected::Sensor(BodyRole::Tool, SENSOR);
    *app.world_mut().resource_mut::<Selection>() = Selection::of(Some(sensor));
    rest(&mut app);
    app
}

fn mark(app: &mut App) -> BestPlace {
    let world = app.world_mut();
    world.query::<&BestPlaceMark>().single(world).unwrap().0.clone()
}

fn design(app: &App) -> Design {
    app.world().resource::<OpenWorld>().0.document.design().clone()
}

#[test]
fn a_click_on_the_best_place_gives_what_it_promised() {
    let mut app = app();
    let (before, best) = (design(&app), mark(&mut app));
    let promised = best.placement.expected.unwrap();
    let words = app.world().resource::<Legends>().words(LEGEND_ORDER).unwrap();
    assert_eq!(words, format!("best place found: {:.2}\u{2009}mm", promised.rms_mm));
    let (old_mm, _) = known_mm(&app);
    assert!(promised.rms_mm < old_mm, "{} {old_mm}", promised.rms_mm);

    let mut pointer = SimulatedPointer { app };
    let at = pointer.pixel(&best.sensor.position_in_body);
    pointer.click(at);
    rest(&mut pointer.app);
    let sensor = pointer.design().tool.body.rigid.sensors[SENSOR].clone();
    assert_eq!(sensor, best.sensor);
    let world = &pointer.app.world().resource::<OpenWorld>().0;
    let found = trackwright_simulation::coil_statements(&trackwright_project::coil_findings(world));
    assert!(found.is_empty(), "the program warns of its best place: {found:?}");
    let (figure_mm, own_mm) = known_mm(&pointer.app);
    // The same study of the same design, its place rounded by nothing but the edit.
    assert!((figure_mm - promised.rms_mm).abs() < 1e-9, "{figure_mm} {}", promised.rms_mm);
    let promised_mm = best.placement.tip_rms_mm.unwrap();
    assert!((own_mm - promised_mm).abs() < 1e-9, "{own_mm} {promised_mm}");
    request(&mut pointer.app, EditRequest::Undo);
    rest(&mut pointer.app);
    assert_eq!((pointer.design(), pointer.undo_label()), (before, None));
}

/// The study's tip RMS, and that by the room's model alone.
fn known_mm(app: &App) -> (f64, f64) {
    let study = &app.world().resource::<Results>().study.as_ref().unwrap().value;
    let figure = study.figures.get(Metric::TIP_RMS).unwrap();
    (figure.value, study.room_field.position_mm.rms())
}

#[test]
fn a_command_moves_the_sensor_to_its_best_place() {
    let mut app = app();
    let best = mark(&mut app);
    app.world_mut().write_message(RunCommand(MOVE_TO_BEST.name));
    app.update();
    app.update();
    assert_eq!(design(&app).tool.body.rigid.sensors[SENSOR], best.sensor);
}

#[test]
fn a_command_puts_the_coil_on_the_surface_and_back() {
    let mut app = app();
    for depth in [CoilDepth::Surface, CoilDepth::Own] {
        app.world_mut().write_message(RunCommand(PLACE_IN_BORE.name));
        app.update();
        rest(&mut app);
        assert_eq!(app.world().resource::<OpenWorld>().0.document.view().placement_depth, depth);
        let legends = app.world().resource::<Legends>();
        let note = legends.bar(placement::LAYER.row.order).unwrap().note.clone().unwrap();
        assert_eq!(note, format!("coil {}, axis as it is", depth.name()));
    }
}

#[test]
fn a_coil_that_fits_nowhere_is_stated() {
    let mut app = app();
    let mut sensor = design(&app).tool.body.rigid.sensors[SENSOR].clone();
    // So large that the tool's other coils are in it wherever it is.
    sensor.coil = Some(Coil { diameter_mm: 800.0, length_mm: 800.0 });
    let edit = Edit::SetSensor { body: BodyRole::Tool, index: SENSOR, sensor };
    request(&mut app, EditRequest::Apply(edit));
    rest(&mut app);
    app.update();
    assert_eq!(named(&mut app, "best place"), 0);
    let words = app.world().resource::<Legends>().words(LEGEND_ORDER).unwrap();
    assert_eq!(words, "no best place: the coil fits at none");
}

#[test]
fn the_best_place_is_gone_with_its_layer() {
    let mut app = app();
    assert_eq!(named(&mut app, "best place"), 1);
    let mut view = app.world().resource::<OpenWorld>().0.document.view().clone();
    view.layers.placement = false;
    app.world_mut().write_message(ViewRequest::Set(view));
    rest(&mut app);
    app.update();
    assert_eq!(named(&mut app, "best place"), 0);
    assert_eq!(app.world().resource::<Legends>().words(LEGEND_ORDER), None);
}
