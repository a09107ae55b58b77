//! The Live workspace: a tracker's server on a real socket, and what the window makes of it.

use super::app::{
    create_app, create_scene_app_with, document, error, named, request, scenario, settle,
};
use super::harness::{panel, use_panel};
use crate::support::wire::{Events, PATIENCE, events, free_address, rest};
use bevy::prelude::*;
use egui_kittest::kittest::Queryable;
use nalgebra::Point3;
use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};
use trackwright_calibration::coverage::CoveragePlan;
use trackwright_design::{BodyRole, Edit};
use trackwright_editor::document::requests::{EditRequest, OpenWorld};
use trackwright_editor::document::shown::{LIVE, LivePoses, ShownDesign};
use trackwright_editor::runner::results::Results;
use trackwright_editor::runner::wake::Waker;
use trackwright_editor::shell::dialogs::ErrorDialog;
use trackwright_editor::workspaces;
use trackwright_editor::workspaces::live::cells::CellsPlugin;
use trackwright_editor::workspaces::live::panels::collecting::collecting_ui;
use trackwright_editor::workspaces::live::panels::tools::tools_ui;
use trackwright_editor::workspaces::live::panels::tracker::{recording_ui, tracker_ui};
use trackwright_editor::workspaces::live::state::LiveState;
use trackwright_editor::workspaces::live::{LivePlugin, LiveRequest};
use trackwright_editor::workspaces::study::StudyPlugin;
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_openigtlink::codec::{Content, Matrix, Message, Timestamp, ToolKind};
use trackwright_openigtlink::relay::{Reason, ToolState};
use trackwright_openigtlink::server::{Server, ServerEvent, ServerOptions};
use trackwright_openigtlink::session::{Link, Recording};
use trackwright_simulation::{BodyDetail, PoseDetail, simulate_pose};

/// A tracker's server, and who came to it.
struct Tracker {
    server: Server,
    events: Events<ServerEvent>,
}

impl Tracker {
    fn start(address: SocketAddr) -> Self {
        let (sender, events) = events();
        let server = Server::start(&ServerOptions::at(address), move |event| {
            drop(sender.send(event));
        });
        Self { server: server.unwrap(), events }
    }

    fn anywhere() -> Self {
        Self::start("127.0.0.1:0".parse().unwrap())
    }

    fn wait_for_client(&self) {
        self.events.wait_for("a client", |event| {
            matches!(event, ServerEvent::Joined { .. }).then_some(())
        });
    }

    fn send(&self, tool: &str, pose: &Pose) {
        let content = Content::Transform(Matrix::from_pose(pose));
        let message = Message::new(tool, Timestamp::now(), content);
        let server = &self.server;
        server.send_transform(&message, ToolKind::SixDof, Instant::now()).unwrap();
    }
}

fn live_app() -> App {
    let mut app = create_app();
    app.add_plugins((StudyPlugin, LivePlugin)).insert_resource(workspaces::live::WORKSPACE);
    settle(&mut app);
    app
}

fn request_and_wait(app: &mut App, request: LiveRequest) {
    app.world_mut().write_message(request);
    app.update();
}

fn connect(app: &mut App, tracker: &Tracker) {
    let server = tracker.server.address().to_string();
    request_and_wait(app, LiveRequest::SetServer(server));
    request_and_wait(app, LiveRequest::Connect);
    tracker.wait_for_client();
}

/// Updates, doing something before each, until something holds.
#[track_caller]
fn until(app: &mut App, what: &str, mut before: impl FnMut(), holds: impl Fn(&App) -> bool) {
    let end = Instant::now() + PATIENCE;
    while !holds(app) {
        assert!(Instant::now() < end, "waited for {what} in vain");
        before();
        rest(Duration::from_millis(5));
        app.update();
    }
}

fn live_state(app: &App) -> &LiveState {
    app.world().resource::<LiveState>()
}

fn state_of(app: &App, tool: &str) -> Option<ToolState> {
    let seen = live_state(app).seen.as_ref()?;
    Some(seen.tools.get(tool)?.state)
}

/// The design with its bodies somewhere else, and what is measured of them there.
fn elsewhere(app: &App) -> (Pose, Pose, PoseDetail) {
    let mut scenario = scenario(app);
    let turn = nalgebra::UnitQuaternion::from_euler_angles(0.2, -0.1, 0.7);
    scenario.crf_from_tool = pose_from_parts([30.0, -45.0, 12.0].into(), turn);
    let crf = scenario.crf.as_mut().unwrap();
    crf.tracker_from_crf = pose_from_parts([55.0, 20.0, -260.0].into(), turn.inverse());
    let tracker_from_crf = crf.tracker_from_crf;
    let tracker_from_tool = tracker_from_crf * scenario.crf_from_tool;
    (tracker_from_tool, tracker_from_crf, simulate_pose(&scenario))
}

