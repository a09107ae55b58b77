//! Position error vectors on a lattice through the room: what arrows are drawn from.

use super::field_lattice::MeanErrors;
use super::metric::Statistics;
use super::run::StudyError;
use super::scenario::Scenario;
use super::work::Work;
use nalgebra::{Point3, Unit, Vector3};
use rayon::prelude::*;
use trackwright_field::{AxisModel, OutsidePolicy};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::volume::Volume;
use trackwright_task::CancelToken;

/// Layers across x that one core does before it looks whether anyone still wants them: a lattice of
/// 22³ points is shared out into 11 parts.
const SLAB: usize = 2;

/// Which sensor is imagined at each point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ArrowSensor {
    /// One along this axis, tracker frame.
    Along(Unit<Vector3<f64>>),
    /// All of the tool's, each turned as the design's own pose has it: the arrow is the mean of
    /// their errors, by which the tool's centroid would be off were they all at the point.
    OfTool,
}

/// Where to sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArrowPlan {
    pub sensor: ArrowSensor,
    /// Points along x, y and z; one alone is in the middle.
    pub counts: [usize; 3],
}

/// Sampled error vectors, x slowest and z fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct ArrowOutcome {
    pub plan: ArrowPlan,
    /// What the lattice spans: the model's box, as far as that around where the tracker promises to
    /// measure; `None` where the two have nothing in common, and then there are no arrows.
    pub bounds: Option<Bounds>,
    /// Where the tracker promises to measure: beyond it there is no arrow.
    pub volume: Option<Volume>,
    /// Measured minus true position at every point of the lattice, tracker frame, mm.
    pub errors_mm: Vec<Vector3<f64>>,
    /// Length of the longest.
    pub max_mm: f64,
    /// 95th percentile of the lengths: what a scale of lengths or colours spans.
    pub p95_mm: f64,
    pub work: Work,
}

impl ArrowOutcome {
    /// Where each arrow within the volume begins, tracker frame, mm, with the arrow.
    pub fn arrows(&self) -> impl Iterator<Item = (Point3<f64>, Vector3<f64>)> {
        let [_, ny, nz] = self.plan.counts;
        let coordinates = self.bounds.map(|bounds| coordinates_mm(&bounds, self.plan.counts));
        let errors = self.errors_mm.iter().enumerate();
        let arrows = coordinates.into_iter().flat_map(move |[xs, ys, zs]| {
            errors.clone().map(move |(i, error)| {
                let at = Point3::new(xs[i / (ny * nz)], ys[i / nz % ny], zs[i % nz]);
                (at, *error)
            })
        });
        arrows.filter(|(at, _)| self.volume.is_none_or(|volume| volume.contains(at)))
    }
}

/// The error vectors of a plan, by sum factorisation.
///
/// # Errors
/// [`StudyError::Cancelled`]; [`StudyError::NoSensors`] where the tool's sensors are requested and
/// it has none.
pub fn sample_arrows(
    scenario: &Scenario,
    plan: &ArrowPlan,
    cancel: &CancelToken,
) -> Result<ArrowOutcome, StudyError> {
    let environment = &scenario.environment;
    let axes = match plan.sensor {
        ArrowSensor::Along(axis) => vec![Some(axis)],
        ArrowSensor::OfTool => axes_of_tool(scenario)?,
    };
    let models: Vec<AxisModel> =
        axes.iter().map(|axis| environment.model.at_axis_or_mean(axis.as_ref())).collect();
    let own = *environment.model.bounds();
    let bounds = match environment.volume {
        Some(volume) => own.intersection(&volume.bounds()),
        None => Some(own),
    };
    let errors_mm = match &bounds {
        Some(bounds) => mean_errors(&models, coordinates_mm(bounds, plan.counts), cancel)?,
        None => Vec::new(),
    };
    let evaluations = (errors_mm.len() * models.len()) as u64;
    let mut outcome = ArrowOutcome {
        plan: *plan,
        bounds,
        volume: environment.volume,
        errors_mm,
        max_mm: 0.0,
        p95_mm: 0.0,
        work: Work {
            arrow_evaluations: evaluations,
            coefficient_blends: models.len() as u64,
            blended_evaluations: evaluations,
            ..Work::default()
        },
    };
    let mut lengths: Vec<f64> = outcome.arrows().map(|(_, error)| error.norm()).collect();
    if let Some(statistics) = Statistics::of(&mut lengths) {
        outcome.max_mm = statistics.max();
        outcome.p95_mm = statistics.p95();
    }
    Ok(outcome)
}

/// Axes of the tool's sensors at the design's own pose, tracker frame; none of markers.
fn axes_of_tool(scenario: &Scenario) -> Result<Vec<Option<Unit<Vector3<f64>>>>, StudyError> {
    let tool = &scenario.tool;
    if tool.sensors.is_empty() {
        return Err(StudyError::NoSensors { body: tool.name.clone() });
    }
    let tracker_from_crf = scenario.tracker_from_crf();
    let turn = (tracker_from_crf * scenario.crf_from_tool).rotation;
    Ok(tool.sensors.iter().map(|s| s.axis_in_body().map(|axis| turn * axis)).collect())
}

fn mean_errors(
    models: &[AxisModel],
    [xs, ys, zs]: [Vec<f64>; 3],
    cancel: &CancelToken,
) -> Result<Vec<Vector3<f64>>, StudyError> {
    let slabs: Option<Vec<Vec<Vector3<f64>>>> = xs
        .par_chunks(SLAB)
        .map_init(MeanErrors::default, |buffers, xs| {
            let means = buffers.of(models, [xs, &ys, &zs], OutsidePolicy::Clamp, cancel)?;
            Some(means.iter().map(|at| at.error.position_mm).collect())
        })
        .collect();
    Ok(slabs.ok_or(StudyError::Cancelled)?.concat())
}

/// Coordinates of a lattice over a box, along each axis.
pub(super) fn coordinates_mm(bounds: &Bounds, counts: [usize; 3]) -> [Vec<f64>; 3] {
    [0, 1, 2].map(|k| {
        let (min, max) = (bounds.min_mm[k], bounds.max_mm[k]);
        match counts[k] {
            1 => vec![bounds.center_mm()[k]],
            count => (0..count)
                .map(|i| match i + 1 == count {
                    true => max,
                    false => min + (max - min) * i as f64 / (count - 1) as f64,
                })
                .collect(),
        }
    })
}
