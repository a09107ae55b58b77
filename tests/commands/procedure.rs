//! Where a design stands, and what is decided: equal to the single commands, kept in the design, and
//! reported when it no longer holds.

use crate::support::data::{aurora_pairs, own, third_party};
use crate::support::golden::{list, number};
use crate::support::program::Scratch;
use serde_json::Value;
use std::fs;

fn fit(scratch: &Scratch, to: &str, order: &str) {
    let room = "own:room-a/room-a-fit.csv";
    scratch.succeed(format!("fit {room} -o {to} --order {order} --directions 14"));
}

/// The worked design with a CRF that is judged at two targets, in a room, and another room beside it.
fn world() -> (Scratch, String) {
    let scratch = Scratch::new();
    scratch.copy_own("golden/pointer-on-head", "d");
    fit(&scratch, "d/room.env.ron", "2");
    fs::create_dir(scratch.path("ward")).unwrap();
    fit(&scratch, "ward/ward.env.ron", "1");
    let design = scratch.read("d/pointer-on-head.design.ron");
    let targets = "targets: [(name: \"left\", position: (20, -40, -60)), (name: \"right\", position: (-20, -40, -60))], \
        requirement: (position_rms: 5.0)))";
    let design = design.replacen("))),\n    tool", &format!("), {targets},\n    tool"), 1);
    assert!(design.contains("left"), "{design}");
    let required = "requirement: (position_rms: 0.01), orientation_weight";
    let design = design.replacen("orientation_weight", required, 1);
    scratch.write("d/pointer-on-head.design.ron", design);
    let design = scratch.arg("d/pointer-on-head.design.ron");
    (scratch, design)
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
    let output = command.env("SOURCE_DATE_EPOCH", "951782400").output().unwrap();
    assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// What the study predicts for the worked input, as a recording of the built tool would state it, in the
/// CRF's frame.
fn recording(scratch: &Scratch, design: &str, to: &str) -> String {
    let input = scratch.read("d/input.csv");
    let tool_only = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        cells[cells.len() - 7..].join(",")
    };
    let lines: Vec<String> = input.lines().map(tool_only).collect();
    scratch.write("tool.csv", lines.join("\n"));
    scratch.succeed(format!("simulate {design} --mode input --input tool.csv --log log.csv"));
    let table = scratch.read("log.csv");
    let (head, rows) = table.split_once('\n').unwrap();
    let head = head.replace("true_", "ideal_").replace("sim_", "measured_");
    // Only inside the room's box: `outside` is its own column.
    let column = head.split(',').position(|name| name == "outside").unwrap();
    let inside = rows.lines().filter(|row| row.split(',').nth(column) == Some("0"));
    let table: Vec<&str> = std::iter::once(head.as_str()).chain(inside).collect();
    assert!(table.len() > 12, "{}", table.len());
    scratch.write(to, table.join("\n"));
    scratch.arg(to)
}

#[test]
fn step_figures_are_those_of_the_commands() {
    let (scratch, design) = world();
    let recorded = recording(&scratch, &design, "built.csv");
    let ward = scratch.arg("ward/ward.env.ron");
    let base = format!("procedure {design} --environment {ward}");
    let found = scratch.json(format!("{base} --built {recorded} --frame crf"));
    assert_eq!(states(&found), ["met", "missed", "compared"]);
    let same = |row: &Value, single: &Value| {
        for key in "trials outside out_of_volume position_mm angle_deg worst requirement".split(' ')
        {
            assert_eq!(row[key], single[key], "{key}");
        }
    };
    let crf = scratch.json(format!("simulate {design} --mode single --body crf"));
    let rows = list(step(&found, "crf"), "rows");
    assert_eq!(rows.len(), 4);
    for (row, single) in rows.iter().zip(list(&crf, "targets")) {
        assert_eq!(row["target"], single["target"]);
        same(row, single);
    }
    let tool = scratch.json(format!("simulate {design} --mode motion"));
    let rows = list(step(&found, "tool"), "rows");
    same(&rows[0], &tool);
    assert_eq!((&rows[0]["for_now"], &rows[1]["for_now"]), (&false.into(), &true.into()));
    let verified = scratch.json(format!("verify {design} {recorded} --frame crf"));
    let figures = &step(&found, "built")["figures"];
    for key in ["used", "position_mm", "angle_deg", "effective", "verdict", "statement"] {
        assert_eq!(figures[key], verified[key], "{key}");
    }
    // In the other room as a design of its own would have it.
    fs::copy(&ward, scratch.path("d/room.env.ron")).unwrap();
    same(&rows[1], &scratch.json(format!("simulate {design} --mode motion")));
    let words = scratch.succeed(&base);
    assert!(words.contains("2. The tool in the CRF"), "{words}");
    assert!(words.contains("missed in") && words.contains("(this once)"), "{words}");
    assert!(words.contains("3. The built tool: nothing recorded yet"), "{words}");
}

