//! One trial: both bodies distorted, refitted, and compared in the CRF (paper, section 3).

use super::scenario::{InputTrial, Scenario, ScenarioCrf};
use super::tracker::{BodyTracker, SensorDetail, TrackBuffers, Tracked};
use super::weak_rotation::WeakRotation;
use super::work::Work;
use crate::figures::{FreeAxis, FreeRotation};
use crate::frame_fit::Determination;
use crate::tool_in_crf::{FreeMotion, relative_error};
use nalgebra::{Point3, UnitQuaternion, Vector3};
use trackwright_field::Environment;
use trackwright_geometry::pose::{Pose, pose_from_parts};

/// The figures of one trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial {
    pub crf_from_tool: Pose,
    /// What the tracker would report.
    pub crf_from_tool_simulated: Pose,
    pub tip_error_in_crf_mm: Vector3<f64>,
    pub tip_error_mm: f64,
    pub angle_error_deg: f64,
    /// Sensors of tool and CRF outside the model's box, or in metal.
    pub outside: usize,
    /// Those of them that are in metal, or so close to it that its signals determine no pose.
    pub in_metal: usize,
    /// Sensors of tool and CRF outside the tracker's measurement volume.
    pub out_of_volume: usize,
    /// The part of the tip error that a free rotation cannot change; `None` where none is free.
    pub determined_mm: Option<f64>,
    /// How far the tip is from the axes of the rotations that are free, tool's and CRF's together.
    pub free_reach_mm: f64,
}

impl Trial {
    /// Whether a room states its field at all sensors.
    pub fn has_field(&self, environment: &Environment) -> bool {
        self.in_metal == 0 && environment.states_field(self.outside > 0, self.out_of_volume > 0)
    }
}

/// One body at one pose.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyDetail {
    pub tracker_from_body: Pose,
    pub tracker_from_body_fitted: Pose,
    pub sensors: Vec<SensorDetail>,
    pub determination: Determination,
    /// Where a rotation is not determined at all.
    pub free_rotation: Option<FreeRotation>,
    /// Where its rotation is barely determined.
    pub weak_rotation: Option<WeakRotation>,
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
pub fn simulate_pose(scenario: &Scenario) -> PoseDetail {
    let mut buffers = TrackBuffers::default();
    let tracker_from_crf = scenario.tracker_from_crf();
    let crf = scenario.crf.as_ref().map(|crf| {
        let tracker = BodyTracker::new(&crf.body, scenario);
        let (tracked, sensors) = tracker.track_in_detail(&mut buffers, &tracker_from_crf);
        (tracker, tracked, sensors)
    });
    let crf_evaluations = buffers.work.study_evaluations;
    let tracker = BodyTracker::new(&scenario.tool, scenario);
    let tracker_from_tool = tracker_from_crf * scenario.crf_from_tool;
    let (tracked, sensors) = tracker.track_in_detail(&mut buffers, &tracker_from_tool);
    let trial = compare(
        &scenario.crf_from_tool,
        &scenario.tool.judged_tip_in_body(),
        (&tracker, &tracked),
        crf.as_ref().map(|(tracker, tracked, _)| (tracker, tracked)),
    );
    let weight_mm = scenario.orientation_weight_mm;
    let tip = tracker_from_tool * scenario.tool.judged_tip_in_body();
    let free = |key, tracker: &BodyTracker, tracked: &Tracked, tracker_from_body: &Pose| {
        let motion = tracker.free_motion(&tracked.fit.determination)?;
        Some(FreeRotation {
            free: FreeAxis::of(key, motion.axis, scenario),
            reach_mm: motion.transformed_by(tracker_from_body).reach_mm(&tip),
        })
    };
    PoseDetail {
        trial,
        work: Work {
            pose_evaluations: buffers.work.study_evaluations,
            study_evaluations: 0,
            crf_evaluations,
            crf_trackings: u64::from(crf.is_some()),
            ..buffers.work
        },
        tool: BodyDetail {
            weak_rotation: WeakRotation::of_body("tool", &scenario.tool, weight_mm),
            free_rotation: free("tool", &tracker, &tracked, &tracker_from_tool),
            ..detail(&tracker_from_tool, &tracked, sensors)
        },
        crf: crf.zip(scenario.crf.as_ref()).map(|((tracker, tracked, sensors), crf)| BodyDetail {
            weak_rotation: WeakRotation::of_body("crf", &crf.body, weight_mm),
            free_rotation: free("crf", &tracker, &tracked, &tracker_from_crf),
            ..detail(&tracker_from_crf, &tracked, sensors)
        }),
    }
}

fn detail(pose: &Pose, tracked: &Tracked, sensors: Vec<SensorDetail>) -> BodyDetail {
    BodyDetail {
        tracker_from_body: *pose,
        tracker_from_body_fitted: tracked.fit.tracker_from_body,
        sensors,
        determination: tracked.fit.determination,
        free_rotation: None,
        weak_rotation: None,
    }
}

