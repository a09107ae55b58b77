//! Files that are wrong, each in its own way: one error that names file, place, what was found and
//! what was expected; exit status 2; nothing written.

use crate::support::data::own;
use crate::support::program::{Scratch, fail, succeed, text, trackwright};
use std::fs;

const BODY: &str = "golden/pointer-on-head/tool.body.ron";

/// A working design with its environment, for one file to be spoilt.
fn working() -> Scratch {
    let scratch = Scratch::new();
    scratch.copy_own("golden/pointer-on-head", "d");
    let table = text(&own("room-a/room-a-fit.csv"));
    let env = scratch.arg("d/room.env.ron");
    succeed(&["fit", &table, "-o", &env, "--order", "1", "--directions", "6"]);
    scratch
}

/// Spoils one file of the design; simulating with a log must fail with all the words, once, and
/// leave no log.
#[track_caller]
fn spoil(file: &str, change: impl FnOnce(Vec<u8>) -> Vec<u8>, words: &[&str]) {
    let scratch = working();
    let path = scratch.path(&format!("d/{file}"));
    let before = fs::read(&path).unwrap();
    let after = change(before.clone());
    assert_ne!(before, after, "{file} was not changed");
    fs::write(&path, after).unwrap();
    let design = scratch.arg("d/pointer-on-head.design.ron");
    let (log, input) = (scratch.arg("log.csv"), scratch.arg("d/input.csv"));
    let mut args = vec!["simulate", &design, "--log", &log];
    args.extend(match file {
        "input.csv" => ["--input", &input],
        _ => ["--mode", "motion"],
    });
    let message = fail(&args);
    assert!(!scratch.path("log.csv").exists(), "{file}: a log was written");
    assert_says(&message, &[&[file], words].concat());
}

#[track_caller]
fn assert_says(message: &str, words: &[&str]) {
    assert_eq!(message.lines().count(), 1, "one line: {message}");
    for word in words {
        assert!(message.contains(word), "{word:?} is not in: {message}");
    }
}

fn replace(from: &'static str, to: &'static str) -> impl FnOnce(Vec<u8>) -> Vec<u8> {
    move |bytes| String::from_utf8(bytes).unwrap().replacen(from, to, 1).into_bytes()
}

#[test]
fn a_missing_file_is_named() {
    let scratch = working();
    for (file, word) in [
        ("d/tool.body.ron", "tool.body.ron"),
        ("d/crf.body.ron", "crf.body.ron"),
        ("d/room.env.ron", "room.env.ron"),
        ("d/pointer-on-head.design.ron", "pointer-on-head.design.ron"),
    ] {
        let (path, away) = (scratch.path(file), scratch.path("away"));
        fs::rename(&path, &away).unwrap();
        let design = scratch.arg("d/pointer-on-head.design.ron");
        let message = fail(&["simulate", &design, "--mode", "single"]);
        assert_says(&message, &[word, "found no such file", "expected"]);
        fs::rename(&away, &path).unwrap();
    }
}

#[test]
fn truncated_files_name_the_line() {
    for file in ["tool.body.ron", "pointer-on-head.design.ron", "room.env.ron"] {
        spoil(file, |b| b[..b.len() * 2 / 3].to_vec(), &["line", "column", "expected"]);
    }
}

#[test]
fn bytes_that_are_not_utf8_are_located() {
    for file in ["tool.body.ron", "pointer-on-head.design.ron", "room.env.ron", "input.csv"] {
        spoil(
            file,
            |b| [b"(\n  \xff\xfe\x00\x01".as_slice(), &b].concat(),
            &["line 2, column 3", "UTF-8"],
        );
    }
}

#[test]
fn a_wrong_version_is_named() {
    for file in ["tool.body.ron", "pointer-on-head.design.ron"] {
        spoil(file, replace("version: 1", "version: 7"), &["version", "7", "expected"]);
    }
}

