//! The state of the Live workspace: what was requested, the session, and what was last seen of it.

use crate::document::shown::LivePoses;
use crate::runner::wake::Waker;
use crate::workspaces::live::collected::{Collected, Collector};
use bevy::prelude::Resource;
use std::net::Ipv4Addr;
use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use trackwright_calibration::coverage::CoveragePlan;
use trackwright_design::{BodyRole, Design};
use trackwright_field::Environment;
use trackwright_field::OutsidePolicy;
use trackwright_field::compensation::Method;
use trackwright_openigtlink::client::ClientOptions;
use trackwright_openigtlink::codec::DEFAULT_PORT;
use trackwright_openigtlink::relay::{LiveDesign, LiveRoom, RelayOptions, ToolState};
use trackwright_openigtlink::roles::Assigned;
use trackwright_openigtlink::server::ServerOptions;
use trackwright_openigtlink::session::{
    Session, SessionError, SessionEvent, SessionSettings, SessionState,
};
use trackwright_simulation::Scenario;

/// What the workspace knows.
#[derive(Resource)]
pub struct LiveState {
    /// `HOST:PORT` of the tracker's server.
    pub server: String,
    /// The port that poses are sent on at.
    pub port: Option<u16>,
    /// The bodies that the person chose for tools.
    pub assigned: Assigned,
    /// How the session was when it was last looked at; the last look of one that is over.
    pub seen: Option<SessionState>,
    /// Why there is no session, or no recording.
    pub problem: Option<String>,
    /// Where samples were taken.
    pub collected: Option<Collected>,
    pub(crate) session: Option<Session>,
    pub(crate) collector: Collector,
    /// What the session compensates by.
    pub(crate) in_room: Option<RoomKey>,
    /// Whether poses are looked at, for the session's thread.
    pub(crate) is_shown: Arc<AtomicBool>,
}

/// What a session's room depends on: equal keys are equal rooms.
#[derive(Clone, Debug)]
pub(crate) struct RoomKey {
    pub generation: u64,
    pub revision: u64,
    pub environment: Arc<Environment>,
    pub assigned: Assigned,
}

impl PartialEq for RoomKey {
    fn eq(&self, other: &Self) -> bool {
        self.generation == other.generation
            && self.revision == other.revision
            && Arc::ptr_eq(&self.environment, &other.environment)
            && self.assigned == other.assigned
    }
}

impl Default for LiveState {
    fn default() -> Self {
        Self {
            server: format!("localhost:{DEFAULT_PORT}"),
            port: None,
            assigned: Assigned::new(),
            seen: None,
            problem: None,
            collected: None,
            session: None,
            collector: Collector::default(),
            in_room: None,
            is_shown: Arc::default(),
        }
    }
}

impl LiveState {
    pub fn is_connected(&self) -> bool {
        self.session.is_some()
    }

    /// Which bodies of a design do not stand where they are now, and why.
    pub fn troubles(&self, design: &Design) -> Vec<(BodyRole, String)> {
        let Some(seen) = &self.seen else {
            return Vec::new();
        };
        let trouble = |role: BodyRole| {
            let name = &design.body(role)?.rigid.name;
            let received = seen.tools.values().find(|view| view.role == Some(role));
            let text = match received.map(|view| view.state) {
                Some(ToolState::Good) => return None,
                Some(ToolState::NotGood(reason)) => format!("{name}, last good pose: {reason}"),
                None => format!("{name}, as designed: no pose received"),
            };
            Some((role, text))
        };
        BodyRole::ALL.into_iter().filter_map(trouble).collect()
    }

    pub fn is_recording(&self) -> bool {
        let recording = self.seen.as_ref().and_then(|seen| seen.recording.as_ref());
        self.is_connected() && recording.is_some_and(|recording| recording.failed.is_none())
    }

    /// Begins a session in a design's room.
    pub(crate) fn connect(
        &mut self,
        scenario: &Scenario,
        waker: &Waker,
    ) -> Result<(), SessionError> {
        let settings = SessionSettings {
            client: ClientOptions::to(&self.server),
            relay: RelayOptions::default(),
            room: Some(self.room(scenario)),
            server: (self.port)
                .map(|port| ServerOptions::at(SocketAddr::from((Ipv4Addr::LOCALHOST, port)))),
            record: None,
        };
        let (collector, waker) = (self.collector.clone(), waker.clone());
        let is_shown = Arc::clone(&self.is_shown);
        let session = Session::start(settings, move |event| {
            collector.receive(event);
            let is_pose = matches!(event, SessionEvent::Pose(_) | SessionEvent::Measured { .. });
            // What is not looked at wakes nobody.
            if !is_pose || is_shown.load(Ordering::Relaxed) {
                waker.wake();
            }
        })?;
        self.seen = Some(session.state());
        self.session = Some(session);
        self.problem = None;
        Ok(())
    }

    /// The room of a scenario, with its bodies.
    pub(crate) fn room(&self, scenario: &Scenario) -> LiveRoom {
        let mut design = LiveDesign::of(scenario);
        design.assigned.clone_from(&self.assigned);
        LiveRoom {
            method: Method::of(scenario.environment.model.map()),
            environment: Arc::clone(&scenario.environment),
            outside: OutsidePolicy::Reject,
            design: Some(design),
        }
    }

    /// Ends the session; what was seen of it stays.
    pub(crate) fn disconnect(&mut self) {
        if let Some(session) = self.session.take() {
            self.collector.pause();
            self.seen = Some(session.stop());
        }
        self.in_room = None;
    }

    /// Counts samples from now on, on from where it was where the volume is the same.
    pub(crate) fn collect(&mut self, plan: CoveragePlan) {
        self.collector.begin(plan);
    }
}

/// Takes what a session was seen at; whether it is new.
pub(crate) fn take_poses(poses: &mut LivePoses, seen: Option<&SessionState>) -> bool {
    let of = |role: BodyRole| {
        let view = seen?.tools.values().find(|view| view.role == Some(role))?;
        view.last.map(|(_, compensated, _)| compensated)
    };
    let (tool, crf) = (of(BodyRole::Tool), of(BodyRole::Crf));
    let is_new = (poses.tool, poses.crf) != (tool, crf);
    if is_new {
        *poses = LivePoses { number: poses.number + 1, tool, crf };
    }
    is_new
}
