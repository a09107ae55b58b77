//! The paper's design procedure (section 4.1) in the editor, from an empty design to a decided tool: what
//! `docs/start/tutorial.md` describes. With `UPDATE_TUTORIAL` set, its pictures are painted.

use super::app::{document, scenario};
use super::decide::{decide_app, decide_state, move_sensor, request_and_wait, rest, use_panel};
use crate::support::studies::{built_in_room, steps};
use crate::support::table::measurement_columns;
use bevy::prelude::*;
use egui_kittest::kittest::Queryable;
use std::path::{Path, PathBuf};
use trackwright_calibration::room_model::RoomModel;
use trackwright_design::{BodyRole, Edit, Target};
use trackwright_editor::app::picture::{self, ComparedDesigns, PictureSetup};
use trackwright_editor::document::requests::{EditRequest, FileRequest, OpenWorld, SharedChoice};
use trackwright_editor::document::trials::TrialChoice;
use trackwright_editor::runner::results::Results;
use trackwright_editor::shell::window::Workspace;
use trackwright_editor::workspaces;
use trackwright_editor::workspaces::decide::DecideRequest;
use trackwright_editor::workspaces::decide::judged::Judged;
use trackwright_editor::workspaces::decide::panels::steps_ui::steps_ui;
use trackwright_field::DistortionModel;
use trackwright_geometry::pose::{Pose, pose_to_array};
use trackwright_procedure::{State, Step, StepStatus};
use trackwright_project::{RoomSource, Starter};
use trackwright_simulation::{
    CancelToken, Metric, Mode, Motion, Requirement, Scenario, Trial, run,
};

fn edit(app: &mut App, edit: Edit) {
    app.world_mut().write_message(EditRequest::Apply(edit));
    rest(app);
}

fn file(app: &mut App, request: FileRequest) {
    app.world_mut().write_message(request);
    rest(app);
}

fn step_status(app: &App) -> &StepStatus {
    let (step_status, is_current) = app.world().resource::<Judged>().found().unwrap();
    assert!(is_current, "of the design as it is");
    step_status
}

/// A second room: the field of the first as polynomials have it, half as strong again.
fn stronger_room(folder: &Path) -> PathBuf {
    let mut room = built_in_room(&RoomModel::PAPER, 1);
    let model = &room.model;
    let stronger = model.coefficients().iter().map(|c| c.map(|v| 1.5 * v));
    room.model = DistortionModel::new(
        model.order(),
        model.directions(),
        model.weighting(),
        model.map(),
        *model.bounds(),
        stronger.collect(),
    )
    .unwrap();
    // Nothing was measured in it: its model is taken for the field.
    (room.process, room.provenance) = (None, None);
    room.name = "Operating table, C-arm in".to_owned();
    let file = folder.join("c-arm-in.env.ron");
    super::app::write_environment(&file, &room);
    file
}

/// Every seventh pose of the motion is recorded: a tenth of them, spread over it.
const EVERY: usize = 7;

/// A table of recorded poses, true and measured, in the tracker's frame.
fn write_recording(file: &Path, rows: &[[Pose; 2]]) {
    let mut text = measurement_columns() + "\n";
    for row in rows {
        let cells = row.iter().flat_map(pose_to_array).map(|v| v.to_string());
        text += &(cells.collect::<Vec<_>>().join(",") + "\n");
    }
    std::fs::write(file, text).unwrap();
}

/// Every so manyeth trial of a scenario.
fn trials(scenario: &Scenario, mode: &Mode, every: usize) -> Vec<Trial> {
    let (mut number, mut kept) = (0, Vec::new());
    let mut visit = |trial: &Trial| {
        number += 1;
        if number % every == 0 {
            kept.push(*trial);
        }
    };
    run(scenario, mode, &CancelToken::default(), Some(&mut visit)).unwrap();
    kept
}

