//! `simulate --explain`: what was computed, reused and left out, beside an unchanged result.

use crate::support::program::trackwright;
use std::path::Path;

/// Standard output and the lines of standard error.
fn simulate(design: &str, more: &[&str]) -> (String, Vec<String>) {
    let args = [&["simulate", design, "--mode", "motion"], more].concat();
    let output = trackwright(&args).output().unwrap();
    let err = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{err}");
    let out = String::from_utf8(output.stdout).unwrap();
    (out, err.lines().map(str::to_owned).collect())
}

fn built_in(name: &str) -> String {
    let designs = Path::new(env!("CARGO_MANIFEST_DIR")).join("designs");
    designs.join(name).to_str().unwrap().to_owned()
}

#[test]
fn counts_go_to_stderr_and_change_nothing() {
    for format in ["text", "json"] {
        let design = built_in("endoscope.design.ron");
        let (plain, silent) = simulate(&design, &["--format", format]);
        let (explained, lines) = simulate(&design, &["--format", format, "--explain"]);
        assert_eq!(plain, explained);
        assert!(silent.is_empty(), "{silent:?}");
        assert!(lines.iter().all(|line| {
            ["computed  ", "reused    ", "left out  "].iter().any(|deed| line.starts_with(deed))
        }));
        assert!(lines.iter().any(|l| l.ends_with("for the tool")), "{lines:?}");
    }
}

#[test]
fn reuse_of_the_crf_is_reported() {
    let (_, with_crf) = simulate(&built_in("pointer-on-head.design.ron"), &["--explain"]);
    let (_, without) = simulate(&built_in("endoscope.design.ron"), &["--explain"]);
    let reused = |lines: &[String]| {
        lines
            .iter()
            .filter(|l| l.as_str() == "reused    the CRF, tracked once for 3,375 trials")
            .count()
    };
    let left_out =
        |lines: &[String]| lines.iter().filter(|l| l.starts_with("left out  the CRF")).count();
    assert_eq!((reused(&with_crf), left_out(&with_crf)), (1, 0), "{with_crf:?}");
    assert_eq!((reused(&without), left_out(&without)), (0, 1), "{without:?}");
    assert!(without.iter().all(|l| !l.ends_with("for the CRF")), "{without:?}");
}
