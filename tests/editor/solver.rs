//! What the solver computes, counts and shows.

use super::app::{
    change_view, create_app, design, environment, request, scenario, settle, studied,
    wait_for_answer,
};
use super::one_figure::{built_in, hold, move_tool, release, shown};
use std::sync::{Arc, Mutex};
use trackwright_design::view::View;
use trackwright_design::{BodyRole, Document, Edit, Origin};
use trackwright_editor::document::requests::{EditRequest, OpenWorld};
use trackwright_editor::document::state::{Notice, WorldGeneration};
use trackwright_editor::runner::diagnostics::{Diagnostics, DiagnosticsPlugin, Explain};
use trackwright_editor::runner::results::Results;
use trackwright_editor::runner::solve::slice_plan;
use trackwright_editor::runner::solved::Extent;
use trackwright_geometry::pose::Pose;
use trackwright_simulation::preview::preview;
use trackwright_simulation::{AxisRange, Basis, Mode, Motion, NoInterval};

fn slice_evaluations(app: &bevy::prelude::App) -> u64 {
    app.world().resource::<Diagnostics>().work.slice_evaluations
}

#[test]
fn figures_are_those_that_the_study_itself_gives() {
    let mut app = create_app();
    settle(&mut app);
    let results = app.world().resource::<Results>();
    let study = &results.study.as_ref().unwrap().value;
    assert_eq!(*study, studied(&scenario(&app), &Mode::Motion));
    assert_eq!(study.room_field.trials, 15);
    assert!(results.pose.is_some());
}

#[test]
fn a_preview_has_interval_and_verdict_of_its_own() {
    let mut app = built_in(trackwright_project::DEFAULT_BUILTIN);
    // Long enough for a preview, and within the room that was measured.
    let [fine, coarse] = [1.0, 10.0].map(|step| Some(AxisRange { min: -10.0, max: 10.0, step }));
    let motion = Motion { x: fine, y: fine, z: fine, rx: coarse, ..Motion::default() };
    request(&mut app, EditRequest::Apply(Edit::SetMotion(Some(motion))));
    settle(&mut app);
    hold(&mut app);
    move_tool(&mut app, 5.0);
    let (held, extent) = shown(&app);
    let part = preview(&scenario(&app)).unwrap();
    assert_eq!(extent, Extent::PreviewOf(part.whole_trials));
    assert_eq!(held, studied(&scenario(&app), &part.mode));
    release(&mut app);
    let (whole, extent) = shown(&app);
    assert_eq!(extent, Extent::Whole);
    // The same quantities, of the same kind, judged alike.
    let [during, after] = [&held, &whole].map(|study| {
        let figures = &study.figures;
        let metrics: Vec<_> = figures.all.iter().map(|figure| figure.metric).collect();
        let headline = figures.headline().map(|figure| figure.metric);
        let requirement = figures.requirement.as_ref().map(|own| own.verdict);
        (figures.basis, metrics, headline, requirement, figures.no_interval.clone())
    });
    assert_eq!(during, after);
}

#[test]
fn without_measurements_figures_have_no_interval() {
    let mut app = create_app();
    settle(&mut app);
    let figures = shown(&app).0.figures;
    assert_eq!((figures.basis, figures.no_interval), (Basis::Assumed, Some(NoInterval::Assumed)));
    assert!(figures.all.iter().all(|figure| figure.low.is_none() && figure.high.is_none()));
}

#[test]
fn a_layer_costs_only_its_sample_points() {
    let mut app = create_app();
    change_view(&mut app, |view| view.layers.slice = false);
    let off = slice_evaluations(&app);
    let plan = {
        let world = &app.world().resource::<OpenWorld>().0;
        slice_plan(&world.environment, &world.document.view().slice)
    };
    let points = (plan.counts[0] * plan.counts[1]) as u64;
    change_view(&mut app, |view| view.layers.slice = true);
    assert_eq!(slice_evaluations(&app), off + points);
    assert!(app.world().resource::<Results>().slice.is_some());
    change_view(&mut app, |view| view.layers.slice = false);
    assert_eq!(slice_evaluations(&app), off + points);
    assert!(app.world().resource::<Results>().slice.is_none());
    change_view(&mut app, |view| view.layers.slice = true);
    assert_eq!(slice_evaluations(&app), off + 2 * points);
}

#[test]
fn moving_a_sensor_does_not_sample_the_slice_again() {
    let mut app = create_app();
    settle(&mut app);
    let before = slice_evaluations(&app);
    assert!(before > 0);
    request(&mut app, EditRequest::Apply(Edit::SetToolPose(Pose::translation(1.0, 2.0, 30.0))));
    settle(&mut app);
    assert_eq!(slice_evaluations(&app), before);
}

/// A range of motion that takes long enough to be overtaken.
fn long_motion() -> Motion {
    let range = Some(AxisRange { min: -40.0, max: 40.0, step: 4.0 });
    Motion { x: range, y: range, z: range, rx: range, ..Motion::default() }
}

