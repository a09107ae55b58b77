//! A layout while it is searched for: bodies and poses, and the numbers that move them.

use crate::footing::{FootPose, Footing};
use crate::outcome::OptimizeError;
use crate::places::{PlacedSensor, Places};
use crate::problem::{MountedBody, PoseBounds, Problem};
use nalgebra::{Point3, Translation3, Vector3};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::pose::Pose;
use trackwright_geometry::rotation::exp_vector;
use trackwright_simulation::{PlacedBody, RigidBody, Scenario, ScenarioCrf};

/// What a study needs besides the room.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Bodies {
    pub tool: RigidBody,
    pub crf: Option<RigidBody>,
    /// `None` without a CRF.
    pub tracker_from_crf: Option<Pose>,
    pub crf_from_tool: Pose,
}

impl Bodies {
    pub fn of(scenario: &Scenario) -> Self {
        Self {
            tool: scenario.tool.clone(),
            crf: scenario.crf.as_ref().map(|crf| crf.body.clone()),
            tracker_from_crf: scenario.crf.as_ref().map(|crf| crf.tracker_from_crf),
            crf_from_tool: scenario.crf_from_tool,
        }
    }

    pub fn body(&self, body: PlacedBody) -> Option<&RigidBody> {
        match body {
            PlacedBody::Tool => Some(&self.tool),
            PlacedBody::Crf => self.crf.as_ref(),
        }
    }

    pub fn body_mut(&mut self, body: PlacedBody) -> Option<&mut RigidBody> {
        match body {
            PlacedBody::Tool => Some(&mut self.tool),
            PlacedBody::Crf => self.crf.as_mut(),
        }
    }

    /// The scenario with these bodies where they are.
    pub fn in_room(&self, scenario: &Scenario) -> Scenario {
        Scenario {
            tool: self.tool.clone(),
            crf: self
                .crf
                .clone()
                .zip(self.tracker_from_crf)
                .map(|(body, tracker_from_crf)| ScenarioCrf { body, tracker_from_crf }),
            crf_from_tool: self.crf_from_tool,
            motion: scenario.motion.map(|motion| {
                motion.with_reference_moved(&scenario.crf_from_tool, &self.crf_from_tool)
            }),
            ..scenario.clone()
        }
    }

    /// The field generator moved in its own axes: all else stays where it is in the room. The
    /// field's errors go with the generator.
    fn with_generator_moved(&mut self, moved: &Pose) {
        let back = moved.inverse();
        match &mut self.tracker_from_crf {
            Some(tracker_from_crf) => *tracker_from_crf = back * *tracker_from_crf,
            None => self.crf_from_tool = back * self.crf_from_tool,
        }
    }

    /// The CRF moved in its own axes; the tool stays where it is in the room.
    fn with_crf_moved(&mut self, moved: &Pose) {
        if let Some(tracker_from_crf) = &mut self.tracker_from_crf {
            *tracker_from_crf *= moved;
            self.crf_from_tool = moved.inverse() * self.crf_from_tool;
        }
    }
}

/// A sensor that moves: its body and its number there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Slot {
    pub body: PlacedBody,
    pub index: usize,
}

/// The slots of a problem and where each may be.
pub(crate) struct Movable<'a> {
    pub slots: Vec<Slot>,
    tool: Places<'a>,
    crf: Option<Places<'a>>,
    generator: Option<PoseBounds>,
    /// Where the CRF moves freely.
    crf_pose: Option<PoseBounds>,
    /// Where it moves over a patch of the patient.
    footing: Option<Footing<'a>>,
    /// What nothing was moved of.
    pub base: Bodies,
}

/// Places of all slots, and how far the poses were moved: three shifts in mm and three turns in
/// degrees each; and where the CRF stands on its patch.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Position {
    pub places: Vec<PlacedSensor>,
    pub generator: Vector6,
    pub crf_pose: Vector6,
    pub foot_pose: Option<FootPose>,
}

type Vector6 = [f64; 6];

/// Turn of a pose, degrees, that counts as much as a millimetre.
const TURN_DEG_PER_MM: f64 = 0.1;

impl<'a> Movable<'a> {
    pub fn new(
        problem: &'a Problem,
        base: Bodies,
        slots: Vec<Slot>,
    ) -> Result<Self, OptimizeError> {
        for bounds in [problem.moves.generator, problem.moves.crf_pose].into_iter().flatten() {
            for found in bounds.shift_mm.iter().copied().chain([bounds.turn_deg]) {
                if !(found.is_finite() && found >= 0.0) {
                    return Err(OptimizeError::Bounds {
                        found,
                        expected: "a finite number from 0",
                    });
                }
            }
        }
        let crf = problem.crf.as_ref().zip(base.crf.as_ref());
        let crf_pose = problem.moves.crf_pose.filter(|_| base.crf.is_some());
        let footing = match (crf_pose, &problem.crf_patches[..]) {
            (None, _) | (_, []) => None,
            (Some(bounds), [patch]) => Some(Footing::new(patch, &middle_of_crf(problem), bounds)?),
            (Some(_), patches) => {
                let anatomy = patches.iter().map(|patch| patch.anatomy.clone()).collect();
                return Err(OptimizeError::SeveralPatches { anatomy });
            }
        };
        Ok(Self {
            tool: Places::new(&problem.tool, base.tool.tip_in_body),
            crf: crf.map(|(mounted, body)| Places::new(mounted, body.tip_in_body)),
            generator: problem.moves.generator,
            crf_pose: crf_pose.filter(|_| footing.is_none()),
            footing,
            slots,
            base,
        })
    }

