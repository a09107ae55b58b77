//! Our client against our server, and against whatever else may be at the other end.

use crate::support::wire::{
    Events, PATIENCE, Reader, events, free_address, number_of, numbered, until,
};
use std::io::{Read, Write};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::mpsc::Sender;
use std::time::{Duration, Instant};
use trackwright_openigtlink::client::{Client, ClientEvent, ClientOptions, DisconnectReason};
use trackwright_openigtlink::codec::{
    Content, DecodeError, HEADER_BYTES, Message, StartTracking, Timestamp, ToolKind,
};
use trackwright_openigtlink::relay::{Reason, RelayOptions, ToolState};
use trackwright_openigtlink::server::{LeaveReason, Server, ServerEvent, ServerOptions};
use trackwright_openigtlink::session::{Link, Session, SessionEvent, SessionSettings};

pub(super) fn anywhere() -> SocketAddr {
    "127.0.0.1:0".parse().unwrap()
}

/// On a machine that does other things no pose becomes too old.
pub(super) fn patient(address: SocketAddr) -> ServerOptions {
    ServerOptions { max_age: Duration::from_secs(60), ..ServerOptions::at(address) }
}

pub(super) fn serve(options: &ServerOptions) -> (Server, Events<ServerEvent>) {
    let (sender, events) = events();
    let server = Server::start(options, move |event| drop(sender.send(event))).unwrap();
    (server, events)
}

pub(super) fn send(server: &Server, tool: &str, number: u32) {
    server.send_transform(&numbered(tool, number), ToolKind::SixDof, Instant::now()).unwrap();
}

pub(super) fn joined(events: &Events<ServerEvent>) {
    events.wait_for("a client", |event| matches!(event, ServerEvent::Joined { .. }).then_some(()));
}

fn left(events: &Events<ServerEvent>) -> (LeaveReason, usize) {
    events.wait_for("a client that left", |event| match event {
        ServerEvent::Left { why, clients, .. } => Some((why, clients)),
        _ => None,
    })
}

/// A client that comes back at once.
pub(super) fn listen(address: SocketAddr) -> (Client, Events<ClientEvent>) {
    let mut options = ClientOptions::to(address.to_string());
    options.longest_wait = Duration::from_millis(100);
    let (sender, events): (Sender<ClientEvent>, _) = events();
    let client = Client::start(options, move |event| drop(sender.send(event))).unwrap();
    (client, events)
}

fn connected(events: &Events<ClientEvent>) {
    events.wait_for("a connection", |event| {
        matches!(event, ClientEvent::Connected { .. }).then_some(())
    });
}

pub(super) fn lost(events: &Events<ClientEvent>) -> DisconnectReason {
    events.wait_for("a loss", |event| match event {
        ClientEvent::Lost { why, .. } => Some(why),
        _ => None,
    })
}

pub(super) fn received(events: &Events<ClientEvent>) -> Message {
    events.wait_for("a message", |event| match event {
        ClientEvent::Received { message, .. } => Some(message),
        _ => None,
    })
}

#[test]
fn a_client_waits_and_reconnects() {
    let address = free_address();
    let (client, events) = listen(address);
    assert!(matches!(lost(&events), DisconnectReason::NotReached(_)));
    for round in 1..3 {
        let (server, served) = serve(&patient(address));
        connected(&events);
        joined(&served);
        send(&server, "Probe", round);
        let message = received(&events);
        assert_eq!((message.device.as_str(), number_of(&message)), ("Probe", Some(round)));
        server.stop();
        assert_eq!(lost(&events), DisconnectReason::Closed);
    }
    client.stop();
}

#[test]
fn other_protocols_are_reported() {
    let listener = TcpListener::bind(anywhere()).unwrap();
    let (_client, events) = listen(listener.local_addr().unwrap());
    let (mut first, _) = listener.accept().unwrap();
    first.write_all(&[b'x'; 5000]).unwrap();
    let error = events.wait_for("an error", |event| match event {
        ClientEvent::Unreadable(error) => Some(error),
        _ => None,
    });
    assert!(matches!(error, DecodeError::Header(_)), "{error}");
    assert_eq!(lost(&events), DisconnectReason::Unreadable);

    let (mut second, _) = listener.accept().unwrap();
    let message = numbered("Probe", 7).encode().unwrap();
    second.write_all(&message).unwrap();
    assert_eq!(number_of(&received(&events)), Some(7));
    // A message with a wrong checksum is one message lost.
    let mut wrong = message.clone();
    wrong[70] ^= 1;
    second.write_all(&wrong).unwrap();
    second.write_all(&message).unwrap();
    events.wait_for("a checksum", |event| {
        matches!(event, ClientEvent::Unreadable(DecodeError::Checksum { .. })).then_some(())
    });
    assert_eq!(number_of(&received(&events)), Some(7));
    // An end within a message is no end as any.
    second.write_all(&message[..80]).unwrap();
    second.shutdown(Shutdown::Both).unwrap();
    assert_eq!(lost(&events), DisconnectReason::Cut);
}

