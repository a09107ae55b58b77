//! Tool definitions through body files and back: real ones to the byte, and what is reported of each.

use crate::support::data::third_party;
use crate::support::golden::{list, number, numbers};
use crate::support::program::{Scratch, text};
use serde_json::Value;

/// The files of the shared set, in order.
fn roms() -> Option<Vec<std::path::PathBuf>> {
    let folder = third_party("rom")?;
    let entries = std::fs::read_dir(folder).unwrap();
    let mut files: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert_eq!(files.len(), 21);
    Some(files)
}

/// Converts; what was printed and what was noted beside it.
fn convert(scratch: &Scratch, from: &str, to: &str) -> (Value, String) {
    scratch.json_and_notes(format!("convert {from} {to}"))
}

#[test]
fn real_definitions_round_trip_to_the_byte() {
    let Some(files) = roms() else { return };
    for file in files {
        let scratch = Scratch::new();
        let name = file.file_name().unwrap().to_str().unwrap();
        let original = std::fs::read(&file).unwrap();
        let (found, noted) = convert(&scratch, &text(&file), "a.body.ron");
        assert_eq!(noted, "", "{name}");
        let rom = &found["read"]["rom"];
        assert_eq!(rom["checksum"]["matches"], true, "{name}");
        let trailing = if name.contains("REFERENCE_frame_small") { 8 } else { 0 };
        assert_eq!(rom["trailing_bytes"], trailing, "{name}");
        let (found, noted) = convert(&scratch, "a.body.ron", "a.rom");
        assert_eq!(found["lost"], serde_json::json!([]), "{name}");
        assert_eq!(noted.contains("experimental"), name.starts_with("610029"), "{name}");
        assert_eq!(std::fs::read(scratch.path("a.rom")).unwrap(), original, "{name}");
        // And wrapped in a property list.
        convert(&scratch, "a.body.ron", "a.tool");
        convert(&scratch, "a.tool", "b.rom");
        assert_eq!(std::fs::read(scratch.path("b.rom")).unwrap(), original, "{name}");
    }
}

#[test]
fn trailing_bytes_and_a_long_name_are_reported() {
    let Some(files) = roms() else { return };
    let file = &files[files.iter().position(|f| text(f).contains("8a41d90b")).unwrap()];
    let scratch = Scratch::new();
    let words = scratch.succeed(format!("convert {} a.body.ron", text(file)));
    let has = |label: &str, value: &str| {
        let is = |line: &str| line.starts_with(label) && line.ends_with(value);
        assert!(words.lines().any(is), "{label}: {words}");
    };
    has("trailing bytes", "8: EE FD FF FF FD FD FF FF");
    has("manufacturer", "SINTEF helse");
    has("part number", "Reference_small");
    has("checksum", ", matches");
}

#[test]
fn known_tools_have_known_markers() {
    let Some(folder) = third_party("rom") else { return };
    let known: [(&str, [[f64; 3]; 4]); 4] = [
        ("8700338", [[0.0; 3], [0.0, 25.28, 16.15], [0.0, 0.0, 65.0], [0.0, -18.65, 29.61]]),
        ("8700339", [[0.0; 3], [0.0, 28.59, 41.02], [0.0, 0.0, 88.0], [0.0, -44.32, 40.45]]),
        ("8700340", [[0.0; 3], [0.0, 0.0, 50.0], [0.0, 25.0, 100.0], [0.0, -25.0, 135.0]]),
        ("8700449", [[0.0; 3], [0.0, 47.38, 28.99], [0.0, 0.0, 89.1], [0.0, -35.36, 35.36]]),
    ];
    let scratch = Scratch::new();
    for (part, places) in known {
        let file = text(&folder.join(format!("{part}.rom")));
        let (found, _) = convert(&scratch, &file, "a.body.ron");
        let read = &found["read"];
        assert_eq!(read["rom"]["part_number"], part);
        let sensors = list(read, "sensors");
        assert_eq!(sensors.len(), places.len());
        for (sensor, place) in sensors.iter().zip(places) {
            for (found, expected) in numbers::<3>(&sensor["position"]).iter().zip(place) {
                // Half a step of a 32-bit number at 128 mm.
                assert!((found - expected).abs() < 4e-6, "{part}: {sensor}");
            }
        }
        let [a, b] = [places[0], places[1]].map(nalgebra::Point3::from);
        let distance = number(&read["pairs"][0]["distance_mm"]);
        assert!((distance - (b - a).norm()).abs() < 1e-5, "{part}");
    }
    let file = text(&folder.join("8700339.rom"));
    let (found, _) = convert(&scratch, &file, "a.body.ron");
    let rom = &found["read"]["rom"];
    assert_eq!(rom["unique_id"], "01-34801403-8700339");
    assert_eq!(rom["date"], "2005-01-06");
    // What is left over behind the markers that count is no marker.
    let file = text(&folder.join("medtronic-PN960556.rom"));
    let (found, _) = convert(&scratch, &file, "a.body.ron");
    assert_eq!(list(&found["read"], "sensors").len(), 5);
}

