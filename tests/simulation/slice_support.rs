//! Model validity on a slice.

use crate::support::studies::{cancelled, default_in_polynomials, slice_beyond_box};
use nalgebra::Vector3;
use trackwright_field::OutsidePolicy;
use trackwright_simulation::slice_support::*;
use trackwright_simulation::{Quantity, Scenario, SlicePlan, StudyError, simulate_pose};
use trackwright_task::CancelToken;

fn plan(scenario: &Scenario) -> SlicePlan {
    slice_beyond_box(&scenario.environment, [23, 19])
}

#[test]
fn tool_support_requires_valid_poses_of_all_sensors() {
    let scenario = default_in_polynomials();
    let (plan, support) = (plan(&scenario), scenario.environment.fit_validity.as_ref().unwrap());
    let cancel = CancelToken::default();
    let found = slice_support(&scenario, Quantity::TipErrorMm, &plan, &cancel).unwrap().unwrap();
    let crf = scenario.crf.as_ref().unwrap();
    for i in (0..found.len()).step_by(17) {
        let tip = plan.point_mm(i % plan.counts[0], i / plan.counts[0]);
        // The design's own tool, shifted until its tip is there.
        let mut moved = scenario.clone();
        let now =
            crf.tracker_from_crf * scenario.crf_from_tool * scenario.tool.judged_tip_in_body();
        let shift = crf.tracker_from_crf.rotation.inverse() * (tip - now);
        moved.crf_from_tool.translation.vector += shift;
        let detail = simulate_pose(&moved);
        let bodies = [Some(&detail.tool), detail.crf.as_ref()];
        let all = bodies.into_iter().flatten().flat_map(|body| &body.sensors);
        let is_supported = all.clone().all(|sensor| {
            let pose = &sensor.tracker_from_sensor;
            let at = pose.translation.vector.into();
            let axis = pose.rotation * Vector3::z_axis();
            support.at(&at, &axis, OutsidePolicy::Clamp).is_valid
        });
        assert_eq!(found[i], is_supported, "{tip}");
    }
    assert!(found.iter().any(|s| *s) && found.iter().any(|s| !s));
}

#[test]
fn a_cancelled_slice_has_no_support() {
    let scenario = default_in_polynomials();
    let plan = plan(&scenario);
    let cancel = cancelled().cancel;
    let stopped = slice_support(&scenario, Quantity::PositionErrorMm, &plan, &cancel);
    assert_eq!(stopped, Err(StudyError::Cancelled));
}