#[test]
fn decisions_stay_in_the_design() {
    let (scratch, design) = world();
    let ward = scratch.arg("ward/ward.env.ron");
    let recorded = recording(&scratch, &design, "built.csv");
    let found = scratch.json(format!("procedure {design} --add-room {ward}"));
    assert_eq!(list(step(&found, "tool"), "rows").len(), 2);
    scratch.refused(format!("procedure {design} --add-room {ward}"), &["judged in it already"]);
    let own_room = scratch.fail(format!("procedure {design} --add-room d/room.env.ron"));
    assert!(own_room.contains("judged in it already"), "{own_room}");

    let found = decide(&scratch, &format!("procedure {design} --decide crf"));
    assert_eq!(states(&found), ["decided", "missed", "not_recorded"]);
    let missed = scratch.fail(format!("procedure {design} --decide tool"));
    assert!(missed.contains("the requirement is missed, expected --note"), "{missed}");
    let early = scratch.fail(format!("procedure {design} --decide built"));
    assert!(early.contains("nothing recorded of the built tool"), "{early}");
    let note = "a first try, \"as it is\"";
    decide(&scratch, &format!("procedure {design} --decide tool --note '{note}'"));
    let built = format!("--built {recorded} --frame crf");
    decide(&scratch, &format!("procedure {design} --decide built {built}"));

    // Everything is in the file: nothing is reported of it here.
    let found = scratch.json(format!("procedure {design}"));
    assert_eq!(states(&found), ["decided", "decided", "decided"]);
    assert_eq!(step(&found, "tool")["decision"]["note"], note);
    assert_eq!(step(&found, "built")["decision"]["date"], "2000-02-29");
    let saved = fs::read_to_string(&design).unwrap();
    assert!(saved.contains("rooms: [\"../ward/ward.env.ron\"]"), "{saved}");
    assert!(saved.contains("table: \"../built.csv\""), "{saved}");

    // A room that is judged this once changes nothing of it.
    let other = scratch.arg("other.env.ron");
    fs::copy(&ward, &other).unwrap();
    let found = scratch.json(format!("procedure {design} --environment {other}"));
    assert_eq!(states(&found), ["decided", "decided", "decided"]);

    // A room that is measured anew does.
    fit(&scratch, "ward/ward.env.ron", "2");
    let found = scratch.json(format!("procedure {design}"));
    let [crf, tool, built] = states(&found)[..] else {
        panic!("{found}");
    };
    let outdated = "decided_on_other_figures";
    assert_eq!([crf, tool, built], [outdated, outdated, "decided"]);
    let changes = list(step(&found, "tool"), "changes");
    let rms = changes.iter().find(|c| c["what"]["figure"] == "tip error RMS").unwrap();
    assert_eq!(rms["environment_file"], "../ward/ward.env.ron");
    let now = &list(step(&found, "tool"), "rows")[1]["position_mm"]["rms"];
    assert_eq!(&rms["what"]["now"], now);
    assert_ne!(rms["what"]["before"], *now);
    scratch.succeed_with(format!("procedure {design}"), &["since then: ", "tip error RMS was "]);

    // So does another bound, and a recording that is gone.
    fs::remove_file(&recorded).unwrap();
    let loose =
        saved.replacen("requirement: (position_rms: 0.01)", "requirement: (position_rms: 0.5)", 1);
    fs::write(&design, loose).unwrap();
    let words = scratch.succeed(format!("procedure {design}"));
    assert!(words.contains("required position_rms was 0.01, is 0.5"), "{words}");
    assert!(words.contains("built.csv: File not found"), "{words}");

    let found = scratch.json(format!("procedure {design} --withdraw tool --remove-room {ward}"));
    assert_ne!(step(&found, "tool")["state"], outdated);
    assert_eq!(list(step(&found, "tool"), "rows").len(), 1);
    let twice = scratch.fail(format!("procedure {design} --withdraw tool"));
    assert!(twice.contains("nothing is decided on the tool"), "{twice}");
    let page = scratch.arg("page.html");
    scratch.succeed(format!("report {design} -o {page}"));
    let page = fs::read_to_string(page).unwrap();
    assert!(page.contains("id=\"decisions\"") && page.contains("2000-02-29"));
}

