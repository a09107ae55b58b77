//! Two commands at once on one design: both report that they saved, and both have.

use crate::support::program::{Scratch, json, succeed, text, trackwright};
use std::fs;
use std::process::Stdio;

/// Races of each kind; more with `TRACKWRIGHT_RUNS`.
fn runs() -> usize {
    let runs = std::env::var("TRACKWRIGHT_RUNS");
    runs.map_or(3, |runs| runs.parse().unwrap())
}

/// A design whose study is short, with two rooms beside its own.
fn design() -> (Scratch, String) {
    let scratch = Scratch::new();
    scratch.copy_own("golden/pointer-on-head", "d");
    for room in ["d/room.env.ron", "d/ward.env.ron", "d/theatre.env.ron"] {
        scratch.succeed(format!("fit own:room-a/room-a-fit.csv -o {room} --order 0 --no-support"));
    }
    let file = scratch.path("d/pointer-on-head.design.ron");
    let design = fs::read_to_string(&file).unwrap();
    let line = design.lines().find(|line| line.contains("motion:")).unwrap();
    let design = design.replace(line, &format!("{line}\n    requirement: (position_rms: 60.0),"));
    fs::write(&file, design).unwrap();
    (scratch, text(&file))
}

/// Runs both at once; each must end well.
fn race(first: &[&str], second: &[&str]) {
    let children = [first, second].map(|args| {
        let mut command = trackwright(args);
        command.stdout(Stdio::null()).stderr(Stdio::piped());
        command.spawn().unwrap()
    });
    for child in children {
        let output = child.wait_with_output().unwrap();
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{message}");
    }
}

#[test]
#[ignore = "long: races"]
fn long_decisions_made_at_once_are_both_kept() {
    let (_scratch, design) = design();
    for run in 0..runs() {
        race(
            &["procedure", &design, "--decide", "crf", "--note", "good"],
            &["procedure", &design, "--decide", "tool", "--note", "good"],
        );
        let found = json(&["procedure", &design]);
        let steps = found["steps"].as_array().unwrap();
        for step in &steps[..2] {
            assert_eq!(step["state"], "decided", "run {run}: {step}");
        }
        succeed(&["procedure", &design, "--withdraw", "crf"]);
        succeed(&["procedure", &design, "--withdraw", "tool"]);
    }
}

#[test]
#[ignore = "long: races"]
fn long_rooms_added_at_once_are_both_kept() {
    let (scratch, design) = design();
    let [ward, theatre] = ["d/ward.env.ron", "d/theatre.env.ron"].map(|name| scratch.arg(name));
    for run in 0..runs() {
        race(
            &["procedure", &design, "--add-room", &ward],
            &["procedure", &design, "--add-room", &theatre],
        );
        let text = fs::read_to_string(&design).unwrap();
        let has = |room: &str| text.contains(room);
        assert!(has("ward.env.ron") && has("theatre.env.ron"), "run {run}: {text}");
        scratch.succeed(format!("procedure {design} --remove-room {ward} {theatre}"));
    }
}

#[test]
fn comments_of_a_design_are_not_lost_by_a_decision() {
    let (scratch, design) = design();
    let written = format!("// by hand\n{}", fs::read_to_string(&design).unwrap());
    fs::write(&design, &written).unwrap();
    let args = ["procedure", &design, "--decide", "tool", "--note", "good"];
    let output = trackwright(&args).output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{stderr}");
    let former = format!("{design}.old");
    assert!(stderr.contains(&former), "{stderr}");
    assert_eq!(fs::read_to_string(&former).unwrap(), written);
    assert!(!fs::read_to_string(&design).unwrap().contains("by hand"));
    // What has no comments is kept by being what the program writes.
    scratch.succeed(format!("procedure {design} --withdraw tool"));
    let names = fs::read_dir(scratch.path("d")).unwrap();
    let old = names.filter(|entry| {
        let name = entry.as_ref().unwrap().file_name();
        name.to_string_lossy().contains(".old")
    });
    assert_eq!(old.count(), 1);
}
