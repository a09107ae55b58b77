//! What waits for one client, in order, and where the tools are now for those who request that. Poses that have become too old are thrown away, and never sent:
//! a client that stops reading and goes on gets fresh ones.

use crate::codec::{
    Content, EncodeError, Matrix, Message, QuaternionElement, Timestamp, ToolKind, TrackingElement,
};
use crate::thread::lock;
use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use tokio::sync::Notify;
use trackwright_geometry::pose::quaternion_to_array;

/// A client is up to date again once nothing was thrown away for so long.
const CAUGHT_UP_AFTER: Duration = Duration::from_secs(1);

/// A message as bytes, with headers of version 1 and of the version that it came with.
#[derive(Debug)]
pub struct Encoded {
    pub own: Arc<[u8]>,
    pub one: Arc<[u8]>,
}

impl Encoded {
    /// # Errors
    /// A name that is too long.
    pub fn of(message: &Message) -> Result<Self, EncodeError> {
        let own: Arc<[u8]> = message.encode()?.into();
        let one = match message.extension {
            None => Arc::clone(&own),
            Some(_) => {
                let plain = Message { extension: None, ..message.clone() };
                plain.encode()?.into()
            }
        };
        Ok(Self { own, one })
    }

    /// The bytes for a client that reads version 1 only, or both.
    pub fn bytes(&self, is_version_one: bool) -> &Arc<[u8]> {
        if is_version_one { &self.one } else { &self.own }
    }
}

/// When a pose came, and until when it may be sent.
#[derive(Clone, Copy, Debug)]
pub struct PoseTimes {
    pub arrived: Instant,
    /// Its age when it arrived, as far as that is known.
    pub latency: Duration,
    /// `None`: for ever.
    pub good_until: Option<Instant>,
}

impl PoseTimes {
    /// Of a pose that arrived at a moment and was as old as this then.
    pub fn new(arrived: Instant, latency: Duration, max_age: Duration) -> Self {
        Self { arrived, latency, good_until: arrived.checked_add(max_age.saturating_sub(latency)) }
    }

    pub fn is_too_old(&self, now: Instant) -> bool {
        self.good_until.is_some_and(|until| now > until)
    }

    /// From the measurement on, as far as that is known.
    pub fn age(&self, now: Instant) -> Duration {
        now.saturating_duration_since(self.arrived) + self.latency
    }
}

/// Tracking data as a client requested them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tracking {
    pub every: Duration,
    pub has_quaternions: bool,
}

/// What goes through a client's queue.
#[derive(Clone, Debug)]
pub enum Item {
    Send {
        message: Arc<Encoded>,
        /// `None` of what does not grow old.
        pose: Option<PoseTimes>,
    },
    /// From now on, tracking data in place of transforms; or no more.
    Track(Option<Tracking>),
    /// Nothing more comes.
    End,
}

impl Item {
    fn is_too_old(&self, now: Instant) -> bool {
        matches!(self, Self::Send { pose: Some(times), .. } if times.is_too_old(now))
    }

    fn is_pose(&self) -> bool {
        matches!(self, Self::Send { pose: Some(_), .. })
    }

    fn is_message(&self) -> bool {
        matches!(self, Self::Send { .. })
    }
}

/// The queue of one client, of bounded length; whoever fills it never waits.
#[derive(Debug)]
pub struct Outbox {
    waiting: Mutex<Waiting>,
    filled: Notify,
    limit: usize,
}

#[derive(Debug, Default)]
struct Waiting {
    items: VecDeque<Item>,
    dropped: Dropped,
}

/// What was thrown away since the client was up to date.
#[derive(Debug, Default)]
struct Dropped {
    count: u64,
    last: Option<Instant>,
    is_reported: bool,
}

impl Dropped {
    fn add(&mut self, count: usize, now: Instant) -> u64 {
        let count = count as u64;
        if count > 0 {
            self.count += count;
            self.last = Some(now);
        }
        count
    }
}

