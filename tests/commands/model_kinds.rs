//! Kinds of models on real errors: what each leaves of rows it has not seen, and what is refused.

use crate::rooms::tracker::Random;
use crate::support::close::assert_close;
use crate::support::data::own;
use crate::support::golden::{list, number};
use crate::support::program::{Scratch, assert_has};
use crate::support::table::{POSE, POSITIONS, measurement_columns};
use serde_json::Value;
use std::fs;
use std::io::{BufWriter, Write};

const ROOM: &str = "own:room-a/room-a-fit.csv";
const HOLDOUT: &str = "own:room-a/room-a-holdout.csv";

/// Writes the first rows of room-a.
fn write_rows(scratch: &Scratch, name: &str, rows: usize) {
    let table = fs::read_to_string(own("room-a/room-a-fit.csv")).unwrap();
    let lines: Vec<_> = table.lines().take(rows + 1).collect();
    scratch.write(name, lines.join("\n") + "\n");
}

fn held_out_mm(fitted: &Value) -> f64 {
    number(&fitted["holdout"]["after"]["position_rms_mm"])
}

/// What is distorted in `room.env.ron` and compensated there is what it was.
fn assert_compensates(scratch: &Scratch) {
    let places = ["0,0,-300", "90,-60,-220", "-110,80,-380", "40,120,-260"];
    let rows = places.map(|at| format!("{at},0.8,0.0,0.6,0.0\n"));
    scratch.write("poses.csv", format!("{POSE}\n{}", rows.concat()));
    scratch.succeed("distort room.env.ron poses.csv -o measured.csv");
    scratch.succeed("compensate room.env.ron measured.csv -o corrected.csv");
    let [true_mm, read_mm, found_mm] =
        ["poses.csv", "measured.csv", "corrected.csv"].map(|file| scratch.table(file).first::<3>());
    for ((true_mm, read_mm), found_mm) in true_mm.iter().zip(read_mm).zip(found_mm) {
        assert!((0..3).any(|k| (true_mm[k] - read_mm[k]).abs() > 0.05), "{read_mm:?}");
        for k in 0..3 {
            assert!((found_mm[k] - true_mm[k]).abs() < 1e-8, "{found_mm:?} {true_mm:?}");
        }
    }
}

#[test]
fn kriging_beats_polynomials_on_unseen_rows() {
    let scratch = Scratch::new();
    let fit =
        |more: &str| scratch.json(format!("fit {ROOM} -o room.env.ron --holdout {HOLDOUT} {more}"));
    let polynomials = fit("--order 2 --directions 14 --ridge 0.01");
    let symmetric = fit("--order 2 --directions 14 --ridge 0.01 --symmetric yes");
    let kriging = fit("--model kriging");
    assert_eq!(kriging["model"], "kriging");
    assert_eq!(kriging["order"], Value::Null);
    assert!(held_out_mm(&symmetric) < held_out_mm(&polynomials), "{symmetric}");
    // The bound of the issue that requested it; 1.05 mm.
    assert!(held_out_mm(&kriging) < 1.15, "{kriging}");
    assert!(held_out_mm(&kriging) < held_out_mm(&symmetric));
    assert_compensates(&scratch);
}

#[test]
fn a_learned_generator_serves_the_other_half() {
    let scratch = Scratch::new();
    let learned =
        scratch.json(format!("generator learn {ROOM} -o own.generator.ron --rows 400 --degree 3"));
    assert_eq!(learned["name"], "own");
    assert_eq!(list(&learned, "starts").len(), 2);
    let model = "--model harmonic --generator own.generator.ron --degree 5";
    let fitted = scratch.json(format!("fit {ROOM} -o room.env.ron --holdout {HOLDOUT} {model}"));
    assert_eq!(fitted["harmonic"]["generator"], "own");
    assert!(held_out_mm(&fitted) < 0.75, "{fitted}");
    assert_compensates(&scratch);
    let body = format!("{}/assets/bodies/pointer.body.ron", env!("CARGO_MANIFEST_DIR"));
    scratch.write_design("pointer", &body, [0.0, 0.0, -250.0], "");
    let simulated = scratch.json("simulate pointer.design.ron --mode single");
    let rms = &simulated["figures"]["position_mm"]["rms"];
    let [value, low, high] = ["value", "low", "high"].map(|end| number(&rms[end]));
    assert!(low < value && value < high, "{simulated}");
}

