//! `simulate --explain`: what was computed, reused and left out, beside an unchanged result.

use crate::support::program::Scratch;

/// Standard output and the lines of standard error.
fn simulate(design: &str, more: &str) -> (String, Vec<String>) {
    let line = format!("simulate designs/{design}.design.ron --mode motion {more}");
    let (out, notes) = Scratch::new().both(line);
    (out, notes.lines().map(str::to_owned).collect())
}

#[test]
fn counts_go_to_stderr_and_change_nothing() {
    for format in ["text", "json"] {
        let (plain, silent) = simulate("endoscope", &format!("--format {format}"));
        let (explained, lines) = simulate("endoscope", &format!("--format {format} --explain"));
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
    for (design, reused, left_out) in [("pointer-on-head", 1, 0), ("endoscope", 0, 1)] {
        let (_, lines) = simulate(design, "--explain");
        let count = |start: &str| lines.iter().filter(|line| line.starts_with(start)).count();
        let whole = count("reused    the CRF, tracked once for 3,375 trials");
        assert_eq!((whole, count("left out  the CRF")), (reused, left_out), "{lines:?}");
        let is_of_crf = lines.iter().any(|line| line.ends_with("for the CRF"));
        assert!(!is_of_crf || left_out == 0, "{lines:?}");
    }
}
