//! A room from real recordings of an Aurora beside a Polaris, and recordings that give none.

use crate::support::data::{aurora_pairs, third_party};
use crate::support::golden::{list, number};
use crate::support::program::{Scratch, text};
use nalgebra::DMatrix;
use serde_json::Value;
use trackwright_formats::tool_definition::OnMismatch;
use trackwright_project::Files;

/// Within 10 % of a published range.
#[track_caller]
fn assert_near(what: &str, value: &Value, low: f64, high: f64) {
    let value = number(value);
    assert!((0.9 * low..=1.1 * high).contains(&value), "{what}: {value}, expected {low} to {high}");
}

fn matrix(value: &Value) -> DMatrix<f64> {
    let rows: Vec<Vec<f64>> = serde_json::from_value(value.clone()).unwrap();
    DMatrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j])
}

/// The blocks of the joint covariance are those of the frames, and agree with the standard errors.
fn check_covariance(found: &Value) {
    let joint = matrix(&found["covariance"]["matrix"]);
    let sensors = list(found, "sensors");
    assert_eq!(joint.nrows(), 6 + 6 * sensors.len());
    assert!((&joint - joint.transpose()).amax() < 1e-12 * joint.amax());
    let frames = list(&found["covariance"], "frames");
    assert_eq!(frames[0], "tracker_from_reference");
    let reference = matrix(&found["tracker_from_reference"]["covariance"]);
    assert_eq!(joint.view((0, 0), (6, 6)), reference);
    let worst = |block: &DMatrix<f64>, first| {
        let block = block.view((first, first), (3, 3)).into_owned();
        block.symmetric_eigenvalues().max().sqrt()
    };
    let angle = number(&found["tracker_from_reference"]["std_error"]["angle_deg"]);
    assert!((worst(&reference, 0).to_degrees() - angle).abs() < 1e-9);
    for (k, sensor) in sensors.iter().enumerate() {
        assert_eq!(frames[1 + k], sensor["name"]);
        let own = matrix(&sensor["covariance"]);
        assert_eq!(joint.view((6 + 6 * k, 6 + 6 * k), (6, 6)), own);
        let error = &sensor["std_error"];
        assert!((worst(&own, 3) - number(&error["position_mm"])).abs() < 1e-9);
        assert!((worst(&own, 0).to_degrees() - number(&error["angle_deg"])).abs() < 1e-9);
    }
}

#[test]
fn the_real_static_room_has_known_errors() {
    let Some(folder) = third_party("aurora-polaris/static") else { return };
    let scratch = Scratch::new();
    let pairs = aurora_pairs(&folder, 0, 1);
    let found = scratch.json(format!("characterize {pairs} -o room.csv --body object.body.ron"));
    assert_eq!(found["pairs"], 91);
    assert_eq!(found["rejected"], 0);
    assert_eq!(found["readings"], 273);
    let sensors = list(&found, "sensors");
    // Two independent solutions with different losses.
    let rms = [(5.4, 5.8), (5.5, 6.0), (2.7, 3.2)];
    let medians = [(2.5, 2.7), (2.6, 2.9), (1.8, 2.6)];
    let angles = [2.6, 2.7, 1.7];
    for (k, sensor) in sensors.iter().enumerate() {
        let name = sensor["name"].as_str().unwrap();
        assert!(name.starts_with(&format!("Port 1{k}: NDI-MF2")), "{name}");
        let (low, high) = rms[k];
        assert_near(name, &sensor["position_mm"]["rms"], low, high);
        let (low, high) = medians[k];
        assert_near(name, &sensor["position_mm"]["median"], low, high);
        assert_near(name, &sensor["angle_deg"]["rms"], angles[k], angles[k]);
        for quantity in ["position_mm", "angle_deg"] {
            let of = |figure: &str| number(&sensor[quantity][figure]);
            assert!(of("median") < of("rms") && of("rms") < of("p95") && of("p95") < of("max"));
        }
        let error = &sensor["std_error"];
        assert!(number(&error["position_mm"]) < 1.5 && number(&error["angle_deg"]) < 1.0);
    }
    check_covariance(&found);
    let distances = list(&found, "distances");
    let names: Vec<&Value> = sensors.iter().map(|s| &s["name"]).collect();
    for (distance, (a, b, mean, std)) in
        distances.iter().zip([(0, 1, 24.8, 1.7), (0, 2, 26.9, 3.9), (1, 2, 24.6, 3.0)])
    {
        assert_eq!((&distance["a"], &distance["b"]), (names[a], names[b]));
        assert_near("mean", &distance["mean"], mean, mean);
        assert_near("std", &distance["std"], std, std);
        assert!(number(&distance["min"]) < mean - std && number(&distance["max"]) > mean + std);
    }
    // The body's sensors are as far apart as the reference's frame has them.
    let body = scratch.path("object.body.ron");
    let body = Files::default().read_tool(&body, OnMismatch::Refuse).unwrap();
    let [a, b, c] = [0, 1, 2].map(|k: usize| body.body.rigid.sensors[k].position_in_body);
    for ((a, b), mean) in [(a, b), (a, c), (b, c)].into_iter().zip([24.8, 26.9, 24.6]) {
        assert!(((a - b).norm() - mean).abs() < 0.1 * mean, "{a} {b}");
    }
    assert_near("angle", &distances[0]["angle_deg"]["std"], 1.8, 1.8);
    assert_near("angle", &distances[1]["angle_deg"]["std"], 1.3, 1.3);

    // The table is one that `select` takes, held out by pose without an option.
    let settings = "--sensors 6dof --map correction --orders 1-2 --directions 1 --ridges 0,0.01";
    let chosen = scratch.json(format!("select room.csv {settings}"));
    assert_eq!(chosen["groups"]["by"], "column pose");
    assert_eq!(chosen["groups"]["count"], 91);
    let cv = |order: u64| {
        let rows = list(&chosen, "table").iter().filter(|r| r["order"] == order);
        rows.map(|r| number(&r["cv"]["position_rms_mm"])).fold(f64::INFINITY, f64::min)
    };
    // 4.77 to 3.42 mm, by an affine map alone.
    assert!(cv(1) < 0.8 * cv(0), "{} {}", cv(0), cv(1));
}