#[test]
fn an_unusable_room_is_a_row_with_its_reason() {
    let (scratch, design) = world();
    let ward = scratch.arg("ward/ward.env.ron");
    scratch.succeed(format!("procedure {design} --add-room {ward}"));
    fs::remove_file(&ward).unwrap();
    // A room of which no trial is a part: the same field, metres away.
    let data = fs::read_to_string(own("room-a/room-a-fit.csv")).unwrap();
    let mut lines = data.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    let mut moved = vec![head.join(",")];
    for line in lines {
        let cells = line.split(',').zip(&head).map(|(cell, name)| match *name {
            "ideal_x" | "measured_x" => (cell.parse::<f64>().unwrap() + 3000.0).to_string(),
            _ => cell.to_owned(),
        });
        moved.push(cells.collect::<Vec<_>>().join(","));
    }
    scratch.write("away.csv", moved.join("\n"));
    scratch.succeed("fit away.csv -o away.env.ron --order 2 --directions 14");
    let alone = scratch.json(format!("procedure {design} --remove-room {ward}"));
    scratch.succeed(format!("procedure {design}"));
    let text = fs::read_to_string(&design).unwrap();
    let rooms = "procedure: (rooms: [\"../ward/ward.env.ron\"]),\n    orientation_weight";
    fs::write(&design, text.replacen("orientation_weight", rooms, 1)).unwrap();
    let found = scratch.json(format!("procedure {design} --environment away.env.ron"));
    // Neither is averaged in.
    assert_eq!(states(&found), states(&alone));
    let rows = list(step(&found, "tool"), "rows");
    assert_eq!(rows[0], list(step(&alone, "tool"), "rows")[0]);
    let why = |row: &Value| row["no_figures"].as_str().unwrap().to_owned();
    assert!(why(&rows[1]).contains("ward.env.ron: File not found"), "{}", rows[1]);
    assert!(why(&rows[2]).contains("the room does not reach"), "{}", rows[2]);
    let words = scratch.succeed(format!("procedure {design} --environment away.env.ron"));
    assert!(words.contains("2 have no figures"), "{words}");
    // Even what is not there can be left.
    scratch.succeed(format!("procedure {design} --remove-room {ward}"));
    let gone = scratch.fail(format!("procedure {design} --remove-room {ward}"));
    assert!(gone.contains("it has no further rooms"), "{gone}");
    scratch.refused(format!("procedure {design} --add-room {ward}"), &["File not found"]);
}

#[test]
fn impossible_decisions_write_nothing() {
    let scratch = Scratch::new();
    scratch.refused("procedure endoscope --decide tool", &["read-only"]);
    let found = scratch.json("procedure endoscope");
    assert_eq!(list(&found, "steps").len(), 3);
    scratch.copy_own("golden/pointer-no-crf", "d");
    fit(&scratch, "d/room.env.ron", "2");
    let design = "d/pointer-no-crf.design.ron";
    let before = scratch.read(design);
    let found = scratch.json(format!("procedure {design}"));
    assert_eq!(states(&found), ["does_not_apply", "no_requirement", "not_recorded"]);
    for (args, part) in [
        ("--decide crf", "the design has no CRF"),
        ("--withdraw tool", "nothing is decided on the tool"),
        ("--note x", "--decide"),
        ("--crf x.csv", "--built"),
        ("--decide built --built none.csv", "none.csv: File not found"),
        ("--decide tool --environment x", "cannot be used with"),
    ] {
        scratch.refused(format!("procedure {design} {args}"), &[part]);
    }
    assert_eq!(scratch.read(design), before);
    // Without a requirement there is nothing to miss.
    let found = decide(&scratch, &format!("procedure {design} --decide tool"));
    assert_eq!(step(&found, "tool")["state"], "decided");
}

