//! Better places for sensors through the command line: the design that is written has the figures that
//! are printed, no thread changes them, and what cannot be searched is one clear error.

use crate::support::golden::{list, number};
use crate::support::program::{
    Scratch, assert_has, assert_one_line, end_within, processor_seconds, signal,
};
use crate::support::wire::until;
use serde_json::Value;
use std::fs;
use std::time::Duration;
use trackwright_formats::environment;

const DESIGN: &str = "d/pointer-on-head.design.ron";
const BODY: &str = "d/tool.body.ron";
const COIL: &str = "coil: (diameter: 0.8, length: 9.0)";
const CHANNEL: &str = "Channel(points: [(0, 0, 10), (0, 0, 160)], radius: 6.0, axis: AsItIs)";

/// The worked design, with sensors far up in a channel that begins near the tip, over a short range of
/// motion.
fn world() -> Scratch {
    let scratch = Scratch::new();
    scratch.copy_design_with_room("golden/pointer-on-head", "--order 2 --directions 14");
    for (from, to) in [
        ("0.0, 60.0), axis: (0, 0, 1)", "0.0, 130.0), axis: (0, 0, 1)"),
        ("(8.0, 0.0, 95.0)", "(0.0, 0.0, 150.0)"),
    ] {
        scratch.replace(BODY, from, to);
    }
    let body = scratch.read(BODY).replace("),\n", &format!(", {COIL}),\n"));
    let body = body.replace("\n    ],\n)", &format!("\n    ],\n    mounting: [{CHANNEL}],\n)"));
    // The tip is in a line of its own.
    scratch.write(BODY, body.replace(&format!("tip: (0, 0, 0, {COIL})"), "tip: (0, 0, 0)"));
    let text = scratch.read(DESIGN);
    let [motion, end] = ["motion: (", "orientation_weight"].map(|at| text.find(at).unwrap());
    let required = "motion: (x: (min: -40, max: 40, step: 40), rx: (min: -60, max: 60, step: 30)),
    requirement: (position_rms: 0.5),\n    ";
    scratch.write(DESIGN, format!("{}{required}{}", &text[..motion], &text[end..]));
    scratch
}

/// The same in a room that was never measured: its field is what it is, so that each gain is one.
fn exact_world() -> Scratch {
    let scratch = world();
    forget_measurements(&scratch, "d/room.env.ron");
    scratch
}

/// Leaves nothing of a room but its model.
pub fn forget_measurements(scratch: &Scratch, file: &str) {
    let mut room = scratch.environment(file);
    (room.provenance, room.fit_validity, room.process) = (None, None, None);
    scratch.write(file, environment::write(&room, None));
}

#[track_caller]
fn assert_close(found: &Value, expected: &Value, at: &str) {
    match (found, expected) {
        (Value::Object(found), Value::Object(expected)) => {
            let keys =
                |map: &serde_json::Map<String, Value>| map.keys().cloned().collect::<Vec<_>>();
            assert_eq!(keys(found), keys(expected), "{at}");
            for (key, value) in found {
                assert_close(value, &expected[key], &format!("{at}.{key}"));
            }
        }
        (Value::Array(found), Value::Array(expected)) => {
            assert_eq!(found.len(), expected.len(), "{at}");
            for (k, value) in found.iter().enumerate() {
                assert_close(value, &expected[k], &format!("{at}[{k}]"));
            }
        }
        (Value::Number(_), Value::Number(_)) => {
            let [found, expected] = [found, expected].map(number);
            // A file has the numbers of a pose after its quaternion was made one again.
            assert!(
                (found - expected).abs() <= 1e-9 * (1.0 + expected.abs()),
                "{at}: {found} {expected}"
            );
        }
        _ => assert_eq!(found, expected, "{at}"),
    }
}

/// The design that was written has the figures that were printed of it.
#[track_caller]
fn assert_written_as_printed(scratch: &Scratch, design: &str, found: &Value) {
    let single = scratch.json(format!("simulate {design} --mode motion"));
    let written = if found["is_better"] == true { &found["best"] } else { &found["start"] };
    assert_close(&written["figures"], &single, design);
}

