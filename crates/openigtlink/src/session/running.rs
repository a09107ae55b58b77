//! A session's own thread: from the client's messages to recording, server and state.

use super::{Input, Link, Recording, SessionEvent, SessionState, ToolView};
use crate::client::ClientEvent;
use crate::codec::{Content, DecodeError, Message, Status, StatusCode, Timestamp};
use crate::relay::{
    Correction, LiveRoom, Output, Relay, RelayOptions, SentPose, ToolClock, ToolState,
};
use crate::server::{DEVICE, LeaveReason, Server, ServerEvent};
use crate::thread::lock;
use std::collections::BTreeSet;
use std::mem::Discriminant;
use std::sync::Mutex;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};
use trackwright_formats::recording::live_table::LiveSample;
use trackwright_project::Recorder;

/// How often tools are looked at that send nothing: a fifth of the time after which they are stale.
const TICK: Duration = Duration::from_millis(50);

/// Types of unknown messages, and statuses of devices, that are reported at most.
const MAX_KINDS: usize = 64;

/// Why a session comes out of its loop.
pub enum Next {
    Stop,
    Room(Option<Box<LiveRoom>>),
}

/// In a room that lives as long as `'r`.
pub struct Running<'a, 'r, F> {
    relay: Relay<'r>,
    server: Option<&'a Server>,
    recorder: Option<Recorder>,
    state: &'a Mutex<SessionState>,
    on_event: F,
    /// Since when there is no connection.
    lost_since: Instant,
    skipped_kinds: BTreeSet<String>,
    reported_errors: Vec<Discriminant<DecodeError>>,
    reported_statuses: BTreeSet<(String, u16)>,
    outputs: Vec<Output>,
}

impl<'a, 'r, F: FnMut(&SessionEvent)> Running<'a, 'r, F> {
    /// In no room.
    pub fn new(
        options: RelayOptions,
        server: Option<&'a Server>,
        recorder: Option<Recorder>,
        state: &'a Mutex<SessionState>,
        on_event: F,
    ) -> Self {
        Self {
            relay: Relay::new(None, options),
            server,
            recorder,
            state,
            on_event,
            lost_since: Instant::now(),
            skipped_kinds: BTreeSet::new(),
            reported_errors: Vec::new(),
            reported_statuses: BTreeSet::new(),
            outputs: Vec::new(),
        }
    }

