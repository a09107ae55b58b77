//! Commands end: for every bound, whatever they are given to read, with few threads, and by a signal.

use crate::support::data::own;
use crate::support::program::{
    Scratch, end_within, processor_seconds, run_within, text, trackwright,
};
use crate::support::wire::until;
use std::process::{Command, Output};
use std::time::Duration;

/// Far more than any of these takes, on a machine that does other things as well.
const LIMIT: Duration = Duration::from_secs(60);

#[track_caller]
fn refused(command: Command) -> String {
    let Output { status, stdout, stderr } = run_within(command, LIMIT);
    let stderr = String::from_utf8(stderr).unwrap();
    assert_eq!(status.code(), Some(2), "{stderr}");
    assert!(stdout.is_empty());
    stderr
}

#[test]
fn a_scene_ends_for_every_bound_of_triangles() {
    let scratch = Scratch::new();
    let file = scratch.arg("scene.glb");
    let scene = |triangles: &str| {
        let args = ["export", "scene", "endoscope", "-o", &file];
        let more = ["--layers", "none", "--triangles", triangles];
        trackwright(&[&args[..], &more].concat())
    };
    for triangles in ["1", "3", "20", "100"] {
        let output = run_within(scene(triangles), LIMIT);
        assert!(output.status.success(), "{output:?}");
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert!(stderr.contains("the tool's mesh is drawn with "), "{stderr}");
        let is_above = stderr.contains(&format!("not with at most {triangles}: fewer leave no"));
        assert!(is_above || triangles != "1", "{stderr}");
    }
    let error = refused(scene("0"));
    assert!(error.contains("0 is not in 1.."), "{error}");
}

#[cfg(unix)]
#[test]
fn pipes_that_nobody_writes_to_are_refused() {
    let scratch = Scratch::new();
    let pipe = scratch.arg("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let (out, table) = (scratch.arg("out"), text(&own("room-a/room-a-fit.csv")));
    let expected = format!("{pipe}: found a named pipe, expected ");
    for args in [
        &["fit", &pipe, "-o", &out, "--order", "1", "--directions", "6"][..],
        &["fit", &table, "-o", &out, "--holdout", &pipe, "--order", "0"],
        &["select", &pipe],
        &["simulate", &pipe, "--mode", "single"],
        &["distort", &pipe, &table, "-o", &out],
        &["pivot", &pipe],
        &["convert", &pipe, "out.body.ron"],
        &["register", &pipe, &pipe],
    ] {
        let error = refused(trackwright(args));
        assert!(error.contains(&expected), "{args:?}: {error}");
    }
    let error = refused(trackwright(&["select", "/dev/zero"]));
    assert!(error.contains("/dev/zero: found a device"), "{error}");
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
    let direct = scratch.arg("direct.env.ron");
    scratch.succeed(format!("fit {table} -o {direct} --order 1 --directions 6"));
    let [piped, direct] = [out, direct].map(|file| {
        let room = trackwright_project::Files::default().read_environment(file.as_ref()).unwrap();
        room.model
    });
    assert_eq!(piped, direct);
}

#[cfg(target_os = "linux")]
#[test]
fn threads_that_cannot_start_are_one_error() {
    let design = format!("{}/designs/endoscope.design.ron", env!("CARGO_MANIFEST_DIR"));
    // 5,000 stacks of 2 MiB are 10 GiB of addresses.
    let script =
        "ulimit -v 2000000; RAYON_NUM_THREADS=5000 exec \"$0\" simulate \"$1\" --mode single";
    let mut shell = Command::new("sh");
    shell.args(["-c", script, env!("CARGO_BIN_EXE_trackwright"), &design]);
    let error = refused(shell);
    assert_eq!(error.lines().count(), 1, "{error}");
    assert!(error.starts_with("error: the threads to compute with"), "{error}");
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
