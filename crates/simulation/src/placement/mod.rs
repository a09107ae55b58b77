//! Where on a body's surface a sensor would serve the tip best: the study's tip RMS if it sat
//! there, for every vertex of the surface, coarse first.
//!
//! All that does not change with the sensor's place is computed once: the readings of the other
//! sensors at every pose, the CRF, the poses. A vertex then costs one reading and one frame fit a
//! pose. For a sensor of the CRF, which stands still, it costs one of each in all (`crf.rs`), and
//! every vertex is computed fully. For a sensor of the tool 20,000 vertices times thousands of
//! poses are too many, so that a part of the vertices is computed fully, farthest first, and the
//! others as their own tip RMS over few poses times how far that is from the full one at the
//! fully computed vertices around.
//!
//! 20,000 vertices of a tool and 3,375 poses take 4.3 million fits, 0.6 µs of one core each; the
//! first picture 0.11 million. 20,000 vertices of a CRF take some 0.05 s.
//!
//! The few poses are a Gauss rule on the motion's grid. How far values are from the full study, in
//! parts of it, median / 90th percentile / worst of 97 vertices of the built-in tools (room of order 2,
//! 3,375 poses):
//!
//! | picture | full | axis kept | along the normal | along the surface |
//! | --- | --- | --- | --- | --- |
//! | pointer, 512 vertices at few poses, others between | 24 | 0.1 / 0.3 / 0.6 % | 2.4 / 7.4 / 21 % | 2.3 / 5.7 / 10 % |
//! | pointer, all 11,204 vertices at few poses | 24 | 0.08 / 0.17 / 0.3 % | 2.2 / 5.6 / 21 % | 1.8 / 4.5 / 6.6 % |
//! | pointer, the last one | 900 | 0.01 / 0.02 / 0.03 % | 0.5 / 2.1 / 7.3 % | 0.4 / 1.6 / 4.4 % |
//! | shaver, 512 vertices at few poses, others between | 24 | 0.2 / 0.7 / 1.5 % | 2.6 / 7.8 / 32 % | 2.3 / 6.2 / 22 % |
//! | shaver, all 13,476 vertices at few poses | 24 | 0.07 / 0.3 / 0.5 % | 1.2 / 3.5 / 17 % | 0.9 / 3.6 / 8.6 % |
//! | shaver, the last one | 900 | 0.01 / 0.02 / 0.06 % | 0.5 / 1.4 / 3.1 % | 0.2 / 1.3 / 2.5 % |
//!
//! The large errors are where trials vary most over the motion, as they do where the sensor's axis
//! is nearly along the others' and the tool's roll hangs by little: few poses do not show that.
//! Vertices are therefore also told apart by how much their trials vary.

mod crf;
mod interval;
mod known;
mod rule;
mod tool;

pub use rule::AxisRule;

use super::metric::Metric;
use super::motion::MotionError;
use super::pose_rule::{PoseRule, corners};
use super::preview::WHOLE_UP_TO;
use super::run::{StudyError, check};
use super::scenario::Scenario;
use super::tracker::TrackBuffers;
use super::work::Work;
use crate::Sensor;
use crf::CrfAt;
use interval::OpenParts;
use known::Known;
use nalgebra::{Unit, Vector3};
use rayon::prelude::*;
use std::collections::HashMap;
use std::sync::Arc;
use tool::{ToolAt, ToolBuffers};
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_geometry::pose::Pose;
use trackwright_geometry::spread::{Position, farthest_first};
use trackwright_geometry::surface::SurfacePoint;
use trackwright_task::{Cancelled, Task};

/// Poses that every vertex is computed at.
const FEW_POSES: usize = 64;

/// Poses that stand for a range of motion of more than [`WHOLE_UP_TO`].
const MANY_POSES: usize = 4096;

/// Trials that go into fully computed vertices.
const FULL_TRIALS: usize = 3_000_000;

/// Vertices that are computed fully whatever that costs: without any, nobody knows how good the
/// others are.
const LEAST_FULL: usize = 24;

/// Vertices that the first picture is made of.
const FIRST_VERTICES: usize = 512;

