//! Where a design stands, and what is decided: equal to the single commands, kept in the design, and
//! reported when it no longer holds.

use super::verify::{keep_inside, record_input};
use crate::support::data::{aurora_pairs, own, third_party};
use crate::support::golden::{list, number};
use crate::support::program::{Scratch, assert_has, json_of};
use crate::support::table::{POSE, Table};
use serde_json::Value;
use std::fs;
use trackwright_geometry::pose::{pose_from_array, pose_to_array};

const DESIGN: &str = "d/pointer-on-head.design.ron";
const NO_CRF: &str = "d/pointer-no-crf.design.ron";
const WARD: &str = "ward/ward.env.ron";
const ORDER_2: &str = "--order 2 --directions 14";

/// The worked design with a CRF that is judged at two targets, in a room, and another room beside it.
fn world() -> Scratch {
    let scratch = Scratch::new();
    scratch.copy_design_with_room("golden/pointer-on-head", ORDER_2);
    fs::create_dir(scratch.path("ward")).unwrap();
    scratch.fit(WARD, "--order 1 --directions 14");
    let targets = "targets: [(name: \"left\", position: (20, -40, -60)), (name: \"right\", position: (-20, -40, -60))], \
        requirement: (position_rms: 5.0)))";
    scratch.replace(DESIGN, "))),\n    tool", &format!("), {targets},\n    tool"));
    let required = "requirement: (position_rms: 0.01), orientation_weight";
    scratch.replace(DESIGN, "orientation_weight", required);
    scratch
}

fn step<'a>(found: &'a Value, key: &str) -> &'a Value {
    let steps = list(found, "steps");
    steps.iter().find(|step| step["step"] == key).unwrap()
}

fn states(found: &Value) -> Vec<&str> {
    let steps = list(found, "steps").iter();
    steps.map(|step| step["state"].as_str().unwrap()).collect()
}

/// On a given day.
fn decide(scratch: &Scratch, line: &str) -> Value {
    let mut command = scratch.command(&format!("{line} --format json"));
    json_of(command.env("SOURCE_DATE_EPOCH", "951782400"))
}

/// What the study predicts for the worked input inside the room's box, as a recording of the built tool would
/// state it, in the CRF's frame: `built.csv`.
fn record(scratch: &Scratch, design: &str) {
    let input = scratch.table("d/input.csv");
    let of_tool = input.without_first(input.columns.len() - 7);
    scratch.write("d/input.csv", of_tool.to_text());
    record_input(scratch, design, "built.csv");
    keep_inside(scratch, "built.csv");
}

#[test]
fn step_figures_are_those_of_the_commands() {
    let scratch = world();
    record(&scratch, DESIGN);
    let base = format!("procedure {DESIGN} --environment {WARD}");
    let found = scratch.json(format!("{base} --built built.csv --frame crf"));
    assert_eq!(states(&found), ["met", "missed", "compared"]);
    let same = |row: &Value, single: &Value| {
        let keys = "trials outside out_of_volume figures basis room_field worst requirement";
        for key in keys.split(' ') {
            assert_eq!(row[key], single[key], "{key}");
        }
    };
    let crf = scratch.json(format!("simulate {DESIGN} --mode single --body crf"));
    let rows = list(step(&found, "crf"), "rows");
    assert_eq!(rows.len(), 4);
    for (row, single) in rows.iter().zip(list(&crf, "targets")) {
        assert_eq!(row["target"], single["target"]);
        same(row, single);
    }
    let tool = scratch.json(format!("simulate {DESIGN} --mode motion"));
    let rows = list(step(&found, "tool"), "rows");
    same(&rows[0], &tool);
    assert_eq!((&rows[0]["for_now"], &rows[1]["for_now"]), (&false.into(), &true.into()));
    let verified = scratch.json(format!("verify {DESIGN} built.csv --frame crf"));
    let figures = &step(&found, "built")["figures"];
    for key in ["used", "position_mm", "angle_deg", "effective", "verdict", "statement"] {
        assert_eq!(figures[key], verified[key], "{key}");
    }
    // In the other room as a design of its own would have it.
    scratch.copy(WARD, "d/room.env.ron");
    same(&rows[1], &scratch.json(format!("simulate {DESIGN} --mode motion")));
    let built = "3. The built tool: nothing recorded yet";
    scratch.succeed_with(&base, &["2. The tool in the CRF", "missed in", "(this once)", built]);
}

