//! Places of a sensor: what is wanted, what one comes to, and what is known of all.

use super::best::BestPlace;
use super::depth::CoilDepth;
use super::rule::AxisRule;
use crate::body::Sensor;
use crate::motion::MotionError;
use crate::pose_rule::{PoseRule, corners};
use crate::preview::WHOLE_UP_TO;
use crate::run::StudyError;
use crate::scenario::Scenario;
use crate::work::Work;
use nalgebra::Vector3;
use std::collections::HashMap;
use std::sync::Arc;
use trackwright_geometry::pose::Pose;
use trackwright_geometry::spread::Position;
use trackwright_geometry::surface::{Surface, SurfacePoint};
use trackwright_task::Cancelled;

/// Poses that every vertex is computed at.
const FEW_POSES: usize = 64;

/// Poses that stand for a range of motion of more than [`WHOLE_UP_TO`].
const MANY_POSES: usize = 4096;

/// How far apart two places are whose sensors point a radian apart: about as far as sensors of a
/// tool are from each other. Chosen, not tuned, as is the next.
pub(super) const RADIAN_MM: f64 = 20.0;

/// How far apart two places are at one of which trials vary e times as much as at the other. Where
/// a sensor hardly adds to what the others determine, the tip swings far at some of the poses, few
/// poses miss that, and a place predicts little of its neighbour.
pub(super) const E_FOLD_MM: f64 = 20.0;

/// Whose sensor is moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PlacedBody {
    Tool,
    Crf,
}

/// What is requested: places for one sensor.
#[derive(Clone, Debug)]
pub struct PlacementPlan {
    pub body: PlacedBody,
    /// Its number in the body.
    pub sensor: usize,
    pub rule: AxisRule,
    /// Body frame.
    pub candidates: Arc<[SurfacePoint]>,
    /// How deep they are below the surface.
    pub depth: CoilDepth,
    /// Of the body, where it has a mesh: at the best place the coil fits in it.
    pub surface: Option<Arc<Surface>>,
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
    /// The expected tip RMS where it is known, else that of the room's model alone.
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
    /// The best of them as a study of its own; `None` before the last picture.
    pub best: Option<BestPlace>,
    /// Whether there is no best place because the coil fits at none.
    pub fits_nowhere: bool,
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

/// A tip RMS, and whether the sensor leaves the model's box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Found {
    pub tip_rms_mm: Option<f64>,
    pub is_outside: bool,
    /// Standard deviation of the squares of the tip errors, in parts of their mean.
    pub variation: f64,
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

    /// The smallest and the largest value.
    pub fn range_mm(&self) -> Option<[f64; 2]> {
        let values = self.places.iter().filter_map(Placement::shown_mm);
        values.fold(None, |range, v| {
            let [low, high] = range.unwrap_or([v; 2]);
            Some([low.min(v), high.max(v)])
        })
    }
}

/// The poses of the study, and few that stand for them.
pub(super) struct Study {
    pub trials: usize,
    pub many: PoseRule,
    /// Whether these are all poses of the study.
    pub is_whole: bool,
    pub few: PoseRule,
    /// `crf_from_tool` at the ends of the motion.
    pub corners: Vec<Pose>,
}

impl Study {
    pub fn new(scenario: &Scenario) -> Result<Self, MotionError> {
        let Some(grid) = scenario.motion_grid()? else {
            return Ok(Self {
                trials: 1,
                many: PoseRule::single(scenario),
                is_whole: true,
                few: PoseRule::single(scenario),
                corners: vec![scenario.crf_from_tool],
            });
        };
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
pub(super) struct Candidates {
    pub sensors: Vec<Sensor>,
    pub places: Vec<Position>,
    /// Of each candidate, which of them it is.
    pub place_of: Vec<usize>,
    /// Where the sensor is now.
    present: Position,
}

/// A sensor in one length.
fn position_of(sensor: &Sensor) -> Position {
    let axis = sensor.axis_in_body();
    let axis = axis.map_or_else(Vector3::zeros, |axis| axis.into_inner() * RADIAN_MM);
    let at = sensor.position_in_body;
    [at.x, at.y, at.z, axis.x, axis.y, axis.z, 0.0]
}

impl Candidates {
    pub fn new(sensor: &Sensor, plan: &PlacementPlan) -> Self {
        let nameless = Sensor { name: String::new(), ..sensor.clone() };
        let mut known: HashMap<[u64; 7], usize> = HashMap::new();
        let (mut sensors, mut places) = (Vec::new(), Vec::new());
        let place_of = plan
            .candidates
            .iter()
            .map(|candidate| {
                let placed = plan.rule.placed(&nameless, candidate);
                let place = position_of(&placed);
                *known.entry(place.map(f64::to_bits)).or_insert_with(|| {
                    sensors.push(placed);
                    places.push(place);
                    places.len() - 1
                })
            })
            .collect();
        Self { sensors, places, place_of, present: position_of(sensor) }
    }

    /// The place that is nearest to where the sensor is now.
    pub fn nearest_to_present(&self) -> Option<usize> {
        let away = |place: &Position| -> f64 {
            place.iter().zip(&self.present).map(|(a, b)| (a - b) * (a - b)).sum()
        };
        let finite = (0..self.places.len()).filter(|place| self.is_finite(*place));
        finite.min_by(|a, b| away(&self.places[*a]).total_cmp(&away(&self.places[*b])))
    }

    pub fn is_finite(&self, place: usize) -> bool {
        self.places[place].iter().all(|v| v.is_finite())
    }

    /// The outcome from what each place comes to.
    pub fn outcome(
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
            best: None,
            fits_nowhere: false,
            is_final,
            work: Work {
                placement_evaluations: work.study_evaluations,
                study_evaluations: 0,
                ..work
            },
        }
    }
}

pub(super) const NOWHERE: Placement =
    Placement { tip_rms_mm: None, basis: Basis::Full, expected: None, is_outside: true };

pub(super) fn difference_mm(a: &Found, b: &Found) -> f64 {
    match (a.tip_rms_mm, b.tip_rms_mm) {
        (Some(a), Some(b)) => (a - b).abs(),
        _ => f64::INFINITY,
    }
}
