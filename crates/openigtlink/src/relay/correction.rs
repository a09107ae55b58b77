//! How readings are corrected: bodies of a known design by their sensors, any other tool as if it
//! were a sensor.

use super::counts::Reason;
use super::motion::Motion;
use crate::roles::{Assigned, BodyNames, roles};
use nalgebra::{Point3, UnitQuaternion};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Instant;
use trackwright_design::BodyRole;
use trackwright_field::compensation::{Compensated, Compensator, Method};
use trackwright_field::inverse::InverseState;
use trackwright_field::{Environment, OutsidePolicy};
use trackwright_geometry::pose::Pose;
use trackwright_simulation::Scenario;
use trackwright_simulation::body_compensation::BodyCompensator;
use trackwright_simulation::body_prediction::{BodyPrediction, BodyPredictor};
use trackwright_simulation::{RigidBody, Sensor};
use trackwright_task::Task;

/// A room that poses are compensated by.
#[derive(Clone, Debug)]
pub struct LiveRoom {
    pub environment: Arc<Environment>,
    pub outside: OutsidePolicy,
    pub method: Method,
    /// The design whose tools are received; without one every tool counts as a sensor.
    pub design: Option<LiveDesign>,
}

/// The bodies that tools are looked for of.
#[derive(Clone, Debug)]
pub struct LiveDesign {
    pub tool: RigidBody,
    pub crf: Option<RigidBody>,
    pub orientation_weight_mm: f64,
    /// What the user has assigned of the tools.
    pub assigned: Assigned,
}

impl LiveDesign {
    /// The bodies of a scenario, with no tool assigned.
    pub fn of(scenario: &Scenario) -> Self {
        Self {
            tool: scenario.tool.clone(),
            crf: scenario.crf.as_ref().map(|crf| crf.body.clone()),
            orientation_weight_mm: scenario.orientation_weight_mm,
            assigned: Assigned::new(),
        }
    }

    /// What its bodies are called.
    pub fn names(&self) -> BodyNames {
        BodyNames {
            tool: self.tool.name.clone(),
            crf: self.crf.as_ref().map(|body| body.name.clone()),
        }
    }
}

/// A room made ready, and the bodies found so far.
pub struct Correction<'a> {
    method: Method,
    sensors: Compensator<'a>,
    sensor_predictor: BodyPredictor<'a>,
    bodies: BTreeMap<BodyRole, (BodyCompensator<'a>, BodyPredictor<'a>)>,
    names: BodyNames,
    assigned: Assigned,
    received: BTreeSet<String>,
    /// Which tool is which body.
    found: BTreeMap<String, BodyRole>,
    motion: Motion,
}

/// A corrected pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corrected {
    pub pose: Pose,
    /// Whether another one reads the same, to which the tool cannot have come since it was last seen.
    pub is_followed: bool,
}

impl<'a> Correction<'a> {
    /// Prepares a room.
    pub fn new(room: &'a LiveRoom) -> Self {
        let environment = &*room.environment;
        let ready = |body: &RigidBody, weight_mm| {
            let predictor = BodyPredictor::new(body, weight_mm, environment, room.outside);
            let body = body.clone();
            let compensator =
                BodyCompensator::new(body, weight_mm, environment, room.outside, room.method);
            (compensator, predictor)
        };
        let mut bodies = BTreeMap::new();
        if let Some(design) = &room.design {
            let weight_mm = design.orientation_weight_mm;
            bodies.insert(BodyRole::Tool, ready(&design.tool, weight_mm));
            if let Some(crf) = &design.crf {
                bodies.insert(BodyRole::Crf, ready(crf, weight_mm));
            }
        }
        let design = room.design.as_ref();
        // Its own weight decides nothing where there is one sensor.
        let sensor_predictor = BodyPredictor::new(&one_sensor(), 1.0, environment, room.outside);
        Self {
            method: room.method,
            sensor_predictor,
            sensors: Compensator::new(&environment.model, room.outside, room.method),
            bodies,
            names: design.map(LiveDesign::names).unwrap_or_default(),
            assigned: design.map(|d| d.assigned.clone()).unwrap_or_default(),
            received: BTreeSet::new(),
            found: BTreeMap::new(),
            motion: Motion::default(),
        }
    }

