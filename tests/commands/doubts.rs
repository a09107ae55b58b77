//! Tables that are not what they are read as: refused or warned of, and taken where that is meant.

use crate::support::data::own;
use crate::support::golden::{number, numbers};
use crate::support::program::Scratch;
use crate::support::table::{POSE, Table, points_table};
use nalgebra::{UnitQuaternion, Vector3};
use std::fs;
use trackwright_geometry::pose::{Pose, pose_from_parts, pose_to_array};

const ROOM: &str = "room-a/room-a-fit.csv";
const GOOD: &str = "own:room-a/room-a-fit.csv";

/// A table with every number of some columns changed.
fn changed(scratch: &Scratch, name: &str, change: impl Fn(usize, f64) -> f64) -> String {
    let mut table = Table::read(&own(ROOM));
    for (k, cell) in table.rows.iter_mut().flat_map(|row| row.iter_mut().enumerate()) {
        *cell = change(k, cell.parse().unwrap()).to_string();
    }
    scratch.write(name, table.to_text());
    name.to_owned()
}

/// Positions are columns 0 to 2 and 7 to 9.
fn is_position(column: usize) -> bool {
    column % 7 < 3
}

fn in_metres(scratch: &Scratch) -> String {
    changed(scratch, "metres.csv", |k, v| if is_position(k) { v * 1e-3 } else { v })
}

fn fit(table: &str) -> String {
    format!("fit {table} -o room.env.ron --order 1 --directions 6")
}

#[test]
fn metres_are_refused_unless_they_are_meant() {
    let scratch = Scratch::new();
    let table = in_metres(&scratch);
    scratch.refused(fit(&table), &["metres.csv: positions span 0.", "are they metres?", "--as-is"]);
    assert!(!scratch.has("room.env.ron"));
    let meant = scratch.notes_with(format!("{} --as-is", fit(&table)), &["are they metres?"]);
    assert!(meant.starts_with("warning: "), "{meant}");
    assert!(scratch.has("room.env.ron"));
    for command in ["select", "generator learn -o g.generator.ron"] {
        scratch.refused(format!("{command} {table}"), &["are they metres?"]);
    }
}

#[test]
fn inches_are_a_warning_and_good_tables_are_none() {
    let scratch = Scratch::new();
    let inches = changed(&scratch, "inches.csv", |k, v| if is_position(k) { v / 25.4 } else { v });
    scratch.notes_with(fit(&inches), &["are they inches or centimetres?"]);
    let notes = scratch.notes(fit(GOOD));
    assert!(!notes.contains("warning: ") || !notes.contains(".csv"), "{notes}");
}

#[test]
fn mirrored_and_reordered_sides_are_refused() {
    let scratch = Scratch::new();
    let mirrored = changed(&scratch, "z.csv", |k, v| if k == 9 { -v } else { v });
    scratch.refused(fit(&mirrored), &["measured z is ideal −z"]);
    let table = fs::read_to_string(own(ROOM)).unwrap();
    // The names of the measured quaternion's columns go one on.
    let last = table.replacen(
        "measured_qw,measured_qx,measured_qy,measured_qz",
        "measured_qz,measured_qw,measured_qx,measured_qy",
        1,
    );
    scratch.write("order.csv", last);
    scratch.refused(fit("order.csv"), &["the measured quaternions"]);
}

#[test]
fn poses_in_metres_are_refused_as_measurements_are() {
    let scratch = Scratch::new();
    scratch.succeed(fit(GOOD));
    let rows: String = (0..20).map(|k| format!("0.0{k:02},0.1,-0.3,1,0,0,0\n")).collect();
    scratch.write("p.csv", format!("{POSE}\n{rows}"));
    for command in ["distort", "compensate"] {
        scratch.refused(format!("{command} room.env.ron p.csv -o out.csv"), &["are they metres?"]);
        assert!(!scratch.has("out.csv"));
    }
    scratch.refused("pivot p.csv", &["are they metres?"]);
    scratch.succeed("distort room.env.ron p.csv -o out.csv --as-is");
}

#[test]
fn poses_on_other_axes_than_the_room_are_reported() {
    let scratch = Scratch::new();
    scratch.succeed(fit(GOOD));
    for (sign, is_reported) in [(1, true), (-1, false)] {
        let rows: String = (0..20).map(|k| format!("{k},100,{},1,0,0,0\n", sign * 250)).collect();
        scratch.write("p.csv", format!("{POSE}\n{rows}"));
        for command in ["distort", "compensate"] {
            let notes = scratch.notes(format!("{command} room.env.ron p.csv -o {command}.csv"));
            let has = notes.contains("0 of 20 positions are in the room's box, 20 where z is −z");
            assert_eq!(has, is_reported, "{notes}");
        }
    }
}

