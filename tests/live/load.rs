//! Many tools to many clients, with a client killed and the tracker's server restarted.

use crate::support::live_load::{Load, run, tracker};
use crate::support::live_program::{Live, address_in};
use crate::support::program::trackwright;
use crate::support::wire::{events, until};
use std::time::Duration;
use trackwright_openigtlink::client::ClientOptions;
use trackwright_openigtlink::relay::RelayOptions;
use trackwright_openigtlink::server::{ServerEvent, ServerOptions};
use trackwright_openigtlink::session::{Session, SessionEvent, SessionSettings};

#[test]
#[ignore = "long: thirty seconds of load"]
fn long_load_loses_only_what_was_sent_to_nobody() {
    let load = Load { tools: 8, rate_hz: 40, clients: 16, seconds: 30 };
    let server = tracker("127.0.0.1:0".parse().unwrap());
    let mut options = ServerOptions::at("127.0.0.1:0".parse().unwrap());
    // Counts, not times: on a busy machine nobody is dropped, and nothing is late, for being slow.
    options.queue = 100_000;
    let relay = RelayOptions { stale_after: Duration::from_secs(60), ..RelayOptions::default() };
    let (sender, events) = events();
    let session = Session::start(
        SessionSettings {
            client: ClientOptions::to(server.address().to_string()),
            relay,
            room: None,
            server: Some(options),
            record: None,
        },
        move |event| {
            if !matches!(event, SessionEvent::Pose(_)) {
                let _ = sender.send(event.clone());
            }
        },
    )
    .unwrap();
    until("a client", || server.clients() > 0);
    let wait_for_clients = || {
        events.wait_for("all clients", |event| match event {
            SessionEvent::Server(ServerEvent::Joined { clients, .. }) => {
                (clients == load.clients).then_some(())
            }
            _ => None,
        });
    };
    let relay_at = session.address().unwrap();
    let outcome = run(load, server, relay_at, wait_for_clients, || 0);
    let end = session.stop();

    let away = outcome.away;
    assert!(away.first > 0 && away.last >= away.first, "{away:?}");
    for (client, received) in outcome.received.iter().enumerate() {
        assert_eq!((received.old, received.not_good), (0, 0), "{client}");
        for gap in &received.gaps {
            assert!(gap.first >= away.first && gap.last <= away.last, "{client}: {gap:?} {away:?}");
        }
        if client > 0 {
            let missing: u32 = received.gaps.iter().map(|gap| gap.last - gap.first + 1).sum();
            let all = u64::from(load.tools * outcome.frames);
            assert_eq!(received.transforms + u64::from(missing), all, "{client}");
            assert!(received.last.values().all(|last| *last == outcome.frames));
        }
    }
    // The one that was killed received the first half.
    let killed = &outcome.received[0];
    assert!(killed.last.values().all(|last| *last < outcome.frames) && killed.transforms > 0);
    assert_eq!(end.counts.sent, end.counts.poses);
    assert_eq!(end.counts.sent, outcome.received[1].transforms);
    assert_eq!((end.connections, end.slow_clients, end.unreadable), (2, 0, 0));
}

/// `VmRSS` of a process, in kB.
fn resident_kb(process: u32) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    line.and_then(|line| line.trim().trim_end_matches(" kB").parse().ok()).unwrap_or(0)
}

/// Growth of the program's memory from the first minute to the last that counts as none: its
/// allocator's own.
const FLAT_KB: u64 = 4096;

#[test]
#[ignore = "long: ten minutes, or TRACKWRIGHT_LOAD_SECONDS"]
#[expect(clippy::print_stdout, reason = "its figures are what it is run for")]
fn long_load_keeps_memory_and_sends_nothing_old() {
    let seconds = std::env::var("TRACKWRIGHT_LOAD_SECONDS").ok();
    let load = Load {
        tools: 8,
        rate_hz: 100,
        clients: 20,
        seconds: seconds.and_then(|s| s.parse().ok()).unwrap_or(600),
    };
    let server = tracker("127.0.0.1:0".parse().unwrap());
    let connect = server.address().to_string();
    let ends = ["live", "--format", "json", "--connect", &connect, "--serve", "0"];
    let room = ["--environment", super::peers::ROOM];
    let live = Live::run(trackwright(&[&ends[..], &room].concat()));
    let relay_at = address_in(&live.wait_for_note("serving at"));
    live.wait_for_note("connected to");
    let process = live.child.id();
    let wait_for_clients = || drop(live.wait_for_note(&format!("joined, {} now", load.clients)));
    let outcome = run(load, server, relay_at, wait_for_clients, || resident_kb(process));
    let end = live.interrupt();
    println!("{load:?}, {} frames, away {:?}", outcome.frames, outcome.away);
    for client in &outcome.received {
        let missing: u32 = client.gaps.iter().map(|gap| gap.last - gap.first + 1).sum();
        println!("{} transforms, {missing} missing, {:?}", client.transforms, client.latency);
        assert_eq!((client.old, client.late), (0, 0));
    }
    println!("memory in kB {:?}\n{end:#}", outcome.memory);
    // To the histogram's two digits.
    let bound_ms = 1.01e3 * RelayOptions::STALE_AFTER.as_secs_f64();
    assert!(end["age_ms"]["max"].as_f64().unwrap() <= bound_ms);
    let at_first = outcome.memory.get(1).unwrap().1;
    let (_, at_last) = outcome.memory.last().unwrap();
    assert!(*at_last <= at_first + FLAT_KB, "{:?}", outcome.memory);
    assert_eq!(end["connections"], 2);
}