#[test]
fn select_compares_kinds_on_the_same_rows() {
    let scratch = Scratch::new();
    let models = "--models bernstein,symmetric,kriging,harmonic --generator planar-nine --degree 4";
    let sizes = "--orders 1-2 --directions 14 --ridges 0.01 --folds 3";
    let found = scratch.json(format!("select {ROOM} {models} {sizes} -o room.env.ron"));
    let kinds = list(&found["models"], "kinds");
    let of = |name: &str| kinds.iter().find(|kind| kind["model"] == name).unwrap();
    let rms = |name: &str| number(&of(name)["cv"]["position_rms_mm"]);
    assert!(rms("symmetric") < rms("bernstein"));
    assert!(rms("kriging") < rms("symmetric"));
    assert!(rms("harmonic") < rms("kriging"));
    assert_eq!(of("harmonic")["is_chosen"], true);
    // The polynomials are judged as the table of orders judges them.
    let is_best = |row: &&Value| ["order", "ridge"].iter().all(|k| row[k] == found["best"][k]);
    let best = list(&found, "table").iter().find(is_best).unwrap();
    let best_mm = number(&best["cv"]["position_rms_mm"]);
    assert_close("bernstein", rms("bernstein"), best_mm, 1e-9, 1e-9);
    assert_eq!(found["fit"]["model"], "harmonic");
    let text = scratch.read("room.env.ron");
    assert!(text.contains("harmonic: ("));
}

#[test]
fn a_ridge_makes_a_harmonic_model_smoother() {
    let scratch = Scratch::new();
    let fit = format!("fit {ROOM} -o room.env.ron --generator planar-nine --degree 6 --no-support");
    let usual = scratch.json(&fit);
    assert_eq!(usual["harmonic"]["ridge"], 1e-6);
    let train = |found: &Value| number(&found["train"]["after"]["position_rms_mm"]);
    let mut left = train(&usual);
    for ridge in [1e-3, 1e-2, 1e-1] {
        let found = scratch.json(format!("{fit} --ridge {ridge}"));
        assert_eq!(found["harmonic"]["ridge"], ridge);
        // Damped coefficients follow the fitted rows less.
        assert!(train(&found) > left, "{ridge}: {} after {left}", train(&found));
        left = train(&found);
        assert!(scratch.read("room.env.ron").contains(&format!("ridge: {ridge}")));
    }
    scratch.succeed_with(format!("{fit} --ridge 0.01"), &["degree 6, ridge 1e-2"]);
}

#[test]
fn contradicting_options_are_refused() {
    let scratch = Scratch::new();
    write_rows(&scratch, "few.csv", 3);
    write_rows(&scratch, "149.csv", 149);
    let rows = "0,0,-200,0,0,-201\n9,0,-200,9,1,-200\n";
    scratch.write("positions.csv", format!("{POSITIONS}\n{rows}"));
    for (file, args, part) in [
        (ROOM, "--model harmonic", "found no --generator"),
        (ROOM, "--model kriging --order 2", "--order does not go with --model kriging"),
        (ROOM, "--model kriging --ridge 0.1", "--ridge does not go with --model kriging"),
        (ROOM, "--generator planar-nine --ridge=-1", "ridge is -1, expected"),
        (ROOM, "--model kriging --no-support", "made of the measurements"),
        (ROOM, "--model kriging --symmetric yes", "--symmetric belongs to"),
        (ROOM, "--model kriging --generator anser", "belong to --model harmonic"),
        (ROOM, "--model harmonic --generator anser --degree 11", "found 11, expected 1 to 10"),
        (ROOM, "--model harmonic --generator nobody", "nobody"),
        (
            ROOM,
            "--model harmonic --generator anser --map correction",
            "expected the distortion map",
        ),
        ("few.csv", "--model kriging", "found 3 measurements, expected at least 4"),
        (
            "149.csv",
            "--model harmonic --generator learn",
            "149 measurements, expected at least 150 to learn a generator from",
        ),
        ("positions.csv", "--model harmonic --generator planar-nine", "no orientations"),
    ] {
        scratch.fail_with(format!("fit {file} -o room.env.ron {args}"), &[part]);
    }
    let words = "found \"splines\", expected none, bernstein, harmonic, kriging, symmetric";
    scratch.fail_with(format!("select {ROOM} --models bernstein,splines"), &[words]);
}

