//! A design at its own pose, read again and again: what scatters, and the frames that follow.

use super::error::UncertaintyError;
use crate::body::{RigidBody, Sensor};
use crate::frame_fit::{FrameFitter, Reading};
use crate::scenario::Scenario;
use crate::tool_in_crf::FreeMotion;
use crate::trial::{BodyDetail, PoseDetail, simulate_pose};
use nalgebra::{Point3, Unit, Vector3};
use trackwright_field::OutsidePolicy;
use trackwright_field::environment::{Jitter, LocalJitter};
use trackwright_geometry::pose::Pose;
use trackwright_geometry::rotation::{exp_vector, log_quaternion, perpendicular};

/// Both bodies at the design's pose, and the scatter of each sensor there.
pub(super) struct Still<'a> {
    pub scenario: &'a Scenario,
    /// Without jitter: what the distortion alone does.
    pub pose: PoseDetail,
    pub tool_jitter: Vec<LocalJitter>,
    pub crf_jitter: Vec<LocalJitter>,
}

impl<'a> Still<'a> {
    pub fn new(scenario: &'a Scenario) -> Result<Self, UncertaintyError> {
        let jitter = stated_jitter(scenario)?;
        let pose = simulate_pose(scenario);
        if scenario.outside == OutsidePolicy::Reject && pose.trial.outside > 0 {
            return Err(UncertaintyError::Outside { sensors: pose.trial.outside });
        }
        let tool_jitter = local_jitter(&jitter, &scenario.tool, &pose.tool)?;
        let crf_jitter = match (&scenario.crf, &pose.crf) {
            (Some(crf), Some(detail)) => local_jitter(&jitter, &crf.body, detail)?,
            _ => Vec::new(),
        };
        Ok(Self { scenario, pose, tool_jitter, crf_jitter })
    }

    /// The true tip.
    pub fn tip_in_crf(&self) -> Point3<f64> {
        self.scenario.crf_from_tool * self.scenario.tool.judged_tip_in_body()
    }

    /// The bodies made ready to be read and refitted.
    pub fn refit(&self) -> Refit {
        let weight_mm = self.scenario.orientation_weight_mm;
        Refit {
            tool: RefitBody::new(
                &self.scenario.tool,
                weight_mm,
                &self.pose.tool,
                &self.tool_jitter,
            ),
            crf: self.scenario.crf.as_ref().zip(self.pose.crf.as_ref()).map(|(crf, detail)| {
                RefitBody::new(&crf.body, weight_mm, detail, &self.crf_jitter)
            }),
            crf_from_tool: self.scenario.crf_from_tool,
            tip_in_tool: self.scenario.tool.judged_tip_in_body(),
        }
    }
}

/// The jitter that the scenario's environment states.
pub(super) fn stated_jitter(scenario: &Scenario) -> Result<Jitter, UncertaintyError> {
    let bodies = [Some(&scenario.tool), scenario.crf.as_ref().map(|c| &c.body)];
    if let Some(body) = bodies.into_iter().flatten().find(|b| b.sensors.is_empty()) {
        return Err(UncertaintyError::NoSensors { body: body.name.clone() });
    }
    let jitter = scenario.environment.jitter.ok_or_else(|| UncertaintyError::NoJitter {
        environment: scenario.environment.name.clone(),
    })?;
    match jitter.problem() {
        None => Ok(jitter),
        Some((name, found, expected)) => Err(UncertaintyError::Jitter { name, found, expected }),
    }
}

fn local_jitter(
    jitter: &Jitter,
    body: &RigidBody,
    detail: &BodyDetail,
) -> Result<Vec<LocalJitter>, UncertaintyError> {
    body.sensors
        .iter()
        .zip(&detail.sensors)
        .map(|(sensor, at)| {
            let local = jitter.at(&at.tracker_from_sensor.translation.vector.into());
            check_size(&local, body, sensor)?;
            Ok(local)
        })
        .collect()
}

/// Whether a sensor's jitter has squares that can be computed with.
pub(super) fn check_size(
    local: &LocalJitter,
    body: &RigidBody,
    sensor: &Sensor,
) -> Result<(), UncertaintyError> {
    let is_finite = (local.position_mm * local.position_mm).is_finite()
        && (local.angle_rad * local.angle_rad).is_finite();
    if is_finite {
        return Ok(());
    }
    Err(UncertaintyError::TooLarge {
        body: body.name.clone(),
        sensor: sensor.name.clone(),
        position_mm: local.position_mm,
        angle_rad: local.angle_rad,
    })
}

/// Both bodies, ready to be read with noise and refitted by the frame fit that studies use.
pub(super) struct Refit {
    pub tool: RefitBody,
    pub crf: Option<RefitBody>,
    crf_from_tool: Pose,
    tip_in_tool: Point3<f64>,
}

/// One body and its readings without noise.
pub(super) struct RefitBody {
    fitter: FrameFitter,
    readings: Vec<Reading>,
    noise: Vec<SensorNoise>,
    tracker_from_body: Pose,
}

/// Which way one sensor scatters, by how much.
struct SensorNoise {
    position_mm: f64,
    /// Rotation vectors of one standard deviation, tracker axes: a 5-DOF sensor has two, across
    /// its axis, and a zero.
    turns_rad: [Vector3<f64>; 3],
    rotations: usize,
}