impl Outbox {
    pub fn new(limit: usize) -> Self {
        Self { waiting: Mutex::default(), filled: Notify::new(), limit: limit.max(1) }
    }

    /// Adds an item; how many messages were thrown away for it.
    pub fn push(&self, item: Item, now: Instant) -> u64 {
        let dropped = {
            let mut waiting = lock(&self.waiting);
            let before = waiting.items.len();
            while waiting.items.front().is_some_and(|item| item.is_too_old(now)) {
                waiting.items.pop_front();
            }
            if waiting.items.len() >= self.limit {
                waiting.make_room(now);
            }
            let dropped = before - waiting.items.len();
            waiting.items.push_back(item);
            waiting.dropped.add(dropped, now)
        };
        self.filled.notify_one();
        dropped
    }

    /// The next item, unless all that waits is too old, and how many before it were.
    pub async fn next(&self) -> (Option<Item>, u64) {
        loop {
            if let Some(next) = self.pop(Instant::now()) {
                return next;
            }
            self.filled.notified().await;
        }
    }

    /// `None` where nothing waits.
    fn pop(&self, now: Instant) -> Option<(Option<Item>, u64)> {
        let mut waiting = lock(&self.waiting);
        let mut dropped = 0;
        while let Some(item) = waiting.items.pop_front() {
            if !item.is_too_old(now) {
                return Some((Some(item), dropped));
            }
            dropped += waiting.dropped.add(1, now);
        }
        (dropped > 0).then_some((None, dropped))
    }

    /// Counts a message that had become too old when it was to be written; how many these are.
    pub fn dropped_at_write(&self) -> u64 {
        lock(&self.waiting).dropped.add(1, Instant::now())
    }

    /// Waits for more to be put in.
    pub async fn filled(&self) {
        self.filled.notified().await;
    }

    /// Whether messages were thrown away, the first time since the client was up to date.
    pub fn fell_behind(&self) -> bool {
        let mut waiting = lock(&self.waiting);
        let is_new = waiting.dropped.count > 0 && !waiting.dropped.is_reported;
        waiting.dropped.is_reported |= is_new;
        is_new
    }

    /// How many messages were thrown away for a client that is up to date again, once.
    pub fn caught_up(&self, now: Instant) -> Option<u64> {
        let mut waiting = lock(&self.waiting);
        let last = waiting.dropped.last?;
        let is_over =
            waiting.dropped.is_reported && now.saturating_duration_since(last) >= CAUGHT_UP_AFTER;
        is_over.then(|| std::mem::take(&mut waiting.dropped).count)
    }
}

impl Waiting {
    /// Throws away what is too old, else the oldest pose, else the oldest message.
    fn make_room(&mut self, now: Instant) {
        let before = self.items.len();
        self.items.retain(|item| !item.is_too_old(now));
        if self.items.len() < before {
            return;
        }
        let oldest = (self.items.iter().position(Item::is_pose))
            .or_else(|| self.items.iter().position(Item::is_message));
        self.items.remove(oldest.unwrap_or(0));
    }
}

/// The name of the device that tracking data come from.
pub const DEVICE: &str = "trackwright";

/// The tools that are good, each with what was last sent of it.
#[derive(Default)]
pub struct Served {
    tools: BTreeMap<String, ServedTool>,
    /// Goes up with every pose that came.
    pub revision: u64,
}

struct ServedTool {
    kind: ToolKind,
    matrix: Matrix,
    timestamp: Timestamp,
    encoded: Arc<Encoded>,
    times: PoseTimes,
}

impl Served {
    pub fn set(
        &mut self,
        message: &Message,
        kind: ToolKind,
        encoded: &Arc<Encoded>,
        times: PoseTimes,
    ) {
        let Content::Transform(matrix) = &message.content else {
            return;
        };
        self.revision += 1;
        let tool = ServedTool {
            kind,
            matrix: *matrix,
            timestamp: message.timestamp,
            encoded: Arc::clone(encoded),
            times,
        };
        self.tools.insert(message.device.clone(), tool);
    }