#[test]
fn every_command_that_reads_a_table_takes_it_as_is() {
    let scratch = Scratch::new();
    let commands = "fit, select, generator learn, distort, compensate, simulate, import jhu-cis, characterize, \
        pivot, verify, register, export poses, export tips, report";
    for command in commands.split(", ") {
        scratch.succeed_with(format!("{command} --help"), &["--as-is"]);
    }
}

#[test]
fn a_spreadsheet_in_a_european_language_is_read() {
    let scratch = Scratch::new();
    let table = fs::read_to_string(own(ROOM)).unwrap();
    let (head, rows) = table.split_once('\n').unwrap();
    let rows = rows.replace(',', ";").replace('.', ",");
    let names = head.split(',').map(|name| match name.contains("_q") {
        true => format!("\"{}\"", name.replace('_', " ").to_uppercase()),
        false => format!(" {name} (mm) "),
    });
    let head = names.collect::<Vec<_>>().join(";");
    let env = |name: &str, table: &str| {
        fs::create_dir(scratch.path(name)).unwrap();
        scratch.write(&format!("{name}/room.csv"), table);
        let line = format!("fit {name}/room.csv -o {name}/room.env.ron --order 1 --directions 6");
        scratch.succeed(line);
        fs::read(scratch.path(&format!("{name}/room.env.ron"))).unwrap()
    };
    let plain = env("plain", &table);
    assert_eq!(env("european", &format!("\u{feff}sep=;\r\n{head}\n{rows}")), plain);
    assert_eq!(env("tabs", &table.replace(',', "\t")), plain);
}

#[test]
fn other_units_and_missing_headers_are_named() {
    let scratch = Scratch::new();
    let table = fs::read_to_string(own(ROOM)).unwrap();
    let metres = table.replacen("ideal_x", "ideal_x (m)", 1);
    let headless = table.split_once('\n').unwrap().1.to_owned();
    let both_marks = table.replace(',', ";").replacen("0.5", "0,5", 1);
    for (table, words) in [
        (metres, "column \"ideal_x (m)\" is in m, expected mm"),
        (headless, "found numbers, expected names of columns"),
        (both_marks, "the decimal mark of the rows before"),
    ] {
        scratch.write("t.csv", table);
        scratch.refused(fit("t.csv"), &[words]);
    }
}

