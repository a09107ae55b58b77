//! A room from real recordings of an Aurora beside a Polaris, and recordings that give none.

use crate::support::data::third_party;
use crate::support::golden::{list, number};
use crate::support::program::{Scratch, fail, json, succeed, text};
use nalgebra::DMatrix;
use serde_json::Value;
use std::path::{Path, PathBuf};
use trackwright_formats::tool_definition::OnMismatch;
use trackwright_project::Files;

/// Recordings of a folder whose names begin so, sorted.
fn files(folder: &Path, first: &str) -> Vec<String> {
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|file| text(file).contains(&format!("/{first}_")))
        .collect();
    files.sort();
    files.iter().map(|file| text(file)).collect()
}

/// The arguments for all recordings of a folder.
fn arguments(folder: &Path, table: &str) -> Vec<String> {
    let mut arguments = vec!["characterize".to_owned(), "--em".to_owned()];
    arguments.extend(files(folder, "EM"));
    arguments.push("--reference".to_owned());
    arguments.extend(files(folder, "OT"));
    arguments.extend(["-o", table].map(str::to_owned));
    arguments
}

fn borrowed(arguments: &[String]) -> Vec<&str> {
    arguments.iter().map(String::as_str).collect()
}

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

/// The blocks of the joint covariance are those of the frames, and say what the standard errors say.
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
    let Some(folder) = third_party("aurora-polaris/static") else {
        return;
    };
    let scratch = Scratch::new();
    let table = scratch.arg("room.csv");
    let body = scratch.arg("object.body.ron");
    let arguments = arguments(&folder, &table);
    let with_body = [&borrowed(&arguments)[..], &["--body", &body]].concat();
    let found = json(&with_body);
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
    let body = Files::default().read_tool(body.as_ref(), OnMismatch::Refuse).unwrap();
    let [a, b, c] = [0, 1, 2].map(|k: usize| body.body.rigid.sensors[k].position_in_body);
    for ((a, b), mean) in [(a, b), (a, c), (b, c)].into_iter().zip([24.8, 26.9, 24.6]) {
        assert!(((a - b).norm() - mean).abs() < 0.1 * mean, "{a} {b}");
    }
    assert_near("angle", &distances[0]["angle_deg"]["std"], 1.8, 1.8);
    assert_near("angle", &distances[1]["angle_deg"]["std"], 1.3, 1.3);

    // The table is one that `select` takes, held out by pose without being told.
    let chosen = json(&[
        "select",
        &table,
        "--sensors",
        "6dof",
        "--map",
        "correction",
        "--orders",
        "1-2",
        "--directions",
        "1",
        "--ridges",
        "0,0.01",
    ]);
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
    let Some(folder) = third_party("aurora-polaris/paths") else {
        return;
    };
    let scratch = Scratch::new();
    let arguments = arguments(&folder, &scratch.arg("paths.csv"));
    let found = json(&borrowed(&arguments));
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
    let Some(folder) = third_party("aurora-polaris/paths") else {
        return;
    };
    let scratch = Scratch::new();
    let table = scratch.arg("path.csv");
    let of = |name: &str| {
        let file = |tracker: &str| text(&folder.join(format!("{tracker}_19_09_{name}.tsv")));
        [vec![file("EM")], vec![file("OT")]]
    };
    let [em, reference] = of("Line100");
    let said = fail(&characterize(&em, &reference, &table));
    assert!(said.contains("too few poses: 4, expected at least 10"), "{said}");
    let few = [characterize(&em, &reference, &table), vec!["--min-poses", "3"]].concat();
    let said = fail(&few);
    assert!(said.contains("the body hardly turned"), "{said}");
    // A circle and an arc, each about one axis.
    for name in ["Circle30", "Arc10"] {
        let [em, reference] = of(name);
        let said = fail(&characterize(&em, &reference, &table));
        assert!(said.contains("the body turned about one axis only"), "{said}");
    }
    let [em, reference] = of("Random10");
    let one = [characterize(&em, &reference, &table), vec!["--sensors", "Port 12"]].concat();
    let said = succeed(&one);
    for word in [
        "paths: 1",
        "body from Port 12",
        "offset s",
        "clocks: EM tracker by frames at 320 Hz",
        "written to",
    ] {
        assert!(said.contains(word), "{said}");
    }
    assert!(!said.contains("Port 10"), "{said}");
}

const COLUMNS: &str = "Frame\tState\tQ0\tQx\tQy\tQz\tTx\tTy\tTz";

