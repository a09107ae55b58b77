//! Senders that delay, lie about lengths and send bad names, and clients that stop reading.

use super::connections::{
    anywhere, file_limit, header_announcing, joined, listen, lost, patient, received, send, serve,
    session, view,
};
use crate::support::wire::{Events, PATIENCE, Reader, number_of, numbered, rest, until};
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::time::{Duration, Instant};
use trackwright_openigtlink::client::{ClientEvent, ClientOptions, DisconnectReason};
use trackwright_openigtlink::codec::{
    Content, DecodeError, HEADER_BYTES, Matrix, Message, StatusCode, Timestamp, ToolKind,
    TrackingElement,
};
use trackwright_openigtlink::relay::{ClockChange, Reason, RelayOptions, ToolState, described};
use trackwright_openigtlink::server::{ServerEvent, ServerOptions};
use trackwright_openigtlink::session::{Session, SessionEvent};

/// A session, what it listens to, and one client of it.
struct Relayed {
    session: Session,
    events: Events<SessionEvent>,
    tracker: TcpStream,
    viewer: Reader,
}

impl Relayed {
    fn start(relay: RelayOptions) -> Self {
        let listener = TcpListener::bind(anywhere()).unwrap();
        let client = ClientOptions::to(listener.local_addr().unwrap().to_string());
        let (session, events) = session(client, relay, ServerOptions::at(anywhere()));
        let viewer = view(&session, &events);
        let (tracker, _) = listener.accept().unwrap();
        tracker.set_nodelay(true).unwrap();
        Self { session, events, tracker, viewer }
    }

    /// Sends a message that is as old as this.
    fn send(&mut self, tool: &str, number: u32, age_s: f64) {
        let mut message = numbered(tool, number);
        message.timestamp.0 -= (age_s * 2.0_f64.powi(32)) as u64;
        self.tracker.write_all(&message.encode().unwrap()).unwrap();
    }
}

/// Until so many poses have been judged.
fn wait_for_poses(session: &Session, count: u64) {
    until("poses", || session.state().counts.poses >= count);
}

/// A machine that does other things is not taken for a delay.
fn patient_relay() -> RelayOptions {
    RelayOptions { stale_after: Duration::from_secs(20), ..RelayOptions::default() }
}

#[test]
fn delays_beyond_the_bound_are_never_sent_as_good() {
    // Constant, growing and jumping; each beyond the bound from the first frame that is late.
    let delays: [fn(u32) -> f64; 3] = [
        |_| 100.0,
        |frame| 100.0 + 0.02 * f64::from(frame),
        |frame| 100.0 + 60.0 * f64::from(frame % 2),
    ];
    for delay in delays {
        let mut relayed = Relayed::start(patient_relay());
        for number in 1..=20 {
            relayed.send("Probe", number, 0.0);
            assert_eq!(number_of(&relayed.viewer.next_transform()), Some(number));
        }
        for frame in 0..339 {
            relayed.send("Probe", 21 + frame, delay(frame));
        }
        wait_for_poses(&relayed.session, 359);
        let end = relayed.session.stop();
        assert_eq!(end.counts.sent, 20);
        assert_eq!(end.counts.dropped[&Reason::Late], 339);
        while let Some(message) = relayed.viewer.next() {
            assert!(!matches!(message.content, Content::Transform(_)), "{message:?}");
        }
    }
}

#[test]
fn lasting_lateness_is_followed_only_on_request() {
    for follows_clock_steps in [false, true] {
        let options = RelayOptions {
            stale_after: Duration::from_secs(1),
            follows_clock_steps,
            ..RelayOptions::default()
        };
        let mut relayed = Relayed::start(options);
        relayed.send("Probe", 1, 0.0);
        assert_eq!(number_of(&relayed.viewer.next_transform()), Some(1));
        // Stamped 50 s ago, for as long as it takes to be reported, and followed.
        let end = Instant::now() + PATIENCE;
        let mut changes = Vec::new();
        let is_done = |changes: &[ClockChange]| match follows_clock_steps {
            false => !changes.is_empty(),
            true => matches!(changes.last(), Some(ClockChange::Step { .. })),
        };
        for number in 2.. {
            assert!(Instant::now() < end, "{changes:?}");
            relayed.send("Probe", number, 50.0);
            rest(Duration::from_millis(25));
            while let Some(event) = relayed.events.try_next() {
                if let SessionEvent::Clock { change, .. } = event {
                    changes.push(change);
                }
            }
            if is_done(&changes) {
                break;
            }
        }
        let late = |change: &ClockChange| matches!(change, ClockChange::Late { by_s } if (by_s - 50.0).abs() < 1.0);
        assert!(late(&changes[0]), "{changes:?}");
        if follows_clock_steps {
            // Every pose states the shift from then on.
            let pose = relayed.viewer.next_transform();
            let extension = pose.extension.unwrap();
            let shift_ms: f64 = extension.get(described::CLOCK_SHIFT_MS).unwrap().parse().unwrap();
            assert!((shift_ms - 50e3).abs() < 1e3, "{shift_ms}");
            let shift_s = relayed.session.stop().tools["Probe"].clock.shift_s;
            assert!((shift_s - 50.0).abs() < 1.0, "{shift_s}");
        } else {
            until("the report that it is late", || {
                let state = relayed.session.state();
                assert_eq!(state.counts.sent, 1);
                state.tools["Probe"].state == ToolState::NotGood(Reason::Late)
            });
        }
    }
}

