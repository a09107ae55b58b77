//! The Decide workspace: a pinned baseline beside the design, designs and rooms in one table.

use super::app::{
    create_app, create_scene_app_with, document, named, request, scenario, settle, studied,
};
use bevy::prelude::*;
use bevy_egui::egui;
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use trackwright_design::{BodyRole, Edit};
use trackwright_editor::document::autosave::RecoveryFolder;
use trackwright_editor::document::requests::{EditRequest, FileRequest, OpenWorld};
use trackwright_editor::document::state::WorldGeneration;
use trackwright_editor::runner::results::Results;
use trackwright_editor::shell::dialogs::{Dialog, Dialogs};
use trackwright_editor::workspaces;
use trackwright_editor::workspaces::decide::against::{Against, Found};
use trackwright_editor::workspaces::decide::baseline_ghost::BaselineGhostPlugin;
use trackwright_editor::workspaces::decide::dialog::DecideDialog;
use trackwright_editor::workspaces::decide::judged::Judged;
use trackwright_editor::workspaces::decide::panels::DecideView;
use trackwright_editor::workspaces::decide::panels::baseline_ui::baseline_ui;
use trackwright_editor::workspaces::decide::panels::steps_ui::steps_ui;
use trackwright_editor::workspaces::decide::panels::table_ui::table_ui;
use trackwright_editor::workspaces::decide::state::DecideState;
use trackwright_editor::workspaces::decide::table::AddedDesign;
use trackwright_editor::workspaces::decide::{DecidePlugin, DecideRequest};
use trackwright_editor::workspaces::field::FieldRequest;
use trackwright_procedure::Step;
use trackwright_project::RoomSource;
use trackwright_simulation::comparison::DifferenceVerdict;
use trackwright_simulation::study::{NoFigures, mode_of, study_with_figures};
use trackwright_simulation::{CancelToken, METRICS, Metric, Requirement, Scenario, Study};

pub(crate) fn decide_app() -> App {
    let mut app = create_app();
    app.add_plugins(DecidePlugin);
    app.insert_resource(OpenWorld(
        trackwright_project::open_builtin(trackwright_project::DEFAULT_BUILTIN).unwrap(),
    ));
    app.insert_resource(workspaces::decide::WORKSPACE);
    settle(&mut app);
    app
}

/// Updates until nothing is computed any more.
pub(crate) fn rest(app: &mut App) {
    let start = Instant::now();
    loop {
        settle(app);
        let is_idle = app.world().resource::<Against>().is_idle();
        let is_judged = app.world().resource::<Judged>().is_idle();
        if is_idle && is_judged && !app.world().resource::<DecideState>().is_busy() {
            // What was found last may be there since.
            settle(app);
            return;
        }
        assert!(start.elapsed() < Duration::from_secs(60), "never idle");
    }
}

pub(crate) fn request_and_wait(app: &mut App, request: DecideRequest) {
    app.world_mut().write_message(request);
    rest(app);
}

pub(crate) fn decide_state(app: &App) -> &DecideState {
    app.world().resource::<DecideState>()
}

pub(crate) fn found(app: &App) -> &Found {
    let serial = decide_state(app).pinned.as_ref().unwrap().serial;
    app.world().resource::<Against>().found(serial).unwrap().1
}

/// What a study of its own states of the open design.
fn own_study(app: &App) -> Study {
    let scenario = scenario(app);
    studied(&scenario, &mode_of(&scenario))
}

/// The same of a scenario, or why there are no figures.
fn with_figures(scenario: &Scenario) -> Result<Study, NoFigures> {
    study_with_figures(scenario, &mode_of(scenario), &CancelToken::default()).unwrap()
}

/// Moves the tool's first sensor along its shaft.
pub(crate) fn move_sensor(app: &mut App, by_mm: f64) {
    let mut sensors = document(app).design().tool.body.rigid.sensors.clone();
    sensors[0].position_in_body.z += by_mm;
    let edit = Edit::SetSensor { body: BodyRole::Tool, index: 0, sensor: sensors.remove(0) };
    request(app, EditRequest::Apply(edit));
    rest(app);
}