#[test]
fn numbers_that_are_not_finite_are_named() {
    spoil("tool.body.ron", replace("(0.0, 0.0, 60.0)", "(0.0, NaN, 60.0)"), &["position", "NaN"]);
    spoil("tool.body.ron", replace("(0.0, 0.0, 60.0)", "(0.0, inf, 60.0)"), &["position", "inf"]);
    spoil("tool.body.ron", replace("tip: (0, 0, 0)", "tip: (0, NaN, 0)"), &["tip", "NaN"]);
    spoil(
        "pointer-on-head.design.ron",
        replace("min: -40.0", "min: NaN"),
        &["motion.x", "NaN", "expected"],
    );
    spoil(
        "pointer-on-head.design.ron",
        replace("orientation_weight: 100.0", "orientation_weight: inf"),
        &["orientation_weight", "inf", "expected"],
    );
}

#[test]
fn quaternions_without_length_are_named() {
    spoil(
        "pointer-on-head.design.ron",
        replace("rotation: (1, 0, 0, 0)", "rotation: (0, 0, 0, 0)"),
        &["rotation", "expected"],
    );
    spoil("input.csv", replace(",0.9", ",2.9"), &["line", "expected"]);
}

#[test]
fn axes_without_length_are_named() {
    spoil(
        "tool.body.ron",
        replace("axis: (0, 0, 1)", "axis: (0, 0, 0)"),
        &["sensors[0] \"s0\"", "axis", "(0, 0, 0)", "expected"],
    );
}

#[test]
fn bodies_without_distinct_sensors_are_refused() {
    spoil(
        "tool.body.ron",
        |b| {
            let text = String::from_utf8(b).unwrap();
            let start = text.find("sensors: [").unwrap();
            format!("{}sensors: [],\n)", &text[..start]).into_bytes()
        },
        &["sensors", "expected at least one"],
    );
    spoil("tool.body.ron", replace("\"s1\"", "\"s0\""), &["s0", "expected"]);
}

#[test]
fn an_environment_that_does_not_exist_is_named() {
    let scratch = working();
    fs::rename(scratch.path("d/room.env.ron"), scratch.path("d/else.env.ron")).unwrap();
    let design = scratch.arg("d/pointer-on-head.design.ron");
    assert_says(
        &fail(&["simulate", &design, "--mode", "motion"]),
        &["room.env.ron", "found no such file", "expected an environment"],
    );
}

#[test]
fn unusable_input_tables_are_located() {
    spoil("input.csv", replace("tool_qz", "tool_q"), &["tool_qz", "column"]);
    spoil(
        "input.csv",
        |b| b[..=b.iter().position(|&c| c == b'\n').unwrap()].to_vec(),
        &["no rows"],
    );
    spoil("input.csv", replace("\n2", "\nx2"), &["line 10", "crf_x", "x2.97", "expected"]);
}

#[test]
fn a_huge_range_of_motion_is_refused() {
    spoil(
        "pointer-on-head.design.ron",
        |b| {
            let text = String::from_utf8(b).unwrap();
            let (start, end) =
                (text.find("motion: (").unwrap(), text.find("orientation_w").unwrap());
            let axis = |name: &str| format!("{name}: (min: 0.0, max: 99.0, step: 1.0), ");
            let axes: String = ["x", "y", "z", "rx", "ry", "rz"].map(axis).concat();
            format!("{}motion: ({axes}),\n    {}", &text[..start], &text[end..]).into_bytes()
        },
        &["motion", "1.0000e12", "expected at most"],
    );
}

#[test]
fn misspelt_fields_are_named_with_the_right_ones() {
    for (file, from, to, words) in [
        (
            "pointer-on-head.design.ron",
            "    crf: ",
            "    cfr: ",
            &["line 5, column 5: found the unknown field `cfr`, expected `crf`"][..],
        ),
        (
            "pointer-on-head.design.ron",
            "    motion: ",
            "    moiton: ",
            &["found the unknown field `moiton`, expected `motion`"],
        ),
        ("tool.body.ron", "tip: ", "tipp: ", &["found the unknown field `tipp`, expected `tip`"]),
        (
            "tool.body.ron",
            "version: 1,",
            "version: 9, color: Red,",
            &["version is 9, expected 1; a newer trackwright wrote it"],
        ),
    ] {
        spoil(file, replace(from, to), words);
    }
}