    /// Which body of the design a tool was found to be.
    pub fn role_of(&self, tool: &str) -> Option<BodyRole> {
        self.found.get(tool).copied()
    }

    /// The poses of tools by name, each corrected or refused, of readings that arrived at a moment.
    pub fn correct(
        &mut self,
        readings: &[(&str, Pose)],
        at: Instant,
    ) -> Vec<Result<Corrected, Reason>> {
        for (tool, _) in readings {
            self.add_tool(tool);
        }
        let body_of = |tool: &str| self.bodies.get(self.found.get(tool)?);
        let alone: Vec<Pose> = (readings.iter())
            .filter(|(tool, _)| body_of(tool).is_none())
            .map(|(_, pose)| *pose)
            .collect();
        // Nobody has the means to cancel it.
        let as_sensors = self.sensors.compensate(&alone, &Task::default());
        let mut as_sensors = as_sensors.unwrap_or_default().into_iter();
        let found: Vec<Option<Compensated>> = (readings.iter())
            .map(|(tool, measured)| match body_of(tool) {
                Some((body, _)) => Some(body.compensate(measured, &self.sensors)),
                None => as_sensors.next(),
            })
            .collect();
        let each = readings.iter().zip(found);
        each.map(|((tool, _), found)| self.followed(tool, &found.ok_or(Reason::NotConverged)?, at))
            .collect()
    }

    /// The pose of an answer that nothing speaks against, or that alone is near enough to the one before.
    fn followed(
        &mut self,
        tool: &str,
        found: &Compensated,
        at: Instant,
    ) -> Result<Corrected, Reason> {
        let only = match found.state {
            InverseState::Ambiguous(_) => self.motion.only(tool, found, at),
            _ => None,
        };
        let pose = only.map_or_else(|| certain(found), Ok)?;
        self.motion.saw(tool, &pose, at);
        Ok(Corrected { pose, is_followed: only.is_some() })
    }

    /// What is known of a tool's pose, as it was measured and as it was corrected.
    pub fn predict(
        &self,
        tool: &str,
        (measured, corrected): (&Pose, &Pose),
    ) -> Option<BodyPrediction> {
        let body = (self.found.get(tool)).and_then(|role| self.bodies.get(role));
        let predictor = body.map_or(&self.sensor_predictor, |(_, predictor)| predictor);
        // A correction map is a function of what was measured.
        predictor.predict(match self.method {
            Method::Inverse => corrected,
            Method::Correction | Method::Shortcut => measured,
        })
    }

    fn add_tool(&mut self, tool: &str) {
        if self.bodies.is_empty() || self.received.contains(tool) {
            return;
        }
        self.received.insert(tool.to_owned());
        let received = self.received.iter().map(String::as_str);
        self.found = (roles(received, &self.names, &self.assigned).into_iter())
            .map(|(role, tool)| (tool, role))
            .collect();
    }
}

/// What a tool is taken for that is no body of the design: a sensor at its origin.
fn one_sensor() -> RigidBody {
    RigidBody {
        name: String::new(),
        tip_in_body: None,
        sensors: vec![Sensor::six_dof("", Point3::origin(), UnitQuaternion::identity())],
    }
}

/// The pose of an answer that nothing speaks against.
fn certain(found: &Compensated) -> Result<Pose, Reason> {
    match (found.state, found.pose) {
        (InverseState::Converged, Some(pose)) => Ok(pose),
        (InverseState::Ambiguous(_), _) => Err(Reason::Ambiguous),
        (InverseState::Folded { .. }, _) => Err(Reason::Folded),
        (InverseState::Rejected, _) => Err(Reason::OutsideModel),
        (InverseState::NoReading, _) => Err(Reason::InMetal),
        (InverseState::Converged | InverseState::NotConverged, _) => Err(Reason::NotConverged),
    }
}