#[test]
fn real_paths_are_aligned_by_frame_counters() {
    let Some(folder) = third_party("aurora-polaris/paths") else { return };
    let scratch = Scratch::new();
    let pairs = aurora_pairs(&folder, 0, 1);
    let found = scratch.json(format!("characterize {pairs} -o paths.csv"));
    assert_eq!((&found["pairs"], &found["rejected"]), (&4.into(), &0.into()));
    let paths = list(&found, "paths");
    assert_eq!(paths.len(), 4);
    for path in paths {
        assert_eq!(path["clocks"][0], "frames at 320 Hz");
        assert_eq!(path["clocks"][1], "frames at 60 Hz");
        assert!(number(&path["correlation"]) > 0.95, "{path}");
        // All were begun by one program, within a quarter of a second.
        assert!(number(&path["offset_s"]).abs() < 0.25, "{path}");
        let by_speeds = number(&path["offset_by_speeds_s"]);
        assert!((number(&path["offset_s"]) - by_speeds).abs() < 0.1, "{path}");
        let [before, after] = ["before", "after"].map(|w| number(&path[w]["position_mm"]));
        assert!(after <= before * 1.001 && after < 4.0, "{path}");
    }
}

#[test]
fn undetermined_real_motions_are_refused() {
    let Some(folder) = third_party("aurora-polaris/paths") else { return };
    let scratch = Scratch::new();
    let of = |name: &str, more: &str| {
        let file = |tracker: &str| text(&folder.join(format!("{tracker}_19_09_{name}.tsv")));
        format!("{} {more}", characterize(&[file("EM")], &[file("OT")]))
    };
    for (name, more, words) in [
        ("Line100", "", "too few poses: 4, expected at least 10"),
        ("Line100", "--min-poses 3", "the body hardly turned"),
        // A circle and an arc, each about one axis.
        ("Circle30", "", "the body turned about one axis only"),
        ("Arc10", "", "the body turned about one axis only"),
    ] {
        scratch.refused(of(name, more), &[words]);
    }
    let clocks = "clocks: EM tracker by frames at 320 Hz";
    let words = ["paths: 1", "body from Port 12", "offset s", clocks, "written to"];
    let printed = scratch.succeed_with(of("Random10", "--sensors 'Port 12'"), &words);
    assert!(!printed.contains("Port 10"), "{printed}");
}

const COLUMNS: &str = "Frame\tState\tQ0\tQx\tQy\tQz\tTx\tTy\tTz";

/// A table of one tool with a few samples of a pose, in a state.
fn recording(scratch: &Scratch, name: &str, pose: &str, state: &str) -> String {
    let mut table = format!("Tools\tPort 1: tool\t{COLUMNS}\n");
    for frame in 0..5 {
        table += &format!("1\tPort 1: tool\t{}\t{state}\t{pose}\n", 8 * frame);
    }
    let file = format!("{name}.tsv");
    scratch.write(&file, table);
    file
}