#[test]
fn a_learning_curve_has_a_line_a_kind() {
    let scratch = Scratch::new();
    let models = "bernstein,kriging,harmonic";
    let base = format!("select {ROOM} --models {models} --generator planar-nine");
    let quick = "--degree 4 --orders 1,2 --directions 14";
    let curve = format!("{base} {quick} --learning-curve curve.svg --rows");
    let found = scratch.json(format!("{curve} 100,400"));
    let points = list(&found, "learning_curve");
    let rms = |point: &Value, name: &str| {
        let kind = list(point, "kinds").iter().find(|kind| kind["model"] == name).unwrap();
        number(&kind["cv"]["position_rms_mm"])
    };
    for name in models.split(',') {
        let [few, many] = [0, 1].map(|i| rms(&points[i], name));
        assert!(many < few, "{name}: {few} of 100 rows, {many} of 400");
    }
    assert!(rms(&points[1], "harmonic") < 0.5 * rms(&points[1], "bernstein"));
    assert_eq!(points[1]["rows"], 400);
    let svg = scratch.read("curve.svg");
    assert_has(&svg, &models.split(',').collect::<Vec<_>>(), "curve.svg");
    let words = ["--rows: found 10, expected numbers of rows, 50 and more"];
    scratch.refused(format!("{curve} 10"), &words);
    scratch.refused(format!("select {ROOM} --rows 100"), &["--learning-curve"]);
}

#[test]
fn known_generator_200_rows_below_half_a_mm() {
    let scratch = Scratch::new();
    let cube = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/environments/data/cube");
    let all = fs::read_to_string(format!("{cube}-fit.csv")).unwrap();
    let some: Vec<&str> = all.lines().take(201).collect();
    scratch.write("some.csv", some.join("\n"));
    let model = "--model harmonic --generator planar-nine";
    let fitted =
        scratch.json(format!("fit some.csv -o cube.env.ron {model} --holdout {cube}-holdout.csv"));
    assert!(held_out_mm(&fitted) < 0.5, "{fitted}");
}

#[test]
fn a_million_rows_are_fitted_and_a_subset_is_named() {
    let scratch = Scratch::new();
    let mut out = BufWriter::new(fs::File::create(scratch.path("million.csv")).unwrap());
    writeln!(out, "{}", measurement_columns()).unwrap();
    // A shift that grows with the square of the height, seen from four ways of the sensor.
    let rotations = ["1,0,0,0", "0.8,0.6,0,0", "0.8,0,0.6,0", "0.6,0,0.8,0"];
    for row in 0..1_000_000_u32 {
        let [x, y, z] = [row % 100, row / 100 % 100, row / 10_000].map(|k| f64::from(k) * 4.0);
        let rotation = rotations[(row % 4) as usize];
        let shift = 2.0 * (z / 400.0).powi(2);
        writeln!(out, "{x},{y},{z},{rotation},{:.4},{y},{z},{rotation}", x + shift).unwrap();
    }
    out.into_inner().unwrap();
    scratch.write("poses.csv", format!("{POSE}\n101,203,302,0.8,0,0.6,0\n"));
    for (kind, settings, made) in [
        ("bernstein", "--order 2 --directions 6", "expected figures"),
        ("kriging", "", "model and expected figures"),
    ] {
        let fit = format!("fit million.csv -o m.env.ron --model {kind} {settings}");
        let printed = scratch.succeed(fit);
        let line = format!("{made}: from 4,000 of the 1,000,000 samples, chosen at random");
        assert!(printed.lines().any(|other| other == line), "{printed}");
        scratch.succeed("distort m.env.ron poses.csv -o measured.csv");
        let shift_mm = scratch.table("measured.csv").number(0, "x") - 101.0;
        let expected_mm = 2.0 * (302.0_f64 / 400.0).powi(2);
        assert!((shift_mm - expected_mm).abs() < 0.01, "{kind}: {shift_mm}");
    }
}

