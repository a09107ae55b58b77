//! Designs beside each other through the command line: equal to `simulate`, readable, and clear about
//! what cannot be compared.

use crate::support::golden::{list, number, numbers};
use crate::support::program::Scratch;
use std::fs;

/// Rooms of two orders in `rooms`, and the worked designs beside them, each with the first as its own.
fn world() -> Scratch {
    let scratch = Scratch::new();
    fs::create_dir(scratch.path("rooms")).unwrap();
    for (name, order) in [("one", "1"), ("two", "2")] {
        let room = format!("rooms/{name}.env.ron");
        scratch.fit(&room, &format!("--order {order} --directions 14"));
        scratch.replace(&room, "name: \"", &format!("name: \"{name}: "));
    }
    for name in ["pointer-no-crf", "pointer-on-head"] {
        scratch.copy_own(&format!("golden/{name}"), name);
        scratch.copy("rooms/one.env.ron", &format!("{name}/room.env.ron"));
    }
    scratch
}

const NO_CRF: &str = "pointer-no-crf/pointer-no-crf.design.ron";
const ON_HEAD: &str = "pointer-on-head/pointer-on-head.design.ron";

impl Scratch {
    /// A copy of a design with something else in it.
    fn changed(&self, design: &str, name: &str, from: &str, with: &str) -> String {
        let (folder, _) = design.split_once('/').unwrap();
        let to = format!("{folder}/{name}.design.ron");
        self.copy(design, &to);
        self.replace(&to, from, with);
        to
    }
}

#[test]
fn each_row_equals_a_simulate_run_exactly() {
    let scratch = world();
    let (designs, rooms) = ([ON_HEAD, NO_CRF], ["rooms/one.env.ron", "rooms/two.env.ron"]);
    let (both, rooms_of) = (designs.join(" "), rooms.join(" "));
    let found = scratch.json(format!("compare {both} --environment {rooms_of}"));
    let rows = list(&found, "rows");
    assert_eq!(rows.len(), 4);
    for (k, row) in rows.iter().enumerate() {
        let (design, room) = (designs[k / 2], rooms[k % 2]);
        assert_eq!(row["design_file"], design);
        assert_eq!(row["environment_file"], room);
        let (folder, _) = design.split_once('/').unwrap();
        scratch.copy(room, &format!("{folder}/room.env.ron"));
        let single = scratch.json(format!("simulate {design} --mode motion --log log.csv"));
        let keys = "figures basis no_interval trials outside out_of_volume without_field rejected \
            room_field requirement poorly_determined";
        for key in keys.split_whitespace() {
            assert_eq!(row[key], single[key], "{key}");
        }
        for key in ["trial", "position_mm", "angle_deg"] {
            assert_eq!(row["worst"][key], single["worst"][key], "{key}");
        }
        // The worst pose is the log's row of that number.
        let trial = row["worst"]["trial"].as_u64().unwrap() as usize;
        let logged = scratch.table("log.csv").first::<7>()[trial];
        assert_eq!(numbers(&row["worst"]["pose"]), logged);
    }
    assert_eq!(found["baseline"], "pointer-on-head");
    assert!(rows[0]["against_baseline"].is_null());
    let against = &rows[2]["against_baseline"];
    let rms = |row: usize| number(&rows[row]["figures"]["position_mm"]["rms"]["value"]);
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
    let moved = scratch.changed(ON_HEAD, "moved", "0, 20, 30", "0, 20, 60");
    scratch.copy("rooms/two.env.ron", "pointer-no-crf/room.env.ron");
    let compare = format!("compare {ON_HEAD} {moved} {NO_CRF}");
    let found = scratch.json(&compare);
    assert_eq!(list(&found, "environments").len(), 2);
    let rows = list(&found, "rows");
    let differs = |row: usize| &rows[row]["against_baseline"]["environment_differs"];
    assert_eq!((differs(1), differs(2)), (&false.into(), &true.into()));
    // Both designs are called the same: their files distinguish them.
    let names: Vec<_> = rows.iter().map(|r| r["design"].as_str().unwrap()).collect();
    assert!(names[0].starts_with("pointer-on-head (") && names[1].contains("moved.design.ron"));
    assert_eq!(names[2], "pointer-no-crf");
    // Another baseline, by its file or by its name, turns the signs.
    for baseline in [NO_CRF, "pointer-no-crf"] {
        let turned = scratch.json(format!("{compare} --baseline {baseline}"));
        assert_eq!(turned["baseline"], "pointer-no-crf");
        let of = |found: &serde_json::Value, row: usize| {
            let against = &found["rows"][row]["against_baseline"];
            number(&against["position_mm"]["rms"]["difference"])
        };
        assert_eq!(of(&turned, 0), -of(&found, 2));
    }
}

#[test]
fn the_text_has_a_sentence_per_difference() {
    let scratch = world();
    let requirement = ", requirement: (position_rms: 0.001),\n)";
    let strict = scratch.changed(NO_CRF, "strict", ",\n)", requirement);
    let words = [
        "negligible (0.000 mm)",
        "negligible (0.000°)",
        "note: its requirement is not the baseline's",
        "(trial ",
    ];
    let compare = format!("compare {NO_CRF} {strict} --environment rooms/two.env.ron");
    let printed = scratch.succeed_with(compare, &words);
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
}

