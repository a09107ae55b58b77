//! Serves transforms to any number of clients over OpenIGTLink.
//!
//! One thread with an event loop serves them all: a thousand clients at two threads each would be
//! gigabytes of stacks and ten thousand wakes a second for messages of a hundred bytes. Each client
//! has a queue of bounded length; whoever sends never waits, and poses that have waited too long are
//! thrown away. What is queued is shared between clients.

mod connection;
mod outbox;

use super::codec::{Content, EncodeError, Message, Status, StatusCode, ToolKind};
use super::latency::{Latencies, LatencySummary};
use super::relay::RelayOptions;
use super::thread::{EventThread, lock};
use connection::Connection;
pub use outbox::DEVICE;
use outbox::{Encoded, Item, Outbox, PoseTimes, Served};
use std::fs::File;
use std::io::{self, Write};
use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use tokio::net::{TcpListener, TcpSocket, TcpStream};
use tokio::runtime::{Builder, Runtime};
use tokio::sync::oneshot;

/// Bytes that the system keeps for a client until it has confirmed them: little, so that one that
/// stops reading and goes on gets few old poses. The system doubles it.
const SEND_BUFFER_BYTES: u32 = 8 * 1024;

/// Clients that may wait for being accepted.
const BACKLOG: u32 = 1024;

/// How long the loop waits after the system accepted no client, as for want of descriptors.
const ACCEPT_PAUSE: Duration = Duration::from_millis(200);

/// How long clients have to take what is queued for them when the server stops.
const FAREWELL: Duration = Duration::from_secs(1);

/// The options of a server.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ServerOptions {
    /// Port 0 is any that is free.
    pub address: SocketAddr,
    pub max_clients: usize,
    /// Messages that may wait for one client.
    pub queue: usize,
    /// The age from which a pose is not sent any more.
    pub max_age: Duration,
    /// How long a client may take nothing until it is dropped.
    pub stuck_after: Duration,
    /// Whether all messages have headers of version 1, for receivers that read no others.
    pub is_version_one: bool,
}

impl ServerOptions {
    pub const MAX_CLIENTS: usize = 1000;
    /// One and a half seconds of eight tools at 40 Hz.
    pub const QUEUE: usize = 512;
    pub const STUCK_AFTER: Duration = Duration::from_secs(300);

    /// Options for an address, with the usual limits.
    pub fn at(address: SocketAddr) -> Self {
        Self {
            address,
            max_clients: Self::MAX_CLIENTS,
            queue: Self::QUEUE,
            max_age: RelayOptions::STALE_AFTER,
            stuck_after: Self::STUCK_AFTER,
            is_version_one: false,
        }
    }
}

/// What happens to a server, reported from its thread.
#[derive(Clone, Debug, PartialEq)]
pub enum ServerEvent {
    /// A client that is served from now on.
    Joined { client: SocketAddr, clients: usize },
    /// A client that is served no more.
    Left { client: SocketAddr, why: LeaveReason, clients: usize },
    /// There are as many clients as may be, or as the system allows.
    Refused { client: SocketAddr, why: String },
    /// It does not read fast enough: poses that are too old by then are not sent to it.
    FellBehind { client: SocketAddr },
    /// It reads fast enough again; what it did not get meanwhile.
    CaughtUp { client: SocketAddr, dropped: u64 },
    /// The system would not accept a client; tried again soon.
    NotAccepted { why: String },
}

/// Why a client is gone.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LeaveReason {
    #[error("it closed the connection")]
    Closed,
    #[error("the connection failed: {0}")]
    Failed(String),
    #[error("dropped: it took nothing for too long")]
    TooSlow,
    #[error("dropped: {0}")]
    Unreadable(super::codec::DecodeError),
    #[error("the server stopped")]
    Stopped,
}

#[derive(Debug, thiserror::Error)]
pub enum ServerError {
    #[error("port {port} of {host} is in use, expected a free one: another program serves there", port = .0.port(), host = .0.ip())]
    InUse(SocketAddr),
    #[error("cannot serve at {address}: {cause}")]
    Bind { address: SocketAddr, cause: io::Error },
    #[error("cannot start the server's thread: {0}")]
    Thread(io::Error),
}

type EventHandler = Arc<dyn Fn(ServerEvent) + Send + Sync>;

/// What the thread that serves and those that publish share.
struct Shared {
    clients: Mutex<Vec<Slot>>,
    served: Mutex<Served>,
    latencies: Mutex<Latencies>,
    ages: Mutex<Latencies>,
    dropped_messages: AtomicU64,
}

impl Shared {
    fn count_dropped(&self, count: u64) {
        self.dropped_messages.fetch_add(count, Ordering::Relaxed);
    }
}

/// A client, as seen by who publishes.
struct Slot {
    id: u64,
    outbox: Arc<Outbox>,
    /// Whether it has requested tracking data, and gets them in place of transforms.
    is_tracking: Arc<AtomicBool>,
    /// Its connection ends when this is dropped.
    _hold: oneshot::Sender<()>,
}

