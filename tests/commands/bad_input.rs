//! Files that are wrong, each in its own way: one error that names file, place, what was found and
//! what was expected; exit status 2; nothing written.

use crate::support::data::own;
use crate::support::program::{Scratch, assert_one_line};
use crate::support::table::POSITIONS;
use std::fs;

const DESIGN: &str = "pointer-on-head.design.ron";
const SIMULATE: &str = "simulate d/pointer-on-head.design.ron --mode";

/// A working design with its environment, for one file to be spoilt.
fn working() -> Scratch {
    let scratch = Scratch::new();
    scratch.copy_design_with_room("golden/pointer-on-head", "--order 1 --directions 6");
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
    let mode = if file == "input.csv" { "input --input d/input.csv" } else { "motion" };
    let message = scratch.fail(format!("{SIMULATE} {mode} --log log.csv"));
    assert!(!scratch.has("log.csv"), "{file}: a log was written");
    assert_one_line(&message, &[&[file], words].concat());
}

fn replace(from: &str, to: &str) -> impl FnOnce(Vec<u8>) -> Vec<u8> {
    move |bytes| String::from_utf8(bytes).unwrap().replacen(from, to, 1).into_bytes()
}

fn header(bytes: Vec<u8>) -> Vec<u8> {
    bytes[..=bytes.iter().position(|&c| c == b'\n').unwrap()].to_vec()
}

fn without_motion(scratch: &Scratch) {
    let name = format!("d/{DESIGN}");
    let text = scratch.read(&name);
    let (start, end) = (text.find("motion: (").unwrap(), text.find("orientation_w").unwrap());
    scratch.write(&name, [&text[..start], &text[end..]].concat());
}

#[test]
fn a_missing_file_is_named() {
    let scratch = working();
    for (file, expected) in [
        ("tool.body.ron", "expected"),
        ("crf.body.ron", "expected"),
        ("room.env.ron", "expected an environment"),
        (DESIGN, "expected"),
    ] {
        let (path, away) = (scratch.path(&format!("d/{file}")), scratch.path("away"));
        fs::rename(&path, &away).unwrap();
        for mode in ["single", "motion"] {
            let line = format!("{SIMULATE} {mode}");
            scratch.fail_with(line, &[file, "File not found", expected]);
        }
        fs::rename(&away, &path).unwrap();
    }
}

#[test]
fn truncated_files_name_the_line() {
    for file in ["tool.body.ron", DESIGN, "room.env.ron"] {
        spoil(file, |b| b[..b.len() * 2 / 3].to_vec(), &["line", "column", "expected"]);
    }
}

#[test]
fn bytes_that_are_not_utf8_are_located() {
    for file in ["tool.body.ron", DESIGN, "room.env.ron", "input.csv"] {
        let change = |b: Vec<u8>| [b"(\n  \xff\xfe\x00\x01".as_slice(), &b].concat();
        spoil(file, change, &["line 2, column 3", "UTF-8"]);
    }
}

/// One of each kind of file and of each kind of mistake; the readers' own tests have the others.
#[test]
fn wrong_values_are_named_with_their_place() {
    for (file, from, to, words) in [
        ("tool.body.ron", "(0.0, 0.0, 60.0)", "(0.0, NaN, 60.0)", &["position", "NaN"][..]),
        ("tool.body.ron", "\"s1\"", "\"s0\"", &["s0", "expected"]),
        (DESIGN, "version: 1", "version: 7", &["version", "7", "expected"]),
        (DESIGN, "min: -40.0", "min: NaN", &["motion.x", "NaN", "expected"]),
        (DESIGN, "    crf: ", "    cfr: ", &["line 5, column 5: ", "`cfr`, expected `crf`"]),
        ("input.csv", "tool_qz", "tool_q", &["tool_qz", "column"]),
        ("input.csv", "\n2", "\nx2", &["line 10", "crf_x", "x2.97", "expected"]),
    ] {
        spoil(file, replace(from, to), words);
    }
    spoil("input.csv", header, &["no rows"]);
}