/// Trials up to which there is one picture only.
const AT_ONCE: usize = 100_000;

/// How far apart two places are whose sensors point a radian apart: about as far as sensors of a
/// tool are from each other. Chosen, not tuned, as is the next.
const RADIAN_MM: f64 = 20.0;

/// How far apart two places are at one of which trials vary e times as much as at the other. Where
/// a sensor hardly adds to what the others determine, the tip swings far at some of the poses, few
/// poses miss that, and a place tells little of its neighbour.
const E_FOLD_MM: f64 = 20.0;

/// Whose sensor is moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PlacedBody {
    Tool,
    Crf,
}

/// What is asked: places for one sensor.
#[derive(Clone, Debug)]
pub struct PlacementPlan {
    pub body: PlacedBody,
    /// Its number in the body.
    pub sensor: usize,
    pub rule: AxisRule,
    /// Body frame.
    pub candidates: Arc<[SurfacePoint]>,
}

/// What one place comes to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// The study's tip error RMS over the design's motion, or of its own pose where it has none;
    /// `None` where each trial is left out, or the place is not a number.
    pub tip_rms_mm: Option<f64>,
    pub basis: Basis,
    /// With what the room's measurements leave open; `None` where it keeps none, and before the last
    /// picture.
    pub expected: Option<ExpectedTip>,
    /// Whether the sensor leaves the model's box: at a pose that was computed, or in a corner of
    /// the range of motion.
    pub is_outside: bool,
}

/// A tip RMS to be expected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExpectedTip {
    /// Mean over drawn fields.
    pub rms_mm: f64,
    /// 95 % interval.
    pub interval_mm: [f64; 2],
}

impl Placement {
    /// The expected tip RMS where it is known, else that of the room's own field.
    pub fn shown_mm(&self) -> Option<f64> {
        self.expected.map_or(self.tip_rms_mm, |expected| Some(expected.rms_mm))
    }
}

/// How a value was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Basis {
    /// The study with the sensor there, to the last digits.
    Full,
    /// By few poses and full neighbours.
    Approximate {
        /// An estimate that is rather too large: what the neighbours that are known would be off by
        /// were they found like this from the others.
        error_mm: f64,
    },
}

/// All places, as well as they are known so far.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacementOutcome {
    /// One a candidate.
    pub places: Vec<Placement>,
    /// Candidates that are computed fully.
    pub full: usize,
    /// Poses of the study.
    pub trials: usize,
    /// Whether nothing better follows.
    pub is_final: bool,
    /// So far.
    pub work: Work,
}

/// Why there are no places.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlacementError {
    #[error("the design has no CRF")]
    NoCrf,
    #[error("sensor {sensor} of {body} is to be moved, which has {sensors}")]
    NoSensor { body: String, sensor: usize, sensors: usize },
    #[error(transparent)]
    Study(#[from] StudyError),
}

impl From<Cancelled> for PlacementError {
    fn from(_: Cancelled) -> Self {
        Self::Study(StudyError::Cancelled)
    }
}

impl From<MotionError> for PlacementError {
    fn from(error: MotionError) -> Self {
        Self::Study(error.into())
    }
}

/// A tip RMS, and whether the sensor leaves the model's box.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Found {
    tip_rms_mm: Option<f64>,
    is_outside: bool,
    /// Standard deviation of the squares of the tip errors, in parts of their mean.
    variation: f64,
}

impl PlacementOutcome {
    /// Between candidates, each with what it counts for: of the vertices of a triangle, as the body
    /// is painted. `None` where one of them that counts has no value.
    pub fn between(&self, candidates: [usize; 3], weights: [f64; 3]) -> Option<f64> {
        self.mixed(candidates, weights, Placement::shown_mm)
    }

    /// Likewise the 95 % interval of the expected value.
    pub fn interval_between(&self, candidates: [usize; 3], weights: [f64; 3]) -> Option<[f64; 2]> {
        let end = |k: usize| {
            self.mixed(candidates, weights, |place| Some(place.expected?.interval_mm[k]))
        };
        Some([end(0)?, end(1)?])
    }