fn apart_mm(a: &Pose, b: &Pose) -> f64 {
    let at = Point3::new(0.0, 0.0, 150.0);
    ((a * at) - (b * at)).norm().max((a.translation.vector - b.translation.vector).norm())
}

fn shown_live(app: &App) -> Option<&ShownDesign> {
    let shown = app.world().get_resource::<ShownDesign>()?;
    shown.live.is_some().then_some(shown)
}

const TOOL: &str = "PointerToTracker";
const CRF: &str = "HeadFrameToTracker";

#[test]
fn live_bodies_stand_at_compensated_poses() {
    let mut app = live_app();
    let tracker = Tracker::anywhere();
    connect(&mut app, &tracker);
    let before = document(&app).design().clone();
    let (tracker_from_tool, tracker_from_crf, detail) = elsewhere(&app);
    let crf: &BodyDetail = detail.crf.as_ref().unwrap();
    let send = || {
        tracker.send(TOOL, &detail.tool.tracker_from_body_fitted);
        tracker.send(CRF, &crf.tracker_from_body_fitted);
    };
    let is_there = |app: &App| {
        shown_live(app).is_some_and(|shown| {
            let at = |role| shown.design.tracker_from_body(role).unwrap();
            // Single precision at half a metre, twice, at the end of a lever.
            apart_mm(&at(BodyRole::Tool), &tracker_from_tool) < 2e-3
                && apart_mm(&at(BodyRole::Crf), &tracker_from_crf) < 2e-3
        })
    };
    until(&mut app, "the bodies", send, is_there);
    let of_live = |app: &App| app.world().resource::<Results>().pose_trial >= Some(LIVE);
    until(&mut app, "the errors", send, of_live);
    settle(&mut app);
    let results = app.world().resource::<Results>();
    let trial = &results.pose.as_ref().unwrap().value.trial;
    assert!((trial.tip_error_mm - detail.trial.tip_error_mm).abs() < 5e-3);
    // What was received is shown, and no part of the design.
    assert_eq!(*document(&app).design(), before);
    assert!(document(&app).undo_label().is_none());

    // A sensor that is moved is compensated by where it is then.
    let mut sensor = before.tool.body.rigid.sensors[0].clone();
    sensor.position_in_body = Point3::new(0.0, 0.0, 60.0);
    let edit = Edit::SetSensor { body: BodyRole::Tool, index: 0, sensor };
    request(&mut app, EditRequest::Apply(edit));
    app.update();
    let (tracker_from_tool, _, detail) = elsewhere(&app);
    let send = || tracker.send(TOOL, &detail.tool.tracker_from_body_fitted);
    until(&mut app, "the tool with its sensor moved", send, |app| {
        shown_live(app).is_some_and(|shown| {
            let at = shown.design.tracker_from_body(BodyRole::Tool).unwrap();
            apart_mm(&at, &tracker_from_tool) < 2e-3
        })
    });

    app.insert_resource(workspaces::design::WORKSPACE);
    settle(&mut app);
    let shown = app.world().resource::<ShownDesign>();
    assert_eq!((shown.live, &shown.trial), (None, &None));
    assert_eq!(*shown.design, *document(&app).design());
}

#[test]
fn a_silent_tool_is_stale_and_reconnects() {
    let mut app = live_app();
    let address = free_address();
    let tracker = Tracker::start(address);
    connect(&mut app, &tracker);
    let (.., detail) = elsewhere(&app);
    let measured = detail.tool.tracker_from_body_fitted;
    let good = |app: &App| state_of(app, TOOL) == Some(ToolState::Good);
    until(&mut app, "a good tool", || tracker.send(TOOL, &measured), good);
    let stale = Some(ToolState::NotGood(Reason::Stale));
    until(&mut app, "a stale tool", || (), |app| state_of(app, TOOL) == stale);
    let design = document(&app).design();
    let troubles = live_state(&app).troubles(design);
    let expected = [
        "Pointer, last good pose: no sample came in time",
        "Head frame, as designed: no pose received",
    ];
    let [tool, crf] = expected.map(str::to_owned);
    assert_eq!(troubles, [(BodyRole::Tool, tool), (BodyRole::Crf, crf)]);

    tracker.server.stop();
    let lost = |app: &App| {
        let link = &live_state(app).seen.as_ref().unwrap().link;
        matches!(link, Link::Lost { .. } | Link::Connecting)
    };
    until(&mut app, "the loss", || (), lost);
    assert_eq!(state_of(&app, TOOL), Some(ToolState::NotGood(Reason::LinkLost)));
    let tracker = Tracker::start(address);
    tracker.wait_for_client();
    until(&mut app, "the tool again", || tracker.send(TOOL, &measured), good);

    request_and_wait(&mut app, LiveRequest::Disconnect);
    assert!(!live_state(&app).is_connected() && !app.world().resource::<LivePoses>().is_any());
    settle(&mut app);
    assert!(shown_live(&app).is_none(), "the design stands as it is designed");
}

