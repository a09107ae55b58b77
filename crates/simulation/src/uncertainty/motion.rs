//! The first-order scatter of the tip at every pose of a range of motion.

use super::error::UncertaintyError;
use super::first_order::free_body;
use super::still::{check_size, stated_jitter};
use crate::body::Sensor;
use crate::figures::FreeAxis;
use crate::linear_fit::{LinearFit, MotionCovariance, SensorCovariance};
use crate::metric::Statistics;
use crate::scenario::{Scenario, ScenarioCrf};
use rayon::prelude::*;
use serde::Serialize;
use trackwright_field::OutsidePolicy;
use trackwright_field::environment::Jitter;
use trackwright_geometry::pose::Pose;
use trackwright_task::{Cancelled, Task};

/// Poses that are done together between checks whether to go on.
const BATCH: usize = 65_536;

/// The scatter over a range of motion, of the jitter alone and to first order.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MotionUncertainty {
    pub trials: usize,
    /// Poses with a sensor outside the model's box that were left out.
    pub rejected: usize,
    /// Over the poses, the tip's RMS scatter at each.
    pub rms_mm: Statistics,
    /// Over the poses, the RMS scatter of the rotation at each.
    pub rotation_rms_deg: Statistics,
    /// The pose with the largest scatter of the tip, from 0.
    pub worst_trial: usize,
    /// A rotation that is not determined, and taken to be the true one.
    pub free_axis: Option<FreeAxis>,
}

impl MotionUncertainty {
    /// Of distortion and jitter together, from the RMS tip error of the same poses without jitter.
    pub fn total_rms_mm(&self, systematic_rms_mm: f64) -> f64 {
        self.rms_mm.rms().hypot(systematic_rms_mm)
    }
}

/// First-order scatter of the tip at every pose of the design's range of motion.
///
/// # Errors
/// See [`UncertaintyError`].
pub fn over_motion(
    scenario: &Scenario,
    task: &Task,
) -> Result<MotionUncertainty, UncertaintyError> {
    let grid = scenario.motion_grid()?.ok_or(UncertaintyError::NoMotion)?;
    let scatter = Scatter::new(scenario)?;
    let trials = grid.trials();
    let mut values = Vec::new();
    let (mut tip_mm, mut turn_deg) = (Vec::with_capacity(trials), Vec::with_capacity(trials));
    let (mut worst_trial, mut worst_mm) = (0, f64::NEG_INFINITY);
    for start in (0..trials).step_by(BATCH) {
        task.step(start, trials)?;
        let end = (start + BATCH).min(trials);
        (start..end)
            .into_par_iter()
            .map(|index| {
                if task.cancel.is_cancelled() {
                    return Err(Cancelled.into());
                }
                scatter.at(&grid.pose(index))
            })
            .collect_into_vec(&mut values);
        for (offset, value) in values.drain(..).enumerate() {
            let Some([tip, turn]) = value? else {
                continue;
            };
            if tip > worst_mm {
                (worst_mm, worst_trial) = (tip, start + offset);
            }
            tip_mm.push(tip);
            turn_deg.push(turn.to_degrees());
        }
    }
    let rejected = trials - tip_mm.len();
    let all_rejected = UncertaintyError::AllRejected { trials };
    Ok(MotionUncertainty {
        trials,
        rejected,
        rms_mm: Statistics::of(&mut tip_mm).ok_or(all_rejected.clone())?,
        rotation_rms_deg: Statistics::of(&mut turn_deg).ok_or(all_rejected)?,
        worst_trial,
        free_axis: scatter.free_axis,
    })
}

/// Everything that does not change while the tool moves. The tip's mean square needs no axes, so
/// what each sensor of the tool adds to it for a unit of variance is one number.
struct Scatter<'a> {
    scenario: &'a Scenario,
    jitter: Jitter,
    tool: Vec<ToolSensor<'a>>,
    crf: Option<CrfScatter>,
    free_axis: Option<FreeAxis>,
}

struct ToolSensor<'a> {
    sensor: &'a Sensor,
    /// Mean square of tip and turn for a unit of the position's variance, and of the rotation's.
    by_position: [f64; 2],
    by_rotation: [f64; 2],
}