    fn mixed(
        &self,
        candidates: [usize; 3],
        weights: [f64; 3],
        value_mm: impl Fn(&Placement) -> Option<f64>,
    ) -> Option<f64> {
        let parts = candidates.into_iter().zip(weights);
        parts
            .filter(|(_, weight)| *weight != 0.0)
            .map(|(candidate, weight)| Some(weight * value_mm(self.places.get(candidate)?)?))
            .sum()
    }

    /// Whether values are expected ones.
    pub fn is_expected(&self) -> bool {
        self.places.iter().any(|place| place.expected.is_some())
    }

    /// The name of the figure that places are shown by.
    pub fn figure_label(&self) -> String {
        let expected = if self.is_expected() { "expected " } else { "" };
        format!("{expected}{}", Metric::TIP_RMS.label())
    }

    /// The smallest and the largest value.
    pub fn range_mm(&self) -> Option<[f64; 2]> {
        let values = self.places.iter().filter_map(Placement::shown_mm);
        values.fold(None, |range, v| {
            let [low, high] = range.unwrap_or([v; 2]);
            Some([low.min(v), high.max(v)])
        })
    }
}

/// The vertices of an instrument, part after part in the mesh's order; one whose normal has no
/// direction looks along z.
pub fn vertices(mesh: &SurfaceMesh) -> Vec<SurfacePoint> {
    mesh.body_parts()
        .flat_map(|part| part.positions_mm.iter().zip(&part.normals))
        .map(|(position_mm, normal)| SurfacePoint {
            position_mm: *position_mm,
            normal: Unit::try_new(*normal, 1e-12).unwrap_or_else(Vector3::z_axis),
        })
        .collect()
}

/// Finds what each place comes to; `deliver` gets each picture, the last one too, which is
/// returned. The result does not depend on the number of threads.
///
/// # Errors
/// See [`PlacementError`].
pub fn place(
    scenario: &Scenario,
    plan: &PlacementPlan,
    task: &Task,
    deliver: &mut dyn FnMut(&PlacementOutcome),
) -> Result<PlacementOutcome, PlacementError> {
    check(scenario)?;
    let body = match plan.body {
        PlacedBody::Tool => &scenario.tool,
        PlacedBody::Crf => &scenario.crf.as_ref().ok_or(PlacementError::NoCrf)?.body,
    };
    let sensors = body.sensors.len();
    let Some(sensor) = body.sensors.get(plan.sensor) else {
        return Err(PlacementError::NoSensor {
            body: body.name.clone(),
            sensor: plan.sensor,
            sensors,
        });
    };
    task.step(0, 1)?;
    let study = Study::new(scenario)?;
    let candidates = Candidates::new(sensor, plan);
    let (mut outcome, features) = match (plan.body, &scenario.crf) {
        (PlacedBody::Crf, Some(crf)) => {
            let of = |rule| CrfAt::new(scenario, crf, plan.sensor, rule, &task.cancel);
            let outcome = on_crf(&of(&study.many)?, &of(&study.few)?, &study, &candidates, task)?;
            (outcome, candidates.places.clone())
        }
        _ => {
            let of = |rule| ToolAt::new(scenario, plan.sensor, rule, &task.cancel);
            let tools = [of(&study.many)?, of(&study.few)?];
            on_tool(scenario, &tools, &study, &candidates, task, deliver)?
        }
    };
    if scenario.environment.process.is_some() {
        outcome.is_final = false;
        deliver(&outcome);
        if let Some(open) = OpenParts::find(scenario, plan, &candidates, &features, task)? {
            open.add_to(&mut outcome.places, &candidates.place_of, &features);
        }
        outcome.is_final = true;
    }
    deliver(&outcome);
    task.step(1, 1)?;
    Ok(outcome)
}

/// The poses of the study, and few that stand for them.
struct Study {
    trials: usize,
    many: PoseRule,
    /// Whether these are all poses of the study.
    is_whole: bool,
    few: PoseRule,
    /// `crf_from_tool` at the ends of the motion.
    corners: Vec<Pose>,
}

