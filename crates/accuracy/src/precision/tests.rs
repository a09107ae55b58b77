//! The report as a whole: rows, fronts, what repeats and what stops.

use super::*;
use std::sync::{Arc, LazyLock, Mutex};
use trackwright_field::DistortionModel;
use trackwright_field::samples::MapKind;

/// Of the built-in design; what it was shown on the way, and how far it was said to be.
struct Measured {
    report: Report,
    shown: Vec<What>,
    heard: Vec<f64>,
}

fn measured() -> Measured {
    let heard = Arc::new(Mutex::new(Vec::new()));
    let task = Task::with_progress({
        let heard = heard.clone();
        move |part| heard.lock().unwrap().push(part)
    });
    let mut shown = Vec::new();
    let report = run_each(&testing::built_in(), &Settings::quick(), &task, |family| {
        shown.push(family.what);
    })
    .unwrap();
    let heard = heard.lock().unwrap().clone();
    Measured { report, shown, heard }
}

static MEASURED: LazyLock<Measured> = LazyLock::new(measured);

fn errors(report: &Report) -> Vec<(&str, &str, f64)> {
    report.rows().map(|r| (r.problem.as_str(), r.method.as_str(), r.error)).collect()
}

#[test]
fn errors_repeat_to_the_bit() {
    assert_eq!(errors(&MEASURED.report), errors(&measured().report));
}

#[test]
fn every_family_has_rows_a_front_and_a_default() {
    for family in &MEASURED.report.families {
        let name = family.what.name();
        assert_eq!(family.left_out, None, "{name}");
        let charted = || family.rows.iter().filter(|r| r.problem == family.charted);
        assert!(charted().any(|r| r.on_front), "{name}");
        assert_eq!(charted().filter(|r| r.is_default).count(), 1, "{name}");
        for row in &family.rows {
            assert!(row.seconds > 0.0 && row.error >= 0.0, "{row:?}");
            assert!(row.size > 0 && row.error.is_finite(), "{row:?}");
        }
    }
}

#[test]
fn fronts_are_those_of_each_problem() {
    let rows: Vec<_> = MEASURED.report.rows().collect();
    for row in &rows {
        let is_beaten = rows.iter().any(|other| {
            (other.what, &other.problem) == (row.what, &row.problem)
                && other.seconds <= row.seconds
                && other.error <= row.error
                && (other.seconds < row.seconds || other.error < row.error)
        });
        assert_eq!(row.on_front, !is_beaten, "{row:?}");
    }
}

#[test]
fn families_come_one_by_one_and_progress_never_falls() {
    assert_eq!(MEASURED.shown, What::ALL);
    let heard = &MEASURED.heard;
    assert!(heard.windows(2).all(|w| w[0] <= w[1]), "{heard:?}");
    assert_eq!(heard.last(), Some(&1.0));
}

#[test]
fn an_ideal_room_leaves_out_what_it_has_no_field_for() {
    let model = DistortionModel::zero(testing::bounds(), MapKind::Distortion);
    let report = run(&testing::scenario(model), &Settings::quick(), &Task::default()).unwrap();
    for family in &report.families {
        assert_eq!(family.rows.is_empty(), family.left_out.is_some());
    }
    let left_out = |what| {
        let family = report.families.iter().find(|f| f.what == what).unwrap();
        family.left_out.is_some()
    };
    assert!([What::Field, What::Inverse, What::Motion, What::Heatmap].into_iter().all(left_out));
}

#[test]
fn a_cancelled_report_is_none() {
    let task = Task::default();
    task.cancel.cancel();
    let report = run(&testing::built_in(), &Settings::quick(), &task);
    assert_eq!(report, Err(Cancelled));
}
