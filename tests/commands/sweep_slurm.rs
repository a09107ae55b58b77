//! A sweep on a Slurm cluster of this one machine: a job array, a task that is killed, what is missing again.
//! And names that a shell would obey, with an `sbatch` that runs the scripts at once.

use crate::support::golden::list;
use crate::support::program::{Scratch, assert_has, json_of};
use crate::support::wire::rest;
use serde_json::Value;
use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::{Duration, Instant};

const PLAN: &str = r#"(
    version: 1,
    designs: ["pointer-on-head"],
    vary: [Sobol(count: 24000, ranges: [
        (path: "tool.body.sensors[0].position.z", from: 40, to: 90),
        (path: "tool.body.sensors[1].position.z", from: 90, to: 130),
    ])],
    motions: [Single],
    figures: ["position_rms"],
    expected: false,
    shard_seconds: 0.3,
)"#;

/// A cluster, as long as it lives.
struct Cluster {
    folder: tempfile::TempDir,
}

impl Cluster {
    fn start() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let started = Self::script().arg("start").arg(folder.path()).output().unwrap();
        let message = String::from_utf8_lossy(&started.stderr);
        assert!(
            started.status.success(),
            "tests/run long installs Slurm; as root it starts: {message}"
        );
        Self { folder }
    }

    fn script() -> Command {
        Command::new(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/peers/slurm.sh"))
    }

    fn config(&self) -> PathBuf {
        self.folder.path().join("slurm.conf")
    }

    /// What one of Slurm's commands prints.
    fn tool(&self, name: &str, arguments: &[&str]) -> String {
        let mut command = Command::new(name);
        let output = command.args(arguments).env("SLURM_CONF", self.config()).output().unwrap();
        assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    }

    /// The program's JSON.
    fn json(&self, scratch: &Scratch, line: &str) -> Value {
        let mut command = scratch.command(&format!("{line} --format json"));
        json_of(command.env("SLURM_CONF", self.config()))
    }

    fn wait(&self, what: &str, mut is_so: impl FnMut(&str) -> bool) {
        let started = Instant::now();
        loop {
            let queue = self.tool("squeue", &["--noheader", "--array", "--format=%F %K %T"]);
            if is_so(&queue) {
                return;
            }
            assert!(started.elapsed() < Duration::from_secs(300), "{what}: {queue}");
            rest(Duration::from_millis(100));
        }
    }
}

impl Drop for Cluster {
    fn drop(&mut self) {
        let stopped = Self::script().arg("stop").arg(self.folder.path()).status();
        assert!(stopped.is_ok_and(|status| status.success()) || std::thread::panicking());
    }
}

#[test]
#[ignore = "long: a cluster is started"]
fn long_slurm_computes_what_one_machine_does() {
    let (cluster, scratch) = (Cluster::start(), Scratch::new());
    scratch.write("plan.sweep.ron", PLAN);
    scratch.succeed("sweep plan.sweep.ron -o here");
    scratch.succeed("sweep merge here -o here.parquet");
    let submit =
        "sweep plan.sweep.ron -o there --submit slurm --tasks 6 --partition main --time 0:30:00";
    let first = cluster.json(&scratch, submit);
    assert_eq!(list(&first, "parts").len(), 6);
    let job = first["job"].as_str().unwrap();
    // What is in the queue is not submitted again.
    assert_eq!(cluster.json(&scratch, submit)["job"], Value::Null);
    let running = format!("{job} 3 RUNNING");
    cluster.wait("part 3 runs", |queue| queue.contains(&running));
    cluster.tool("scancel", &["--signal=KILL", "--full", &format!("{job}_3")]);
    // The merge has nothing to wait for any more, and leaves the queue as well.
    cluster.wait("all have ended", str::is_empty);
    let status = cluster.json(&scratch, "sweep status there");
    assert!(!list(&status, "missing").is_empty() && !scratch.has("there/rows.parquet"), "{status}");
    let again = cluster.json(&scratch, submit);
    assert_eq!(again["parts"], serde_json::json!([3]));
    cluster.wait("part 3 and the merge have ended", str::is_empty);
    let [here, there] = ["here.parquet", "there/rows.parquet"]
        .map(|name| std::fs::read(scratch.path(name)).unwrap());
    assert!(here == there, "{} and {} bytes", here.len(), there.len());
    assert_eq!(cluster.json(&scratch, submit)["job"], Value::Null);
}

const FEW: &str = r#"(
    version: 1,
    designs: ["pointer-on-head"],
    vary: [Grid([(path: "tool.body.sensors[0].position.z", values: List([60, 72]))])],
    motions: [Single],
    figures: ["position_rms"],
    expected: false,
)"#;

