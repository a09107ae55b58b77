//! The Study workspace: what is computed for it, which trial the scene shows, playing, input data,
//! the log.

use super::app::{
    create_app, create_scene_app, design, document, drop_on_window, error, request, scenario,
    settle, studied, wait_for_work, write,
};
use super::copied::Copied;
use crate::support::program::{succeed, text};
use bevy::ecs::message::Messages;
use bevy::input::ButtonState;
use bevy::input::keyboard::{Key, KeyboardInput};
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy::window::RequestRedraw;
use std::path::{Path, PathBuf};
use std::time::Duration;
use trackwright_design::{BodyRole, Edit};
use trackwright_editor::document::commands::DocumentCommandsPlugin;
use trackwright_editor::document::requests::{EditRequest, FileRequest, OpenWorld};
use trackwright_editor::document::shown::ShownDesign;
use trackwright_editor::document::state::Notice;
use trackwright_editor::document::trials::{ModeKind, TrialChoice};
use trackwright_editor::runner::diagnostics::Diagnostics;
use trackwright_editor::runner::results::Results;
use trackwright_editor::scene::BodyRoot;
use trackwright_editor::shell::commands::CommandsPlugin;
use trackwright_editor::shell::dialogs::{Dialogs, ErrorDialog};
use trackwright_editor::shell::shortcuts::ShortcutsPlugin;
use trackwright_editor::shell::window::Workspace;
use trackwright_editor::workspaces::study::StudyPlugin;
use trackwright_editor::workspaces::study::log::LogJob;
use trackwright_editor::workspaces::study::state::StudyRequest;
use trackwright_editor::{convert, workspaces};
use trackwright_geometry::pose::Pose;
use trackwright_simulation::{
    AxisRange, Mode, Motion, Scenario, simulate_pose, trial_pose, trial_sources,
};

fn study_app() -> App {
    let mut app = create_app();
    app.add_plugins(StudyPlugin);
    show_workspace(&mut app, workspaces::study::WORKSPACE);
    app
}

fn show_workspace(app: &mut App, workspace: Workspace) {
    app.insert_resource(workspace);
    settle(app);
}

fn request_and_wait(app: &mut App, request: StudyRequest) {
    app.world_mut().write_message(request);
    settle(app);
}

fn edit(app: &mut App, edit: Edit) {
    request(app, EditRequest::Apply(edit));
    settle(app);
}

fn results(app: &App) -> &Results {
    app.world().resource::<Results>()
}

fn shown_trial(app: &App) -> Option<usize> {
    let shown = app.world().resource::<ShownDesign>();
    shown.trial.as_ref().map(|trial| trial.number)
}

#[test]
fn a_profile_needs_the_study_workspace() {
    let mut app = create_app();
    app.add_plugins(StudyPlugin);
    settle(&mut app);
    let profiles = |app: &App| app.world().resource::<Diagnostics>().profiles;
    assert_eq!(profiles(&app), 0);
    assert!(results(&app).profile.is_none());

    show_workspace(&mut app, workspaces::study::WORKSPACE);
    assert_eq!(profiles(&app), 1);
    let study = results(&app).study.as_ref().unwrap();
    let profile = results(&app).profile.as_ref().unwrap();
    assert_eq!(profile.revision, study.revision);
    assert_eq!(profile.value.profile.len(), 15);
    let worst = study.value.room_field.worst;
    assert_eq!(profile.value.worst_trial, Some(worst.trial));
    let pose = Pose::translation(5.0, 0.0, 30.0);
    edit(&mut app, Edit::SetToolPose(pose));
    assert_eq!(profiles(&app), 2);

    show_workspace(&mut app, workspaces::design::WORKSPACE);
    assert!(results(&app).profile.is_none(), "nothing is kept");
    let pose = Pose::translation(6.0, 0.0, 30.0);
    edit(&mut app, Edit::SetToolPose(pose));
    assert_eq!(profiles(&app), 2);
    assert!(results(&app).study.is_some());
}

