//! A tracker's poses received, recorded and served on, by the program as a person runs it.

use crate::support::live_load::tracker;
use crate::support::live_program::{Live, address_in};
use crate::support::program::Scratch;
use crate::support::table::poses_table;
use crate::support::wire::{Reader, free_address, number_of, numbered, numbered_pose, until};
use serde_json::Value;
use std::net::TcpListener;
use std::path::Path;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};
use trackwright_formats::recording::live_table;
use trackwright_geometry::pose::{Pose, pose_from_array};
use trackwright_openigtlink::codec::{Content, Matrix, Message, Timestamp, ToolKind};
use trackwright_openigtlink::server::Server;
use trackwright_simulation::simulate_pose;

fn send(server: &Server, tool: &str, number: u32) {
    server.send_transform(&numbered(tool, number), ToolKind::SixDof, Instant::now()).unwrap();
}

/// A tracker, the program behind it as it is started, and a client of the program, all connected.
fn session_of(start: impl FnOnce(&[&str]) -> Live, more: &[&str]) -> (Server, Live, Reader) {
    let server = tracker(free_address());
    let connect = server.address().to_string();
    let live = start(&[&["--connect", &connect, "--serve", "0"], more].concat());
    let note = live.wait_for_note("serving at");
    assert!(note.contains("for this machine alone"), "{note}");
    let viewer = Reader::connect(address_in(&note));
    live.wait_for_note("joined, 1 now");
    until("a client", || server.clients() > 0);
    (server, live, viewer)
}

fn session(more: &[&str]) -> (Server, Live, Reader) {
    session_of(Live::start, more)
}

#[test]
fn poses_are_recorded_served_and_counted() {
    let scratch = Scratch::new();
    let recording = scratch.arg("live.csv");
    let (server, live, mut viewer) = session(&["--record", &recording]);
    for number in 1..=20 {
        for tool in ["ProbeToTracker", "StylusToTracker"] {
            send(&server, tool, number);
            let received = viewer.next_transform();
            assert_eq!((received.device.as_str(), number_of(&received)), (tool, Some(number)));
        }
    }
    live.wait_for_note("StylusToTracker: good");
    // While it is being written.
    let read = || live_table::parse(&std::fs::read(scratch.path("live.csv")).unwrap()).unwrap();
    let count = || read().tools.iter().map(|tool| tool.samples.len()).sum::<usize>();
    until("forty samples", || count() >= 40);
    let found = read();
    let probe = found.tool(Some("Probe")).unwrap();
    let off = |(pose, number): (&Pose, u32)| {
        let expected = numbered_pose(number);
        (pose.translation.vector - expected.translation.vector).norm()
            + pose.rotation.angle_to(&expected.rotation)
    };
    assert!(probe.good().zip(1..).map(off).all(|off| off < 1e-4));
    assert_eq!(probe.good().count(), 20);

    server.stop();
    live.wait_for_note("lost: the server closed the connection");
    let end = live.interrupt();
    for (key, expected) in [("poses", 40), ("sent", 40), ("recorded", 40), ("connections", 1)] {
        assert_eq!(end[key], expected, "{end}");
    }
    assert_eq!(end["tools"], serde_json::json!(["ProbeToTracker", "StylusToTracker"]));
    assert_eq!(end["latency_ms"]["count"], 40);
    assert_eq!(end["age_ms"]["count"], 40);
    let shift_ms = end["clock_shift_ms"]["ProbeToTracker"].as_f64().unwrap();
    // What drift allows for in a minute.
    assert!((0.0..12.0).contains(&shift_ms), "{shift_ms}");

    // What was recorded is a recording for others, the tool named.
    scratch.refused(format!("pivot {recording} --tool Probe"), &["too little variation"]);
    let again = scratch.fail(format!("live --connect localhost:1 --record {recording}"));
    assert!(again.contains("live.csv: cannot be written: a file is there already"), "{again}");
}