#[test]
fn a_pinned_state_differs_by_what_changed() {
    let mut app = decide_app();
    request_and_wait(&mut app, DecideRequest::PinHere);
    let against = found(&app).comparison.rows[1].against_baseline.clone();
    for difference in against.unwrap().differences {
        assert_eq!(difference.difference, 0.0);
        assert_eq!(difference.verdict, DifferenceVerdict::Negligible);
    }
    let before = own_study(&app);
    move_sensor(&mut app, 30.0);
    let now = own_study(&app);
    let [a, b] = [&now, &before].map(|study| METRICS.map(|m| study.figures.get(m).unwrap().value));
    let against = found(&app).comparison.rows[1].against_baseline.clone();
    let differences = against.unwrap().differences;
    for (index, difference) in differences.iter().enumerate() {
        assert_eq!(difference.difference, a[index] - b[index], "{:?}", METRICS[index]);
    }
    assert!(differences[0].difference != 0.0);
    // Back to what was pinned.
    request(&mut app, EditRequest::Undo);
    rest(&mut app);
    let against = found(&app).comparison.rows[1].against_baseline.clone();
    assert!((against.unwrap().differences).iter().all(|d| d.difference == 0.0));
}

#[test]
fn comparison_needs_workspace_and_baseline() {
    let mut app = decide_app();
    move_sensor(&mut app, 1.0);
    assert_eq!(decide_state(&app).counts.baselines, 0, "nothing is pinned");
    request_and_wait(&mut app, DecideRequest::PinHere);
    assert_eq!(decide_state(&app).counts.baselines, 1);
    app.insert_resource(workspaces::design::WORKSPACE);
    move_sensor(&mut app, 1.0);
    assert_eq!(decide_state(&app).counts.baselines, 1, "nothing shows it");
    app.insert_resource(workspaces::decide::WORKSPACE);
    rest(&mut app);
    assert_eq!(decide_state(&app).counts.baselines, 2);
    request_and_wait(&mut app, DecideRequest::Unpin);
    move_sensor(&mut app, 1.0);
    assert_eq!(decide_state(&app).counts.baselines, 2);
}

/// A built-in design in a folder of its own.
fn saved(folder: &Path, name: &str) -> PathBuf {
    let mut world = trackwright_project::open_builtin(name).unwrap();
    let file = folder.join(name).join(format!("{name}.design.ron"));
    std::fs::create_dir_all(file.parent().unwrap()).unwrap();
    trackwright_project::save_as(&mut world, &file).unwrap();
    file
}

#[test]
fn the_table_has_every_design_in_every_room() {
    let folder = tempfile::tempdir().unwrap();
    let other =
        trackwright_project::builtin_names().find(|n| *n != trackwright_project::DEFAULT_BUILTIN);
    let other = saved(folder.path(), other.unwrap());
    let gone = folder.path().join("gone.design.ron");
    let mut app = decide_app();
    let room = RoomSource::File(saved_room(folder.path()));
    for request in [
        DecideRequest::AddDesign(other.clone()),
        DecideRequest::AddDesign(gone.clone()),
        // Once more is once.
        DecideRequest::AddDesign(other.clone()),
        DecideRequest::AddRoom(room.clone()),
        DecideRequest::Compare,
    ] {
        request_and_wait(&mut app, request);
    }
    let compared = decide_state(&app).compared.as_ref().unwrap();
    assert_eq!(compared.comparison.rows.len(), 4);
    assert!(
        matches!(compared.missing.as_slice(), [why] if why.contains("gone.design.ron")),
        "{:?}",
        compared.missing
    );
    let row = &compared.comparison.rows[0];
    assert_eq!(row.measured.as_ref().unwrap().study, own_study(&app));
    // The other design in the other room.
    let row = &compared.comparison.rows[3];
    let world = trackwright_project::open_design_without_meshes(&other).unwrap();
    let environment = room.read().unwrap().bare;
    let scenario = trackwright_project::resolve(world.document.design(), &environment);
    match (&row.measured, with_figures(&scenario)) {
        (Ok(measured), Ok(expected)) => assert_eq!(measured.study, expected),
        (Err(NoFigures::NoOverlap { .. }), Err(NoFigures::NoOverlap { .. })) => {}
        (found, expected) => panic!("{found:?} {expected:?}"),
    }
}

