//! One client of a server: what is queued goes out, what it asks for is answered.

use super::{Left, Shared, lock};
use crate::live::codec::{
    Content, Decoded, Decoder, Message, StartTracking, Status, StatusCode, Timestamp,
};
use crate::live::keepalive;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::net::tcp::{ReadHalf, WriteHalf};
use tokio::sync::{mpsc, oneshot};
use tokio::time::{Interval, MissedTickBehavior, interval};

/// The longest message that is read from a client: requests have 36 bytes.
const MAX_REQUEST_BYTES: usize = 4096;

/// Read at once.
const READ_BYTES: usize = 4096;

/// The shortest time between two messages of tracking data, whatever a client asks for.
const SHORTEST_INTERVAL: Duration = Duration::from_millis(5);

/// What goes through a client's queue.
pub enum Item {
    Send {
        bytes: Arc<[u8]>,
        /// When what it says came in, where that is to be measured.
        arrived: Option<Instant>,
    },
    /// From now on, tracking data in place of transforms; or no more.
    Track(Option<Tracking>),
    /// Nothing more comes.
    End,
}

/// Tracking data as a client asked for them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tracking {
    every: Duration,
    has_quaternions: bool,
}

pub struct Connection {
    pub stream: TcpStream,
    pub items: mpsc::Receiver<Item>,
    /// For answers; it keeps the queue of a client that was dropped from living on.
    pub queue: mpsc::WeakSender<Item>,
    pub is_tracking: Arc<AtomicBool>,
    pub shared: Arc<Shared>,
}

impl Connection {
    /// Serves until the client leaves or `let_go` says that its place is taken away.
    pub async fn run(self, let_go: oneshot::Receiver<()>) -> Left {
        let Self {
            mut stream,
            items,
            queue,
            is_tracking,
            shared,
        } = self;
        // Without it a transform may wait for the next one.
        if let Err(error) = stream.set_nodelay(true) {
            return Left::Failed(error.to_string());
        }
        keepalive::set(&stream);
        let (reading, writing) = stream.split();
        let requests = Requests {
            queue,
            is_tracking,
            shared: shared.clone(),
        };
        tokio::select! {
            why = requests.read(reading) => why,
            why = write(writing, items, &shared) => why,
            _ = let_go => Left::TooSlow,
        }
    }
}

/// Writes what is queued, message by message, and tracking data where they were asked for.
async fn write(mut out: WriteHalf<'_>, mut items: mpsc::Receiver<Item>, shared: &Shared) -> Left {
    let mut tracking: Option<(Tracking, Interval)> = None;
    let mut shown = 0;
    loop {
        let item = tokio::select! {
            item = items.recv() => item,
            () = tick(&mut tracking) => {
                let Some((wanted, _)) = &tracking else { continue };
                let Some(bytes) = snapshot(shared, wanted.has_quaternions, &mut shown) else {
                    continue;
                };
                Some(Item::Send { bytes, arrived: None })
            }
        };
        match item {
            Some(Item::Send { bytes, arrived }) => {
                if let Err(error) = out.write_all(&bytes).await {
                    return failed(&error);
                }
                if let Some(arrived) = arrived {
                    lock(&shared.latencies).record(arrived.elapsed());
                }
            }
            Some(Item::Track(wanted)) => {
                tracking = wanted.map(|wanted| {
                    let mut ticks = interval(wanted.every);
                    ticks.set_missed_tick_behavior(MissedTickBehavior::Skip);
                    (wanted, ticks)
                });
            }
            Some(Item::End) => {
                // It is gone either way.
                let _ = out.shutdown().await;
                return Left::Stopped;
            }
            None => return Left::TooSlow,
        }
    }
}

async fn tick(tracking: &mut Option<(Tracking, Interval)>) {
    match tracking {
        Some((_, ticks)) => {
            ticks.tick().await;
        }
        None => std::future::pending().await,
    }
}