#[test]
fn reversed_ranges_and_huge_lengths_are_refused() {
    let design = "pointer-on-head.design.ron";
    let range = "x: (min: 40.0, max: -40.0, step: 40.0)";
    spoil(
        design,
        replace("x: (min: -40.0, max: 40.0, step: 40.0)", range),
        &["motion.x: min is 40, max is -40, expected min at most max"],
    );
    spoil(
        design,
        replace("orientation_weight: 100.0", "orientation_weight: 1e9"),
        &["orientation_weight is 1000000000, expected a length of at most 1e6 mm"],
    );
    spoil(
        design,
        replace("orientation_weight: 100.0", "orientation_weight: 1e308"),
        &["column ", "found `1e308`, expected a number of at most 1e30"],
    );
}

/// What a file calls things goes to the terminal as it can be read there, and to programs as it is.
#[test]
fn names_that_a_terminal_would_obey_are_escaped() {
    let scratch = working();
    let path = scratch.path("d/pointer-on-head.design.ron");
    let text = fs::read_to_string(&path).unwrap();
    let start = text.find("name: \"").unwrap() + "name: \"".len();
    let end = start + text[start..].find('"').unwrap();
    let name = "a\\u{1b}[31m\\u{202e}b";
    fs::write(&path, format!("{}{name}{}", &text[..start], &text[end..])).unwrap();
    let design = scratch.arg("d/pointer-on-head.design.ron");
    let shown = succeed(&["simulate", &design, "--mode", "single"]);
    assert!(shown.contains(name), "{shown}");
    let is_hidden = |c: char| c == '\u{1b}' || c == '\u{202e}';
    assert!(!shown.contains(is_hidden), "{shown}");
    let error = fail(&["simulate", "no\u{202e}such.ron", "--mode", "single"]);
    assert!(!error.contains(is_hidden), "{error}");
    assert!(error.contains("no\\u{202e}such.ron"), "{error}");
}

#[test]
fn a_two_gigabyte_file_is_refused_by_length() {
    let scratch = working();
    let design = scratch.arg("d/pointer-on-head.design.ron");
    fs::File::create(scratch.path("d/pointer-on-head.design.ron"))
        .and_then(|file| file.set_len(2 << 30))
        .unwrap();
    let message = fail(&["simulate", &design, "--mode", "single"]);
    assert_says(&message, &["found more than 16777216 bytes", "a design"]);
    fs::File::create(scratch.path("d/input.csv")).and_then(|file| file.set_len(2 << 30)).unwrap();
    let table = scratch.arg("d/input.csv");
    let out = scratch.arg("out.env.ron");
    let message = fail(&["fit", &table, "-o", &out, "--order", "1"]);
    assert_says(&message, &["found more than 1073741824 bytes", "a measurement"]);
}

#[test]
fn a_design_without_motion_has_no_motion_mode() {
    let scratch = working();
    let path = scratch.path("d/pointer-on-head.design.ron");
    let text = fs::read_to_string(&path).unwrap();
    let (start, end) = (text.find("motion: (").unwrap(), text.find("orientation_w").unwrap());
    fs::write(&path, format!("{}{}", &text[..start], &text[end..])).unwrap();
    let design = scratch.arg("d/pointer-on-head.design.ron");
    assert_says(
        &fail(&["simulate", &design, "--mode", "motion"]),
        &["pointer-on-head.design.ron", "no range of motion"],
    );
    succeed(&["simulate", &design, "--mode", "single"]);
}