#[test]
fn the_aurora_sensor_is_two_coils_that_cross() {
    let Some(file) = third_party("rom/610029-6DOF.rom") else { return };
    let scratch = Scratch::new();
    let (found, _) = convert(&scratch, &text(&file), "a.body.ron");
    let read = &found["read"];
    assert_eq!(read["kind"], "ndi_em");
    assert_eq!(read["rom"]["checksum"]["stored"], 4235);
    assert_eq!(read["rom"]["date"], "2011-03-10");
    let pair = &read["pairs"][0];
    assert!((number(&pair["distance_mm"]) - 0.7).abs() < 1e-6, "{pair}");
    // The polar angles are 0.218224 rad each.
    assert!((number(&pair["angle_deg"]) - 25.0).abs() < 0.05, "{pair}");
    scratch.succeed_with(
        format!("convert {} b.body.ron", text(&file)),
        &["distance, mm", "0.700", "25.0"],
    );
}

const MARKERS: &str = "(version: 1, name: \"triangle\", tip: (0, 0, -120.5), sensors: [
    (name: \"left\", kind: Marker, position: (-30, 0.1, 0)),
    (name: \"right\", kind: Marker, position: (30, 0, 0)),
    (name: \"top\", kind: Marker, position: (0, 55, 0)),
])";

const COILS: &str = "(version: 1, name: \"probe\", sensors: [
    (name: \"coil 1\", kind: FiveDof, position: (-2, 0, 40), axis: (0, 0, 1)),
    (name: \"coil 2\", kind: FiveDof, position: (2, 0, 60), axis: (1, 0, 0)),
])";

#[test]
fn each_loss_of_a_format_is_one_line() {
    let scratch = Scratch::new();
    scratch.write("a.body.ron", MARKERS);
    let (found, noted) = convert(&scratch, "a.body.ron", "a.rom");
    assert_eq!(found["written"]["new_image"], true);
    assert_eq!(found["written"]["kind"], "ndi_optical");
    let lines: Vec<_> = noted.lines().collect();
    assert_eq!(lines.len(), 3, "{noted}");
    assert!(lines[0].ends_with("without the tip (0 0 -120.5 mm): a ROM's own is its origin"));
    assert!(
        lines[1].ends_with("without the names of 3 sensors, \"left\" the first: they have numbers")
    );
    // A pivot is a tip: text formats keep it, and 64-bit numbers too.
    let (found, _) = convert(&scratch, "a.body.ron", "a.ini");
    let codes = |found: &Value| {
        let lost = list(found, "lost").iter();
        lost.map(|l| l["what"].as_str().unwrap().to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(codes(&found), ["body_name", "sensor_names"]);
    let (found, _) = convert(&scratch, "a.ini", "a.json");
    assert_eq!(codes(&found), [""; 0]);
    let (found, _) = convert(&scratch, "a.json", "b.body.ron");
    assert_eq!(numbers(&found["read"]["tip"]), [0.0, 0.0, -120.5]);
    assert_eq!(numbers(&found["read"]["sensors"][0]["position"]), [-30.0, 0.1, 0.0]);

    scratch.write("a.body.ron", COILS);
    let (found, noted) = convert(&scratch, "a.body.ron", "b.rom");
    assert_eq!(found["written"]["experimental"], true);
    assert!(noted.contains("writing Aurora ROMs is experimental"), "{noted}");
    assert_eq!(codes(&found), [""; 0]);
}

#[test]
fn impossible_conversions_are_refused() {
    let scratch = Scratch::new();
    scratch.write("a.body.ron", COILS);
    convert(&scratch, "a.body.ron", "a.rom");
    let mut image = std::fs::read(scratch.path("a.rom")).unwrap();
    image[60] ^= 1;
    scratch.write("a.rom", &image);
    scratch.refused(
        "convert a.rom out.body.ron",
        &["checksum is ", "(--force reads it all the same)"],
    );
    let one_six = COILS.replace(
        "FiveDof, position: (-2, 0, 40), axis: (0, 0, 1)",
        "SixDof, position: (0, 0, 0), rotation: (1, 0, 0, 0)",
    );
    scratch.write("a.body.ron", &one_six);
    for (to, words) in [
        ("out.rom", "0 markers, 1 5-DOF and 1 6-DOF sensors, expected markers alone"),
        ("out.txt", "expected one in .body.ron, .rom, .tool, .ini or .json"),
        ("a.body.ron", "a file that is read here"),
    ] {
        scratch.refused(format!("convert a.body.ron {to}"), &[words]);
    }
    assert_eq!(scratch.read("a.body.ron"), one_six);
    for name in ["out.body.ron", "out.rom", "out.txt"] {
        assert!(!scratch.has(name), "{name}");
    }
    let (found, noted) = convert(&scratch, "a.rom", "out.body.ron --force");
    assert_eq!(found["read"]["rom"]["checksum"]["matches"], false);
    assert!(noted.contains("read from an image whose checksum is "), "{noted}");
    let (_, noted) = convert(&scratch, "out.body.ron", "out.rom");
    assert!(noted.contains("checksum was "), "{noted}");
    convert(&scratch, "out.rom", "out.body.ron");
}

/// Writes `a.design.ron`, whose tool is this file.
fn design_with(scratch: &Scratch, tool: &str) {
    let room = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/environments/operating-table.env.ron");
    let written = format!(
        "(version: 1, name: \"a\", environment: {room:?}, tool: (body: {tool:?}, pose: (position: (0, 30, -190), rotation: (1, 0, 0, 0))),
         motion: (x: (min: -30, max: 30, step: 30)))"
    );
    scratch.write("a.design.ron", written);
}

#[test]
fn a_makers_file_is_simulated_like_its_body() {
    let scratch = Scratch::new();
    for body in [MARKERS, COILS] {
        // Places that a 32-bit number holds, so that both are the same tool.
        let body = body.replace("0.1", "0.125").replace("tip: (0, 0, -120.5), ", "");
        scratch.write("a.body.ron", body);
        let simulated = |tool: &str| {
            design_with(&scratch, tool);
            scratch.json("simulate a.design.ron --mode motion")["room_field"]["position_mm"].clone()
        };
        let expected = simulated("a.body.ron");
        assert!(number(&expected["rms"]) > 0.01, "{expected}");
        for tool in ["a.rom", "a.tool"] {
            // The one of the markers, for the coils.
            let _ = std::fs::remove_file(scratch.path(tool));
            convert(&scratch, "a.body.ron", tool);
            let found = simulated(tool);
            let [found, expected] = [&found, &expected].map(|v| number(&v["rms"]));
            // Axes of coils are rounded to 1.2e-7 rad.
            assert!((found - expected).abs() < 1e-4, "{found} {expected}");
        }
    }
    let mut image = std::fs::read(scratch.path("a.rom")).unwrap();
    image[70] ^= 1;
    scratch.write("a.rom", image);
    design_with(&scratch, "a.rom");
    scratch.refused("simulate a.design.ron --mode motion", &["a.rom: checksum is "]);
}

#[test]
fn indistinguishable_tools_are_named() {
    let scratch = Scratch::new();
    let moved = MARKERS.replace("(0, 0, -120.5)", "(0, 0, -80.5)");
    for (name, body) in [("a.body.ron", MARKERS), ("b.body.ron", &moved), ("c.body.ron", COILS)] {
        scratch.write(name, body);
    }
    let line = "convert --check a.body.ron b.body.ron c.body.ron";
    let output = scratch.command(line).output().unwrap();
    let printed = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(1), "{printed}");
    // One tool with another tip is the same to a tracker.
    assert!(printed.contains("b.body.ron: indistinguishable"), "{printed}");
    let noted = String::from_utf8(output.stderr).unwrap();
    assert!(noted.contains("known by its port and serial number"), "{noted}");
    let Some(files) = roms() else { return };
    let [a, b] = [&files[0], &files[1]].map(|file| text(file));
    let line = format!("convert --check {a} {b} --format json");
    let output = scratch.command(&line).output().unwrap();
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(list(&found, "pairs").len(), 3, "{found}");
    scratch.refused("convert --check a.body.ron --least-mm 0", &["above zero"]);
}