#[test]
fn a_shown_trial_has_its_own_figures() {
    let mut app = study_app();
    for trial in [0, 7, 14] {
        request_and_wait(&mut app, StudyRequest::Show(Some(trial)));
        let pose = trial_pose(&scenario(&app), &Mode::Motion, trial).unwrap();
        let alone =
            simulate_pose(&Scenario { crf_from_tool: pose.crf_from_tool, ..scenario(&app) });
        let results = results(&app);
        assert_eq!(results.pose_trial, Some(trial));
        assert_eq!(results.pose.as_ref().unwrap().value.trial, alone.trial);
        let profile = &results.profile.as_ref().unwrap().value.profile;
        let difference = profile.tip_error_mm[trial] - alone.trial.tip_error_mm;
        assert!(difference.abs() < 1e-9, "{difference:e}");
    }
    let document = document(&app);
    assert_eq!(*document.design(), design());
    assert!(!document.is_dirty() && document.undo_label().is_none());

    request_and_wait(&mut app, StudyRequest::Show(None));
    let own = simulate_pose(&scenario(&app));
    let results = results(&app);
    assert_eq!(results.pose_trial, None);
    assert_eq!(results.pose.as_ref().unwrap().value.trial, own.trial);
}

#[test]
fn only_a_shown_trial_has_contributions() {
    let mut app = study_app();
    assert!(results(&app).sources.is_empty(), "the design's own pose is shown");
    request_and_wait(&mut app, StudyRequest::ShowWorst);
    let number = shown_trial(&app).unwrap();
    let of = scenario(&app);
    let expected = trial_sources(&of, trial_pose(&of, &Mode::Motion, number).unwrap());
    assert!(expected.len() >= 2);
    let found = &results(&app).sources;
    assert_eq!(found.len(), expected.len());
    for (one, other) in found.iter().zip(&expected) {
        assert_eq!((one.body, &one.name), (other.body, &other.name));
        assert!((one.along_tip_error_mm - other.along_tip_error_mm).abs() < 1e-9, "{one:?}");
    }
    show_workspace(&mut app, workspaces::design::WORKSPACE);
    assert!(results(&app).sources.is_empty(), "no trial is shown there");
}

#[test]
fn the_worst_trial_is_shown_when_it_is_known() {
    let mut app = study_app();
    let worst = results(&app).study.as_ref().unwrap().value.room_field.worst.trial;
    // Another tip has another worst trial; it is requested before that is known.
    let tip = Edit::SetTip { body: BodyRole::Tool, tip_in_body: Some([60.0, -40.0, 20.0].into()) };
    app.world_mut().write_message(EditRequest::Apply(tip));
    request_and_wait(&mut app, StudyRequest::ShowWorst);
    // Its errors are computed then.
    settle(&mut app);
    let study = results(&app).study.as_ref().unwrap();
    assert_eq!(study.revision, document(&app).revision());
    let new = study.value.room_field.worst.trial;
    assert_eq!(shown_trial(&app), Some(new));
    assert_ne!(new, worst, "the edit moves the worst trial");
    // A choice of one's own takes its place.
    app.world_mut().write_message(StudyRequest::ShowWorst);
    request_and_wait(&mut app, StudyRequest::Show(Some(3)));
    assert_eq!(shown_trial(&app), Some(3));
}

#[test]
fn the_scene_shows_the_trials_tool() {
    let mut app = create_scene_app();
    show_workspace(&mut app, workspaces::study::WORKSPACE);
    let place = |app: &mut App| {
        app.update();
        let world = app.world_mut();
        let mut roots = world.query::<(&BodyRoot, &Transform)>();
        let tool = roots.iter(world).find(|(root, _)| root.0 == BodyRole::Tool);
        *tool.unwrap().1
    };
    let own = place(&mut app);
    request_and_wait(&mut app, StudyRequest::ShowWorst);
    let trial = shown_trial(&app).unwrap();
    let pose = trial_pose(&scenario(&app), &Mode::Motion, trial).unwrap();
    let tracker_from_crf = scenario(&app).crf.unwrap().tracker_from_crf;
    let expected = convert::transform(&(tracker_from_crf * pose.crf_from_tool));
    assert_eq!(place(&mut app), expected);
    assert_ne!(own, expected);
    show_workspace(&mut app, workspaces::design::WORKSPACE);
    assert_eq!(place(&mut app), own);
    show_workspace(&mut app, workspaces::study::WORKSPACE);
    assert_eq!(place(&mut app), expected, "the workspace keeps its trial");
}

