//! The study of a design whose sensors are not quite where it states: they read where they are, and
//! the frames are fitted as if they were where the design has them.
//!
//! What a sensor that is where it is drawn reads, and how a body without any error is fitted, is
//! computed once. A variant then costs the readings of those sensors that are off and a frame fit a
//! pose; with nothing but the CRF off, which stands still, one fit in all.

use crate::body::{RigidBody, Sensor};
use crate::frame_fit::FrameFitter;
use crate::metric::Statistics;
use crate::motion::MotionError;
use crate::pose_rule::PoseRule;
use crate::preview::{WHOLE_UP_TO, spread};
use crate::refit::{BodyReadings, RefitBuffers};
use crate::requirement::{Check, Requirement};
use crate::run::StudyError;
use crate::scenario::Scenario;
use crate::tool_in_crf::relative_error;
use crate::work::Work;
use nalgebra::{Point3, Vector3};
use trackwright_field::OutsidePolicy;
use trackwright_field::samples::PoseError;
use trackwright_geometry::pose::Pose;
use trackwright_geometry::rotation::exp_vector;
use trackwright_task::{CancelToken, Cancelled};

/// Poses that stand for a study of more than [`WHOLE_UP_TO`].
const PART_OF_LONG: usize = 8192;

/// Moves the poses that stand for a long study off the corner of its range; the square roots of the
/// first primes, which share no period with the sequence.
const SHIFT: [f64; 6] = [0.414_214, 0.732_051, 0.236_068, 0.645_751, 0.316_625, 0.605_551];

/// How far off each sensor of both bodies is, in its body's axes, one a sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct BuildErrors {
    pub tool: Vec<PoseError>,
    pub crf: Vec<PoseError>,
}

/// Off by nothing.
pub const AS_DRAWN: PoseError = PoseError {
    position_mm: Vector3::new(0.0, 0.0, 0.0),
    rotation_rad: Vector3::new(0.0, 0.0, 0.0),
};

impl BuildErrors {
    /// Everything where it is drawn.
    pub fn none(scenario: &Scenario) -> Self {
        let crf = scenario.crf.as_ref().map_or(0, |c| c.body.sensors.len());
        Self { tool: vec![AS_DRAWN; scenario.tool.sensors.len()], crf: vec![AS_DRAWN; crf] }
    }
}

/// One body that is to be read with errors and fitted without.
struct Built<'a> {
    body: &'a RigidBody,
    fitter: FrameFitter,
    readings: BodyReadings<'a>,
    run: usize,
    /// Of the body as drawn.
    tracker_from_body_fitted: Vec<Pose>,
}

/// A design's study, made ready for many ways of being off.
pub struct BuiltStudy<'a> {
    scenario: &'a Scenario,
    requirement: Requirement,
    crf_from_tool: Vec<Pose>,
    tool: Built<'a>,
    crf: Option<Built<'a>>,
    /// Poses that enter the figures.
    is_kept: Vec<bool>,
    tip_in_tool: Point3<f64>,
    work: Work,
}

/// What a variant is computed in, and the poses of the last one.
#[derive(Default)]
pub struct BuiltBuffers {
    refit: RefitBuffers,
    fitted: Vec<Pose>,
    /// `crf_from_tool` as the tracker reports it.
    pub simulated: Vec<Pose>,
    position_mm: Vec<f64>,
    angle_deg: Vec<f64>,
}

impl BuiltBuffers {
    pub fn take_work(&mut self) -> Work {
        self.refit.take_work()
    }
}

impl<'a> BuiltStudy<'a> {
    /// Over the design's range of motion, or at its pose where it has none.
    ///
    /// # Errors
    /// [`StudyError::Motion`]: a range of motion that cannot be visited.
    pub fn new(scenario: &'a Scenario, requirement: Requirement) -> Result<Self, StudyError> {
        let (poses, run) = poses(scenario)?;
        let mut buffers = BuiltBuffers::default();
        let mut work = Work::default();
        let mut built = |body, poses, run| {
            let found = Built::new(scenario, body, poses, run, &mut buffers);
            let (built, cost) = found.map_err(|Cancelled| StudyError::Cancelled)?;
            work += cost;
            Ok::<_, StudyError>(built)
        };
        let crf = scenario.crf.as_ref();
        let crf = crf.map(|crf| built(&crf.body, vec![crf.tracker_from_crf], 1)).transpose()?;
        let tracker_from_crf = scenario.tracker_from_crf();
        let tracker_from_tool = poses.iter().map(|pose| tracker_from_crf * pose).collect();
        let tool = built(&scenario.tool, tracker_from_tool, run)?;
        let crf_is_inside = crf.as_ref().is_none_or(|crf| crf.readings.are_inside(0, None));
        // The poses are those of the design as drawn: one that a sensor leaves the box in because it
        // is a hair off must not make the figures better.
        let is_kept = (0..poses.len())
            .map(|pose| {
                scenario.outside != OutsidePolicy::Reject
                    || (tool.readings.are_inside(pose, None) && crf_is_inside)
            })
            .collect();
        Ok(Self {
            scenario,
            requirement,
            crf_from_tool: poses,
            tool,
            crf,
            is_kept,
            tip_in_tool: scenario.tool.judged_tip_in_body(),
            work: work + buffers.take_work(),
        })
    }