#[test]
fn files_of_other_kinds_are_named() {
    let scratch = Scratch::new();
    for (name, bytes, words) in [
        ("a.csv", &b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR"[..], "a PNG image"),
        ("a.xlsx", b"PK\x03\x04\x14\0\x06\0", "an Excel workbook"),
        ("a.tra", b"\x01\x02\x03", "an OptiTrack tool"),
        ("tool.rom", b"NDI\0\x01\x02\xff\xfe", "an NDI tool definition"),
        ("b.csv", b"\xff\xfei\0d\0e\0", "UTF-16 text"),
    ] {
        scratch.write(name, bytes);
        for line in [fit(name), format!("pivot {name}"), format!("register {name} {name}")] {
            scratch.refused(line, &[words, "expected"]);
        }
    }
    scratch.write("t.csv", "x,y,z\n1,2,3\n");
    let error = scratch.fail("distort t.csv t.csv -o room.env.ron");
    assert!(error.contains("found a table, expected an environment"), "{error}");
}

#[test]
fn mirrored_and_outlying_fiducials_are_named() {
    let scratch = Scratch::new();
    let points = [&super::register::POINTS[..], &[[10.0, 70.0, 55.0]]].concat();
    let write = |name: &str, map: &dyn Fn(usize, [f64; 3]) -> [f64; 3]| {
        let moved = points.iter().enumerate().map(|(k, point)| map(k, *point).into());
        scratch.write(name, points_table(moved).replace(',', " "));
    };
    write("source.txt", &|_, p| p);
    write("mirrored.txt", &|_, [x, y, z]| [x, -y, z]);
    scratch.refused("register source.txt mirrored.txt", &["mirrored or left-handed"]);
    write("metres.txt", &|_, p| p.map(|v| 1e-3 * v));
    let words = ["are they in metres and millimetres?"];
    scratch.refused("register source.txt metres.txt", &words);
    // Half a millimetre of noise, and one point that slipped.
    let noise = |k: usize| 0.5 * (k as f64 * 2.4).sin();
    write("slipped.txt", &|k, [x, y, z]| {
        let slip = if k == 3 { 15.0 } else { 0.0 };
        [x + noise(k), y + noise(k + 7) + slip, z + noise(k + 13)]
    });
    let register = "register source.txt slipped.txt";
    scratch.notes_with(register, &["warning: point 4 is 1", "--leave-out-outliers"]);
    let found = scratch.json(format!("{register} --leave-out-outliers"));
    assert_eq!(found["points"], 5);
    assert_eq!(found["left_out"][0]["point"], 4);
    let fre = |key: &str| number(&found[key]);
    assert!(fre("fre_rms_mm") < 0.8 && fre("fre_of_all_rms_mm") > 3.0, "{found}");
}

/// A stylus that pivots, in a tracker's frame in which a reference moves.
#[test]
fn a_pivot_is_found_relative_to_a_reference_tool() {
    let scratch = Scratch::new();
    let mut log = String::from("received_s,time_s,tool,state,x,y,z,qw,qx,qy,qz\n");
    for k in 0..60 {
        let t = f64::from(k);
        // The reference drifts along x; the tip rests at (0, 0, 50) of it, 100 mm along the stylus' z.
        let (a, b) = (0.5 * (0.7 * t).sin(), 0.5 * (0.7 * t).cos());
        let angle = a.hypot(b);
        let (sine, cosine) = (0.5 * angle).sin_cos();
        let (x, y, w) = (sine * a / angle, sine * b / angle, cosine);
        let axis = [2.0 * w * y, -2.0 * w * x, w * w - x * x - y * y];
        let drift = 3.0 * t;
        let at = [drift - 100.0 * axis[0], -100.0 * axis[1], 50.0 - 100.0 * axis[2] - 300.0];
        log.push_str(&format!("{t},{t},ReferenceToTracker,OK,{drift},0,-300,1,0,0,0\n"));
        log.push_str(&format!(
            "{t},{t},StylusToTracker,OK,{},{},{},{w},{x},{y},0\n",
            at[0], at[1], at[2]
        ));
    }
    scratch.write("live.csv", log);
    for args in ["--tool StylusToReference", "--tool Stylus --relative-to Reference"] {
        let found = scratch.json(format!("pivot live.csv {args}"));
        let [x, _, z] = numbers::<3>(&found["tip"]);
        assert!((z - 100.0).abs() < 1e-6 && x.abs() < 1e-6, "{found}");
        assert!((number(&found["pivot"][2]) - 50.0).abs() < 1e-6, "{found}");
    }
    scratch.refused("pivot live.csv --tool Stylus", &["--max-rms-mm"]);
}

/// A path of a hand whose readings are so many rows late, beside a smooth field.
fn late_path(scratch: &Scratch, lag_rows: f64) -> String {
    let place = |t: f64| [0.031, 0.047, 0.023].map(|speed| 80.0 * (speed * t).sin());
    let field = |[x, y, z]: [f64; 3]| [0.01 * y, 1e-4 * x * z, 1.0 + 0.008 * x];
    let mut text = format!("{}\n", Table::read(&own(ROOM)).columns.join(","));
    for row in 0..600 {
        let t = f64::from(row);
        let turn = |t: f64| [(0.02 * t).cos(), (0.02 * t).sin() * 0.6, (0.02 * t).sin() * 0.8, 0.0];
        let (ideal, then) = (place(t), place(t - lag_rows));
        let off = field(then);
        let measured: Vec<f64> = (0..3).map(|k| then[k] + off[k]).collect();
        let numbers = ideal.into_iter().chain(turn(t)).chain(measured).chain(turn(t - lag_rows));
        let cells: Vec<String> = numbers.map(|v| v.to_string()).collect();
        text.push_str(&format!("{}\n", cells.join(",")));
    }
    scratch.write("path.csv", text);
    "path.csv".to_owned()
}

#[test]
fn a_lag_is_named_and_taken_out_on_request() {
    let scratch = Scratch::new();
    let fit = format!("{} --format json", fit(&late_path(&scratch, 1.5)));
    let rms = |more: &str| {
        let found: serde_json::Value =
            serde_json::from_str(&scratch.succeed(format!("{fit} {more}"))).unwrap();
        number(&found["train"]["after"]["position_rms_mm"])
    };
    scratch.notes_with(&fit, &["1.50 rows behind", "lag 1.50 takes it out"]);
    let notes = scratch.notes(format!("{fit} --lag 1.5"));
    assert!(!notes.contains("behind"), "{notes}");
    let [late, without] = [rms(""), rms("--lag 1.5")];
    // The path's steps are some millimetres.
    assert!(late > 1.0 && without < 0.1 * late, "{late}, {without}");
    for bad in ["NaN", "101", "-1e9"] {
        scratch
            .refused(format!("{fit} --lag {bad}"), &["--lag: found", "expected -100 to 100 rows"]);
    }
}

#[test]
fn a_coil_beside_a_tip_is_named_in_mm() {
    let scratch = Scratch::new();
    let mut table = Table::read(&own(ROOM));
    for row in &mut table.rows {
        let v: Vec<f64> = row.iter().map(|cell| cell.parse().unwrap()).collect();
        let [w, x, y, z] = [10, 11, 12, 13].map(|k| v[k]);
        let axis = [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)];
        for k in 0..3 {
            row[7 + k] = (v[7 + k] + 10.0 * axis[k]).to_string();
        }
    }
    scratch.write("tip.csv", table.to_text());
    let notes = scratch.notes(fit("tip.csv"));
    assert!(notes.contains("positions are 10.0") || notes.contains("positions are 9.9"), "{notes}");
    assert!(notes.contains("mm along the sensor's z axis"), "{notes}");
    let without = format!("{} --sensor-offset 10 --format json", fit("tip.csv"));
    assert!(!scratch.notes(&without).contains("along the sensor"));
    let rms = |line: String| number(&scratch.json(line)["train"]["after"]["position_rms_mm"]);
    let [with, right] = [without.replace(" --format json", ""), fit(GOOD)].map(rms);
    assert!((with - right).abs() < 0.01, "{with}, {right}");
}