#[test]
fn an_edit_keeps_an_existing_trial() {
    let mut app = study_app();
    request_and_wait(&mut app, StudyRequest::Show(Some(12)));
    let moved = Pose::translation(3.0, 0.0, 30.0);
    edit(&mut app, Edit::SetToolPose(moved));
    assert_eq!(shown_trial(&app), Some(12));
    let pose = trial_pose(&scenario(&app), &Mode::Motion, 12).unwrap();
    let shown = &app.world().resource::<ShownDesign>().design;
    assert_eq!(shown.tool.crf_from_tool, pose.crf_from_tool);

    let short =
        Motion { x: Some(AxisRange { min: -10.0, max: 10.0, step: 10.0 }), ..Motion::default() };
    edit(&mut app, Edit::SetMotion(Some(short)));
    assert_eq!(shown_trial(&app), None);
    assert_eq!(results(&app).pose_trial, None);
    request(&mut app, EditRequest::Undo);
    settle(&mut app);
    assert_eq!(shown_trial(&app), None, "it does not come back by itself");
}

#[test]
fn steps_stay_within_the_trials() {
    let mut app = study_app();
    request_and_wait(&mut app, StudyRequest::Step(1));
    assert_eq!(shown_trial(&app), Some(0));
    request_and_wait(&mut app, StudyRequest::Step(-1));
    assert_eq!(shown_trial(&app), Some(0));
    request_and_wait(&mut app, StudyRequest::Step(100));
    assert_eq!(shown_trial(&app), Some(14));
    request_and_wait(&mut app, StudyRequest::ShowWorst);
    let worst = results(&app).study.as_ref().unwrap().value.room_field.worst;
    assert_eq!(shown_trial(&app), Some(worst.trial));
}

#[test]
fn playback_keeps_its_rate_and_stops() {
    let mut app = study_app();
    let tenth = TimeUpdateStrategy::ManualDuration(Duration::from_millis(100));
    app.insert_resource(tenth);
    app.world_mut().write_message(StudyRequest::SetRate(25.0));
    app.world_mut().write_message(StudyRequest::TogglePlay);
    let frame = |app: &mut App| {
        app.update();
        let redraws = app.world().resource::<Messages<RequestRedraw>>();
        let redraw_requested = redraws.iter_current_update_messages().count() > 0;
        let is_playing = app.world().resource::<TrialChoice>().is_playing();
        let trial = app.world().resource::<TrialChoice>().trial();
        (trial, is_playing, redraw_requested)
    };
    assert_eq!(frame(&mut app), (Some(0), true, true));
    // 25 trials a second, 0.1 s a frame.
    for trial in [2, 5, 7, 10, 12] {
        assert_eq!(frame(&mut app), (Some(trial), true, true));
    }
    assert_eq!(frame(&mut app), (Some(14), false, true));
    for _ in 0..5 {
        assert_eq!(frame(&mut app), (Some(14), false, false), "at rest");
    }
    settle(&mut app);
    assert_eq!(shown_trial(&app), Some(14));
    app.world_mut().write_message(StudyRequest::TogglePlay);
    assert_eq!(frame(&mut app), (Some(0), true, true), "it begins anew");
    app.world_mut().write_message(StudyRequest::TogglePlay);
    frame(&mut app);
    let (paused, is_playing, _) = frame(&mut app);
    assert!(!is_playing);
    assert_eq!(frame(&mut app).0, paused);
}

#[test]
fn the_tool_and_its_errors_are_never_of_two_trials() {
    let mut app = study_app();
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(40)));
    app.world_mut().write_message(StudyRequest::TogglePlay);
    for _ in 0..30 {
        app.update();
        let results = results(&app);
        let detail = &results.pose.as_ref().unwrap().value;
        let shown = app.world().resource::<ShownDesign>();
        assert_eq!(results.pose_trial, shown_trial(&app));
        let crf_from_tool = shown.design.tool.crf_from_tool;
        assert_eq!(crf_from_tool, detail.trial.crf_from_tool);
    }
}

