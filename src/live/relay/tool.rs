//! One tool: whether it is good, and whether its next sample is one to be used.

use super::counts::Reason;
use super::{REMINDER, RelayOptions, ToolState};
use crate::geometry::pose::Pose;
use crate::live::clock::{Judged, SenderClock};
use crate::live::codec::{Content, Message, Status, StatusCode, Timestamp};
use std::time::Instant;

pub struct Tool {
    pub state: ToolState,
    clock: SenderClock,
    /// The last sample that was in time and order.
    last: Option<(Timestamp, Pose)>,
    last_good: Instant,
    last_said: Option<Instant>,
}

impl Tool {
    pub fn new(options: &RelayOptions, at: Instant) -> Self {
        Self {
            state: ToolState::Good,
            clock: SenderClock::new(options.stale_after),
            last: None,
            last_good: at,
            last_said: None,
        }
    }

    /// Whether a sample is newer than all before it and not late; counts clocks that were set.
    pub fn follows(
        &mut self,
        (timestamp, pose): (Timestamp, &Pose),
        at: Instant,
        clock_jumps: &mut u64,
    ) -> Result<(), Reason> {
        match self.clock.judge(timestamp, at) {
            Judged::InTime => {}
            Judged::Late => return Err(Reason::Late),
            Judged::AfterJump => {
                *clock_jumps += 1;
                self.last = None;
            }
        }
        if let Some((last, last_pose)) = &self.last
            && timestamp.is_stated()
            && last.is_stated()
        {
            if timestamp < *last {
                return Err(Reason::OutOfOrder);
            }
            if timestamp == *last && pose == last_pose {
                return Err(Reason::Repeated);
            }
        }
        self.last = Some((timestamp, *pose));
        Ok(())
    }

    /// A good sample came; says so where the tool was not good before.
    pub fn good(&mut self, name: &str, at: Instant) -> Option<Message> {
        self.last_good = at;
        let was = std::mem::replace(&mut self.state, ToolState::Good);
        self.last_said = None;
        (was != ToolState::Good).then(|| said(name, ToolState::Good))
    }

    /// The tool is not good; says so where that is new, and every second.
    pub fn not_good(&mut self, name: &str, reason: Reason, at: Instant) -> Option<Message> {
        let state = ToolState::NotGood(reason);
        let is_new = self.state != state;
        self.state = state;
        if !is_new && !self.is_to_be_reminded_of(at) {
            return None;
        }
        self.last_said = Some(at);
        Some(said(name, state))
    }

    pub fn is_to_be_reminded_of(&self, at: Instant) -> bool {
        self.last_said
            .is_none_or(|said| at.saturating_duration_since(said) >= REMINDER)
    }

    pub fn is_stale(&self, options: &RelayOptions, now: Instant) -> bool {
        self.state == ToolState::Good
            && now.saturating_duration_since(self.last_good) > options.stale_after
    }

    /// What comes next is by another clock.
    pub fn forget_clock(&mut self, options: &RelayOptions) {
        self.clock = SenderClock::new(options.stale_after);
        self.last = None;
    }
}

/// A STATUS message of a tool, with a header that every receiver reads.
fn said(name: &str, state: ToolState) -> Message {
    let status = match state {
        ToolState::Good => Status {
            code: StatusCode::OK,
            subcode: 0,
            name: "OK".to_owned(),
            text: format!("{name} is tracked"),
        },
        ToolState::NotGood(reason) => Status {
            code: reason.status(),
            subcode: 0,
            name: reason.name().to_owned(),
            text: format!("no transform of {name} is sent: {reason}"),
        },
    };
    Message::new(name, Timestamp::now(), Content::Status(status))
}
