//! A tracker of many tools, a relay, and many clients that count: one is killed, and the tracker's
//! server is restarted in between. The relay is whoever listens to the tracker's address and serves
//! at another one.

#![allow(dead_code, reason = "tests and a bench share it, and each needs a part")]

use super::wire::{Reader, numbered, rest};
use std::collections::BTreeMap;
use std::net::{Shutdown, SocketAddr};
use std::time::{Duration, Instant};
use trackwright_openigtlink::codec::{Content, Message, Timestamp, ToolKind};
use trackwright_openigtlink::latency::{Latencies, LatencySummary};
use trackwright_openigtlink::relay::{RelayOptions, described};
use trackwright_openigtlink::server::{Server, ServerOptions};

/// How long the tracker's server is away.
const AWAY_S: u32 = 1;

#[derive(Clone, Copy, Debug)]
pub struct Load {
    pub tools: u32,
    pub rate_hz: u32,
    pub clients: usize,
    pub seconds: u32,
}

/// The tracker's server, at the address that it had before.
pub fn tracker(address: SocketAddr) -> Server {
    let mut options = ServerOptions::at(address);
    // On a machine that does other things a relay may be away for a while.
    options.queue = 100_000;
    options.max_age = Duration::from_secs(3600);
    Server::start(&options, |_| {}).unwrap()
}

/// What one client received.
#[derive(Clone, Debug, Default)]
pub struct Received {
    pub transforms: u64,
    /// By tool: the last number, and the numbers missing before each that came.
    pub last: BTreeMap<String, u32>,
    pub gaps: Vec<Gap>,
    /// Transforms that were not newer than the one before.
    pub old: u64,
    /// Transforms of tools whose last reported state was not good.
    pub not_good: u64,
    /// Transforms whose stated latency exceeds the relay's own bound.
    pub late: u64,
    /// From the tracker to here.
    pub latency: LatencySummary,
}

/// Numbers of a tool that never came.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gap {
    pub first: u32,
    pub last: u32,
}

/// What a load came to.
#[derive(Debug)]
pub struct Outcome {
    /// Frames, each a transform of every tool.
    pub frames: u32,
    /// The first and the last frame that nobody could receive.
    pub away: Gap,
    /// The first was killed.
    pub received: Vec<Received>,
    /// Resident memory of the relay, at times.
    pub memory: Vec<(u32, u64)>,
}

/// Runs a load on a relay that listens to the server of the tracker and serves at `relay_at`.
/// `wait_for_relay` is to return once the relay has all its clients; `memory` gives its memory.
pub fn run(
    load: Load,
    server: Server,
    relay_at: SocketAddr,
    wait_for_relay: impl FnOnce(),
    mut memory: impl FnMut() -> u64,
) -> Outcome {
    let tracker_at = server.address();
    let mut server = Some(server);
    let frames = load.seconds * load.rate_hz;
    let clients = 0..load.clients;
    let readers: Vec<Reader> = clients.map(|_| Reader::connect(relay_at)).collect();
    let victim = readers[0].stream.try_clone().unwrap();
    wait_for_relay();
    let receiving = |reader| std::thread::spawn(move || receive(reader, load.tools, frames));
    let threads: Vec<_> = readers.into_iter().map(receiving).collect();

    let mut away = Gap { first: 0, last: 0 };
    let mut memory_at = vec![(0, memory())];
    let start = Instant::now();
    for frame in 1..=frames {
        let due =
            |frame| start + Duration::from_secs_f64(f64::from(frame) / f64::from(load.rate_hz));
        rest(due(frame).saturating_duration_since(Instant::now()));
        if frame == frames / 2 {
            victim.shutdown(Shutdown::Both).unwrap();
        }
        if frame == frames * 2 / 3 {
            away.first = frame;
            // What was sent before arrives: a server gives what is queued.
            server.take().unwrap().stop();
        }
        if server.is_none() && frame >= away.first + AWAY_S * load.rate_hz {
            server = Some(tracker(tracker_at));
        }
        match &server {
            Some(server) if server.clients() > 0 => {}
            _ => away.last = frame,
        }
        for tool in 0..load.tools {
            let message = framed(&name(tool), frame);
            if let Some(server) = &server {
                server.send_transform(&message, ToolKind::SixDof, Instant::now()).unwrap();
            }
        }
        if frame % (60 * load.rate_hz) == 0 || frame == frames {
            memory_at.push((frame / load.rate_hz, memory()));
        }
    }
    let join = |thread: std::thread::JoinHandle<Received>| thread.join().unwrap();
    let received = threads.into_iter().map(join).collect();
    Outcome { frames, away, received, memory: memory_at }
}

/// The last bits of a timestamp, 0.24 ms, in which a message has the number of its frame: a room
/// changes poses, but no timestamps.
const FRAME_BITS: u64 = (1 << 20) - 1;

/// The first two are the bodies of the built-in design, for a relay that knows it.
fn name(tool: u32) -> String {
    match tool {
        0 => "PointerToTracker".to_owned(),
        1 => "HeadFrameToTracker".to_owned(),
        _ => format!("Tool{tool}ToTracker"),
    }
}

/// A transform in the middle of the rooms of these tests.
fn framed(tool: &str, frame: u32) -> Message {
    let mut message = numbered(tool, 40 + frame % 40);
    message.timestamp.0 = (message.timestamp.0 & !FRAME_BITS) | u64::from(frame);
    message
}

fn frame_of(message: &Message) -> u32 {
    (message.timestamp.0 & FRAME_BITS) as u32
}

/// Counts until every tool's last number has come, or the connection ends.
fn receive(mut reader: Reader, tools: u32, frames: u32) -> Received {
    let mut received = Received::default();
    let mut latencies = Latencies::default();
    let mut is_good: BTreeMap<String, bool> = BTreeMap::new();
    let mut done = 0;
    while done < tools {
        let Some(message) = reader.next() else { break };
        if let Content::Status(status) = &message.content {
            is_good.insert(message.device, status.name == "OK");
            continue;
        }
        if !matches!(message.content, Content::Transform(_)) {
            continue;
        }
        let number = frame_of(&message);
        received.transforms += 1;
        received.not_good += u64::from(is_good.get(&message.device) == Some(&false));
        let latency_ms = message.extension.as_ref().map(|e| e.get(described::LATENCY_MS));
        let latency_ms = latency_ms.flatten().and_then(|ms| ms.parse::<f64>().ok());
        let bound_ms = 1e3 * RelayOptions::STALE_AFTER.as_secs_f64();
        received.late += u64::from(latency_ms.is_none_or(|ms| ms > bound_ms));
        let taken_s = Timestamp::now().seconds_since(message.timestamp);
        latencies.record(Duration::try_from_secs_f64(taken_s).unwrap_or_default());
        let last = received.last.insert(message.device, number).unwrap_or(0);
        if number <= last {
            received.old += 1;
        } else if number > last + 1 {
            received.gaps.push(Gap { first: last + 1, last: number - 1 });
        }
        done += u32::from(number == frames);
    }
    received.latency = latencies.summary();
    received
}