#[test]
fn places_on_a_line_are_refused() {
    let scratch = Scratch::new();
    let on_line = |v: f64, k: usize| if k.is_multiple_of(7) { v } else { 100.0 + 0.001 * v };
    let line = changed(&scratch, "line.csv", |k, v| if is_position(k) { on_line(v, k) } else { v });
    for model in ["kriging", "harmonic --generator planar-nine --degree 2"] {
        let words = ["mm RMS of one line, expected 1 mm at least"];
        scratch.refused(format!("fit {line} -o room.env.ron --as-is --model {model}"), &words);
    }
}

#[test]
fn poses_outside_the_room_are_a_warning() {
    let scratch = Scratch::new();
    scratch.succeed(fit(GOOD));
    let rows: String = (0..40).map(|k| format!("{k},100,-9000,1,0,0,0\n")).collect();
    scratch.write("p.csv", format!("{POSE}\n{rows}"));
    let words = ["warning: 40 of 40 poses are outside the room's box"];
    scratch.notes_with("compensate room.env.ron p.csv -o out.csv", &words);
}

/// Poses of a built-in design's tool and CRF in its room, as they should be and with every mistake that puts them out
/// of it.
#[test]
fn given_poses_out_of_the_room_are_explained() {
    let scratch = Scratch::new();
    let simulate = "simulate pointer-on-head --mode input --input";
    let numbers = |pose: &Pose| pose_to_array(pose).map(|v| v.to_string()).join(",");
    let world = trackwright_project::open_builtin("pointer-on-head").unwrap();
    let design = world.document.design();
    let crf = design.crf.as_ref().unwrap().tracker_from_crf;
    let crf_from_tool = |k: usize| {
        let turn = UnitQuaternion::from_scaled_axis(Vector3::new(0.1, 0.02 * k as f64, 0.3));
        design.tool.crf_from_tool * pose_from_parts(Vector3::new(k as f64, -5.0, 5.0), turn)
    };
    let check = |words: Option<&str>, change: &dyn Fn(Pose, Pose) -> (Pose, Pose)| {
        let columns = ["crf", "tool"].map(|of| POSE.replace(',', &format!(",{of}_")));
        let mut text = format!("crf_{},tool_{}\n", columns[0], columns[1]);
        for k in 0..20 {
            let (crf, tool) = change(crf, crf_from_tool(k));
            text += &format!("{},{}\n", numbers(&crf), numbers(&tool));
        }
        scratch.write("poses.csv", text);
        let notes = scratch.notes(format!("{simulate} poses.csv"));
        match words {
            Some(words) => assert!(notes.contains(words), "{words}: {notes}"),
            None => assert!(!notes.contains("poses.csv"), "{notes}"),
        }
    };
    let scaled = |pose: Pose, by: f64| pose_from_parts(pose.translation.vector * by, pose.rotation);
    check(None, &|crf, tool| (crf, tool));
    let words = "the CRF's positions are in metres";
    check(Some(words), &|crf, tool| (scaled(crf, 1e-3), tool));
    let words = "the CRF's z is its −z";
    check(Some(words), &|crf, tool| {
        let at = crf.translation.vector;
        (pose_from_parts(Vector3::new(at.x, at.y, -at.z), crf.rotation), tool)
    });
    let words = "the tool's poses are in the tracker frame";
    check(Some(words), &|crf, tool| (crf, crf * tool));
    check(Some("are the columns exchanged?"), &|crf, tool| (tool, crf));
    check(Some("poses are inverted"), &|crf, tool| (crf.inverse(), tool));
}
