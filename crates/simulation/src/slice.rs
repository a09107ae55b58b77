//! A slice through the room: a quantity on a lattice in a plane.

use super::metric::Statistics;
use super::run::{StudyError, check};
use super::scenario::Scenario;
use super::slice_plan::{SlicePlan, SlicePlane, others};
use super::slice_quantity::Quantity;
use super::trial::{Simulator, TrialBuffers};
use super::work::Work;
use nalgebra::Point3;
use rayon::prelude::*;
use trackwright_field::samples::PoseError;
use trackwright_field::validity::{ModelValidity, SensorPlace};
use trackwright_field::{Batch, DistortionModel, OutsidePolicy};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::svd3::svd3;
use trackwright_task::CancelToken;

/// Rows of points that one core does before it looks whether anyone still wants them.
const BAND: usize = 16;

/// A sampled slice. Values run along the first of the plane's two axes fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct SliceOutcome {
    pub plan: SlicePlan,
    pub quantity: Quantity,
    /// In the quantity's unit. Where there is none it is NaN and counts as outside.
    pub values: Vec<f64>,
    /// Whether each point lies in the model's box; of the tip error, whether all sensors of tool
    /// and CRF do.
    pub is_inside: Vec<bool>,
    /// The box that a point of the plane is inside of or not; `None` for the tip error, of which each
    /// sensor decides.
    pub bounds: Option<Bounds>,
    /// Whether the model is valid at each point, see [`super::slice_support()`]; empty where
    /// that was not requested or the environment does not state it.
    pub is_supported: Vec<bool>,
    /// Largest value inside the box, 0 where nothing is inside.
    pub max: f64,
    /// 95th percentile of the values inside the box, 0 where nothing is inside: what a colour map
    /// spans, so that one bad corner of the room does not take all its colours.
    pub p95: f64,
    pub work: Work,
}

/// A value and whether it is of the inside of the box.
type Sampled = (f64, bool);

/// A quantity at each point of the plan; `None` where it needs an environment that states where its
/// model is valid, and this one does not. Quantities of the field are clamped to the box;
/// the tip error treats what is outside as the scenario's studies do.
///
/// # Errors
/// [`StudyError::Cancelled`]; for the tip error [`StudyError::NoSensors`].
pub fn sample_slice(
    scenario: &Scenario,
    quantity: Quantity,
    plan: &SlicePlan,
    cancel: &CancelToken,
) -> Result<Option<SliceOutcome>, StudyError> {
    let environment = &scenario.environment;
    let model = &environment.model;
    let sampled = match quantity {
        Quantity::PositionErrorMm => errors(model, plan, cancel, |e| e.position_mm.norm()),
        Quantity::OrientationErrorDeg => {
            errors(model, plan, cancel, |e| e.rotation_rad.norm().to_degrees())
        }
        Quantity::TipErrorMm => tip_errors(scenario, plan, cancel),
        Quantity::GradientMmPerMm => gradients(model, plan, cancel),
        Quantity::StdErrorMm | Quantity::SupportDistanceMm => {
            let Some(validity) = environment.model_validity(OutsidePolicy::Clamp) else {
                return Ok(None);
            };
            supports(quantity, &validity, model, plan, cancel)
        }
    };
    let (sampled, work) = sampled?;
    let bounds = (!quantity.needs_tool()).then(|| *model.bounds());
    Ok(Some(SliceOutcome { bounds, ..outcome(plan, quantity, sampled, work) }))
}

fn outcome(
    plan: &SlicePlan,
    quantity: Quantity,
    sampled: Vec<Sampled>,
    work: Work,
) -> SliceOutcome {
    let mut inside: Vec<f64> =
        sampled.iter().filter_map(|&(value, is_inside)| is_inside.then_some(value)).collect();
    let statistics = Statistics::of(&mut inside);
    let (values, is_inside) = sampled.into_iter().unzip();
    SliceOutcome {
        plan: *plan,
        quantity,
        values,
        is_inside,
        bounds: None,
        is_supported: Vec::new(),
        max: statistics.map_or(0.0, |s| s.max()),
        p95: statistics.map_or(0.0, |s| s.p95()),
        work,
    }
}

type Rows = Result<(Vec<Sampled>, Work), StudyError>;

