//! What can be looked at of a session at any time.

use super::SessionSettings;
use crate::client::DisconnectReason;
use crate::latency::LatencySummary;
use crate::relay::{RelayCounts, ToolClock, ToolState};
use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::{Duration, Instant};
use trackwright_design::BodyRole;
use trackwright_geometry::pose::Pose;

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
    /// Clients that were dropped because they did not read, and the messages that clients did not get
    /// because they had become too old.
    pub slow_clients: u64,
    pub undelivered: u64,
    /// From the read off the tracker's connection to the write into a client's.
    pub latency: LatencySummary,
    /// Of poses when they were written into a client's connection, as far as timestamps tell.
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
    pub(super) fn begun(file: PathBuf) -> Self {
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
    pub(super) fn new(settings: &SessionSettings, address: Option<SocketAddr>) -> Self {
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