#[test]
fn a_client_that_sends_garbage_is_dropped() {
    let other = b"GET / HTTP/1.1\r\nHost: here\r\nAccept: */*\r\nConnection: close\r\n\r\n";
    let is_too_long = |error: &DecodeError| matches!(error, DecodeError::TooLong { found, .. } if *found == 4 << 30);
    let (server, served) = serve(&patient(anywhere()));
    let mut good = Reader::connect(server.address());
    joined(&served);
    for (number, bytes, has_length) in
        [(1, other.to_vec(), false), (2, header_announcing(b"TRANSFORM", 4 << 30), true)]
    {
        let mut bad = TcpStream::connect(server.address()).unwrap();
        joined(&served);
        bad.write_all(&bytes).unwrap();
        let (why, clients) = left(&served);
        let LeaveReason::Unreadable(error) = &why else { panic!("{why}") };
        assert_eq!((is_too_long(error), clients), (has_length, 1), "{error}");
        send(&server, "Probe", number);
        assert_eq!(number_of(&good.next_transform()), Some(number));
    }
}

/// The header of a message with so many bytes behind it.
pub(super) fn header_announcing(kind: &[u8], body_bytes: u64) -> Vec<u8> {
    let mut header = numbered("Probe", 1).encode().unwrap();
    header.truncate(HEADER_BYTES);
    header[2..14].fill(0);
    header[2..2 + kind.len()].copy_from_slice(kind);
    header[42..50].copy_from_slice(&body_bytes.to_be_bytes());
    header
}

/// A session without a room that serves anywhere, and what happens in it.
pub(super) fn session(
    client: ClientOptions,
    relay: RelayOptions,
    server: ServerOptions,
) -> (Session, Events<SessionEvent>) {
    let (sender, events) = events();
    let server = Some(server);
    let settings = SessionSettings { client, relay, room: None, server, record: None };
    let session = Session::start(settings, move |event| drop(sender.send(event.clone()))).unwrap();
    (session, events)
}

/// A client of the session that has joined it.
pub(super) fn view(session: &Session, events: &Events<SessionEvent>) -> Reader {
    let viewer = Reader::connect(session.address().unwrap());
    events.wait_for("a viewer", |event| {
        matches!(event, SessionEvent::Server(ServerEvent::Joined { .. })).then_some(())
    });
    viewer
}

#[test]
fn a_client_that_never_reads_is_dropped() {
    let mut options = patient(anywhere());
    options.queue = 64;
    options.stuck_after = Duration::from_secs(1);
    let (server, served) = serve(&options);
    let mut good = Reader::connect(server.address());
    joined(&served);
    let lazy = TcpStream::connect(server.address()).unwrap();
    joined(&served);
    // More than the system keeps for it and the queue together, for a second.
    let end = Instant::now() + PATIENCE;
    let mut number = 0;
    while server.clients() == 2 {
        number += 1;
        assert!(Instant::now() < end, "never dropped");
        send(&server, "Probe", number);
        // The other one reads each before the next is sent.
        assert_eq!(number_of(&good.next_transform()), Some(number));
    }
    let (why, clients) = left(&served);
    assert_eq!((why, clients), (LeaveReason::TooSlow, 1));
    assert!(server.dropped_messages() >= 64);
    drop(lazy);
}

#[test]
fn a_killed_client_leaves_and_the_others_receive_on() {
    let (server, served) = serve(&patient(anywhere()));
    let mut good = Reader::connect(server.address());
    let killed = Reader::connect(server.address());
    joined(&served);
    joined(&served);
    killed.stream.shutdown(Shutdown::Both).unwrap();
    drop(killed);
    let (why, clients) = left(&served);
    assert_eq!((why, clients), (LeaveReason::Closed, 1));
    send(&server, "Probe", 9);
    assert_eq!(number_of(&good.next_transform()), Some(9));
}

