//! One trial: both bodies distorted, refitted, and compared in the CRF (paper, section 3).

use super::scenario::{Scenario, ScenarioCrf};
use super::work::Work;
use crate::field::samples::PoseError;
use crate::field::{Environment, OutsidePolicy};
use crate::geometry::pose::{Pose, pose_from_parts};
use crate::geometry::rotation::exp_vector;
use crate::tracking::frame_fit::{FrameFit, FrameFitter, Reading};
use crate::tracking::tool_in_crf::{FreeMotion, relative_error};
use crate::tracking::{Determination, RigidBody};
use nalgebra::{Point3, Unit, Vector3};

/// The figures of one trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial {
    pub crf_from_tool: Pose,
    /// What the tracker would report.
    pub crf_from_tool_simulated: Pose,
    pub tip_error_in_crf_mm: Vector3<f64>,
    pub tip_error_mm: f64,
    pub angle_error_deg: f64,
    /// Sensors of tool and CRF outside the model's box.
    pub outside: usize,
    /// Sensors of tool and CRF outside the tracker's measurement volume.
    pub out_of_volume: usize,
    /// The part of the tip error that a free rotation cannot change; `None` where none is free.
    pub determined_mm: Option<f64>,
}

/// One sensor at one pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorDetail {
    pub tracker_from_sensor: Pose,
    pub tracker_from_measured: Pose,
    pub error: PoseError,
    /// In the model's box.
    pub is_inside: bool,
    /// In the tracker's measurement volume, where that is known.
    pub is_in_volume: bool,
}

/// One body at one pose.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyDetail {
    pub tracker_from_body: Pose,
    pub tracker_from_body_fitted: Pose,
    pub sensors: Vec<SensorDetail>,
    pub determination: Determination,
}

/// The design's own pose in full, for a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseDetail {
    pub trial: Trial,
    pub tool: BodyDetail,
    pub crf: Option<BodyDetail>,
    pub work: Work,
}

/// The design's own pose in full.
pub fn look(scenario: &Scenario) -> PoseDetail {
    let simulator = Simulator::new(scenario);
    let crf = simulator.crf.as_ref().map(|t| {
        let mut sensors = Vec::new();
        let tracked = t.tracker.track(&t.tracker_from_crf, Some(&mut sensors));
        detail(&t.tracker_from_crf, &tracked, sensors)
    });
    let mut sensors = Vec::new();
    let tracker_from_tool = simulator.tracker_from_crf() * scenario.crf_from_tool;
    let tracked = simulator.tool.track(&tracker_from_tool, Some(&mut sensors));
    let trial = simulator.compare(&scenario.crf_from_tool, &tracked, simulator.crf.as_ref());
    let tool = detail(&tracker_from_tool, &tracked, sensors);
    let readings = tool.sensors.len() + crf.as_ref().map_or(0, |c| c.sensors.len());
    PoseDetail {
        trial,
        work: Work {
            pose_evaluations: readings as u64,
            frame_fits: 1 + u64::from(crf.is_some()),
            ..Work::default()
        },
        tool,
        crf,
    }
}

fn detail(pose: &Pose, tracked: &Tracked, sensors: Vec<SensorDetail>) -> BodyDetail {
    BodyDetail {
        tracker_from_body: *pose,
        tracker_from_body_fitted: tracked.fit.tracker_from_body,
        sensors,
        determination: tracked.fit.determination,
    }
}

/// Tracks one body in one room.
struct BodyTracker<'a> {
    body: &'a RigidBody,
    environment: &'a Environment,
    outside: OutsidePolicy,
    fitter: FrameFitter,
    /// `body_from_sensor` and axis of each sensor, made once for all trials.
    sensors: Vec<(Pose, Unit<Vector3<f64>>)>,
}

/// A body as the tracker sees it.
#[derive(Clone, Copy)]
struct Tracked {
    fit: FrameFit,
    outside: usize,
    out_of_volume: usize,
}

