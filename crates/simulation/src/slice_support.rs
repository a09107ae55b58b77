//! Where in a slice the model is valid: beside a slice's values, done only where requested.

use super::run::{StudyError, check};
use super::scenario::Scenario;
use super::slice::each_point;
use super::slice_plan::SlicePlan;
use super::slice_quantity::Quantity;
use super::support::is_supported;
use super::trial::Simulator;
use trackwright_task::CancelToken;

/// Whether the field is supported ([FitValidity::is_valid`]) at each point of the plan, in the order
/// of a slice's values: for the plan's imagined sensor, or for a quantity of the tool for every sensor
/// of tool and CRF with the tip at the point. `None` where the environment does not state it.
///
/// # Errors
/// [`StudyError::Cancelled`]; for a quantity of the tool [`StudyError::NoSensors`].
pub fn slice_support(
    scenario: &Scenario,
    quantity: Quantity,
    plan: &SlicePlan,
    cancel: &CancelToken,
) -> Result<Option<Vec<bool>>, StudyError> {
    let Some(support) = &scenario.environment.fit_validity else {
        return Ok(None);
    };
    if !quantity.needs_tool() {
        let is_valid = |u, v| support.is_valid(&plan.point_mm(u, v), &plan.sensor_axis);
        return each_point(plan, cancel, is_valid).map(Some);
    }
    check(scenario)?;
    let simulator = Simulator::new(scenario);
    let tracker_from_crf = scenario.tracker_from_crf();
    let is_crf_supported = scenario
        .crf
        .as_ref()
        .is_none_or(|crf| is_supported(support, &crf.body, &crf.tracker_from_crf));
    let rotation = scenario.crf_from_tool.rotation;
    each_point(plan, cancel, |u, v| {
        let tip = plan.point_mm(u, v);
        let tool = tracker_from_crf * simulator.crf_from_tool_with_tip_at(&tip, &rotation);
        is_crf_supported && is_supported(support, &scenario.tool, &tool)
    })
    .map(Some)
}