#[test]
fn the_better_design_has_the_printed_figures() {
    let scratch = exact_world();
    let before: Vec<_> = [DESIGN, BODY, "d/crf.body.ron"].map(|file| scratch.read(file)).into();
    fs::create_dir(scratch.path("out")).unwrap();
    for better in ["d/better.design.ron", "out/better.design.ron"] {
        // As drawn: figures state no building errors.
        let line = format!("optimize {DESIGN} -o {better} --move s0,s1 --built-error 0,0");
        let found = scratch.json(line);
        assert_eq!(found["is_better"], true);
        let [start, best] = ["start", "best"].map(|key| &found[key]);
        assert!(number(&best["objective"]) < number(&start["objective"]));
        for (design, layout) in [(DESIGN, start), (better, best)] {
            let single = scratch.json(format!("simulate {design} --mode motion"));
            assert_close(&layout["figures"], &single, design);
            assert_close(&layout["rooms"][0]["figures"], &single, design);
        }
        // The largest part of a limit is that of the only limit.
        let rms = number(&best["figures"]["figures"]["position_mm"]["rms"]["value"]);
        assert!((number(&best["objective"]) - rms / 0.5).abs() < 1e-9);
        let gain = &found["gain"][0]["position_mm"]["rms"];
        // The sampling of the motion is known, the uncertainty of the room is not.
        assert_eq!(gain["verdict"], "room_unknown");
        assert!(number(&gain["low"]) < number(&gain["high"]) && number(&gain["high"]) < 0.0);
        // Only the tool has changed, and only where it is new.
        let written: Vec<_> = list(&found, "written").iter().map(|f| f.as_str().unwrap()).collect();
        let body = if better.starts_with("d/") { "d/tool-2.body.ron" } else { "out/tool.body.ron" };
        assert_eq!(written, [body, better]);
        assert!(scratch.read(body).contains("mounting"));
        let candidates = list(&found, "candidates");
        assert_eq!(candidates[0]["tool"], best["tool"]);
        let names = list(best, "tool").iter().map(|own| own["sensor"].as_str().unwrap());
        assert_eq!(names.collect::<Vec<_>>(), ["s0", "s1", "s2"]);
        assert_eq!(best["tool"][2], start["tool"][2]);
        let flat: Vec<_> = list(&found, "flatness").iter().map(|own| &own["sensor"]).collect();
        assert_eq!(flat, ["s0", "s1"]);
        for key in "binding evaluations certain_to_mm pareto undetermined notes stopped".split(' ')
        {
            assert!(found.get(key).is_some(), "{key}");
        }
    }
    let after: Vec<_> = [DESIGN, BODY, "d/crf.body.ron"].map(|file| scratch.read(file)).into();
    assert_eq!(before, after);
}

#[test]
fn no_better_start_is_written_as_it_is() {
    // The measurements of this room do not determine whether the places that are found are better.
    let scratch = world();
    let line = format!("optimize {DESIGN} -o d/better.design.ron --move s0,s1");
    let verdict = "not shown to be better than the start: the interval of the gain holds zero";
    let text = scratch.succeed(&line);
    assert!(text.lines().any(|line| line == verdict), "{text}");
    let words = ["not significant", "which is not written", "written: d/better.design.ron"];
    assert_has(&text, &words, &line);
    assert!(!scratch.has("d/tool-2.body.ron"));
    let single = |design: &str| scratch.json(format!("simulate {design} --mode motion"));
    assert_eq!(single("d/better.design.ron"), single(DESIGN));
    let found = scratch.json(format!("{line} --overwrite"));
    assert_eq!(found["is_better"], false);
    let [start, best] = ["start", "best"].map(|key| number(&found[key]["objective"]));
    assert!(best < start);
    assert_close(&found["start"]["figures"], &single(DESIGN), "start");
    // In several rooms the verdict is on all of them.
    scratch.fit("other.env.ron", "--order 1 --directions 14");
    let rooms = "--environment d/room.env.ron other.env.ron --rooms mean --overwrite";
    let text = scratch.succeed(format!("{line} {rooms}"));
    assert!(text.lines().any(|line| line == verdict), "{text}");
    let found = scratch.json(format!("{line} {rooms}"));
    assert_eq!((list(&found["best"], "rooms").len(), list(&found, "gain").len()), (2, 2));
}

