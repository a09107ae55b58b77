//! Where a tracked body is, from where the tracker reports it: the room errs at its sensors, not at
//! the frame that the tracker reports, which may be a tip a hand's breadth away from them.

use super::tracker::{BodyTracker, TrackBuffers};
use crate::body::RigidBody;
use crate::frame_fit::{FrameFitter, Reading};
use nalgebra::{Point3, UnitQuaternion, Vector3};
use trackwright_field::compensation::{Compensated, Compensator, Method};
use trackwright_field::inverse::{Ambiguity, InverseState};
use trackwright_field::{Environment, OutsidePolicy};
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_task::Task;

/// Steps after which a pose is given up: where errors change by a tenth from a place to the one
/// that is measured for it, nine reach the tolerance.
const MAX_STEPS: usize = 64;

/// Far below what single precision, in which poses travel, resolves at half a metre (6e-5 mm).
const TOLERANCE_MM: f64 = 1e-7;
const TOLERANCE_RAD: f64 = 1e-10;

/// Poses further apart than a thousand times the tolerance are two.
const SAME_MM: f64 = 1e-4;
const SAME_RAD: f64 = 1e-7;

/// One body made ready to be compensated often.
pub struct BodyCompensator<'a> {
    tracker: BodyTracker<'a>,
    fitter: FrameFitter,
    body: RigidBody,
    method: Method,
}

impl<'a> BodyCompensator<'a> {
    /// Of a body that the tracker fits to what its sensors read, with a weight of orientations
    /// against positions in mm per radian (13).
    pub fn new(
        body: RigidBody,
        orientation_weight_mm: f64,
        environment: &'a Environment,
        outside: OutsidePolicy,
        method: Method,
    ) -> Self {
        let fitter = FrameFitter::new(&body, orientation_weight_mm);
        Self {
            tracker: BodyTracker::of_sensors(fitter.clone(), &body.sensors, environment, outside),
            fitter,
            body,
            method,
        }
    }

    /// The true pose of the body whose measured pose this is; `sensors` corrects single sensors in
    /// the same room by the same method.
    ///
    /// With a distortion map it is the pose at which the sensors' distorted readings are fitted by
    /// the measured one. What those sensors read is then corrected one by one, and what speaks
    /// against any of them (outside the box, a fold, a second answer) speaks against the body. With
    /// a correction map, and with the paper's shortcut, the sensors are taken to have read where
    /// the measured pose has them, which leaves out how the field deforms the body; each is
    /// corrected, and the body fitted to them.
    pub fn compensate(
        &self,
        tracker_from_body_measured: &Pose,
        sensors: &Compensator<'_>,
    ) -> Compensated {
        match self.method {
            Method::Inverse => self.invert(tracker_from_body_measured, sensors),
            Method::Correction | Method::Shortcut => {
                self.correct(tracker_from_body_measured, sensors)
            }
        }
    }

    /// The pose that is measured as this one in a distortion map, whether or not it is
    /// the only one; where the search does not come to rest (at a jump of area weights, where some
    /// readings have none), the last it came to.
    pub fn nearest(&self, tracker_from_body_measured: &Pose) -> Pose {
        let mut buffers = TrackBuffers::default();
        let measured = tracker_from_body_measured;
        self.pose_read_as(measured, *measured, &mut buffers).unwrap_or_else(|last| last)
    }

    fn invert(&self, measured: &Pose, sensors: &Compensator<'_>) -> Compensated {
        let mut buffers = TrackBuffers::default();
        let Ok(pose) = self.pose_read_as(measured, *measured, &mut buffers) else {
            let is_inside = self.tracker.track(&mut buffers, measured).outside == 0;
            return refused(InverseState::NotConverged, is_inside);
        };
        let (tracked, details) = self.tracker.track_in_detail(&mut buffers, &pose);
        let is_inside = tracked.outside == 0;
        // A marker's error is a mean that no inverse of the map is of.
        let with_axis = self.body.sensors.iter().zip(&details);
        let readings: Vec<Pose> = with_axis
            .filter(|(sensor, _)| sensor.axis_in_body().is_some())
            .map(|(_, detail)| detail.tracker_from_measured)
            .collect();
        if let Some(state) = against(sensors, &readings) {
            return refused(state, is_inside);
        }
        let others = self.other_poses(measured, &pose, &mut buffers);
        let Some(second) = others.first() else { return found(pose, is_inside) };
        let (distance_mm, angle_rad) = self.apart(second, &pose);
        let ambiguity = Ambiguity::SecondPreimage { distance_mm, angle_rad };
        let known = if others.len() <= 2 { &others[..] } else { &[] };
        Compensated {
            others: [0, 1].map(|k| known.get(k).copied()),
            state: InverseState::Ambiguous(ambiguity),
            ..found(pose, is_inside)
        }
    }