#[test]
fn a_failed_recording_stops_nothing_else() {
    let scratch = Scratch::new();
    let recording = scratch.arg("live.csv");
    let (server, live, mut viewer) =
        session_of(Live::start_on_a_small_disk, &["--record", &recording]);
    let pass = |numbers: std::ops::Range<u32>, viewer: &mut Reader| {
        for number in numbers {
            send(&server, "Probe", number);
            assert_eq!(number_of(&viewer.next_transform()), Some(number));
        }
    };
    // Some 100 bytes each, on 4 KB at most.
    pass(1..100, &mut viewer);
    let note = live.wait_for_note("nothing more is recorded");
    assert!(note.contains("live.csv"), "{note}");
    pass(100..150, &mut viewer);
    let end = live.interrupt();
    assert_eq!(end["sent"], 149, "{end}");
    let why = end["not_recorded"].as_str().unwrap();
    assert!(why.contains("live.csv") && note.contains(why), "{end}");
    // All that was reported as recorded is there, and nothing of the line that was not whole.
    let bytes = std::fs::read(&recording).unwrap();
    assert!(bytes.ends_with(b"\n"), "the last line is cut");
    let lines = bytes.split(|byte| *byte == b'\n').count() as u64 - 2;
    assert_eq!(end["recorded"], lines);
    let found = live_table::parse(&std::fs::read(&recording).unwrap()).unwrap();
    let recorded = found.tools[0].good().count() as u64;
    assert_eq!(end["recorded"], recorded);
    assert!((10..99).contains(&recorded), "{recorded}");
}

#[test]
fn served_poses_are_those_of_compensate() {
    let scratch = Scratch::new();
    let [env, recording] = ["room.env.ron", "live.csv"].map(|name| scratch.arg(name));
    scratch.fit("room.env.ron", "--order 1 --directions 1");
    // Single precision changes what is measured: both correct the same numbers.
    let mut message = numbered("Probe", 60);
    let Content::Transform(matrix) = &message.content else { panic!("a transform") };
    scratch.write("poses.csv", poses_table([matrix.pose().unwrap()]));
    scratch.succeed("compensate room.env.ron poses.csv -o out.csv");
    let expected = pose_from_array(scratch.table("out.csv").first()[0]).unwrap();

    let (server, live, mut viewer) = session(&["--environment", &env, "--record", &recording]);
    // Far outside the box: reported, and not sent.
    send(&server, "Probe", 100_000);
    live.wait_for_note("Probe: not good, it is outside the box");
    // After the other one.
    message.timestamp = Timestamp::now();
    server.send_transform(&message, ToolKind::SixDof, Instant::now()).unwrap();
    let received = viewer.next_transform();
    let Content::Transform(matrix) = &received.content else { panic!("a transform") };
    let found = matrix.pose().unwrap();
    let moved_mm = (found.translation.vector - numbered_pose(60).translation.vector).norm();
    assert!(moved_mm > 0.1, "{moved_mm}");
    // Half a unit in the last place of 250 mm.
    assert!((found.translation.vector - expected.translation.vector).amax() < 2e-5);
    assert!(found.rotation.angle_to(&expected.rotation) < 1e-6);
    assert_eq!(received.timestamp, message.timestamp);
    let end = live.interrupt();
    assert_eq!((&end["poses"], &end["sent"]), (&Value::from(2), &Value::from(1)));
    assert_eq!(end["dropped"]["outside_model"], 1);
    let kept = live_table::parse(&std::fs::read(&recording).unwrap()).unwrap();
    let x = |pose: &Pose| pose.translation.x;
    assert_eq!(kept.tools[0].good().map(x).collect::<Vec<_>>(), [100_000.0, 60.0]);
}

#[test]
fn a_served_tool_is_where_its_sensors_are() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/designs/pointer-on-head.design.ron");
    let world = trackwright_project::open_design_without_meshes(Path::new(file)).unwrap();
    let detail =
        simulate_pose(&trackwright_project::resolve(world.document.design(), &world.environment));
    let (server, _live, mut viewer) = session(&["--design", file]);
    let crf = detail.crf.as_ref().unwrap();
    for (name, body) in [("PointerToTracker", &detail.tool), ("ReferenceToTracker", crf)] {
        let matrix = Matrix::from_pose(&body.tracker_from_body_fitted);
        let message = Message::new(name, Timestamp::now(), Content::Transform(matrix));
        server.send_transform(&message, ToolKind::SixDof, Instant::now()).unwrap();
        let received = viewer.next_transform();
        let Content::Transform(matrix) = &received.content else { panic!("a transform") };
        let found = matrix.pose().unwrap();
        let off_mm = |pose: &Pose| {
            let expected = body.tracker_from_body.translation.vector;
            (pose.translation.vector - expected).norm()
        };
        // Single precision at half a metre, there and back.
        assert!(off_mm(&found) < 5e-4, "{name}: {} mm", off_mm(&found));
        assert!(off_mm(&body.tracker_from_body_fitted) > 0.1);
    }
}