#[test]
fn while_it_records_the_volume_fills_and_no_longer() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("session.csv");
    let mut app = live_app();
    let tracker = Tracker::anywhere();
    connect(&mut app, &tracker);
    let distinct = |app: &App| {
        let collected = live_state(app).collected.as_ref();
        collected.map_or(0, |collected| collected.summary.distinct)
    };
    let mut sent = 0;
    // Every one 20 mm from the one before: another part of a cell.
    let mut send = || {
        sent = (sent + 1) % 20;
        let at = [f64::from(sent) * 20.0 - 200.0, 0.0, -300.0];
        tracker.send("Wand", &pose_from_parts(at.into(), Default::default()));
    };
    let is_received = |app: &App| state_of(app, "Wand").is_some();
    until(&mut app, "the wand", &mut send, is_received);
    assert!(live_state(&app).collected.is_none(), "nothing is recorded yet");

    request_and_wait(&mut app, LiveRequest::Record(file.clone()));
    until(&mut app, "five places", &mut send, |app| distinct(app) >= 5);
    let world = &app.world().resource::<OpenWorld>().0;
    let collected = live_state(&app).collected.clone().unwrap();
    assert_eq!(collected.plan, CoveragePlan::of(&world.environment));
    assert_eq!(collected.summary.cells, 1000);
    assert!(collected.next_mm.is_some() && collected.summary.cells_sampled >= 2);

    request_and_wait(&mut app, LiveRequest::StopRecording);
    until(&mut app, "the end of the recording", || (), |app| !live_state(app).is_recording());
    let left = distinct(&app);
    for _ in 0..10 {
        send();
        app.update();
    }
    assert_eq!(distinct(&app), left, "what is not recorded is not collected");
    let recording =
        trackwright_project::Files::default().read_recording(&file).unwrap().as_it_stands();
    assert!(recording.tools.iter().any(|tool| tool.name == "Wand"));

    // A recording is never written over, and what was collected stays.
    request_and_wait(&mut app, LiveRequest::Record(file.clone()));
    let ErrorDialog { title, text } = error(&app);
    assert_eq!(title, "Nothing can be recorded");
    assert!(text.contains("session.csv"), "{text}");
    assert_eq!(distinct(&app), left);
    request_and_wait(&mut app, LiveRequest::StartOver);
    until(&mut app, "a new start", || (), |app| live_state(app).collected.is_none());
}

#[test]
fn poses_wake_only_the_live_workspace() {
    let mut app = live_app();
    let woken = Arc::new(AtomicUsize::new(0));
    let counter = Arc::clone(&woken);
    app.insert_resource(Waker::new(move || {
        counter.fetch_add(1, Ordering::Relaxed);
    }));
    let tracker = Tracker::anywhere();
    connect(&mut app, &tracker);
    let (.., detail) = elsewhere(&app);
    let measured = detail.tool.tracker_from_body_fitted;
    let good = |app: &App| state_of(app, TOOL) == Some(ToolState::Good);
    until(&mut app, "a good tool", || tracker.send(TOOL, &measured), good);

    app.insert_resource(workspaces::design::WORKSPACE);
    app.update();
    let poses = app.world().resource::<LivePoses>().number;
    let samples = |app: &App| live_state(app).seen.as_ref().unwrap().counts.sent;
    let seen = samples(&app);
    // Long enough for the last of before to have been received, not for the tool to be stale.
    rest(Duration::from_millis(40));
    let before = woken.load(Ordering::Relaxed);
    for _ in 0..20 {
        tracker.send(TOOL, &measured);
        rest(Duration::from_millis(5));
        app.update();
    }
    let woken = woken.load(Ordering::Relaxed) - before;
    // On a machine that is busy elsewhere the tool may have been stale and good again.
    assert!(woken <= 4, "{woken} wakes of 20 poses");
    assert_eq!(samples(&app), seen, "what is not shown is not read");
    assert_eq!(app.world().resource::<LivePoses>().number, poses);
}

