//! The built tool against its design: recordings made by the study itself, by a wrong room, of a
//! pivot, and of a real tool.

use crate::support::data::{own, third_party};
use crate::support::golden::{list, number};
use crate::support::program::{Scratch, fail, json, succeed, text, trackwright};
use std::fs;
use std::path::Path;

/// A worked design in a room fitted here; the design as an argument.
fn design(scratch: &Scratch, name: &str, orders: &[&str]) -> String {
    scratch.copy_own(&format!("golden/{name}"), "d");
    fit(scratch, "d/room.env.ron", orders);
    scratch.arg(&format!("d/{name}.design.ron"))
}

fn fit(scratch: &Scratch, to: &str, more: &[&str]) {
    let (data, room) = (text(&own("room-a/room-a-fit.csv")), scratch.arg(to));
    let base = ["fit", &data, "-o", &room];
    succeed(&[&base[..], more].concat());
}

const ROOM: [&str; 4] = ["--order", "2", "--directions", "14"];

/// What the study predicts for the worked input, as a recording of the built tool would say it.
fn predicted_recording(scratch: &Scratch, design: &str, to: &str) -> String {
    let folder = Path::new(design).parent().unwrap();
    let (input, log) = (text(&folder.join("input.csv")), scratch.arg("log.csv"));
    let base = ["simulate", design, "--mode", "input", "--input", &input];
    succeed(&[&base[..], &["--log", &log, "--outside", "clamp"]].concat());
    let table = fs::read_to_string(&log).unwrap();
    let table = table.replace("true_", "ideal_").replace("sim_", "measured_");
    fs::write(scratch.path(to), table).unwrap();
    scratch.arg(to)
}

#[test]
fn a_predicted_recording_is_fully_explained() {
    let scratch = Scratch::new();
    let design = design(&scratch, "pointer-no-crf", &ROOM);
    let recorded = predicted_recording(&scratch, &design, "r.csv");
    let (log, chart) = (scratch.arg("out.csv"), scratch.arg("out.svg"));
    let outputs = ["--log", &log, "--chart", &chart, "--outside", "clamp"];
    let found = json(&[&["verify", &design, &recorded], &outputs[..]].concat());
    let poses = found["poses"].as_u64().unwrap() as usize;
    assert_eq!(found["used"], poses);
    assert_eq!(found["frame"], "tracker");
    assert_eq!(found["verdict"], "explains");
    let position = &found["position_mm"];
    assert!(number(&position["measured"]["rms"]) > 0.2);
    assert!(number(&position["residual"]["max"]) < 1e-9, "{position}");
    assert!((number(&position["explained"]["value"]) - 1.0).abs() < 1e-9);
    assert!(number(&found["angle_deg"]["residual"]["max"]) < 1e-9);
    // Of the same poses in fields that the room's measurements leave possible.
    let expected = number(&found["expected"]["position_mm"]["rms"]);
    let [low, high] = [0, 1].map(|k| number(&found["intervals"]["position_mm"]["rms"][k]));
    assert!(low < expected && expected < high, "{found}");
    let words = succeed(&["verify", &design, &recorded, "--outside", "clamp"]);
    assert!(words.contains("expected tip error RMS"), "{words}");
    // As `simulate` has it.
    let input = scratch.arg("d/input.csv");
    let study = json(&["simulate", &design, "--mode", "input", "--input", &input]);
    let [a, b] = [&study["position_mm"], &position["predicted"]].map(|s| number(&s["rms"]));
    assert!((a - b).abs() < 1e-9 * a, "{a} {b}");

    let table = fs::read_to_string(&log).unwrap();
    assert_eq!(table.lines().count(), poses + 1);
    assert!(table.starts_with("true_x,true_y,"), "{table}");
    let svg = fs::read_to_string(&chart).unwrap();
    assert!(svg.contains("measured") && svg.contains("predicted"));
    let words = succeed(&["verify", &design, &recorded, "--outside", "clamp"]);
    assert!(words.contains("The simulation explains 100 %"), "{words}");
    assert!(words.contains("Assumed: the tracker computes"), "{words}");
}

