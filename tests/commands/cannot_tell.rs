//! Rooms with too few measurements: no figure without its interval, and the verdict *cannot
//! tell*, in every command that names one.

use crate::rooms::tracker::{Random, Room};
use crate::support::golden::{list, number};
use crate::support::program::Scratch;
use crate::support::table::measurement_columns;
use nalgebra::{UnitQuaternion, Vector3};
use serde_json::Value;

/// Rows of a room: readings of sensors at places by chance that `is_measured` names.
fn write_table(
    scratch: &Scratch,
    room: &Room,
    rows: usize,
    is_measured: impl Fn(&Vector3<f64>) -> bool,
) {
    let mut random = Random::new(17);
    let mut table = vec![measurement_columns()];
    while table.len() <= rows {
        let sensor = (room.position(&mut random), random.direction());
        let reading = room.measure(&sensor, &mut random);
        let Some(reading) = reading.filter(|_| is_measured(&sensor.0)) else { continue };
        let cells = [sensor, reading].map(|(p, n)| {
            let turn = UnitQuaternion::rotation_between(&Vector3::z(), &n)
                .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), 3.2));
            let [x, y, z, w]: [f64; 4] = turn.coords.into();
            [p.x, p.y, p.z, w, x, y, z].map(|v| v.to_string()).join(",")
        });
        table.push(cells.join(","));
    }
    scratch.write("rows.csv", table.join("\n"));
}

/// A pointer that moves about a place, with a bound on its RMS.
fn write_design(scratch: &Scratch, name: &str, at: &Vector3<f64>, limit_mm: f64) -> String {
    let body = format!("{}/assets/bodies/pointer.body.ron", env!("CARGO_MANIFEST_DIR"));
    let shift = "(min: -20.0, max: 20.0, step: 20.0)";
    let turn = "(min: -30.0, max: 30.0, step: 30.0)";
    let shifts = format!("x: {shift}, y: {shift}, z: {shift}");
    let motion = format!("motion: ({shifts}, rx: {turn}, ry: {turn})");
    let requirement = format!("requirement: (position_rms: {limit_mm:?})");
    scratch.write_design(name, &body, (*at).into(), &format!("{motion}, {requirement}"))
}

/// The interval of a study's tip error RMS.
fn ends(study: &Value) -> [f64; 2] {
    ["low", "high"].map(|end| number(&study["figures"]["position_mm"]["rms"][end]))
}

/// The figures that a requirement can be about, each with its interval.
fn assert_intervals_are_shown(text: &str) {
    for figure in ["tip error RMS", "tip error max", "angle error RMS"] {
        let is_shown = |line: &str| line.contains(figure) && line.contains(" (95 %: ");
        assert!(text.lines().any(is_shown), "{figure}: {text}");
    }
}

/// Runs every command on a design whose bound lies in its interval.
fn assert_every_verdict_is_open(scratch: &Scratch, at: &Vector3<f64>, limit_mm: f64) {
    let design = write_design(scratch, "pointer", at, limit_mm);
    let other = write_design(scratch, "other", &(at + Vector3::x()), limit_mm);
    let cannot_tell = Value::from("cannot_tell");

    let simulated = scratch.json(format!("simulate {design} --mode motion"));
    assert_eq!(simulated["requirement"]["verdict"], cannot_tell, "{simulated}");
    let [low, high] = ends(&simulated);
    assert!(low < limit_mm && limit_mm < high, "{low} to {high}");
    let words = ["requirement position_rms: cannot tell: the interval holds the limit; "];
    let text = scratch.succeed_with(format!("simulate {design} --mode motion"), &words);
    assert_intervals_are_shown(&text);
    let mut bounds = text.lines().filter(|line| line.starts_with("requirement position_rms: "));
    assert!(bounds.any(|line| line.contains("decided")), "{text}");
    assert!(simulated["measurements_needed"].get("position_rms").is_some());

    let compared = scratch.json(format!("compare {design} {other}"));
    for row in list(&compared, "rows") {
        assert_eq!(row["requirement"]["verdict"], cannot_tell, "{row}");
        let [low, high] = ends(row);
        assert!(low < high, "{row}");
    }

    let procedure = scratch.json(format!("procedure {design}"));
    let tool = list(&procedure, "steps").iter().find(|step| step["step"] == "tool").unwrap();
    assert_eq!(tool["state"], cannot_tell);
    assert_eq!(tool["rows"][0]["requirement"]["verdict"], cannot_tell);
    let words = ["cannot tell in 1 of 1 room"];
    assert_intervals_are_shown(&scratch.succeed_with(format!("procedure {design}"), &words));

    let sheet = scratch.json(format!("tolerances {design}"));
    assert_eq!(sheet["requirement"]["checks"][0]["verdict"], cannot_tell);
    let words = ["it is not decided whether the requirement is met as drawn"];
    scratch.succeed_with(format!("tolerances {design}"), &words);

    scratch.succeed(format!("report {design} -o pointer.html"));
    let verdict = "The measurements of this room cannot decide whether the requirement is met";
    assert!(scratch.read("pointer.html").contains(verdict));
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
    write_table(&scratch, &room, 20, |_| true);
    scratch.succeed("fit rows.csv -o room.env.ron --order 0");
    let at = middle(&room);
    assert_every_verdict_is_open(&scratch, &at, 1.0);
    let simulated = scratch.json("simulate pointer.design.ron --mode motion");
    // The room's model alone has no errors but round-off, which is not what is to be expected.
    assert!(number(&simulated["room_field"]["position_mm"]["rms"]) < 1e-9);
    assert!(number(&simulated["figures"]["position_mm"]["rms"]["value"]) > 0.1, "{simulated}");
}

#[test]
fn six_rows_do_not_determine_a_field_of_order_four() {
    let scratch = Scratch::new();
    let room = Room::new(1, false);
    // Near the corners, so that the design is between them.
    let size = room.max_mm - room.min_mm;
    let is_at_corner = |p: &Vector3<f64>| {
        let from_end = |k: usize| (p[k] - room.min_mm[k]).min(room.max_mm[k] - p[k]);
        (0..3).all(|k| from_end(k) < 0.1 * size[k])
    };
    write_table(&scratch, &room, 6, is_at_corner);
    scratch.succeed("fit rows.csv -o room.env.ron --order 4 --directions 1");
    assert_every_verdict_is_open(&scratch, &middle(&room), 1.0);
}

#[test]
fn a_hole_in_the_measurements_is_reported() {
    const HOLE_MM: f64 = 160.0;
    let scratch = Scratch::new();
    let room = Room::new(3, false);
    let at = middle(&room);
    write_table(&scratch, &room, 700, |p| (p - at).norm() > HOLE_MM);
    let fit = "fit rows.csv -o room.env.ron --order 2 --directions 6";
    scratch.succeed(fit);
    let unbounded = write_design(&scratch, "unbounded", &at, 1e3);
    let simulated = scratch.json(format!("simulate {unbounded} --mode motion"));
    let expected_mm = number(&simulated["figures"]["position_mm"]["rms"]["value"]);
    assert_every_verdict_is_open(&scratch, &at, expected_mm);
    // The same room with the hole measured decides more.
    write_table(&scratch, &room, 700, |_| true);
    scratch.succeed(fit);
    let whole = scratch.json(format!("simulate {unbounded} --mode motion"));
    let ratio = |value: &Value| {
        let [low, high] = ends(value);
        high / low
    };
    let (with_hole, without) = (ratio(&simulated), ratio(&whole));
    assert!(without < with_hole, "{without} and {with_hole}");
}