/// What is measured of the error at each point; by sum factorisation across the tracker's axes.
fn errors(
    model: &DistortionModel,
    plan: &SlicePlan,
    cancel: &CancelToken,
    measure: impl Fn(&PoseError) -> f64 + Sync,
) -> Rows {
    let [nu, nv] = plan.counts;
    let at_axis = model.at_axis(&plan.sensor_axis);
    let outside = OutsidePolicy::Clamp;
    let of_band = |(batch, evaluations): &mut (Batch, Vec<_>), rows: std::ops::Range<usize>| {
        let points = |v: usize| (0..nu).map(move |u| plan.point_mm(u, v));
        // Where each point of a band is found: of a lattice, whose last axis is the plane's second,
        // its rows are columns.
        let len = rows.len();
        let is_across = match plan.plane {
            SlicePlane::Across { normal_axis, position_mm, .. } => {
                let [axis_u, axis_v] = others(normal_axis);
                let us: Vec<f64> = points(0).map(|p| p[axis_u]).collect();
                let vs: Vec<f64> = rows.map(|v| plan.point_mm(0, v)[axis_v]).collect();
                let across = [position_mm];
                let mut coordinates = [&across[..]; 3];
                (coordinates[axis_u], coordinates[axis_v]) = (&us, &vs);
                at_axis.evaluate_lattice(coordinates, outside, evaluations);
                true
            }
            SlicePlane::Free { .. } => {
                let positions_mm: Vec<_> = rows.flat_map(points).collect();
                at_axis.evaluate_all(batch, &positions_mm, outside, evaluations);
                false
            }
        };
        let places = (0..len).flat_map(|v| (0..nu).map(move |u| (u, v)));
        let sampled = places.map(|(u, v)| {
            let place = if is_across { u * len + v } else { v * nu + u };
            let at = &evaluations[place];
            (measure(&at.error), at.is_inside)
        });
        sampled.collect()
    };
    let bands: Vec<_> = (0..nv).step_by(BAND).map(|start| start..(start + BAND).min(nv)).collect();
    let bands: Option<Vec<Vec<Sampled>>> = bands
        .into_par_iter()
        .map_init(Default::default, |buffers, rows| {
            (!cancel.is_cancelled()).then(|| of_band(buffers, rows))
        })
        .collect();
    let work = Work {
        slice_evaluations: plan.points() as u64,
        coefficient_blends: 1,
        blended_evaluations: plan.points() as u64,
        ..Work::default()
    };
    Ok((bands.ok_or(StudyError::Cancelled)?.concat(), work))
}

/// The study's trial with the tip at each point.
fn tip_errors(scenario: &Scenario, plan: &SlicePlan, cancel: &CancelToken) -> Rows {
    check(scenario)?;
    let simulator = Simulator::new(scenario);
    let rotation = scenario.crf_from_tool.rotation;
    let [nu, nv] = plan.counts;
    let rows: Option<Vec<(Vec<Sampled>, Work)>> = (0..nv)
        .into_par_iter()
        .map_init(TrialBuffers::default, |buffers, v| {
            if cancel.is_cancelled() {
                return None;
            }
            let poses: Vec<_> = (0..nu)
                .map(|u| simulator.crf_from_tool_with_tip_at(&plan.point_mm(u, v), &rotation))
                .collect();
            let trials = simulator.trials(buffers, &poses, nu);
            let sampled = trials.iter().map(|t| (t.tip_error_mm, t.outside == 0));
            Some((sampled.collect(), buffers.take_work()))
        })
        .collect();
    let (sampled, cost): (Vec<_>, Work) = rows.ok_or(StudyError::Cancelled)?.into_iter().unzip();
    let (sampled, work) = (sampled.concat(), simulator.own_work() + cost);
    let work = Work { slice_evaluations: work.study_evaluations, study_evaluations: 0, ..work };
    Ok((sampled, work))
}

fn gradients(model: &DistortionModel, plan: &SlicePlan, cancel: &CancelToken) -> Rows {
    let at_axis = model.at_axis(&plan.sensor_axis);
    let steepest = |point: Point3<f64>| {
        // On the face, and not a rounding beyond it, where the slope across is that of a field
        // that is clamped: none.
        let at = model.bounds().clamp(&point);
        let there = at_axis.evaluate_with_jacobian(&at, OutsidePolicy::Clamp);
        let slopes = there.by_position.fixed_rows::<3>(0).into_owned();
        let is_inside = model.bounds().contains(&point);
        (svd3(&slopes).singular_values[0], is_inside)
    };
    let sampled = each_row(plan, cancel, |points| points.into_iter().map(steepest).collect())?;
    let work = Work {
        slice_evaluations: plan.points() as u64,
        coefficient_blends: 1,
        blended_evaluations: plan.points() as u64,
        ..Work::default()
    };
    Ok((sampled, work))
}

fn supports(
    quantity: Quantity,
    validity: &ModelValidity,
    model: &DistortionModel,
    plan: &SlicePlan,
    cancel: &CancelToken,
) -> Rows {
    let sampled = each_row(plan, cancel, |points| {
        let along_axis = |at| (at, Some(plan.sensor_axis));
        let sensors: Vec<SensorPlace> = points.iter().copied().map(along_axis).collect();
        let values: Vec<f64> = match quantity {
            Quantity::StdErrorMm => {
                validity.at(&sensors).iter().map(|at| at.position_error_mm).collect()
            }
            _ => sensors.iter().map(|sensor| validity.distance_mm(sensor)).collect(),
        };
        let each = points.iter().zip(values).map(|(point, value)| match value.is_finite() {
            true => (value, model.bounds().contains(point)),
            false => (f64::NAN, false),
        });
        each.collect()
    })?;
    let work = Work { slice_evaluations: plan.points() as u64, ..Work::default() };
    Ok((sampled, work))
}

/// Rows of points in parallel.
pub(super) fn each_row<T: Clone + Send>(
    plan: &SlicePlan,
    cancel: &CancelToken,
    sample: impl Fn(Vec<Point3<f64>>) -> Vec<T> + Sync,
) -> Result<Vec<T>, StudyError> {
    let [nu, nv] = plan.counts;
    let points = |v: usize| (0..nu).map(|u| plan.point_mm(u, v)).collect();
    let rows: Option<Vec<Vec<T>>> = (0..nv)
        .into_par_iter()
        .map(|v| (!cancel.is_cancelled()).then(|| sample(points(v))))
        .collect();
    Ok(rows.ok_or(StudyError::Cancelled)?.concat())
}
