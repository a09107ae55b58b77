//! Serves transforms to any number of clients over OpenIGTLink.
//!
//! One thread with an event loop serves them all: a thousand clients at two threads each would be
//! gigabytes of stacks and ten thousand wakes a second for messages of a hundred bytes. Each client
//! has a queue of bounded length; whoever sends never waits, and a client whose queue is full is
//! dropped. What is queued is shared between clients.

mod connection;
mod served;

use super::codec::{Content, EncodeError, Message, Status, StatusCode, ToolKind};
use super::latency::{Latencies, LatencySummary};
use connection::{Connection, Item};
use served::Served;
use std::io::{self, Write};
use std::net::SocketAddr;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tokio::net::{TcpListener, TcpSocket, TcpStream};
use tokio::runtime::{Builder, Runtime};
use tokio::sync::{mpsc, oneshot};

/// Bytes that the system keeps for a client that does not read, beside the queue: little, so that
/// one that has stopped is found within seconds and one that goes on does not get old poses. The
/// system doubles it.
const SEND_BUFFER_BYTES: u32 = 32 * 1024;

/// Clients that may wait for being accepted.
const BACKLOG: u32 = 1024;

/// How long the loop waits after the system would not accept a client: for want of file
/// descriptors, say, which trying again at once does not bring.
const ACCEPT_PAUSE: Duration = Duration::from_millis(200);

/// How long clients have to take what is queued for them when the server stops.
const FAREWELL: Duration = Duration::from_secs(1);

/// What a server is told beforehand.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ServerOptions {
    /// Port 0 is any that is free.
    pub address: SocketAddr,
    pub max_clients: usize,
    /// Messages that may wait for one client.
    pub queue: usize,
}

impl ServerOptions {
    pub const MAX_CLIENTS: usize = 1000;
    /// One and a half seconds of eight tools at 40 Hz.
    pub const QUEUE: usize = 512;

    pub fn at(address: SocketAddr) -> Self {
        Self {
            address,
            max_clients: Self::MAX_CLIENTS,
            queue: Self::QUEUE,
        }
    }
}

/// What happens to a server; told from its thread.
#[derive(Clone, Debug, PartialEq)]
pub enum ServerEvent {
    Joined {
        client: SocketAddr,
        clients: usize,
    },
    Left {
        client: SocketAddr,
        why: Left,
        clients: usize,
    },
    /// There are as many clients as may be.
    Refused {
        client: SocketAddr,
    },
    /// The system would not accept a client; tried again soon.
    NotAccepted {
        why: String,
    },
}

/// Why a client is gone.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Left {
    #[error("it closed the connection")]
    Closed,
    #[error("the connection failed: {0}")]
    Failed(String),
    #[error("dropped: it did not read fast enough")]
    TooSlow,
    #[error("dropped: {0}")]
    Unreadable(super::codec::DecodeError),
    #[error("the server stopped")]
    Stopped,
}

/// Why there is no server.
#[derive(Debug, thiserror::Error)]
pub enum ServerError {
    #[error("port {port} of {host} is in use, expected a free one: another program serves there", port = .0.port(), host = .0.ip())]
    InUse(SocketAddr),
    #[error("cannot serve at {address}: {cause}")]
    Bind {
        address: SocketAddr,
        cause: io::Error,
    },
    #[error("cannot start the server's thread: {0}")]
    Thread(io::Error),
}

type Teller = Arc<dyn Fn(ServerEvent) + Send + Sync>;

/// What the thread that serves and those that publish share.
struct Shared {
    clients: Mutex<Vec<Slot>>,
    served: Mutex<Served>,
    latencies: Mutex<Latencies>,
    dropped_messages: AtomicU64,
}

/// A client, as seen by who publishes.
struct Slot {
    id: u64,
    queue: mpsc::Sender<Item>,
    /// Whether it has asked for tracking data, and gets them in place of transforms.
    is_tracking: Arc<std::sync::atomic::AtomicBool>,
    /// Its connection ends when this is dropped.
    _hold: oneshot::Sender<()>,
}

