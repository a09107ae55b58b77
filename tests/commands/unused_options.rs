//! Options that another option's choice would leave unused are refused, with what they belong to.

use crate::support::data::own;
use crate::support::program::{Scratch, fail, json, text};

#[test]
fn a_table_of_poses_is_the_mode() {
    let scratch = Scratch::new();
    scratch.copy_design_with_room("golden/pointer-on-head", &["--order", "1", "--directions", "6"]);
    let design = scratch.arg("d/pointer-on-head.design.ron");
    let input = scratch.arg("d/input.csv");
    let told = json(&["simulate", &design, "--mode", "input", "--input", &input]);
    assert_eq!(json(&["simulate", &design, "--input", &input]), told);
    let out = scratch.arg("tips.csv");
    for args in [
        &["simulate", &design, "--mode", "motion", "--input", &input][..],
        &["simulate", &design, "--mode", "single", "--input", &input],
        &["export", "tips", &design, "-o", &out, "--mode", "motion", "--input", &input],
        &["report", &design, "-o", &out, "--mode", "single", "--input", &input],
    ] {
        let said = fail(args);
        assert!(said.contains("input.csv: found another --mode, expected --mode input"), "{said}");
    }
    assert!(fail(&["simulate", &design]).contains("--mode"));
}

#[test]
fn options_that_nothing_would_look_at_are_refused() {
    let scratch = Scratch::new();
    let table = text(&own("room-a/room-a-fit.csv"));
    let design = format!("{}/designs/endoscope.design.ron", env!("CARGO_MANIFEST_DIR"));
    let out = scratch.arg("out.csv");
    let jitter = ["--jitter-position-mm", "0.1", "--jitter-angle-deg", "0.1"];
    let single = ["simulate", &design, "--mode", "single"];
    let fit = ["fit", &table, "-o", &out];
    for (args, word) in [
        (
            [&single[..], &jitter, &["--uncertainty", "first-order", "--seed", "1"]].concat(),
            "--seed needs --uncertainty monte-carlo",
        ),
        ([&fit[..], &["--loss", "squares"]].concat(), "--loss belongs to"),
        (
            [&fit[..], &["--model", "kriging", "--method", "joint"]].concat(),
            "--method does not go with --model kriging",
        ),
        (
            [&fit[..], &["--model", "kriging", "--rcond", "1e-8"]].concat(),
            "--rcond does not go with --model kriging",
        ),
        (vec!["select", &table, "--loss", "squares"], "--loss belongs to"),
        (
            vec!["select", &table, "--models", "kriging", "--orders", "2"],
            "--orders belongs to Bernstein",
        ),
        ([&["select", &table][..], &jitter].concat(), "expected --output"),
        (vec!["select", &table, "--volume", "aurora-cube"], "--output"),
        (vec!["tolerances", &design, "--seed", "1"], "--check"),
        (vec!["pivot", &table, "--max-shaft-deg", "1"], "--spin"),
        (vec!["pivot", "--spin", &table, "--max-rms-mm", "1"], "RECORDINGS"),
        (
            vec!["export", "tips", &design, "-o", &out, "--axes", "lps"],
            "is in the tracker's own axes",
        ),
        (
            vec!["export", "poses", &table, "--columns", "ideal", "-o", &out, "--axes", "lps"],
            "is in the tracker's own axes",
        ),
    ] {
        let said = fail(&args);
        assert!(said.contains(word), "{args:?}: {said}");
    }
    assert!(!scratch.path("out.csv").exists());
}
