//! A sensor of the tool: what all its places share is computed once.

use super::Found;
use crate::frame_fit::{FrameFitter, Reading};
use crate::pose_rule::PoseRule;
use crate::scenario::Scenario;
use crate::tool_in_crf::relative_error;
use crate::tracker::{BodyTracker, TrackBuffers};
use crate::work::Work;
use crate::{RigidBody, Sensor};
use nalgebra::Point3;
use rayon::prelude::*;
use trackwright_field::OutsidePolicy;
use trackwright_geometry::pose::Pose;
use trackwright_task::{CancelToken, Cancelled};

/// The readings that stay as they are while one sensor of the tool is moved, at the poses of a
/// rule.
pub(super) struct ToolAt<'a> {
    scenario: &'a Scenario,
    sensor: usize,
    rule: &'a PoseRule,
    tracker_from_tool: Vec<Pose>,
    /// Pose by pose, all sensors of the tool; the moved one's slot is written over.
    readings: Vec<Reading>,
    /// Whether all but the moved sensor, the CRF's too, are in the model's box, pose by pose.
    are_inside: Vec<bool>,
    /// `crf_from_tracker` as the tracker sees it.
    crf_from_tracker_fitted: Pose,
    tip_in_tool: Point3<f64>,
    work: Work,
}

/// What a place is computed in.
#[derive(Default)]
pub(super) struct ToolBuffers {
    track: TrackBuffers,
    moved: Vec<(Reading, bool)>,
    readings: Vec<Reading>,
}

impl ToolBuffers {
    pub fn take_work(&mut self) -> Work {
        std::mem::take(&mut self.track.work)
    }
}

impl<'a> ToolAt<'a> {
    pub fn new(
        scenario: &'a Scenario,
        sensor: usize,
        rule: &'a PoseRule,
        cancel: &CancelToken,
    ) -> Result<Self, Cancelled> {
        let mut buffers = TrackBuffers::default();
        let crf = scenario.crf.as_ref().map(|crf| {
            let tracker = BodyTracker::new(&crf.body, scenario);
            let tracked = tracker.track(&mut buffers, &crf.tracker_from_crf);
            (crf.tracker_from_crf, tracked)
        });
        let mut work = buffers.work;
        work.crf_evaluations = work.study_evaluations;
        work.crf_trackings = u64::from(crf.is_some());
        let tracker_from_crf = crf.as_ref().map_or_else(Pose::identity, |c| c.0);
        let poses = rule.poses.iter().map(|pose| tracker_from_crf * pose);
        let tracker_from_tool: Vec<Pose> = poses.collect();
        let others = without(&scenario.tool, sensor);
        let fitter = FrameFitter::new(&others, scenario.orientation_weight_mm);
        let tracker = BodyTracker::of_sensors(
            fitter,
            &others.sensors,
            &scenario.environment,
            scenario.outside,
        );
        let parts: Result<Vec<_>, Cancelled> = rule
            .pieces()
            .into_par_iter()
            .map_init(TrackBuffers::default, |buffers, piece| {
                if cancel.is_cancelled() {
                    return Err(Cancelled);
                }
                let poses = &tracker_from_tool[piece.clone()];
                let mut read = Vec::with_capacity(poses.len() * others.sensors.len());
                tracker.read_all(buffers, poses, rule.run.min(poses.len()), &mut read);
                Ok((piece, read, std::mem::take(&mut buffers.work)))
            })
            .collect();
        let (sensors, count) = (scenario.tool.sensors.len(), tracker_from_tool.len());
        let crf_is_inside = crf.as_ref().is_none_or(|(_, tracked)| tracked.outside == 0);
        let nothing = Reading {
            position_mm: Point3::origin(),
            rotation: nalgebra::UnitQuaternion::identity(),
        };
        let mut readings = vec![nothing; count * sensors];
        let mut are_inside = vec![crf_is_inside; count];
        for (piece, read, cost) in parts? {
            work += cost;
            for (index, (reading, is_inside)) in read.into_iter().enumerate() {
                let (other, pose) = (index / piece.len(), piece.start + index % piece.len());
                let slot = other + usize::from(other >= sensor);
                readings[pose * sensors + slot] = reading;
                are_inside[pose] &= is_inside;
            }
        }
        Ok(Self {
            scenario,
            sensor,
            rule,
            tracker_from_tool,
            readings,
            are_inside,
            crf_from_tracker_fitted: crf.map_or_else(Pose::identity, |(_, tracked)| {
                tracked.fit.tracker_from_body.inverse()
            }),
            tip_in_tool: scenario.tool.judged_tip_in_body(),
            work,
        })
    }