/// Locks whatever a thread that panicked left.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A server that runs as long as this is there.
pub struct Server {
    address: SocketAddr,
    shared: Arc<Shared>,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Server {
    /// Binds and serves; `tell` is called from the server's thread and is to return soon.
    ///
    /// # Errors
    /// See [`ServerError`].
    pub fn start(
        options: &ServerOptions,
        tell: impl Fn(ServerEvent) + Send + Sync + 'static,
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
            dropped_messages: AtomicU64::new(0),
        });
        let (stop, stopped) = oneshot::channel();
        let accepting = Accepting {
            listener,
            shared: shared.clone(),
            max_clients: options.max_clients,
            queue: options.queue.max(1),
            tell: Arc::new(tell),
        };
        let thread = std::thread::Builder::new()
            .name("live server".to_owned())
            .spawn(move || {
                runtime.block_on(accepting.run(stopped));
                runtime.shutdown_background();
            })
            .map_err(ServerError::Thread)?;
        Ok(Self {
            address,
            shared,
            stop: Some(stop),
            thread: Some(thread),
        })
    }

    /// Where it serves, with the port that was free.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    pub fn clients(&self) -> usize {
        lock(&self.shared.clients).len()
    }

    /// From the moments that transforms arrived here to those that they were written to clients.
    pub fn latencies(&self) -> LatencySummary {
        lock(&self.shared.latencies).summary()
    }

    /// Messages that were queued for clients that were dropped as too slow, and the ones that no
    /// longer found a place.
    pub fn dropped_messages(&self) -> u64 {
        self.shared.dropped_messages.load(Ordering::Relaxed)
    }

    /// Sends a tool's transform to all clients, at once; `arrived` is when what it says came in.
    ///
    /// # Errors
    /// A name that is too long.
    pub fn send_transform(
        &self,
        message: &Message,
        kind: ToolKind,
        arrived: Instant,
    ) -> Result<(), EncodeError> {
        let bytes: Arc<[u8]> = message.encode()?.into();
        lock(&self.shared.served).set(message, kind, &bytes);
        self.queue(&bytes, Some(arrived), |slot| {
            !slot.is_tracking.load(Ordering::Relaxed)
        });
        Ok(())
    }

    /// Sends any other message to all clients.
    ///
    /// # Errors
    /// A name that is too long.
    pub fn send(&self, message: &Message) -> Result<(), EncodeError> {
        let bytes: Arc<[u8]> = message.encode()?.into();
        self.queue(&bytes, None, |_| true);
        Ok(())
    }

    /// A tool is not good any more: nobody who asks is told where it was.
    pub fn withdraw(&self, tool: &str) {
        lock(&self.shared.served).remove(tool);
    }

    fn queue(&self, bytes: &Arc<[u8]>, arrived: Option<Instant>, is_for: impl Fn(&Slot) -> bool) {
        lock(&self.shared.clients).retain(|slot| {
            if !is_for(slot) {
                return true;
            }
            let item = Item::Send {
                bytes: bytes.clone(),
                arrived,
            };
            let is_taken = slot.queue.try_send(item).is_ok();
            if !is_taken {
                let waiting = slot.queue.max_capacity() - slot.queue.capacity() + 1;
                self.shared
                    .dropped_messages
                    .fetch_add(waiting as u64, Ordering::Relaxed);
            }
            is_taken
        });
    }

    /// Gives clients what is queued for them, for a second at most, and ends; how long all took.
    pub fn stop(mut self) -> LatencySummary {
        self.end();
        self.latencies()
    }

    fn end(&mut self) {
        if let Some(stop) = self.stop.take() {
            // A thread that ended by itself needs no word.
            let _ = stop.send(());
        }
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.end();
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
    max_clients: usize,
    queue: usize,
    tell: Teller,
}

impl Accepting {
    async fn run(self, mut stopped: oneshot::Receiver<()>) {
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
                    if lock(&self.shared.clients).len() >= self.max_clients {
                        refuse(stream, self.max_clients);
                        (self.tell)(ServerEvent::Refused { client });
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
                            (self.tell)(ServerEvent::NotAccepted { why });
                        }
                        was_accepting = false;
                        tokio::time::sleep(ACCEPT_PAUSE).await;
                    }
                }
            }
        }
        drop(self.listener);
        for slot in lock(&self.shared.clients).iter() {
            // One whose queue is full is not waited for: its place ends below.
            let _ = slot.queue.try_send(Item::End);
        }
        let all_gone = async { while connections.join_next().await.is_some() {} };
        let _ = tokio::time::timeout(FAREWELL, all_gone).await;
        lock(&self.shared.clients).clear();
    }

    fn welcome(
        &self,
        stream: TcpStream,
        client: SocketAddr,
        id: u64,
    ) -> impl Future<Output = ()> + use<> {
        let (queue, items) = mpsc::channel(self.queue);
        let (hold, let_go) = oneshot::channel();
        let is_tracking = Arc::default();
        let connection = Connection {
            stream,
            items,
            queue: queue.downgrade(),
            is_tracking: Arc::clone(&is_tracking),
            shared: self.shared.clone(),
        };
        let clients = {
            let mut clients = lock(&self.shared.clients);
            clients.push(Slot {
                id,
                queue,
                is_tracking,
                _hold: hold,
            });
            clients.len()
        };
        let tell = self.tell.clone();
        let shared = self.shared.clone();
        tell(ServerEvent::Joined { client, clients });
        async move {
            let why = connection.run(let_go).await;
            let clients = {
                let mut clients = lock(&shared.clients);
                clients.retain(|slot| slot.id != id);
                clients.len()
            };
            tell(ServerEvent::Left {
                client,
                why,
                clients,
            });
        }
    }
}

/// Says why and closes; a client that takes no hundred bytes gets none.
fn refuse(stream: TcpStream, max_clients: usize) {
    let status = Status::problem(
        StatusCode::RESOURCE_ERROR,
        "TOO_MANY_CLIENTS",
        format!("{max_clients} clients are served already"),
    );
    let message = Message::new("", super::codec::Timestamp::now(), Content::Status(status));
    if let (Ok(mut stream), Ok(bytes)) = (stream.into_std(), message.encode()) {
        let _ = stream.write(&bytes);
    }
}
