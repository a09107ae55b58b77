//! Surveys of a study's support: what they count is what each sensor finds, whatever the threads.

use crate::support::studies::{cancelled, default_in_polynomials as built_in, on_threads};
use nalgebra::Vector3;
use trackwright_field::OutsidePolicy;
use trackwright_simulation::{
    self, InputTrial, Mode, Scenario, StudyError, SupportSurvey, support::SurveyError,
};
use trackwright_task::Task;

fn survey(scenario: &Scenario, mode: &Mode) -> SupportSurvey {
    trackwright_simulation::survey(scenario, mode, &Task::default()).unwrap()
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
fn a_cancelled_survey_stops() {
    let stopped = trackwright_simulation::survey(&built_in(), &Mode::Motion, &cancelled());
    assert_eq!(stopped, Err(SurveyError::Study(StudyError::Cancelled)));
}
