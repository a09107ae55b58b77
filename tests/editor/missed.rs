//! Why a requirement is missed, and which changes of the large figure are the design's.

use super::app::{create_app, environment, request, settle};
use bevy::prelude::*;
use std::sync::Arc;
use std::time::{Duration, Instant};
use trackwright_design::{BodyRole, Edit};
use trackwright_editor::document::requests::{EditRequest, OpenWorld};
use trackwright_editor::runner::results::Results;
use trackwright_editor::workspaces::design::DesignPlugin;
use trackwright_editor::workspaces::design::baseline::{Baseline, Change};
use trackwright_editor::workspaces::design::missed::Missed;
use trackwright_editor::workspaces::study::StudyPlugin;
use trackwright_simulation::{CancelToken, ErrorOf, Metric, Mode, Requirement, error_sources};

fn app() -> App {
    let mut app = create_app();
    app.add_plugins((DesignPlugin, StudyPlugin));
    settle(&mut app);
    app
}

/// Updates until the sources of the error are known, if any are wanted.
fn rest(app: &mut App) {
    let start = Instant::now();
    settle(app);
    while !app.world().resource::<Missed>().is_answered() {
        assert!(start.elapsed() < Duration::from_secs(30), "never answered");
        app.update();
    }
}

fn require(app: &mut App, limit_mm: f64) {
    let requirement = Requirement::at_most([(Metric::TIP_RMS, limit_mm)]);
    request(app, EditRequest::Apply(Edit::SetRequirement(Some(requirement))));
    rest(app);
}

fn change(app: &App) -> Option<Change> {
    let world = &app.world().resource::<OpenWorld>().0;
    let study = app.world().resource::<Results>().study.as_ref().unwrap();
    app.world().resource::<Baseline>().change(world, study.value.figures.headline()?)
}

#[test]
fn a_missed_requirement_has_its_sources() {
    let mut app = app();
    require(&mut app, 1000.0);
    assert!(app.world().resource::<Missed>().sources().is_none(), "it is met");
    require(&mut app, 1e-3);
    let world = &app.world().resource::<OpenWorld>().0;
    let scenario = trackwright_project::resolve(world.document.design(), &world.environment);
    let expected = error_sources(&scenario, &Mode::Motion, &CancelToken::default()).unwrap();
    let found = app.world().resource::<Missed>().sources();
    assert_eq!(found, Some(&expected));
    let words = expected.words(ErrorOf::Position, " ");
    assert!(words[0].starts_with("Sensor ") && words[0].contains(" carries "), "{words:?}");
    require(&mut app, 1000.0);
    assert!(app.world().resource::<Missed>().sources().is_none(), "it is met again");
}

#[test]
fn only_a_change_of_the_design_has_a_sign() {
    let mut app = app();
    require(&mut app, 1000.0);
    let world = &app.world().resource::<OpenWorld>().0;
    let mut sensor = world.document.design().tool.body.rigid.sensors[0].clone();
    sensor.position_in_body.z -= 40.0;
    let edit = Edit::SetSensor { body: BodyRole::Tool, index: 0, sensor };
    request(&mut app, EditRequest::Apply(edit));
    settle(&mut app);
    assert!(matches!(change(&app), Some(Change::By(by_mm)) if by_mm != 0.0), "{:?}", change(&app));
    request(&mut app, EditRequest::Apply(Edit::SetMotion(None)));
    settle(&mut app);
    assert_eq!(change(&app), Some(Change::OtherMotion));
    app.world_mut().resource_mut::<OpenWorld>().0.is_in_room(Arc::new(environment()));
    settle(&mut app);
    assert_eq!(change(&app), Some(Change::OtherRoom));
}
