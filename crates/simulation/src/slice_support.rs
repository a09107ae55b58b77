//! Where in a slice the model is valid: beside a slice's values, done only where requested.

use super::run::{StudyError, check};
use super::scenario::Scenario;
use super::slice::each_row;
use super::slice_plan::SlicePlan;
use super::slice_quantity::Quantity;
use super::support::{is_supported, sensor_places};
use super::trial::Simulator;
use nalgebra::Point3;
use trackwright_field::validity::SensorPlace;
use trackwright_task::CancelToken;

/// Whether the field is supported (as [`ModelValidity::is_supported`] has it) at each point of the plan, in the
/// order of a slice's values: for the plan's imagined sensor, or for a quantity of the tool for every sensor of
/// tool and CRF with the tip at the point. `None` where the environment does not state it.
///
/// [`ModelValidity::is_supported`]: trackwright_field::validity::ModelValidity::is_supported
///
/// # Errors
/// [`StudyError::Cancelled`]; for a quantity of the tool [`StudyError::NoSensors`].
pub fn slice_support(
    scenario: &Scenario,
    quantity: Quantity,
    plan: &SlicePlan,
    cancel: &CancelToken,
) -> Result<Option<Vec<bool>>, StudyError> {
    let Some(validity) = scenario.environment.model_validity(scenario.outside) else {
        return Ok(None);
    };
    if !quantity.needs_tool() {
        let along_axis = |at| (at, Some(plan.sensor_axis));
        let of_row = |points: Vec<Point3<f64>>| {
            let sensors: Vec<SensorPlace> = points.into_iter().map(along_axis).collect();
            validity.is_supported(&sensors)
        };
        return each_row(plan, cancel, of_row).map(Some);
    }
    check(scenario)?;
    let simulator = Simulator::new(scenario);
    let tracker_from_crf = scenario.tracker_from_crf();
    let is_crf_supported = scenario
        .crf
        .as_ref()
        .is_none_or(|crf| is_supported(&validity, &crf.body, &crf.tracker_from_crf));
    let rotation = scenario.crf_from_tool.rotation;
    each_row(plan, cancel, |tips| {
        let tool_at = |tip: &Point3<f64>| {
            tracker_from_crf * simulator.crf_from_tool_with_tip_at(tip, &rotation)
        };
        let of_tip = |tip| sensor_places(&scenario.tool, tool_at(tip));
        let sensors: Vec<SensorPlace> = tips.iter().flat_map(of_tip).collect();
        let found = validity.is_supported(&sensors);
        let of_tool = found.chunks(scenario.tool.sensors.len());
        of_tool.map(|each| is_crf_supported && !each.contains(&false)).collect()
    })
    .map(Some)
}