#[test]
fn built_in_designs_are_compared_too() {
    let mut app = decide_app();
    let (own, other) = (trackwright_project::DEFAULT_BUILTIN, "endoscope");
    for request in [
        DecideRequest::AddBuiltIn(other),
        DecideRequest::AddBuiltIn(own),
        DecideRequest::AddBuiltIn(other),
        DecideRequest::Compare,
    ] {
        request_and_wait(&mut app, request);
    }
    assert_eq!(decide_state(&app).designs, [AddedDesign::BuiltIn(other)], "each once");
    let compared = decide_state(&app).compared.as_ref().unwrap();
    assert_eq!((compared.comparison.rows.len(), compared.missing.len()), (2, 0));
    let world = trackwright_project::open_builtin_without_meshes(other).unwrap();
    let room = Arc::clone(&app.world().resource::<OpenWorld>().0.environment);
    let scenario = trackwright_project::resolve(world.document.design(), &room);
    let found = compared.comparison.rows[1].measured.as_ref().unwrap();
    assert_eq!(found.study, with_figures(&scenario).unwrap());
    let requests = use_panel(&app, table_ui, |harness| {
        harness.get_by_label("Add built-in").click();
        harness.run_steps(2);
        harness.get_by_label("shaver-on-head").click();
    });
    assert_eq!(requests, [DecideRequest::AddBuiltIn("shaver-on-head")]);
    let opened = collect_messages::<FileRequest>(&mut app);
    request_and_wait(&mut app, DecideRequest::OpenRow(1));
    assert_eq!(*opened.lock().unwrap(), [FileRequest::OpenBuiltIn(other.to_owned())]);
}

#[test]
fn dialogs_begin_where_their_files_were_chosen_last() {
    let folder = tempfile::tempdir().unwrap();
    let [designs, recordings] = ["designs", "recordings"].map(|name| folder.path().join(name));
    for folder in [&designs, &recordings] {
        std::fs::create_dir(folder).unwrap();
    }
    let mut app = decide_app();
    let folder_of = |app: &mut App, request: DecideRequest| {
        request_and_wait(app, request);
        let dialog = app.world().resource::<Dialogs>().get::<DecideDialog>().cloned();
        let mut dialog = dialog.expect("a dialog");
        app.world_mut().resource_mut::<Dialogs>().current = None;
        dialog.files().unwrap().folder.clone()
    };
    let before = folder_of(&mut app, DecideRequest::ShowAddDesign);
    let chosen = vec![designs.join("a.design.ron"), designs.join("b.design.ron")];
    request_and_wait(&mut app, DecideRequest::AddDesigns(chosen));
    let table = DecideRequest::Recorded(BodyRole::Tool, recordings.join("poses.csv"));
    request_and_wait(&mut app, table);
    assert_eq!(folder_of(&mut app, DecideRequest::ShowAddDesign), designs);
    assert_eq!(folder_of(&mut app, DecideRequest::ShowPin), designs);
    let show = DecideRequest::ShowRecorded(BodyRole::Tool);
    assert_eq!(folder_of(&mut app, show), recordings);
    // Beside the open design again once it is gone.
    std::fs::remove_dir(&designs).unwrap();
    assert_eq!(folder_of(&mut app, DecideRequest::ShowAddDesign), before);
}

#[test]
fn a_row_opens_its_design_in_its_room() {
    let folder = tempfile::tempdir().unwrap();
    let other = saved(folder.path(), trackwright_project::DEFAULT_BUILTIN);
    let mut app = decide_app();
    let (opened, assigned) =
        (collect_messages::<FileRequest>(&mut app), collect_messages::<FieldRequest>(&mut app));
    let room = RoomSource::File(saved_room(folder.path()));
    for request in [
        DecideRequest::AddDesign(other.clone()),
        DecideRequest::AddRoom(room.clone()),
        DecideRequest::Compare,
        DecideRequest::OpenRow(3),
    ] {
        request_and_wait(&mut app, request);
    }
    // A room was added, so a dialog first decides what becomes of that.
    let open = Box::new(FileRequest::Open(other.clone()));
    app.world_mut().write_message(FileRequest::Discard(open));
    rest(&mut app);
    assert_eq!(opened.lock().unwrap()[0], FileRequest::Open(other));
    // The document's plugin has opened it; the room is the Field workspace's to assign.
    assert_eq!(*assigned.lock().unwrap(), [FieldRequest::Assign(room)]);
}

fn saved_room(folder: &Path) -> PathBuf {
    let file = folder.join("other.env.ron");
    let room = trackwright_project::builtin_rooms().next().unwrap().read().unwrap();
    super::app::write_environment(&file, &room.bare);
    file
}

/// The requests to others from now on.
fn collect_messages<M: Message + Clone>(app: &mut App) -> Arc<Mutex<Vec<M>>> {
    let received = Arc::new(Mutex::new(Vec::new()));
    let sink = Arc::clone(&received);
    app.add_message::<M>();
    app.add_systems(Last, move |mut messages: MessageReader<M>| {
        sink.lock().unwrap().extend(messages.read().cloned());
    });
    received
}