/// Recordings of a body that turns about one axis, or about three; sensor and body are one.
fn turning(scratch: &Scratch, has_one_axis: bool) -> [Vec<String>; 2] {
    let mut files = [Vec::new(), Vec::new()];
    for i in 0..12 {
        let (sine, cosine) = (0.1 * f64::from(i) + 0.05).sin_cos();
        let (y, z) = match has_one_axis || i % 2 == 0 {
            true => (0.0, sine),
            false => (sine, 0.0),
        };
        let pose = format!("{cosine}\t0\t{y}\t{z}\t{}\t{}\t-300", 5 * i, 40 - i * i);
        for (files, name) in files.iter_mut().zip(["em", "ot"]) {
            files.push(recording(scratch, &format!("{name}-{has_one_axis}-{i}"), &pose, "OK"));
        }
    }
    files
}

fn characterize(em: &[String], reference: &[String]) -> String {
    let (em, reference) = (em.join(" "), reference.join(" "));
    format!("characterize --em {em} --reference {reference} -o room.csv")
}

#[test]
fn equal_readings_give_identity_frames() {
    let scratch = Scratch::new();
    let [em, reference] = turning(&scratch, false);
    let found = scratch.json(characterize(&em, &reference));
    let sensor = &found["sensors"][0];
    assert!(number(&sensor["position_mm"]["max"]) < 1e-9, "{found}");
    assert!(number(&found["tracker_from_reference"]["pose"][3]) > 1.0 - 1e-12);
    let rows = scratch.read("room.csv");
    let header = rows.lines().next().unwrap();
    assert!(header.ends_with("measured_qz,sensor,pair,pose"), "{header}");
    assert_eq!(rows.lines().count(), 13);
    assert!(rows.lines().nth(3).unwrap().ends_with(",Port 1: tool,2,2"), "{rows}");
}

#[test]
fn unusable_recordings_are_refused() {
    let scratch = Scratch::new();
    let [em, reference] = turning(&scratch, false);
    let refused = |em: &[String], reference: &[String], words: &[&str]| {
        scratch.fail_with(characterize(em, reference), words);
        assert!(!scratch.has("room.csv"));
    };
    refused(&em, &reference[1..], &["--em names 12", "--reference 11"]);
    refused(&em[1..], &reference[1..3], &["--em names 11", "--reference 2"]);
    refused(&em[..9], &reference[..9], &["too few poses: 9, expected at least 10"]);
    let [one_em, one_reference] = turning(&scratch, true);
    refused(
        &one_em,
        &one_reference,
        &["turned about one axis only", "(0.00, 0.00, 1.00) in its own frame", "tilt the body"],
    );
    let bad = recording(&scratch, "bad", "1\t0\t0\t0\t0\t0\t0", "Too Few Markers");
    let bads = vec![bad; 12];
    refused(&em, &bads, &["none of 12 pairs", "the reference tracker has no good sample"]);
    refused(&bads, &reference, &["none of 12 pairs", "no good sample of any sensor"]);
    scratch.write("empty.tsv", "");
    refused(&["empty.tsv".into()], &reference[..1], &["empty.tsv: line 1: found \"\""]);
    scratch.write("header.tsv", format!("Tools\tPort 1\t{COLUMNS}\n"));
    refused(&em[..1], &["header.tsv".into()], &["header.tsv: found no rows"]);
    refused(&["none.tsv".into()], &reference[..1], &["none.tsv: File not found"]);
}

#[test]
fn every_pair_is_held_out_once() {
    let scratch = Scratch::new();
    let [em, reference] = turning(&scratch, false);
    let base = characterize(&em, &reference);
    let rows = |file: &str| scratch.read(file).lines().count() - 1;
    let mut seen = Vec::new();
    for part in ["1/4", "2/4", "3/4", "4/4"] {
        let more = format!("--hold-out {part} --held-out held.csv --min-poses 9");
        let found = scratch.json(format!("{base} {more}"));
        assert_eq!((rows("room.csv"), rows("held.csv")), (9, 3), "{part}");
        assert_eq!((&found["readings"], &found["held_out"]), (&9.into(), &3.into()));
        let pair = |line: &str| line.rsplit(',').nth(1).unwrap().parse::<usize>().unwrap();
        seen.extend(scratch.read("held.csv").lines().skip(1).map(pair));
    }
    seen.sort_unstable();
    assert_eq!(seen, (0..12).collect::<Vec<_>>());
    let refused = |part: &str, words: &str| {
        scratch.refused(format!("{base} --hold-out {part}"), &[words]);
    };
    for wrong in ["0/5", "6/5", "1/1", "1", "a/b"] {
        refused(&format!("{wrong} --held-out held.csv"), "expected K/N");
    }
    refused("1/4", "--held-out");
    refused("13/13 --held-out held.csv", "--hold-out: found no good reading");
}