#[test]
fn bad_names_cost_only_their_own_poses() {
    let mut relayed = Relayed::start(patient_relay());
    let mut viewer = relayed.viewer;
    let counted = std::thread::spawn(move || {
        let mut counted = 0;
        while let Some(message) = viewer.next() {
            counted += u32::from(message.device == "Probe" && number_of(&message).is_some());
        }
        counted
    });
    let element = |name: &str| TrackingElement {
        name: name.to_owned(),
        kind: ToolKind::SixDof,
        matrix: Matrix([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 3.0]),
    };
    for number in 1..=120 {
        let good = numbered("Probe", number).encode().unwrap();
        relayed.tracker.write_all(&good).unwrap();
        let mut bad = numbered("x", number).encode().unwrap();
        bad[14..18].copy_from_slice(b"\xff\xfe\x1b[");
        relayed.tracker.write_all(&bad).unwrap();
        let content = Content::Tracking(vec![element("Wand"), element("")]);
        let list = Message::new("", Timestamp::now(), content);
        let mut bytes = list.encode().unwrap();
        // A name that is no text in a list, with the checksum of what it is now.
        let second = HEADER_BYTES + 70;
        bytes[second] = 0xff;
        let checksum = crc::Crc::<u64>::new(&crc::CRC_64_ECMA_182);
        let of_body = checksum.checksum(&bytes[HEADER_BYTES..]);
        bytes[50..58].copy_from_slice(&of_body.to_be_bytes());
        relayed.tracker.write_all(&bytes).unwrap();
    }
    wait_for_poses(&relayed.session, 360);
    let end = relayed.session.stop();
    assert_eq!((end.counts.sent, end.connections, end.unreadable), (240, 1, 120));
    assert_eq!(end.counts.dropped[&Reason::NoName], 120);
    let (mut unreadable, mut refused) = (0, 0);
    while let Some(event) = relayed.events.try_next() {
        unreadable +=
            u32::from(matches!(event, SessionEvent::Unreadable(DecodeError::Name { .. })));
        refused += u32::from(matches!(event, SessionEvent::Refused { .. }));
    }
    assert_eq!((unreadable, refused), (1, 1));
    assert_eq!(counted.join().unwrap(), 120);
}

#[test]
fn lengths_that_lie_end_the_connection_at_once() {
    let listener = TcpListener::bind(anywhere()).unwrap();
    let (_client, events) = listen(listener.local_addr().unwrap());
    for (kind, announced) in [
        ("TRANSFORM", 900_000_000_u64),
        ("IMAGE", 900_000_000),
        ("TRANSFORM", 4 << 30),
        ("TRANSFORM", 1 << 62),
        ("TRANSFORM", u64::MAX),
    ] {
        let (mut tracker, _) = listener.accept().unwrap();
        tracker.write_all(&header_announcing(kind.as_bytes(), announced)).unwrap();
        assert_eq!(lost(&events), DisconnectReason::Unreadable, "{announced}");
        tracker.set_read_timeout(Some(PATIENCE)).unwrap();
        assert_eq!(tracker.read(&mut [0]).unwrap(), 0);
    }
    let (mut tracker, _) = listener.accept().unwrap();
    let message = numbered("Probe", 7).encode().unwrap();
    tracker.write_all(&message).unwrap();
    assert_eq!(number_of(&received(&events)), Some(7));
}

#[test]
fn a_message_that_never_ends_is_given_up() {
    let listener = TcpListener::bind(anywhere()).unwrap();
    let (_client, events) = listen(listener.local_addr().unwrap());
    // An image that is not too long, and poses where its pixels should be.
    let (mut tracker, _) = listener.accept().unwrap();
    tracker.write_all(&header_announcing(b"IMAGE", 30_000_000)).unwrap();
    let end = Instant::now() + PATIENCE;
    let why = loop {
        assert!(Instant::now() < end, "never given up");
        // It may be gone already.
        let _ = tracker.write_all(&numbered("Probe", 2).encode().unwrap());
        rest(Duration::from_millis(50));
        if let Some(ClientEvent::Lost { why, .. }) =
            std::iter::from_fn(|| events.try_next()).find(|e| matches!(e, ClientEvent::Lost { .. }))
        {
            break why;
        }
    };
    assert_eq!(why, DisconnectReason::Unfinished);
    let (mut tracker, _) = listener.accept().unwrap();
    tracker.write_all(&numbered("Probe", 7).encode().unwrap()).unwrap();
    assert_eq!(number_of(&received(&events)), Some(7));
}