    /// The pose that is measured as this one, searched from `pose`; else the last it came to.
    fn pose_read_as(
        &self,
        measured: &Pose,
        mut pose: Pose,
        buffers: &mut TrackBuffers,
    ) -> Result<Pose, Pose> {
        let centre = self.fitter.centroid_in_body();
        for _ in 0..MAX_STEPS {
            let read = self.tracker.track(buffers, &pose).fit.tracker_from_body;
            let step_mm = measured * centre - read * centre;
            let step = measured.rotation * read.rotation.inverse();
            let is_there = step_mm.norm() < TOLERANCE_MM && step.angle() < TOLERANCE_RAD;
            let rotation = step * pose.rotation;
            let at_mm = (pose * centre) + step_mm;
            pose = pose_from_parts((at_mm - rotation * centre.coords).coords, rotation);
            if !pose.translation.vector.iter().all(|v| v.is_finite()) {
                break;
            }
            if is_there {
                return Ok(pose);
            }
        }
        Err(pose)
    }

    /// Where searches that begin on the other sides of the measured pose end elsewhere.
    fn other_poses(&self, measured: &Pose, pose: &Pose, buffers: &mut TrackBuffers) -> Vec<Pose> {
        let centre = self.fitter.centroid_in_body();
        let (correction_mm, correction_rad) = self.apart(measured, pose);
        let mut others: Vec<Pose> = Vec::new();
        for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
            for sign in [-2.0, 2.0] {
                let turn = UnitQuaternion::new(axis * (sign * correction_rad));
                let rotation = turn * measured.rotation;
                let at_mm = measured * centre + axis * (sign * correction_mm);
                let start = pose_from_parts((at_mm - rotation * centre.coords).coords, rotation);
                let Ok(found) = self.pose_read_as(measured, start, buffers) else {
                    continue;
                };
                let is_other = |known: &Pose| {
                    let (mm, rad) = self.apart(&found, known);
                    mm > SAME_MM || rad > SAME_RAD
                };
                if is_other(pose) && others.iter().all(is_other) {
                    others.push(found);
                }
            }
        }
        others
    }

    /// Distance of the sensors' middles, mm, and angle in radians.
    fn apart(&self, a: &Pose, b: &Pose) -> (f64, f64) {
        let centre = self.fitter.centroid_in_body();
        ((a * centre - b * centre).norm(), a.rotation.angle_to(&b.rotation))
    }

    fn correct(&self, measured: &Pose, sensors: &Compensator<'_>) -> Compensated {
        let readings: Vec<Pose> =
            (self.body.sensors.iter()).map(|sensor| measured * sensor.body_from_sensor()).collect();
        let Ok(corrected) = sensors.compensate(&readings, &Task::default()) else {
            return refused(InverseState::NotConverged, false);
        };
        let is_inside = corrected.iter().all(|found| found.is_inside);
        let mut of_sensors = Vec::with_capacity(corrected.len());
        for found in &corrected {
            let Some(pose) = found.pose.filter(|_| is_certain(found)) else {
                return refused(found.state, is_inside);
            };
            of_sensors.push(Reading {
                position_mm: Point3::from(pose.translation.vector),
                rotation: pose.rotation,
            });
        }
        found(self.fitter.fit(&of_sensors, measured).tracker_from_body, is_inside)
    }
}

/// What speaks against the first reading that something speaks against. A single sensor that reads
/// the same at a second pose does not: the others of the body would not.
fn against(sensors: &Compensator<'_>, readings: &[Pose]) -> Option<InverseState> {
    match sensors.compensate(readings, &Task::default()) {
        Ok(found) => (found.into_iter())
            .map(|found| found.state)
            .find(|state| !matches!(state, InverseState::Converged | InverseState::Ambiguous(_))),
        // Nobody has the means to cancel it.
        Err(_) => Some(InverseState::NotConverged),
    }
}

fn is_certain(found: &Compensated) -> bool {
    found.state == InverseState::Converged && found.pose.is_some()
}

fn found(pose: Pose, is_inside: bool) -> Compensated {
    Compensated { pose: Some(pose), others: [None; 2], state: InverseState::Converged, is_inside }
}

fn refused(state: InverseState, is_inside: bool) -> Compensated {
    Compensated { pose: None, others: [None; 2], state, is_inside }
}