    /// Goes on in another room.
    pub fn in_room<'s>(self, room: Option<&'s LiveRoom>) -> Running<'a, 's, F> {
        Running {
            relay: self.relay.with_correction(room.map(Correction::new)),
            server: self.server,
            recorder: self.recorder,
            state: self.state,
            on_event: self.on_event,
            lost_since: self.lost_since,
            skipped_kinds: self.skipped_kinds,
            reported_errors: self.reported_errors,
            reported_statuses: self.reported_statuses,
            outputs: self.outputs,
        }
    }

    /// Until it receives a request to stop, or to go on in another room.
    pub fn run(&mut self, received: &Receiver<Input>) -> Next {
        let mut next_tick = Instant::now() + TICK;
        loop {
            let wait = next_tick.saturating_duration_since(Instant::now());
            match received.recv_timeout(wait) {
                Ok(Input::Client(event)) => self.client(event),
                Ok(Input::Server(event)) => self.served(event),
                Ok(Input::Room(room)) => return Next::Room(room),
                Ok(Input::Record(recorder)) => self.record_in(recorder),
                Ok(Input::Stop) | Err(RecvTimeoutError::Disconnected) => return Next::Stop,
                Err(RecvTimeoutError::Timeout) => {}
            }
            let now = Instant::now();
            if now >= next_tick {
                next_tick = now + TICK;
                let mut outputs = std::mem::take(&mut self.outputs);
                self.relay.tick(now, &mut outputs);
                self.act(outputs, now);
                self.update();
            }
        }
    }

    /// The session ends: clients are notified, and nothing is good.
    pub fn finish(&mut self) {
        let now = Instant::now();
        let mut outputs = std::mem::take(&mut self.outputs);
        self.relay.end(now, &mut outputs);
        self.act(outputs, now);
        if let Some(server) = self.server {
            let text = "the session ends: trackwright stops serving; the tracker may go on";
            let status = Status::problem(StatusCode::NOT_READY, "SESSION_ENDS", text);
            let message = Message::new(DEVICE, Timestamp::now(), Content::Status(status));
            // The name fits.
            let _ = server.send(&message);
        }
        self.update();
    }

    /// Brings what can be looked at up to date.
    pub fn update(&mut self) {
        let mut state = lock(self.state);
        state.counts = self.relay.counts().clone();
        if let (Some(recording), Some(recorder)) = (&mut state.recording, &self.recorder) {
            recording.samples = recorder.samples();
        }
        if let Some(server) = self.server {
            state.serving = Some((server.address(), server.clients()));
            state.latency = server.latencies();
            state.age = server.ages();
            state.undelivered = server.dropped_messages();
        }
    }

    fn client(&mut self, event: ClientEvent) {
        match event {
            ClientEvent::Received { message, arrived } => self.message(&message, arrived),
            ClientEvent::Connecting => self.link(Link::Connecting, SessionEvent::Connecting),
            ClientEvent::Connected { server } => {
                self.reported_errors.clear();
                self.reported_statuses.clear();
                lock(self.state).connections += 1;
                let since = Instant::now();
                self.link(Link::Connected { server, since }, SessionEvent::Connected { server });
            }
            ClientEvent::Lost { why, wait } => {
                let was_connected = matches!(lock(self.state).link, Link::Connected { .. });
                if was_connected {
                    self.lost_since = Instant::now();
                    let mut outputs = std::mem::take(&mut self.outputs);
                    self.relay.lost(self.lost_since, &mut outputs);
                    self.act(outputs, self.lost_since);
                }
                let link = Link::Lost { since: self.lost_since, why: why.clone(), wait };
                self.link(link, SessionEvent::Lost { why, wait });
            }
            ClientEvent::Skipped { kind } => {
                lock(self.state).skipped += 1;
                let is_new =
                    self.skipped_kinds.len() < MAX_KINDS && self.skipped_kinds.insert(kind.clone());
                if is_new {
                    (self.on_event)(&SessionEvent::Skipped { kind });
                }
            }
            ClientEvent::Unreadable(error) => {
                lock(self.state).unreadable += 1;
                let of_its_kind = std::mem::discriminant(&error);
                if !self.reported_errors.contains(&of_its_kind) {
                    self.reported_errors.push(of_its_kind);
                    (self.on_event)(&SessionEvent::Unreadable(error));
                }
            }
        }
    }

    fn link(&mut self, link: Link, event: SessionEvent) {
        lock(self.state).link = link;
        (self.on_event)(&event);
    }

    fn message(&mut self, message: &Message, arrived: Instant) {
        if let Content::Status(status) = &message.content
            && status.code != StatusCode::OK
            && self.reported_statuses.len() < MAX_KINDS
            && self.reported_statuses.insert((message.device.clone(), status.code.0))
        {
            (self.on_event)(&SessionEvent::TrackerStatus {
                device: message.device.clone(),
                status: status.clone(),
            });
        }
        let mut outputs = std::mem::take(&mut self.outputs);
        self.relay.receive(message, arrived, &mut outputs);
        self.act(outputs, arrived);
    }

    /// Sends, then records and reports: what others wait for comes first.
    fn act(&mut self, mut outputs: Vec<Output>, at: Instant) {
        if let Some(server) = self.server {
            for output in &outputs {
                // Names come from messages, where they had a place.
                let _ = match output {
                    Output::Pose(sent) => {
                        let latency_s = sent.clock.latency_s.unwrap_or(0.0);
                        let latency = Duration::try_from_secs_f64(latency_s).unwrap_or_default();
                        server.send_delayed(&sent.message, sent.kind, at, latency)
                    }
                    Output::Status { tool, state, message } => {
                        if *state != ToolState::Good {
                            server.withdraw(tool);
                        }
                        server.send(message)
                    }
                    Output::Measured { .. } | Output::Clock { .. } | Output::Refused { .. } => {
                        Ok(())
                    }
                };
            }
        }
        for output in outputs.drain(..) {
            match output {
                Output::Measured { tool, timestamp, pose } => {
                    self.record(&LiveSample {
                        received_s: Timestamp::now().seconds(),
                        time_s: timestamp.is_stated().then(|| timestamp.seconds()),
                        tool: &tool,
                        pose: pose.clone(),
                    });
                    if let Ok(pose) = pose {
                        (self.on_event)(&SessionEvent::Measured { tool, pose });
                    }
                }
                Output::Pose(sent) => self.show(sent, at),
                Output::Status { tool, state, .. } => self.report(tool, state),
                Output::Clock { tool, change } => {
                    (self.on_event)(&SessionEvent::Clock { tool, change });
                }
                Output::Refused { tool, reason } => {
                    (self.on_event)(&SessionEvent::Refused { tool, reason });
                }
            }
        }
        self.outputs = outputs;
    }

    fn record_in(&mut self, recorder: Option<Recorder>) {
        self.recorder = recorder;
        let recording = (self.recorder.as_ref()).map(|r| Recording::begun(r.path().to_owned()));
        lock(self.state).recording = recording;
    }

    fn record(&mut self, sample: &LiveSample) {
        let Some(recorder) = &mut self.recorder else {
            return;
        };
        if let Err(error) = recorder.add(sample) {
            let why = error.to_string();
            let recording = Recording {
                file: recorder.path().to_owned(),
                samples: recorder.samples(),
                failed: Some(why.clone()),
            };
            lock(self.state).recording = Some(recording);
            self.recorder = None;
            (self.on_event)(&SessionEvent::NotRecorded { why });
        }
    }

    fn show(&mut self, sent: SentPose, at: Instant) {
        let is_new = {
            let mut state = lock(self.state);
            let last = Some((sent.measured, sent.pose, at));
            let view =
                ToolView { state: ToolState::Good, role: sent.role, last, clock: sent.clock };
            state.tools.insert(sent.tool.clone(), view).is_none()
        };
        if is_new {
            (self.on_event)(&SessionEvent::Tool {
                tool: sent.tool.clone(),
                state: ToolState::Good,
            });
        }
        (self.on_event)(&SessionEvent::Pose(Box::new(sent)));
    }

    /// Reported where it is new; clients are reminded, a person is not.
    fn report(&mut self, tool: String, new: ToolState) {
        let is_new = {
            let mut state = lock(self.state);
            let view = state.tools.entry(tool.clone()).or_insert(ToolView {
                state: ToolState::Good,
                role: None,
                last: None,
                clock: ToolClock::default(),
            });
            std::mem::replace(&mut view.state, new) != new
        };
        if is_new {
            (self.on_event)(&SessionEvent::Tool { tool, state: new });
        }
    }

    fn served(&mut self, event: ServerEvent) {
        if let ServerEvent::Left { why: LeaveReason::TooSlow, .. } = event {
            lock(self.state).slow_clients += 1;
        }
        (self.on_event)(&SessionEvent::Server(event));
    }
}