    pub fn scenario(&self) -> &'a Scenario {
        self.scenario
    }

    pub fn requirement(&self) -> Requirement {
        self.requirement
    }

    /// Poses that variants are simulated at.
    pub fn poses(&self) -> usize {
        self.crf_from_tool.len()
    }

    /// What making this cost.
    pub fn own_work(&self) -> Work {
        self.work
    }

    /// The true poses, and whether they enter the figures.
    pub fn crf_from_tool(&self) -> impl Iterator<Item = (&Pose, bool)> {
        self.crf_from_tool.iter().zip(self.is_kept.iter().copied())
    }

    /// The requirement with sensors that are off; the simulated poses stay in `buffers`.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn simulate(
        &self,
        buffers: &mut BuiltBuffers,
        errors: &BuildErrors,
        cancel: &CancelToken,
    ) -> Result<Vec<Check>, Cancelled> {
        let crf_from_tracker = match &self.crf {
            None => Pose::identity(),
            Some(crf) => {
                crf.fit(buffers, &errors.crf, cancel)?;
                buffers.fitted.first().map_or_else(Pose::identity, Pose::inverse)
            }
        };
        self.tool.fit(buffers, &errors.tool, cancel)?;
        buffers.simulated.clear();
        buffers.position_mm.clear();
        buffers.angle_deg.clear();
        for (pose, is_kept, fitted) in self
            .crf_from_tool()
            .zip(&buffers.fitted)
            .map(|((pose, is_kept), fitted)| (pose, is_kept, fitted))
        {
            let simulated = crf_from_tracker * fitted;
            buffers.simulated.push(simulated);
            if is_kept {
                let error = relative_error(pose, &simulated, &self.tip_in_tool);
                buffers.position_mm.push(error.tip_error_in_crf_mm.norm());
                buffers.angle_deg.push(error.angle_rad.to_degrees());
            }
        }
        let position_mm = Statistics::of(&mut buffers.position_mm);
        let angle_deg = Statistics::of(&mut buffers.angle_deg);
        Ok(position_mm
            .zip(angle_deg)
            .map(|(position_mm, angle_deg)| self.requirement.checks(&position_mm, &angle_deg))
            .unwrap_or_default())
    }
}

/// The poses of the design's study, or of a part of a long one, in runs of one orientation, and how
/// long those are.
fn poses(scenario: &Scenario) -> Result<(Vec<Pose>, usize), MotionError> {
    let Some(grid) = scenario.motion_grid()? else {
        return Ok((vec![scenario.crf_from_tool], 1));
    };
    if grid.trials() <= WHOLE_UP_TO {
        let rule = PoseRule::whole(&grid);
        return Ok((rule.poses, rule.run));
    }
    let part = spread(&grid, PART_OF_LONG, SHIFT);
    Ok((part.iter().map(|t| t.crf_from_tool).collect(), 1))
}

/// Poses that are read together: some 0.3 ms, between two looks at whether anyone still wants them.
const PIECE: usize = 256;

impl<'a> Built<'a> {
    fn new(
        scenario: &'a Scenario,
        body: &'a RigidBody,
        tracker_from_body: Vec<Pose>,
        run: usize,
        buffers: &mut BuiltBuffers,
    ) -> Result<(Self, Work), Cancelled> {
        let fitter = FrameFitter::new(body, scenario.orientation_weight_mm);
        let whole = std::iter::once(0..tracker_from_body.len()).collect();
        let cancel = CancelToken::default();
        let poses = (tracker_from_body, run);
        let (readings, work) = BodyReadings::read(scenario, body, None, poses, whole, &cancel)?;
        let tracker_from_body_fitted = readings.fit(&fitter, &mut buffers.refit);
        Ok((Self { body, fitter, readings, run, tracker_from_body_fitted }, work))
    }

    /// Fits the body with sensors that are off, into `buffers.fitted`.
    fn fit(
        &self,
        buffers: &mut BuiltBuffers,
        errors: &[PoseError],
        cancel: &CancelToken,
    ) -> Result<(), Cancelled> {
        buffers.fitted.clear();
        let off: Vec<usize> = (0..errors.len().min(self.body.sensors.len()))
            .filter(|&sensor| errors[sensor] != AS_DRAWN)
            .collect();
        if off.is_empty() {
            buffers.fitted.extend_from_slice(&self.tracker_from_body_fitted);
            return Ok(());
        }
        let built = |&sensor: &usize| built_sensor(&self.body.sensors[sensor], &errors[sensor]);
        let sensors: Vec<Sensor> = off.iter().map(built).collect();
        let replaced = self.readings.replaced(self.body, &self.fitter, &off, &sensors);
        let count = self.readings.tracker_from_body().len();
        // Whole runs, or pieces of a long one.
        let len = if self.run < PIECE { PIECE / self.run * self.run } else { PIECE };
        let pieces = (0..count).step_by(len).map(|start| start..(start + len).min(count));
        let BuiltBuffers { refit, fitted, .. } = buffers;
        let keeps_all = |_, _| true;
        self.readings.refit(&replaced, pieces, refit, cancel, keeps_all, |_, pose| {
            fitted.push(pose);
        })
    }
}

/// A sensor that is off.
pub fn built_sensor(sensor: &Sensor, error: &PoseError) -> Sensor {
    Sensor::new(
        "",
        sensor.position_in_body + error.position_mm,
        sensor.orientation.rotated_by(&exp_vector(&error.rotation_rad)),
    )
}