#[test]
fn numbers_of_sensors_make_a_front() {
    let scratch = world();
    let line = format!("optimize {DESIGN} -o d/better.design.ron --move tool --sensors 2-4");
    let found = scratch.json(format!("{line} --kind 5:10 --seconds 20"));
    let pareto = list(&found, "pareto");
    let counts: Vec<usize> = pareto.iter().map(|own| list(own, "tool").len()).collect();
    assert!(!counts.is_empty() && counts.is_sorted(), "{counts:?}");
    for (own, count) in pareto.iter().zip(&counts) {
        assert_eq!(number(&own["cost"]), 10.0 * *count as f64);
    }
    let objectives = pareto.iter().map(|own| number(&own["objective"]));
    assert!(objectives.collect::<Vec<_>>().is_sorted_by(|a, b| a > b), "{pareto:?}");
    assert_written_as_printed(&scratch, "d/better.design.ron", &found);
}

#[test]
fn a_moved_crf_leaves_the_patient() {
    let scratch = world();
    let targets = "), targets: [(name: \"sella\", position: (20, -40, -60))])),\n    tool";
    scratch.replace(DESIGN, "))),\n    tool", targets);
    let line = format!("optimize {DESIGN} -o d/better.design.ron --move crf-pose,generator");
    let found = scratch.json(format!("{line} --crf-bounds 5,3 --generator-bounds 30,0"));
    assert_eq!(found["best"]["tool"], found["start"]["tool"]);
    assert_written_as_printed(&scratch, "d/better.design.ron", &found);
}

/// The CRF of the worked design on a plane of 200 mm, of which it may stand on a part.
fn world_with_patch(patch: &str) -> Scratch {
    let scratch = world();
    let corners = ["-100 -100 0", "100 -100 0", "100 100 0", "-100 100 0"];
    let vertices = corners.map(|corner| format!("v {corner}\n")).concat();
    scratch.write("d/skin.obj", format!("{vertices}f 1 2 3\nf 1 3 4\n"));
    let pose = "pose: (position: (0, 0, -9), rotation: (1, 0, 0, 0))";
    let anatomy = format!(
        "anatomy: [(name: \"skin\", mesh: \"skin.obj\", {pose}, crf_patch: [{patch}])],\n    motion: ("
    );
    scratch.replace(DESIGN, "motion: (", &anatomy);
    scratch
}

#[test]
fn the_crf_glides_over_its_patch() {
    let scratch = world_with_patch("(min: (-60, -60, -5), max: (60, 60, 5))");
    // In an exact room, as drawn, there is a better place.
    forget_measurements(&scratch, "d/room.env.ron");
    let line = format!(
        "optimize {DESIGN} -o d/better.design.ron --seconds 3 --move crf-pose --built-error 0,0"
    );
    let found = scratch.json(&line);
    assert_eq!(found["start"]["crf_moved"], Value::Null);
    assert_eq!(found["best"]["generator_moved"], Value::Null);
    let pose = |layout: &str| -> Vec<f64> {
        list(&found[layout], "tracker_from_crf").iter().map(number).collect()
    };
    let (start, best) = (pose("start"), pose("best"));
    let way: Vec<f64> = (0..3).map(|k| best[k] - start[k]).collect();
    let way_mm = way.iter().map(|part| part * part).sum::<f64>().sqrt();
    let moved = &found["best"]["crf_moved"];
    assert!((number(&moved["way_mm"]) - way_mm).abs() < 1e-9, "{moved} {way_mm}");
    // Over a plane the CRF is only turned about the normal, by 10° at the most.
    assert!(way_mm > 1.0 && number(&moved["turn_deg"]) <= 10.0 + 1e-9, "{moved}");
    let notes = list(&found, "notes").iter().map(Value::to_string).collect::<String>();
    assert!(notes.contains("stands on the patch of the anatomy"), "{notes}");
    let text = scratch.succeed(format!("{line} --overwrite --crf-bounds 15,0"));
    assert!(text.contains("the CRF on the patient"), "{text}");
    assert!(text.contains("turned by 0.00°"), "{text}");
}

