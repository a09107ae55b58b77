//! Runs the built program.

use super::table::Table;
use super::wire::rest;
use nalgebra::Point3;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Output, Stdio};
use std::sync::{Arc, Mutex, OnceLock};
use std::time::{Duration, Instant};
use trackwright_field::Environment;
use trackwright_geometry::pose::Pose;
use trackwright_project::{Files, STATE_VARIABLE};

/// The program with arguments, ready to run.
pub fn trackwright(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_trackwright"));
    // What it remembers is not for the person who runs the tests.
    command.args(args).env(STATE_VARIABLE, concat!(env!("CARGO_TARGET_TMPDIR"), "/state"));
    command
}

/// Runs and returns standard output; panics with standard error where it fails.
#[track_caller]
pub fn succeed(args: &[&str]) -> String {
    String::from_utf8(good(&mut trackwright(args)).stdout).unwrap()
}

/// Runs with `--format json` and gives what was printed.
#[track_caller]
pub fn json(args: &[&str]) -> Value {
    json_of(&mut trackwright(&[args, &["--format", "json"]].concat()))
}

/// What a program that ends well prints as JSON.
#[track_caller]
pub fn json_of(command: &mut Command) -> Value {
    let Output { stdout, stderr, .. } = good(command);
    let texts = || [stdout.as_slice(), &stderr].map(String::from_utf8_lossy);
    serde_json::from_slice(&stdout).unwrap_or_else(|e| panic!("{e}: {:?}", texts()))
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
    assert_has(message, words, "the error");
}

/// Whether a text has all words; `of` is what they are missing in.
#[track_caller]
pub fn assert_has(text: &str, words: &[&str], of: &str) {
    for word in words {
        assert!(text.contains(word), "{word:?} is not in {of}: {text}");
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
fn good(command: &mut Command) -> Output {
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
        self.both(line).0
    }

    /// Standard error of a line that ends well.
    #[track_caller]
    pub fn notes(&self, line: impl AsRef<str>) -> String {
        self.both(line).1
    }

    #[track_caller]
    pub fn json(&self, line: impl AsRef<str>) -> Value {
        self.json_and_notes(line).0
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

    /// An error that has all words, however many lines it is explained in.
    #[track_caller]
    pub fn refused(&self, line: impl AsRef<str>, words: &[&str]) {
        assert_has(&self.fail(&line), words, line.as_ref());
    }

    /// Standard output of a line that ends well, with all words in it.
    #[track_caller]
    pub fn succeed_with(&self, line: impl AsRef<str>, words: &[&str]) -> String {
        let out = self.succeed(&line);
        assert_has(&out, words, line.as_ref());
        out
    }

    /// Standard error of a line that ends well, with all words in it.
    #[track_caller]
    pub fn notes_with(&self, line: impl AsRef<str>, words: &[&str]) -> String {
        let notes = self.notes(&line);
        assert_has(&notes, words, line.as_ref());
        notes
    }

    /// Standard output and standard error of a line that ends well.
    #[track_caller]
    pub fn both(&self, line: impl AsRef<str>) -> (String, String) {
        let Output { stdout, stderr, .. } = good(&mut self.command(line.as_ref()));
        (String::from_utf8(stdout).unwrap(), String::from_utf8(stderr).unwrap())
    }

    /// Standard output as JSON, and standard error.
    #[track_caller]
    pub fn json_and_notes(&self, line: impl AsRef<str>) -> (Value, String) {
        let (out, notes) = self.both(format!("{} --format json", line.as_ref()));
        (serde_json::from_str(&out).unwrap_or_else(|e| panic!("{e}: {out}")), notes)
    }

    /// Fits a room to the table of `room-a`. What several tests fit is computed once: a room's file depends on
    /// its name and the options only.
    #[track_caller]
    pub fn fit(&self, to: &str, options: &str) {
        type Fitted = BTreeMap<[String; 2], Arc<OnceLock<Vec<u8>>>>;
        static FITTED: Mutex<Fitted> = Mutex::new(Fitted::new());
        let name = text(Path::new(Path::new(to).file_name().unwrap()));
        let fitted = FITTED.lock().unwrap().entry([name, options.to_owned()]).or_default().clone();
        let file = fitted.get_or_init(|| {
            self.succeed(format!("fit own:room-a/room-a-fit.csv -o {to} {options} --overwrite"));
            std::fs::read(self.path(to)).unwrap()
        });
        self.write(to, file);
    }

    /// A table that was written here.
    pub fn table(&self, name: &str) -> Table {
        Table::read(&self.path(name))
    }

    /// The poses of a file here.
    pub fn poses(&self, name: &str) -> Vec<Pose> {
        Files::default().read_poses(&self.path(name)).unwrap().as_it_stands()
    }

    /// The points of a file here.
    pub fn points(&self, name: &str) -> Vec<Point3<f64>> {
        Files::default().read_points(&self.path(name)).unwrap().as_it_stands()
    }

    pub fn environment(&self, name: &str) -> Environment {
        Files::default().read_environment(&self.path(name)).unwrap()
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
        self.fit("d/room.env.ron", fit);
    }

    /// Copies a built-in design with `from` replaced by `to`; its files stay where they are.
    pub fn copy_built_in(&self, design: &str, copy: &str, from: &str, to: &str) {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let file = root.join("designs").join(format!("{design}.design.ron"));
        let text = std::fs::read_to_string(file).unwrap();
        assert!(text.contains(from), "{from:?} is not in {text}");
        let text = text.replacen(from, to, 1);
        self.write(copy, text.replace("../assets", root.join("assets").to_str().unwrap()));
    }

    /// Copies a built-in design to `a.design.ron`, in the room `room.env.ron` beside it.
    pub fn copy_to_own_room(&self, design: &str) {
        let room = "../assets/environments/operating-table.env.ron";
        self.copy_built_in(design, "a.design.ron", room, "room.env.ron");
    }

    /// Writes `NAME.design.ron`, a body at a place of the tracker in `room.env.ron`, with more fields; the
    /// file's name.
    pub fn write_design(&self, name: &str, body: &str, at: [f64; 3], more: &str) -> String {
        let [x, y, z] = at;
        let pose = format!("(position: ({x:?}, {y:?}, {z:?}), rotation: (1.0, 0.0, 0.0, 0.0))");
        let tool = format!("(body: {body:?}, pose: {pose})");
        let file = format!("{name}.design.ron");
        let room = "environment: \"room.env.ron\"";
        self.write(&file, format!("(version: 1, name: {name:?}, {room}, tool: {tool}, {more})"));
        file
    }

    /// Changes the text of a file, which has `from` in it.
    #[track_caller]
    pub fn replace(&self, name: &str, from: &str, to: &str) {
        let text = self.read(name);
        assert!(text.contains(from), "{from:?} is not in {text}");
        self.write(name, text.replacen(from, to, 1));
    }

    /// Copies a file within the folder.
    pub fn copy(&self, from: &str, to: &str) {
        std::fs::copy(self.path(from), self.path(to)).unwrap();
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