/// A CRF that has been tracked where it stands.
struct TrackedCrf<'a> {
    tracker: BodyTracker<'a>,
    tracker_from_crf: Pose,
    tracked: Tracked,
}

/// A scenario made ready for many trials: the CRF is tracked once.
pub struct Simulator<'a> {
    scenario: &'a Scenario,
    tool: BodyTracker<'a>,
    /// The tool where the design has it: what its sensors determine at all.
    tool_at_design: Tracked,
    crf: Option<TrackedCrf<'a>>,
    tip_in_tool: Point3<f64>,
    own_work: Work,
}

/// What trials are computed in, used again for the next ones, and what they have cost.
#[derive(Default)]
pub struct TrialBuffers {
    track: TrackBuffers,
    poses: Vec<Pose>,
    tool: Vec<Tracked>,
    crf: Vec<Tracked>,
    /// Of each trial, which of `crf` is its own; `None` for the CRF where it stands.
    crf_of_trial: Vec<Option<usize>>,
}

impl TrialBuffers {
    /// The work done since the last call.
    pub fn take_work(&mut self) -> Work {
        std::mem::take(&mut self.track.work)
    }
}

impl<'a> Simulator<'a> {
    pub fn new(scenario: &'a Scenario) -> Self {
        let mut buffers = TrackBuffers::default();
        let crf = scenario.crf.as_ref().map(|ScenarioCrf { body, tracker_from_crf }| {
            let tracker = BodyTracker::new(body, scenario);
            TrackedCrf {
                tracked: tracker.track(&mut buffers, tracker_from_crf),
                tracker,
                tracker_from_crf: *tracker_from_crf,
            }
        });
        buffers.work.crf_evaluations = buffers.work.study_evaluations;
        buffers.work.crf_trackings = u64::from(crf.is_some());
        let tracker_from_crf = crf.as_ref().map_or_else(Pose::identity, |c| c.tracker_from_crf);
        let tool = BodyTracker::new(&scenario.tool, scenario);
        let tracker_from_tool = tracker_from_crf * scenario.crf_from_tool;
        Self {
            scenario,
            tool_at_design: tool.track(&mut buffers, &tracker_from_tool),
            tool,
            crf,
            tip_in_tool: scenario.tool.judged_tip_in_body(),
            own_work: buffers.work,
        }
    }

    /// Where the design has the tool.
    pub fn design_crf_from_tool(&self) -> Pose {
        self.scenario.crf_from_tool
    }

    /// The tool turned like this, its tip at a point of the tracker frame.
    pub fn crf_from_tool_with_tip_at(
        &self,
        tip_in_tracker: &Point3<f64>,
        rotation: &UnitQuaternion<f64>,
    ) -> Pose {
        let tip_in_crf = self.tracker_from_crf().inverse_transform_point(tip_in_tracker);
        let arm = rotation * self.tip_in_tool.coords;
        pose_from_parts(tip_in_crf.coords - arm, *rotation)
    }

    /// What making the simulator cost.
    pub fn own_work(&self) -> Work {
        self.own_work
    }

    /// What the sensors leave free, tool before CRF, in that body's frame. It depends on the bodies
    /// alone, so the design's pose answers for all trials.
    pub fn free_motion(&self) -> Option<(&'static str, FreeMotion)> {
        let tool = self.tool.free_motion(&self.tool_at_design.fit.determination);
        let crf =
            self.crf.as_ref().and_then(|c| c.tracker.free_motion(&c.tracked.fit.determination));
        tool.map(|free| ("tool", free)).or(crf.map(|free| ("crf", free)))
    }

    /// Whether a body's rotation is so weakly determined that noise decides it.
    pub fn is_poorly_determined(&self) -> bool {
        [Some(&self.tool_at_design), self.crf.as_ref().map(|c| &c.tracked)]
            .into_iter()
            .flatten()
            .any(|t| matches!(t.fit.determination, Determination::Poor { .. }))
    }

    /// The tool at poses in the CRF, which stands where the scenario has it. Where poses come in
    /// runs of one orientation, `run` is their length.
    pub fn trials(
        &self,
        buffers: &mut TrialBuffers,
        crf_from_tool: &[Pose],
        run: usize,
    ) -> Vec<Trial> {
        let tracker_from_crf = self.tracker_from_crf();
        buffers.poses.clear();
        buffers.poses.extend(crf_from_tool.iter().map(|pose| tracker_from_crf * pose));
        buffers.tool.clear();
        let TrialBuffers { track, poses, tool, .. } = buffers;
        self.tool.track_all(track, poses, run, tool);
        if self.crf.is_some() {
            track.work.crf_reuses += crf_from_tool.len() as u64;
        }
        let crf = self.crf.as_ref().map(|c| (&c.tracker, &c.tracked));
        crf_from_tool
            .iter()
            .zip(&buffers.tool)
            .map(|(pose, tracked)| self.compare(pose, tracked, crf))
            .collect()
    }

