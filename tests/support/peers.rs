//! Programs that others wrote, to check ours against: packages for Python and Node.js that `tests/run`
//! installs.

#![allow(dead_code, reason = "the files and messages that need it come one after the other")]

use super::program::json_of;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Where `tests/run` puts the programs of others.
fn folder() -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    std::env::var_os("TRACKWRIGHT_PEERS").map_or_else(|| root.join("target/peers"), PathBuf::from)
}

/// A program of the folder, which has to be there.
#[track_caller]
fn program(path: &str) -> Command {
    let program = folder().join(path);
    assert!(program.exists(), "{} is not there: tests/run installs it", program.display());
    Command::new(program)
}

/// The Python that has the packages of `tests/peers/requirements.txt`, ready to run one of the
/// scripts beside it.
#[track_caller]
pub fn python(script: &str) -> Command {
    let mut command = program("bin/python");
    let scripts = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/peers");
    command.arg("-B").arg(scripts.join(script));
    command
}

/// The rows of a sweep, with types and units of their columns, as a program reads them: `pandas`, `polars` or
/// `duckdb`.
#[track_caller]
pub fn read_sweep(path: &Path, with: &str) -> Value {
    json_of(python("read_sweep.py").arg(path).arg(with))
}

/// The rows of a sweep.
#[track_caller]
pub fn sweep_rows(path: &Path) -> Vec<Value> {
    read_sweep(path, "pandas")["rows"].as_array().unwrap().clone()
}

/// Node.js with the packages of `tests/peers/package.json`, ready to run one of the scripts beside it.
#[track_caller]
pub fn node(script: &str) -> Command {
    let packages = folder().join("node_modules");
    assert!(packages.exists(), "{} is not there: tests/run installs it", packages.display());
    let scripts = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/peers");
    let mut command = Command::new("node");
    command.env("NODE_PATH", packages).arg(scripts.join(script));
    command
}

/// One of the example programs of the OpenIGTLink library, as Debian has them.
#[track_caller]
pub fn openigtlink(example: &str) -> Command {
    program(&format!("openigtlink/{example}"))
}
