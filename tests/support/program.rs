//! Runs the built program.

use super::wire::rest;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Output, Stdio};
use std::time::{Duration, Instant};

/// The program with arguments, ready to run.
pub fn trackwright(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_trackwright"));
    command.args(args);
    command
}

/// Runs and returns standard output; panics with standard error where it fails.
#[track_caller]
pub fn succeed(args: &[&str]) -> String {
    String::from_utf8(good(trackwright(args)).stdout).unwrap()
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
    bad(trackwright(args))
}

/// Whether a message is one line that has all words.
#[track_caller]
pub fn assert_one_line(message: &str, words: &[&str]) {
    assert_eq!(message.lines().count(), 1, "one line: {message}");
    for word in words {
        assert!(message.contains(word), "{word:?} is not in: {message}");
    }
}

/// Runs and waits so long at most; panics where it has not ended by then.
#[track_caller]
pub fn run_within(mut command: Command, limit: Duration) -> Output {
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    // What it prints is little: no pipe fills up.
    end_within(&mut child, limit);
    child.wait_with_output().unwrap()
}

/// Waits for a program's end so long at most; kills it and panics where it has not ended by then.
#[track_caller]
pub fn end_within(child: &mut Child, limit: Duration) -> ExitStatus {
    let started = Instant::now();
    loop {
        if let Some(status) = child.try_wait().unwrap() {
            return status;
        }
        if started.elapsed() > limit {
            child.kill().unwrap();
            child.wait().unwrap();
            panic!("{} had not ended after {limit:?}", child.id());
        }
        rest(Duration::from_millis(20));
    }
}

/// Sends a signal, such as `-INT`, to a program that still runs.
#[track_caller]
pub fn signal(child: &Child, signal: &str) {
    let sent = Command::new("kill").args([signal, &child.id().to_string()]).status();
    assert!(sent.unwrap().success(), "{signal}: the program had ended");
}

/// User and system time of a process and all its threads, in seconds.
pub fn processor_seconds(pid: u32) -> f64 {
    /// On Linux everywhere.
    const TICKS_A_SECOND: f64 = 100.0;
    let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap();
    // The name in parentheses may contain anything; fields are counted from behind it.
    let fields: Vec<&str> = stat[stat.rfind(')').unwrap() + 1..].split_whitespace().collect();
    let ticks = [11, 12].map(|k| fields[k].parse::<f64>().unwrap());
    (ticks[0] + ticks[1]) / TICKS_A_SECOND
}

/// The output of a program that ends well; panics with its standard error where it does not.
#[track_caller]
fn good(mut command: Command) -> Output {
    let output = command.output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?} ended with {}: {stderr}", output.status);
    output
}

/// What ends with exit status 2 and no result; the error it prints.
#[track_caller]
fn bad(mut command: Command) -> String {
    let Output { status, stdout, stderr } = command.output().unwrap();
    let stderr = String::from_utf8(stderr).unwrap();
    assert_eq!(status.code(), Some(2), "{command:?}: {stderr}");
    assert!(stdout.is_empty(), "{command:?} printed {}", String::from_utf8_lossy(&stdout));
    stderr
}

/// A folder of its own for one test, and the program run in it. A line of arguments is split at
/// spaces outside of 'single quotes'; `own:PATH` is a file of `tests/data`, `designs/PATH` one of
/// the built-in designs.
pub struct Scratch(tempfile::TempDir);

impl Scratch {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn command(&self, line: &str) -> Command {
        let mut command = trackwright(&[]);
        for (k, part) in line.split('\'').enumerate() {
            if k % 2 == 1 {
                command.arg(part);
                continue;
            }
            for word in part.split_whitespace() {
                match word.strip_prefix("own:") {
                    Some(path) => command.arg(super::data::own(path)),
                    None if word.starts_with("designs/") => {
                        command.arg(Path::new(env!("CARGO_MANIFEST_DIR")).join(word))
                    }
                    None => command.arg(word),
                };
            }
        }
        command.current_dir(self.0.path());
        command
    }

    /// Standard output of a line that ends well.
    #[track_caller]
    pub fn succeed(&self, line: impl AsRef<str>) -> String {
        String::from_utf8(good(self.command(line.as_ref())).stdout).unwrap()
    }

    /// Standard error of a line that ends well.
    #[track_caller]
    pub fn notes(&self, line: impl AsRef<str>) -> String {
        String::from_utf8(good(self.command(line.as_ref())).stderr).unwrap()
    }

    #[track_caller]
    pub fn json(&self, line: impl AsRef<str>) -> Value {
        let out = self.succeed(format!("{} --format json", line.as_ref()));
        serde_json::from_str(&out).unwrap_or_else(|e| panic!("{e}: {out}"))
    }

    /// The error of a line that ends with status 2.
    #[track_caller]
    pub fn fail(&self, line: impl AsRef<str>) -> String {
        bad(self.command(line.as_ref()))
    }

    /// The one line of an error that has all words.
    #[track_caller]
    pub fn fail_with(&self, line: impl AsRef<str>, words: &[&str]) {
        assert_one_line(&self.fail(line), words);
    }

    pub fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap()
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).unwrap();
    }

    pub fn has(&self, name: &str) -> bool {
        self.path(name).exists()
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// A path as an argument.
    pub fn arg(&self, name: &str) -> String {
        text(&self.path(name))
    }

    /// Copies a design's folder of `tests/data` to `d`, in a room fitted to the table of `room-a` with the given options.
    pub fn copy_design_with_room(&self, from: &str, fit: &str) {
        self.copy_own(from, "d");
        self.succeed(format!("fit own:room-a/room-a-fit.csv -o d/room.env.ron {fit}"));
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
