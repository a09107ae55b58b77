//! Step 2 of the paper's procedure: the CRF alone against the tracker.

use crate::support::close::assert_close;
use crate::support::golden::{list, number, numbers};
use crate::support::program::Scratch;
use serde_json::Value;

const STUDY: &str = "motion: (x: (min: -40.0, max: 40.0, step: 40.0), rz: (min: -30.0, max: 30.0, step: 30.0)), \
    requirement: (position_rms: 0.5)";

#[test]
fn a_crf_alone_equals_a_tool_at_the_target() {
    let scratch = Scratch::new();
    let study = format!("{STUDY},\n    ),\n    tool: (");
    scratch.copy_built_in("pointer-on-head", "crf.design.ron", "),\n    tool: (", &study);
    let simulate = "simulate crf.design.ron --mode motion --body crf";
    let of_crf = scratch.json(simulate);
    let targets = list(&of_crf, "targets");
    let names: Vec<&str> = targets.iter().map(|t| t["target"].as_str().unwrap()).collect();
    assert_eq!(names, ["right maxillary sinus", "left maxillary sinus", "sella"]);

    // The same by another way: the CRF's body as a tool of its own, tip at the sella.
    let assets = concat!(env!("CARGO_MANIFEST_DIR"), "/assets");
    let body = std::fs::read_to_string(format!("{assets}/bodies/head-crf.body.ron")).unwrap();
    let mesh = body.find("mesh:").unwrap();
    let end = mesh + body[mesh..].find('\n').unwrap();
    let body = format!("{}tip: (0.0, -38.0, 75.0),{}", &body[..mesh], &body[end..]);
    scratch.write("tool.body.ron", body);
    let text = format!(
        r#"(version: 1, name: "as a tool", environment: "{assets}/environments/operating-table.env.ron",
        tool: (body: "tool.body.ron", pose: (position: (-50.0, 0.0, -300.0), rotation: (1.0, 0.0, 0.0, 0.0))),
        {STUDY})"#
    );
    scratch.write("alone.design.ron", text);
    let as_tool = scratch.json("simulate alone.design.ron --mode motion");
    let sella = &targets[2];
    assert_eq!(sella["trials"], 9);
    for quantity in ["position_mm", "angle_deg"] {
        for figure in ["rms", "mean", "std", "min", "median", "p95", "max"] {
            assert_eq!(
                sella["room_field"][quantity][figure],
                as_tool["room_field"][quantity][figure]
            );
        }
    }
    assert_eq!(sella["requirement"], as_tool["requirement"]);
    // A place further from the sensors is worse or better, but not the same.
    assert_ne!(sella["room_field"]["position_mm"], targets[0]["room_field"]["position_mm"]);

    let text = scratch.succeed_with(simulate, &["Head CRF at sella, alone in Operating table"]);
    assert_eq!(text.matches("requirement position_rms").count(), 3, "{text}");
}

#[test]
fn the_crf_error_is_measured_at_the_target() {
    let line = "simulate designs/pointer-on-head.design.ron --mode single --body crf";
    for target in list(&Scratch::new().json(line), "targets") {
        let length = numbers::<3>(&target["error_mm"]).map(|v| v * v).iter().sum::<f64>().sqrt();
        let rms = number(&target["room_field"]["position_mm"]["rms"]);
        assert_close("length of the error", length, rms, 1e-12, 1e-3);
        assert_eq!(target["requirement"], Value::Null);
    }
}

#[test]
fn unsupported_crf_studies_are_refused() {
    let scratch = Scratch::new();
    for (args, words) in [
        ("endoscope.design.ron --mode single", &["endoscope", "no CRF"][..]),
        ("pointer-on-head.design.ron --mode motion", &["crf.motion is absent"]),
        (
            "pointer-on-head.design.ron --mode single --log log.csv",
            &["--log is of the tool's study"],
        ),
    ] {
        scratch.refused(format!("simulate designs/{args} --body crf"), words);
    }
}
