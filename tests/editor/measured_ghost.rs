//! A recording of the built tool, pose by pose: the measured tool is drawn while one of its poses is
//! shown, and only then.

use super::app::{change_view, create_scene_app_with, named, scenario, settle};
use bevy::prelude::*;
use trackwright_design::view::Magnification;
use trackwright_editor::document::trials::TrialChoice;
use trackwright_editor::layers::legend::{Legends, StrokeKey};
use trackwright_editor::workspaces::study::measured_ghost::MeasuredGhostPlugin;
use trackwright_editor::workspaces::study::state::StudyRequest;
use trackwright_editor::{convert, palette, workspaces};
use trackwright_geometry::pose::Pose;
use trackwright_project::{MeasuredError, RecordedPoses};
use trackwright_simulation::{InputTrial, Scenario};

const NAME: &str = "measured ghost";

/// How far the measured tool is off at every pose.
const SHIFT_MM: [f64; 3] = [0.5, -1.0, 2.0];

fn app() -> App {
    let mut app = create_scene_app_with(|app| {
        app.add_plugins(MeasuredGhostPlugin);
    });
    app.insert_resource(workspaces::study::WORKSPACE);
    settle(&mut app);
    // As large as they are.
    change_view(&mut app, |view| view.magnification = Magnification::Times(1.0));
    app
}

fn shift() -> Pose {
    Pose::translation(SHIFT_MM[0], SHIFT_MM[1], SHIFT_MM[2])
}

/// The design's own pose and one beside it; of the second no rotation was measured.
fn recording(scenario: &Scenario) -> RecordedPoses {
    let own = scenario.crf_from_tool;
    let trials = [own, Pose::translation(5.0, 0.0, 0.0) * own].map(InputTrial::at);
    let measured = |crf_from_tool: Option<Pose>| MeasuredError {
        tip_error_in_crf_mm: SHIFT_MM.into(),
        angle_error_deg: crf_from_tool.map(|_| 0.0),
        crf_from_tool,
    };
    RecordedPoses {
        trials: trials.to_vec(),
        measured: vec![measured(Some(shift() * own)), measured(None)],
    }
}

fn request(app: &mut App, request: StudyRequest) {
    app.world_mut().write_message(request);
    settle(app);
}

fn place(app: &mut App) -> Transform {
    let world = app.world_mut();
    let mut places = world.query::<(&Name, &Transform)>();
    let found = places.iter(world).find(|(name, _)| name.as_str() == NAME);
    *found.expect("a measured ghost").1
}

fn in_legend(app: &App) -> Vec<StrokeKey> {
    let strokes = app.world().resource::<Legends>().strokes().map(|(_, stroke)| stroke.clone());
    strokes.filter(|stroke| stroke.color == palette::MEASURED).collect()
}

/// Ghosts and entries in the legend.
fn shown(app: &mut App) -> (usize, usize) {
    (named(app, NAME), in_legend(app).len())
}

#[test]
fn a_recorded_pose_shows_the_measured_tool() {
    let mut app = app();
    assert_eq!(shown(&mut app), (0, 0));
    let of = scenario(&app);
    app.world_mut().resource_mut::<TrialChoice>().take_recording("built".into(), recording(&of));
    settle(&mut app);
    assert_eq!(shown(&mut app), (0, 0), "no pose is shown yet");
    request(&mut app, StudyRequest::Show(Some(0)));
    assert_eq!(shown(&mut app), (1, 1));
    let measured = of.tracker_from_crf() * shift() * of.crf_from_tool;
    let expected = convert::transform(&measured);
    let found = place(&mut app);
    // Single precision at a distance of 300 mm.
    assert!(found.translation.distance(expected.translation) < 1e-3, "{found:?} {expected:?}");
    assert!(found.rotation.dot(expected.rotation).abs() > 0.99999, "{found:?} {expected:?}");
    request(&mut app, StudyRequest::Show(Some(1)));
    assert_eq!(shown(&mut app), (0, 0), "its measured pose is not known");
    request(&mut app, StudyRequest::Show(Some(0)));
    assert_eq!(shown(&mut app), (1, 1));
    request(&mut app, StudyRequest::Show(None));
    assert_eq!(shown(&mut app), (0, 0), "the design's own pose is no recorded one");
}

#[test]
fn only_study_shows_the_measured_tool() {
    let mut app = app();
    let of = scenario(&app);
    app.world_mut().resource_mut::<TrialChoice>().take_recording("built".into(), recording(&of));
    request(&mut app, StudyRequest::Show(Some(0)));
    assert_eq!(shown(&mut app), (1, 1));
    app.insert_resource(workspaces::design::WORKSPACE);
    settle(&mut app);
    assert_eq!(shown(&mut app), (0, 0));
}

#[test]
fn plain_input_data_has_no_measured_tool() {
    let mut app = app();
    let trials = recording(&scenario(&app)).trials;
    app.world_mut().resource_mut::<TrialChoice>().take_input("poses".into(), trials.into());
    request(&mut app, StudyRequest::Show(Some(0)));
    assert_eq!(shown(&mut app), (0, 0));
}
