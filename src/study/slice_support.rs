//! Where in a slice the model is valid: beside a slice's values, done only where it is asked.

use super::run::{StudyError, check};
use super::scenario::Scenario;
use super::slice_plan::SlicePlan;
use super::slice_quantity::Quantity;
use super::trial::Simulator;
use crate::field::Support;
use crate::geometry::pose::Pose;
use crate::task::CancelToken;
use crate::tracking::RigidBody;
use rayon::prelude::*;

/// Whether the field is supported ([`Support::is_supported`]) at each point of the plan, in the order
/// of a slice's values: for the plan's imagined sensor, or for a quantity of the tool for every sensor
/// of tool and CRF with the tip at the point. `None` where the environment does not say.
///
/// # Errors
/// [`StudyError::Cancelled`]; for a quantity of the tool [`StudyError::NoSensors`].
pub fn slice_support(
    scenario: &Scenario,
    quantity: Quantity,
    plan: &SlicePlan,
    cancel: &CancelToken,
) -> Result<Option<Vec<bool>>, StudyError> {
    let Some(support) = &scenario.environment.support else {
        return Ok(None);
    };
    if !quantity.needs_tool() {
        return each_point(plan, cancel, |u, v| {
            support.is_supported(&plan.point_mm(u, v), &plan.sensor_axis)
        });
    }
    check(scenario)?;
    let simulator = Simulator::new(scenario);
    let tracker_from_crf =
        scenario.crf.as_ref().map_or_else(Pose::identity, |crf| crf.tracker_from_crf);
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
}

fn is_supported(support: &Support, body: &RigidBody, tracker_from_body: &Pose) -> bool {
    body.sensors.iter().all(|sensor| {
        let position_mm = tracker_from_body * sensor.position_in_body;
        match sensor.axis_in_body() {
            Some(axis) => support.is_supported(&position_mm, &(tracker_from_body.rotation * axis)),
            None => support.is_marker_supported(&position_mm),
        }
    })
}

/// Rows of points in parallel.
fn each_point(
    plan: &SlicePlan,
    cancel: &CancelToken,
    is_supported: impl Fn(usize, usize) -> bool + Sync,
) -> Result<Option<Vec<bool>>, StudyError> {
    let [nu, nv] = plan.counts;
    let rows: Option<Vec<Vec<bool>>> = (0..nv)
        .into_par_iter()
        .map(|v| (!cancel.is_cancelled()).then(|| (0..nu).map(|u| is_supported(u, v)).collect()))
        .collect();
    Ok(Some(rows.ok_or(StudyError::Cancelled)?.concat()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::OutsidePolicy;
    use crate::geometry::bounds::Bounds;
    use crate::store;
    use crate::study::{SlicePlane, look};
    use nalgebra::{Unit, Vector3};

    fn scenario() -> Scenario {
        let world = store::open_builtin(store::DEFAULT_BUILTIN).unwrap();
        store::resolve(world.document.design(), &world.environment)
    }

    /// Larger than the box, so that some of it is outside.
    fn plan(scenario: &Scenario) -> SlicePlan {
        let own = scenario.environment.model.bounds();
        let out = Vector3::repeat(40.0);
        SlicePlan {
            plane: SlicePlane::Across {
                normal_axis: 1,
                position_mm: own.center_mm().y,
                bounds: Bounds { min_mm: own.min_mm - out, max_mm: own.max_mm + out },
            },
            sensor_axis: Unit::new_normalize(Vector3::new(0.3, -0.5, 0.8)),
            counts: [23, 19],
        }
    }

    fn supported(scenario: &Scenario, quantity: Quantity) -> Vec<bool> {
        let plan = plan(scenario);
        let found = slice_support(scenario, quantity, &plan, &CancelToken::default());
        found.unwrap().unwrap()
    }

    #[test]
    fn a_point_is_supported_where_the_support_says_so_of_the_imagined_sensor() {
        let scenario = scenario();
        let (plan, support) = (plan(&scenario), scenario.environment.support.as_ref().unwrap());
        let found = supported(&scenario, Quantity::PositionErrorMm);
        for (i, is_supported) in found.iter().enumerate() {
            let at = plan.point_mm(i % plan.counts[0], i / plan.counts[0]);
            let said = support.at(&at, &plan.sensor_axis, OutsidePolicy::Clamp);
            assert_eq!(*is_supported, said.is_supported, "{at}");
        }
        assert!(found.iter().any(|s| *s) && found.iter().any(|s| !s));
    }

    #[test]
    fn of_the_tool_every_sensor_is_asked_with_the_tip_at_the_point() {
        let scenario = scenario();
        let (plan, support) = (plan(&scenario), scenario.environment.support.as_ref().unwrap());
        let found = supported(&scenario, Quantity::TipErrorMm);
        let crf = scenario.crf.as_ref().unwrap();
        for i in (0..found.len()).step_by(17) {
            let tip = plan.point_mm(i % plan.counts[0], i / plan.counts[0]);
            // The design's own tool, shifted until its tip is there.
            let mut moved = scenario.clone();
            let now =
                crf.tracker_from_crf * scenario.crf_from_tool * scenario.tool.judged_tip_in_body();
            let shift = crf.tracker_from_crf.rotation.inverse() * (tip - now);
            moved.crf_from_tool.translation.vector += shift;
            let detail = look(&moved);
            let bodies = [Some(&detail.tool), detail.crf.as_ref()];
            let all = bodies.into_iter().flatten().flat_map(|body| &body.sensors);
            let is_supported = all.clone().all(|sensor| {
                let pose = &sensor.tracker_from_sensor;
                let at = pose.translation.vector.into();
                let axis = pose.rotation * Vector3::z_axis();
                support.at(&at, &axis, OutsidePolicy::Clamp).is_supported
            });
            assert_eq!(found[i], is_supported, "{tip}");
        }
        assert!(found.iter().any(|s| *s) && found.iter().any(|s| !s));
    }

    #[test]
    fn a_room_that_says_nothing_has_no_such_slice_and_a_cancelled_one_neither() {
        let mut scenario = scenario();
        let plan = plan(&scenario);
        let cancel = CancelToken::default();
        cancel.cancel();
        let stopped = slice_support(&scenario, Quantity::PositionErrorMm, &plan, &cancel);
        assert_eq!(stopped, Err(StudyError::Cancelled));
        std::sync::Arc::make_mut(&mut scenario.environment).support = None;
        let none = slice_support(&scenario, Quantity::TipErrorMm, &plan, &cancel);
        assert_eq!(none, Ok(None));
    }
}