#[test]
fn the_crf_recording_is_optional() {
    let scratch = Scratch::new();
    let design = design(&scratch, "pointer-on-head", &ROOM);
    // The CRF where the design has it.
    let input = fs::read_to_string(scratch.path("d/input.csv")).unwrap();
    let rows: Vec<String> = input
        .lines()
        .map(|line| line.split(',').rev().take(7).collect::<Vec<_>>())
        .map(|cells| cells.into_iter().rev().collect::<Vec<_>>().join(","))
        .collect();
    fs::write(scratch.path("d/input.csv"), rows.join("\n")).unwrap();
    let recorded = predicted_recording(&scratch, &design, "r.csv");
    let base = ["verify", &design, &recorded, "--outside", "clamp"];
    let found = json(&[&base[..], &["--frame", "crf"]].concat());
    assert_eq!(found["frame"], "crf");
    assert!(number(&found["position_mm"]["residual"]["max"]) < 1e-9);
    assert_eq!(found["verdict"], "explains");
    let crf = scratch.arg("r.csv");
    let message = fail(&[&base[..], &["--frame", "crf", "--crf", &crf]].concat());
    assert!(message.contains("cannot be used with"), "{message}");
}

#[test]
fn moments_of_one_body_alone_are_counted_and_told() {
    let scratch = Scratch::new();
    let design = design(&scratch, "pointer-on-head", &ROOM);
    let recorded = predicted_recording(&scratch, &design, "r.csv");
    let rows = fs::read_to_string(&recorded).unwrap().lines().count() - 1;
    let names = ["x", "y", "z", "qw", "qx", "qy", "qz"];
    let header = ["ideal", "measured"].map(|of| names.map(|name| format!("{of}_{name}")).join(","));
    let at_rest = "0,0,-225,1,0,0,0,0,0,-225,1,0,0,0";
    for (crf_rows, alone, [without_crf, without_tool]) in
        [(rows + 3, "crf.csv: 3 of", [0, 3]), (rows - 2, "r.csv: 2 of", [2, 0])]
    {
        let crf = scratch.arg("crf.csv");
        let table = format!("{}\n{}", header.join(","), format!("{at_rest}\n").repeat(crf_rows));
        fs::write(&crf, table).unwrap();
        let more = ["--crf", &crf, "--same-frame", "--outside", "clamp"];
        let args = [&["verify", &design, &recorded][..], &more].concat();
        let found = json(&args);
        assert_eq!(found["without_crf"], without_crf);
        assert_eq!(found["without_tool"], without_tool);
        let output = trackwright(&args).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(said.contains(alone) && said.contains("poses not used"), "{said}");
    }
}

#[test]
fn an_unrelated_room_explains_nothing() {
    let scratch = Scratch::new();
    let design = design(&scratch, "pointer-no-crf", &ROOM);
    let recorded = predicted_recording(&scratch, &design, "r.csv");
    // The same room seen in a mirror: every error has the wrong sign.
    let data = fs::read_to_string(own("room-a/room-a-fit.csv")).unwrap();
    let swapped = data
        .replace("ideal_", "other_")
        .replace("measured_", "ideal_")
        .replace("other_", "measured_");
    fs::write(scratch.path("wrong.csv"), swapped).unwrap();
    let (wrong, room) = (scratch.arg("wrong.csv"), scratch.arg("d/room.env.ron"));
    succeed(&[&["fit", &wrong, "-o", &room][..], &ROOM].concat());
    let found = json(&["verify", &design, &recorded, "--outside", "clamp"]);
    assert_eq!(found["verdict"], "worse_than_nothing", "{found}");
    assert!(number(&found["position_mm"]["explained"]["high"]) < 0.0);
}