/// What a file calls things goes to the terminal as it can be read there, and to programs as it is.
#[test]
fn names_that_a_terminal_would_obey_are_escaped() {
    let scratch = working();
    let name = "a\\u{1b}[31m\\u{202e}b";
    let named = |name: &str| format!("name: \"{name}\"");
    scratch.replace("d/pointer-on-head.design.ron", &named("pointer-on-head"), &named(name));
    let shown = scratch.succeed_with(format!("{SIMULATE} single"), &[name]);
    let is_hidden = |c: char| c == '\u{1b}' || c == '\u{202e}';
    assert!(!shown.contains(is_hidden), "{shown}");
    let error = scratch.fail("simulate no\u{202e}such.ron --mode single");
    assert!(!error.contains(is_hidden), "{error}");
    assert!(error.contains("no\\u{202e}such.ron"), "{error}");
}

#[test]
fn a_table_of_two_gigabytes_is_refused_by_length() {
    let scratch = Scratch::new();
    fs::File::create(scratch.path("long.csv")).unwrap().set_len(2 << 30).unwrap();
    let words = ["long.csv", "found more than 1073741824 bytes", "a measurement"];
    scratch.fail_with("fit long.csv -o out.env.ron --order 1", &words);
}

/// Of 1,025 rows none is left out without a word.
#[test]
fn a_stray_quote_is_refused_with_its_line() {
    let scratch = Scratch::new();
    let table = fs::read_to_string(own("room-a/room-a-fit.csv")).unwrap();
    let lines: Vec<&str> = table.lines().collect();
    for (line, cell) in [(1, 0), (2, 0), (12, 3), (513, 13), (lines.len(), 13)] {
        let mut cells: Vec<String> = lines[line - 1].split(',').map(str::to_owned).collect();
        cells[cell].insert(0, '"');
        let mut spoilt = lines.clone();
        let row = cells.join(",");
        spoilt[line - 1] = &row;
        scratch.write("a.csv", spoilt.join("\n"));
        let place = format!("a.csv: line {line}: found a quote at byte ");
        for command in ["fit a.csv -o out.env.ron --order 1", "select a.csv"] {
            scratch.fail_with(command, &[&place, "that does not close on this line"]);
        }
    }
}

#[test]
fn a_design_without_motion_has_no_motion_mode() {
    let scratch = working();
    without_motion(&scratch);
    scratch.fail_with(format!("{SIMULATE} motion"), &[DESIGN, "no range of motion"]);
    scratch.succeed(format!("{SIMULATE} single"));
}

/// Fits a spoilt measurement table; no environment must appear.
#[track_caller]
fn spoil_table(change: impl FnOnce(Vec<u8>) -> Vec<u8>, words: &[&str]) {
    let scratch = Scratch::new();
    let before = fs::read(own("room-a/room-a-fit.csv")).unwrap();
    let after = change(before.clone());
    assert_ne!(before, after);
    scratch.write("data.csv", after);
    let message = scratch.fail("fit data.csv -o e.env.ron --order 1 --directions 14");
    assert!(!scratch.has("e.env.ron"));
    assert_one_line(&message, &[&["data.csv"], words].concat());
}

#[test]
fn unusable_measurement_tables_are_located() {
    for (from, to, words) in [
        ("measured_z", "measured", &["measured_z", "column"][..]),
        ("ideal_qw", "ideal_q", &["ideal_qw", "or none of them"]),
        ("-111.428939", "NaN", &["line 2", "ideal_x", "NaN"]),
        ("0.403448096", "0.503448096", &["line 2", "expected"]),
        ("-111.428939,", "", &["line 2", "expected"]),
    ] {
        spoil_table(replace(from, to), words);
    }
    spoil_table(header, &["no rows"]);
    spoil_table(|_| Vec::new(), &["expected"]);
    spoil_table(|b| [b"\x00\x01\x02\xff".as_slice(), &b].concat(), &["line 1", "UTF-8"]);
}

#[test]
fn an_underdetermined_fit_warns() {
    let scratch = Scratch::new();
    let table = fs::read_to_string(own("room-a/room-a-fit.csv")).unwrap();
    let few: String = table.lines().take(31).map(|l| format!("{l}\n")).collect();
    scratch.write("few.csv", few);
    let notes = scratch.notes("fit few.csv -o few.env.ron --order 4 --directions 1");
    assert_one_line(&notes, &["warning", "fewer samples than the 125 coefficients"]);
    assert!(scratch.has("few.env.ron"));
}

