//! A tracker received, its poses compensated, recorded and served on, until it is stopped.

mod running;
mod section;

pub use super::relay::{LiveDesign, LiveRoom};

use super::client::{Client, ClientEvent, ClientOptions, DisconnectReason};
use super::codec::{DecodeError, Status};
use super::latency::LatencySummary;
use super::relay::{
    ClockChange, Reason, RelayCounts, RelayOptions, SentPose, ToolClock, ToolState,
};
use super::server::{Server, ServerError, ServerEvent, ServerOptions};
use super::thread::lock;
use running::{Next, Running};
use std::collections::BTreeMap;
use std::io;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use trackwright_design::BodyRole;
use trackwright_geometry::pose::Pose;
use trackwright_project::{Recorder, StoreError};

/// What may wait between the threads: three seconds of eight tools at 40 Hz. While it is full the
/// client does not read, and the tracker's server has to wait.
const INPUTS: usize = 1024;

/// The options of a session.
#[derive(Clone, Debug)]
pub struct SessionSettings {
    pub client: ClientOptions,
    pub relay: RelayOptions,
    /// Without one, poses are passed on as they are.
    pub room: Option<LiveRoom>,
    pub server: Option<ServerOptions>,
    /// A file that is not there yet.
    pub record: Option<PathBuf>,
}

/// What happens in a session, reported from its thread.
#[derive(Clone, Debug, PartialEq)]
pub enum SessionEvent {
    /// The tracker's server is being reached.
    Connecting,
    /// It is there.
    Connected { server: SocketAddr },
    /// It is gone, and reached for again after a wait.
    Lost { why: DisconnectReason, wait: Duration },
    /// A message that is not used, the first of its kind on this connection.
    Unreadable(DecodeError),
    /// Messages of a type that is not known, the first of its kind.
    Skipped { kind: String },
    /// The tracker reports a status of a device that is not "OK", the first time on this
    /// connection.
    TrackerStatus { device: String, status: Status },
    /// A tool is good, or is not any more.
    Tool { tool: String, state: ToolState },
    /// What the tracker stands by, before any compensation: also where that is not possible.
    Measured { tool: String, pose: Pose },
    /// A good pose, as it is sent on.
    Pose(Box<SentPose>),
    /// What a tool's timestamps show, each kind once until it is over.
    Clock { tool: String, change: ClockChange },
    /// Samples that no tool is made for, the first of their kind.
    Refused { tool: String, reason: Reason },
    /// What happens to clients.
    Server(ServerEvent),
    /// Nothing more is recorded; all else goes on.
    NotRecorded { why: String },
}

/// How a session is.
#[derive(Clone, Debug)]
pub struct SessionState {
    pub link: Link,
    /// Where it serves, and to how many clients.
    pub serving: Option<(SocketAddr, usize)>,
    /// The one that grows, or the last one if writing it failed.
    pub recording: Option<Recording>,
    /// By name.
    pub tools: BTreeMap<String, ToolView>,
    pub counts: RelayCounts,
    /// Connections that were made, the first among them.
    pub connections: u64,
    /// Messages with wrong checksums, lengths or texts, and streams that were none.
    pub unreadable: u64,
    /// Messages of types that are not known.
    pub skipped: u64,
    /// Clients dropped because they did not read, and messages that became too old for clients.
    pub slow_clients: u64,
    pub undelivered: u64,
    /// From the read off the tracker's connection to the write into a client's.
    pub latency: LatencySummary,
    /// Of poses when they were written into a client's connection, as far as timestamps show.
    pub age: LatencySummary,
}