#[test]
fn an_invalid_address_connects_nothing() {
    let mut app = live_app();
    request_and_wait(&mut app, LiveRequest::SetServer("tracker-of-room-3".into()));
    request_and_wait(&mut app, LiveRequest::Connect);
    let problem = live_state(&app).problem.clone().unwrap();
    assert!(
        problem.contains("tracker-of-room-3") && problem.contains("expected HOST:PORT"),
        "{problem}"
    );
    assert!(!live_state(&app).is_connected());
}

#[test]
fn a_port_in_use_is_reported_and_nothing_connects() {
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port();
    let mut app = live_app();
    request_and_wait(&mut app, LiveRequest::SetPort(Some(port)));
    request_and_wait(&mut app, LiveRequest::Connect);
    let problem = live_state(&app).problem.clone().unwrap();
    assert!(problem.contains(&port.to_string()), "{problem}");
    assert!(!live_state(&app).is_connected());
}

#[test]
fn scene_blocks_belong_to_the_workspace() {
    let mut app = create_scene_app_with(|app| {
        app.add_plugins((LivePlugin, CellsPlugin)).insert_resource(workspaces::live::WORKSPACE);
    });
    settle(&mut app);
    let folder = tempfile::tempdir().unwrap();
    let tracker = Tracker::anywhere();
    connect(&mut app, &tracker);
    assert_eq!(named(&mut app, "collected"), 0);
    request_and_wait(&mut app, LiveRequest::Record(folder.path().join("session.csv")));
    let at = pose_from_parts([10.0, 0.0, -300.0].into(), Default::default());
    let send = || tracker.send("Wand", &at);
    until(&mut app, "a sample", send, |app| live_state(app).collected.is_some());
    app.update();
    assert_eq!(named(&mut app, "collected"), 1);
    app.insert_resource(workspaces::design::WORKSPACE);
    app.update();
    app.update();
    assert_eq!(named(&mut app, "collected"), 0);
    app.insert_resource(workspaces::live::WORKSPACE);
    app.update();
    app.update();
    assert_eq!(named(&mut app, "collected"), 1);
}

#[test]
fn the_live_panels_show_and_request() {
    let mut app = live_app();
    let tracker = Tracker::anywhere();
    connect(&mut app, &tracker);
    let (.., detail) = elsewhere(&app);
    let far = pose_from_parts([4000.0, 0.0, -300.0].into(), Default::default());
    let send = || {
        tracker.send(TOOL, &detail.tool.tracker_from_body_fitted);
        tracker.send("Wand", &far);
    };
    let both = |app: &App| state_of(app, TOOL).is_some() && state_of(app, "Wand").is_some();
    until(&mut app, "both tools", send, both);
    let design = document(&app).design().clone();
    let state = live_state(&app);
    let (mut harness, requests) = panel([224.0, 700.0], move |ui| {
        let mut requests = tracker_ui(ui, state);
        requests.extend(tools_ui(ui, state, &design));
        requests.extend(recording_ui(ui, state));
        requests.extend(collecting_ui(ui, state));
        requests
    });
    harness.run_steps(2);
    harness.get_by_label(&format!("connected to {}", tracker.server.address()));
    harness.get_by_label("Pointer");
    harness.get_by_label("not good: it is outside the box that the room was measured in");
    harness.get_by_label("Record…").click();
    harness.run_steps(2);
    harness.get_by_label("Disconnect").click();
    harness.run_steps(2);
    assert_eq!(*requests.borrow(), [LiveRequest::ShowRecord, LiveRequest::Disconnect]);
}

#[test]
fn a_failed_recording_can_be_followed_by_another() {
    let mut app = live_app();
    let tracker = Tracker::anywhere();
    connect(&mut app, &tracker);
    let mut state = app.world_mut().resource_mut::<LiveState>();
    state.seen.as_mut().unwrap().recording = Some(Recording {
        file: "/rooms/session.csv".into(),
        samples: 1234,
        failed: Some("/rooms/session.csv: cannot be written: disk full".to_owned()),
    });
    assert!(!state.is_recording());
    let state = &*state;
    let requests = use_panel(
        [224.0, 300.0],
        |ui| recording_ui(ui, state),
        |harness| {
            harness.get_by_label("session.csv");
            harness
                .get_by_label_contains("Nothing more is recorded: /rooms/session.csv: cannot be");
            assert!(harness.query_by_label("Stop recording").is_none());
            harness.get_by_label("Record…").click();
        },
    );
    assert_eq!(requests, [LiveRequest::ShowRecord]);
}
