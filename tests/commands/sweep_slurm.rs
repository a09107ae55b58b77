//! A sweep on a Slurm cluster of this one machine: a job array, a task that is killed, what is missing again.

use crate::support::golden::list;
use crate::support::program::{Scratch, json_of};
use crate::support::wire::rest;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;
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
