//! One client of a server: what is queued goes out, what it requests is answered.

use super::outbox::{Encoded, Item, Outbox, PoseTimes, Tracking};
use super::{EventHandler, LeaveReason, ServerEvent, Shared};
use crate::client::keep_alive;
use crate::codec::{
    Content, Decoded, Decoder, Message, StartTracking, Status, StatusCode, Timestamp,
};
use crate::thread::lock;
use std::io;
use std::net::SocketAddr;
use std::pin::pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::net::tcp::{ReadHalf, WriteHalf};
use tokio::sync::oneshot;
use tokio::time::{Interval, MissedTickBehavior, interval, sleep};

/// The longest message that is read from a client: requests have 36 bytes.
const MAX_REQUEST_BYTES: usize = 4096;

/// Read at once.
const READ_BYTES: usize = 4096;

/// The shortest time between two messages of tracking data, whatever a client requests.
const SHORTEST_INTERVAL: Duration = Duration::from_millis(5);

/// A message is taken by the system once fewer bytes than this wait for being sent: what it has is
/// sent, however old it has become, so that it is to have one message only. Where it took a part of
/// one, the rest has to follow: a stream cannot go on without it.
#[cfg(any(target_os = "linux", target_os = "android"))]
const UNSENT_BYTES: u32 = 1;

pub struct Connection {
    pub client: SocketAddr,
    pub outbox: Arc<Outbox>,
    pub is_tracking: Arc<AtomicBool>,
    /// Whether the client is known to read headers of version 1 only.
    pub is_version_one: AtomicBool,
    pub shared: Arc<Shared>,
    pub on_event: EventHandler,
    /// A client that takes nothing for so long is dropped.
    pub stuck_after: Duration,
}

impl Connection {
    /// Serves until the client leaves or `let_go` reports that its slot is taken away.
    pub async fn run(self, mut stream: TcpStream, let_go: oneshot::Receiver<()>) -> LeaveReason {
        // Without it a transform may wait for the next one.
        if let Err(error) = stream.set_nodelay(true) {
            return LeaveReason::Failed(error.to_string());
        }
        keep_alive(&stream);
        #[cfg(any(target_os = "linux", target_os = "android"))]
        {
            // Where it cannot be set a client that stops reading gets some old poses more.
            let _ = socket2::SockRef::from(&stream).set_tcp_notsent_lowat(UNSENT_BYTES);
        }
        let (reading, writing) = stream.split();
        tokio::select! {
            why = self.answer_requests(reading) => why,
            why = self.write_queue(writing) => why,
            _ = let_go => LeaveReason::Stopped,
        }
    }

    /// Writes what is queued, message by message, and tracking data where they were requested.
    async fn write_queue(&self, mut out: WriteHalf<'_>) -> LeaveReason {
        let mut tracking: Option<(Tracking, Interval)> = None;
        let mut shown = 0;
        loop {
            let (item, dropped) = tokio::select! {
                next = self.outbox.next() => next,
                () = tick(&mut tracking) => {
                    let Some((wanted, _)) = &tracking else { continue };
                    let Some(message) = snapshot(&self.shared, wanted.has_quaternions, &mut shown)
                    else {
                        continue;
                    };
                    (Some(Item::Send { message, pose: None }), 0)
                }
            };
            self.shared.count_dropped(dropped);
            let Some(item) = item else { continue };
            match item {
                Item::Send { message, pose } => {
                    let bytes = message.bytes(self.is_version_one.load(Ordering::Relaxed));
                    let now = match self.write(&out, bytes, pose).await {
                        Ok(Some(taken_at)) => taken_at,
                        Ok(None) => {
                            self.shared.count_dropped(self.outbox.dropped_at_write());
                            continue;
                        }
                        Err(why) => return why,
                    };
                    if let Some(times) = pose {
                        let taken = now.saturating_duration_since(times.arrived);
                        lock(&self.shared.latencies).record(taken);
                        lock(&self.shared.ages).record(times.age(now));
                    }
                    if let Some(dropped) = self.outbox.caught_up(now) {
                        let client = self.client;
                        (self.on_event)(ServerEvent::CaughtUp { client, dropped });
                    }
                }
                Item::Track(wanted) => {
                    tracking = wanted.map(|wanted| {
                        let mut ticks = interval(wanted.every);
                        ticks.set_missed_tick_behavior(MissedTickBehavior::Skip);
                        (wanted, ticks)
                    });
                }
                Item::End => {
                    // It is gone either way.
                    let _ = out.shutdown().await;
                    return LeaveReason::Stopped;
                }
            }
        }
    }