#[test]
fn decisions_stay_in_the_design() {
    let scratch = world();
    let procedure = format!("procedure {DESIGN}");
    record(&scratch, DESIGN);
    let found = scratch.json(format!("{procedure} --add-room {WARD}"));
    assert_eq!(list(step(&found, "tool"), "rows").len(), 2);
    let found = decide(&scratch, &format!("{procedure} --decide crf"));
    assert_eq!(states(&found), ["decided", "missed", "not_recorded"]);
    for (args, words) in [
        (&*format!("--add-room {WARD}"), "judged in it already"),
        ("--add-room d/room.env.ron", "judged in it already"),
        ("--decide tool", "the requirement is missed, expected --note"),
        ("--decide built", "nothing recorded of the built tool"),
    ] {
        scratch.refused(format!("{procedure} {args}"), &[words]);
    }
    let note = "a first try, \"as it is\"";
    decide(&scratch, &format!("{procedure} --decide tool --note '{note}'"));
    decide(&scratch, &format!("{procedure} --decide built --built built.csv --frame crf"));

    // Everything is in the file: nothing is reported of it here.
    let found = scratch.json(&procedure);
    assert_eq!(states(&found), ["decided", "decided", "decided"]);
    assert_eq!(step(&found, "tool")["decision"]["note"], note);
    assert_eq!(step(&found, "built")["decision"]["date"], "2000-02-29");
    let saved = scratch.read(DESIGN);
    let references = ["rooms: [\"../ward/ward.env.ron\"]", "table: \"../built.csv\""];
    assert_has(&saved, &references, DESIGN);

    // A room that is judged this once changes nothing of it.
    scratch.copy(WARD, "other.env.ron");
    let found = scratch.json(format!("{procedure} --environment other.env.ron"));
    assert_eq!(states(&found), ["decided", "decided", "decided"]);

    // A room that is measured anew does.
    let again = "fit own:room-a/room-a-holdout.csv --order 1 --directions 14 --overwrite -o";
    scratch.succeed(format!("{again} {WARD}"));
    let found = scratch.json(&procedure);
    let outdated = "decided_on_other_figures";
    assert_eq!(states(&found), [outdated, outdated, "decided"]);
    let changes = list(step(&found, "tool"), "changes");
    let rms = changes.iter().find(|c| c["what"]["figure"] == "tip error RMS").unwrap();
    assert_eq!(rms["environment_file"], "../ward/ward.env.ron");
    let row = &list(step(&found, "tool"), "rows")[1];
    let now = &row["figures"]["position_mm"]["rms"]["value"];
    assert_eq!(&rms["what"]["now"], now);
    assert_ne!(rms["what"]["before"], *now);
    scratch.succeed_with(&procedure, &["since then: ", "tip error RMS was "]);

    // So does another bound, and a recording that is gone.
    fs::remove_file(scratch.path("built.csv")).unwrap();
    scratch.replace(
        DESIGN,
        "requirement: (position_rms: 0.01)",
        "requirement: (position_rms: 0.5)",
    );
    let words = ["required position_rms was 0.01, is 0.5", "built.csv: File not found"];
    scratch.succeed_with(&procedure, &words);

    let found = scratch.json(format!("{procedure} --withdraw tool --remove-room {WARD}"));
    assert_ne!(step(&found, "tool")["state"], outdated);
    assert_eq!(list(step(&found, "tool"), "rows").len(), 1);
    let twice = format!("{procedure} --withdraw tool");
    scratch.refused(twice, &["nothing is decided on the tool"]);
    scratch.succeed(format!("report {DESIGN} -o page.html"));
    let page = scratch.read("page.html");
    assert!(page.contains("id=\"decisions\"") && page.contains("2000-02-29"));
}

#[test]
fn an_unusable_room_is_a_row_with_its_reason() {
    let scratch = world();
    let procedure = format!("procedure {DESIGN}");
    scratch.succeed(format!("{procedure} --add-room {WARD}"));
    fs::remove_file(scratch.path(WARD)).unwrap();
    // A room of which no trial is a part: the same field, metres away.
    let mut table = Table::read(&own("room-a/room-a-fit.csv"));
    for column in ["ideal_x", "measured_x"].map(|name| table.column(name)) {
        for row in &mut table.rows {
            row[column] = (row[column].parse::<f64>().unwrap() + 3000.0).to_string();
        }
    }
    scratch.write("away.csv", table.to_text());
    scratch.succeed("fit away.csv -o away.env.ron --order 2 --directions 14");
    let alone = scratch.json(format!("{procedure} --remove-room {WARD}"));
    scratch.succeed(&procedure);
    let rooms = "procedure: (rooms: [\"../ward/ward.env.ron\"]),\n    orientation_weight";
    scratch.replace(DESIGN, "orientation_weight", rooms);
    let found = scratch.json(format!("{procedure} --environment away.env.ron"));
    // Neither is averaged in.
    assert_eq!(states(&found), states(&alone));
    let rows = list(step(&found, "tool"), "rows");
    assert_eq!(rows[0], list(step(&alone, "tool"), "rows")[0]);
    let why = |row: &Value| row["no_figures"].as_str().unwrap().to_owned();
    assert!(why(&rows[1]).contains("ward.env.ron: File not found"), "{}", rows[1]);
    assert!(why(&rows[2]).contains("the room does not reach"), "{}", rows[2]);
    let away = format!("{procedure} --environment away.env.ron");
    scratch.succeed_with(away, &["2 have no figures"]);
    // Even what is not there can be left.
    scratch.succeed(format!("{procedure} --remove-room {WARD}"));
    let gone = format!("{procedure} --remove-room {WARD}");
    scratch.refused(gone, &["it has no further rooms"]);
    scratch.refused(format!("{procedure} --add-room {WARD}"), &["File not found"]);
}