    /// The tool at given poses in a CRF that may stand somewhere else each time. A CRF that stands
    /// where it stood before is not tracked again.
    pub fn given_trials(&self, buffers: &mut TrialBuffers, given: &[InputTrial]) -> Vec<Trial> {
        let Some(crf) = &self.crf else {
            let poses: Vec<_> = given.iter().map(|t| t.crf_from_tool).collect();
            return self.trials(buffers, &poses, 1);
        };
        let TrialBuffers { track, poses, tool, crf: moved, crf_of_trial } = buffers;
        poses.clear();
        crf_of_trial.clear();
        for t in given {
            let place = match t.tracker_from_crf {
                Some(pose) if pose != crf.tracker_from_crf => {
                    if poses.last() != Some(&pose) {
                        poses.push(pose);
                    }
                    Some(poses.len() - 1)
                }
                _ => None,
            };
            crf_of_trial.push(place);
        }
        moved.clear();
        let before = track.work.study_evaluations;
        crf.tracker.track_all(track, poses, 1, moved);
        track.work.crf_evaluations += track.work.study_evaluations - before;
        track.work.crf_trackings += poses.len() as u64;
        track.work.crf_reuses += (given.len() - poses.len()) as u64;
        poses.clear();
        poses.extend(
            given
                .iter()
                .map(|t| t.tracker_from_crf.unwrap_or(crf.tracker_from_crf) * t.crf_from_tool),
        );
        tool.clear();
        self.tool.track_all(track, poses, 1, tool);
        let trials = given.iter().zip(tool).zip(crf_of_trial);
        trials
            .map(|((given, tool), place)| {
                let tracked = place.map_or(&crf.tracked, |place| &moved[place]);
                self.compare(&given.crf_from_tool, tool, Some((&crf.tracker, tracked)))
            })
            .collect()
    }

    /// The tool's tracker and the CRF's.
    pub fn trackers(&self) -> (&BodyTracker<'a>, Option<&BodyTracker<'a>>) {
        (&self.tool, self.crf.as_ref().map(|crf| &crf.tracker))
    }

    /// The point whose error is judged.
    pub fn tip_in_tool(&self) -> &Point3<f64> {
        &self.tip_in_tool
    }

    /// Where the CRF stands; the tracker's own frame without one.
    pub fn tracker_from_crf(&self) -> Pose {
        self.crf.as_ref().map_or_else(Pose::identity, |c| c.tracker_from_crf)
    }

    fn compare(
        &self,
        crf_from_tool: &Pose,
        tool: &Tracked,
        crf: Option<(&BodyTracker, &Tracked)>,
    ) -> Trial {
        compare(crf_from_tool, &self.tip_in_tool, (&self.tool, tool), crf)
    }
}

/// `F̂ = F̂_CRF⁻¹ F̂_Tool` (14) against `F`.
fn compare(
    crf_from_tool: &Pose,
    tip_in_tool: &Point3<f64>,
    (tool_tracker, tool): (&BodyTracker, &Tracked),
    crf: Option<(&BodyTracker, &Tracked)>,
) -> Trial {
    let tracker_from_crf = crf.map_or_else(Pose::identity, |(_, c)| c.fit.tracker_from_body);
    let simulated = tracker_from_crf.inverse() * tool.fit.tracker_from_body;
    let error = relative_error(crf_from_tool, &simulated, tip_in_tool);
    // In the CRF.
    let free_tool = tool_tracker
        .free_motion(&tool.fit.determination)
        .map(|free| free.transformed_by(&simulated));
    let free_crf =
        crf.and_then(|(tracker, tracked)| tracker.free_motion(&tracked.fit.determination));
    let (tip, tip_simulated) = (crf_from_tool * tip_in_tool, simulated * tip_in_tool);
    let free_reach_mm = [free_tool, free_crf].into_iter().flatten();
    let free_reach_mm = free_reach_mm.map(|free| free.reach_mm(&tip_simulated)).sum();
    Trial {
        crf_from_tool: *crf_from_tool,
        crf_from_tool_simulated: simulated,
        tip_error_in_crf_mm: error.tip_error_in_crf_mm,
        tip_error_mm: error.tip_error_in_crf_mm.norm(),
        angle_error_deg: error.angle_rad.to_degrees(),
        outside: tool.outside + crf.map_or(0, |(_, c)| c.outside),
        in_metal: tool.in_metal + crf.map_or(0, |(_, c)| c.in_metal),
        out_of_volume: tool.out_of_volume + crf.map_or(0, |(_, c)| c.out_of_volume),
        determined_mm: free_tool
            .or(free_crf)
            .map(|free| free.determined_error_mm(&tip, &tip_simulated)),
        free_reach_mm,
    }
}