#[test]
fn a_patch_without_the_crf_is_one_error() {
    for (patch, words) in [
        (
            "(min: (40, 40, -5), max: (60, 60, 5))",
            "the CRF does not stand on the crf_patch of the anatomy \"skin\": the point of the surface that \
             is nearest to the CRF is (",
        ),
        (
            "(min: (40, 40, 5), max: (60, 60, 9))",
            "no point of the surface of the anatomy \"skin\" is in its crf_patch: the nearest corner is ",
        ),
    ] {
        let scratch = world_with_patch(patch);
        scratch
            .refused(format!("optimize {DESIGN} -o better.design.ron --move crf-pose"), &[words]);
        assert!(!scratch.has("better.design.ron"), "{patch}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_signal_keeps_the_best_so_far() {
    let scratch = Scratch::new();
    let line = "optimize pointer-on-head -o better.design.ron --seconds 3000 --format json";
    let mut command = scratch.command(line);
    // A pipe that nobody reads would fill up.
    let printed = fs::File::create(scratch.path("printed.json")).unwrap();
    let mut child = command.stdout(printed).spawn().unwrap();
    until("work", || processor_seconds(child.id()) > 2.0);
    signal(&child, "-INT");
    let status = end_within(&mut child, Duration::from_secs(120));
    assert!(status.success(), "{status}");
    let found: Value = serde_json::from_str(&scratch.read("printed.json")).unwrap();
    assert_eq!(found["stopped"], true);
    assert!(number(&found["best"]["objective"]) <= number(&found["start"]["objective"]));
    assert_written_as_printed(&scratch, "better.design.ron", &found);
}

#[test]
fn what_cannot_be_searched_is_one_error() {
    let scratch = world();
    let base = format!("optimize {DESIGN} -o better.design.ron");
    let fails = |args: &str, words: &[&str]| {
        scratch.refused(format!("{base} {args}"), words);
        assert!(!scratch.has("better.design.ron"), "{args}");
    };
    for (args, words) in [
        (
            "--move tip",
            "--move: found no sensor \"tip\", expected tool, crf, generator, crf-pose, s0, s1, s2",
        ),
        ("--sensors 4-2", "expected a number from 1 to 32"),
        ("--move s0,s1 --sensors 1", "1 to 1 sensors of the tool, of which 1 do not move"),
        ("--move crf-pose --sensors 2", "--sensors and --kind need sensors that move"),
        ("--move crf-pose --crf-bounds -1,5", "expected mm and degrees with a comma"),
        ("--crf-bounds 5,5", "--crf-bounds needs --move crf-pose"),
        ("--generator-bounds 5,5", "--generator-bounds needs --move generator"),
        (
            "--sensors 3-12 --kind 5:1 --kind 6:2 --kind 6:3:1x8",
            "sets of sensors, expected at most 100",
        ),
        ("--kind 4:10", "with 5 or 6 degrees of freedom"),
        ("--metric rms", "expected one of position_rms, "),
        ("--seconds 0", "expected a number above zero"),
        ("--environment d/room.env.ron d/room.env.ron", "found the same environment named twice"),
        ("--environment gone.env.ron", "gone.env.ron: File not found, expected an environment"),
    ] {
        fails(args, &[words]);
    }
    // Files that are wrong, or not to be written.
    for (line, words) in [
        (
            "optimize gone.design.ron -o a".to_owned(),
            &["gone.design.ron: File not found", "a design"][..],
        ),
        (format!("optimize {DESIGN} -o {DESIGN}"), &["found a file that is read here"]),
        (format!("optimize {DESIGN} -o {BODY}"), &["found a file that is read here"]),
        (format!("optimize {DESIGN} -o no/a.design.ron"), &["no/a.design.ron", "no such"]),
    ] {
        scratch.fail_with(line, words);
    }
    scratch.copy(DESIGN, "d/own.design.ron");
    let line = format!("optimize {DESIGN} -o d/own.design.ron");
    scratch.fail_with(line, &["d/own.design.ron: found a design", "--overwrite"]);
    let required = "requirement: (position_rms: 0.5),";
    scratch.replace(DESIGN, required, "");
    fails(
        "",
        &[DESIGN, "found no requirement, expected one in the design, or a figure by --metric"],
    );
    // No place: the coil is wider than its channel.
    scratch.replace(BODY, "radius: 6.0", "radius: 0.3");
    let message = scratch.fail(format!("{base} --move s0 --metric position_rms"));
    assert_one_line(&message, &[DESIGN, "no place of the tool holds the coil of s0"]);
}

#[test]
fn a_design_without_crf_has_none_to_move() {
    let scratch = Scratch::new();
    scratch.copy_design_with_room("golden/pointer-no-crf", "--order 1 --directions 6");
    for name in ["crf", "crf-pose"] {
        let optimize = "optimize d/pointer-no-crf.design.ron -o a.design.ron --metric position_rms";
        let words = ["--move", &format!("{name}: the design has no CRF")];
        scratch.fail_with(format!("{optimize} --move {name}"), &words);
    }
}