    /// Writes one message whole, and returns where what waits behind it has become too old. A pose
    /// that has become too old before any of it was taken is not written; else when the last of the
    /// message was given to the system.
    ///
    /// # Errors
    /// Why the client is gone.
    async fn write(
        &self,
        out: &WriteHalf<'_>,
        mut bytes: &[u8],
        pose: Option<PoseTimes>,
    ) -> Result<Option<Instant>, LeaveReason> {
        let whole = bytes.len();
        let mut stuck = pin!(sleep(self.stuck_after));
        let mut now = Instant::now();
        while !bytes.is_empty() {
            if self.outbox.fell_behind() {
                let client = self.client;
                (self.on_event)(ServerEvent::FellBehind { client });
            }
            tokio::select! {
                // Most messages are taken at once, which needs no timer.
                biased;
                ready = out.writable() => {
                    now = Instant::now();
                    let is_too_old = pose.is_some_and(|times| times.is_too_old(now));
                    if is_too_old && bytes.len() == whole {
                        return Ok(None);
                    }
                    match ready.and_then(|()| out.try_write(bytes)) {
                        Ok(taken) => bytes = bytes.get(taken..).unwrap_or_default(),
                        Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
                        Err(error) => return Err(failed(&error)),
                    }
                }
                () = self.outbox.filled() => {}
                () = &mut stuck => return Err(LeaveReason::TooSlow),
            }
        }
        Ok(Some(now))
    }

    async fn answer_requests(&self, mut stream: ReadHalf<'_>) -> LeaveReason {
        let mut decoder = Decoder::new(MAX_REQUEST_BYTES);
        let mut buffer = vec![0; READ_BYTES];
        loop {
            let mut arrived = match stream.read(&mut buffer).await {
                Ok(0) => return LeaveReason::Closed,
                Ok(count) => buffer.get(..count).unwrap_or_default(),
                Err(error) => return failed(&error),
            };
            while let Some(decoded) = decoder.next(&mut arrived) {
                let answers = match decoded {
                    Ok(Decoded::Message(message)) => {
                        // As PLUS does: whoever writes version 1 is not known to read another.
                        let is_version_one = message.extension.is_none();
                        self.is_version_one.store(is_version_one, Ordering::Relaxed);
                        self.answer(&message)
                    }
                    Ok(Decoded::Skipped { .. }) => Vec::new(),
                    Err(error) if error.ends_the_stream() => return LeaveReason::Unreadable(error),
                    // A request that cannot be read is one that is not answered.
                    Err(_) => Vec::new(),
                };
                for answer in answers {
                    let dropped = self.outbox.push(answer, Instant::now());
                    self.shared.count_dropped(dropped);
                }
            }
        }
    }

    fn answer(&self, request: &Message) -> Vec<Item> {
        let reply = |content| {
            let message = Message::new(request.device.clone(), Timestamp::now(), content);
            Encoded::of(&message)
                .ok()
                .map(|message| Item::Send { message: Arc::new(message), pose: None })
        };
        let start = |answer, wanted: &StartTracking, has_quaternions| {
            self.is_tracking.store(true, Ordering::Relaxed);
            let every = Duration::from_millis(wanted.resolution_ms.into()).max(SHORTEST_INTERVAL);
            let tracking = Tracking { every, has_quaternions };
            reply(answer).into_iter().chain([Item::Track(Some(tracking))]).collect()
        };
        let stop = |answer| {
            self.is_tracking.store(false, Ordering::Relaxed);
            [Item::Track(None)].into_iter().chain(reply(answer)).collect()
        };
        match &request.content {
            Content::StartTracking(wanted) => start(Content::TrackingReply(0), wanted, false),
            Content::StartQuaternionTracking(wanted) => {
                start(Content::QuaternionTrackingReply(0), wanted, true)
            }
            Content::StopTracking => stop(Content::TrackingReply(0)),
            Content::StopQuaternionTracking => stop(Content::QuaternionTrackingReply(0)),
            Content::GetTransform => {
                let found = lock(&self.shared.served).transforms(&request.device, Instant::now());
                if found.is_empty() {
                    let status = Status::problem(
                        StatusCode::NOT_FOUND,
                        "NOT_TRACKED",
                        "no transform of this name is good now",
                    );
                    return reply(Content::Status(status)).into_iter().collect();
                }
                let send = |message| Item::Send { message, pose: None };
                found.into_iter().map(send).collect()
            }
            Content::GetStatus => {
                reply(Content::Status(Status::ok("serving"))).into_iter().collect()
            }
            _ => Vec::new(),
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
fn snapshot(shared: &Shared, has_quaternions: bool, shown: &mut u64) -> Option<Arc<Encoded>> {
    let served = lock(&shared.served);
    if served.revision == *shown {
        return None;
    }
    *shown = served.revision;
    let message = served.tracking(has_quaternions, Instant::now())?;
    Encoded::of(&message).ok().map(Arc::new)
}

fn failed(error: &io::Error) -> LeaveReason {
    match error.kind() {
        io::ErrorKind::BrokenPipe | io::ErrorKind::ConnectionReset => LeaveReason::Closed,
        _ => LeaveReason::Failed(error.to_string()),
    }
}
