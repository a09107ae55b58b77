//! Fitted models: residuals, values, corrections, what lies outside, and too few samples.

use crate::support::close::{assert_all_golden, assert_golden};
use crate::support::data::own;
use crate::support::golden::{GOLDEN, count, list, number, numbers, pose, vector};
use nalgebra::Vector3;
use serde_json::Value;
use trackwright_field::fit::{Fit, FitMethod, FitSettings, Residuals, fit, residuals};
use trackwright_field::samples::{MapKind, MeasurementSet, SampleSet};
use trackwright_field::{DistortionModel, OutsidePolicy};
use trackwright_formats::measurements;
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::directions::DirectionSet;
use trackwright_geometry::pose::pose_to_array;

/// Errors in mm and radians below this are round-off of positions of some hundred mm.
const FLOOR: f64 = 1e-6;

fn measured(name: &str) -> MeasurementSet {
    let bytes = std::fs::read(own(&format!("room-a/{name}"))).unwrap();
    measurements::parse(&bytes).unwrap()
}

fn samples(name: &str, map: MapKind) -> SampleSet {
    measured(name).samples(map)
}

fn settings() -> FitSettings {
    FitSettings::new(2, DirectionSet::Fourteen)
}

fn fitted(settings: &FitSettings) -> Fit {
    fit(&samples("room-a-fit.csv", settings.map), settings, None).unwrap()
}

#[track_caller]
fn assert_residuals(found: &Residuals, expected: &Value) {
    assert_golden(
        "position RMS",
        found.position_rms_mm,
        number(&expected["position_rms_mm"]),
        FLOOR,
    );
    assert_golden(
        "angle RMS",
        found.angle_rms_rad.unwrap().to_degrees(),
        number(&expected["angle_rms_deg"]),
        FLOOR,
    );
}

#[track_caller]
fn assert_error(
    model: &DistortionModel,
    at: &Value,
    outside: OutsidePolicy,
    expected: &Value,
) -> bool {
    let at = pose(at);
    let found =
        model.evaluate(&at.translation.vector.into(), &(at.rotation * Vector3::z_axis()), outside);
    let expected = numbers::<6>(expected);
    let (p, r) = (found.error.position_mm, found.error.rotation_rad);
    assert_all_golden("position error", p.as_slice(), &expected[..3], FLOOR);
    assert_all_golden("rotation error", r.as_slice(), &expected[3..], FLOOR);
    found.is_inside
}

fn assert_box(found: &Bounds, expected: &Value) {
    assert_eq!(found.min_mm.coords, vector(&expected[0]));
    assert_eq!(found.max_mm.coords, vector(&expected[1]));
}

#[test]
fn per_direction_and_joint_fits_agree() {
    for case in list(&GOLDEN, "fits") {
        let method = match case["method"].as_str().unwrap() {
            "joint" => FitMethod::Joint,
            _ => FitMethod::PerDirection,
        };
        let fit = fitted(&FitSettings { method, ..settings() });
        assert_residuals(&fit.before, &case["before"]);
        assert_residuals(&fit.after, &case["after"]);
        assert_box(fit.model.bounds(), &case["box"]);
        let holdout = samples("room-a-holdout.csv", MapKind::Distortion);
        let zero = DistortionModel::zero(*fit.model.bounds(), MapKind::Distortion);
        assert_residuals(
            &residuals(&zero, &holdout, OutsidePolicy::Clamp),
            &case["holdout_before"],
        );
        assert_residuals(
            &residuals(&fit.model, &holdout, OutsidePolicy::Clamp),
            &case["holdout_after"],
        );
        for p in list(case, "poses") {
            let is_inside = assert_error(&fit.model, &p["pose"], OutsidePolicy::Clamp, &p["error"]);
            assert_eq!(is_inside, p["inside"].as_bool().unwrap());
        }
    }
}

#[test]
fn corrections_of_measured_poses_agree() {
    let case = &GOLDEN["correction_map"];
    let fit = fitted(&FitSettings { map: MapKind::Correction, ..settings() });
    assert_residuals(&fit.after, &case["after"]);
    for p in list(case, "poses") {
        let (found, _) = fit.model.correct(&pose(&p["measured"]), OutsidePolicy::Clamp);
        let expected = numbers::<7>(&p["corrected"]);
        let found = pose_to_array(&found);
        assert_all_golden("position", &found[..3], &expected[..3], 1.0);
        assert_all_golden("quaternion", &found[3..], &expected[3..], 1.0);
    }
}

#[test]
fn errors_outside_the_box_agree() {
    let model = fitted(&settings()).model;
    for case in list(&GOLDEN, "outside") {
        for (policy, key) in
            [(OutsidePolicy::Clamp, "clamp"), (OutsidePolicy::Extrapolate, "extrapolate")]
        {
            assert!(!assert_error(&model, &case["pose"], policy, &case[key]));
        }
    }
}

#[test]
fn a_single_orientation_agrees() {
    let case = &GOLDEN["one_direction"];
    let fit = fitted(&FitSettings::new(2, DirectionSet::One));
    assert_residuals(&fit.after, &case["after"]);
    for p in list(case, "poses") {
        assert_error(&fit.model, &p["pose"], OutsidePolicy::Clamp, &p["error"]);
    }
}

#[test]
fn too_few_samples_give_least_norm() {
    let case = &GOLDEN["least_norm"];
    let all = samples("room-a-fit.csv", MapKind::Distortion);
    let bounds = Bounds::around(all.samples.iter().map(|s| s.position_mm)).unwrap();
    assert_box(&bounds, &case["box"]);
    let few = SampleSet { samples: all.samples[..count(&case["samples"])].to_vec(), ..all };
    let settings = FitSettings::new(count(&case["order"]), DirectionSet::One);
    let fit = fit(&few, &settings, Some(bounds)).unwrap();
    assert!(fit.systems[0].is_underdetermined());
    assert_eq!(fit.systems[0].rank, few.samples.len());
    assert!(fit.after.position_rms_mm < 1e-12, "{:?}", fit.after);
    for p in list(case, "poses") {
        assert_error(&fit.model, &p["pose"], OutsidePolicy::Clamp, &p["error"]);
    }
}