/// Draws a panel of the Decide workspace and uses it.
pub(crate) fn use_panel(
    app: &App,
    panel: impl Fn(&mut egui::Ui, &DecideView) -> Vec<DecideRequest>,
    use_it: impl FnOnce(&mut Harness),
) -> Vec<DecideRequest> {
    let world = &app.world().resource::<OpenWorld>().0;
    let view = DecideView {
        document: &world.document,
        generation: app.world().resource::<WorldGeneration>().0,
        results: app.world().resource::<Results>(),
        state: decide_state(app),
        against: Some(app.world().resource::<Against>()),
        judged: Some(app.world().resource::<Judged>()),
        environment: &world.environment.name,
        rooms: &[],
        is_listing: false,
    };
    super::harness::use_panel([1200.0, 700.0], |ui| panel(ui, &view), use_it)
}

#[test]
fn a_deleted_baseline_stays_with_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let file = saved(folder.path(), trackwright_project::DEFAULT_BUILTIN);
    let mut app = decide_app();
    request_and_wait(&mut app, DecideRequest::Pin(file.clone()));
    std::fs::remove_file(&file).unwrap();
    request_and_wait(&mut app, DecideRequest::Compare);
    use_panel(&app, baseline_ui, |harness| {
        harness.get_by_label_contains("has been deleted or moved");
        harness.get_by_label_contains("negligible (");
    });
    let requests = use_panel(&app, table_ui, |harness| {
        // Both designs are the same, and the room holds the same of them.
        let verdicts = ["✔ met", "✖ missed", "? cannot tell"]
            .map(|verdict| harness.query_all_by_label(verdict).count());
        assert_eq!(verdicts.iter().max(), Some(&2), "{verdicts:?}");
        harness.get_by_label("this design").click();
    });
    assert_eq!(requests, [DecideRequest::OpenRow(1)]);
    // Without a file there is nothing to open.
    request_and_wait(&mut app, DecideRequest::Pin(file));
    assert!(decide_state(&app).pinned.is_some(), "the one that was there stays");
}

#[test]
fn the_baseline_stays_with_the_design() {
    let folder = tempfile::tempdir().unwrap();
    let file = saved(folder.path(), trackwright_project::DEFAULT_BUILTIN);
    let kept = || trackwright_project::read_baseline(&file).unwrap();
    let session = |is_kept: bool| {
        let mut app = create_app();
        if is_kept {
            app.insert_resource(RecoveryFolder(folder.path().join("recovery")));
        }
        app.add_plugins(DecidePlugin);
        app.insert_resource(OpenWorld(trackwright_project::open_design(&file).unwrap()));
        app.insert_resource(workspaces::decide::WORKSPACE);
        rest(&mut app);
        app
    };
    // A picture leaves nothing on the disk.
    request_and_wait(&mut session(false), DecideRequest::PinHere);
    assert!(kept().is_none());
    let mut app = session(true);
    assert!(decide_state(&app).pinned.is_none() && kept().is_none());
    request_and_wait(&mut app, DecideRequest::PinHere);
    let pinned = Arc::clone(&decide_state(&app).pinned.as_ref().unwrap().design);
    assert_eq!(kept().unwrap().design, *pinned);
    // It is what it was when it was pinned, in the next session too.
    move_sensor(&mut app, 30.0);
    drop(app);
    let mut app = session(true);
    assert_eq!(decide_state(&app).pinned.as_ref().unwrap().design, pinned);
    request_and_wait(&mut app, DecideRequest::Unpin);
    assert!(kept().is_none());
    assert!(decide_state(&session(true)).pinned.is_none());
}

#[test]
fn the_baseline_ghost_needs_a_comparison() {
    let mut app = create_scene_app_with(|app| {
        app.add_plugins((DecidePlugin, BaselineGhostPlugin));
    });
    settle(&mut app);
    let drawn = |app: &mut App| (named(app, "baseline ghost"), named(app, "baseline sensors"));
    app.insert_resource(workspaces::decide::WORKSPACE);
    rest(&mut app);
    assert_eq!(drawn(&mut app), (0, 0));
    request_and_wait(&mut app, DecideRequest::PinHere);
    assert_eq!(drawn(&mut app), (1, 1));
    move_sensor(&mut app, 20.0);
    assert_eq!((drawn(&mut app), named(&mut app, "ghost")), ((1, 1), 1));
    app.insert_resource(workspaces::design::WORKSPACE);
    rest(&mut app);
    assert_eq!(drawn(&mut app), (0, 0));
    app.insert_resource(workspaces::decide::WORKSPACE);
    rest(&mut app);
    request_and_wait(&mut app, DecideRequest::Unpin);
    assert_eq!(drawn(&mut app), (0, 0));
}