/// A room without distortion about a point.
fn ideal_room(scratch: &Scratch, name: &str, at: f64) -> String {
    let (min, max) = (at - 600.0, at + 600.0);
    let model = format!(
        "(order: 0, directions: 1, weighting: Gnomonic, map: Distortion, \
         box: (({min:?}, {min:?}, {min:?}), ({max:?}, {max:?}, {max:?})), coefficients: [])"
    );
    let file = format!("{name}.env.ron");
    scratch.write(&file, format!("(version: 1, name: \"{name}\", model: {model})"));
    file
}

#[test]
fn a_room_without_overlap_has_no_figures() {
    let scratch = world();
    let (near, far) = (ideal_room(&scratch, "near", 0.0), ideal_room(&scratch, "far", 5000.0));
    let compare = format!("compare {NO_CRF} {ON_HEAD} --environment {near} {far}");
    let found = scratch.json(&compare);
    let rows = list(&found, "rows");
    assert!(number(&rows[0]["figures"]["position_mm"]["rms"]["value"]) < 1e-9);
    let why = rows[1]["no_figures"].as_str().unwrap();
    assert!(why.contains("of 45 trials, 45 have a sensor outside"), "{why}");
    assert!(rows[1]["figures"].is_null());
    assert!(rows[3]["against_baseline"].is_null());
    let unknown = found["environments"][0]["uncertainty_unknown"].as_str();
    assert!(unknown.unwrap().contains("no standard error"));
    let field = "the uncertainty of the room's field is unknown";
    scratch.succeed_with(&compare, &["no figures: the room does not reach", field]);
    // Where such trials are rejected it is the same, and no error.
    let rejecting = scratch.json(format!("{compare} --outside reject"));
    assert_eq!(rejecting["rows"][1]["no_figures"], why);
}

#[test]
fn the_csv_has_the_figures_of_the_json() {
    let scratch = world();
    // Inside the room, so that there is an interval.
    let lifted = "(min: -120.0, max: 0.0, step: 60.0)";
    scratch.replace(NO_CRF, "(min: -180.0, max: 100.0, step: 70.0)", lifted);
    let name = "A \\\"tool\\\", first\\nof two; =1+1 Ω";
    let odd = scratch.changed(NO_CRF, "odd", "pointer-no-crf", name);
    let files = "--environment rooms/two.env.ron --csv out.csv";
    let found = scratch.json(format!("compare {NO_CRF} {odd} {files}"));
    let mut reader = csv::Reader::from_path(scratch.path("out.csv")).unwrap();
    let header = reader.headers().unwrap().clone();
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    let cell = |row: usize, name: &str| {
        let column = header.iter().position(|h| h == name).unwrap();
        rows[row][column].to_owned()
    };
    assert_eq!(cell(1, "design"), "A \"tool\", first\nof two; =1+1 Ω");
    for row in 0..2 {
        let own = &found["rows"][row];
        for (figure, kind, summary, unit) in
            [("position_rms", "position_mm", "rms", "mm"), ("angle_max", "angle_deg", "max", "deg")]
        {
            for (ending, end) in [("", "value"), ("_low", "low"), ("_high", "high")] {
                let written: f64 = cell(row, &format!("{figure}{ending}_{unit}")).parse().unwrap();
                assert_eq!(written, number(&own["figures"][kind][summary][end]), "{figure} {end}");
            }
        }
        assert_eq!(cell(row, "basis"), own["basis"].as_str().unwrap());
        assert_eq!(cell(row, "verdict"), "");
    }
    assert_eq!(cell(0, "position_rms_verdict"), "");
    assert_eq!(cell(1, "position_rms_verdict"), "negligible");
    assert_eq!(cell(1, "baseline"), "pointer-no-crf");
}

#[test]
fn what_cannot_be_compared_is_named() {
    let scratch = world();
    let again = "pointer-on-head/../pointer-no-crf/pointer-no-crf.design.ron";
    let (room, gone) = ("rooms/one.env.ron", "gone.design.ron");
    let no_file = "File not found, expected";
    let no_design = "found no such file, and no design of this name, expected one of ";
    for (args, expected) in [
        (again, "found the same design named twice"),
        (&format!("--environment {room} {room}"), "found the same environment named twice"),
        (
            &format!("--environment {room} gone.env.ron"),
            &format!("gone.env.ron: {no_file} an environment"),
        ),
        (&format!("--environment {ON_HEAD}"), "pointer-on-head.design.ron: "),
        (&format!("--baseline {ON_HEAD}"), "found a design that is not compared, expected one of "),
        (&format!("--baseline {gone}"), &format!("--baseline {gone}: {no_design}")),
        (gone, &format!("{gone}: {no_file} a design")),
    ] {
        scratch.refused(format!("compare {NO_CRF} {args}"), &[expected]);
    }
}