#[test]
fn settings_that_make_no_fit_are_refused() {
    let scratch = Scratch::new();
    scratch.copy_own("room-a/room-a-fit.csv", "room.csv");
    scratch.write("p.csv", format!("{POSITIONS}\n0,0,0,1,0,0\n1,1,1,1,1,2\n"));
    for (arguments, words) in [
        ("room.csv --order 2 --directions 13", &["expected 1, 6, 12, 14, 26 or 42"][..]),
        ("room.csv --order 13 --directions 1", &["expected 0 to 12"]),
        ("room.csv --order -1 --directions 1", &["--order"]),
        ("room.csv --order 2 --directions 6 --ridge NaN", &["ridge", "NaN"]),
        ("p.csv --order 1 --directions 14", &["p.csv", "no orientations", "expected 1"]),
    ] {
        scratch.refused(format!("fit -o e.env.ron {arguments}"), words);
    }
    assert!(!scratch.has("e.env.ron"));
}

#[test]
fn a_broken_mesh_changes_no_number() {
    let scratch = working();
    let text = scratch.read("d/tool.body.ron");
    scratch.replace("d/tool.body.ron", "version: 1,", "version: 1,\n    mesh: \"tool.glb\",");
    let simulate = || scratch.succeed(format!("{SIMULATE} single"));
    let without = simulate();
    scratch.write("d/tool.glb", b"glTF but no more");
    assert_eq!(simulate(), without);
    scratch.write("d/tool.body.ron", text);
    assert_eq!(simulate(), without);
}

#[test]
fn poses_that_cannot_be_used_leave_no_table() {
    let scratch = working();
    for command in ["distort", "compensate"] {
        for (content, words) in [
            ("x,y,z,qw,qx,qy\n0,0,0,1,0,0\n", ["p.csv", "qz", "column"]),
            ("x,y,z,qw,qx,qy,qz\n0,0,0,0,0,0,0\n", ["p.csv", "line 2", "expected"]),
            ("x,y,z,qw,qx,qy,qz\n0,NaN,0,1,0,0,0\n", ["p.csv", "line 2", "NaN"]),
            ("x,y,z,qw,qx,qy,qz\n", ["p.csv", "no rows", "expected"]),
        ] {
            scratch.write("p.csv", content);
            scratch.fail_with(format!("{command} d/room.env.ron p.csv -o out.csv"), &words);
        }
    }
    assert!(!scratch.has("out.csv"));
}

#[test]
fn calibration_files_that_cannot_be_used_are_named() {
    let scratch = Scratch::new();
    let points: String = (0..12).map(|i| format!("{i}, {}, {}\n", i * i, i % 2)).collect();
    let body = format!("4, 4, 4, b.txt\n{points}");
    let on_a_line = format!("4, 4, 4, 1, r.txt\n{}", "1, 1, 1\n".repeat(12));
    for (body, readings, words) in [
        ("nonsense\n", on_a_line.as_str(), ["b.txt", "line 1"]),
        (&body, "4, 4, 4, 1, r.txt\n1, x, 3\n", ["r.txt", "line 2"]),
        (&body, &on_a_line, ["r.txt", "one line"]),
    ] {
        scratch.write("b.txt", body);
        scratch.write("r.txt", readings);
        scratch.fail_with("import jhu-cis b.txt r.txt -o o.csv", &words);
        assert!(!scratch.has("o.csv"));
    }
}

#[test]
fn a_failed_write_leaves_the_file_that_was_there() {
    let scratch = working();
    scratch.write("log.csv", "mine");
    without_motion(&scratch);
    scratch.fail(format!("{SIMULATE} motion --log log.csv"));
    assert_eq!(scratch.read("log.csv"), "mine");
    let nowhere = format!("{SIMULATE} single --log no-such-folder/log.csv");
    scratch.fail_with(nowhere, &["no-such-folder", "log.csv"]);
}
