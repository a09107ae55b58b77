//! Runs the built program.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

/// The program with arguments, ready to run.
pub fn trackwright(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_trackwright"));
    command.args(args);
    command
}

/// Runs and gives standard output; panics with standard error where it fails.
#[track_caller]
pub fn succeed(args: &[&str]) -> String {
    let output = trackwright(args).output().unwrap();
    assert!(
        output.status.success(),
        "{args:?} ended with {}: {}",
        output.status,
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8(output.stdout).unwrap()
}

/// Runs with `--format json` and gives what was printed.
#[track_caller]
pub fn json(args: &[&str]) -> Value {
    let text = succeed(&[args, &["--format", "json"]].concat());
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("{e}: {text}"))
}

/// Runs what has to fail with exit status 2, and gives the one error it prints.
#[track_caller]
pub fn fail(args: &[&str]) -> String {
    let Output { status, stdout, stderr } = trackwright(args).output().unwrap();
    let stderr = String::from_utf8(stderr).unwrap();
    assert_eq!(status.code(), Some(2), "{args:?}: {stderr}");
    assert!(stdout.is_empty(), "{args:?} printed a result: {}", String::from_utf8_lossy(&stdout));
    stderr
}

/// Runs and waits so long at most; panics where it has not ended by then.
#[track_caller]
pub fn run_within(mut command: Command, limit: Duration) -> Output {
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let started = Instant::now();
    // What it prints is little: no pipe fills up.
    while child.try_wait().unwrap().is_none() {
        if started.elapsed() > limit {
            child.kill().unwrap();
            child.wait().unwrap();
            panic!("{command:?} had not ended after {limit:?}");
        }
        pause(Duration::from_millis(20));
    }
    child.wait_with_output().unwrap()
}

/// Waits without anything to wait for: a command is to be interrupted in the middle of its work.
pub fn pause(duration: std::time::Duration) {
    let (_sender, never) = std::sync::mpsc::channel::<()>();
    let _ = never.recv_timeout(duration);
}

/// A folder of its own for one test.
pub struct Scratch(tempfile::TempDir);

impl Scratch {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// A path as an argument.
    pub fn arg(&self, name: &str) -> String {
        text(&self.path(name))
    }

    /// Copies a design's folder of `tests/data` to `d`, in a room fitted to the table of `room-a` as asked.
    pub fn copy_design_with_room(&self, from: &str, fit: &[&str]) {
        self.copy_own(from, "d");
        let table = text(&super::data::own("room-a/room-a-fit.csv"));
        let room = self.arg("d/room.env.ron");
        succeed(&[&["fit", &table, "-o", &room], fit].concat());
    }

    /// Copies a file or a flat folder of `tests/data` here.
    pub fn copy_own(&self, from: &str, to: &str) {
        let from = super::data::own(from);
        if from.is_dir() {
            std::fs::create_dir_all(self.path(to)).unwrap();
            for entry in std::fs::read_dir(&from).unwrap() {
                let entry = entry.unwrap();
                std::fs::copy(entry.path(), self.path(to).join(entry.file_name())).unwrap();
            }
        } else {
            std::fs::copy(&from, self.path(to)).unwrap();
        }
    }
}

pub fn text(path: &Path) -> String {
    path.to_str().unwrap().to_owned()
}