/// Fits a spoilt measurement table; no environment must appear.
#[track_caller]
fn spoil_table(change: impl FnOnce(Vec<u8>) -> Vec<u8>, words: &[&str]) {
    let scratch = Scratch::new();
    let before = fs::read(own("room-a/room-a-fit.csv")).unwrap();
    let after = change(before.clone());
    assert_ne!(before, after);
    fs::write(scratch.path("data.csv"), after).unwrap();
    let (data, env) = (scratch.arg("data.csv"), scratch.arg("e.env.ron"));
    let message = fail(&["fit", &data, "-o", &env, "--order", "1", "--directions", "14"]);
    assert!(!scratch.path("e.env.ron").exists());
    assert_says(&message, &[&["data.csv"], words].concat());
}

#[test]
fn unusable_measurement_tables_are_located() {
    spoil_table(replace("measured_z", "measured"), &["measured_z", "column"]);
    spoil_table(replace("ideal_qw", "ideal_q"), &["ideal_qw", "or none of them"]);
    spoil_table(|b| b[..=b.iter().position(|&c| c == b'\n').unwrap()].to_vec(), &["no rows"]);
    spoil_table(|_| Vec::new(), &["expected"]);
    spoil_table(|b| [b"\x00\x01\x02\xff".as_slice(), &b].concat(), &["line 1", "UTF-8"]);
    spoil_table(replace("-111.428939", "NaN"), &["line 2", "ideal_x", "NaN"]);
    spoil_table(replace("-111.428939", "inf"), &["line 2", "ideal_x", "inf"]);
    spoil_table(replace("0.403448096", "0.503448096"), &["line 2", "expected"]);
    spoil_table(
        replace("0.403448096,0.580714761,-0.704057214,-0.0656006052", "0,0,0,0"),
        &["line 2"],
    );
    spoil_table(replace("-111.428939,", ""), &["line 2", "expected"]);
}

#[test]
fn a_position_only_table_needs_one_direction() {
    let scratch = Scratch::new();
    fs::write(
        scratch.path("p.csv"),
        "ideal_x,ideal_y,ideal_z,measured_x,measured_y,measured_z\n0,0,0,1,0,0\n1,1,1,1,1,2\n",
    )
    .unwrap();
    let (data, env) = (scratch.arg("p.csv"), scratch.arg("p.env.ron"));
    let message = fail(&["fit", &data, "-o", &env, "--order", "1", "--directions", "14"]);
    assert_says(&message, &["p.csv", "no orientations", "expected 1"]);
    assert!(!scratch.path("p.env.ron").exists());
}

#[test]
fn an_underdetermined_fit_warns() {
    let scratch = Scratch::new();
    let table = fs::read_to_string(own("room-a/room-a-fit.csv")).unwrap();
    let few: String = table.lines().take(31).map(|l| format!("{l}\n")).collect();
    fs::write(scratch.path("few.csv"), few).unwrap();
    let (data, env) = (scratch.arg("few.csv"), scratch.arg("few.env.ron"));
    let output = trackwright(&["fit", &data, "-o", &env, "--order", "4", "--directions", "1"])
        .output()
        .unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{stderr}");
    assert_says(&stderr, &["warning", "fewer samples than the 125 coefficients"]);
    assert!(scratch.path("few.env.ron").exists());
}

#[test]
fn settings_that_make_no_fit_are_refused() {
    let scratch = Scratch::new();
    let (data, env) = (text(&own("room-a/room-a-fit.csv")), scratch.arg("e.env.ron"));
    let base = ["fit", &data, "-o", &env];
    for (arguments, word) in [
        (["--order", "2", "--directions", "13"], "expected 1, 6, 12, 14, 26 or 42"),
        (["--order", "13", "--directions", "1"], "expected 0 to 12"),
        (["--order", "-1", "--directions", "1"], "--order"),
    ] {
        let message = fail(&[base.as_slice(), &arguments].concat());
        assert!(message.contains(word), "{message}");
    }
    let message =
        fail(&[base.as_slice(), &["--order", "2", "--directions", "6", "--ridge", "NaN"]].concat());
    assert_says(&message, &["ridge", "NaN"]);
    assert!(!scratch.path("e.env.ron").exists());
}