/// A table with its true poses in a frame of their own: turned by 120° about the diagonal, and shifted.
fn in_another_frame(table: &str) -> String {
    let mut lines = table.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    let column = |name: &str| head.iter().position(|found| *found == name).unwrap();
    let at = ["ideal_x", "ideal_y", "ideal_z"].map(column);
    let turn = ["ideal_qw", "ideal_qx", "ideal_qy", "ideal_qz"].map(column);
    let mut out = vec![head.join(",")];
    for line in lines {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        let value = |cells: &[String], k: usize| cells[k].parse::<f64>().unwrap();
        let [x, y, z] = at.map(|k| value(&cells, k));
        // (x, y, z) to (z, x, y), by the quaternion (1, 1, 1, 1) / 2.
        for (k, v) in at.into_iter().zip([z + 400.0, x - 100.0, y + 50.0]) {
            cells[k] = v.to_string();
        }
        let [w, i, j, k] = turn.map(|k| value(&cells, k));
        let product = [w - i - j - k, w + i + k - j, w + j + i - k, w + k + j - i];
        for (k, v) in turn.into_iter().zip(product) {
            cells[k] = (0.5 * v).to_string();
        }
        out.push(cells.join(","));
    }
    out.join("\n")
}

#[test]
fn another_frame_is_recognised_as_such() {
    let scratch = Scratch::new();
    scratch.copy_own("golden/pointer-no-crf", "d");
    fit(&scratch, "d/room.env.ron", "2");
    let design = "d/pointer-no-crf.design.ron";
    let recorded = recording(&scratch, design, "built.csv");
    let table = scratch.read("built.csv");
    let verified = scratch.json(format!("verify {design} {recorded}"));
    scratch.write("turned.csv", in_another_frame(&table));
    let error = scratch.fail(format!("verify {design} turned.csv"));
    for part in [
        "turned.csv: the measured tip is",
        "after turning by 120.0°",
        "different frames",
        "--same-frame",
    ] {
        assert!(error.contains(part), "{part}: {error}");
    }
    // What a common frame leaves is what was measured, less what a registration takes up.
    let (_, left) = error.split_once("they agree to ").unwrap();
    let left: f64 = left.split(' ').next().unwrap().parse().unwrap();
    assert!(left <= number(&verified["position_mm"]["measured"]["rms"]) + 0.05, "{left}");
    let found = scratch.json(format!("verify {design} turned.csv --same-frame --outside clamp"));
    assert!(number(&found["position_mm"]["measured"]["rms"]) > 100.0);
    let found = scratch.json(format!("procedure {design} --built turned.csv"));
    let built = step(&found, "built");
    assert_eq!(built["state"], "no_figures");
    assert!(built["no_figures"].as_str().unwrap().contains("different frames"));
}

#[test]
fn real_recordings_agree_until_turned() {
    let Some(folder) = third_party("aurora-polaris/static") else {
        return;
    };
    let scratch = Scratch::new();
    scratch.succeed(format!("characterize {} -o all.csv", aurora_pairs(&folder, 0, 1)));
    // A room in which nothing is expected, and a sensor by itself for a tool.
    scratch.succeed("fit all.csv -o room.env.ron --sensors 6dof --order 1 --directions 1");
    let body = "(version: 1, name: \"b\", tip: (0, 0, 0), sensors: [(name: \"whole\", kind: SixDof, position: (0, 0, 0), \
        rotation: (1, 0, 0, 0))])";
    scratch.write("b.body.ron", body);
    let design = "(version: 1, name: \"b\", environment: \"room.env.ron\", tool: (body: \"b.body.ron\", pose: \
        (position: (0, 0, -250), rotation: (1, 0, 0, 0))))";
    scratch.write("b.design.ron", design);
    let port = "--tool 'Port 11' --registered";
    // 18 mm at the worst, and no matter of frames.
    let found = scratch.json(format!("verify b.design.ron all.csv {port}"));
    assert!(number(&found["position_mm"]["measured"]["max"]) > 5.0);
    scratch.write("turned.csv", in_another_frame(&scratch.read("all.csv")));
    let error = scratch.fail(format!("verify b.design.ron turned.csv {port}"));
    assert!(error.contains("after turning by 1") && error.contains("different frames"), "{error}");
}