/// All tools in one message, where any has moved since the last.
fn snapshot(shared: &Shared, has_quaternions: bool, shown: &mut u64) -> Option<Arc<[u8]>> {
    let served = lock(&shared.served);
    if served.revision == *shown {
        return None;
    }
    *shown = served.revision;
    Some(served.tracking(has_quaternions)?.encode().ok()?.into())
}

fn failed(error: &io::Error) -> Left {
    match error.kind() {
        io::ErrorKind::BrokenPipe | io::ErrorKind::ConnectionReset => Left::Closed,
        _ => Left::Failed(error.to_string()),
    }
}

/// What a client asks for.
struct Requests {
    queue: mpsc::WeakSender<Item>,
    is_tracking: Arc<AtomicBool>,
    shared: Arc<Shared>,
}

impl Requests {
    async fn read(self, mut stream: ReadHalf<'_>) -> Left {
        let mut decoder = Decoder::new(MAX_REQUEST_BYTES);
        let mut buffer = vec![0; READ_BYTES];
        loop {
            let mut arrived = match stream.read(&mut buffer).await {
                Ok(0) => return Left::Closed,
                Ok(count) => buffer.get(..count).unwrap_or_default(),
                Err(error) => return failed(&error),
            };
            while let Some(decoded) = decoder.next(&mut arrived) {
                let answers = match decoded {
                    Ok(Decoded::Message(message)) => self.answer(&message),
                    Ok(Decoded::Skipped { .. }) => Vec::new(),
                    Err(error) if error.ends_the_stream() => return Left::Unreadable(error),
                    // A request that cannot be read is one that is not answered.
                    Err(_) => Vec::new(),
                };
                for answer in answers {
                    let sent = self.queue.upgrade().map(|queue| queue.try_send(answer));
                    if !matches!(sent, Some(Ok(()))) {
                        return Left::TooSlow;
                    }
                }
            }
        }
    }

    fn answer(&self, request: &Message) -> Vec<Item> {
        let reply = |content| {
            let message = Message::new(request.device.clone(), Timestamp::now(), content);
            message.encode().ok().map(|bytes| Item::Send {
                bytes: bytes.into(),
                arrived: None,
            })
        };
        let start = |start: &StartTracking, has_quaternions| {
            self.is_tracking.store(true, Ordering::Relaxed);
            let every = Duration::from_millis(start.resolution_ms.into()).max(SHORTEST_INTERVAL);
            Item::Track(Some(Tracking {
                every,
                has_quaternions,
            }))
        };
        let stop = || {
            self.is_tracking.store(false, Ordering::Relaxed);
            Item::Track(None)
        };
        match &request.content {
            Content::StartTracking(wanted) => reply(Content::TrackingReply(0))
                .into_iter()
                .chain([start(wanted, false)])
                .collect(),
            Content::StartQuaternionTracking(wanted) => reply(Content::QuaternionTrackingReply(0))
                .into_iter()
                .chain([start(wanted, true)])
                .collect(),
            Content::StopTracking => [stop()]
                .into_iter()
                .chain(reply(Content::TrackingReply(0)))
                .collect(),
            Content::StopQuaternionTracking => [stop()]
                .into_iter()
                .chain(reply(Content::QuaternionTrackingReply(0)))
                .collect(),
            Content::GetTransform => {
                let found = lock(&self.shared.served).transforms(&request.device);
                if found.is_empty() {
                    let status = Status::problem(
                        StatusCode::NOT_FOUND,
                        "NOT_TRACKED",
                        "no transform of this name is good now",
                    );
                    return reply(Content::Status(status)).into_iter().collect();
                }
                let send = |bytes| Item::Send {
                    bytes,
                    arrived: None,
                };
                found.into_iter().map(send).collect()
            }
            Content::GetStatus => reply(Content::Status(Status::ok("serving")))
                .into_iter()
                .collect(),
            _ => Vec::new(),
        }
    }
}