impl Study {
    fn new(scenario: &Scenario) -> Result<Self, PlacementError> {
        let Some(motion) = scenario.motion else {
            return Ok(Self {
                trials: 1,
                many: PoseRule::single(scenario),
                is_whole: true,
                few: PoseRule::single(scenario),
                corners: vec![scenario.crf_from_tool],
            });
        };
        let grid = motion.grid(&scenario.crf_from_tool)?;
        let is_whole = grid.trials() <= WHOLE_UP_TO;
        Ok(Self {
            trials: grid.trials(),
            many: match is_whole {
                true => PoseRule::whole(&grid),
                false => PoseRule::gauss(scenario, MANY_POSES)?,
            },
            is_whole,
            few: PoseRule::gauss(scenario, FEW_POSES)?,
            corners: corners(&grid),
        })
    }
}

/// The places, each once: meshes name a vertex of a sharp edge several times.
struct Candidates {
    sensors: Vec<Sensor>,
    places: Vec<Position>,
    /// Of each candidate, which of them it is.
    place_of: Vec<usize>,
}

impl Candidates {
    fn new(sensor: &Sensor, plan: &PlacementPlan) -> Self {
        let nameless = Sensor { name: String::new(), ..sensor.clone() };
        let mut known: HashMap<[u64; 7], usize> = HashMap::new();
        let (mut sensors, mut places) = (Vec::new(), Vec::new());
        let place_of = plan
            .candidates
            .iter()
            .map(|candidate| {
                let placed = plan.rule.placed(&nameless, candidate);
                let axis = placed
                    .axis_in_body()
                    .map_or_else(Vector3::zeros, |axis| axis.into_inner() * RADIAN_MM);
                let at = placed.position_in_body;
                let place = [at.x, at.y, at.z, axis.x, axis.y, axis.z, 0.0];
                *known.entry(place.map(f64::to_bits)).or_insert_with(|| {
                    sensors.push(placed);
                    places.push(place);
                    places.len() - 1
                })
            })
            .collect();
        Self { sensors, places, place_of }
    }

    fn is_finite(&self, place: usize) -> bool {
        self.places[place].iter().all(|v| v.is_finite())
    }

    /// The outcome from what each place comes to.
    fn outcome(
        &self,
        of_place: &[Placement],
        trials: usize,
        is_final: bool,
        work: Work,
    ) -> PlacementOutcome {
        let places: Vec<_> = self.place_of.iter().map(|&place| of_place[place]).collect();
        PlacementOutcome {
            full: places.iter().filter(|p| p.basis == Basis::Full).count(),
            places,
            trials,
            is_final,
            work: Work {
                placement_evaluations: work.study_evaluations,
                study_evaluations: 0,
                ..work
            },
        }
    }
}

const NOWHERE: Placement =
    Placement { tip_rms_mm: None, basis: Basis::Full, expected: None, is_outside: true };

fn on_crf(
    many: &CrfAt,
    few: &CrfAt,
    study: &Study,
    candidates: &Candidates,
    task: &Task,
) -> Result<PlacementOutcome, PlacementError> {
    let found: Result<Vec<(Placement, Work)>, Cancelled> = candidates
        .sensors
        .par_iter()
        .enumerate()
        .map_init(TrackBuffers::default, |buffers, (place, sensor)| {
            if task.cancel.is_cancelled() {
                return Err(Cancelled);
            }
            if !candidates.is_finite(place) {
                return Ok((NOWHERE, Work::default()));
            }
            let found = many.found(buffers, sensor);
            let basis = match study.is_whole {
                true => Basis::Full,
                false => Basis::Approximate {
                    error_mm: difference_mm(&found, &few.found(buffers, sensor)),
                },
            };
            let placement = Placement {
                tip_rms_mm: found.tip_rms_mm,
                basis,
                expected: None,
                is_outside: found.is_outside,
            };
            Ok((placement, std::mem::take(&mut buffers.work)))
        })
        .collect();
    let mut work = many.own_work() + few.own_work();
    let mut places = Vec::with_capacity(candidates.places.len());
    for (placement, cost) in found? {
        work += cost;
        places.push(placement);
    }
    Ok(candidates.outcome(&places, study.trials, true, work))
}