#[test]
fn leaving_the_workspace_stops_playing() {
    let mut app = study_app();
    app.world_mut().write_message(StudyRequest::TogglePlay);
    app.update();
    assert!(app.world().resource::<TrialChoice>().is_playing());
    show_workspace(&mut app, workspaces::field::WORKSPACE);
    assert!(!app.world().resource::<TrialChoice>().is_playing());
}

fn press(app: &mut App, key: &Key) {
    for state in [ButtonState::Pressed, ButtonState::Released] {
        app.world_mut().write_message(KeyboardInput {
            key_code: KeyCode::KeyA,
            logical_key: key.clone(),
            state,
            text: None,
            repeat: false,
            window: Entity::PLACEHOLDER,
        });
    }
    settle(app);
}

#[test]
fn study_keys_need_the_study_workspace() {
    let mut app = study_app();
    app.add_plugins((ShortcutsPlugin, CommandsPlugin, DocumentCommandsPlugin));
    press(&mut app, &Key::ArrowRight);
    press(&mut app, &Key::ArrowRight);
    assert_eq!(shown_trial(&app), Some(1));
    press(&mut app, &Key::Character("w".into()));
    let worst = results(&app).study.as_ref().unwrap().value.room_field.worst;
    assert_eq!(shown_trial(&app), Some(worst.trial));
    press(&mut app, &Key::Home);
    assert_eq!(shown_trial(&app), None);
    show_workspace(&mut app, workspaces::design::WORKSPACE);
    press(&mut app, &Key::ArrowRight);
    press(&mut app, &Key::Space);
    let choice = app.world().resource::<TrialChoice>();
    assert!(choice.trial().is_none() && !choice.is_playing());
}

#[test]
fn a_chosen_mode_is_no_part_of_the_design() {
    let mut app = study_app();
    assert_eq!(results(&app).mode, Some(ModeKind::Motion));
    request_and_wait(&mut app, StudyRequest::Choose(ModeKind::Single));
    assert_eq!(results(&app).mode, Some(ModeKind::Single));
    let study = results(&app).study.as_ref().unwrap();
    assert_eq!(study.value.room_field.trials, 1);
    let document = document(&app);
    assert!(!document.is_dirty());
    show_workspace(&mut app, workspaces::design::WORKSPACE);
    assert_eq!(results(&app).mode, Some(ModeKind::Single), "still chosen");
}

const POSES: &str = "tool_x,tool_y,tool_z,tool_qw,tool_qx,tool_qy,tool_qz\n\
    0,0,30,1,0,0,0\n20,-5,40,1,0,0,0\n-40,0,10,0,0,0,1\n";

fn drop_file(app: &mut App, path: &Path) {
    drop_on_window(app, path);
    settle(app);
}

#[test]
fn a_dropped_table_is_studied_here_only() {
    let folder = tempfile::tempdir().unwrap();
    let file = write(&folder, "poses.csv", POSES);
    let mut app = study_app();
    show_workspace(&mut app, workspaces::design::WORKSPACE);
    drop_file(&mut app, &file);
    assert_eq!(results(&app).mode, Some(ModeKind::Motion));

    show_workspace(&mut app, workspaces::study::WORKSPACE);
    drop_file(&mut app, &file);
    assert_eq!(results(&app).mode, Some(ModeKind::Input));
    let trials =
        trackwright_project::Files::default().read_input(&file, true).unwrap().as_it_stands();
    let mode = Mode::Input(trials.clone().into());
    let study = results(&app).study.as_ref().unwrap();
    assert_eq!(study.value, studied(&scenario(&app), &mode));
    request_and_wait(&mut app, StudyRequest::Show(Some(2)));
    let pose = &results(&app).pose.as_ref().unwrap().value;
    assert_eq!(pose.trial.crf_from_tool, trials[2].crf_from_tool);
    let notice = app.world().resource::<Notice>();
    assert_eq!(*notice, Notice::Done("Read 3 poses from poses.csv".into()));
}