/// The connection to the tracker's server.
#[derive(Clone, Debug, PartialEq)]
pub enum Link {
    Connecting,
    Connected {
        server: SocketAddr,
        since: Instant,
    },
    Lost {
        /// When it was there for the last time, or first tried.
        since: Instant,
        why: DisconnectReason,
        wait: Duration,
    },
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recording {
    pub file: PathBuf,
    pub samples: u64,
    /// Why nothing more is written to it, where writing failed.
    pub failed: Option<String>,
}

impl Recording {
    fn begun(file: PathBuf) -> Self {
        Self { file, samples: 0, failed: None }
    }
}

/// A tool as it was last seen.
#[derive(Clone, Debug, PartialEq)]
pub struct ToolView {
    pub state: ToolState,
    /// Which body of the design it is, where one is known and found.
    pub role: Option<BodyRole>,
    /// The last good one, as measured and as sent on, and when it came.
    pub last: Option<(Pose, Pose, Instant)>,
    /// At the last good one.
    pub clock: ToolClock,
}

impl SessionState {
    fn new(settings: &SessionSettings, address: Option<SocketAddr>) -> Self {
        Self {
            link: Link::Connecting,
            serving: address.map(|address| (address, 0)),
            recording: settings.record.clone().map(Recording::begun),
            tools: BTreeMap::new(),
            counts: RelayCounts::default(),
            connections: 0,
            unreadable: 0,
            skipped: 0,
            slow_clients: 0,
            undelivered: 0,
            latency: LatencySummary::default(),
            age: LatencySummary::default(),
        }
    }
}

#[derive(Debug, thiserror::Error)]
pub enum SessionError {
    #[error(transparent)]
    Server(#[from] ServerError),
    #[error(transparent)]
    Recording(#[from] StoreError),
    #[error("cannot start a thread: {0}")]
    Thread(#[from] io::Error),
}

/// What the session's thread receives from the others.
enum Input {
    Client(ClientEvent),
    Server(ServerEvent),
    Room(Option<Box<LiveRoom>>),
    Record(Option<Recorder>),
    Stop,
}

/// A session that runs as long as this is there.
pub struct Session {
    address: Option<SocketAddr>,
    state: Arc<Mutex<SessionState>>,
    inputs: SyncSender<Input>,
    thread: Option<JoinHandle<()>>,
}

impl Session {
    /// Binds, begins to record, connects, and goes on by itself; a tracker that is absent is waited
    /// for. `on_event` is called from the session's thread.
    pub fn start(
        settings: SessionSettings,
        on_event: impl FnMut(&SessionEvent) + Send + 'static,
    ) -> Result<Self, SessionError> {
        let (inputs, received) = sync_channel(INPUTS);
        let server = match &settings.server {
            None => None,
            Some(options) => {
                let inputs = inputs.clone();
                // One bound for all: what is too old here is too old for every client.
                let options =
                    ServerOptions { max_age: settings.relay.stale_after, ..options.clone() };
                Some(Server::start(&options, move |event| {
                    // The session is ending.
                    let _ = inputs.send(Input::Server(event));
                })?)
            }
        };
        let recorder = settings.record.as_deref().map(Recorder::create).transpose()?;
        let address = server.as_ref().map(Server::address);
        let state = Arc::new(Mutex::new(SessionState::new(&settings, address)));
        let client = {
            let inputs = inputs.clone();
            Client::start(settings.client.clone(), move |event| {
                // The session is ending.
                let _ = inputs.send(Input::Client(event));
            })?
        };
        let ends = Ends { client, server, recorder, received };
        let thread = std::thread::Builder::new().name("live session".to_owned()).spawn({
            let state = state.clone();
            move || run(settings, ends, &state, on_event)
        })?;
        Ok(Self { address, state, inputs, thread: Some(thread) })
    }

    /// Where the server is, with the port that was free.
    pub fn address(&self) -> Option<SocketAddr> {
        self.address
    }

    /// How everything is now.
    pub fn state(&self) -> SessionState {
        lock(&self.state).clone()
    }

    /// Compensates by another room from now on; without one poses are passed on as they are.
    pub fn set_room(&self, room: Option<LiveRoom>) {
        // A session that ended by itself needs none.
        let _ = self.inputs.send(Input::Room(room.map(Box::new)));
    }

    /// Records in a new file from now on, or no more; after an error recording goes on as before.
    pub fn record(&self, file: Option<&Path>) -> Result<(), StoreError> {
        let recorder = file.map(Recorder::create).transpose()?;
        // A session that ended by itself records nothing.
        let _ = self.inputs.send(Input::Record(recorder));
        Ok(())
    }

    /// Closes the connection, gives clients what is queued for them, and returns how it was.
    pub fn stop(mut self) -> SessionState {
        self.end();
        self.state()
    }

    fn end(&mut self) {
        if let Some(thread) = self.thread.take() {
            // A thread that ended by itself needs no word.
            let _ = self.inputs.send(Input::Stop);
            let _ = thread.join();
        }
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        self.end();
    }
}

/// What a session's thread works with.
struct Ends {
    client: Client,
    server: Option<Server>,
    recorder: Option<Recorder>,
    received: Receiver<Input>,
}

fn run(
    settings: SessionSettings,
    ends: Ends,
    state: &Mutex<SessionState>,
    on_event: impl FnMut(&SessionEvent),
) {
    let Ends { client, server, recorder, received } = ends;
    let mut running = Running::new(settings.relay, server.as_ref(), recorder, state, on_event);
    let mut room = settings.room.map(Box::new);
    loop {
        let mut in_room = running.in_room(room.as_deref());
        let next = in_room.run(&received);
        running = in_room.in_room(None);
        match next {
            Next::Stop => break,
            Next::Room(next) => room = next,
        }
    }
    running.update();
    // The client and the server may be waiting for a place in the channel.
    drop(received);
    client.stop();
    running.finish();
    if let Some(server) = server {
        let (latency, age) = server.stop();
        let mut state = lock(state);
        (state.latency, state.age) = (latency, age);
    }
}