/// The tool in the CRF after one refit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Refitted {
    /// `F̂·tip − F·tip`, CRF axes.
    pub tip_error_mm: Vector3<f64>,
    /// `log(R̂ Rᵀ)`, CRF axes.
    pub turn_rad: Vector3<f64>,
    pub crf_from_tool: Pose,
}

impl RefitBody {
    fn new(body: &RigidBody, weight_mm: f64, detail: &BodyDetail, jitter: &[LocalJitter]) -> Self {
        let readings: Vec<_> = detail
            .sensors
            .iter()
            .map(|s| Reading {
                position_mm: s.tracker_from_measured.translation.vector.into(),
                rotation: s.tracker_from_measured.rotation,
            })
            .collect();
        let noise = body
            .sensors
            .iter()
            .zip(&readings)
            .zip(jitter)
            .map(|((sensor, reading), jitter)| {
                let sigma = jitter.angle_rad;
                let (directions, rotations) = match sensor.orientation.degrees_of_freedom() {
                    5 => {
                        let axis = Unit::new_normalize(reading.rotation * Vector3::z());
                        let u = perpendicular(&axis).into_inner();
                        ([u, axis.cross(&u), Vector3::zeros()], 2)
                    }
                    3 => ([Vector3::zeros(); 3], 0),
                    _ => ([Vector3::x(), Vector3::y(), Vector3::z()], 3),
                };
                SensorNoise {
                    position_mm: jitter.position_mm,
                    turns_rad: directions.map(|d| d * sigma),
                    rotations,
                }
            })
            .collect();
        Self {
            fitter: FrameFitter::new(body, weight_mm),
            readings,
            noise,
            tracker_from_body: detail.tracker_from_body,
        }
    }

    /// Numbers that one reading of the body takes: three a marker, five a 5-DOF sensor,
    /// six a 6-DOF one.
    pub fn dimensions(&self) -> usize {
        self.noise.iter().map(|n| 3 + n.rotations).sum()
    }

    /// The fit to readings moved by `normal`, numbers of unit standard deviation taken in the
    /// sensors' order, position before turn; `readings` is room to work in.
    pub fn fit(&self, mut normal: impl FnMut() -> f64, readings: &mut Vec<Reading>) -> Pose {
        readings.clear();
        readings.extend(self.readings.iter().zip(&self.noise).map(|(reading, noise)| {
            let position = Vector3::from_fn(|_, _| normal() * noise.position_mm);
            let turn_rad: Vector3<f64> = noise.turns_rad[..noise.rotations]
                .iter()
                .map(|direction| direction * normal())
                .sum();
            Reading {
                position_mm: reading.position_mm + position,
                rotation: exp_vector(&turn_rad) * reading.rotation,
            }
        }));
        self.fitter.fit(readings, &self.tracker_from_body).tracker_from_body
    }

    fn fit_without_noise(&self) -> Pose {
        self.fit(|| 0.0, &mut Vec::new())
    }
}

impl Refit {
    pub fn dimensions(&self) -> usize {
        self.tool.dimensions() + self.crf.as_ref().map_or(0, RefitBody::dimensions)
    }

    /// Frames that one reading of everything takes.
    pub fn fits(&self) -> u64 {
        1 + u64::from(self.crf.is_some())
    }

    /// What the distortion alone does.
    pub fn without_noise(&self) -> Refitted {
        let crf = self.crf.as_ref().map(RefitBody::fit_without_noise);
        self.compare(&self.tool.fit_without_noise(), crf.as_ref())
    }

    /// One reading of everything, the tool's sensors before the CRF's.
    pub fn with_noise(
        &self,
        mut normal: impl FnMut() -> f64,
        readings: &mut Vec<Reading>,
    ) -> Refitted {
        let tool = self.tool.fit(&mut normal, readings);
        let crf = self.crf.as_ref().map(|crf| crf.fit(&mut normal, readings));
        self.compare(&tool, crf.as_ref())
    }

    /// `F̂ = F̂_CRF⁻¹ F̂_Tool` (14) against `F`.
    pub fn compare(&self, tool: &Pose, crf: Option<&Pose>) -> Refitted {
        let crf_from_tool = crf.map_or(*tool, |crf| crf.inverse() * tool);
        Refitted {
            tip_error_mm: crf_from_tool * self.tip_in_tool - self.crf_from_tool * self.tip_in_tool,
            turn_rad: log_quaternion(
                &(crf_from_tool.rotation * self.crf_from_tool.rotation.inverse()),
            ),
            crf_from_tool,
        }
    }

    /// The part of a refit's tip error that a free motion of the tool (in its frame) or the CRF
    /// (in its own) cannot change.
    pub fn determined_mm(&self, free: &FreeBody, refitted: &Refitted) -> f64 {
        let (truth, simulated) =
            (self.crf_from_tool * self.tip_in_tool, refitted.crf_from_tool * self.tip_in_tool);
        free.in_crf(&refitted.crf_from_tool).determined_error_mm(&truth, &simulated)
    }
}

/// A body whose sensors leave a rotation free.
#[derive(Clone, Copy, Debug)]
pub(super) struct FreeBody {
    /// `tool` or `crf`.
    pub body: &'static str,
    pub motion_in_body: FreeMotion,
}

impl FreeBody {
    /// The free motion in CRF coordinates, with the tool at a pose.
    pub fn in_crf(&self, crf_from_tool: &Pose) -> FreeMotion {
        if self.body == "tool" {
            self.motion_in_body.transformed_by(crf_from_tool)
        } else {
            self.motion_in_body
        }
    }
}