#[test]
fn a_plain_fit_takes_the_best_kind_and_states_why() {
    let scratch = Scratch::new();
    write_rows(&scratch, "some.csv", 400);
    let (fitted, notes) = scratch.json_and_notes("fit some.csv -o room.env.ron");
    assert_eq!(fitted["harmonic"]["generator"], "planar-nine", "{fitted}");
    let reason = fitted["models"]["reason"].as_str().unwrap();
    assert!(notes.contains(reason), "{notes}");
    assert_has(reason, &["chosen: harmonic, generator planar-nine", "may do better"], "reason");
    let kinds = list(&fitted["models"], "kinds");
    let left_mm = |name: &str| {
        let kind = kinds.iter().find(|kind| kind["model"] == name).unwrap();
        number(&kind["cv"]["position_rms_mm"])
    };
    assert!(left_mm("harmonic") < 0.3 * left_mm("kriging"), "{fitted}");
    assert!(left_mm("kriging") < left_mm("bernstein") && left_mm("bernstein") < left_mm("none"));
    let left_out = list(&fitted["models"], "left_out");
    let anser = left_out.iter().find(|kind| kind["model"] == "harmonic, anser").unwrap();
    assert_has(anser["reason"].as_str().unwrap(), &["of the first rows held out"], "reason");
    // The list is that of `select`, and its room the same.
    fs::create_dir(scratch.path("again")).unwrap();
    let listed = scratch.json("select some.csv -o again/room.env.ron");
    assert_eq!(listed["models"], fitted["models"]);
    let room = scratch.read("room.env.ron");
    assert!(room == scratch.read("again/room.env.ron") && room.contains("refits: ["));
    // An option of polynomials names them.
    let polynomials = scratch.json("fit some.csv -o p.env.ron --order 1 --directions 6");
    assert_eq!(polynomials["model"], "bernstein");
    assert!(polynomials["models"].is_null());
}

#[test]
fn what_is_only_noise_is_not_corrected() {
    let scratch = Scratch::new();
    let mut random = Random::new(5);
    let mut lines = vec![POSITIONS.to_owned()];
    for _ in 0..120 {
        let p = [0; 3].map(|_| random.range(-150.0, 150.0));
        let e = random.normal() * 0.8;
        let q = [p[0] + e.x, p[1] + e.y, p[2] + e.z];
        let row: Vec<String> = p.iter().chain(&q).map(f64::to_string).collect();
        lines.push(row.join(","));
    }
    scratch.write("noise.csv", lines.join("\n") + "\n");
    let fitted = scratch.json("fit noise.csv -o noise.env.ron");
    assert_eq!(fitted["order"], 0, "{fitted}");
    let kinds = list(&fitted["models"], "kinds");
    let chosen = kinds.iter().find(|kind| kind["is_chosen"] == true).unwrap();
    assert_eq!(chosen["model"], "none");
}

#[test]
fn a_generator_that_a_choice_learned_is_the_fits() {
    let scratch = Scratch::new();
    write_rows(&scratch, "some.csv", 200);
    for folder in ["chosen", "fitted"] {
        fs::create_dir(scratch.path(folder)).unwrap();
    }
    let learned = "--generator learn --degree 2";
    let select = format!("select some.csv --models harmonic {learned} -o chosen/room.env.ron");
    let kinds = scratch.json(select)["models"]["kinds"].clone();
    let ridge = &kinds[0]["ridge"];
    let fit = format!("fit some.csv --model harmonic {learned} --ridge {ridge}");
    scratch.succeed(format!("{fit} -o fitted/room.env.ron"));
    assert!(scratch.read("chosen/room.env.ron") == scratch.read("fitted/room.env.ron"));
}