#[test]
fn impossible_decisions_write_nothing() {
    let scratch = Scratch::new();
    scratch.refused("procedure endoscope --decide tool", &["read-only"]);
    let found = scratch.json("procedure endoscope");
    assert_eq!(list(&found, "steps").len(), 3);
    scratch.copy_design_with_room("golden/pointer-no-crf", ORDER_2);
    let before = scratch.read(NO_CRF);
    let found = scratch.json(format!("procedure {NO_CRF}"));
    assert_eq!(states(&found), ["does_not_apply", "no_requirement", "not_recorded"]);
    for (args, part) in [
        ("--decide crf", "the design has no CRF"),
        ("--withdraw tool", "nothing is decided on the tool"),
        ("--note x", "--decide"),
        ("--crf x.csv", "--built"),
        ("--decide built --built none.csv", "none.csv: File not found"),
        ("--decide tool --environment x", "cannot be used with"),
    ] {
        scratch.refused(format!("procedure {NO_CRF} {args}"), &[part]);
    }
    assert_eq!(scratch.read(NO_CRF), before);
    // Without a requirement there is nothing to miss.
    let found = decide(&scratch, &format!("procedure {NO_CRF} --decide tool"));
    assert_eq!(step(&found, "tool")["state"], "decided");
}

/// A table with its true poses in a frame of their own: turned by 120° about the diagonal, and shifted.
fn in_another_frame(mut table: Table) -> String {
    let other_from_tracker = pose_from_array([400.0, -100.0, 50.0, 0.5, 0.5, 0.5, 0.5]).unwrap();
    let columns = POSE.split(',').map(|name| table.column(&format!("ideal_{name}")));
    let columns: [usize; 7] = columns.collect::<Vec<_>>().try_into().unwrap();
    for row in &mut table.rows {
        let pose = pose_from_array(columns.map(|column| row[column].parse().unwrap())).unwrap();
        for (column, value) in columns.into_iter().zip(pose_to_array(&(other_from_tracker * pose)))
        {
            row[column] = value.to_string();
        }
    }
    table.to_text()
}

#[test]
fn another_frame_is_recognised_as_such() {
    let scratch = Scratch::new();
    scratch.copy_design_with_room("golden/pointer-no-crf", ORDER_2);
    record(&scratch, NO_CRF);
    let verified = scratch.json(format!("verify {NO_CRF} built.csv"));
    scratch.write("turned.csv", in_another_frame(scratch.table("built.csv")));
    let verify = format!("verify {NO_CRF} turned.csv");
    let error = scratch.fail(&verify);
    let tip = "turned.csv: the measured tip is";
    let words = [tip, "after turning by 120.0°", "different frames", "--same-frame"];
    assert_has(&error, &words, &verify);
    // What a common frame leaves is what was measured, less what a registration takes up.
    let (_, left) = error.split_once("they agree to ").unwrap();
    let left: f64 = left.split(' ').next().unwrap().parse().unwrap();
    assert!(left <= number(&verified["position_mm"]["measured"]["rms"]) + 0.05, "{left}");
    let found = scratch.json(format!("{verify} --same-frame --outside clamp"));
    assert!(number(&found["position_mm"]["measured"]["rms"]) > 100.0);
    let found = scratch.json(format!("procedure {NO_CRF} --built turned.csv"));
    let built = step(&found, "built");
    assert_eq!(built["state"], "no_figures");
    assert!(built["no_figures"].as_str().unwrap().contains("different frames"));
}

#[test]
fn real_recordings_agree_until_turned() {
    let Some(folder) = third_party("aurora-polaris/static") else { return };
    let scratch = Scratch::new();
    scratch.succeed(format!("characterize {} -o all.csv", aurora_pairs(&folder, 0, 1)));
    // A room in which nothing is expected, and a sensor by itself for a tool.
    scratch.succeed("fit all.csv -o room.env.ron --sensors 6dof --order 1 --directions 1");
    let body = "(version: 1, name: \"b\", tip: (0, 0, 0), sensors: [(name: \"whole\", kind: SixDof, position: (0, 0, 0), \
        rotation: (1, 0, 0, 0))])";
    scratch.write("b.body.ron", body);
    scratch.write_design("b", "b.body.ron", [0.0, 0.0, -250.0], "");
    let port = "--tool 'Port 11' --registered";
    // 18 mm at the worst, and no matter of frames.
    let found = scratch.json(format!("verify b.design.ron all.csv {port}"));
    assert!(number(&found["position_mm"]["measured"]["max"]) > 5.0);
    scratch.write("turned.csv", in_another_frame(scratch.table("all.csv")));
    let turned = format!("verify b.design.ron turned.csv {port}");
    scratch.refused(turned, &["after turning by 1", "different frames"]);
}