/// What the built tool would have recorded in its room: the poses of its motion as they are and as the
/// tracker reports them, a few hundredths off.
fn recording(app: &App, folder: &Path) -> PathBuf {
    let mut scenario = scenario(app);
    if let Some(crf) = scenario.crf.take() {
        scenario.crf_from_tool = crf.tracker_from_crf * scenario.crf_from_tool;
    }
    let shaken = |(index, trial): (usize, Trial)| {
        let phase = (EVERY * (index + 1)) as f64;
        let shake = [phase.sin(), (2.0 * phase).cos(), (3.0 * phase).sin()].map(|v| 0.05 * v);
        let measured =
            Pose::translation(shake[0], shake[1], shake[2]) * trial.crf_from_tool_simulated;
        [trial.crf_from_tool, measured]
    };
    let trials = trials(&scenario, &Mode::Motion, EVERY).into_iter();
    let rows: Vec<_> = trials.enumerate().map(shaken).collect();
    let file = folder.join("needle-built.csv");
    write_recording(&file, &rows);
    file
}

/// What the tracker reported of the CRF meanwhile, which lay still.
fn recording_of_crf(app: &App, folder: &Path, rows: usize) -> PathBuf {
    let mut scenario = scenario(app);
    let crf = scenario.crf.take().unwrap();
    scenario.crf_from_tool = crf.tracker_from_crf;
    scenario.tool = crf.body;
    let lain = trials(&scenario, &Mode::Single, 1).remove(0);
    let file = folder.join("crf-built.csv");
    let row = [lain.crf_from_tool, lain.crf_from_tool_simulated];
    write_recording(&file, &vec![row; rows]);
    file
}

/// A picture of the tutorial, where they are requested.
fn picture(app: &App, name: &str, workspace: Workspace, compared: ComparedDesigns) {
    if std::env::var_os("UPDATE_TUTORIAL").is_none() {
        return;
    }
    let world = app.world().resource::<OpenWorld>().0.clone();
    let setup = PictureSetup { has_panels: true, workspace, compared, ..PictureSetup::default() };
    let png = picture::png(world, [1440, 900], setup).unwrap();
    let file =
        Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("docs/pictures/tutorial-{name}.png"));
    std::fs::write(file, png).unwrap();
}

