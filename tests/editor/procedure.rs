//! The paper's design procedure (section 4.1) in the editor, from an empty design to a decided tool: what
//! `docs/tutorial.md` tells. With `UPDATE_TUTORIAL` set, its pictures are painted.

use super::decide::{ask, decide_app, desk, move_sensor, rest};
use bevy::prelude::*;
use std::path::{Path, PathBuf};
use trackwright::design::{Document, Edit, Target};
use trackwright::editor::decide::DecideRequest;
use trackwright::editor::decide::judged::Judged;
use trackwright::editor::picture::{self, ComparedDesigns, Desk};
use trackwright::editor::state::{EditRequest, FileRequest, OpenWorld, SharedChoice, Workspace};
use trackwright::field::DistortionModel;
use trackwright::geometry::pose::{Pose, pose_to_array};
use trackwright::store::{self, RoomPlace, Starter};
use trackwright::study::procedure::{Standing, State, Step};
use trackwright::study::{AxisRange, CancelToken, Mode, Motion, Requirement, Trial, run};

fn edit(app: &mut App, edit: Edit) {
    app.world_mut().write_message(EditRequest::Apply(edit));
    rest(app);
}

fn file(app: &mut App, asked: FileRequest) {
    app.world_mut().write_message(asked);
    rest(app);
}

fn standing(app: &App) -> &Standing {
    let (standing, is_current) = app.world().resource::<Judged>().found().unwrap();
    assert!(is_current, "of the design as it is");
    standing
}

fn document(app: &App) -> &Document {
    &app.world().resource::<OpenWorld>().0.document
}

/// A second room: the field of the first, half as strong again.
fn stronger_room(app: &App, folder: &Path) -> PathBuf {
    let mut room = (*app.world().resource::<OpenWorld>().0.environment).clone();
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
    room.name = "Operating table, C-arm in".to_owned();
    let file = folder.join("c-arm-in.env.ron");
    store::write_environment(&file, &room).unwrap();
    file
}

/// What the built tool would have recorded in its room: the poses of its motion in the tracker's frame,
/// as they are and as the tracker tells them, a few hundredths off.
fn recording(app: &App, folder: &Path) -> PathBuf {
    let world = &app.world().resource::<OpenWorld>().0;
    let mut scenario = store::resolve(world.document.design(), &world.environment);
    let tracker_from_crf = scenario
        .crf
        .take()
        .map_or(Pose::identity(), |c| c.tracker_from_crf);
    scenario.crf_from_tool = tracker_from_crf * scenario.crf_from_tool;
    let mut text = String::from(
        "ideal_x,ideal_y,ideal_z,ideal_qw,ideal_qx,ideal_qy,ideal_qz,measured_x,measured_y,measured_z,\
         measured_qw,measured_qx,measured_qy,measured_qz\n",
    );
    let mut number = 0;
    let mut visit = |trial: &Trial| {
        number += 1;
        // A tenth of them, spread over the motion.
        if number % 7 != 0 {
            return;
        }
        let shaken = Pose::translation(
            0.05 * f64::from(number).sin(),
            0.05 * f64::from(2 * number).cos(),
            0.05 * f64::from(3 * number).sin(),
        );
        let measured = shaken * trial.crf_from_tool_simulated;
        let cells: Vec<String> = [&trial.crf_from_tool, &measured]
            .into_iter()
            .flat_map(|pose| pose_to_array(pose).map(|v| v.to_string()))
            .collect();
        text += &(cells.join(",") + "\n");
    };
    run(
        &scenario,
        &Mode::Motion,
        &CancelToken::default(),
        Some(&mut visit),
    )
    .unwrap();
    let file = folder.join("needle-built.csv");
    std::fs::write(&file, text).unwrap();
    file
}

/// A picture of the tutorial, where they are asked for.
fn picture(app: &App, name: &str, workspace: Workspace, compared: ComparedDesigns) {
    if std::env::var_os("UPDATE_TUTORIAL").is_none() {
        return;
    }
    let world = app.world().resource::<OpenWorld>().0.clone();
    let desk = Desk {
        has_panels: true,
        workspace,
        compared,
        ..Desk::default()
    };
    let png = picture::png(world, [1440, 900], desk).unwrap();
    let file =
        Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("docs/pictures/tutorial-{name}.png"));
    std::fs::write(file, png).unwrap();
}

