//! Surveys of a study's support: what they count is what each sensor finds, whatever the threads.

use crate::support::studies::{cancelled, default_in_polynomials as built_in, on_threads};
use nalgebra::Vector3;
use std::sync::Arc;
use trackwright_field::OutsidePolicy;
use trackwright_geometry::bounds::Bounds;
use trackwright_simulation::{
    self, CancelToken, InputTrial, Mode, Quantity, Scenario, SlicePlan, SlicePlane, StudyError,
    SupportSurvey, sample_slice, support::SurveyError,
};
use trackwright_task::Task;

fn survey(scenario: &Scenario, mode: &Mode) -> SupportSurvey {
    trackwright_simulation::survey(scenario, mode, &Task::default()).unwrap()
}

fn without_validity(scenario: &Scenario) -> Scenario {
    let mut scenario = scenario.clone();
    let room = Arc::make_mut(&mut scenario.environment);
    (room.fit_validity, room.process) = (None, None);
    scenario
}

#[test]
fn a_survey_sums_up_its_sensors() {
    let scenario = built_in();
    let support = scenario.environment.fit_validity.as_ref().unwrap();
    let crf = scenario.crf.as_ref().unwrap();
    let found: Vec<_> = [
        (&crf.body, crf.tracker_from_crf),
        (&scenario.tool, crf.tracker_from_crf * scenario.crf_from_tool),
    ]
    .into_iter()
    .flat_map(|(body, pose)| {
        body.sensors.iter().map(move |sensor| {
            support.at(
                &(pose * sensor.position_in_body),
                &(pose.rotation * sensor.axis_in_body().unwrap()),
                OutsidePolicy::Clamp,
            )
        })
    })
    .collect();
    let survey = survey(&scenario, &Mode::Single);
    let squares: f64 = found.iter().map(|at| at.position_std_error_mm.powi(2)).sum();
    let rms = (squares / found.len() as f64).sqrt();
    assert!((survey.std_error_mm.rms - rms).abs() < 1e-14, "{survey:?}");
    let angles = found.iter().map(|at| at.angle_std_error_rad.unwrap());
    let max = angles.fold(0.0, f64::max).to_degrees();
    assert!((survey.std_error_deg.unwrap().max - max).abs() < 1e-14);
    let distance = found.iter().map(|at| at.distance_mm).fold(0.0, f64::max);
    assert_eq!(survey.greatest_distance_mm, distance);
    assert!(found.iter().all(|at| at.is_valid));
    assert_eq!((survey.trials, survey.unsupported), (1, 0));
}

#[test]
fn a_crf_at_rest_is_evaluated_once_on_any_threads() {
    let scenario = built_in();
    let sensors = |scenario: &Scenario| {
        let crf = scenario.crf.as_ref().unwrap();
        (scenario.tool.sensors.len() as u64, crf.body.sensors.len() as u64)
    };
    let (tool, crf) = sensors(&scenario);
    let surveys = [1, 3].map(|threads| on_threads(threads, || survey(&scenario, &Mode::Motion)));
    assert_eq!(surveys[0], surveys[1]);
    assert_eq!((surveys[0].trials, surveys[0].evaluations), (3375, 3375 * tool + crf));
    // Where it moves it is evaluated each time.
    let trial = InputTrial {
        tracker_from_crf: scenario.crf.as_ref().map(|c| c.tracker_from_crf),
        crf_from_tool: scenario.crf_from_tool,
    };
    let moved = survey(&scenario, &Mode::Input(vec![trial; 10].into()));
    assert_eq!(moved.evaluations, 10 * (tool + crf) + crf);
    let single = survey(&scenario, &Mode::Single);
    assert!((moved.std_error_mm.rms - single.std_error_mm.rms).abs() < 1e-14);
}

#[test]
fn a_tool_beyond_the_samples_is_unsupported() {
    let mut scenario = built_in();
    scenario.crf_from_tool.translation.vector += Vector3::new(400.0, 0.0, 0.0);
    let found = survey(&scenario, &Mode::Single);
    assert_eq!((found.trials, found.unsupported), (1, 1));
    assert!(found.greatest_distance_mm > 100.0, "{found:?}");
    scenario.outside = OutsidePolicy::Reject;
    let rejected = trackwright_simulation::survey(&scenario, &Mode::Single, &Task::default());
    let all = StudyError::AllRejected { trials: 1 };
    assert_eq!(rejected, Err(SurveyError::Study(all)));
}

#[test]
fn no_survey_without_validity_or_when_cancelled() {
    let scenario = built_in();
    let stopped = trackwright_simulation::survey(&scenario, &Mode::Motion, &cancelled());
    assert_eq!(stopped, Err(SurveyError::Study(StudyError::Cancelled)));
    let scenario = without_validity(&scenario);
    let found = trackwright_simulation::survey(&scenario, &Mode::Single, &Task::default());
    let error = found.unwrap_err();
    assert!(error.to_string().contains("\"Operating table\" has no model validity"), "{error}");
}

#[test]
fn a_slice_shows_its_quantity() {
    let scenario = built_in();
    let environment = &scenario.environment;
    let (model, support) = (&environment.model, environment.fit_validity.as_ref().unwrap());
    let bounds = *model.bounds();
    let plan = SlicePlan {
        plane: SlicePlane::Across {
            normal_axis: 2,
            position_mm: bounds.center_mm().z,
            // Somewhat more than the box, so that some of the points are outside.
            bounds: Bounds { max_mm: bounds.max_mm + Vector3::repeat(20.0), ..bounds },
        },
        sensor_axis: Vector3::x_axis(),
        counts: [9, 5],
    };
    let cancel = CancelToken::default();
    let slice = |quantity| sample_slice(&scenario, quantity, &plan, &cancel);
    let error = slice(Quantity::PositionErrorMm).unwrap().unwrap();
    let std_error = slice(Quantity::StdErrorMm).unwrap().unwrap();
    let distance = slice(Quantity::SupportDistanceMm).unwrap().unwrap();
    for (i, is_inside) in error.is_inside.iter().enumerate() {
        let point = plan.point_mm(i % 9, i / 9);
        let at = support.at(&point, &plan.sensor_axis, OutsidePolicy::Clamp);
        assert_eq!(std_error.values[i], at.position_std_error_mm);
        assert_eq!(distance.values[i], at.distance_mm);
        assert_eq!([std_error.is_inside[i], distance.is_inside[i]], [*is_inside; 2]);
    }
    assert!(std_error.p95 > 0.0 && std_error.p95 <= std_error.max);
    let without = without_validity(&scenario);
    let none = sample_slice(&without, Quantity::StdErrorMm, &plan, &cancel);
    assert_eq!(none, Ok(None));
    cancel.cancel();
    assert_eq!(slice(Quantity::StdErrorMm), Err(StudyError::Cancelled));
}
