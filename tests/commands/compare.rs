//! Designs beside each other through the command line: equal to `simulate`, readable, and clear about
//! what cannot be compared.

use crate::support::golden::{list, number};
use crate::support::program::Scratch;
use std::fs;

/// Rooms of two orders in `rooms`, and the worked designs beside them, each with the first as its own.
fn world() -> Scratch {
    let scratch = Scratch::new();
    fs::create_dir(scratch.path("rooms")).unwrap();
    for (name, order) in [("one", "1"), ("two", "2")] {
        let room = format!("rooms/{name}.env.ron");
        let data = "own:room-a/room-a-fit.csv";
        scratch.succeed(format!("fit {data} -o {room} --order {order} --directions 14"));
        let named = format!("name: \"{name}: ");
        scratch.write(&room, scratch.read(&room).replacen("name: \"", &named, 1));
    }
    for name in ["pointer-no-crf", "pointer-on-head"] {
        scratch.copy_own(&format!("golden/{name}"), name);
        let own = scratch.path(&format!("{name}/room.env.ron"));
        fs::copy(scratch.path("rooms/one.env.ron"), own).unwrap();
    }
    scratch
}

impl Scratch {
    fn design(&self, name: &str) -> String {
        self.arg(&format!("{name}/{name}.design.ron"))
    }

    /// A copy of a design with something else in it.
    fn changed(&self, name: &str, to: &str, from: &str, with: &str) -> String {
        let design = fs::read_to_string(self.design(name)).unwrap();
        assert!(design.contains(from), "{from}");
        let to = format!("{name}/{to}.design.ron");
        fs::write(self.path(&to), design.replacen(from, with, 1)).unwrap();
        self.arg(&to)
    }
}

#[test]
fn each_row_equals_a_simulate_run_exactly() {
    let scratch = world();
    let designs = ["pointer-on-head", "pointer-no-crf"].map(|name| scratch.design(name));
    let rooms = ["one", "two"].map(|name| scratch.arg(&format!("rooms/{name}.env.ron")));
    let (both, rooms_of) = (designs.join(" "), rooms.join(" "));
    let found = scratch.json(format!("compare {both} --environment {rooms_of}"));
    let rows = list(&found, "rows");
    assert_eq!(rows.len(), 4);
    for (k, row) in rows.iter().enumerate() {
        let (design, room) = (&designs[k / 2], &rooms[k % 2]);
        assert_eq!(row["design_file"], **design);
        assert_eq!(row["environment_file"], **room);
        let folder = std::path::Path::new(design).parent().unwrap();
        fs::copy(room, folder.join("room.env.ron")).unwrap();
        let single = scratch.json(format!("simulate {design} --mode motion --log log.csv"));
        let keys = "trials outside out_of_volume rejected position_mm angle_deg requirement";
        for key in keys.split(' ').chain(["poorly_determined"]) {
            assert_eq!(row[key], single[key], "{key}");
        }
        for key in ["trial", "position_mm", "angle_deg"] {
            assert_eq!(row["worst"][key], single["worst"][key], "{key}");
        }
        // The worst pose is the log's row of that number.
        let trial = row["worst"]["trial"].as_u64().unwrap() as usize;
        let log = scratch.read("log.csv");
        let cells = log.lines().nth(trial + 1).unwrap().split(',').take(7);
        let logged: Vec<f64> = cells.map(|cell| cell.parse().unwrap()).collect();
        let pose: Vec<f64> = list(&row["worst"], "pose").iter().map(number).collect();
        assert_eq!(pose, logged);
    }
    assert_eq!(found["baseline"], "pointer-on-head");
    assert!(rows[0]["against_baseline"].is_null());
    let against = &rows[2]["against_baseline"];
    let rms = |row: usize| number(&rows[row]["position_mm"]["rms"]);
    let difference = &against["position_mm"]["rms"];
    assert_eq!(number(&difference["difference"]), rms(2) - rms(0));
    assert_eq!(against["motion_differs"], true);
    let [low, high] = ["low", "high"].map(|end| number(&difference[end]));
    assert!(low < rms(2) - rms(0) && rms(2) - rms(0) < high);
    assert!(number(&difference["model_std"]) > 0.0);
}

