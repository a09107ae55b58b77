//! Programs that others wrote, at the other end: pyigtl, and the examples of the OpenIGTLink library.

use super::connections::{anywhere, joined, patient};
use crate::support::live_load::tracker;
use crate::support::live_program::{Live, address_in, lines_of};
use crate::support::peers::{openigtlink, python};
use crate::support::program::Scratch;
use crate::support::wire::{Events, events, free_address, numbered, rest, until};
use nalgebra::Vector3;
use serde_json::Value;
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use trackwright_openigtlink::client::{Client, ClientEvent, ClientOptions};
use trackwright_openigtlink::codec::{Content, Extension, Message, ToolKind};
use trackwright_openigtlink::relay::{Output, Reason, Relay, RelayOptions, ToolState, described};
use trackwright_openigtlink::server::{Server, ServerEvent};
use trackwright_project::Files;

/// A program of somebody else, ended with the test.
struct Peer(Child);

impl Peer {
    fn start(mut command: Command, arguments: &[&dyn ToString]) -> Self {
        command.args(arguments.iter().map(|argument| argument.to_string()));
        let command = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        Self(command.spawn().unwrap())
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        // Gone already is as good.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn listen(options: ClientOptions) -> (Client, Events<Message>) {
    let (sender, events) = events();
    let send_message = move |event| {
        if let ClientEvent::Received { message, .. } = event {
            let _ = sender.send(message);
        }
    };
    (Client::start(options, send_message).unwrap(), events)
}

fn serve() -> (Server, Events<ServerEvent>) {
    super::connections::serve(&patient(anywhere()))
}

/// How often transforms are sent to a peer that prints each of them.
const OFTEN: Duration = Duration::from_millis(25);

/// How often they are sent to a peer that requests tracking data, and requests their end after ten messages
/// of any kind: the first request has to be read before.
const SELDOM: Duration = Duration::from_millis(400);

/// Sends numbered transforms until the peer has printed enough lines to see what is wanted.
fn send_until<R>(
    server: &Server,
    peer: &mut Peer,
    interval: Duration,
    pick: impl FnMut(&str) -> Option<R>,
) -> R {
    sent_until(server, peer, interval, pick).unwrap_or_else(|printed| panic!("in vain: {printed}"))
}

/// The same for a minute; all that was printed, where it was in vain.
fn sent_until<R>(
    server: &Server,
    peer: &mut Peer,
    interval: Duration,
    mut pick: impl FnMut(&str) -> Option<R>,
) -> Result<R, String> {
    let lines = lines_of(peer.0.stderr.take().unwrap());
    let mut printed = String::new();
    let started = Instant::now();
    for number in (1000..).take_while(|_| started.elapsed() < Duration::from_secs(60)) {
        let mut message = numbered("ProbeToTracker", number);
        message.extension = None;
        server.send_transform(&message, ToolKind::SixDof, Instant::now()).unwrap();
        rest(interval);
        for line in lines.try_iter() {
            printed += &line;
            printed.push('\n');
        }
        if let Some(found) = pick(&printed) {
            return Ok(found);
        }
    }
    Err(printed)
}

#[test]
fn transforms_of_pyigtl_are_received() {
    let address = free_address();
    let mut peer = Peer::start(python("igtl_server.py"), &[&address.port()]);
    let (_client, events) = listen(ClientOptions::to(address.to_string()));
    let mut relay = Relay::new(None, RelayOptions::default());
    let mut stdin = peer.0.stdin.take().unwrap();
    for (line, state) in [
        ("Probe 10 1 OK", ToolState::Good),
        ("Stylus 11 2 OK", ToolState::Good),
        ("Lost 12 2 INVALID", ToolState::NotGood(Reason::NotTracked)),
    ] {
        writeln!(stdin, "{line}").unwrap();
        let message = events.wait_for("a transform", Some);
        let (name, rest) = line.split_once(' ').unwrap();
        assert_eq!(message.device, name);
        assert_eq!(message.extension.is_some(), rest.contains(" 2 "));
        assert!(message.timestamp.is_stated());
        let mut out = Vec::new();
        relay.receive(&message, Instant::now(), &mut out);
        let found = out.iter().find_map(|output| match output {
            Output::Pose(sent) => Some((ToolState::Good, Some(sent.pose))),
            Output::Status { state, .. } => Some((*state, None)),
            _ => None,
        });
        let (found, pose) = found.unwrap();
        assert_eq!(found, state);
        if let Some(pose) = pose {
            let x: f64 = rest.split_once(' ').unwrap().0.parse().unwrap();
            let moved = pose * nalgebra::Point3::new(1.0, 0.0, 0.0);
            assert!((moved.coords - Vector3::new(x, 21.0, 30.0)).norm() < 1e-6, "{moved}");
        }
    }
}

#[test]
fn pyigtl_receives_our_transforms_in_both_versions() {
    for version in [1, 2] {
        let (server, served) = serve();
        let port = server.address().port();
        let mut peer = Peer::start(python("igtl_client.py"), &[&port, &"ProbeToTracker"]);
        joined(&served);
        let mut message = numbered("ProbeToTracker", 1234);
        if version == 2 {
            let mut extension = Extension::default();
            extension.set("TransformStatus", "OK");
            message.extension = Some(extension);
        }
        server.send_transform(&message, ToolKind::SixDof, Instant::now()).unwrap();
        let mut printed = String::new();
        peer.0.stdout.take().unwrap().read_to_string(&mut printed).unwrap();
        let found: Value =
            serde_json::from_str(&printed).unwrap_or_else(|e| panic!("{e}: {printed}"));
        let Content::Transform(matrix) = message.content else { panic!("a transform") };
        for row in 0..3 {
            for column in 0..4 {
                // The last digit of a double is not what was sent.
                let found = found["matrix"][row][column].as_f64().unwrap() as f32;
                assert_eq!(found, matrix.0[3 * column + row]);
            }
        }
        assert_eq!(found["version"], version);
        let off_s = found["timestamp"].as_f64().unwrap() - message.timestamp.seconds();
        assert!(off_s.abs() < 1e-6, "{off_s}");
        if version == 2 {
            assert_eq!(found["metadata"]["TransformStatus"], "OK");
        }
    }
}

/// The room that comes with the program, and an inner pose of it.
pub(super) const ROOM: &str =
    concat!(env!("CARGO_MANIFEST_DIR"), "/assets/environments/operating-table.env.ron");

/// A tracker's server, the program in between, and where it serves.
fn relayed(arguments: &[&str]) -> (Server, Live, u16) {
    let server = tracker(free_address());
    let connect = server.address().to_string();
    let ends = ["--connect", &connect, "--serve", "0"];
    let live = Live::start(&[&ends, arguments].concat());
    let port = address_in(&live.wait_for_note("serving at")).port();
    until("the program", || server.clients() > 0);
    (server, live, port)
}

#[test]
fn pyigtl_reads_what_is_known_of_every_pose() {
    let files = Files::default();
    let room = files.read_environment(std::path::Path::new(ROOM)).unwrap();
    let mut without_support = room.clone();
    (without_support.fit_validity, without_support.process) = (None, None);
    let scratch = Scratch::new();
    let unknown = scratch.arg("unknown.env.ron");
    let output = files.output(std::path::Path::new(&unknown)).unwrap();
    output.write_environment(&without_support).unwrap();
    let middle = room.model.bounds().center_mm();
    for (environment, has_support) in [(ROOM, true), (unknown.as_str(), false)] {
        let (server, live, port) = relayed(&["--environment", environment]);
        let mut peer = Peer::start(python("igtl_metadata.py"), &[&port, &"ProbeToTracker", &40]);
        live.wait_for_note("joined, 1 now");
        let mut lines = BufReader::new(peer.0.stdout.take().unwrap()).lines();
        let mut valid = 0;
        for number in 0..40 {
            let mut message = numbered("ProbeToTracker", number);
            let Content::Transform(matrix) = &mut message.content else { panic!("a transform") };
            // Along a line through the box.
            let at = middle.coords + 2.0 * (f64::from(number) - 20.0) * Vector3::new(1.0, 0.5, 0.2);
            for (value, at) in matrix.0[9..].iter_mut().zip(at.iter()) {
                *value = *at as f32;
            }
            server.send_transform(&message, ToolKind::SixDof, Instant::now()).unwrap();
            // Each is read before the next is sent: pyigtl keeps the last one only.
            let line = lines.next().expect("a line for every pose").unwrap();
            let metadata: Value = serde_json::from_str(&line).unwrap();
            let number = |key: &str| -> Option<f64> {
                let text = metadata[key].as_str().unwrap_or_else(|| panic!("{key}: {line}"));
                (text != described::UNKNOWN).then(|| text.parse().unwrap())
            };
            assert!(number(described::LATENCY_MS).unwrap() >= 0.0);
            assert!(number(described::CLOCK_SHIFT_MS).unwrap() >= 0.0);
            let [tip_mm, std_mm, std_deg] =
                [described::TIP_RMS_MM, described::STD_MM, described::STD_DEG].map(number);
            let validity = metadata[described::VALIDITY].as_str().unwrap();
            if !has_support {
                assert_eq!((validity, tip_mm, std_mm), ("unknown", None, None));
                continue;
            }
            let (tip_mm, std_mm) = (tip_mm.unwrap(), std_mm.unwrap());
            assert!(std_mm > 0.0 && tip_mm >= std_mm, "{line}");
            assert!(std_deg.is_some_and(|deg| deg > 0.0), "{line}");
            assert!(["valid", "invalid"].contains(&validity), "{line}");
            valid += u32::from(validity == "valid");
        }
        assert_eq!(valid > 0, has_support);
    }
}

#[test]
fn the_librarys_clients_are_served_by_the_program() {
    let (server, live, port) = relayed(&["--header-version", "1"]);
    let mut peer = Peer::start(openigtlink("ReceiveClient"), &[&"127.0.0.1", &port]);
    live.wait_for_note("joined, 1 now");
    send_until(&server, &mut peer, OFTEN, |printed| {
        let count = printed.matches("Receiving TRANSFORM data type.").count();
        (count >= 10).then_some(())
    });
    // A client that sends a request is recognised by it. This one ends after ten messages of any kind, whether its
    // request was read by then or not.
    let is_served = (0..3).any(|_| {
        let (server, live, port) = relayed(&[]);
        let mut peer = Peer::start(openigtlink("TrackingDataClient"), &[&"127.0.0.1", &port, &40]);
        live.wait_for_note("joined, 1 now");
        let wanted = ["Receiving : RTS_TDATA", "Name       : ProbeToTracker", "Type       : 2"];
        let pick = |printed: &str| wanted.iter().all(|part| printed.contains(part)).then_some(());
        sent_until(&server, &mut peer, SELDOM, pick).is_ok()
    });
    assert!(is_served);
}

#[test]
fn the_librarys_tracker_server_is_received() {
    let address = free_address();
    let _peer = Peer::start(openigtlink("TrackerServer"), &[&address.port(), &40]);
    let (_client, events) = listen(ClientOptions::to(address.to_string()));
    let message = events.wait_for("a transform", Some);
    assert_eq!(message.device, "Tracker");
    assert!(matches!(message.content, Content::Transform(_)), "{message:?}");

    let address = free_address();
    let _peer = Peer::start(openigtlink("TrackingDataServer"), &[&address.port()]);
    let mut options = ClientOptions::to(address.to_string());
    options.tracking_ms = Some(25);
    let (_client, events) = listen(options);
    let tools = events.wait_for("tracking data", |message| match message.content {
        Content::Tracking(tools) => Some(tools),
        _ => None,
    });
    let found: Vec<_> = tools.iter().map(|tool| (tool.name.as_str(), tool.kind)).collect();
    let expected = [
        ("Channel 0", ToolKind::Tracker),
        ("Channel 1", ToolKind::SixDof),
        ("Channel 2", ToolKind::FiveDof),
    ];
    assert_eq!(found, expected);
}