#[test]
fn an_unreadable_table_uses_the_commands_words() {
    let folder = tempfile::tempdir().unwrap();
    let file = write(&folder, "wrong.csv", "tool_x,tool_y\n1,2\n");
    let mut app = study_app();
    drop_file(&mut app, &file);
    let error = trackwright_project::Files::default().read_input(&file, true).unwrap_err();
    let expected = ErrorDialog::new("The input data cannot be read", &error);
    assert_eq!(app.world().resource::<Dialogs>().get(), Some(&expected));
    assert_eq!(results(&app).mode, Some(ModeKind::Motion), "as before");
}

#[test]
fn another_design_starts_with_its_own_mode() {
    let folder = tempfile::tempdir().unwrap();
    let file = write(&folder, "poses.csv", POSES);
    let mut app = study_app();
    drop_file(&mut app, &file);
    request_and_wait(&mut app, StudyRequest::Show(Some(1)));
    let name = trackwright_project::DEFAULT_BUILTIN.to_owned();
    app.world_mut().write_message(FileRequest::OpenBuiltIn(name));
    settle(&mut app);
    assert_eq!(shown_trial(&app), None);
    assert_eq!(results(&app).mode, Some(ModeKind::Motion));
    assert!(app.world().resource::<TrialChoice>().input().is_none());
    let shown = &app.world().resource::<ShownDesign>().design;
    let document = document(&app);
    assert_eq!(**shown, *document.design());
}

/// Updates until no log is written any more.
fn wait_for_log(app: &mut App) {
    while app.world().resource::<LogJob>().part().is_some() {
        wait_for_work(app);
    }
}

#[test]
fn the_log_is_that_of_the_command_line_to_the_byte() {
    let copied = Copied::new("pointer-on-head");
    let mut app = study_app();
    *app.world_mut().resource_mut::<OpenWorld>() =
        OpenWorld(trackwright_project::open_design(&copied.design).unwrap());
    settle(&mut app);
    let (ours, theirs) = (copied.path("ours.csv"), copied.path("theirs.csv"));
    app.world_mut().write_message(FileRequest::WriteLog(ours.clone()));
    app.update();
    wait_for_log(&mut app);
    succeed(&["simulate", &text(&copied.design), "--mode", "motion", "--log", &text(&theirs)]);
    let read = |file| std::fs::read_to_string(file).unwrap();
    let (ours, theirs) = (read(ours), read(theirs));
    assert!(ours == theirs, "{} and {} bytes", ours.len(), theirs.len());
    assert_eq!(ours.lines().count(), 3375 + 1);
    let notice = app.world().resource::<Notice>();
    assert!(matches!(notice, Notice::Done(text) if text.starts_with("Wrote 3,375 trials to ")));
}

#[test]
fn a_log_that_is_given_up_leaves_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("long.csv");
    let mut app = study_app();
    let range = Some(AxisRange { min: -40.0, max: 40.0, step: 1.0 });
    let long = Motion { x: range, y: range, z: range, ..Motion::default() };
    request(&mut app, EditRequest::Apply(Edit::SetMotion(Some(long))));
    app.world_mut().write_message(FileRequest::WriteLog(file.clone()));
    app.update();
    assert!(app.world().resource::<LogJob>().part().is_some());
    app.world_mut().write_message(StudyRequest::CancelLog);
    app.update();
    wait_for_log(&mut app);
    assert!(!file.exists());
    let notice = app.world().resource::<Notice>();
    assert!(matches!(notice, Notice::Done(text) if text.contains("cancelled")));
}

#[test]
fn a_log_that_cannot_be_written_names_its_file() {
    let mut app = study_app();
    let file = PathBuf::from("/no/such/folder/log.csv");
    app.world_mut().write_message(FileRequest::WriteLog(file));
    app.update();
    wait_for_log(&mut app);
    let ErrorDialog { title, text } = error(&app);
    assert_eq!(title, "The log cannot be written");
    assert!(text.starts_with("/no/such/folder/log.csv"), "{text}");
}