#[test]
fn a_missed_step_needs_a_reason() {
    let mut app = decide_app();
    let strict = Requirement::at_most([(Metric::TIP_MAX, 0.01)]);
    let loose = Requirement::at_most([(Metric::TIP_MAX, 100.0)]);
    for edit in [Edit::SetCrfRequirement(Some(strict)), Edit::SetRequirement(Some(loose))] {
        request(&mut app, EditRequest::Apply(edit));
    }
    rest(&mut app);
    let requests = use_panel(&app, steps_ui, |harness| {
        harness.get_by_label_contains("missed in 3 of 3");
        // The CRF's is first, the tool's second: it meets its requirement.
        let decide: Vec<bool> = (harness.query_all_by_label("Decide"))
            .map(|button| button.accesskit_node().is_disabled())
            .collect();
        assert_eq!(decide, [true, false]);
        harness.query_all_by_label("Decide").nth(1).unwrap().click();
    });
    assert_eq!(requests, [DecideRequest::Decide(Step::Tool)]);
    request_and_wait(&mut app, DecideRequest::Decide(Step::Crf));
    let procedure = |app: &App| document(app).design().procedure.clone();
    assert!(procedure(&app).crf.is_none(), "without a reason");
    let note = "good enough for the first trial".to_owned();
    request_and_wait(&mut app, DecideRequest::SetNote(Step::Crf, note.clone()));
    request_and_wait(&mut app, DecideRequest::Decide(Step::Crf));
    assert_eq!(procedure(&app).crf.as_ref().unwrap().note, note);
    use_panel(&app, steps_ui, |harness| {
        harness.get_by_label_contains(&note);
        harness.get_by_label("Decide anew");
    });
    // Another bound is another ground.
    let less = Requirement::at_most([(Metric::TIP_MAX, 5.0)]);
    request(&mut app, EditRequest::Apply(Edit::SetCrfRequirement(Some(less))));
    rest(&mut app);
    let requests = use_panel(&app, steps_ui, |harness| {
        harness.get_by_label_contains("required position_max was 0.01, is 5");
        harness.get_by_label("Withdraw").click();
    });
    assert_eq!(requests, [DecideRequest::Withdraw(Step::Crf)]);
    request_and_wait(&mut app, DecideRequest::Withdraw(Step::Crf));
    assert!(procedure(&app).is_empty());
}

#[test]
fn a_decision_leaves_the_comparison_as_it_is() {
    let mut app = decide_app();
    let loose = Requirement::at_most([(Metric::TIP_MAX, 100.0)]);
    request(&mut app, EditRequest::Apply(Edit::SetRequirement(Some(loose))));
    rest(&mut app);
    request_and_wait(&mut app, DecideRequest::PinHere);
    request_and_wait(&mut app, DecideRequest::Compare);
    let changed = |app: &App| {
        let mut count = 0;
        use_panel(app, table_ui, |harness| {
            count = harness.query_all_by_label_contains("has changed since").count();
        });
        count
    };
    assert_eq!(changed(&app), 0);
    let document = |app: &App| app.world().resource::<OpenWorld>().0.document.clone();
    let before = document(&app).revision();
    request_and_wait(&mut app, DecideRequest::Decide(Step::Tool));
    assert!(document(&app).design().procedure.tool.is_some());
    assert!(document(&app).revision() > before, "a decision is an edit");
    assert_eq!(changed(&app), 0);
    move_sensor(&mut app, 1.0);
    assert_eq!(changed(&app), 1);
}

#[test]
fn the_next_design_starts_without_notes() {
    let mut app = decide_app();
    request_and_wait(&mut app, DecideRequest::SetNote(Step::Tool, "for this one".to_owned()));
    request_and_wait(&mut app, DecideRequest::Recorded(BodyRole::Tool, "poses.csv".into()));
    assert!(decide_state(&app).recorded.is_some());
    let other =
        trackwright_project::builtin_names().find(|n| *n != trackwright_project::DEFAULT_BUILTIN);
    let open = FileRequest::OpenBuiltIn(other.unwrap().to_owned());
    app.world_mut().write_message(open);
    rest(&mut app);
    assert!(decide_state(&app).recorded.is_none());
    assert_eq!(decide_state(&app).note(Step::Tool), "");
    // What is judged is the design that is open.
    let (status, is_current) = app.world().resource::<Judged>().found().unwrap();
    assert!(is_current && status.built.recording.is_none());
    // A request in the very frame in which a design opens is for that design.
    app.world_mut().resource_mut::<WorldGeneration>().set_changed();
    request_and_wait(&mut app, DecideRequest::Recorded(BodyRole::Tool, "poses.csv".into()));
    assert!(decide_state(&app).recorded.is_some());
}
