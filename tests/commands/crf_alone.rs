//! Step 2 of the paper's procedure: the CRF alone against the tracker.

use crate::support::close::assert_close;
use crate::support::program::{Scratch, fail, json};
use serde_json::Value;

fn built_in(name: &str) -> String {
    format!("{}/designs/{name}.design.ron", env!("CARGO_MANIFEST_DIR"))
}

/// The built-in design with a range of motion and a requirement of its CRF.
fn with_motion(scratch: &Scratch) -> String {
    let folder = env!("CARGO_MANIFEST_DIR");
    let text = std::fs::read_to_string(built_in("pointer-on-head")).unwrap();
    let study = "motion: (x: (min: -40.0, max: 40.0, step: 40.0), rz: (min: -30.0, max: 30.0, step: 30.0)), requirement: (position_rms: 0.5),\n    ),\n    tool: (";
    let text = text
        .replacen("),\n    tool: (", study, 1)
        .replace("../assets", &format!("{folder}/assets"));
    let file = scratch.path("crf.design.ron");
    std::fs::write(&file, text).unwrap();
    file.to_string_lossy().into_owned()
}

#[test]
fn a_crf_alone_equals_a_tool_at_the_target() {
    let scratch = Scratch::new();
    let design = with_motion(&scratch);
    let of_crf = scratch.json(format!("simulate {design} --mode motion --body crf"));
    let targets = of_crf["targets"].as_array().unwrap();
    let names: Vec<&str> = targets.iter().map(|t| t["target"].as_str().unwrap()).collect();
    assert_eq!(names, ["right maxillary sinus", "left maxillary sinus", "sella"]);

    // The same by another way: the CRF's body as a tool of its own, tip at the sella.
    let body = std::fs::read_to_string(format!(
        "{}/assets/bodies/head-crf.body.ron",
        env!("CARGO_MANIFEST_DIR")
    ))
    .unwrap();
    let mesh = body.find("mesh:").unwrap();
    let end = mesh + body[mesh..].find('\n').unwrap();
    let body = format!("{}tip: (0.0, -38.0, 75.0),{}", &body[..mesh], &body[end..]);
    scratch.write("tool.body.ron", body);
    let room =
        format!("{}/assets/environments/operating-table.env.ron", env!("CARGO_MANIFEST_DIR"));
    let text = format!(
        r#"(version: 1, name: "as a tool", environment: "{room}",
        tool: (body: "tool.body.ron", pose: (position: (-50.0, 0.0, -300.0), rotation: (1.0, 0.0, 0.0, 0.0))),
        motion: (x: (min: -40.0, max: 40.0, step: 40.0), rz: (min: -30.0, max: 30.0, step: 30.0)),
        requirement: (position_rms: 0.5))"#
    );
    let alone = scratch.path("alone.design.ron");
    std::fs::write(&alone, text).unwrap();
    let as_tool = json(&["simulate", &alone.to_string_lossy(), "--mode", "motion"]);
    let sella = &targets[2];
    assert_eq!(sella["trials"], 9);
    for quantity in ["position_mm", "angle_deg"] {
        for figure in ["rms", "mean", "std", "min", "median", "p95", "max"] {
            assert_eq!(sella[quantity][figure], as_tool[quantity][figure]);
        }
    }
    assert_eq!(sella["requirement"], as_tool["requirement"]);
    // A place further from the sensors is worse or better, but not the same.
    assert_ne!(sella["position_mm"], targets[0]["position_mm"]);

    let text = scratch.succeed(format!("simulate {design} --mode motion --body crf"));
    assert!(text.contains("Head CRF at sella, alone in Operating table"), "{text}");
    assert_eq!(text.matches("requirement position_rms").count(), 3, "{text}");
}

#[test]
fn the_crf_error_is_measured_at_the_target() {
    let of_crf =
        json(&["simulate", &built_in("pointer-on-head"), "--mode", "single", "--body", "crf"]);
    for target in of_crf["targets"].as_array().unwrap() {
        let error: Vec<f64> =
            (target["error_mm"].as_array().unwrap().iter()).map(|v| v.as_f64().unwrap()).collect();
        let length = error.iter().map(|v| v * v).sum::<f64>().sqrt();
        let rms = target["position_mm"]["rms"].as_f64().unwrap();
        assert_close("length of the error", length, rms, 1e-12, 1e-3);
        assert_eq!(target["requirement"], Value::Null);
    }
}

#[test]
fn unsupported_crf_studies_are_refused() {
    let endoscope = built_in("endoscope");
    let why = fail(&["simulate", &endoscope, "--mode", "single", "--body", "crf"]);
    assert!(why.contains("endoscope") && why.contains("no CRF"), "{why}");
    let pointer = built_in("pointer-on-head");
    let why = fail(&["simulate", &pointer, "--mode", "motion", "--body", "crf"]);
    assert!(why.contains("crf.motion is absent"), "{why}");
    let log = ["--log", "log.csv"];
    let of_crf = ["simulate", &pointer, "--mode", "single", "--body", "crf"];
    let why = fail(&[&of_crf[..], &log].concat());
    assert!(why.contains("--log is of the tool's study"), "{why}");
}
