//! Fits recover what made their samples, and report what they cannot.

use super::support::{bounds, exact, model, places, unlike};
use crate::support::studies::on_threads;
use nalgebra::{Point3, UnitQuaternion, Vector3};
use proptest::prelude::*;
use std::sync::{Arc, Mutex};
use trackwright_calibration::registration::register;
use trackwright_field::fit::{
    Factored, FitError, FitMethod, FitSettings, factor, fit, fit_with, residuals,
};
use trackwright_field::samples::{PoseError, SampleSet};
use trackwright_field::{DistortionModel, OutsidePolicy};
use trackwright_geometry::directions::{DirectionSet, Weighting};
use trackwright_geometry::pose::pose_from_parts;
use trackwright_task::{CancelToken, Cancelled, Task};

/// A model with unlike coefficients everywhere.
fn truth(order: usize, directions: DirectionSet, weighting: Weighting) -> DistortionModel {
    model(order, directions, weighting, unlike)
}

fn samples_of(model: &DistortionModel, count: usize) -> SampleSet {
    exact(model, places(count, &bounds()))
}

#[test]
fn a_joint_fit_recovers_the_model() {
    for weighting in [Weighting::Area, Weighting::Gnomonic] {
        let truth = truth(2, DirectionSet::Six, weighting);
        let set = samples_of(&truth, 3000);
        let settings = FitSettings {
            method: FitMethod::Joint,
            weighting,
            ..FitSettings::new(2, DirectionSet::Six)
        };
        let found = fit(&set, &settings, Some(bounds())).unwrap();
        // Values are of order 1, the condition below 1e4: 1e-10 leaves two digits to spare.
        assert!(found.after.position_rms_mm < 1e-10, "{:?}", found.after);
        assert_eq!(found.systems[0].rank, 6 * 27);
        for (f, t) in found.model.coefficients().iter().zip(truth.coefficients()) {
            assert!((0..6).all(|k| (f[k] - t[k]).abs() < 1e-9));
        }
    }
}

#[test]
fn each_method_recovers_positions_alone() {
    let truth = truth(3, DirectionSet::One, Weighting::Area);
    let set = samples_of(&truth, 500);
    for method in [FitMethod::PerDirection, FitMethod::Joint] {
        let settings = FitSettings { method, ..FitSettings::new(3, DirectionSet::One) };
        let found = fit(&set, &settings, Some(bounds())).unwrap();
        assert!(found.after.position_rms_mm < 1e-11, "{:?}", found.after);
    }
}

#[test]
fn the_joint_fit_never_leaves_more() {
    let truth = truth(4, DirectionSet::FortyTwo, Weighting::Area);
    let set = samples_of(&truth, 2000);
    let rms = |method| {
        let settings = FitSettings { method, ..FitSettings::new(2, DirectionSet::Fourteen) };
        fit(&set, &settings, None).unwrap().after.position_rms_mm
    };
    assert!(rms(FitMethod::Joint) <= rms(FitMethod::PerDirection));
}

#[test]
fn order_zero_corrects_nothing() {
    let set = samples_of(&truth(2, DirectionSet::Six, Weighting::Area), 50);
    let found = fit(&set, &FitSettings::new(0, DirectionSet::One), None).unwrap();
    assert_eq!(found.before, found.after);
    assert!(found.systems.is_empty());
}

#[test]
fn more_ridge_leaves_smaller_coefficients() {
    let set = samples_of(&truth(3, DirectionSet::Six, Weighting::Area), 2000);
    let at = |ridge| {
        let settings = FitSettings { ridge, ..FitSettings::new(3, DirectionSet::Six) };
        let found = fit(&set, &settings, Some(bounds())).unwrap();
        let size: f64 = found.model.coefficients().iter().flatten().map(|c| c * c).sum();
        (residuals(&found.model, &set, OutsidePolicy::Clamp).position_rms_mm, size)
    };
    let (none, some, much) = (at(0.0), at(0.01), at(0.3));
    assert!(none.0 < some.0 && some.0 < much.0);
    assert!(none.1 > some.1 && some.1 > much.1);
}

#[test]
fn an_orientation_without_samples_is_reported() {
    let mut set = samples_of(&truth(1, DirectionSet::Six, Weighting::Area), 400);
    set.samples.retain(|s| s.axis.z > 0.0);
    let found = fit(&set, &FitSettings::new(1, DirectionSet::Six), None).unwrap();
    let empty: Vec<_> = found.systems.iter().filter(|s| s.samples == 0).collect();
    assert_eq!(empty.len(), 1);
    assert_eq!(empty[0].rank, 0);
    assert!(empty[0].is_underdetermined());
}

#[test]
fn what_cannot_be_fitted_is_refused_with_a_reason() {
    let set = samples_of(&truth(1, DirectionSet::One, Weighting::Area), 20);
    let settings = FitSettings::new(1, DirectionSet::Six);
    let none = SampleSet { samples: Vec::new(), ..set.clone() };
    assert_eq!(fit(&none, &settings, None), Err(FitError::NoSamples));
    let flat = SampleSet { has_rotations: false, ..set.clone() };
    assert_eq!(fit(&flat, &settings, None), Err(FitError::NeedsOneDirection(6)));
    let ridge = FitSettings { ridge: -1.0, ..settings };
    assert_eq!(fit(&set, &ridge, None), Err(FitError::Ridge(-1.0)));
}

