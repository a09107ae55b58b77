//! A sensor of the tool: what all its places share is computed once.

use super::outcome::Found;
use crate::body::{RigidBody, Sensor};
use crate::frame_fit::FrameFitter;
use crate::pose_rule::PoseRule;
use crate::refit::{BodyReadings, RefitBuffers};
use crate::scenario::Scenario;
use crate::tool_in_crf::relative_error;
use crate::tracker::{BodyTracker, TrackBuffers};
use crate::work::Work;
use nalgebra::Point3;
use trackwright_field::OutsidePolicy;
use trackwright_geometry::pose::Pose;
use trackwright_task::{CancelToken, Cancelled};

/// The readings that stay as they are while one sensor of the tool is moved, at the poses of a
/// rule.
pub(super) struct ToolAt<'a> {
    scenario: &'a Scenario,
    sensor: usize,
    rule: &'a PoseRule,
    readings: BodyReadings<'a>,
    crf_is_inside: bool,
    /// `crf_from_tracker` as the tracker sees it.
    crf_from_tracker_fitted: Pose,
    tip_in_tool: Point3<f64>,
    work: Work,
}

impl<'a> ToolAt<'a> {
    /// Reads the tool's other sensors at the poses of a rule, and tracks the CRF.
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
        let tracker_from_tool = rule.poses.iter().map(|pose| tracker_from_crf * pose).collect();
        let poses = (tracker_from_tool, rule.run);
        let (readings, cost) = BodyReadings::read(
            scenario,
            &scenario.tool,
            Some(sensor),
            poses,
            rule.pieces(),
            cancel,
        )?;
        Ok(Self {
            scenario,
            sensor,
            rule,
            readings,
            crf_is_inside: crf.as_ref().is_none_or(|(_, tracked)| tracked.outside == 0),
            crf_from_tracker_fitted: crf.map_or_else(Pose::identity, |(_, tracked)| {
                tracked.fit.tracker_from_body.inverse()
            }),
            tip_in_tool: scenario.tool.judged_tip_in_body(),
            work: work + cost,
        })
    }

    /// What making this cost.
    pub fn own_work(&self) -> Work {
        self.work
    }

    /// Number of poses.
    pub fn poses(&self) -> usize {
        self.rule.poses.len()
    }

    /// Where the tool is, pose by pose.
    pub fn tracker_from_tool(&self) -> &[Pose] {
        self.readings.tracker_from_body()
    }

    /// The study's tip RMS over the rule's poses with the sensor like this.
    pub fn found(
        &self,
        buffers: &mut RefitBuffers,
        moved: &Sensor,
        cancel: &CancelToken,
    ) -> Result<Found, Cancelled> {
        let mut body = nameless(&self.scenario.tool);
        body.sensors[self.sensor] = moved.clone();
        let fitter = FrameFitter::new(&body, self.scenario.orientation_weight_mm);
        let number = [self.sensor];
        let replaced = self.readings.replaced(&body, &fitter, &number, std::slice::from_ref(moved));
        let (mut squares_mm2, mut fourths_mm4, mut weights) = (0.0, 0.0, 0.0);
        let mut is_outside = false;
        let rejects = self.scenario.outside == OutsidePolicy::Reject;
        self.readings.refit(
            &replaced,
            self.rule.pieces().into_iter(),
            buffers,
            cancel,
            |pose, is_inside| {
                is_outside |= !is_inside;
                let others = || self.crf_is_inside && self.readings.are_inside(pose, None);
                !rejects || (is_inside && others())
            },
            |pose, tracker_from_tool| {
                let simulated = self.crf_from_tracker_fitted * tracker_from_tool;
                let error = relative_error(&self.rule.poses[pose], &simulated, &self.tip_in_tool);
                let weight = self.rule.weights[pose];
                let square_mm2 = error.tip_error_in_crf_mm.norm_squared();
                squares_mm2 += weight * square_mm2;
                fourths_mm4 += weight * square_mm2 * square_mm2;
                weights += weight;
            },
        )?;
        let rms_mm = (squares_mm2 / weights).sqrt();
        let spread = fourths_mm4 * weights / (squares_mm2 * squares_mm2) - 1.0;
        Ok(Found {
            tip_rms_mm: (weights > 0.0 && rms_mm.is_finite()).then_some(rms_mm),
            is_outside,
            variation: spread.max(0.0).sqrt(),
        })
    }
}

/// The body without names, which cost time to copy.
pub(super) fn nameless(body: &RigidBody) -> RigidBody {
    let sensors = body.sensors.iter();
    RigidBody {
        name: String::new(),
        tip_in_body: body.tip_in_body,
        sensors: sensors.map(|s| Sensor { name: String::new(), ..s.clone() }).collect(),
    }
}