/// A server that runs as long as this is there.
pub struct Server {
    address: SocketAddr,
    max_age: Duration,
    is_version_one: bool,
    shared: Arc<Shared>,
    thread: EventThread,
}

impl Server {
    /// Binds and serves; `on_event` is called from the server's thread and is to return soon.
    pub fn start(
        options: &ServerOptions,
        on_event: impl Fn(ServerEvent) + Send + Sync + 'static,
    ) -> Result<Self, ServerError> {
        let runtime = Builder::new_current_thread()
            .enable_io()
            .enable_time()
            .build()
            .map_err(ServerError::Thread)?;
        let listener = listen(&runtime, options.address)?;
        let address = listener.local_addr().unwrap_or(options.address);
        let shared = Arc::new(Shared {
            clients: Mutex::default(),
            served: Mutex::default(),
            latencies: Mutex::default(),
            ages: Mutex::default(),
            dropped_messages: AtomicU64::new(0),
        });
        let accepting = Accepting {
            listener,
            shared: shared.clone(),
            options: options.clone(),
            spare: spare(),
            on_event: Arc::new(on_event),
        };
        let run = |stopped| accepting.run(stopped);
        let thread =
            EventThread::start("live server", runtime, run).map_err(ServerError::Thread)?;
        Ok(Self {
            address,
            max_age: options.max_age,
            is_version_one: options.is_version_one,
            shared,
            thread,
        })
    }

    /// Where it serves, with the port that was free.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// The number of clients.
    pub fn clients(&self) -> usize {
        lock(&self.shared.clients).len()
    }

    /// From the moments that transforms arrived here to those that they were written to clients.
    pub fn latencies(&self) -> LatencySummary {
        lock(&self.shared.latencies).summary()
    }

    /// From the moments that poses were measured, as far as timestamps show, to those that they
    /// were written to clients.
    pub fn ages(&self) -> LatencySummary {
        lock(&self.shared.ages).summary()
    }

    /// Messages that were dropped as too old for a client, or for want of room in its queue.
    pub fn dropped_messages(&self) -> u64 {
        self.shared.dropped_messages.load(Ordering::Relaxed)
    }

    /// Sends a tool's transform to all clients; `arrived` is when its sample came in.
    pub fn send_transform(
        &self,
        message: &Message,
        kind: ToolKind,
        arrived: Instant,
    ) -> Result<(), EncodeError> {
        self.send_delayed(message, kind, arrived, Duration::ZERO)
    }

    /// The same of a pose that had an age already when it arrived.
    pub fn send_delayed(
        &self,
        message: &Message,
        kind: ToolKind,
        arrived: Instant,
        latency: Duration,
    ) -> Result<(), EncodeError> {
        let encoded = self.encoded(message)?;
        let times = PoseTimes::new(arrived, latency, self.max_age);
        lock(&self.shared.served).set(message, kind, &encoded, times);
        self.queue(&encoded, Some(times), |slot| !slot.is_tracking.load(Ordering::Relaxed));
        Ok(())
    }

    /// Sends any other message to all clients.
    pub fn send(&self, message: &Message) -> Result<(), EncodeError> {
        let encoded = self.encoded(message)?;
        self.queue(&encoded, None, |_| true);
        Ok(())
    }

    fn encoded(&self, message: &Message) -> Result<Arc<Encoded>, EncodeError> {
        if self.is_version_one && message.extension.is_some() {
            let plain = Message { extension: None, ..message.clone() };
            return Encoded::of(&plain).map(Arc::new);
        }
        Encoded::of(message).map(Arc::new)
    }

    /// A tool is not good any more: a request for it gets no pose.
    pub fn withdraw(&self, tool: &str) {
        lock(&self.shared.served).remove(tool);
    }

    fn queue(
        &self,
        message: &Arc<Encoded>,
        pose: Option<PoseTimes>,
        is_for: impl Fn(&Slot) -> bool,
    ) {
        let now = Instant::now();
        let clients = lock(&self.shared.clients);
        for slot in clients.iter().filter(|slot| is_for(slot)) {
            let message = Arc::clone(message);
            let dropped = slot.outbox.push(Item::Send { message, pose }, now);
            self.shared.count_dropped(dropped);
        }
    }

    /// Gives clients their queues for a second at most, and ends; all latencies and ages.
    pub fn stop(mut self) -> (LatencySummary, LatencySummary) {
        self.thread.end();
        (self.latencies(), self.ages())
    }
}