    /// Where the sensors of a body may be.
    pub fn places(&self, body: PlacedBody) -> Option<&Places<'a>> {
        match body {
            PlacedBody::Tool => Some(&self.tool),
            PlacedBody::Crf => self.crf.as_ref(),
        }
    }

    /// Poses as they are, sensors at these places.
    pub fn position(&self, places: Vec<PlacedSensor>) -> Position {
        let foot_pose = self.footing.as_ref().map(|footing| footing.start);
        Position { places, generator: [0.0; 6], crf_pose: [0.0; 6], foot_pose }
    }

    /// Whether a pose moves.
    pub fn has_poses(&self) -> bool {
        self.pose_bounds().count() > 0 || self.footing.is_some()
    }

    /// Whether the CRF is within its patch and bounds; other poses always are.
    pub fn is_on_patch(&self, position: &Position) -> bool {
        let own = self.footing.as_ref().zip(position.foot_pose.as_ref());
        own.is_none_or(|(footing, foot_pose)| footing.is_allowed(foot_pose))
    }

    /// Where the CRF may stand, spread over its patch; nothing without one.
    pub fn foot_poses(&self) -> Vec<FootPose> {
        self.footing.as_ref().map_or_else(Vec::new, Footing::spread_out)
    }

    pub fn bodies(&self, position: &Position) -> Bodies {
        let mut bodies = self.base.clone();
        for (slot, place) in self.slots.iter().zip(&position.places) {
            if let Some(body) = bodies.body_mut(slot.body) {
                let sensor = &mut body.sensors[slot.index];
                sensor.position_in_body = place.sensor.position_in_body;
                sensor.orientation = place.sensor.orientation;
            }
        }
        bodies.with_crf_moved(&match (&self.footing, &position.foot_pose) {
            (Some(footing), Some(foot_pose)) => footing.crf_moved(foot_pose),
            _ => small_pose(&position.crf_pose),
        });
        bodies.with_generator_moved(&small_pose(&position.generator));
        bodies
    }

    /// Numbers that move a position, sensor by sensor, then the poses.
    pub fn dimensions(&self, position: &Position) -> usize {
        let footing = self.footing.as_ref().map_or(0, |_| Footing::DIMENSIONS);
        self.slot_dimensions(position).sum::<usize>() + self.pose_bounds().count() * 6 + footing
    }

    /// Numbers that move each slot.
    pub fn slot_dimensions(&self, position: &Position) -> impl Iterator<Item = usize> {
        let each = self.slots.iter().zip(&position.places);
        each.map(|(slot, place)| self.places(slot.body).map_or(0, |p| p.dimensions(place)))
    }

    fn pose_bounds(&self) -> impl Iterator<Item = PoseBounds> {
        self.generator.into_iter().chain(self.crf_pose)
    }

    /// The position after ways in mm, allowed or not; free poses are kept within their bounds.
    pub fn moved(&self, position: &Position, way_mm: &[f64]) -> Position {
        let mut rest = way_mm;
        let mut out = position.clone();
        for (slot, place) in self.slots.iter().zip(&mut out.places) {
            let Some(places) = self.places(slot.body) else { continue };
            let (own, others) = rest.split_at(places.dimensions(place));
            rest = others;
            *place = places.moved(place, own);
        }
        let moved = [(self.generator, &mut out.generator), (self.crf_pose, &mut out.crf_pose)];
        for (bounds, pose) in moved {
            let Some(bounds) = bounds else { continue };
            let (own, others) = rest.split_at(6);
            rest = others;
            for (k, way_mm) in own.iter().enumerate() {
                let (most, scale) = match k {
                    0..3 => (bounds.shift_mm[k], 1.0),
                    _ => (bounds.turn_deg, TURN_DEG_PER_MM),
                };
                pose[k] = (pose[k] + way_mm * scale).clamp(-most, most);
            }
        }
        if let (Some(footing), Some(foot_pose)) = (&self.footing, &mut out.foot_pose) {
            let way_mm = Vector3::from_column_slice(&rest[..3]);
            *foot_pose = footing.moved(foot_pose, &way_mm, rest[3] * TURN_DEG_PER_MM);
        }
        out
    }
}

/// The middle of the CRF's body; of its sensors where it has no mesh.
fn middle_of_crf(problem: &Problem) -> Point3<f64> {
    let vertices = problem.crf.iter().flat_map(|crf: &MountedBody| crf.vertices.iter());
    if let Some(bounds) = Bounds::around(vertices.map(|vertex| vertex.position_mm)) {
        return bounds.center_mm();
    }
    let crf = problem.scenarios.iter().find_map(|scenario| scenario.crf.as_ref());
    let sensors = crf.map_or(&[][..], |crf| &crf.body.sensors);
    let sum: Vector3<f64> = sensors.iter().map(|sensor| sensor.position_in_body.coords).sum();
    Point3::from(sum / sensors.len().max(1) as f64)
}

/// A pose of three shifts in mm and a rotation vector in degrees.
fn small_pose(numbers: &Vector6) -> Pose {
    let [x, y, z, rx, ry, rz] = *numbers;
    let turn = Vector3::new(rx, ry, rz).map(f64::to_radians);
    Pose::from_parts(Translation3::new(x, y, z), exp_vector(&turn))
}