/// What a shell, `sbatch` or a file of lines could obey. What is obeyed makes the file `owned`.
const HOSTILE: [&[u8]; 40] = [
    b"$(touch owned)",
    b"`touch owned`",
    b"${IFS+$(touch owned)}",
    b"'; touch owned; '",
    b"'$(touch owned)'",
    b"\"; touch owned; \"",
    b"\\'; touch owned #",
    b"'\\''; touch owned; '\\''",
    b"; touch owned",
    b"& touch owned",
    b"&& touch owned",
    b"|| touch owned",
    b"| touch owned",
    b"> owned",
    b">owned",
    b"< owned",
    b"x\ntouch owned",
    b"x\n#SBATCH --wrap=touch owned",
    b"x'\ntouch owned\n'",
    b"x\r\ntouch owned",
    b"x\rtouch owned",
    b"\ntouch owned\n",
    b"x\x0btouch owned",
    b"x\x0ctouch owned",
    b"x\ttouch owned",
    b"x\x1b]0;touch owned\x07",
    b"x\x7ftouch owned",
    b"x\xc2\x85touch owned",
    b"x\xe2\x80\xa8touch owned",
    b"x\xff touch owned",
    b"--wrap=touch owned",
    b"-x",
    b"--",
    b"-o owned",
    b"%j%A owned",
    b"100%",
    b"\\",
    b"* ? [a] {b,c} ~ ! #",
    b"it's here, \xc3\xbcber alles",
    b"eval touch owned",
];

/// The program with an `sbatch` that runs what it gets as a shell does.
fn submit(scratch: &Scratch, out: &[u8], more: &[&[u8]]) -> Output {
    let path = format!("{}:{}", scratch.arg("bin"), std::env::var("PATH").unwrap());
    let output = OsStr::from_bytes(&[b"--output=", out].concat()).to_owned();
    let mut command = scratch.command("sweep plan.sweep.ron --submit slurm --tasks 1");
    command.arg(output).args(more.iter().map(|part| OsStr::from_bytes(part))).env("PATH", path);
    command.output().unwrap()
}

fn with_sbatch() -> Scratch {
    let scratch = Scratch::new();
    scratch.write("plan.sweep.ron", FEW);
    std::fs::create_dir(scratch.path("bin")).unwrap();
    let sbatch = "#!/bin/sh\nfor script; do :; done\n\
        SLURM_ARRAY_TASK_ID=1 sh \"$script\" >> log 2>&1 < /dev/null\necho 7\n";
    scratch.write("bin/sbatch", sbatch);
    let executable = std::fs::Permissions::from_mode(0o755);
    std::fs::set_permissions(scratch.path("bin/sbatch"), executable).unwrap();
    scratch
}

/// Whether a file of this name is anywhere in a folder.
fn has_anywhere(folder: &Path, name: &str) -> bool {
    std::fs::read_dir(folder).unwrap().any(|entry| {
        let path = entry.unwrap().path();
        path.file_name() == Some(OsStr::new(name)) || (path.is_dir() && has_anywhere(&path, name))
    })
}

#[track_caller]
fn assert_refused(output: &Output) {
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert_has(&message, &["expected text without control characters"], "the error");
}

#[test]
fn no_name_becomes_a_command_of_a_cluster() {
    for name in HOSTILE {
        let shown = String::from_utf8_lossy(name);
        let is_plain = std::str::from_utf8(name).is_ok_and(|n| !n.contains(char::is_control));
        let scratch = with_sbatch();
        let folder = scratch.path(".").join(OsStr::from_bytes(name));
        let options = ["partition", "account", "time", "memory"]
            .map(|option| [b"--", option.as_bytes(), b"=", name].concat());
        if is_plain {
            let output = submit(&scratch, name, &options.each_ref().map(Vec::as_slice));
            let message = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success(), "{shown}: {message}");
            assert!(folder.join("rows.parquet").exists(), "{shown}: {}", scratch.read("log"));
            let scripts = ["array.sh", "merge.sh"].map(|s| folder.join("slurm").join(s));
            let lines = scripts.map(|s| std::fs::read_to_string(s).unwrap().lines().count());
            assert_eq!(lines, [4, 3], "{shown}");
        } else {
            assert_refused(&submit(&scratch, name, &[]));
            assert!(!folder.join("slurm/array.sh").exists());
            for option in &options {
                let output = submit(&scratch, b"out", &[option]);
                match std::str::from_utf8(name) {
                    Ok(_) => assert_refused(&output),
                    // Refused with the arguments, before anything is done.
                    Err(_) => assert_eq!(output.status.code(), Some(2), "{shown}"),
                }
            }
        }
        assert!(!has_anywhere(&scratch.path("."), "owned"), "{shown}");
    }
}

#[test]
fn a_script_of_somebody_else_is_kept() {
    for (script, own) in [("array.sh", "merge.sh"), ("merge.sh", "array.sh")] {
        let scratch = with_sbatch();
        std::fs::create_dir_all(scratch.path("out/slurm")).unwrap();
        scratch.write(&format!("out/slurm/{script}"), "#!/bin/sh\nexec mine\n");
        let output = submit(&scratch, b"out", &[]);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert_has(&message, &[script, "rename or remove it"], "the error");
        assert_eq!(scratch.read(&format!("out/slurm/{script}")), "#!/bin/sh\nexec mine\n");
        assert!(!scratch.has("log"), "nothing was submitted, whatever became of {own}");
        std::fs::remove_file(scratch.path(&format!("out/slurm/{script}"))).unwrap();
        assert!(submit(&scratch, b"out", &[]).status.success());
        // Its own script is replaced, with other tasks too.
        std::fs::remove_file(scratch.path("out/rows-000000000000-000000000002.parquet")).unwrap();
        assert!(submit(&scratch, b"out", &[b"--cores=2"]).status.success());
        assert_has(&scratch.read("out/slurm/array.sh"), &["THREADS=2"], "the script");
    }
}