/// The CRF stands still: one covariance for all poses.
struct CrfScatter {
    tracker_from_crf: Pose,
    covariance: MotionCovariance,
    linear: LinearFit,
    /// All of its sensors in the model's box.
    is_inside: bool,
}

impl CrfScatter {
    fn new(
        crf: &ScenarioCrf,
        scenario: &Scenario,
        jitter: &Jitter,
    ) -> Result<Self, UncertaintyError> {
        let bounds = scenario.environment.model.bounds();
        let linear = LinearFit::new(&crf.body, scenario.orientation_weight_mm);
        let mut is_inside = true;
        let mut covariances = Vec::new();
        for sensor in &crf.body.sensors {
            let at = crf.tracker_from_crf * sensor.position_in_body;
            let local = jitter.at(&at);
            check_size(&local, &crf.body, sensor)?;
            is_inside &= bounds.contains(&at);
            covariances.push(SensorCovariance::isotropic(local.position_mm, local.angle_rad));
        }
        Ok(Self {
            tracker_from_crf: crf.tracker_from_crf,
            covariance: linear.covariance(&covariances),
            linear,
            is_inside,
        })
    }
}

impl<'a> Scatter<'a> {
    fn new(scenario: &'a Scenario) -> Result<Self, UncertaintyError> {
        let jitter = stated_jitter(scenario)?;
        let weight_mm = scenario.orientation_weight_mm;
        let linear = LinearFit::new(&scenario.tool, weight_mm);
        let lever_mm = linear.lever_mm(&scenario.tool.judged_tip_in_body());
        let squares = |c: &MotionCovariance| [c.point_mm2(&lever_mm).trace(), c.turn_rad2.trace()];
        let tool = scenario
            .tool
            .sensors
            .iter()
            .zip(linear.unit_covariances())
            .map(|(sensor, unit)| ToolSensor {
                sensor,
                by_position: squares(&unit.position),
                by_rotation: squares(&unit.rotation),
            })
            .collect();
        let crf =
            scenario.crf.as_ref().map(|crf| CrfScatter::new(crf, scenario, &jitter)).transpose()?;
        let free = free_body(&linear, crf.as_ref().map(|c| &c.linear));
        Ok(Self {
            scenario,
            jitter,
            tool,
            crf,
            free_axis: free.map(|free| FreeAxis::of(free.body, free.motion_in_body.axis, scenario)),
        })
    }

    /// RMS of the tip in mm and of the turn in rad; `None` where the pose is left out.
    fn at(&self, crf_from_tool: &Pose) -> Result<Option<[f64; 2]>, UncertaintyError> {
        let tracker_from_tool =
            self.crf.as_ref().map_or(*crf_from_tool, |c| c.tracker_from_crf * crf_from_tool);
        let bounds = self.scenario.environment.model.bounds();
        let mut is_inside = self.crf.as_ref().is_none_or(|c| c.is_inside);
        let (mut tip_mm2, mut turn_rad2) = (0.0, 0.0);
        for tool in &self.tool {
            let at = tracker_from_tool * tool.sensor.position_in_body;
            let jitter = self.jitter.at(&at);
            check_size(&jitter, &self.scenario.tool, tool.sensor)?;
            is_inside &= bounds.contains(&at);
            let position = jitter.position_mm * jitter.position_mm;
            let rotation = jitter.angle_rad * jitter.angle_rad;
            tip_mm2 += position * tool.by_position[0] + rotation * tool.by_rotation[0];
            turn_rad2 += position * tool.by_position[1] + rotation * tool.by_rotation[1];
        }
        if self.scenario.outside == OutsidePolicy::Reject && !is_inside {
            return Ok(None);
        }
        if let Some(crf) = &self.crf {
            let tip = crf_from_tool * self.scenario.tool.judged_tip_in_body();
            tip_mm2 += crf.covariance.point_mm2(&crf.linear.lever_mm(&tip)).trace();
            turn_rad2 += crf.covariance.turn_rad2.trace();
        }
        Ok(Some([tip_mm2.max(0.0).sqrt(), turn_rad2.max(0.0).sqrt()]))
    }
}