#[test]
fn from_an_empty_design_to_a_decided_tool() {
    let folder = tempfile::tempdir().unwrap();
    let mut app = decide_app();

    // 1. An empty design with a CRF, saved under its name.
    file(&mut app, FileRequest::New(Starter::ToolOnCrf));
    edit(&mut app, Edit::SetName("Biopsy needle".to_owned()));
    let saved = folder.path().join("needle.design.ron");
    file(&mut app, FileRequest::SaveAs(saved.clone()));
    assert_eq!(step_status(&app).state(Step::Crf), State::NoRequirement);
    assert_eq!(step_status(&app).state(Step::Built), State::NotRecorded);
    picture(&app, "1-new", workspaces::decide::WORKSPACE, ComparedDesigns::default());

    // 2. The rooms it is to be used in, and what is required of the CRF alone.
    let room = stronger_room(folder.path());
    request_and_wait(&mut app, DecideRequest::AddRoom(RoomSource::File(room)));
    for (name, position) in [("lesion", [40.0, 0.0, 60.0]), ("entry", [60.0, 0.0, 10.0])] {
        let target = Target { name: name.to_owned(), position_in_crf: position.into() };
        edit(&mut app, Edit::AddTarget(target));
    }
    let requirement = Requirement::at_most([(Metric::TIP_MAX, 0.3)]);
    edit(&mut app, Edit::SetCrfRequirement(Some(requirement)));
    assert_eq!(step_status(&app).crf.rows.len(), 4, "two targets in two rooms");
    assert_eq!(step_status(&app).state(Step::Crf), State::Missed);
    let counts = step_status(&app).crf.counts();
    assert_eq!((counts.missed, counts.cannot_tell), (3, 0));
    // What is missed is not decided without a reason.
    request_and_wait(&mut app, DecideRequest::Decide(Step::Crf));
    assert!(document(&app).design().procedure.crf.is_none());
    picture(&app, "2-crf-missed", workspaces::decide::WORKSPACE, ComparedDesigns::default());

    // 3. The patient lies nearer to the field generator.
    let pose = document(&app).design().crf.as_ref().unwrap().tracker_from_crf;
    let nearer = Pose::translation(0.0, 0.0, 140.0) * pose;
    edit(&mut app, Edit::SetCrfPose(nearer));
    assert_eq!(step_status(&app).state(Step::Crf), State::Met);
    request_and_wait(&mut app, DecideRequest::Decide(Step::Crf));
    assert_eq!(step_status(&app).state(Step::Crf), State::Decided);

    // 4. The tool over its motion, against the first draft of itself.
    let [shift, turn] = [20.0, 30.0].map(|reach| steps(reach, 2.0));
    let motion = Motion { x: shift, y: shift, z: shift, rx: turn, ry: turn, ..Motion::default() };
    edit(&mut app, Edit::SetMotion(Some(motion)));
    let requirement = Requirement::at_most([(Metric::TIP_RMS, 0.4), (Metric::TIP_MAX, 0.7)]);
    edit(&mut app, Edit::SetRequirement(Some(requirement)));
    file(&mut app, FileRequest::Save);
    let draft = folder.path().join("draft.design.ron");
    std::fs::copy(&saved, &draft).unwrap();
    request_and_wait(&mut app, DecideRequest::PinHere);
    move_sensor(&mut app, -50.0);
    // The draft keeps its body: this design gets one of its own.
    file(&mut app, FileRequest::Save);
    file(&mut app, FileRequest::SaveShared(SharedChoice::Copy));
    assert!(!document(&app).is_dirty());
    let found = super::decide::found(&app);
    let difference = &found.comparison.rows[1].against_baseline.as_ref().unwrap().differences[0];
    assert!(difference.difference < 0.0, "{difference:?}");
    assert_eq!(step_status(&app).state(Step::Tool), State::Met);
    picture(
        &app,
        "4-beside",
        workspaces::decide::WORKSPACE,
        ComparedDesigns { baseline: Some(draft), ..ComparedDesigns::default() },
    );
    let note = "The lesion is never nearer than 3 mm to a vessel".to_owned();
    request_and_wait(&mut app, DecideRequest::SetNote(Step::Tool, note.clone()));
    request_and_wait(&mut app, DecideRequest::Decide(Step::Tool));
    assert_eq!(step_status(&app).state(Step::Tool), State::Decided);
    assert_eq!(document(&app).design().procedure.tool.as_ref().unwrap().note, note);
    assert!(decide_state(&app).note(Step::Tool).is_empty());

    // 5. The built tool, measured in its room.
    let tool = recording(&app, folder.path());
    request_and_wait(&mut app, DecideRequest::Recorded(BodyRole::Tool, tool));
    assert_eq!(step_status(&app).state(Step::Built), State::Compared);
    let poses = trials(&scenario(&app), &Mode::Motion, EVERY).len();
    let crf = recording_of_crf(&app, folder.path(), poses);
    request_and_wait(&mut app, DecideRequest::Recorded(BodyRole::Crf, crf));
    assert_eq!(step_status(&app).state(Step::Built), State::Compared);
    request_and_wait(&mut app, DecideRequest::Decide(Step::Built));
    assert_eq!(step_status(&app).state(Step::Built), State::Decided);
    file(&mut app, FileRequest::Save);
    picture(&app, "5-decided", workspaces::decide::WORKSPACE, ComparedDesigns::default());

    // 6. Whoever opens it finds what was decided, and on what.
    let opened = trackwright_project::open_design(&saved).unwrap();
    assert_eq!(opened.document.design().procedure, document(&app).design().procedure);
    let step = |step| opened.document.design().procedure.decision(step).is_some();
    assert!(Step::ALL.into_iter().all(step));
    // A change is reported at every step that it concerns.
    move_sensor(&mut app, 5.0);
    assert_eq!(step_status(&app).state(Step::Crf), State::Decided);
    assert_eq!(step_status(&app).state(Step::Tool), State::DecidedOnOtherFigures);
    assert!(!step_status(&app).changes(Step::Tool).is_empty());
}

