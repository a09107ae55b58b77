//! Rooms with too few measurements: no figure without its interval, and the verdict *cannot
//! tell*, in every command that names one.

use crate::rooms::tracker::{Random, Room};
use crate::support::golden::number;
use crate::support::program::Scratch;
use nalgebra::{UnitQuaternion, Vector3};
use serde_json::Value;
use std::fmt::Write;
use std::fs;

/// Rows of a room: readings of sensors at places by chance that `is_measured` names.
fn write_table(
    scratch: &Scratch,
    room: &Room,
    rows: usize,
    is_measured: impl Fn(&Vector3<f64>) -> bool,
) -> String {
    let mut random = Random::new(17);
    let mut table = String::new();
    let columns = ["x", "y", "z", "qw", "qx", "qy", "qz"];
    let names = ["ideal", "measured"].map(|of| columns.map(|name| format!("{of}_{name}")));
    writeln!(table, "{}", names.concat().join(",")).unwrap();
    let mut written = 0;
    while written < rows {
        let sensor = (room.position(&mut random), random.direction());
        let reading = room.measure(&sensor, &mut random);
        let Some(reading) = reading.filter(|_| is_measured(&sensor.0)) else {
            continue;
        };
        let cells = [sensor, reading].map(|(p, n)| {
            let turn = UnitQuaternion::rotation_between(&Vector3::z(), &n)
                .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), 3.2));
            let [x, y, z, w]: [f64; 4] = turn.coords.into();
            [p.x, p.y, p.z, w, x, y, z].map(|v| v.to_string()).join(",")
        });
        writeln!(table, "{}", cells.join(",")).unwrap();
        written += 1;
    }
    scratch.write("rows.csv", table);
    "rows.csv".to_owned()
}

/// A pointer that moves about a place, with a bound on its RMS.
fn write_design(scratch: &Scratch, name: &str, at: &Vector3<f64>, limit_mm: f64) -> String {
    let body = format!("{}/assets/bodies/pointer.body.ron", env!("CARGO_MANIFEST_DIR"));
    let shift = "(min: -20.0, max: 20.0, step: 20.0)";
    let turn = "(min: -30.0, max: 30.0, step: 30.0)";
    let text = format!(
        "(version: 1, name: \"{name}\", environment: \"room.env.ron\",
          tool: (body: {body:?}, pose: (position: ({:?}, {:?}, {:?}), rotation: (1.0, 0.0, 0.0, 0.0))),
          motion: (x: {shift}, y: {shift}, z: {shift}, rx: {turn}, ry: {turn}),
          requirement: (position_rms: {limit_mm:?}))",
        at.x, at.y, at.z
    );
    let file = format!("{name}.design.ron");
    scratch.write(&file, text);
    file
}