#[test]
fn an_end_after_seconds_reports_that_nothing_came() {
    let connect = free_address();
    let end = Scratch::new().json(format!("live --connect {connect} --seconds 0.3"));
    assert_eq!((&end["connections"], &end["messages"]), (&Value::from(0), &Value::from(0)));
    assert_eq!(end["latency_ms"], Value::Null);
}

#[test]
fn at_its_end_clients_receive_the_sessions_end() {
    let (server, live, mut viewer) = session(&[]);
    send(&server, "Probe", 1);
    assert_eq!(number_of(&viewer.next_transform()), Some(1));
    live.interrupt();
    let mut statuses = Vec::new();
    while let Some(message) = viewer.next() {
        if let Content::Status(status) = message.content {
            assert!(status.text.contains("the session ends"), "{status:?}");
            statuses.push((message.device, status.name));
        }
    }
    let expected = ["Probe", "trackwright"].map(|of| (of.to_owned(), "SESSION_ENDS".to_owned()));
    assert_eq!(statuses, expected);
}

#[test]
fn names_are_shown_escaped_and_kept_as_they_are() {
    let (server, live, mut viewer) = session(&[]);
    let name = "Pro\u{202e}be";
    send(&server, name, 1);
    assert_eq!(viewer.next_transform().device, name);
    live.wait_for_note(r"Pro\u{202e}be: good");
    let (out, end) = live.interrupt_printing();
    assert!(out.contains(r"Pro\u202ebe"), "{out}");
    assert_eq!(end["tools"], serde_json::json!([name]));
}

#[test]
fn clients_beyond_the_file_limit_are_refused() {
    let server = tracker(free_address());
    let connect = server.address().to_string();
    let live = Live::start_after("ulimit -n 40", &["--connect", &connect, "--serve", "0"]);
    let address = address_in(&live.wait_for_note("serving at"));
    until("a client", || server.clients() > 0);
    let count = 60;
    let mut clients: Vec<Reader> = (0..count).map(|_| Reader::connect(address)).collect();
    live.wait_for_note("a client cannot be accepted");
    for _ in 0..2 {
        live.wait_for_note("refused");
    }
    // Every client receives one or the other.
    let (mut served, mut refused) = (0, 0);
    let (stop, stopped) = channel::<()>();
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let stopped = stopped;
            for number in 1.. {
                send(&server, "Probe", number);
                if stopped.recv_timeout(Duration::from_millis(20)) != Err(RecvTimeoutError::Timeout)
                {
                    break;
                }
            }
        });
        for client in &mut clients {
            match client.next().map(|message| message.content) {
                Some(Content::Transform(_)) => served += 1,
                Some(Content::Status(status)) if status.name == "TOO_MANY_CLIENTS" => refused += 1,
                other => panic!("{other:?}"),
            }
        }
        drop(stop);
    });
    assert_eq!(served + refused, count);
    assert!(served >= 10 && refused >= 20, "{served} {refused}");
}

#[test]
fn wrong_arguments_fail_before_anything_runs() {
    let scratch = Scratch::new();
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port();
    let connect = "--connect localhost:1";
    for (args, words) in [
        (format!("{connect} --serve {port}"), format!("port {port} of 127.0.0.1 is in use")),
        (format!("{connect} --environment no.env.ron"), "no.env.ron: File not found".into()),
        (format!("{connect} --environment no.env.ron --frame ''"), "found an empty name".into()),
        (format!("{connect} --environment no.env.ron --frame ' '"), "found an empty name".into()),
        ("--connect localhost".into(), "expected HOST:PORT".into()),
    ] {
        scratch.refused(format!("live {args}"), &[&words]);
    }
}