/// Files that this process may have open, as far as the system reports it.
pub(super) fn file_limit() -> usize {
    let limits = std::fs::read_to_string("/proc/self/limits").unwrap_or_default();
    let line = limits.lines().find_map(|line| line.strip_prefix("Max open files"));
    let soft = line.and_then(|line| line.split_whitespace().next());
    soft.and_then(|soft| soft.parse().ok()).unwrap_or(256)
}

#[test]
fn tracking_data_has_all_tools_at_once() {
    let (server, served) = serve(&patient(anywhere()));
    let mut client = Reader::connect(server.address());
    joined(&served);
    let request = |client: &mut Reader, content| {
        let message = Message::new("", Timestamp::NONE, content);
        client.stream.write_all(&message.encode().unwrap()).unwrap();
    };
    let start = |resolution_ms| StartTracking { resolution_ms, frame: String::new() };
    send(&server, "a", 1);
    send(&server, "b", 2);
    for _ in 0..2 {
        client.next_transform();
    }
    request(&mut client, Content::StartTracking(start(10)));
    assert_eq!(client.next().unwrap().content, Content::TrackingReply(0));
    let Content::Tracking(tools) = client.next().unwrap().content else { panic!("tracking data") };
    let found: Vec<_> = tools.iter().map(|t| (t.name.as_str(), t.matrix.0[9])).collect();
    assert_eq!(found, [("a", 1.0), ("b", 2.0)]);

    // A tool that is not good any more is in none.
    server.withdraw("a");
    send(&server, "b", 3);
    request(&mut client, Content::StartQuaternionTracking(start(10)));
    let tools = loop {
        match client.next().unwrap().content {
            Content::QuaternionTracking(tools) => break tools,
            Content::Tracking(tools) => assert!(tools.len() == 1),
            other => assert_eq!(other, Content::QuaternionTrackingReply(0)),
        }
    };
    assert_eq!((tools.len(), tools[0].at_mm[0]), (1, 3.0));
    request(&mut client, Content::StopQuaternionTracking);
    while client.next().unwrap().content != Content::QuaternionTrackingReply(0) {}
    send(&server, "b", 4);
    assert_eq!(number_of(&client.next_transform()), Some(4));

    // Requested by name.
    for (name, is_there) in [("b", true), ("a", false)] {
        let message = Message::new(name, Timestamp::NONE, Content::GetTransform);
        client.stream.write_all(&message.encode().unwrap()).unwrap();
        let answer = client.next().unwrap().content;
        assert_eq!(matches!(answer, Content::Transform(_)), is_there, "{answer:?}");
    }
}

#[test]
fn a_session_marks_stale_and_lost_tools() {
    let address = free_address();
    let tracker = Server::start(&patient(address), |_| {}).unwrap();
    let mut client = ClientOptions::to(address.to_string());
    client.longest_wait = Duration::from_millis(100);
    // Long for a tool, so that a machine that does other things is not taken for a stale one.
    let relay = RelayOptions { stale_after: Duration::from_secs(2), ..RelayOptions::default() };
    let (session, events) = self::session(client, relay, ServerOptions::at(anywhere()));
    let mut viewer = view(&session, &events);
    until("the session at the tracker", || tracker.clients() > 0);
    let tool_is = |state: ToolState| {
        events.wait_for("a tool's state", |event| match event {
            SessionEvent::Tool { state: found, .. } if found == state => Some(()),
            _ => None,
        });
    };
    send(&tracker, "Probe", 1);
    tool_is(ToolState::Good);
    assert_eq!(number_of(&viewer.next_transform()), Some(1));
    // It sends nothing more.
    tool_is(ToolState::NotGood(Reason::Stale));
    let status = viewer.next().unwrap();
    assert!(matches!(&status.content, Content::Status(s) if s.name == "STALE"), "{status:?}");
    assert_eq!(status.device, "Probe");
    send(&tracker, "Probe", 2);
    tool_is(ToolState::Good);
    tracker.stop();
    tool_is(ToolState::NotGood(Reason::LinkLost));
    events.wait_for("a loss", |event| matches!(event, SessionEvent::Lost { .. }).then_some(()));
    assert!(!matches!(session.state().link, Link::Connected { .. }));
    let end = session.stop();
    assert_eq!((end.counts.poses, end.counts.sent, end.connections), (2, 2, 1));
    assert_eq!(end.latency.count, 2);
    let mut rest = Vec::new();
    viewer.stream.read_to_end(&mut rest).unwrap();
}