#[test]
fn systems_of_parts_merge_to_the_fit_of_all() {
    let noisy = truth(4, DirectionSet::FortyTwo, Weighting::Area);
    let set = samples_of(&noisy, 900);
    for method in [FitMethod::PerDirection, FitMethod::Joint] {
        let settings =
            FitSettings { method, ridge: 1e-3, ..FitSettings::new(1, DirectionSet::Fourteen) };
        let parts: Vec<_> = set
            .samples
            .chunks(300)
            .map(|samples| {
                let part = SampleSet { samples: samples.to_vec(), ..set.clone() };
                factor(&part, &settings, Some(bounds()), &Task::default()).unwrap()
            })
            .collect();
        let merged = Factored::merged(&parts).unwrap();
        assert_eq!(merged.samples, 900);
        let whole = fit(&set, &settings, Some(bounds())).unwrap();
        for found in [
            merged.solve(settings.rcond, settings.ridge).unwrap(),
            merged.decompose().unwrap().solve(settings.rcond, settings.ridge).unwrap(),
        ] {
            let (f, w) = (found.model.coefficients(), whole.model.coefficients());
            // The condition is below 100 and the coefficients are of order 1.
            assert!((0..f.len()).all(|i| (0..6).all(|k| (f[i][k] - w[i][k]).abs() < 1e-12)));
            for (f, w) in found.systems.iter().zip(&whole.systems) {
                assert_eq!((f.samples, f.rank), (w.samples, w.rank));
                assert!((f.condition / w.condition - 1.0).abs() < 1e-12);
            }
        }
        let other = factor(&set, &settings, None, &Task::default()).unwrap();
        assert!(Factored::merged([&merged, &other]).is_none(), "other box");
    }
}

#[test]
fn a_fit_under_way_stops_and_reports_its_progress() {
    let set = samples_of(&truth(1, DirectionSet::Six, Weighting::Area), 30_000);
    for method in [FitMethod::PerDirection, FitMethod::Joint] {
        let settings =
            FitSettings { method, ridge: 1e-3, ..FitSettings::new(1, DirectionSet::Six) };
        let reported = Arc::new(Mutex::new(Vec::new()));
        let task = Task::with_progress({
            let reported = reported.clone();
            move |part| reported.lock().unwrap().push(part)
        });
        let whole = on_threads(1, || fit_with(&set, &settings, None, &task));
        assert_eq!(whole, fit(&set, &settings, None));
        let parts = reported.lock().unwrap().clone();
        assert!(parts.is_sorted(), "{parts:?}");
        assert_eq!(parts.last(), Some(&1.0));

        let token = CancelToken::default();
        let mut task = Task::with_progress({
            let token = token.clone();
            move |part| {
                if part > 0.3 {
                    token.cancel();
                }
            }
        });
        task.cancel = token;
        let stopped = fit_with(&set, &settings, None, &task);
        assert_eq!(stopped, Err(FitError::Cancelled(Cancelled)));
    }
}

#[test]
fn a_fit_does_not_depend_on_the_number_of_threads() {
    let set = samples_of(&truth(2, DirectionSet::FortyTwo, Weighting::Area), 40_000);
    let on = |threads, settings: &FitSettings| {
        on_threads(threads, || fit(&set, settings, None).unwrap())
    };
    for method in [FitMethod::PerDirection, FitMethod::Joint] {
        for directions in [DirectionSet::One, DirectionSet::Fourteen] {
            let settings = FitSettings { method, ..FitSettings::new(1, directions) };
            let (one, four) = (on(1, &settings), on(4, &settings));
            assert_eq!(one.model, four.model);
            assert_eq!(one.systems, four.systems);
        }
    }
}

#[test]
fn samples_in_one_place_get_the_least_norm() {
    let mut set = samples_of(&truth(1, DirectionSet::One, Weighting::Area), 10);
    let first = set.samples[0];
    set.samples.iter_mut().for_each(|s| *s = first);
    let found = fit(&set, &FitSettings::new(2, DirectionSet::One), None).unwrap();
    assert_eq!(found.systems[0].rank, 1);
    assert!(found.after.position_rms_mm < 1e-13);
    let away = Point3::new(1e6, -1e6, 0.0);
    let e = found.model.evaluate(&away, &first.axis, OutsidePolicy::Clamp);
    assert!(e.error.position_mm.iter().all(|v| v.is_finite()));
    assert_ne!(e.error, PoseError::default());
}

proptest! {
    #[test]
    fn registration_recovers_any_pose_without_noise(
        turn in prop::array::uniform3(-3.1..3.1_f64),
        shift in prop::array::uniform3(-500.0..500.0_f64),
        points in prop::collection::vec(prop::array::uniform3(-100.0..100.0_f64), 4..12),
    ) {
        let pose = pose_from_parts(shift.into(), UnitQuaternion::from_scaled_axis(Vector3::from(turn)));
        let source: Vec<Point3<f64>> = points.into_iter().map(Point3::from).collect();
        let target: Vec<_> = source.iter().map(|p| pose * p).collect();
        // Random points on one line are refused, and do not come up.
        let found = register(&source, &target).unwrap();
        for (s, t) in source.iter().zip(&target) {
            prop_assert!((found.target_from_source * s - t).norm() < 1e-9);
        }
    }
}