#[test]
fn a_spoilt_mesh_is_no_matter_to_the_numbers() {
    let scratch = working();
    let body = own(BODY);
    let text = fs::read_to_string(body).unwrap();
    let with_mesh = text.replacen("version: 1,", "version: 1,\n    mesh: \"tool.glb\",", 1);
    fs::write(scratch.path("d/tool.body.ron"), with_mesh).unwrap();
    let design = scratch.arg("d/pointer-on-head.design.ron");
    let simulate = ["simulate", &design, "--mode", "single"];
    let without = succeed(&simulate);
    fs::write(scratch.path("d/tool.glb"), b"glTF but no more").unwrap();
    assert_eq!(succeed(&simulate), without);
    fs::write(scratch.path("d/tool.body.ron"), text).unwrap();
    assert_eq!(succeed(&simulate), without);
}

#[test]
fn poses_that_cannot_be_used_leave_no_table() {
    let scratch = working();
    let env = scratch.arg("d/room.env.ron");
    let (poses, out) = (scratch.arg("p.csv"), scratch.arg("out.csv"));
    for (content, words) in [
        ("x,y,z,qw,qx,qy\n0,0,0,1,0,0\n", ["qz", "column"]),
        ("x,y,z,qw,qx,qy,qz\n0,0,0,0,0,0,0\n", ["line 2", "expected"]),
        ("x,y,z,qw,qx,qy,qz\n", ["no rows", "expected"]),
    ] {
        fs::write(&poses, content).unwrap();
        let message = fail(&["distort", &env, &poses, "-o", &out]);
        assert_says(&message, &[&["p.csv"], words.as_slice()].concat());
        assert!(!scratch.path("out.csv").exists());
    }
}

#[test]
fn calibration_files_that_cannot_be_used_are_named() {
    let scratch = Scratch::new();
    let (body, readings, out) = (scratch.arg("b.txt"), scratch.arg("r.txt"), scratch.arg("o.csv"));
    let points =
        |n: usize| (0..n).map(|i| format!("{}, {}, {}\n", i, i * i, i % 2)).collect::<String>();
    let good_body = format!("4, 4, 4, b.txt\n{}", points(12));
    let good_readings = format!("4, 4, 4, 1, r.txt\n{}", points(12));
    let line = format!("4, 4, 4, 1, r.txt\n{}", "1, 1, 1\n".repeat(12));
    for (b, r, words) in [
        ("nonsense\n", good_readings.as_str(), ["b.txt", "line 1"]),
        (&good_body, "4, 4, 4, 2, r.txt\n1, 2, 3\n", ["r.txt", "expected"]),
        (&good_body, &line, ["r.txt", "one line"]),
        (&good_body, "4, 4, 4, 1, r.txt\n1, x, 3\n", ["r.txt", "line 2"]),
    ] {
        fs::write(&body, b).unwrap();
        fs::write(&readings, r).unwrap();
        let message = fail(&["import", "jhu-cis", &body, &readings, "-o", &out]);
        assert_says(&message, &words);
        assert!(!scratch.path("o.csv").exists());
    }
}

#[test]
fn a_failed_write_leaves_the_file_that_was_there() {
    let scratch = working();
    let design = scratch.arg("d/pointer-on-head.design.ron");
    let log = scratch.arg("log.csv");
    fs::write(&log, "mine").unwrap();
    spoil_design_motion(&scratch);
    fail(&["simulate", &design, "--mode", "motion", "--log", &log]);
    assert_eq!(fs::read_to_string(&log).unwrap(), "mine");
    let nowhere = scratch.arg("no-such-folder/log.csv");
    let message = fail(&["simulate", &design, "--mode", "single", "--log", &nowhere]);
    assert_says(&message, &["no-such-folder", "log.csv"]);
}

fn spoil_design_motion(scratch: &Scratch) {
    let path = scratch.path("d/pointer-on-head.design.ron");
    let text = fs::read_to_string(&path).unwrap();
    let (start, end) = (text.find("motion: (").unwrap(), text.find("orientation_w").unwrap());
    fs::write(&path, format!("{}{}", &text[..start], &text[end..])).unwrap();
}