/// Runs every command on a design whose bound lies in its interval.
fn assert_every_verdict_is_open(scratch: &Scratch, at: &Vector3<f64>, limit_mm: f64) {
    let design = write_design(scratch, "pointer", at, limit_mm);
    let other = write_design(scratch, "other", &(at + Vector3::x()), limit_mm);
    let cannot_tell = Value::from("cannot_tell");

    let simulated = scratch.json(format!("simulate {design} --mode motion"));
    assert_eq!(simulated["verdict"], cannot_tell, "{simulated}");
    let ends = &simulated["intervals"]["position_mm"]["rms"];
    let [low, high] = [0, 1].map(|k| number(&ends[k]));
    assert!(low < limit_mm && limit_mm < high, "{low} to {high}");
    let text = scratch.succeed(format!("simulate {design} --mode motion"));
    assert!(text.contains("requirement position_rms: cannot tell in this room"));
    let needed =
        text.lines().find(|l| l.starts_with("requirement position_rms: ") && l.contains("decided"));
    assert!(needed.is_some(), "{text}");
    assert!(simulated["measurements_needed"].get("position_rms").is_some());
    for figure in ["tip error RMS", "tip error max", "angle error RMS"] {
        assert!(text.contains(&format!("expected {figure}")), "{text}");
    }

    let compared = scratch.json(format!("compare {design} {other}"));
    for row in compared["rows"].as_array().unwrap() {
        assert_eq!(row["verdict"], cannot_tell, "{row}");
        assert_eq!(row["intervals"]["position_mm"]["rms"].as_array().unwrap().len(), 2);
    }

    let procedure = scratch.json(format!("procedure {design}"));
    let steps = procedure["steps"].as_array().unwrap();
    let tool = steps.iter().find(|step| step["step"] == "tool").unwrap();
    assert_eq!(tool["state"], cannot_tell);
    assert_eq!(tool["rows"][0]["verdict"], cannot_tell);
    let text = scratch.succeed(format!("procedure {design}"));
    assert!(text.contains("cannot tell in 1 of 1 room"), "{text}");
    assert!(text.contains("expected tip error RMS"), "{text}");

    let sheet = scratch.json(format!("tolerances {design}"));
    assert_eq!(sheet["expected_as_drawn"][0]["verdict"], cannot_tell);
    let text = scratch.succeed(format!("tolerances {design}"));
    assert!(text.contains("the measurements of this room cannot decide"), "{text}");

    let page = scratch.arg("pointer.html");
    scratch.succeed(format!("report {design} -o {page}"));
    let page = fs::read_to_string(page).unwrap();
    assert!(
        page.contains("The measurements of this room cannot decide whether the requirement is met")
    );
}

/// The room's middle, where a pointer of 150 mm has room on all sides.
fn middle(room: &Room) -> Vector3<f64> {
    let middle = (room.min_mm + room.max_mm) / 2.0;
    middle - Vector3::z() * 60.0
}

#[test]
fn twenty_rows_of_a_room_do_not_make_it_perfect() {
    let scratch = Scratch::new();
    let room = Room::new(1, false);
    let table = write_table(&scratch, &room, 20, |_| true);
    scratch.succeed(format!("fit {table} -o room.env.ron --order 0"));
    let at = middle(&room);
    assert_every_verdict_is_open(&scratch, &at, 1.0);
    let simulated = scratch.json("simulate pointer.design.ron --mode motion");
    // The room's own field has no errors but round-off, and its requirement is met.
    assert!(number(&simulated["position_mm"]["rms"]) < 1e-9);
    assert_eq!(simulated["requirement"]["met"], true);
}

#[test]
fn six_rows_do_not_determine_a_field_of_order_four() {
    let scratch = Scratch::new();
    let room = Room::new(1, false);
    let table = write_table(&scratch, &room, 6, |_| true);
    let order = "--order 4 --directions 1";
    scratch.succeed(format!("fit {table} -o room.env.ron {order}"));
    assert_every_verdict_is_open(&scratch, &middle(&room), 1.0);
}

#[test]
fn a_hole_in_the_measurements_is_reported() {
    const HOLE_MM: f64 = 160.0;
    let scratch = Scratch::new();
    let room = Room::new(3, false);
    let at = middle(&room);
    let table = write_table(&scratch, &room, 700, |p| (p - at).norm() > HOLE_MM);
    let order = "--order 2 --directions 6";
    scratch.succeed(format!("fit {table} -o room.env.ron {order}"));
    let unbounded = write_design(&scratch, "unbounded", &at, 1e3);
    let simulated = scratch.json(format!("simulate {unbounded} --mode motion"));
    let expected = number(&simulated["expected"]["position_mm"]["rms"]);
    assert_every_verdict_is_open(&scratch, &at, expected);
    // The same room with the hole measured decides more.
    let table = write_table(&scratch, &room, 700, |_| true);
    scratch.succeed(format!("fit {table} -o room.env.ron {order}"));
    let whole = scratch.json(format!("simulate {unbounded} --mode motion"));
    let ratio = |value: &Value| {
        let ends = &value["intervals"]["position_mm"]["rms"];
        number(&ends[1]) / number(&ends[0])
    };
    let (with_hole, without) = (ratio(&simulated), ratio(&whole));
    assert!(without < with_hole, "{without} and {with_hole}");
}