#[test]
fn an_older_study_never_overwrites_a_newer_one() {
    let mut app = create_app();
    request(&mut app, EditRequest::Apply(Edit::SetMotion(Some(long_motion()))));
    app.update();
    let mut shown = 0;
    for k in 0..40 {
        request(
            &mut app,
            EditRequest::Apply(Edit::SetToolPose(Pose::translation(f64::from(k), 0.0, 30.0))),
        );
        wait_for_answer(&app, std::time::Duration::from_millis(5));
        app.update();
        if let Some(study) = &app.world().resource::<Results>().study {
            assert!(study.revision >= shown, "{} after {shown}", study.revision);
            shown = study.revision;
        }
    }
    // The last edit is a short study: it is overtaken by none of the long ones before it.
    request(&mut app, EditRequest::Apply(Edit::SetMotion(None)));
    settle(&mut app);
    let revision = app.world().resource::<OpenWorld>().0.document.revision();
    let results = app.world().resource::<Results>();
    let study = results.study.as_ref().unwrap();
    assert_eq!(study.revision, revision);
    assert_eq!(study.value.room_field.trials, 1);
    assert!(app.world().resource::<Diagnostics>().studies_cancelled > 0);
}

#[test]
fn a_drag_gets_poses_during_a_long_study() {
    let mut app = create_app();
    request(&mut app, EditRequest::Apply(Edit::SetMotion(Some(long_motion()))));
    settle_pose(&mut app);
    for k in 0..10 {
        request(
            &mut app,
            EditRequest::Apply(Edit::SetToolPose(Pose::translation(f64::from(k), 0.5, 30.0))),
        );
        settle_pose(&mut app);
        let results = app.world().resource::<Results>();
        let pose = &results.pose.as_ref().unwrap().value;
        assert_eq!(pose.trial.crf_from_tool.translation.x, f64::from(k));
    }
}

fn settle_pose(app: &mut bevy::prelude::App) {
    let start = std::time::Instant::now();
    loop {
        app.update();
        let revision = app.world().resource::<OpenWorld>().0.document.revision();
        let pose = &app.world().resource::<Results>().pose;
        if pose.as_ref().is_some_and(|p| p.revision == revision) {
            return;
        }
        assert!(start.elapsed().as_secs() < 10, "the pose never came");
        wait_for_answer(app, std::time::Duration::from_millis(2));
    }
}

/// Edits and files keep one sensor at least, so that only a world made by hand has none.
#[test]
fn a_study_that_cannot_run_reports_why() {
    let mut app = create_app();
    let whole = design();
    let mut bare = design();
    bare.tool.body.rigid.sensors.clear();
    for (design, problem) in [(bare, Some("Pointer has no sensors")), (whole, None)] {
        let origin = Origin::File("test.design.ron".into());
        let document = Document::new(design, View::default(), origin);
        app.world_mut().resource_mut::<WorldGeneration>().0 += 1;
        let world = trackwright_project::World::new(document, Arc::new(environment()), None, None);
        app.insert_resource(OpenWorld(world));
        settle(&mut app);
        let results = app.world().resource::<Results>();
        assert_eq!(results.problem.as_deref(), problem);
        assert_eq!(results.study.is_some(), problem.is_none());
    }
}

#[test]
fn an_edit_of_a_missing_sensor_is_refused() {
    let mut app = create_app();
    request(&mut app, EditRequest::Apply(Edit::RemoveSensor { body: BodyRole::Tool, index: 7 }));
    settle(&mut app);
    let notice = app.world().resource::<Notice>();
    let text = "the tool has no sensor 7, it has 2".to_owned();
    assert_eq!(*notice, Notice::Refused(text));
}

#[test]
fn explain_prints_frames_figures_and_counters() {
    let lines = Arc::new(Mutex::new(Vec::new()));
    let mut app = create_app();
    let sink = Arc::clone(&lines);
    app.add_plugins(DiagnosticsPlugin).insert_resource(Explain(Box::new(move |line: &str| {
        sink.lock().unwrap().push(line.to_owned());
    })));
    settle(&mut app);
    let lines = lines.lock().unwrap();
    assert_eq!(lines.iter().filter(|l| *l == "frame 1").count(), 1);
    let study = app.world().resource::<Results>().study.as_ref().unwrap().value.clone();
    let figures =
        study.figures.bounded().map(|f| format!("{}={}", f.metric.label(), f.words(4, "")));
    let verdict = study.figures.requirement.as_ref().unwrap().verdict;
    for tail in figures.chain([format!("requirement={}", verdict.label())]) {
        let reported = lines.iter().filter(|l| l.starts_with("result") && l.ends_with(&tail));
        assert_eq!(reported.count(), 1, "{tail}");
    }
    assert!(lines.iter().any(|l| l.starts_with("counters ")));
}

#[test]
fn without_a_world_nothing_is_computed() {
    let mut app = create_app();
    app.world_mut().remove_resource::<OpenWorld>();
    settle(&mut app);
    assert_eq!(app.world().resource::<Diagnostics>().studies, 0);
}
