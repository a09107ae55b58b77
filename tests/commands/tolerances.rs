//! The manufacturing sheet as a workshop gets it: text, JSON, table, and the check by drawn tools.

use crate::support::golden::{list, number, numbers};
use crate::support::program::{Scratch, fail, trackwright};
use serde_json::Value;
use std::fs;

fn design(name: &str) -> String {
    format!("{}/designs/{name}.design.ron", env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn the_sheet_is_the_same_in_every_format() {
    let scratch = Scratch::new();
    let (pointer, csv) = (design("pointer-on-head"), scratch.arg("sheet.csv"));
    let found = scratch.json(format!("tolerances {pointer} --csv {csv} --check 20"));
    assert_eq!(found["no_tolerances"], Value::Null);
    assert_eq!((&found["poses"], &found["study_poses"]), (&3375.into(), &3375.into()));
    assert_eq!(found["check"]["met"], 20);
    let bodies = list(&found, "bodies");
    assert_eq!(bodies.len(), 2);
    assert_eq!((&bodies[0]["role"], &bodies[1]["role"]), (&"tool".into(), &"crf".into()));
    let shaft = &bodies[0]["sensors"][0];
    assert_eq!((&shaft["name"], &shaft["kind"]), (&"shaft".into(), &"5 DOF".into()));
    assert_eq!(numbers::<3>(&shaft["position_in_body_mm"]), [0.0, 0.0, 72.0]);
    assert_eq!(number(&shaft["distance_from_tip_mm"]), 72.0);
    assert_eq!(number(&shaft["axis"]["polar_deg"]), 0.0);
    let position = &shaft["alone"]["position_mm"];
    assert!(number(&position["value"]) <= number(&position["simulated"]));
    assert_eq!(position["limited_by"]["met"], true);

    let table = fs::read_to_string(&csv).unwrap();
    let rows: Vec<Vec<&str>> = table.lines().map(|l| l.split(',').collect()).collect();
    assert_eq!(rows.len(), 7);
    let column = |name: &str| rows[0].iter().position(|c| *c == name).unwrap();
    let cell = |row: usize, name: &str| rows[row][column(name)].to_owned();
    assert_eq!((cell(1, "role"), cell(1, "sensor")), ("tool".into(), "shaft".into()));
    let stated: f64 = cell(1, "alone_position_mm").parse().unwrap();
    assert_eq!(stated, number(&position["value"]));
    let together: f64 = cell(6, "together_angle_deg").parse().unwrap();
    assert_eq!(together, number(&bodies[1]["together"]["angle_deg"]["value"]));

    let text = scratch.succeed(format!("tolerances {pointer} --check 20"));
    for part in [
        "Origin: the tip.",
        "in the direction +z",
        "shaft – grip",
        "tool, every sensor",
        "Worst allowed combination: position RMS",
        "all 20 drawn tools meet the requirement",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

/// The built-in pointer with other words in its design, which is saved beside the files it needs.
fn changed(scratch: &Scratch, from: &str, to: &str) -> String {
    let text = fs::read_to_string(design("pointer-on-head")).unwrap();
    let assets = format!("{}/assets", env!("CARGO_MANIFEST_DIR"));
    let text = text.replace("../assets", &assets);
    assert!(text.contains(from));
    scratch.write("changed.design.ron", text.replace(from, to));
    scratch.arg("changed.design.ron")
}

#[test]
fn the_sheet_states_missed_requirements() {
    let scratch = Scratch::new();
    let requirement = "requirement: (position_rms: 1.0, angle_rms: 0.5),";
    let missed = changed(&scratch, requirement, "requirement: (position_max: 0.1),");
    let text = scratch.succeed(format!("tolerances {missed} --check 5"));
    assert!(text.contains("No tolerances: the requirement is missed"), "{text}");
    assert!(text.contains("shaft"), "{text}");
    let found = scratch.json(format!("tolerances {missed}"));
    assert_eq!(found["bodies"][0]["together"], Value::Null);
    let none = changed(&scratch, requirement, "");
    let text = scratch.succeed(format!("tolerances {none}"));
    assert!(text.contains("the design states no requirement"), "{text}");
}

#[test]
fn bad_arguments_of_tolerances_are_refused() {
    let pointer = design("pointer-on-head");
    for draws in ["0", "1000001", "many"] {
        let error = fail(&["tolerances", &pointer, "--check", draws]);
        assert!(error.contains("expected 1 to 1000000"), "{error}");
    }
    let error = fail(&["tolerances", "nowhere.design.ron"]);
    assert!(error.contains("nowhere.design.ron"), "{error}");
    let output =
        trackwright(&["tolerances", &pointer, "--csv", "/nowhere/sheet.csv"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(output.stdout.is_empty());
}