/// A table of one tool with a few samples of a pose, in a state.
fn recording(scratch: &Scratch, name: &str, pose: &str, state: &str) -> String {
    let mut table = format!("Tools\tPort 1: {name}\t{COLUMNS}\n");
    for frame in 0..5 {
        table += &format!("1\tPort 1: {name}\t{}\t{state}\t{pose}\n", 8 * frame);
    }
    let file = format!("{name}.tsv");
    std::fs::write(scratch.path(&file), table).unwrap();
    scratch.arg(&file)
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
            let name = format!("{name}-{has_one_axis}-{i}");
            let file = recording(scratch, &name, &pose, "OK");
            // The same tool in all.
            let table = std::fs::read_to_string(&file).unwrap().replace(&name, "tool");
            std::fs::write(&file, table).unwrap();
            files.push(file);
        }
    }
    files
}

fn characterize<'a>(em: &'a [String], reference: &'a [String], table: &'a str) -> Vec<&'a str> {
    let mut arguments = vec!["characterize", "--em"];
    arguments.extend(em.iter().map(String::as_str));
    arguments.push("--reference");
    arguments.extend(reference.iter().map(String::as_str));
    arguments.extend(["-o", table]);
    arguments
}

#[test]
fn equal_readings_give_identity_frames() {
    let scratch = Scratch::new();
    let table = scratch.arg("room.csv");
    let [em, reference] = turning(&scratch, false);
    let found = json(&characterize(&em, &reference, &table));
    let sensor = &found["sensors"][0];
    assert!(number(&sensor["position_mm"]["max"]) < 1e-9, "{found}");
    assert!(number(&found["tracker_from_reference"]["pose"][3]) > 1.0 - 1e-12);
    let rows = std::fs::read_to_string(&table).unwrap();
    let header = rows.lines().next().unwrap();
    assert!(header.ends_with("measured_qz,sensor,pair,pose"), "{header}");
    assert_eq!(rows.lines().count(), 13);
    assert!(rows.lines().nth(3).unwrap().ends_with(",Port 1: tool,2,2"), "{rows}");
}

#[test]
fn unusable_recordings_are_refused() {
    let scratch = Scratch::new();
    let table = scratch.arg("room.csv");
    let [em, reference] = turning(&scratch, false);
    let refused = |em: &[String], reference: &[String], words: &[&str]| {
        let said = fail(&characterize(em, reference, &table));
        assert_eq!(said.lines().count(), 1, "{said}");
        for word in words {
            assert!(said.contains(word), "{word}: {said}");
        }
        assert!(!scratch.path("room.csv").exists());
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
    let empty = scratch.arg("empty.tsv");
    std::fs::write(&empty, "").unwrap();
    refused(&[empty], &reference[..1], &["empty.tsv: line 1: found \"\""]);
    let header = scratch.arg("header.tsv");
    std::fs::write(&header, format!("Tools\tPort 1\t{COLUMNS}\n")).unwrap();
    refused(&em[..1], &[header], &["header.tsv: found no rows"]);
    let missing = vec![scratch.arg("none.tsv")];
    refused(&missing, &reference[..1], &["none.tsv: found no such file"]);
}

#[test]
fn every_pair_is_held_out_once() {
    let scratch = Scratch::new();
    let [em, reference] = turning(&scratch, false);
    let [table, held] = ["room.csv", "held.csv"].map(|name| scratch.arg(name));
    let rows = |file: &str| std::fs::read_to_string(file).unwrap().lines().count() - 1;
    let mut seen = Vec::new();
    for part in ["1/4", "2/4", "3/4", "4/4"] {
        let more = ["--hold-out", part, "--held-out", &held, "--min-poses", "9"];
        let found = json(&[&characterize(&em, &reference, &table)[..], &more].concat());
        assert_eq!((rows(&table), rows(&held)), (9, 3), "{part}");
        assert_eq!((&found["readings"], &found["held_out"]), (&9.into(), &3.into()));
        let text = std::fs::read_to_string(&held).unwrap();
        let pair = |line: &str| line.rsplit(',').nth(1).unwrap().parse::<usize>().unwrap();
        seen.extend(text.lines().skip(1).map(pair));
    }
    seen.sort_unstable();
    assert_eq!(seen, (0..12).collect::<Vec<_>>());
    for wrong in ["0/5", "6/5", "1/1", "1", "a/b"] {
        let more = ["--hold-out", wrong, "--held-out", &held];
        let said = fail(&[&characterize(&em, &reference, &table)[..], &more].concat());
        assert!(said.contains("expected K/N"), "{said}");
    }
    let alone =
        fail(&[&characterize(&em, &reference, &table)[..], &["--hold-out", "1/4"]].concat());
    assert!(alone.contains("--held-out"), "{alone}");
    let none = ["--hold-out", "13/13", "--held-out", &held];
    let said = fail(&[&characterize(&em, &reference, &table)[..], &none].concat());
    assert!(said.contains("--hold-out: found no good reading"), "{said}");
}
