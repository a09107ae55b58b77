//! Each point of a lattice against the model itself, and lattices that are refused.

use crate::support::studies::in_polynomial_room;
use nalgebra::{Unit, Vector3};
use trackwright_field::samples::MapKind;
use trackwright_field::{DistortionModel, OutsidePolicy};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::pose::pose_from_parts;
use trackwright_geometry::rotation::{axis_rotation, exp_vector};
use trackwright_simulation::field_lattice::*;
use trackwright_task::Task;

fn model() -> DistortionModel {
    in_polynomial_room("shaver-on-head").environment.model.clone()
}

fn plan(model: &DistortionModel, displacement: Displacement) -> FieldPlan {
    let axis = Unit::new_normalize(Vector3::new(0.3, -0.5, 0.8));
    let sensor = FieldSensor::Along(axis);
    let bounds = *model.bounds();
    FieldPlan::spanning(
        bounds,
        [bounds.size_mm().x / 3.0, 90.0, 110.0],
        sensor,
        displacement,
        OutsidePolicy::Clamp,
    )
    .unwrap()
}

#[test]
fn each_point_has_the_models_own_error_x_fastest() {
    let model = model();
    let mut plan = plan(&model, Displacement::Error);
    assert_eq!(plan.counts[0], 4);
    for sensor in [plan.sensor, FieldSensor::MeanOfBasis] {
        plan.sensor = sensor;
        let found = sample_field(&model, &plan, &Task::default()).unwrap();
        let axes = match sensor {
            FieldSensor::Along(axis) => vec![axis],
            FieldSensor::MeanOfBasis => model.directions().directions().to_vec(),
        };
        let angles = found.angle_rad.as_ref().unwrap();
        let points: Vec<_> = found.points().collect();
        assert_eq!(points.len(), plan.counts.iter().product::<usize>());
        assert!(points[1].x > points[0].x && points[1].yz() == points[0].yz());
        for (i, at) in points.iter().enumerate() {
            let (mut shift, mut turn) = (Vector3::zeros(), Vector3::zeros());
            for axis in &axes {
                let error = model.evaluate(at, axis, OutsidePolicy::Clamp).error;
                shift += error.position_mm / axes.len() as f64;
                turn += error.rotation_rad / axes.len() as f64;
            }
            assert!((found.displacement_mm[i] - shift).norm() < 1e-12);
            assert!((angles[i] - turn.norm()).abs() < 1e-14);
        }
    }
}

#[test]
fn a_corrections_end_is_measured_where_it_begins() {
    let model = model();
    let plan = plan(&model, Displacement::Correction);
    let FieldSensor::Along(axis) = plan.sensor else {
        panic!("{plan:?}");
    };
    let found = sample_field(&model, &plan, &Task::default()).unwrap();
    let turn = exp_vector(&axis_rotation(&Vector3::z_axis(), &axis).vector_rad);
    let mut finite = 0;
    for (at, correction) in found.points().zip(&found.displacement_mm) {
        // The axis that reads so is not known here; that it hardly turns is.
        let nearly =
            model.distort(&pose_from_parts(at.coords + correction, turn), OutsidePolicy::Clamp);
        if correction.x.is_finite() {
            finite += 1;
            let off = (nearly.0.translation.vector - at.coords).norm();
            assert!(off < 0.2 * correction.norm().max(0.1), "{off} {correction}");
        }
    }
    assert!(finite > found.displacement_mm.len() / 2, "{finite}");
}

#[test]
fn outside_the_box_the_policy_decides() {
    let model = model();
    let mut plan = plan(&model, Displacement::Error);
    plan.bounds.max_mm.x += 100.0;
    let of = |outside| {
        let plan = FieldPlan { outside, ..plan };
        sample_field(&model, &plan, &Task::default()).unwrap()
    };
    let [clamped, beyond, rejected] =
        [OutsidePolicy::Clamp, OutsidePolicy::Extrapolate, OutsidePolicy::Reject].map(of);
    assert_eq!(clamped.is_outside, rejected.is_outside);
    let last = plan.counts[0] - 1;
    assert!(clamped.is_outside[last] && !clamped.is_outside[0]);
    assert!(rejected.displacement_mm[last].x.is_nan());
    assert_eq!(rejected.displacement_mm[0], clamped.displacement_mm[0]);
    assert_ne!(beyond.displacement_mm[last], clamped.displacement_mm[last]);
    let inside = rejected.is_outside.iter().filter(|is| !**is).count();
    assert_eq!(rejected.lengths_mm().len(), inside);
}

#[test]
fn steps_are_whole_and_no_longer_than_requested() {
    let spanning = |size: [f64; 3], spacing: f64| {
        FieldPlan::spanning(
            Bounds::from(([0.0; 3], size)),
            [spacing; 3],
            FieldSensor::MeanOfBasis,
            Displacement::Error,
            OutsidePolicy::Clamp,
        )
    };
    let plan = spanning([100.0, 95.0, 0.0], 10.0).unwrap();
    assert_eq!(plan.counts, [11, 11, 1]);
    assert_eq!(plan.step_mm(), [10.0, 9.5, 10.0]);
    // Thirty tenths are three whole steps, whatever rounding makes of them.
    assert_eq!(spanning([0.3, 1.0, 1.0], 0.1).unwrap().counts, [4, 11, 11]);
    let Err(FieldLatticeError::TooManyPoints { points, fitting_mm }) = spanning([500.0; 3], 1.0)
    else {
        panic!("125 million points were accepted");
    };
    assert_eq!(points, 501.0_f64.powi(3));
    assert!(spanning([500.0; 3], fitting_mm).is_ok(), "{fitting_mm}");
    assert!(spanning([1e300; 3], 1e-300).is_err());
}

#[test]
fn a_correction_map_has_no_error_at_true_positions() {
    let zero = DistortionModel::zero(*model().bounds(), MapKind::Correction);
    let plan = plan(&model(), Displacement::Error);
    assert_eq!(
        sample_field(&zero, &plan, &Task::default()),
        Err(FieldLatticeError::NeedsDistortionMap)
    );
    let plan = FieldPlan { displacement: Displacement::Correction, ..plan };
    let found = sample_field(&zero, &plan, &Task::default()).unwrap();
    assert!(found.displacement_mm.iter().all(|d| *d == Vector3::zeros()));
    assert_eq!(found.angle_rad, None);
}