/// Without the CRF's own poses the errors are those in the tracker's frame, and the panel states it.
#[test]
fn a_crf_recording_judges_in_the_crf() {
    let folder = tempfile::tempdir().unwrap();
    let mut app = decide_app();
    file(&mut app, FileRequest::New(Starter::ToolOnCrf));
    let tool = recording(&app, folder.path());
    request_and_wait(&mut app, DecideRequest::Recorded(BodyRole::Tool, tool));
    let notes = |app: &App| app.world().resource::<Judged>().notes().to_vec();
    assert!(notes(&app)[0].starts_with("no recording of the CRF"), "{:?}", notes(&app));
    use_panel(&app, steps_ui, |harness| {
        harness.get_by_label_contains("no recording of the CRF");
    });
    let in_crf = trials(&scenario(&app), &Mode::Motion, EVERY);
    let crf = recording_of_crf(&app, folder.path(), in_crf.len());
    let requests = use_panel(&app, steps_ui, |harness| {
        harness.get_by_label("CRF's poses…").click();
    });
    assert_eq!(requests, [DecideRequest::ShowRecorded(BodyRole::Crf)]);
    request_and_wait(&mut app, DecideRequest::Recorded(BodyRole::Crf, crf));
    assert_eq!(notes(&app), [""; 0]);
    let found = step_status(&app).built.recording.clone().unwrap().unwrap().found;
    let squares: f64 = in_crf.iter().map(|t| t.tip_error_mm * t.tip_error_mm).sum();
    let rms_mm = (squares / in_crf.len() as f64).sqrt();
    assert!(
        (found.predicted_rms_mm - rms_mm).abs() < 1e-9 * rms_mm,
        "{} mm predicted, {rms_mm} mm in the study",
        found.predicted_rms_mm
    );
    // The poses were shaken by at most 0.05 mm along each axis.
    assert!(found.residual_rms_mm < 0.05 * 3f64.sqrt());
    // Pose by pose, the study is of the recorded poses, and what was measured is beside it.
    request_and_wait(&mut app, DecideRequest::ShowPoses);
    rest(&mut app);
    assert!(*app.world().resource::<Workspace>() == workspaces::study::WORKSPACE);
    let study = &app.world().resource::<Results>().study.as_ref().unwrap().value.room_field;
    assert_eq!(study.trials, in_crf.len());
    assert!((study.value(Metric::TIP_RMS) - rms_mm).abs() < 1e-9 * rms_mm);
    let choice = app.world().resource::<TrialChoice>();
    let measured = choice.measured(true).unwrap();
    let squares: f64 = measured.iter().map(|m| m.tip_error_in_crf_mm.norm_squared()).sum();
    let measured_mm = (squares / measured.len() as f64).sqrt();
    assert!((measured_mm - found.measured_rms_mm).abs() < 1e-9 * measured_mm);
    // The measured pose, which the scene shows, has these errors.
    let tip = scenario(&app).tool.judged_tip_in_body();
    for (measured, trial) in measured.iter().zip(choice.input().unwrap().trials.iter()) {
        let [pose, truth] = [measured.crf_from_tool.unwrap(), trial.crf_from_tool];
        let error = pose * tip - truth * tip;
        assert!((error - measured.tip_error_in_crf_mm).norm() < 1e-9, "{error} {measured:?}");
        let angle_deg = pose.rotation.angle_to(&truth.rotation).to_degrees();
        assert!((angle_deg - measured.angle_error_deg.unwrap()).abs() < 1e-6, "{angle_deg}");
    }
    app.insert_resource(workspaces::decide::WORKSPACE);
    rest(&mut app);
    // Saved elsewhere, it is still that recording.
    let elsewhere = tempfile::tempdir().unwrap();
    let saved = |folder: &Path| FileRequest::SaveAs(folder.join("needle.design.ron"));
    file(&mut app, saved(folder.path()));
    let table = &decide_state(&app).recorded.as_ref().unwrap().table;
    assert_eq!(table, "needle-built.csv", "beside the design");
    file(&mut app, saved(elsewhere.path()));
    let now = &step_status(&app).built.recording.as_ref().unwrap();
    let now = &now.as_ref().unwrap().found;
    assert_eq!(now.predicted_rms_mm, found.predicted_rms_mm);
    assert_ne!(now.recording.table, "needle-built.csv");
    // And back: the button that leaves the CRF's table out, and what the panel knows of the rest.
    let requests = use_panel(&app, steps_ui, |harness| {
        harness.get_by_label_contains("crf-built.csv");
        harness.get_by_label("registered to these poses").click();
    });
    let [DecideRequest::SetRecorded(changed)] = &requests[..] else {
        panic!("{requests:?}");
    };
    assert!(changed.is_registered && changed.crf_table.is_some());
}
