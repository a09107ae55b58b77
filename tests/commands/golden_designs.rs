//! All three modes of both worked designs through the command line, figure by figure.

use crate::support::close::{assert_all_golden, assert_golden};
use crate::support::golden::{GOLDEN, count, list, number, numbers};
use crate::support::program::Scratch;
use crate::support::table::Table;
use serde_json::Value;

/// Tip errors in mm and degrees below this are round-off of positions of some hundred mm.
const FLOOR: f64 = 1e-3;

const STATISTICS: [&str; 7] = ["rms", "mean", "std", "min", "median", "p95", "max"];

const ON_HEAD: &str = "pointer-on-head/pointer-on-head.design.ron";

/// The designs in a folder of their own, beside the environment that they name.
fn room() -> Scratch {
    let scratch = Scratch::new();
    for design in ["pointer-no-crf", "pointer-on-head"] {
        scratch.copy_own(&format!("golden/{design}"), design);
        scratch.fit(&format!("{design}/room.env.ron"), "--order 2 --directions 14");
    }
    scratch
}

fn assert_figures(found: &Value, expected: &Value, what: &str) {
    assert_eq!(found["trials"], expected["trials"], "{what}");
    assert_eq!(found["outside"], expected["outside"], "{what}");
    assert_eq!(found["worst"]["trial"], expected["worst"], "{what}");
    for quantity in ["position_mm", "angle_deg"] {
        for statistic in STATISTICS {
            assert_golden(
                &format!("{what} {quantity} {statistic}"),
                number(&found["room_field"][quantity][statistic]),
                number(&expected[quantity][statistic]),
                FLOOR,
            );
        }
    }
}

/// Error vector and poses, which a single pose alone has.
fn assert_vectors(found: &Value, expected: &Value) {
    for (key, name) in [("err", "error_mm"), ("true", "true"), ("sim", "simulated")] {
        let values = |v: &Value, key| -> Vec<f64> { list(v, key).iter().map(number).collect() };
        assert_all_golden(name, &values(found, name), &values(expected, key), FLOOR);
    }
}

fn assert_log(log: &Table, expected: &Value, what: &str) {
    assert_eq!(log.rows.len(), count(&expected["trials"]), "{what}");
    let cell = |cell: &String| -> f64 { cell.parse().unwrap() };
    for (row, trial) in log.rows.iter().zip(list(expected, "first_trials")) {
        let row: Vec<f64> = row.iter().map(cell).collect();
        for (first, key) in [("true_x", "true"), ("sim_x", "sim")] {
            let found = &row[log.column(first)..][..7];
            let expected = numbers::<7>(&trial[key]);
            assert_all_golden("position", &found[..3], &expected[..3], 1.0);
            assert_all_golden("quaternion", &found[3..], &expected[3..], 1.0);
        }
        let error = &row[log.column("err_x")..][..3];
        assert_all_golden("error", error, &numbers::<3>(&trial["err"]), FLOOR);
        for key in ["err_mm", "err_deg"] {
            assert_golden(key, row[log.column(key)], number(&trial[key]), FLOOR);
        }
        assert_eq!(row[log.column("outside")], number(&trial["outside"]), "{what}");
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
            let input = match mode {
                "input" => format!("--input {folder}/input.csv"),
                _ => String::new(),
            };
            let line = format!("simulate {design} --mode {mode} --log log.csv {input}");
            let found = room.json(line);
            assert_figures(&found, &case[mode], &what);
            if mode == "single" {
                assert_vectors(&found, &list(&case[mode], "first_trials")[0]);
            }
            assert_log(&room.table("log.csv"), &case[mode], &what);
        }
    }
}

#[test]
fn threads_do_not_change_the_bytes() {
    let room = room();
    let with_threads = |threads: &str| {
        let line = format!("simulate {ON_HEAD} --mode motion --format json --log log.csv");
        let output = room.command(&line).env("RAYON_NUM_THREADS", threads).output().unwrap();
        assert!(output.status.success());
        (output.stdout, room.read("log.csv"))
    };
    assert_eq!(with_threads("1"), with_threads("7"));
}

#[test]
fn a_rejected_sensor_leaves_its_trial_out() {
    let room = room();
    let all = room.json(format!("simulate {ON_HEAD} --mode motion"));
    let kept = room.json(format!("simulate {ON_HEAD} --mode motion --outside reject"));
    assert_eq!(kept["rejected"], all["outside"]);
    assert_ne!(kept["room_field"]["position_mm"]["mean"], all["room_field"]["position_mm"]["mean"]);
}