    pub fn remove(&mut self, tool: &str) {
        self.tools.remove(tool);
    }

    /// The last transform of a tool, of all tools where none is named; none that is too old.
    pub fn transforms(&self, name: &str, now: Instant) -> Vec<Arc<Encoded>> {
        self.fresh(now)
            .filter(|(tool, _)| name.is_empty() || name == tool.as_str())
            .map(|(_, tool)| Arc::clone(&tool.encoded))
            .collect()
    }

    fn fresh(&self, now: Instant) -> impl Iterator<Item = (&String, &ServedTool)> {
        (self.tools.iter()).filter(move |(_, tool)| !tool.times.is_too_old(now))
    }

    /// All tools in one message; `None` where there is none.
    pub fn tracking(&self, has_quaternions: bool, now: Instant) -> Option<Message> {
        let newest = self.fresh(now).map(|(_, tool)| tool.timestamp).max()?;
        let content = match has_quaternions {
            false => Content::Tracking(
                self.fresh(now)
                    .map(|(name, tool)| TrackingElement {
                        name: name.clone(),
                        kind: tool.kind,
                        matrix: tool.matrix,
                    })
                    .collect(),
            ),
            true => Content::QuaternionTracking(
                self.fresh(now).filter_map(|(name, tool)| quaternion_element(name, tool)).collect(),
            ),
        };
        Some(Message::new(DEVICE, newest, content))
    }
}

fn quaternion_element(name: &str, tool: &ServedTool) -> Option<QuaternionElement> {
    let pose = tool.matrix.pose().ok()?;
    let [w, x, y, z] = quaternion_to_array(&pose.rotation).map(|v| v as f32);
    let [.., at_x, at_y, at_z] = tool.matrix.0;
    Some(QuaternionElement {
        name: name.to_owned(),
        kind: tool.kind,
        at_mm: [at_x, at_y, at_z],
        quaternion: [x, y, z, w],
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::Status;

    fn pose(arrived: Instant) -> Item {
        Item::Send {
            message: status(),
            pose: Some(PoseTimes::new(
                arrived,
                Duration::from_millis(50),
                Duration::from_millis(250),
            )),
        }
    }

    fn status() -> Arc<Encoded> {
        let content = Content::Status(Status::ok("fine"));
        let message = Message::new("a", Timestamp::NONE, content);
        Arc::new(Encoded::of(&message).unwrap())
    }

    #[test]
    fn poses_beyond_their_age_are_dropped_and_counted() {
        let outbox = Outbox::new(100);
        let start = Instant::now();
        let at = |ms: u64| start + Duration::from_millis(ms);
        for ms in [0, 10, 20] {
            assert_eq!(outbox.push(pose(at(ms)), at(ms)), 0);
        }
        // 50 ms old when it arrived: 200 ms are left.
        assert_eq!(outbox.push(pose(at(205)), at(205)), 1);
        assert_eq!(outbox.push(pose(at(300)), at(300)), 2);
        assert!(outbox.fell_behind() && !outbox.fell_behind());
        assert_eq!(outbox.caught_up(at(1299)), None);
        assert_eq!(outbox.caught_up(at(1300)), Some(3));
        assert_eq!(outbox.caught_up(at(9999)), None);
        assert_eq!(lock(&outbox.waiting).items.len(), 2);
    }

    #[test]
    fn a_full_queue_loses_poses_before_statuses() {
        let outbox = Outbox::new(3);
        let now = Instant::now();
        let report = || Item::Send { message: status(), pose: None };
        for item in [report(), pose(now), pose(now)] {
            assert_eq!(outbox.push(item, now), 0);
        }
        for item in [report(), report(), report()] {
            assert_eq!(outbox.push(item, now), 1);
        }
        let waiting = lock(&outbox.waiting);
        assert!(waiting.items.len() == 3 && !waiting.items.iter().any(Item::is_pose));
    }
}