impl<'a> BodyTracker<'a> {
    fn new(body: &'a RigidBody, scenario: &'a Scenario) -> Self {
        Self {
            body,
            environment: &scenario.environment,
            outside: scenario.outside,
            fitter: FrameFitter::new(body, scenario.orientation_weight_mm),
            sensors: body
                .sensors
                .iter()
                .map(|s| (s.body_from_sensor(), s.axis_in_body()))
                .collect(),
        }
    }

    fn free_motion(&self, determination: &Determination) -> Option<FreeMotion> {
        FreeMotion::in_body(determination, self.fitter.centroid_in_body())
    }

    /// Distorts every sensor (6), (7) and refits the frame (9)–(13).
    fn track(
        &self,
        tracker_from_body: &Pose,
        mut details: Option<&mut Vec<SensorDetail>>,
    ) -> Tracked {
        let mut readings = Vec::with_capacity(self.sensors.len());
        let (mut outside, mut out_of_volume) = (0, 0);
        for (body_from_sensor, axis_in_body) in &self.sensors {
            let tracker_from_sensor = tracker_from_body * body_from_sensor;
            let at = Point3::from(tracker_from_sensor.translation.vector);
            let rotation = tracker_from_sensor.rotation;
            let axis = tracker_from_body.rotation * axis_in_body;
            let evaluation = self.environment.model.evaluate(&at, &axis, self.outside);
            let error = evaluation.error;
            let is_in_volume = self.environment.volume.is_none_or(|v| v.contains(&at));
            outside += usize::from(!evaluation.is_inside);
            out_of_volume += usize::from(!is_in_volume);
            let reading = Reading {
                position_mm: at + error.position_mm,
                rotation: exp_vector(&error.rotation_rad) * rotation,
            };
            readings.push(reading);
            if let Some(details) = details.as_deref_mut() {
                details.push(SensorDetail {
                    tracker_from_sensor,
                    tracker_from_measured: pose_from_parts(
                        reading.position_mm.coords,
                        reading.rotation,
                    ),
                    error,
                    is_inside: evaluation.is_inside,
                    is_in_volume,
                });
            }
        }
        Tracked {
            fit: self.fitter.fit(&readings, tracker_from_body),
            outside,
            out_of_volume,
        }
    }
}

/// A CRF that has been tracked where it stands.
struct TrackedCrf<'a> {
    tracker: BodyTracker<'a>,
    tracker_from_crf: Pose,
    tracked: Tracked,
}

impl<'a> TrackedCrf<'a> {
    fn new(crf: &'a ScenarioCrf, scenario: &'a Scenario) -> Self {
        let tracker = BodyTracker::new(&crf.body, scenario);
        let tracked = tracker.track(&crf.tracker_from_crf, None);
        Self {
            tracker,
            tracker_from_crf: crf.tracker_from_crf,
            tracked,
        }
    }
}

/// A scenario made ready for many trials: the CRF is tracked once.
pub(super) struct Simulator<'a> {
    scenario: &'a Scenario,
    tool: BodyTracker<'a>,
    /// The tool where the design has it: what its sensors determine at all.
    tool_at_design: Tracked,
    crf: Option<TrackedCrf<'a>>,
    tip_in_tool: Point3<f64>,
}

impl<'a> Simulator<'a> {
    pub fn new(scenario: &'a Scenario) -> Self {
        let tool = BodyTracker::new(&scenario.tool, scenario);
        let crf = scenario.crf.as_ref().map(|c| TrackedCrf::new(c, scenario));
        let tracker_from_crf = crf
            .as_ref()
            .map_or_else(Pose::identity, |c| c.tracker_from_crf);
        Self {
            scenario,
            tool_at_design: tool.track(&(tracker_from_crf * scenario.crf_from_tool), None),
            tool,
            crf,
            tip_in_tool: scenario.tool.judged_tip_in_body(),
        }
    }

    /// Where the design has the tool.
    pub fn design_crf_from_tool(&self) -> Pose {
        self.scenario.crf_from_tool
    }

    /// Evaluations and fits that making the simulator cost.
    pub fn own_work(&self) -> Work {
        self.trial_work(true)
    }