#[test]
fn designs_without_rooms_use_their_own() {
    let scratch = world();
    let first = scratch.design("pointer-on-head");
    let moved = scratch.changed("pointer-on-head", "moved", "0, 20, 30", "0, 20, 60");
    let other = scratch.design("pointer-no-crf");
    fs::copy(scratch.path("rooms/two.env.ron"), scratch.path("pointer-no-crf/room.env.ron"))
        .unwrap();
    let found = scratch.json(format!("compare {first} {moved} {other}"));
    assert_eq!(list(&found, "environments").len(), 2);
    let rows = list(&found, "rows");
    let differs = |row: usize| &rows[row]["against_baseline"]["environment_differs"];
    assert_eq!((differs(1), differs(2)), (&false.into(), &true.into()));
    // Both designs are called the same: their files distinguish them.
    let names: Vec<_> = rows.iter().map(|r| r["design"].as_str().unwrap()).collect();
    assert!(names[0].starts_with("pointer-on-head (") && names[1].contains("moved.design.ron"));
    assert_eq!(names[2], "pointer-no-crf");
    // Another baseline, by its file or by its name, turns the signs.
    for baseline in [&other, "pointer-no-crf"] {
        let turned = scratch.json(format!("compare {first} {moved} {other} --baseline {baseline}"));
        assert_eq!(turned["baseline"], "pointer-no-crf");
        let of = |found: &serde_json::Value, row: usize| {
            number(
                &list(found, "rows")[row]["against_baseline"]["position_mm"]["rms"]["difference"],
            )
        };
        assert_eq!(of(&turned, 0), -of(&found, 2));
    }
}

#[test]
fn the_text_has_a_sentence_per_difference() {
    let scratch = world();
    let requirement = ", requirement: (position_rms: 0.001),\n)";
    let strict = scratch.changed("pointer-no-crf", "strict", ",\n)", requirement);
    let design = scratch.design("pointer-no-crf");
    let printed =
        scratch.succeed(format!("compare {design} {strict} --environment rooms/two.env.ron"));
    let lines: Vec<&str> = printed.lines().collect();
    assert!(lines[0].starts_with("two: "), "{printed}");
    assert!(lines[1].contains("RMS mm") && lines[1].contains("max °"), "{printed}");
    assert!(lines[2].contains("baseline") && lines[2].contains('–'), "{printed}");
    assert!(lines[3].contains("missed") && lines[3].contains("+0.0000"), "{printed}");
    // Aligned: every cell of the RMS ends where its head does.
    let end = lines[1].find("RMS mm").unwrap() + "RMS mm".len();
    for line in &lines[2..4] {
        assert!(
            line.is_char_boundary(end) && line[..end].ends_with(|c: char| c.is_ascii_digit()),
            "{printed}"
        );
    }
    for part in [
        "negligible (0.000 mm)",
        "negligible (0.000°)",
        "note: its requirement is not the baseline's",
        "(trial ",
    ] {
        assert!(printed.contains(part), "{part}: {printed}");
    }
}

/// A room without distortion about a point.
fn ideal_room(scratch: &Scratch, name: &str, at: f64) -> String {
    let (min, max) = (at - 600.0, at + 600.0);
    let model = format!(
        "(order: 0, directions: 1, weighting: Gnomonic, map: Distortion, \
         box: (({min:?}, {min:?}, {min:?}), ({max:?}, {max:?}, {max:?})), coefficients: [])"
    );
    let file = format!("{name}.env.ron");
    let room = format!("(version: 1, name: \"{name}\", model: {model})");
    scratch.write(&file, room);
    scratch.arg(&file)
}

