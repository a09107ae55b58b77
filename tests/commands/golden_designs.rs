//! All three modes of both worked designs through the command line, figure by figure.

use crate::support::close::{self, assert_all_close, assert_close};
use crate::support::data::own;
use crate::support::golden::{GOLDEN, count, list, number, numbers};
use crate::support::program::{Scratch, json, succeed, text};
use serde_json::Value;

/// Tip errors in mm and degrees below this are round-off of positions of some hundred mm.
const FLOOR: f64 = 1e-3;

const STATISTICS: [&str; 7] = ["rms", "mean", "std", "min", "median", "p95", "max"];

/// The designs in a folder of their own, beside the environment that they name.
fn room() -> Scratch {
    let scratch = Scratch::new();
    for design in ["pointer-no-crf", "pointer-on-head"] {
        scratch.copy_own(&format!("golden/{design}"), design);
        succeed(&[
            "fit",
            &text(&own("room-a/room-a-fit.csv")),
            "-o",
            &scratch.arg(&format!("{design}/room.env.ron")),
            "--order",
            "2",
            "--directions",
            "14",
        ]);
    }
    scratch
}

fn assert_figures(found: &Value, expected: &Value, what: &str) {
    assert_eq!(found["trials"], expected["trials"], "{what}");
    assert_eq!(found["outside"], expected["outside"], "{what}");
    assert_eq!(found["worst"]["trial"], expected["worst"], "{what}");
    for quantity in ["position_mm", "angle_deg"] {
        for statistic in STATISTICS {
            assert_close(
                &format!("{what} {quantity} {statistic}"),
                number(&found[quantity][statistic]),
                number(&expected[quantity][statistic]),
                close::GOLDEN,
                FLOOR,
            );
        }
    }
}

fn assert_log(log: &str, expected: &Value, what: &str) {
    let mut lines = log.lines();
    let header: Vec<_> = lines.next().unwrap().split(',').collect();
    let column = |name: &str| header.iter().position(|h| *h == name).unwrap();
    let rows: Vec<Vec<f64>> =
        lines.map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    assert_eq!(rows.len(), count(&expected["trials"]), "{what}");
    for (row, trial) in rows.iter().zip(list(expected, "first_trials")) {
        for (first, key) in [("true_x", "true"), ("sim_x", "sim")] {
            let found = &row[column(first)..][..7];
            let expected = numbers::<7>(&trial[key]);
            assert_all_close("position", &found[..3], &expected[..3], close::GOLDEN, 1.0);
            assert_all_close("quaternion", &found[3..], &expected[3..], close::GOLDEN, 1.0);
        }
        let error = &row[column("err_x")..][..3];
        assert_all_close("error", error, &numbers::<3>(&trial["err"]), close::GOLDEN, FLOOR);
        for key in ["err_mm", "err_deg"] {
            assert_close(key, row[column(key)], number(&trial[key]), close::GOLDEN, FLOOR);
        }
        assert_eq!(row[column("outside")], number(&trial["outside"]), "{what}");
    }
}

#[test]
fn every_mode_of_both_designs_agrees() {
    let room = room();
    for case in list(&GOLDEN, "designs") {
        let design = case["design"].as_str().unwrap();
        let folder = design.split('/').next().unwrap();
        for mode in ["single", "motion", "input"] {
            let what = format!("{folder} {mode}");
            let (design, log) = (room.arg(design), room.arg(&format!("{folder}-{mode}.csv")));
            let input = room.arg(&format!("{folder}/input.csv"));
            let mut args = vec!["simulate", &design, "--mode", mode, "--log", &log];
            if mode == "input" {
                args.extend(["--input", &input]);
            }
            assert_figures(&json(&args), &case[mode], &what);
            assert_log(&std::fs::read_to_string(&log).unwrap(), &case[mode], &what);
        }
    }
}

#[test]
fn single_mode_adds_error_vector_and_poses() {
    let room = room();
    let case = &list(&GOLDEN, "designs")[0];
    let expected = &list(&case["single"], "first_trials")[0];
    let design = room.arg(case["design"].as_str().unwrap());
    let found = json(&["simulate", &design, "--mode", "single"]);
    for (key, name) in [("err", "error_mm"), ("true", "true"), ("sim", "simulated")] {
        let values = |v: &Value| -> Vec<f64> { v.as_array().unwrap().iter().map(number).collect() };
        assert_all_close(
            name,
            &values(&found[name]),
            &values(&expected[key]),
            close::GOLDEN,
            FLOOR,
        );
    }
}

#[test]
fn threads_do_not_change_the_bytes() {
    let room = room();
    let design = room.arg("pointer-on-head/pointer-on-head.design.ron");
    let with_threads = |threads: &str, log: &str| {
        let log = room.arg(log);
        let output = crate::support::program::trackwright(&[
            "simulate", &design, "--mode", "motion", "--format", "json", "--log", &log,
        ])
        .env("RAYON_NUM_THREADS", threads)
        .output()
        .unwrap();
        assert!(output.status.success());
        (output.stdout, std::fs::read(log).unwrap())
    };
    assert_eq!(with_threads("1", "one.csv"), with_threads("7", "seven.csv"));
}

#[test]
fn a_rejected_sensor_leaves_its_trial_out() {
    let room = room();
    let design = room.arg("pointer-on-head/pointer-on-head.design.ron");
    let all = json(&["simulate", &design, "--mode", "motion"]);
    let kept = json(&["simulate", &design, "--mode", "motion", "--outside", "reject"]);
    assert_eq!(kept["rejected"], all["outside"]);
    assert_ne!(kept["position_mm"]["mean"], all["position_mm"]["mean"]);
}
