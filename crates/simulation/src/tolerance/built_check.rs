//! Tools that are off at random, within what the sheet allows, simulated one by one.

use super::as_built::{BuildErrors, BuiltBuffers, BuiltStudy};
use super::search::worst_ratio;
use super::sheet::{BuiltBody, ManufacturingSheet, SheetBody};
use crate::body::{Sensor, SensorOrientation};
use crate::requirement::Check;
use crate::run::StudyError;
use crate::scenario::Scenario;
use crate::work::Work;
use nalgebra::{Unit, Vector3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, UnitBall, UnitDisc};
use rayon::prelude::*;
use serde::Serialize;
use trackwright_field::samples::PoseError;
use trackwright_geometry::rotation::perpendicular;
use trackwright_task::Task;

/// Most draws of a check: what each comes to is kept.
pub const MAX_DRAWS: usize = 1_000_000;

/// What drawn tools came to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BuiltCheck {
    pub draws: usize,
    pub seed: u64,
    /// Draws that meet the requirement.
    pub met: usize,
    /// Of each bound the largest figure over all draws.
    pub worst: Vec<Check>,
    /// The draw that came closest to a bound, from 0.
    pub closest_draw: usize,
    #[serde(skip)]
    pub work: Work,
}

impl BuiltCheck {
    pub fn holds(&self) -> bool {
        self.met == self.draws
    }
}

/// Draws tools and CRFs with every sensor off within [`SheetBody::together`], uniformly in the ball of
/// positions and in the disc (5 DOF) or ball (6 DOF) of turns, and simulates each at every pose of the
/// sheet; `None` where the sheet has no tolerances. The same seed gives the same draws on any machine.
///
/// # Errors
/// Cancelled, or a range of motion that cannot be visited.
pub fn check_built(
    scenario: &Scenario,
    sheet: &ManufacturingSheet,
    draws: usize,
    seed: u64,
    task: &Task,
) -> Result<Option<BuiltCheck>, StudyError> {
    let Some(requirement) = scenario.requirement else {
        return Ok(None);
    };
    if sheet.no_tolerances.is_some() || draws == 0 {
        return Ok(None);
    }
    let study = BuiltStudy::new(scenario, requirement)?;
    let done = std::sync::atomic::AtomicUsize::new(0);
    let found: Result<Vec<(Vec<Check>, Work)>, StudyError> = (0..draws.min(MAX_DRAWS))
        .into_par_iter()
        .map_init(BuiltBuffers::default, |buffers, draw| {
            let before = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            task.step(before, draws).map_err(|_| StudyError::Cancelled)?;
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(draw as u64);
            let errors = drawn(scenario, sheet, &mut rng);
            let checks = study
                .simulate(buffers, &errors, &task.cancel)
                .map_err(|_| StudyError::Cancelled)?;
            Ok((checks, buffers.take_work()))
        })
        .collect();
    let mut check = BuiltCheck {
        draws: draws.min(MAX_DRAWS),
        seed,
        met: 0,
        worst: Vec::new(),
        closest_draw: 0,
        work: study.own_work(),
    };
    let mut closest = f64::NEG_INFINITY;
    for (draw, (checks, work)) in found?.into_iter().enumerate() {
        check.work += work;
        check.met += usize::from(!checks.is_empty() && checks.iter().all(|c| c.met));
        let ratio = worst_ratio(&checks);
        if ratio > closest {
            (closest, check.closest_draw) = (ratio, draw);
        }
        if check.worst.is_empty() {
            check.worst = checks;
            continue;
        }
        for (worst, found) in check.worst.iter_mut().zip(checks) {
            if found.value > worst.value || found.value.is_nan() {
                *worst = found;
            }
        }
    }
    Ok(Some(check))
}

fn drawn(scenario: &Scenario, sheet: &ManufacturingSheet, rng: &mut ChaCha8Rng) -> BuildErrors {
    let body = |role: BuiltBody| sheet.bodies.iter().find(|b| b.role == role);
    let crf = scenario.crf.as_ref();
    BuildErrors {
        tool: of_body(&scenario.tool.sensors, body(BuiltBody::Tool), rng),
        crf: of_body(crf.map_or(&[], |c| &c.body.sensors), body(BuiltBody::Crf), rng),
    }
}

fn of_body(sensors: &[Sensor], body: Option<&SheetBody>, rng: &mut ChaCha8Rng) -> Vec<PoseError> {
    let together = body.and_then(|b| b.together.as_ref());
    let position_mm = together.map_or(0.0, |t| t.position_mm.value());
    let angle_rad = together.map_or(0.0, |t| t.angle_deg.value()).to_radians();
    sensors
        .iter()
        .map(|sensor| PoseError {
            position_mm: in_ball(rng) * position_mm,
            rotation_rad: match &sensor.orientation {
                SensorOrientation::Marker => Vector3::zeros(),
                SensorOrientation::FiveDof(axis) => in_disc(rng, axis) * angle_rad,
                SensorOrientation::SixDof(_) => in_ball(rng) * angle_rad,
            },
        })
        .collect()
}

/// Uniform in the unit ball.
fn in_ball(rng: &mut ChaCha8Rng) -> Vector3<f64> {
    let v: [f64; 3] = UnitBall.sample(rng);
    v.into()
}

/// Uniform in the unit disc perpendicular to an axis.
fn in_disc(rng: &mut ChaCha8Rng, axis: &Unit<Vector3<f64>>) -> Vector3<f64> {
    let [u, v]: [f64; 2] = UnitDisc.sample(rng);
    let across = perpendicular(axis);
    across.into_inner() * u + axis.cross(&across) * v
}
