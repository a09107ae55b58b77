//! Error vectors on a lattice.

use crate::support::studies;
use nalgebra::{Unit, Vector3};
use trackwright_field::OutsidePolicy;
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::volume::Volume;
use trackwright_simulation::arrows::*;
use trackwright_simulation::{Scenario, StudyError, simulate_pose};
use trackwright_task::CancelToken;

fn built_in() -> Scenario {
    studies::built_in("shaver-on-head")
}

fn sample(scenario: &Scenario, plan: &ArrowPlan) -> ArrowOutcome {
    sample_arrows(scenario, plan, &CancelToken::default()).unwrap()
}

#[test]
fn each_arrow_is_the_error_at_its_own_place() {
    let scenario = built_in();
    let model = &scenario.environment.model;
    let axis = Unit::new_normalize(Vector3::new(0.3, -0.5, 0.8));
    let plan = ArrowPlan { sensor: ArrowSensor::Along(axis), counts: [5, 4, 3] };
    let outcome = sample(&scenario, &plan);
    assert_eq!(outcome.work.arrow_evaluations, 60);
    assert_eq!(outcome.arrows().count(), 60);
    let mut longest: f64 = 0.0;
    for (at, error) in outcome.arrows() {
        let expected = model.evaluate(&at, &axis, OutsidePolicy::Clamp);
        assert!(expected.is_inside);
        assert!((error - expected.error.position_mm).norm() < 1e-12);
        longest = longest.max(error.norm());
    }
    assert_eq!(outcome.max_mm, longest);
}

#[test]
fn tool_arrows_are_the_mean_error_of_its_sensors() {
    let scenario = built_in();
    let plan = ArrowPlan { sensor: ArrowSensor::OfTool, counts: [3, 1, 4] };
    let outcome = sample(&scenario, &plan);
    let turn = simulate_pose(&scenario).tool.tracker_from_body.rotation;
    let sensors = &scenario.tool.sensors;
    assert_eq!(outcome.work.coefficient_blends, sensors.len() as u64);
    for (at, arrow) in outcome.arrows() {
        let sum: Vector3<f64> = sensors
            .iter()
            .map(|s| {
                let axis = turn * s.axis_in_body().unwrap();
                let model = &scenario.environment.model;
                model.evaluate(&at, &axis, OutsidePolicy::Clamp).error.position_mm
            })
            .sum();
        assert!((arrow - sum / sensors.len() as f64).norm() < 1e-12);
    }
}

#[test]
fn an_arrow_lattice_is_clipped_to_the_volume() {
    let mut scenario = built_in();
    let own = *scenario.environment.model.bounds();
    let plan = ArrowPlan { sensor: ArrowSensor::Along(Vector3::x_axis()), counts: [2, 2, 2] };
    let beside =
        |from: Vector3<f64>| Bounds { min_mm: own.min_mm + from, max_mm: own.max_mm + from };
    let mut with = |volume: Bounds| {
        let environment = std::sync::Arc::make_mut(&mut scenario.environment);
        environment.volume = Some(trackwright_geometry::volume::Volume::Box(volume));
        sample(&scenario, &plan)
    };
    let clipped = with(beside(Vector3::new(50.0, 0.0, -20.0)));
    let bounds = clipped.bounds.unwrap();
    assert_eq!(bounds.min_mm.x, own.min_mm.x + 50.0);
    assert_eq!(bounds.max_mm.z, own.max_mm.z - 20.0);
    assert_eq!(clipped.arrows().next().unwrap().0, bounds.min_mm);
    let empty = with(beside(own.size_mm() * 2.0));
    assert_eq!((empty.bounds, empty.arrows().count()), (None, 0));
    assert_eq!(empty.work.arrow_evaluations, 0);
}

#[test]
fn only_arrows_within_the_dome_are_counted() {
    let mut scenario = built_in();
    let plan = ArrowPlan { sensor: ArrowSensor::Along(Vector3::x_axis()), counts: [9, 9, 9] };
    let all = sample(&scenario, &plan);
    let environment = std::sync::Arc::make_mut(&mut scenario.environment);
    environment.volume = Some(Volume::AuroraCompact);
    let compact = sample(&scenario, &plan);
    let lengths = compact.arrows().map(|(at, error)| {
        assert!(Volume::AuroraCompact.contains(&at), "{at}");
        error.norm()
    });
    assert_eq!(lengths.fold(0.0, f64::max), compact.max_mm);
    let count = compact.arrows().count();
    // 49 of 81 points of a square are in its circle, and the dome takes some of the lower ones.
    assert!((49 * 6..49 * 9).contains(&count), "{count}");
    assert!(compact.max_mm < all.max_mm);
}

#[test]
fn arrows_are_cancellable_and_independent_of_threads() {
    let scenario = built_in();
    let plan = ArrowPlan { sensor: ArrowSensor::OfTool, counts: [11, 10, 9] };
    let on = |threads| studies::on_threads(threads, || sample(&scenario, &plan));
    assert_eq!(on(1), on(3));
    let stopped = sample_arrows(&scenario, &plan, &studies::cancelled().cancel);
    assert_eq!(stopped, Err(StudyError::Cancelled));
}
