//! One tool: whether it is good, and whether its next sample is one to be used.

use super::counts::{Reason, ToolState};
use crate::clock::{ClockRules, Judged, SenderClock};
use crate::codec::{Content, Message, Status, StatusCode, Timestamp};
use std::time::{Duration, Instant};
use trackwright_formats::printable::printable;
use trackwright_geometry::pose::Pose;

/// How often a tool that is not good is reported as such, for those who came later.
const REMINDER: Duration = Duration::from_secs(1);

/// One tool of a tracker.
pub struct Tool {
    pub state: ToolState,
    clock: SenderClock,
    bound_s: f64,
    /// Of the last sample that was in time; `None` without a timestamp.
    latency_s: Option<f64>,
    /// Late or early samples since the last one in time.
    off: Option<(Reason, f64)>,
    /// What is to be reported of the clock, and what has been.
    change: Option<ClockChange>,
    is_off_reported: bool,
    is_drift_reported: bool,
    /// The last sample that was in time and order.
    last: Option<(Timestamp, Pose)>,
    last_good: Instant,
    last_reported: Option<Instant>,
}

/// A tool's clock at a pose, in seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ToolClock {
    /// Above the fastest sample; `None` without timestamps.
    pub latency_s: Option<f64>,
    /// By how much the reference of latency has become later: as much more may be hidden.
    pub shift_s: f64,
}

/// What timestamps show of a clock, in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ClockChange {
    /// It was set, or latency changed for good; by so much later where positive.
    Step { by_s: f64 },
    /// Drift has moved it by more than the bound of latency.
    Drift { shift_s: f64 },
    /// Samples come so much later than the fastest, and the tool is not good for that.
    Late { by_s: f64 },
    /// Samples come so much earlier than the fastest so far, and the tool is not good for that.
    Early { by_s: f64 },
}

impl Tool {
    pub fn new(rules: ClockRules, at: Instant) -> Self {
        Self {
            state: ToolState::Good,
            clock: SenderClock::new(rules),
            bound_s: rules.bound.as_secs_f64(),
            latency_s: None,
            off: None,
            change: None,
            is_off_reported: false,
            is_drift_reported: false,
            last: None,
            last_good: at,
            last_reported: None,
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
            Judged::InTime { latency_s } => {
                self.latency_s = timestamp.is_stated().then_some(latency_s);
                self.look_at_drift();
            }
            Judged::Late { by_s } => return Err(self.is_off(Reason::Late, by_s)),
            Judged::Early { by_s } => return Err(self.is_off(Reason::Early, by_s)),
            Judged::AfterStep { by_s } => {
                *clock_jumps += 1;
                self.latency_s = Some(0.0);
                self.change = Some(ClockChange::Step { by_s });
                // The step was reported, which is more than its drift would be.
                self.is_drift_reported |= self.clock.shift_s() > self.bound_s;
                self.last = None;
            }
        }
        self.off = None;
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

    fn is_off(&mut self, reason: Reason, by_s: f64) -> Reason {
        self.off = Some((reason, by_s));
        reason
    }

    fn look_at_drift(&mut self) {
        let shift_s = self.clock.shift_s();
        if shift_s > self.bound_s && !self.is_drift_reported {
            self.is_drift_reported = true;
            self.change = Some(ClockChange::Drift { shift_s });
        }
    }

    /// Why no sample is in time, where samples come.
    pub fn lateness(&self) -> Option<Reason> {
        self.off.map(|(reason, _)| reason)
    }

    /// The tool is not good for a reason; what its clock has to do with it is to be reported once.
    pub fn report_late(&mut self, reason: Reason) {
        if let Some((off, by_s)) = self.off
            && off == reason
            && !self.is_off_reported
        {
            self.is_off_reported = true;
            self.change = Some(match off {
                Reason::Early => ClockChange::Early { by_s },
                _ => ClockChange::Late { by_s },
            });
        }
    }

    pub fn take_change(&mut self) -> Option<ClockChange> {
        self.change.take()
    }

    pub fn clock(&self) -> ToolClock {
        ToolClock { latency_s: self.latency_s, shift_s: self.clock.shift_s() }
    }

    /// A good sample came; reports it where the tool was not good before.
    pub fn good(&mut self, name: &str, at: Instant) -> Option<Message> {
        self.last_good = at;
        self.is_off_reported = false;
        let was = std::mem::replace(&mut self.state, ToolState::Good);
        self.last_reported = None;
        (was != ToolState::Good).then(|| status_message(name, ToolState::Good))
    }

    /// The tool is not good; reports it where that is new, and every second.
    pub fn not_good(&mut self, name: &str, reason: Reason, at: Instant) -> Option<Message> {
        let state = ToolState::NotGood(reason);
        let is_new = self.state != state;
        self.state = state;
        if !is_new && !self.is_to_be_reminded_of(at) {
            return None;
        }
        self.last_reported = Some(at);
        Some(status_message(name, state))
    }

    pub fn is_to_be_reminded_of(&self, at: Instant) -> bool {
        self.last_reported.is_none_or(|last| at.saturating_duration_since(last) >= REMINDER)
    }

    pub fn is_stale(&self, stale_after: Duration, now: Instant) -> bool {
        self.state == ToolState::Good && now.saturating_duration_since(self.last_good) > stale_after
    }

    /// What comes next is of another connection, and may be by another clock.
    pub fn reconnect(&mut self) {
        self.clock.reconnect();
        self.off = None;
        self.is_off_reported = false;
    }
}

/// A STATUS message of a tool, with a header that every receiver reads.
fn status_message(name: &str, state: ToolState) -> Message {
    let shown = printable(name);
    let status = match state {
        ToolState::Good => Status::problem(StatusCode::OK, "OK", format!("{shown} is tracked")),
        ToolState::NotGood(reason) => {
            let text = format!("no transform of {shown} is sent: {reason}");
            Status::problem(reason.status(), reason.name(), text)
        }
    };
    Message::new(name, Timestamp::now(), Content::Status(status))
}