/// A client whose own system keeps little for it: what that has taken cannot be called back.
fn reader_of_little(address: SocketAddr) -> Reader {
    let socket = socket2::Socket::new(socket2::Domain::IPV4, socket2::Type::STREAM, None).unwrap();
    socket.set_recv_buffer_size(4096).unwrap();
    socket.connect(&address.into()).unwrap();
    Reader::of(socket.into())
}

/// Counts of what a client got that stopped reading for a while, by the age at which it read.
#[derive(Debug)]
struct Paused {
    sent: u64,
    old: u64,
    dropped: u64,
}

/// Eight tools at 40 Hz; the client reads nothing for so long, then all.
fn pause(seconds: u64, connect: fn(SocketAddr) -> Reader) -> Paused {
    let bound = Duration::from_secs(1);
    let (server, served) =
        serve(&ServerOptions { max_age: bound, ..ServerOptions::at(anywhere()) });
    let mut client = connect(server.address());
    joined(&served);
    let start = Instant::now();
    let mut number = 0;
    let publish = |number: u32| {
        for tool in 0..8 {
            send(&server, &format!("Tool{tool}"), number);
        }
    };
    while start.elapsed() < Duration::from_secs(seconds) {
        number += 1;
        publish(number);
        rest(Duration::from_millis(25));
    }
    let paused = number;
    // What was sent until now and not within the bound is old.
    let resumed = Timestamp::now();
    let old = std::thread::scope(|scope| {
        let reading = scope.spawn(|| {
            let mut old = 0;
            loop {
                let message = client.next_transform();
                if number_of(&message).unwrap() > paused + 120 {
                    return old;
                }
                old += u64::from(resumed.seconds_since(message.timestamp) > bound.as_secs_f64());
            }
        });
        while !reading.is_finished() {
            number += 1;
            publish(number);
            rest(Duration::from_millis(25));
        }
        reading.join().unwrap()
    });
    for event in ["fell behind", "caught up"] {
        served.wait_for(event, |found| {
            let is_it = match found {
                ServerEvent::FellBehind { .. } => event == "fell behind",
                ServerEvent::CaughtUp { dropped, .. } => event == "caught up" && dropped > 0,
                _ => false,
            };
            is_it.then_some(())
        });
    }
    Paused { sent: u64::from(paused) * 8, old, dropped: server.dropped_messages() }
}

#[test]
fn a_client_that_pauses_gets_fresh_poses() {
    let found = pause(6, reader_of_little);
    // Some 8 KB in its own system and as much on the way, of 106 bytes each.
    assert!(found.old < 200, "{found:?}");
    assert!(found.dropped + 400 > found.sent, "{found:?}");
}

#[test]
#[ignore = "long: two minutes"]
#[expect(clippy::print_stdout, reason = "its figures are what it is run for")]
fn long_pause_of_a_client_ends_in_fresh_poses() {
    let found = pause(60, reader_of_little);
    println!("{found:?}");
    assert!(found.old < 200, "{found:?}");
    assert!(found.dropped + 400 > found.sent, "{found:?}");
    // With buffers as the system gives them the old poses are in the client's own, where nothing here
    // reaches them: how many is for the page, and no claim.
    println!("{:?}", pause(60, Reader::connect));
}

#[test]
fn eleven_hundred_clients_are_served_or_refused() {
    let mut options = patient(anywhere());
    // Both ends are in this process, and other tests beside them.
    if file_limit() < 4 * options.max_clients {
        options.max_clients = file_limit() / 8;
    }
    let (limit, beyond) = (options.max_clients, 100);
    let (server, served) = serve(&options);
    let address = server.address();
    let threads: Vec<_> = (0..4)
        .map(|part| {
            let count = (part..limit + beyond).step_by(4).count();
            std::thread::spawn(move || {
                let clients = (0..count).map(|_| Reader::connect(address));
                clients.collect::<Vec<_>>()
            })
        })
        .collect();
    let clients = threads.into_iter().flat_map(|thread| thread.join().unwrap());
    let mut clients: Vec<Reader> = clients.collect();
    let (mut accepted, mut refused) = (0, 0);
    while accepted + refused < limit + beyond {
        served.wait_for("every client", |event| match event {
            ServerEvent::Joined { .. } => {
                accepted += 1;
                Some(())
            }
            ServerEvent::Refused { .. } => {
                refused += 1;
                Some(())
            }
            _ => None,
        });
    }
    assert_eq!((accepted, refused), (limit, beyond));
    send(&server, "Probe", 5);
    let (mut served_clients, mut refused_clients) = (0, 0);
    for client in &mut clients {
        match client.next().map(|message| message.content) {
            Some(Content::Transform(_)) => served_clients += 1,
            Some(Content::Status(status)) if status.name == "TOO_MANY_CLIENTS" => {
                assert_eq!(status.code, StatusCode::RESOURCE_ERROR);
                assert!(status.text.contains(&format!("{limit} clients")), "{status:?}");
                assert_eq!(client.next(), None);
                refused_clients += 1;
            }
            other => panic!("{other:?}"),
        }
    }
    assert_eq!((served_clients, refused_clients), (limit, beyond));
    assert_eq!(server.clients(), limit);
}
