//! A machine without a display: the main job is still done.

use crate::support::program::{json, text, trackwright};
use std::path::Path;

#[test]
fn without_a_display_the_design_is_simulated() {
    let output =
        trackwright(&[]).env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").output().unwrap();
    let (out, err) =
        (String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap());
    assert!(output.status.success(), "{err}");
    assert_eq!(err.lines().count(), 1, "{err}");
    assert!(err.contains("no editor"), "{err}");
    assert!(!err.contains("panicked"), "{err}");
    assert!(out.contains("tip error RMS"), "{out}");
}

#[test]
fn built_in_designs_simulate_with_a_verdict() {
    let designs = Path::new(env!("CARGO_MANIFEST_DIR")).join("designs");
    let mut seen = 0;
    for entry in std::fs::read_dir(designs).unwrap() {
        let path = entry.unwrap().path();
        if !text(&path).ends_with(".design.ron") {
            continue;
        }
        seen += 1;
        let figures = json(&["simulate", &text(&path), "--mode", "motion"]);
        let verdict = figures["requirement"]["verdict"].as_str().unwrap();
        assert!(["met", "missed"].contains(&verdict), "{}: {verdict}", path.display());
        assert!(figures.get("free_axis").is_none(), "{}", path.display());
    }
    assert!(seen >= 3);
}
