//! From what a tracker sends to what is sent on: each tool's pose compensated, and nothing sent on
//! as good that is not.
//!
//! A tool is good while samples of it keep coming that its tracker stands by, in time, in order, and
//! that the room's map corrects with certainty. In any other case no transform of it is sent:
//! receivers that look at no metadata would take it for where the tool is. They receive a STATUS
//! message with the tool's name instead, at once and again every second, and STATUS OK before the
//! next good one.

mod correction;
mod counts;
pub mod described;
mod incoming;
mod motion;
#[cfg(test)]
mod tests;
mod tool;

pub use correction::{Corrected, Correction, LiveDesign, LiveRoom};
pub use counts::{Reason, RelayCounts, ToolState};
pub use tool::{ClockChange, ToolClock};

use super::clock::ClockRules;
pub use super::clock::Moment;
use super::codec::{Content, Matrix, Message, Timestamp, ToolKind};
use super::roles::target_frame;
use incoming::{Incoming, incoming};
use std::collections::BTreeMap;
use std::time::{Duration, Instant};
use tool::Tool;
use trackwright_design::BodyRole;
use trackwright_geometry::pose::Pose;
use trackwright_simulation::body_prediction::BodyPrediction;
use trackwright_simulation::recording::Unusable;

/// Tools that are distinguished; a sender that goes on naming new ones fills no memory.
pub const MAX_TOOLS: usize = 256;

/// The options of a relay.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RelayOptions {
    /// The age from which a pose is not good: how long after its last good sample a tool is not good
    /// any more, and how much later than the fastest of its tool a sample may arrive.
    pub stale_after: Duration,
    /// A moment by both clocks, where the sender stamps by this machine's clock: a delay from the first
    /// sample on is seen then.
    pub shared_clock: Option<Moment>,
    /// Whether lateness that stays the same is taken for a sender's clock that was set back.
    pub follows_clock_steps: bool,
    /// The frame that the room's map is of, as it stands in `StylusToTracker`; transforms to others
    /// are not compensated. Names without a frame are taken for the tracker's own.
    pub tracker_frame: String,
}

impl RelayOptions {
    /// Ten frames of 40 Hz. A packet that is lost is sent again after 200 ms at the earliest, so that a
    /// shorter limit would take every lost packet for a stale tool.
    pub const STALE_AFTER: Duration = Duration::from_millis(250);
    pub const TRACKER_FRAME: &str = "Tracker";
}

impl Default for RelayOptions {
    fn default() -> Self {
        Self {
            stale_after: Self::STALE_AFTER,
            shared_clock: None,
            follows_clock_steps: false,
            tracker_frame: Self::TRACKER_FRAME.to_owned(),
        }
    }
}

/// What a relay makes of a message.
#[derive(Clone, Debug, PartialEq)]
pub enum Output {
    /// What was measured, for a recording.
    Measured { tool: String, timestamp: Timestamp, pose: Result<Pose, Unusable> },
    /// A tool that is good: its transform, to be sent on.
    Pose(SentPose),
    /// The status of a tool that is not good, or is again.
    Status { tool: String, state: ToolState, message: Message },
    /// What a tool's timestamps show, each kind once until it is over.
    Clock { tool: String, change: ClockChange },
    /// Samples that no tool is made for, the first of their kind.
    Refused { tool: String, reason: Reason },
}

/// A pose to be sent on.
#[derive(Clone, Debug, PartialEq)]
pub struct SentPose {
    pub tool: String,
    /// Which body of the design it is, where one is known and found.
    pub role: Option<BodyRole>,
    pub kind: ToolKind,
    pub measured: Pose,
    /// The pose of the message: compensated, where there is a map.
    pub pose: Pose,
    /// What the room's model predicts for it; `None` without a room, or where it keeps no support.
    pub known: Option<BodyPrediction>,
    pub clock: ToolClock,
    /// TRANSFORM with its own name and timestamp, and what is known as [metadata](described).
    pub message: Message,
}

/// Compensates and judges; knows no socket, and no clock but the moments it is given.
pub struct Relay<'a> {
    correction: Option<Correction<'a>>,
    options: RelayOptions,
    clock_rules: ClockRules,
    tools: BTreeMap<String, Tool>,
    counts: RelayCounts,
}