    /// What making this cost.
    pub fn own_work(&self) -> Work {
        self.work
    }

    pub fn poses(&self) -> usize {
        self.rule.poses.len()
    }

    /// Where the tool is, pose by pose.
    pub fn tracker_from_tool(&self) -> &[Pose] {
        &self.tracker_from_tool
    }

    /// The study's tip RMS over the rule's poses with the sensor like this.
    pub fn found(
        &self,
        buffers: &mut ToolBuffers,
        moved: &Sensor,
        cancel: &CancelToken,
    ) -> Result<Found, Cancelled> {
        let mut body = without(&self.scenario.tool, usize::MAX);
        body.sensors[self.sensor] = moved.clone();
        let fitter = FrameFitter::new(&body, self.scenario.orientation_weight_mm);
        let alone = std::slice::from_ref(moved);
        let tracker = BodyTracker::of_sensors(
            fitter.clone(),
            alone,
            &self.scenario.environment,
            self.scenario.outside,
        );
        let sensors = body.sensors.len();
        let (mut squares_mm2, mut fourths_mm4, mut weights) = (0.0, 0.0, 0.0);
        let mut is_outside = false;
        for piece in self.rule.pieces() {
            if cancel.is_cancelled() {
                return Err(Cancelled);
            }
            buffers.moved.clear();
            let poses = &self.tracker_from_tool[piece.clone()];
            let run = self.rule.run.min(poses.len());
            tracker.read_all(&mut buffers.track, poses, run, &mut buffers.moved);
            for (place, (tracker_from_tool, (reading, is_inside))) in
                poses.iter().zip(&buffers.moved).enumerate()
            {
                let pose = piece.start + place;
                is_outside |= !is_inside;
                let is_rejected = self.scenario.outside == OutsidePolicy::Reject
                    && !(*is_inside && self.are_inside[pose]);
                if is_rejected {
                    continue;
                }
                buffers.readings.clear();
                let all = &self.readings[pose * sensors..(pose + 1) * sensors];
                buffers.readings.extend_from_slice(all);
                buffers.readings[self.sensor] = *reading;
                let fit = fitter.fit(&buffers.readings, tracker_from_tool);
                let simulated = self.crf_from_tracker_fitted * fit.tracker_from_body;
                let error = relative_error(&self.rule.poses[pose], &simulated, &self.tip_in_tool);
                let weight = self.rule.weights[pose];
                let square_mm2 = error.tip_error_in_crf_mm.norm_squared();
                squares_mm2 += weight * square_mm2;
                fourths_mm4 += weight * square_mm2 * square_mm2;
                weights += weight;
                buffers.track.work.frame_fits += 1;
                buffers.track.work.reading_reuses += sensors as u64 - 1;
            }
        }
        let rms_mm = (squares_mm2 / weights).sqrt();
        let spread = fourths_mm4 * weights / (squares_mm2 * squares_mm2) - 1.0;
        Ok(Found {
            tip_rms_mm: (weights > 0.0 && rms_mm.is_finite()).then_some(rms_mm),
            is_outside,
            variation: spread.max(0.0).sqrt(),
        })
    }
}

/// The body without a sensor, and without names.
pub(super) fn without(body: &RigidBody, sensor: usize) -> RigidBody {
    let others = body.sensors.iter().enumerate();
    RigidBody {
        name: String::new(),
        tip_in_body: body.tip_in_body,
        sensors: others
            .filter(|(i, _)| *i != sensor)
            .map(|(_, s)| Sensor { name: String::new(), ..s.clone() })
            .collect(),
    }
}
