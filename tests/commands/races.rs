//! Two commands at once on one design: both report that they saved, and both have.

use crate::support::golden::list;
use crate::support::program::Scratch;
use std::fs;
use std::process::Stdio;

const DESIGN: &str = "d/pointer-on-head.design.ron";

/// Races of each kind; more with `TRACKWRIGHT_RUNS`.
fn runs() -> usize {
    let runs = std::env::var("TRACKWRIGHT_RUNS");
    runs.map_or(3, |runs| runs.parse().unwrap())
}

/// A design whose study is short, with two rooms beside its own.
fn design() -> Scratch {
    let scratch = Scratch::new();
    scratch.copy_own("golden/pointer-on-head", "d");
    for room in ["d/room.env.ron", "d/ward.env.ron", "d/theatre.env.ron"] {
        scratch.fit(room, "--order 0 --no-support");
    }
    scratch.replace(DESIGN, "    motion:", "    requirement: (position_rms: 60.0),\n    motion:");
    scratch
}

/// Runs both at once; each must end well.
fn race(scratch: &Scratch, options: [&str; 2]) {
    let children = options.map(|options| {
        let mut command = scratch.command(&format!("procedure {DESIGN} {options}"));
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
    let scratch = design();
    for run in 0..runs() {
        race(&scratch, ["--decide crf --note good", "--decide tool --note good"]);
        let found = scratch.json(format!("procedure {DESIGN}"));
        for step in &list(&found, "steps")[..2] {
            assert_eq!(step["state"], "decided", "run {run}: {step}");
        }
        for step in ["crf", "tool"] {
            scratch.succeed(format!("procedure {DESIGN} --withdraw {step}"));
        }
    }
}

#[test]
#[ignore = "long: races"]
fn long_rooms_added_at_once_are_both_kept() {
    let scratch = design();
    for run in 0..runs() {
        race(&scratch, ["--add-room d/ward.env.ron", "--add-room d/theatre.env.ron"]);
        let text = scratch.read(DESIGN);
        let has = |room: &str| text.contains(room);
        assert!(has("ward.env.ron") && has("theatre.env.ron"), "run {run}: {text}");
        let rooms = "d/ward.env.ron d/theatre.env.ron";
        scratch.succeed(format!("procedure {DESIGN} --remove-room {rooms}"));
    }
}

#[test]
fn comments_of_a_design_are_not_lost_by_a_decision() {
    let scratch = design();
    let written = format!("// by hand\n{}", scratch.read(DESIGN));
    scratch.write(DESIGN, &written);
    let former = format!("{DESIGN}.old");
    scratch.notes_with(format!("procedure {DESIGN} --decide tool --note good"), &[&former]);
    assert_eq!(scratch.read(&former), written);
    assert!(!scratch.read(DESIGN).contains("by hand"));
    // What has no comments is kept by being what the program writes.
    scratch.succeed(format!("procedure {DESIGN} --withdraw tool"));
    let names = fs::read_dir(scratch.path("d")).unwrap();
    let old = names.filter(|entry| {
        let name = entry.as_ref().unwrap().file_name();
        name.to_string_lossy().contains(".old")
    });
    assert_eq!(old.count(), 1);
}
