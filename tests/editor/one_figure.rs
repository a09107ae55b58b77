//! The window shows the one figure of the design as it is, with its interval and its verdict, in every
//! frame of a drag.

use super::app::{create_app, request, scenario, settle, studied};
use super::harness::panel;
use super::panels::of_results;
use bevy::prelude::App;
use egui_kittest::kittest::Queryable;
use trackwright_design::Edit;
use trackwright_editor::document::requests::{ActiveDrag, EditRequest, OpenWorld};
use trackwright_editor::runner::results::Results;
use trackwright_editor::runner::solved::Extent;
use trackwright_editor::workspaces::design::result::result_ui;
use trackwright_geometry::pose::Pose;
use trackwright_simulation::metric::ErrorOf;
use trackwright_simulation::preview::preview;
use trackwright_simulation::study::{Study, mode_of};
use trackwright_simulation::{Basis, Verdict};

/// An App in a built-in design.
pub fn built_in(name: &str) -> App {
    let mut app = create_app();
    let world = trackwright_project::open_builtin_without_meshes(name).unwrap();
    app.insert_resource(OpenWorld(world));
    settle(&mut app);
    app
}

/// Takes hold of the tool as a hand does.
pub fn hold(app: &mut App) {
    app.world_mut().resource_mut::<ActiveDrag>().0 = true;
    request(app, EditRequest::Begin("drag".to_owned()));
}

pub fn move_tool(app: &mut App, by_mm: f64) {
    let moved = Pose::translation(0.0, by_mm, 0.0) * scenario(app).crf_from_tool;
    request(app, EditRequest::Apply(Edit::SetToolPose(moved)));
    settle(app);
}

pub fn release(app: &mut App) {
    app.world_mut().resource_mut::<ActiveDrag>().0 = false;
    request(app, EditRequest::Commit);
    settle(app);
}

/// The study that is shown, and how much it visits.
pub fn shown(app: &App) -> (Study, Extent) {
    let results = app.world().resource::<Results>();
    (results.study.as_ref().unwrap().value.clone(), results.extent.unwrap())
}

/// The study that is shown is that of the design as it is, and the panel has its headline.
fn assert_shown(app: &App, name: &str) -> Study {
    let (study, extent) = shown(app);
    let scenario = scenario(app);
    let mode = match extent {
        Extent::Whole => mode_of(&scenario),
        Extent::PreviewOf(_) => preview(&scenario).unwrap().mode,
    };
    assert_eq!(study, studied(&scenario, &mode), "{name}");
    let results = app.world().resource::<Results>();
    let (harness, _) = panel([300.0, 1100.0], |ui| {
        result_ui(ui, &of_results(results));
        Vec::<()>::new()
    });
    let assert_has = |text: &str| {
        assert!(harness.query_all_by_label(text).count() > 0, "{name}: {text:?}");
    };
    let Some(figure) = study.figures.headline() else {
        assert_has("no figures");
        return study;
    };
    let space = if figure.metric.of == ErrorOf::Angle { "" } else { "\u{2009}" };
    assert_has(figure.metric.label());
    assert_has(&format!("{}{space}{}", figure.value_text(2), figure.metric.unit()));
    let ends = figure.interval_text(2).unwrap();
    assert_has(&format!("95\u{2009}%: {ends}{space}{}", figure.metric.unit()));
    if let Some(requirement) = &study.figures.requirement {
        let verdict = requirement.verdict.label();
        assert!(harness.query_all_by_label_contains(verdict).count() > 0, "{name}: {verdict}");
    }
    study
}

/// How far the figure of a preview is off from that of the whole study, at most.
const MOST_OFF: f64 = 0.02;

#[test]
fn a_drag_shows_in_every_frame_how_it_ends() {
    for name in trackwright_project::builtin_names() {
        let mut app = built_in(name);
        let mut before = assert_shown(&app, name);
        hold(&mut app);
        for frame in 0..3 {
            move_tool(&mut app, 5.0);
            let now = assert_shown(&app, &format!("{name}, frame {frame}"));
            assert_ne!(now.figures, before.figures, "{name}: they follow the hand");
            before = now;
        }
        release(&mut app);
        let after = assert_shown(&app, name);
        assert_eq!(shown(&app).1, Extent::Whole);
        let [held, whole] = [&before, &after].map(|study| study.figures.headline().unwrap());
        assert_eq!(held.metric, whole.metric, "{name}");
        assert!((held.value / whole.value - 1.0).abs() < MOST_OFF, "{name}: {held:?} {whole:?}");
        let verdict = |study: &Study| study.figures.requirement.as_ref().map(|own| own.verdict);
        assert_eq!(verdict(&before), verdict(&after), "{name}");
    }
}

#[test]
fn out_of_the_room_a_drag_decides_nothing() {
    let mut app = built_in(trackwright_project::DEFAULT_BUILTIN);
    hold(&mut app);
    move_tool(&mut app, 4000.0);
    let figures = assert_shown(&app, "outside").figures;
    assert_eq!((figures.basis, figures.all.len()), (Basis::Outside, 0));
    assert_eq!(figures.requirement.unwrap().verdict, Verdict::CannotTell);
}
