//! Where there can be no window: one line states why, and the main job is done.

use super::screen::Screen;
use crate::support::program::{Scratch, succeed, text, trackwright};
use std::path::Path;
use std::process::Command;

/// Starts the editor where there can be none; the line that it prints.
#[track_caller]
fn does_the_main_job(prepare: impl FnOnce(&mut Command)) -> String {
    let design = Path::new(env!("CARGO_MANIFEST_DIR")).join("designs/pointer-on-head.design.ron");
    let mut command = trackwright(&[&text(&design)]);
    command.env_remove("WAYLAND_DISPLAY");
    prepare(&mut command);
    let output = command.output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{stderr}");
    assert_eq!(stderr.lines().count(), 1, "{stderr}");
    let figures = succeed(&["simulate", &text(&design), "--mode", "motion"]);
    assert_eq!(String::from_utf8(output.stdout).unwrap(), figures);
    stderr.trim_end().to_owned()
}

#[test]
fn without_a_display_the_design_is_simulated() {
    let line = does_the_main_job(|command| {
        command.env_remove("DISPLAY");
    });
    assert!(line.starts_with("no editor: no display: DISPLAY is not set"), "{line}");
}

#[test]
fn a_silent_display_simulates_the_design() {
    // Displays are numbered from 0; nobody starts this many.
    let line = does_the_main_job(|command| {
        command.env("DISPLAY", ":9999");
    });
    assert!(line.starts_with("no editor: no display: :9999 does not answer"), "{line}");
}

/// Makes the Vulkan loader find no driver.
fn without_adapter(command: &mut Command) {
    for name in ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"] {
        command.env(name, "/nonexistent.json");
    }
}

#[test]
fn without_an_adapter_the_design_is_simulated() {
    let screen = Screen::start();
    let line = does_the_main_job(|command| {
        command.env("DISPLAY", &screen.name);
        without_adapter(command);
    });
    assert!(line.starts_with("no editor: no graphics adapter"), "{line}");
}

#[test]
fn without_an_adapter_there_is_no_picture() {
    let scratch = Scratch::new();
    let design = Path::new(env!("CARGO_MANIFEST_DIR")).join("designs/pointer-on-head.design.ron");
    let mut command = trackwright(&["render", &text(&design), "-o", &scratch.arg("a.png")]);
    without_adapter(&mut command);
    let output = command.output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{stderr}");
    assert_eq!(stderr.lines().count(), 1, "{stderr}");
    assert!(stderr.contains("no graphics adapter"), "{stderr}");
    assert!(!scratch.path("a.png").exists());
}
