//! Commands for the selected sensors: what they do to the design, and what is selected then.

use super::app::{create_app, document, request};
use bevy::prelude::*;
use trackwright_design::{BodyRole, Design, Edit, MirrorPlane};
use trackwright_editor::document::requests::EditRequest;
use trackwright_editor::document::selection::{Selected, Selection};
use trackwright_editor::document::state::Notice;
use trackwright_editor::shell::commands::{CommandsPlugin, RunCommand, Situation};
use trackwright_editor::shell::shell_commands::{SHOW_HISTORY, ShellCommandsPlugin};
use trackwright_editor::shell::window::PanelsShown;
use trackwright_editor::viewport::coil_fit::{CoilFindings, CoilFitPlugin};
use trackwright_editor::viewport::commands::ViewportCommandsPlugin;
use trackwright_editor::viewport::sensor_commands::SensorCommand;
use trackwright_editor::workspaces;
use trackwright_editor::workspaces::design::row_page;
use trackwright_editor::workspaces::design::row_page::{RowDirection, RowPage};
use trackwright_geometry::surface::Surface;
use trackwright_simulation::Coil;

fn app() -> App {
    let mut app = create_app();
    app.add_plugins((
        CommandsPlugin,
        ShellCommandsPlugin,
        ViewportCommandsPlugin,
        row_page::plugin,
    ));
    app
}

fn select(app: &mut App, body: BodyRole, indices: &[usize]) {
    *app.world_mut().resource_mut::<Selection>() =
        Selection::of_sensors(body, indices.iter().copied());
}

fn run(app: &mut App, command: SensorCommand) {
    app.world_mut().write_message(RunCommand(command.command().name));
    app.update();
    app.update();
}

fn names(app: &App, body: BodyRole) -> Vec<String> {
    let body = document(app).design().body(body).unwrap();
    body.rigid.sensors.iter().map(|s| s.name.clone()).collect()
}

fn selected(app: &App) -> Option<(BodyRole, Vec<usize>)> {
    app.world().resource::<Selection>().sensors()
}

fn is_available(app: &App, command: SensorCommand) -> bool {
    let world = app.world();
    let selection = world.resource::<Selection>();
    let now = Situation {
        world: world.get_resource(),
        selection,
        is_dragging: false,
        workspace: workspaces::design::WORKSPACE,
        panels: PanelsShown::default(),
    };
    now.allows(command.command())
}

#[test]
fn copies_are_selected() {
    let mut app = app();
    select(&mut app, BodyRole::Tool, &[0, 1]);
    run(&mut app, SensorCommand::Duplicate);
    assert_eq!(names(&app, BodyRole::Tool), ["shaft", "grip", "shaft 2", "grip 2"]);
    assert_eq!(selected(&app), Some((BodyRole::Tool, vec![2, 3])));
    assert_eq!(document(&app).undo_label(), Some("Duplicate 2 sensors"));
    request(&mut app, EditRequest::Undo);
    app.update();
    assert_eq!(*document(&app).design(), super::app::design());
    assert_eq!(selected(&app), None);
}

#[test]
fn what_is_moved_in_place_stays_selected() {
    let mut app = app();
    select(&mut app, BodyRole::Tool, &[1]);
    run(&mut app, SensorCommand::Mirror(MirrorPlane::X));
    let sensor = &document(&app).design().tool.body.rigid.sensors[1];
    assert_eq!(sensor.position_in_body.x, -12.0);
    assert_eq!(selected(&app), Some((BodyRole::Tool, vec![1])));
}

#[test]
fn coils_are_searched_after_an_edit() {
    let mut app = app();
    app.add_plugins(CoilFitPlugin);
    let found = |app: &App| app.world().resource::<CoilFindings>().of(BodyRole::Tool).len();
    let mut sensor = document(&app).design().tool.body.rigid.sensors[0].clone();
    sensor.coil = Some(Coil { diameter_mm: 0.8, length_mm: 9.0 });
    request(
        &mut app,
        EditRequest::Apply(Edit::SetSensor { body: BodyRole::Tool, index: 0, sensor }),
    );
    app.update();
    assert_eq!(found(&app), 0);
    select(&mut app, BodyRole::Tool, &[0]);
    run(&mut app, SensorCommand::Duplicate);
    assert_eq!(found(&app), 2, "each of the two in one place");
    request(&mut app, EditRequest::Undo);
    app.update();
    assert_eq!(found(&app), 0);
}

#[test]
fn a_mirror_image_onto_itself_is_refused() {
    for (command, reason) in [
        (SensorCommand::MirrorCopy(MirrorPlane::X), "lies on the plane x = 0"),
        (SensorCommand::Mirror(MirrorPlane::X), "its own mirror image in the plane x = 0"),
    ] {
        let mut app = app();
        select(&mut app, BodyRole::Tool, &[0]);
        let before = document(&app).design().clone();
        assert_eq!(before.tool.body.rigid.sensors[0].position_in_body.x, 0.0);
        run(&mut app, command);
        assert_eq!(*document(&app).design(), before);
        assert_eq!(document(&app).undo_label(), None);
        let Notice::Refused(why) = app.world().resource::<Notice>() else {
            panic!("no reason is shown");
        };
        assert!(why.contains(reason), "{why}");
    }
}

