//! Commands end: for every bound, whatever they are given to read, with few threads, and by a signal.

use crate::support::data::own;
use crate::support::program::{
    Scratch, assert_has, end_within, processor_seconds, run_within, text, trackwright,
};
use crate::support::wire::until;
use std::process::{Command, Output};
use std::time::Duration;

/// Far more than any of these takes, on a machine that does other things as well.
const LIMIT: Duration = Duration::from_secs(60);

#[track_caller]
fn refused(command: Command, words: &[&str]) -> String {
    let what = format!("{command:?}");
    let Output { status, stdout, stderr } = run_within(command, LIMIT);
    let stderr = String::from_utf8(stderr).unwrap();
    assert_eq!(status.code(), Some(2), "{stderr}");
    assert!(stdout.is_empty());
    assert_has(&stderr, words, &what);
    stderr
}

#[test]
fn a_scene_ends_for_every_bound_of_triangles() {
    let scratch = Scratch::new();
    let scene = |triangles: &str| {
        let line = "export scene endoscope -o scene.glb --layers none --triangles";
        scratch.command(&format!("{line} {triangles}"))
    };
    for triangles in ["1", "3", "20", "100"] {
        let output = run_within(scene(triangles), LIMIT);
        assert!(output.status.success(), "{output:?}");
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert!(stderr.contains("the tool's mesh is drawn with "), "{stderr}");
        let is_above = stderr.contains(&format!("not with at most {triangles}: fewer leave no"));
        assert!(is_above || triangles != "1", "{stderr}");
    }
    refused(scene("0"), &["0 is not in 1.."]);
}

#[cfg(unix)]
#[test]
fn pipes_that_nobody_writes_to_are_refused() {
    let scratch = Scratch::new();
    assert!(Command::new("mkfifo").arg(scratch.path("pipe")).status().unwrap().success());
    for line in [
        "fit pipe -o out --order 1 --directions 6",
        "fit own:room-a/room-a-fit.csv -o out --holdout pipe --order 0",
        "select pipe",
        "simulate pipe --mode single",
        "distort pipe own:room-a/room-a-fit.csv -o out",
        "pivot pipe",
        "convert pipe out.body.ron",
        "register pipe pipe",
    ] {
        refused(scratch.command(line), &["pipe: found a named pipe, expected "]);
    }
    refused(scratch.command("select /dev/zero"), &["/dev/zero: found a device"]);
}

#[cfg(unix)]
#[test]
fn what_a_shell_pipes_in_is_read() {
    let scratch = Scratch::new();
    let table = text(&own("room-a/room-a-fit.csv"));
    let out = scratch.arg("room.env.ron");
    let script = "cat \"$1\" | \"$0\" fit /dev/stdin -o \"$2\" --order 1 --directions 6";
    let mut shell = Command::new("sh");
    shell.args(["-c", script, env!("CARGO_BIN_EXE_trackwright")]).args([&table, &out]);
    let output = run_within(shell, LIMIT);
    assert!(output.status.success(), "{output:?}");
    scratch.fit("direct.env.ron", "--order 1 --directions 6");
    let [piped, direct] = ["room.env.ron", "direct.env.ron"].map(|file| scratch.environment(file));
    assert_eq!(piped.model, direct.model);
}

#[cfg(target_os = "linux")]
#[test]
fn threads_that_cannot_start_are_one_error() {
    let design = format!("{}/designs/endoscope.design.ron", env!("CARGO_MANIFEST_DIR"));
    // 500 stacks of 64 MiB are 31 GiB of addresses. What is left when one does not fit is enough for the
    // signal stacks of the threads that did start, however late they get to run.
    let script = "ulimit -v 2000000; export RUST_MIN_STACK=67108864 RAYON_NUM_THREADS=500; \
                  exec \"$0\" simulate \"$1\" --mode single";
    let mut shell = Command::new("sh");
    shell.args(["-c", script, env!("CARGO_BIN_EXE_trackwright"), &design]);
    let error = refused(shell, &[]);
    assert_eq!(error.lines().count(), 1, "{error}");
    assert!(error.starts_with("error: the threads to compute with"), "{error}");
}

#[cfg(target_os = "linux")]
#[test]
fn limits_no_command_can_work_in_are_one_error() {
    for (limit, words) in [
        ("ulimit -v 131072", ["limited to 128 MiB", "expected 256 MiB at least"]),
        ("export RAYON_NUM_THREADS=100000", ["RAYON_NUM_THREADS is 100000", "4096 at most"]),
    ] {
        let mut shell = Command::new("sh");
        let script = format!("{limit}; exec \"$0\" simulate pointer-on-head --mode single");
        shell.args(["-c", &script, env!("CARGO_BIN_EXE_trackwright")]);
        let error = refused(shell, &words);
        assert_eq!(error.lines().count(), 1, "{error}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_signal_ends_a_long_command() {
    use std::os::unix::process::ExitStatusExt;
    for (signal, number) in [("-INT", 2), ("-TERM", 15)] {
        // What is begun in the background ignores some signals, and hands that on.
        let program = trackwright(&["stability"]);
        let mut child = Command::new("env")
            .arg("--default-signal")
            .arg(program.get_program())
            .args(program.get_args())
            .spawn()
            .unwrap();
        // It computes for minutes.
        until("work", || processor_seconds(child.id()) > 1.0);
        crate::support::program::signal(&child, signal);
        assert_eq!(end_within(&mut child, LIMIT).signal(), Some(number));
    }
}