    /// Evaluations and fits of one trial.
    pub fn trial_work(&self, moves_crf: bool) -> Work {
        let crf = self.crf.as_ref().filter(|_| moves_crf);
        body_work(self.tool.body) + crf.map_or_else(Work::default, |c| body_work(c.tracker.body))
    }

    /// What the sensors leave free, tool before CRF, in that body's frame. It hangs on the bodies
    /// alone, so the design's pose answers for all trials.
    pub fn free_motion(&self) -> Option<(&'static str, FreeMotion)> {
        let tool = self
            .tool
            .free_motion(&self.tool_at_design.fit.determination);
        let crf = self
            .crf
            .as_ref()
            .and_then(|c| c.tracker.free_motion(&c.tracked.fit.determination));
        tool.map(|free| ("tool", free))
            .or(crf.map(|free| ("crf", free)))
    }

    /// Whether a body's rotation is so weakly determined that noise decides it.
    pub fn is_poorly_determined(&self) -> bool {
        [
            Some(&self.tool_at_design),
            self.crf.as_ref().map(|c| &c.tracked),
        ]
        .into_iter()
        .flatten()
        .any(|t| matches!(t.fit.determination, Determination::Poor { .. }))
    }

    /// The tool at a pose in the CRF, which stands where the scenario has it.
    pub fn trial(&self, crf_from_tool: &Pose) -> Trial {
        let tracked = self
            .tool
            .track(&(self.tracker_from_crf() * crf_from_tool), None);
        self.compare(crf_from_tool, &tracked, self.crf.as_ref())
    }

    /// The tool at a pose in a CRF that stands somewhere else.
    pub fn trial_with_crf_at(&self, tracker_from_crf: &Pose, crf_from_tool: &Pose) -> Trial {
        let Some(crf) = &self.crf else {
            return self.trial(crf_from_tool);
        };
        let moved = crf.tracker.track(tracker_from_crf, None);
        let tracked = self.tool.track(&(tracker_from_crf * crf_from_tool), None);
        self.compare_with(crf_from_tool, &tracked, Some(&moved))
    }

    fn tracker_from_crf(&self) -> Pose {
        self.crf
            .as_ref()
            .map_or_else(Pose::identity, |c| c.tracker_from_crf)
    }

    fn compare(&self, crf_from_tool: &Pose, tool: &Tracked, crf: Option<&TrackedCrf>) -> Trial {
        self.compare_with(crf_from_tool, tool, crf.map(|c| &c.tracked))
    }

    /// `F̂ = F̂_CRF⁻¹ F̂_Tool` (14) against `F`.
    fn compare_with(&self, crf_from_tool: &Pose, tool: &Tracked, crf: Option<&Tracked>) -> Trial {
        let tracker_from_crf = crf.map_or_else(Pose::identity, |c| c.fit.tracker_from_body);
        let simulated = tracker_from_crf.inverse() * tool.fit.tracker_from_body;
        let error = relative_error(crf_from_tool, &simulated, &self.tip_in_tool);
        let free = self
            .tool
            .free_motion(&tool.fit.determination)
            .map(|free| free.transformed_by(&simulated))
            .or_else(|| {
                let own = self.crf.as_ref()?;
                own.tracker.free_motion(&crf?.fit.determination)
            });
        Trial {
            crf_from_tool: *crf_from_tool,
            crf_from_tool_simulated: simulated,
            tip_error_in_crf_mm: error.tip_error_in_crf_mm,
            tip_error_mm: error.tip_error_in_crf_mm.norm(),
            angle_error_deg: error.angle_rad.to_degrees(),
            outside: tool.outside + crf.map_or(0, |c| c.outside),
            out_of_volume: tool.out_of_volume + crf.map_or(0, |c| c.out_of_volume),
            determined_mm: free.map(|free| {
                free.determined_error_mm(
                    &(crf_from_tool * self.tip_in_tool),
                    &(simulated * self.tip_in_tool),
                )
            }),
        }
    }
}

fn body_work(body: &RigidBody) -> Work {
    Work {
        study_evaluations: body.sensors.len() as u64,
        frame_fits: 1,
        ..Work::default()
    }
}