impl<'a> Relay<'a> {
    /// Without a correction poses are sent on as they are.
    pub fn new(correction: Option<Correction<'a>>, options: RelayOptions) -> Self {
        let clock_rules = ClockRules {
            bound: options.stale_after,
            follows_steps: options.follows_clock_steps,
            shared: options.shared_clock,
        };
        Self {
            correction,
            options,
            clock_rules,
            tools: BTreeMap::new(),
            counts: RelayCounts::default(),
        }
    }

    /// Goes on with another correction: what is known of the tools stays.
    pub fn with_correction(self, correction: Option<Correction<'_>>) -> Relay<'_> {
        Relay {
            correction,
            options: self.options,
            clock_rules: self.clock_rules,
            tools: self.tools,
            counts: self.counts,
        }
    }

    /// What was received, sent and dropped.
    pub fn counts(&self) -> &RelayCounts {
        &self.counts
    }

    /// Takes a message that arrived at a moment; adds what comes of it.
    pub fn receive(&mut self, message: &Message, at: Instant, out: &mut Vec<Output>) {
        self.counts.messages += 1;
        let mut readings: Vec<(Incoming, Pose)> = Vec::new();
        for sample in incoming(message) {
            self.counts.poses += 1;
            let pose = self.admit(&sample, message.timestamp, at);
            self.report_clock(&sample.tool, out);
            out.push(measured(&sample, message.timestamp, pose));
            match pose {
                Ok(pose) => readings.push((sample, pose)),
                Err(reason) => self.drop_sample(&sample.tool, reason, at, out),
            }
        }
        let compensated = self.compensate(&readings, at);
        for ((sample, reading), found) in readings.into_iter().zip(compensated) {
            match found {
                Ok(pose) => self.send(sample, (reading, pose), message, at, out),
                Err(reason) => self.drop_sample(&sample.tool, reason, at, out),
            }
        }
    }

    /// Marks tools of which no good sample came in time, and reminds of the others that are not good.
    pub fn tick(&mut self, now: Instant, out: &mut Vec<Output>) {
        for (name, tool) in &mut self.tools {
            let reason = match (tool.state, tool.lateness()) {
                (ToolState::Good, late) if tool.is_stale(self.options.stale_after, now) => {
                    self.counts.went_stale += 1;
                    late.unwrap_or(Reason::Stale)
                }
                (ToolState::Good, _) => continue,
                // It is received, but not in time.
                (ToolState::NotGood(Reason::Stale | Reason::LinkLost), Some(late)) => late,
                (ToolState::NotGood(reason), _) => reason,
            };
            tool.report_late(reason);
            out.extend(tool.take_change().map(|change| clock(name, change)));
            report(name, tool, reason, now, out);
        }
    }

    fn report_clock(&mut self, name: &str, out: &mut Vec<Output>) {
        let tool = self.tools.get_mut(name);
        let change = tool.and_then(Tool::take_change);
        out.extend(change.map(|change| clock(name, change)));
    }

    /// The tracker's server is gone: so are all tools. It may come back with another clock.
    pub fn lost(&mut self, now: Instant, out: &mut Vec<Output>) {
        for (name, tool) in &mut self.tools {
            tool.reconnect();
            report(name, tool, Reason::LinkLost, now, out);
        }
    }

    /// Nothing more is sent on.
    pub fn end(&mut self, now: Instant, out: &mut Vec<Output>) {
        for (name, tool) in &mut self.tools {
            report(name, tool, Reason::SessionEnds, now, out);
        }
    }

    /// The pose of a sample that can be used as a reading of the tracker.
    fn admit(
        &mut self,
        sample: &Incoming,
        timestamp: Timestamp,
        at: Instant,
    ) -> Result<Pose, Reason> {
        if !self.tools.contains_key(&sample.tool) {
            if sample.tool.trim().is_empty() {
                return Err(Reason::NoName);
            }
            if self.tools.len() >= MAX_TOOLS {
                return Err(Reason::TooManyTools);
            }
            let tool = Tool::new(self.clock_rules, at);
            self.tools.insert(sample.tool.clone(), tool);
        }
        let pose = sample.pose.as_ref().map_err(|refusal| refusal.reason)?;
        let Some(tool) = self.tools.get_mut(&sample.tool) else {
            return Err(Reason::TooManyTools);
        };
        tool.follows((timestamp, pose), at, &mut self.counts.clock_jumps)?;
        let frame = target_frame(&sample.tool).unwrap_or(&self.options.tracker_frame);
        if self.correction.is_some() && !frame.eq_ignore_ascii_case(&self.options.tracker_frame) {
            return Err(Reason::OtherFrame);
        }
        Ok(*pose)
    }

    fn compensate(
        &mut self,
        readings: &[(Incoming, Pose)],
        at: Instant,
    ) -> Vec<Result<Pose, Reason>> {
        match &mut self.correction {
            None => readings.iter().map(|(_, pose)| Ok(*pose)).collect(),
            Some(_) if readings.is_empty() => Vec::new(),
            Some(correction) => {
                let named: Vec<_> =
                    (readings.iter()).map(|(sample, pose)| (sample.tool.as_str(), *pose)).collect();
                let found = correction.correct(&named, at);
                let is_followed = |found: &&Result<Corrected, Reason>| {
                    matches!(found, Ok(Corrected { is_followed: true, .. }))
                };
                self.counts.followed += found.iter().filter(is_followed).count() as u64;
                found.into_iter().map(|found| Ok(found?.pose)).collect()
            }
        }
    }

    fn send(
        &mut self,
        sample: Incoming,
        (measured, pose): (Pose, Pose),
        message: &Message,
        at: Instant,
        out: &mut Vec<Output>,
    ) {
        let Some(tool) = self.tools.get_mut(&sample.tool) else {
            return;
        };
        if let Some(status) = tool.good(&sample.tool, at) {
            out.push(Output::Status {
                tool: sample.tool.clone(),
                state: ToolState::Good,
                message: status,
            });
        }
        self.counts.sent += 1;
        let clock = tool.clock();
        let known = (self.correction.as_ref())
            .and_then(|correction| correction.predict(&sample.tool, (&measured, &pose)));
        let mut extension = message.extension.clone().unwrap_or_default();
        described::describe(&mut extension, known.as_ref(), &clock);
        // What is not changed stays as it is to the bit.
        let unchanged = sample.matrix.filter(|_| self.correction.is_none());
        let matrix = unchanged.unwrap_or_else(|| Matrix::from_pose(&pose));
        let role = (self.correction.as_ref()).and_then(|c| c.role_of(&sample.tool));
        out.push(Output::Pose(SentPose {
            role,
            message: Message {
                device: sample.tool.clone(),
                timestamp: message.timestamp,
                content: Content::Transform(matrix),
                extension: Some(extension),
            },
            tool: sample.tool,
            kind: sample.kind,
            measured,
            pose,
            known,
            clock,
        }));
    }

    fn drop_sample(&mut self, name: &str, reason: Reason, at: Instant, out: &mut Vec<Output>) {
        let dropped = self.counts.dropped.entry(reason).or_default();
        *dropped += 1;
        if *dropped == 1 && matches!(reason, Reason::NoName | Reason::TooManyTools) {
            out.push(Output::Refused { tool: name.to_owned(), reason });
        }
        if reason.is_of_the_sample() {
            return;
        }
        if let Some(tool) = self.tools.get_mut(name) {
            report(name, tool, reason, at, out);
        }
    }
}

fn clock(name: &str, change: ClockChange) -> Output {
    Output::Clock { tool: name.to_owned(), change }
}

fn report(name: &str, tool: &mut Tool, reason: Reason, at: Instant, out: &mut Vec<Output>) {
    if let Some(message) = tool.not_good(name, reason, at) {
        out.push(Output::Status { tool: name.to_owned(), state: tool.state, message });
    }
}

/// What a recording has of a sample: what was measured, whether or not it can be corrected.
fn measured(sample: &Incoming, timestamp: Timestamp, admitted: Result<Pose, Reason>) -> Output {
    let pose = match (&sample.pose, admitted) {
        (Err(refusal), _) if refusal.reason == Reason::NoPose => Err(Unusable::NoPose),
        (Err(refusal), _) => Err(Unusable::State(refusal.word.clone())),
        (Ok(_), Err(reason)) if reason.is_of_the_sample() => {
            Err(Unusable::State(reason.to_string()))
        }
        (Ok(pose), _) => Ok(*pose),
    };
    Output::Measured { tool: sample.tool.clone(), timestamp, pose }
}
