//! Slices against closed forms, finite differences and the study's own trial.

use crate::support::studies::{
    body, built_in, cancelled, on_threads, one_direction, room, tool_alone,
};
use nalgebra::{Matrix3, Point3, Unit, Vector3};
use trackwright_field::OutsidePolicy;
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::pose::Pose;
use trackwright_simulation::slice::*;
use trackwright_simulation::{
    Quantity, Scenario, SlicePlan, SlicePlane, StudyError, simulate_pose,
};
use trackwright_task::CancelToken;

/// A room whose error along x is the position's x in the unit cube, and whose rotation is a
/// hundredth of that, in radians.
fn sloping_room() -> Scenario {
    let coefficients =
        (0..8).map(|i| f64::from(i / 4)).map(|x| [x, 0.0, 0.0, 0.0, 0.01 * x, 0.0]).collect();
    let room = room(one_direction(1, unit_cube(), coefficients));
    tool_alone(room, body(Vec::new(), None), Pose::identity())
}

/// 100 mm wide.
fn unit_cube() -> Bounds {
    Bounds::from(([0.0; 3], [100.0; 3]))
}

fn plan(position_mm: f64) -> SlicePlan {
    SlicePlan {
        plane: SlicePlane::Across { normal_axis: 2, position_mm, bounds: unit_cube() },
        sensor_axis: Vector3::z_axis(),
        counts: [101, 3],
    }
}

fn slice(scenario: &Scenario, quantity: Quantity, plan: &SlicePlan) -> SliceOutcome {
    sample_slice(scenario, quantity, plan, &CancelToken::default()).unwrap().unwrap()
}

#[test]
fn a_slice_costs_its_points_and_holds_their_errors() {
    let position = slice(&sloping_room(), Quantity::PositionErrorMm, &plan(50.0));
    assert_eq!(position.work.slice_evaluations, 303);
    assert!((position.values[25] - 0.25).abs() < 1e-15);
    assert!((position.max - 1.0).abs() < 1e-15);
    assert!((position.p95 - 0.95).abs() < 0.01);
    let turned = slice(&sloping_room(), Quantity::OrientationErrorDeg, &plan(50.0));
    assert!((turned.values[25] - 0.0025_f64.to_degrees()).abs() < 1e-15);
    let steep = slice(&sloping_room(), Quantity::GradientMmPerMm, &plan(50.0));
    assert!(steep.values.iter().all(|v| (v - 0.01).abs() < 1e-15));
}

#[test]
fn outside_the_box_a_slice_has_values_and_no_range() {
    let slice = slice(&sloping_room(), Quantity::PositionErrorMm, &plan(150.0));
    assert!(slice.is_inside.iter().all(|inside| !inside));
    assert_eq!((slice.max, slice.p95), (0.0, 0.0));
}

#[test]
fn a_cancelled_slice_has_no_values() {
    for quantity in Quantity::ALL {
        let scenario = built_in("pointer-on-head");
        let slice = sample_slice(&scenario, quantity, &plan(50.0), &cancelled().cancel);
        assert_eq!(slice, Err(StudyError::Cancelled), "{quantity:?}");
    }
}

#[test]
fn axis_aligned_free_planes_equal_planes_across() {
    let scenario = built_in("pointer-on-head");
    let bounds = *scenario.environment.model.bounds();
    let across = SlicePlan {
        plane: SlicePlane::Across { normal_axis: 1, position_mm: 20.0, bounds },
        sensor_axis: Unit::new_normalize(Vector3::new(0.3, -0.5, 0.8)),
        counts: [21, 37],
    };
    let free = SlicePlan {
        plane: SlicePlane::Free {
            origin_mm: Point3::new(bounds.min_mm.x, 20.0, bounds.min_mm.z),
            axes: [Vector3::x_axis(), Vector3::z_axis()],
            sizes_mm: [bounds.size_mm().x, bounds.size_mm().z],
        },
        ..across
    };
    for quantity in Quantity::ALL {
        let (a, b) = (slice(&scenario, quantity, &across), slice(&scenario, quantity, &free));
        for (a, b) in a.values.iter().zip(&b.values) {
            // The same points but for rounding, the same sums in another order.
            assert!((a - b).abs() < 1e-10, "{quantity:?}: {a} {b}");
        }
        assert_eq!(a.is_inside, b.is_inside, "{quantity:?}");
    }
}

