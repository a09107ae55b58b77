//! The report as a whole: rows, fronts, what repeats and what stops.

use super::*;
use std::sync::{Arc, LazyLock, Mutex};
use trackwright_field::DistortionModel;
use trackwright_field::samples::MapKind;

/// Of the built-in design; the families it showed and the progress it reported.
struct Measured {
    report: Report,
    shown: Vec<What>,
    reported: Vec<f64>,
}

fn measured() -> Measured {
    let reported = Arc::new(Mutex::new(Vec::new()));
    let task = Task::with_progress({
        let reported = reported.clone();
        move |part| reported.lock().unwrap().push(part)
    });
    let mut shown = Vec::new();
    let report = run_each(&testing::built_in(), &Settings::quick(), &task, |family| {
        shown.push(family.what);
    })
    .unwrap();
    let reported = reported.lock().unwrap().clone();
    Measured { report, shown, reported }
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
fn families_come_one_by_one_with_progress() {
    assert_eq!(MEASURED.shown, What::ALL);
    let reported = &MEASURED.reported;
    assert!(reported.windows(2).all(|w| w[0] <= w[1]), "{reported:?}");
    assert_eq!(reported.last(), Some(&1.0));
}

#[test]
fn an_ideal_room_leaves_out_its_field() {
    let model = DistortionModel::zero(testing::bounds(), MapKind::Distortion);
    let scenario = testing::scenario(model);
    let report = run_each(&scenario, &Settings::quick(), &Task::default(), |_| ()).unwrap();
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
    let report = run_each(&testing::built_in(), &Settings::quick(), &task, |_| ());
    assert_eq!(report, Err(Cancelled));
}

#[test]
fn what_is_slower_and_worse_is_not_on_the_front() {
    let nan = f64::NAN;
    for (points, expected) in [
        (
            &[(1.0, 9.0), (2.0, 4.0), (3.0, 5.0), (4.0, 1.0), (4.0, 2.0)][..],
            &[true, true, false, true, false][..],
        ),
        // Equals share the front, and what is not a number has no place.
        (&[(1.0, 1.0), (1.0, 1.0), (0.5, nan), (nan, 0.0)], &[true, true, false, false]),
        // An exact result is on it once.
        (&[(2.0, 0.0), (1.0, 0.0), (0.5, 1e-9)], &[false, true, true]),
        (&[], &[]),
    ] {
        let row = |&(seconds, error)| testing::row("problem", "method").measured(1, seconds, error);
        let mut rows: Vec<Row> = points.iter().map(row).collect();
        mark_fronts(&mut rows);
        let found: Vec<bool> = rows.iter().map(|row| row.on_front).collect();
        assert_eq!(found, expected, "{points:?}");
    }
}