#[test]
fn separate_sensor_recordings_are_fitted() {
    let scratch = Scratch::new();
    let design = design(&scratch, "pointer-no-crf", &ROOM);
    let whole = predicted_recording(&scratch, &design, "r.csv");
    // What each sensor of the tool reads: its own pose, distorted by the room.
    let poses = fs::read_to_string(&whole).unwrap();
    let body = [
        ("s0", [0.0, 0.0, 60.0], [1.0, 0.0, 0.0, 0.0]),
        ("s1", [8.0, 0.0, 95.0], [(0.5_f64).sqrt(), (0.5_f64).sqrt(), 0.0, 0.0]),
    ];
    let sensors = "(name: \"s0\", kind: FiveDof, position: (0.0, 0.0, 60.0), axis: (0, 0, 1)),\
        (name: \"s1\", kind: FiveDof, position: (8.0, 0.0, 95.0), axis: (0, -1, 0))";
    let tool = format!("(version: 1, name: \"Tool\", tip: (0, 0, -35), sensors: [{sensors}])");
    fs::write(scratch.path("d/tool.body.ron"), tool).unwrap();
    let mut true_poses = String::from("x,y,z,qw,qx,qy,qz\n");
    let mut labels = Vec::new();
    for (k, line) in poses.lines().skip(1).enumerate() {
        let cells: Vec<f64> = line.split(',').take(7).map(|c| c.parse().unwrap()).collect();
        for (name, at, turn) in &body {
            let own = compose(&cells, at, turn).map(|v| v.to_string());
            true_poses.push_str(&format!("{}\n", own.join(",")));
            labels.push(format!("Port {name},{k}"));
        }
    }
    fs::write(scratch.path("true.csv"), &true_poses).unwrap();
    let [room, truth, read] = ["d/room.env.ron", "true.csv", "read.csv"].map(|n| scratch.arg(n));
    succeed(&["distort", &room, &truth, "-o", &read]);
    let read = fs::read_to_string(&read).unwrap();
    let names = ["x", "y", "z", "qw", "qx", "qy", "qz"];
    let head = |whose: &str| names.map(|n| format!("{whose}_{n}")).join(",");
    let mut table = format!("{},{},sensor,pose\n", head("ideal"), head("measured"));
    let rows = true_poses.lines().skip(1).zip(read.lines().skip(1)).zip(&labels);
    for ((ideal, measured), label) in rows {
        let measured: Vec<&str> = measured.split(',').take(7).collect();
        table.push_str(&format!("{ideal},{},{label}\n", measured.join(",")));
    }
    fs::write(scratch.path("sensors.csv"), table).unwrap();
    let sensors = scratch.arg("sensors.csv");
    let found = json(&["verify", &design, &sensors, "--outside", "clamp"]);
    assert_eq!(found["sensors"]["count"], 2);
    assert!(number(&found["sensors"]["misfit_rms_mm"]) < 1e-9);
    assert!(number(&found["position_mm"]["residual"]["max"]) < 1e-8, "{found}");
    assert_eq!(found["verdict"], "explains");
    // A sensor that the design does not have the name of.
    let wrong = fs::read_to_string(&sensors).unwrap().replace("Port s1", "Port q");
    fs::write(&sensors, wrong).unwrap();
    let message = fail(&["verify", &design, &sensors]);
    assert!(message.contains("Port s0; Port q") && message.contains("s0; s1"), "{message}");
}

/// A body's pose with a sensor's place and turn on it.
fn compose(body: &[f64], at: &[f64; 3], turn: &[f64; 4]) -> [f64; 7] {
    let q = [body[3], body[4], body[5], body[6]];
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let v = [q[1], q[2], q[3]];
    let u = cross(v, *at);
    let w = cross(v, u);
    let shift = |k: usize| body[k] + at[k] + 2.0 * (q[0] * u[k] + w[k]);
    let tv = [turn[1], turn[2], turn[3]];
    let c = cross(v, tv);
    let scalar = q[0] * turn[0] - (0..3).map(|k| v[k] * tv[k]).sum::<f64>();
    let imaginary = |k: usize| q[0] * tv[k] + turn[0] * v[k] + c[k];
    [shift(0), shift(1), shift(2), scalar, imaginary(0), imaginary(1), imaginary(2)]
}

#[test]
fn unusable_built_tool_recordings_are_refused() {
    let scratch = Scratch::new();
    let design = design(&scratch, "pointer-no-crf", &ROOM);
    let recorded = predicted_recording(&scratch, &design, "r.csv");
    let table = fs::read_to_string(&recorded).unwrap();
    let lines: Vec<&str> = table.lines().collect();
    let refused = |content: String| {
        fs::write(scratch.path("bad.csv"), content).unwrap();
        let log = scratch.arg("never.csv");
        let message = fail(&["verify", &design, &scratch.arg("bad.csv"), "--log", &log]);
        assert!(!scratch.path("never.csv").exists());
        message
    };
    let few = refused(lines[..6].join("\n"));
    assert!(few.contains("bad.csv") && few.contains("expected at least 10"), "{few}");
    let same = refused([&[lines[0]][..], &[lines[1]; 30]].concat().join("\n"));
    assert!(same.contains("all 30 poses are the same"), "{same}");
    let first: Vec<&str> = lines[1].split(',').collect();
    let nan = lines[1].replacen(first[0], "NaN", 1);
    let nan = refused([&[lines[0], &nan][..], &lines[2..]].concat().join("\n"));
    assert!(nan.contains("line 2") && nan.contains("NaN"), "{nan}");
    let away: Vec<String> = lines
        .iter()
        .enumerate()
        .map(|(k, line)| match (k, line.split_once(',')) {
            (1.., Some((_, rest))) => format!("{}000,{rest}", 10 + k),
            _ => (*line).to_owned(),
        })
        .collect();
    let away = refused(away.join("\n"));
    assert!(away.contains("outside the room's box"), "{away}");
    let empty = refused(String::new());
    assert!(empty.contains("ideal_x"), "{empty}");
    let two = fail(&["verify", &design, &recorded, &recorded]);
    assert!(two.contains("expected one"), "{two}");
    let none = fail(&["verify", &design, &recorded, "--crf", &recorded]);
    assert!(none.contains("the design has no CRF"), "{none}");
}

