//! A machine without a display: the main job is still done.

use crate::support::program::trackwright;

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