#[test]
fn deleting_the_last_sensors_is_refused() {
    let mut app = app();
    select(&mut app, BodyRole::Crf, &[0, 1, 2]);
    assert!(!is_available(&app, SensorCommand::Remove));
    run(&mut app, SensorCommand::Remove);
    assert_eq!(names(&app, BodyRole::Crf).len(), 3);
    select(&mut app, BodyRole::Crf, &[0, 2]);
    assert!(is_available(&app, SensorCommand::Remove));
    run(&mut app, SensorCommand::Remove);
    assert_eq!(names(&app, BodyRole::Crf), ["right"]);
    let body = Some(Selected::Body(BodyRole::Crf));
    assert_eq!(app.world().resource::<Selection>().primary(), body);
}

#[test]
fn a_sensor_stays_selected_when_one_before_it_goes() {
    let mut app = app();
    select(&mut app, BodyRole::Crf, &[2]);
    request(&mut app, EditRequest::Apply(Edit::RemoveSensor { body: BodyRole::Crf, index: 0 }));
    app.update();
    assert_eq!(selected(&app), Some((BodyRole::Crf, vec![1])));
    request(&mut app, EditRequest::Undo);
    app.update();
    assert_eq!(selected(&app), Some((BodyRole::Crf, vec![2])));
}

#[test]
fn useless_commands_are_unavailable() {
    let mut app = app();
    assert!(!is_available(&app, SensorCommand::Duplicate));
    select(&mut app, BodyRole::Tool, &[0]);
    assert!(is_available(&app, SensorCommand::Duplicate));
    assert!(is_available(&app, SensorCommand::MakeSixDof));
    assert!(!is_available(&app, SensorCommand::MakeFiveDof));
    assert!(!is_available(&app, SensorCommand::AlongNormal), "no mesh");
    run(&mut app, SensorCommand::MakeSixDof);
    assert!(!is_available(&app, SensorCommand::MakeSixDof));
    assert!(is_available(&app, SensorCommand::MakeFiveDof));
}

#[test]
fn turning_axes_along_the_shaft_is_one_step() {
    let world = trackwright_project::open_builtin("pointer-on-head").unwrap();
    let surface = Surface::new(world.mesh(BodyRole::Tool).unwrap()).unwrap();
    let selection = Selection::of_sensors(BodyRole::Tool, [1, 0]);
    let axis_z = |command: SensorCommand| {
        let mut document = world.document.clone();
        let before: Design = document.design().clone();
        for request in command.requests(&world, &selection, Some(&surface)) {
            match request {
                EditRequest::Begin(label) => document.begin(label),
                EditRequest::Apply(edit) => {
                    document.apply(edit).unwrap();
                }
                EditRequest::Commit => {
                    document.commit();
                }
                other => panic!("{other:?}"),
            }
        }
        assert!(!document.is_in_step());
        let label = document.undo_label().map(str::to_owned);
        let axes =
            [0, 1].map(|k| document.design().tool.body.rigid.sensors[k].axis_in_body().unwrap().z);
        document.undo();
        assert_eq!(*document.design(), before);
        (label, axes)
    };
    let (label, along) = axis_z(SensorCommand::AlongShaft);
    assert_eq!(label.as_deref(), Some("Align 2 sensors"));
    // That of the body of revolution, whatever is under the grip.
    assert_eq!(along, [1.0, 1.0]);
    let (_, out) = axis_z(SensorCommand::AlongNormal);
    assert!(out[0].abs() < 0.01, "{out:?}");
}

#[test]
fn the_row_dialog_selects_its_new_sensors() {
    let mut app = app();
    select(&mut app, BodyRole::Tool, &[0]);
    run(&mut app, SensorCommand::Row);
    assert!(app.world().resource::<RowPage>().is_open);
    assert_eq!(names(&app, BodyRole::Tool).len(), 2);
    let page = RowPage {
        count: 4,
        spacing_mm: -10.0,
        direction: RowDirection::OwnAxis,
        ..RowPage::default()
    };
    let selection = app.world().resource::<Selection>().clone();
    let edit = page.edit(document(&app).design(), &selection).unwrap();
    request(&mut app, EditRequest::Apply(edit));
    app.update();
    assert_eq!(selected(&app), Some((BodyRole::Tool, vec![2, 3, 4])));
    let last = &document(&app).design().tool.body.rigid.sensors[4];
    assert_eq!(last.position_in_body.z, 90.0);
}

#[test]
fn a_history_jump_spans_many_steps() {
    let mut app = app();
    select(&mut app, BodyRole::Tool, &[0]);
    for _ in 0..3 {
        run(&mut app, SensorCommand::Duplicate);
    }
    request(&mut app, EditRequest::JumpTo(1));
    app.update();
    assert_eq!(names(&app, BodyRole::Tool), ["shaft", "grip", "shaft 2"]);
    request(&mut app, EditRequest::JumpTo(3));
    app.update();
    assert_eq!(names(&app, BodyRole::Tool).len(), 5);
}

#[test]
fn the_history_unfolds_the_panel_that_it_stands_in() {
    let mut app = app();
    app.world_mut().resource_mut::<PanelsShown>().left = false;
    app.world_mut().write_message(RunCommand(SHOW_HISTORY.name));
    app.update();
    let panels = *app.world().resource::<PanelsShown>();
    assert!(panels.left && panels.history);
}