#[test]
fn a_real_pivot_has_the_error_that_pivot_says() {
    let Some(file) = third_party("pivot/poses-57.txt") else {
        return;
    };
    let scratch = Scratch::new();
    let design = design(&scratch, "pointer-no-crf", &ROOM);
    let file = text(&file);
    // Metres away from the room of this test, which explains nothing of it.
    let base = ["verify", &design, &file, "--pivot"];
    let found = json(&[&base[..], &["--outside", "clamp"]].concat());
    let pivot = json(&["pivot", &file]);
    let measured = number(&found["position_mm"]["measured"]["rms"]);
    // True axes are a little off those that were read, and a shift of the tip is taken out in them.
    let ratio = measured / number(&pivot["rms_mm"]);
    assert!((ratio - 1.0).abs() < 0.01, "{ratio}");
    assert_eq!(found["outside"], 57);
    assert_eq!(found["unknowns"], "pivot");
    for (k, value) in list(&found["tip"], "recorded").iter().enumerate() {
        assert!((number(value) - number(&pivot["tip"][k])).abs() < 1e-6);
    }
    let message = fail(&base);
    assert!(message.contains("57 have a sensor outside the room's box"), "{message}");
}

#[test]
fn half_of_the_real_poses_predict_the_other() {
    let Some(folder) = third_party("aurora-polaris/static") else {
        return;
    };
    let scratch = Scratch::new();
    let files = |first: &str, half: usize| -> Vec<String> {
        let mut all: Vec<String> = fs::read_dir(&folder)
            .unwrap()
            .map(|entry| text(&entry.unwrap().path()))
            .filter(|file| file.contains(&format!("/{first}_")))
            .collect();
        all.sort();
        all.into_iter().skip(half).step_by(2).collect()
    };
    let characterised = |half: usize, to: &str| {
        let mut args = vec!["characterize".to_owned(), "--em".to_owned()];
        args.extend(files("EM", half));
        args.push("--reference".to_owned());
        args.extend(files("OT", half));
        args.extend(["-o".to_owned(), scratch.arg(to)]);
        json(&args.iter().map(String::as_str).collect::<Vec<_>>())
    };
    let found = characterised(0, "room.csv");
    characterised(1, "held-out.csv");
    let (data, room) = (scratch.arg("room.csv"), scratch.arg("room.env.ron"));
    let model = ["--sensors", "6dof", "--order", "1", "--directions", "6"];
    succeed(&[&["fit", &data, "-o", &room, "--ridge", "0.1"], &model[..]].concat());
    // The body as the room's half has it; the point between its sensors for a tip.
    let mut middle = [0.0; 3];
    let mut sensors = String::new();
    for sensor in list(&found, "sensors") {
        let pose: Vec<f64> = list(sensor, "body_from_sensor").iter().map(number).collect();
        for k in 0..3 {
            middle[k] += pose[k] / 3.0;
        }
        let name = sensor["name"].as_str().unwrap().split(':').next().unwrap();
        let [x, y, z, qw, qx, qy, qz] = pose[..] else {
            panic!("{pose:?}");
        };
        sensors.push_str(&format!(
            "(name: \"{name}\", kind: SixDof, position: ({x}, {y}, {z}), rotation: ({qw}, {qx}, {qy}, {qz})),"
        ));
    }
    let [x, y, z] = middle;
    let body = format!("(version: 1, name: \"b\", tip: ({x}, {y}, {z}), sensors: [{sensors}])");
    fs::write(scratch.path("b.body.ron"), body).unwrap();
    let pose = "(position: (0, 0, -250), rotation: (1, 0, 0, 0))";
    let design = format!(
        "(version: 1, name: \"b\", environment: \"room.env.ron\", tool: (body: \"b.body.ron\", pose: {pose}))"
    );
    fs::write(scratch.path("b.design.ron"), design).unwrap();
    let [design, held_out] = ["b.design.ron", "held-out.csv"].map(|name| scratch.arg(name));
    let base = ["verify", &design, &held_out, "--registered", "--averaged", "100"];
    let found = json(&base);
    assert_eq!(found["verdict"], "explains", "{}", found["statement"]);
    let explained = &found["position_mm"]["explained"];
    // With a model that `select` chose it is 84 % (docs/methods/built-tool.md).
    assert!((0.7..0.95).contains(&number(&explained["value"])), "{explained}");
    assert!(number(&explained["low"]) > 0.5, "{explained}");
    assert!(number(&found["angle_deg"]["explained"]["value"]) > 0.3);
    // 45 poses in the order of a hand's way through the room.
    assert!(number(&found["effective"]) < 45.0);
}