#[test]
fn tip_error_at_the_designs_tip_is_that_of_its_pose() {
    for name in ["pointer-on-head", "shaver-on-head", "endoscope"] {
        let with_crf = built_in(name);
        let without = Scenario {
            crf: None,
            crf_from_tool: simulate_pose(&with_crf).tool.tracker_from_body,
            ..with_crf.clone()
        };
        for scenario in [with_crf, without] {
            let pose = simulate_pose(&scenario);
            let tip = pose.tool.tracker_from_body * scenario.tool.judged_tip_in_body();
            let plan = SlicePlan {
                plane: SlicePlane::Free {
                    origin_mm: tip,
                    axes: [Vector3::x_axis(), Vector3::y_axis()],
                    sizes_mm: [40.0, 10.0],
                },
                sensor_axis: Vector3::z_axis(),
                counts: [20, 2],
            };
            let slice = slice(&scenario, Quantity::TipErrorMm, &plan);
            let expected = pose.trial.tip_error_mm;
            assert!(expected > 0.05);
            // The tip goes to the tracker frame and back: some units in the last place of 500 mm.
            let off = (slice.values[0] - expected).abs();
            assert!(off < 1e-12, "{name}: {off:e} of {expected}");
            let sensors = scenario.tool.sensors.len() as u64;
            let crf = scenario.crf.as_ref().map_or(0, |c| c.body.sensors.len()) as u64;
            // The lattice, and the CRF and the tool once where the design has them.
            assert_eq!(slice.work.slice_evaluations, 41 * sensors + crf);
            assert_eq!(slice.work.frame_fits, 41 + u64::from(crf > 0));
        }
    }
}

#[test]
fn gradients_agree_with_finite_differences() {
    let scenario = built_in("pointer-on-head");
    let model = &scenario.environment.model;
    let plan = SlicePlan {
        plane: SlicePlane::facing(
            model.bounds(),
            &model.bounds().center_mm(),
            &Unit::new_normalize(Vector3::new(0.2, 0.4, -0.6)),
            &Vector3::z(),
        ),
        sensor_axis: Unit::new_normalize(Vector3::new(0.3, -0.5, 0.8)),
        counts: [9, 8],
    };
    let slice = slice(&scenario, Quantity::GradientMmPerMm, &plan);
    let error = |p: Point3<f64>| {
        let at = model.evaluate(&p, &plan.sensor_axis, OutsidePolicy::Clamp);
        at.error.position_mm
    };
    // Central differences over 1 mm of a polynomial over hundreds: third derivatives are some
    // 1e-6 / mm², and round-off of 1e-14 mm is negligible.
    let (h, mut compared) = (0.5, 0);
    for v in 0..8 {
        for u in 0..9 {
            let (place, p) = (v * 9 + u, plan.point_mm(u, v));
            let is_free = |k: usize| {
                let step = Vector3::ith(k, h);
                model.bounds().contains(&(p + step)) && model.bounds().contains(&(p - step))
            };
            if !(0..3).all(is_free) {
                continue;
            }
            compared += 1;
            let columns = [0, 1, 2].map(|k| {
                let step = Vector3::ith(k, h);
                (error(p + step) - error(p - step)) / (2.0 * h)
            });
            let largest = Matrix3::from_columns(&columns).singular_values().max();
            let found = slice.values[place];
            assert!((found - largest).abs() < 1e-5, "{found} {largest}");
            assert!(slice.is_inside[place]);
        }
    }
    assert!(compared > 20);
}

#[test]
fn a_slice_does_not_hang_on_the_number_of_threads() {
    let scenario = built_in("shaver-on-head");
    let plan = SlicePlan {
        plane: SlicePlane::Across {
            normal_axis: 0,
            position_mm: 0.0,
            bounds: *scenario.environment.model.bounds(),
        },
        sensor_axis: Vector3::x_axis(),
        counts: [40, 33],
    };
    let bits = |quantity| {
        let slice = slice(&scenario, quantity, &plan);
        let bits: Vec<_> = slice.values.iter().map(|v| v.to_bits()).collect();
        (bits, slice.work)
    };
    let on = |threads| on_threads(threads, || Quantity::ALL.map(bits));
    assert_eq!(on(1), on(3));
}