#[test]
fn a_room_without_overlap_has_no_figures() {
    let scratch = world();
    let (near, far) = (ideal_room(&scratch, "near", 0.0), ideal_room(&scratch, "far", 5000.0));
    let designs = ["pointer-no-crf", "pointer-on-head"].map(|name| scratch.design(name));
    let [a, b] = &designs;
    let compare = format!("compare {a} {b} --environment {near} {far}");
    let found = scratch.json(&compare);
    let rows = list(&found, "rows");
    assert!(number(&rows[0]["position_mm"]["rms"]) < 1e-9);
    let why = rows[1]["no_figures"].as_str().unwrap();
    assert!(why.contains("of 45 trials, 45 have a sensor outside"), "{why}");
    assert!(rows[1]["position_mm"].is_null());
    assert!(rows[3]["against_baseline"].is_null());
    let unknown = found["environments"][0]["uncertainty_unknown"].as_str();
    assert!(unknown.unwrap().contains("no standard error"));
    let printed = scratch.succeed(&compare);
    assert!(printed.contains("no figures: the room does not reach"), "{printed}");
    assert!(printed.contains("the uncertainty of the room's field is unknown"), "{printed}");
    // Where such trials are rejected it is the same, and no error.
    let rejecting = scratch.json(format!("{compare} --outside reject"));
    assert_eq!(rejecting["rows"][1]["no_figures"], why);
}

#[test]
fn the_csv_has_the_figures_of_the_json() {
    let scratch = world();
    let name = "A \\\"tool\\\", first\\nof two; =1+1 Ω";
    let odd = scratch.changed("pointer-no-crf", "odd", "pointer-no-crf", name);
    let design = scratch.design("pointer-no-crf");
    let (room, table) = (scratch.arg("rooms/two.env.ron"), scratch.arg("out.csv"));
    let found = scratch.json(format!("compare {design} {odd} --environment {room} --csv {table}"));
    let mut reader = csv::Reader::from_path(&table).unwrap();
    let header = reader.headers().unwrap().clone();
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    let cell = |row: usize, name: &str| {
        let column = header.iter().position(|h| h == name).unwrap();
        rows[row][column].to_owned()
    };
    assert_eq!(cell(1, "design"), "A \"tool\", first\nof two; =1+1 Ω");
    for row in 0..2 {
        let of = |key: &str, figure: &str| number(&found["rows"][row][key][figure]);
        let written = |name: &str| cell(row, name).parse::<f64>().unwrap();
        assert_eq!(written("position_rms_mm"), of("position_mm", "rms"));
        assert_eq!(written("angle_max_deg"), of("angle_deg", "max"));
        assert_eq!(cell(row, "requirement_met"), "");
    }
    assert_eq!(cell(0, "position_rms_verdict"), "");
    assert_eq!(cell(1, "position_rms_verdict"), "negligible");
    assert_eq!(cell(1, "baseline"), "pointer-no-crf");
}

#[test]
fn what_cannot_be_compared_is_named() {
    let scratch = world();
    let designs = ["pointer-no-crf", "pointer-on-head"].map(|name| scratch.design(name));
    let room = scratch.arg("rooms/one.env.ron");
    let again = designs[0].replace("pointer-no-crf/", "pointer-on-head/../pointer-no-crf/");
    let [first, second] = &designs;
    for (args, expected) in [
        (format!("{first} {again}"), "found the same design named twice"),
        (format!("{first} --environment {room} {room}"), "found the same environment named twice"),
        (
            format!("{first} --environment {room} gone.env.ron"),
            "gone.env.ron: File not found, expected an environment",
        ),
        (format!("{first} --environment {second}"), "pointer-on-head.design.ron: "),
        (
            format!("{first} --baseline {second}"),
            "found a design that is not compared, expected one of ",
        ),
        (
            format!("{first} --baseline gone.design.ron"),
            "--baseline gone.design.ron: found no such file, and no design of this name, expected one of ",
        ),
        (format!("{first} gone.design.ron"), "gone.design.ron: File not found, expected a design"),
    ] {
        scratch.refused(format!("compare {args}"), &[expected]);
    }
}