fn shift(reach: f64) -> Option<AxisRange> {
    Some(AxisRange {
        min: -reach,
        max: reach,
        step: reach,
    })
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
    assert_eq!(standing(&app).state(Step::Crf), State::NoRequirement);
    assert_eq!(standing(&app).state(Step::Built), State::NotRecorded);
    picture(&app, "1-new", Workspace::Decide, ComparedDesigns::default());

    // 2. The rooms it is to be used in, and what is asked of the CRF alone.
    let room = stronger_room(&app, folder.path());
    ask(&mut app, DecideRequest::AddRoom(RoomPlace::File(room)));
    for (name, position) in [("lesion", [40.0, 0.0, 60.0]), ("entry", [60.0, 0.0, 10.0])] {
        let target = Target {
            name: name.to_owned(),
            position_in_crf: position.into(),
        };
        edit(&mut app, Edit::AddTarget(target));
    }
    let asked = Requirement {
        position_max_mm: Some(0.3),
        ..Requirement::default()
    };
    edit(&mut app, Edit::SetCrfRequirement(Some(asked)));
    assert_eq!(standing(&app).crf.rows.len(), 4, "two targets in two rooms");
    assert_eq!(standing(&app).state(Step::Crf), State::Missed);
    // What is missed is not decided without a reason.
    ask(&mut app, DecideRequest::Decide(Step::Crf));
    assert!(document(&app).design().procedure.crf.is_none());
    picture(
        &app,
        "2-crf-missed",
        Workspace::Decide,
        ComparedDesigns::default(),
    );

    // 3. The patient lies nearer to the field generator.
    let pose = document(&app)
        .design()
        .crf
        .as_ref()
        .unwrap()
        .tracker_from_crf;
    let nearer = Pose::translation(0.0, 0.0, 100.0) * pose;
    edit(&mut app, Edit::SetCrfPose(nearer));
    assert_eq!(standing(&app).state(Step::Crf), State::Met);
    ask(&mut app, DecideRequest::Decide(Step::Crf));
    assert_eq!(standing(&app).state(Step::Crf), State::Decided);

    // 4. The tool over its motion, against the first draft of itself.
    edit(
        &mut app,
        Edit::SetMotion(Some(Motion {
            x: shift(20.0),
            y: shift(20.0),
            z: shift(20.0),
            rx: shift(30.0),
            ry: shift(30.0),
            ..Motion::default()
        })),
    );
    let asked = Requirement {
        position_rms_mm: Some(0.3),
        position_max_mm: Some(0.6),
        ..Requirement::default()
    };
    edit(&mut app, Edit::SetRequirement(Some(asked)));
    file(&mut app, FileRequest::Save);
    let draft = folder.path().join("draft.design.ron");
    std::fs::copy(&saved, &draft).unwrap();
    ask(&mut app, DecideRequest::PinHere);
    move_sensor(&mut app, -50.0);
    // The draft keeps its body: this design gets one of its own.
    file(&mut app, FileRequest::Save);
    file(&mut app, FileRequest::SaveShared(SharedChoice::Copy));
    assert!(!document(&app).is_dirty());
    let found = super::decide::found(&app);
    let difference = found.comparison.rows[1]
        .against_baseline
        .as_ref()
        .unwrap()
        .differences[0];
    assert!(difference.difference < 0.0, "{difference:?}");
    assert_eq!(standing(&app).state(Step::Tool), State::Met);
    picture(
        &app,
        "4-beside",
        Workspace::Decide,
        ComparedDesigns {
            baseline: Some(draft),
            ..ComparedDesigns::default()
        },
    );
    let note = "The lesion is never nearer than 3 mm to a vessel".to_owned();
    ask(&mut app, DecideRequest::SetNote(Step::Tool, note.clone()));
    ask(&mut app, DecideRequest::Decide(Step::Tool));
    assert_eq!(standing(&app).state(Step::Tool), State::Decided);
    assert_eq!(
        document(&app)
            .design()
            .procedure
            .tool
            .as_ref()
            .unwrap()
            .note,
        note
    );
    assert!(desk(&app).note(Step::Tool).is_empty());

    // 5. The built tool, measured in its room.
    let recorded = recording(&app, folder.path());
    ask(&mut app, DecideRequest::Recorded(recorded.clone()));
    assert_eq!(standing(&app).state(Step::Built), State::Compared);
    ask(&mut app, DecideRequest::Decide(Step::Built));
    assert_eq!(standing(&app).state(Step::Built), State::Decided);
    file(&mut app, FileRequest::Save);
    picture(
        &app,
        "5-decided",
        Workspace::Decide,
        ComparedDesigns::default(),
    );

    // 6. Whoever opens it finds what was decided, and on what.
    let opened = store::open_design(&saved).unwrap();
    assert_eq!(
        opened.document.design().procedure,
        document(&app).design().procedure
    );
    let step = |step| opened.document.design().procedure.decision(step).is_some();
    assert!(Step::ALL.into_iter().all(step));
    // A change is told at every step that it concerns.
    move_sensor(&mut app, 5.0);
    assert_eq!(standing(&app).state(Step::Crf), State::Decided);
    assert_eq!(
        standing(&app).state(Step::Tool),
        State::DecidedOnOtherFigures
    );
    assert!(!standing(&app).changes(Step::Tool).is_empty());
}