fn difference_mm(a: &Found, b: &Found) -> f64 {
    match (a.tip_rms_mm, b.tip_rms_mm) {
        (Some(a), Some(b)) => (a - b).abs(),
        _ => f64::INFINITY,
    }
}

fn on_tool(
    scenario: &Scenario,
    [many, few]: &[ToolAt; 2],
    study: &Study,
    candidates: &Candidates,
    task: &Task,
    deliver: &mut dyn FnMut(&PlacementOutcome),
) -> Result<(PlacementOutcome, Vec<Position>), PlacementError> {
    let all: Vec<usize> =
        (0..candidates.places.len()).filter(|&place| candidates.is_finite(place)).collect();
    let most = (FULL_TRIALS / many.poses()).max(LEAST_FULL).min(all.len());
    let mut known = Known {
        candidates,
        study,
        many: vec![None; candidates.places.len()],
        few: vec![None; candidates.places.len()],
        leaves: leaves_box(scenario, few, study, candidates),
        work: many.own_work() + few.own_work(),
    };
    let mut learn = |fully: &[usize], partly: &[usize], is_final: bool| {
        let (found, work) = compute(few, candidates, partly, &known.few, task)?;
        known.work += work;
        for (place, found) in found {
            known.few[place] = Some(found);
        }
        let (found, work) = compute(many, candidates, fully, &known.many, task)?;
        known.work += work;
        for (place, found) in found {
            known.many[place] = Some(found);
        }
        Ok::<_, Cancelled>((known.outcome(is_final), known.features()))
    };
    if most * many.poses() > AT_ONCE {
        let first = farthest_first(&candidates.places, FIRST_VERTICES);
        let fully = &first[..LEAST_FULL.min(first.len())];
        deliver(&learn(fully, &first, false)?.0);
        task.step(1, 3)?;
    }
    if most == all.len() {
        // Few poses then only say how good many are where those are not all.
        let partly = if study.is_whole { &[][..] } else { &all };
        return Ok(learn(&all, partly, true)?);
    }
    let (outcome, features) = learn(&[], &all, false)?;
    deliver(&outcome);
    task.step(2, 3)?;
    Ok(learn(&farthest_first(&features, most), &[], true)?)
}

/// Whether each place leaves the model's box at one of few poses or in a corner of the motion.
fn leaves_box(
    scenario: &Scenario,
    few: &ToolAt,
    study: &Study,
    candidates: &Candidates,
) -> Vec<bool> {
    let bounds = *scenario.environment.model.bounds();
    let crf = scenario.crf.as_ref();
    let tracker_from_crf = crf.map_or_else(Pose::identity, |crf| crf.tracker_from_crf);
    let ends = study.corners.iter().map(|pose| tracker_from_crf * pose);
    let poses: Vec<Pose> = few.tracker_from_tool().iter().copied().chain(ends).collect();
    candidates
        .sensors
        .par_iter()
        .map(|sensor| {
            let at = sensor.position_in_body;
            poses.iter().any(|pose| !bounds.contains(&(pose * at)))
        })
        .collect()
}

type Computed = (Vec<(usize, Found)>, Work);

/// What those of the places come to that are not known yet.
fn compute(
    tool: &ToolAt,
    candidates: &Candidates,
    places: &[usize],
    known: &[Option<Found>],
    task: &Task,
) -> Result<Computed, Cancelled> {
    let found: Result<Vec<(usize, Found, Work)>, Cancelled> = places
        .par_iter()
        .filter(|place| known[**place].is_none())
        .map_init(ToolBuffers::default, |buffers, &place| {
            let found = tool.found(buffers, &candidates.sensors[place], &task.cancel)?;
            Ok((place, found, buffers.take_work()))
        })
        .collect();
    let mut work = Work::default();
    let places = found?.into_iter().map(|(place, found, cost)| {
        work += cost;
        (place, found)
    });
    Ok((places.collect(), work))
}