fn listen(runtime: &Runtime, address: SocketAddr) -> Result<TcpListener, ServerError> {
    let _entered = runtime.enter();
    let listen = || {
        let socket = match address {
            SocketAddr::V4(_) => TcpSocket::new_v4(),
            SocketAddr::V6(_) => TcpSocket::new_v6(),
        }?;
        // A server that was just stopped leaves connections that are closing on its port. On Windows
        // this would let two programs serve on one port.
        #[cfg(unix)]
        socket.set_reuseaddr(true)?;
        // Accepted connections inherit it.
        socket.set_send_buffer_size(SEND_BUFFER_BYTES)?;
        socket.bind(address)?;
        socket.listen(BACKLOG)
    };
    listen().map_err(|cause| match cause.kind() {
        io::ErrorKind::AddrInUse => ServerError::InUse(address),
        _ => ServerError::Bind { address, cause },
    })
}

/// The server's own thread.
struct Accepting {
    listener: TcpListener,
    shared: Arc<Shared>,
    options: ServerOptions,
    /// A file descriptor to give away for a client that is refused for want of one.
    spare: Option<File>,
    on_event: EventHandler,
}

impl Accepting {
    async fn run(mut self, mut stopped: oneshot::Receiver<()>) {
        let mut connections = tokio::task::JoinSet::new();
        let mut next_id = 0;
        let mut was_accepting = true;
        loop {
            let accepted = tokio::select! {
                // Also when the server was dropped.
                _ = &mut stopped => break,
                Some(_) = connections.join_next() => continue,
                accepted = self.listener.accept() => accepted,
            };
            match accepted {
                Ok((stream, client)) => {
                    was_accepting = true;
                    let max_clients = self.options.max_clients;
                    if lock(&self.shared.clients).len() >= max_clients {
                        let why = format!("{max_clients} clients are served already");
                        refuse(stream, &why);
                        (self.on_event)(ServerEvent::Refused { client, why });
                        continue;
                    }
                    next_id += 1;
                    connections.spawn(self.welcome(stream, client, next_id));
                }
                Err(error) => {
                    // A client that left before it was accepted is no news.
                    if error.kind() != io::ErrorKind::ConnectionAborted {
                        if was_accepting {
                            let why = error.to_string();
                            (self.on_event)(ServerEvent::NotAccepted { why });
                        }
                        was_accepting = false;
                        if !self.refuse_by_spare(&error.to_string()).await {
                            tokio::time::sleep(ACCEPT_PAUSE).await;
                        }
                    }
                }
            }
        }
        drop(self.listener);
        for slot in lock(&self.shared.clients).iter() {
            slot.outbox.push(Item::End, Instant::now());
        }
        let all_gone = async { while connections.join_next().await.is_some() {} };
        let _ = tokio::time::timeout(FAREWELL, all_gone).await;
        lock(&self.shared.clients).clear();
    }

    /// Refuses a client for want of a descriptor, by the spare one; whether there was one.
    async fn refuse_by_spare(&mut self, why: &str) -> bool {
        if self.spare.take().is_none() {
            self.spare = spare();
            return false;
        }
        let accepted = tokio::time::timeout(ACCEPT_PAUSE, self.listener.accept()).await;
        let is_refused = match accepted {
            Ok(Ok((stream, client))) => {
                refuse(stream, why);
                let why = why.to_owned();
                (self.on_event)(ServerEvent::Refused { client, why });
                true
            }
            _ => false,
        };
        self.spare = spare();
        is_refused
    }

    fn welcome(
        &self,
        stream: TcpStream,
        client: SocketAddr,
        id: u64,
    ) -> impl Future<Output = ()> + use<> {
        let outbox = Arc::new(Outbox::new(self.options.queue));
        let (hold, let_go) = oneshot::channel();
        let is_tracking = Arc::default();
        let connection = Connection {
            client,
            outbox: Arc::clone(&outbox),
            is_tracking: Arc::clone(&is_tracking),
            is_version_one: AtomicBool::new(false),
            shared: self.shared.clone(),
            on_event: self.on_event.clone(),
            stuck_after: self.options.stuck_after,
        };
        let clients = {
            let mut clients = lock(&self.shared.clients);
            clients.push(Slot { id, outbox, is_tracking, _hold: hold });
            clients.len()
        };
        let on_event = self.on_event.clone();
        let shared = self.shared.clone();
        on_event(ServerEvent::Joined { client, clients });
        async move {
            let why = connection.run(stream, let_go).await;
            let clients = {
                let mut clients = lock(&shared.clients);
                clients.retain(|slot| slot.id != id);
                clients.len()
            };
            on_event(ServerEvent::Left { client, why, clients });
        }
    }
}

/// A file descriptor that can be given away, where the system counts them.
fn spare() -> Option<File> {
    if cfg!(unix) { File::open("/dev/null").ok() } else { None }
}

/// Sends the reason and closes; a client that takes no hundred bytes gets none.
fn refuse(stream: TcpStream, why: &str) {
    let status = Status::problem(StatusCode::RESOURCE_ERROR, "TOO_MANY_CLIENTS", why);
    let message = Message::new("", super::codec::Timestamp::now(), Content::Status(status));
    if let (Ok(mut stream), Ok(bytes)) = (stream.into_std(), message.encode()) {
        let _ = stream.write(&bytes);
    }
}
