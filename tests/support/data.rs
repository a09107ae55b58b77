//! Where test data is: what the repository holds, and third-party sets outside it.

use std::io::Write as _;
use std::path::{Path, PathBuf};

/// A file or folder of `tests/data`.
pub fn own(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(path)
}

/// A path in the third-party data folder named by `TRACKWRIGHT_DATA`. Without the folder the test
/// is skipped, and the terminal reports it; with `CI` set it fails instead.
pub fn third_party(path: &str) -> Option<PathBuf> {
    let Some(root) = std::env::var_os("TRACKWRIGHT_DATA") else {
        let missing = format!("{path} is not there: set TRACKWRIGHT_DATA to the third-party data");
        assert!(std::env::var_os("CI").is_none(), "{missing}");
        // Written to the stream itself, because the test harness captures what is printed.
        let _ = writeln!(std::io::stderr(), "skipped: {missing}");
        return None;
    };
    let full = Path::new(&root).join(path);
    assert!(full.exists(), "TRACKWRIGHT_DATA has no {path}");
    Some(full)
}

/// All recordings of an Aurora beside a Polaris in a folder, from one on in steps, as the arguments
/// of `characterize`.
pub fn aurora_pairs(folder: &Path, first: usize, step: usize) -> String {
    let files = |tracker: &str| {
        let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        let all = entries.map(|path| path.to_str().unwrap().to_owned());
        let mut all: Vec<_> = all.filter(|path| path.contains(&format!("/{tracker}_"))).collect();
        all.sort();
        all.into_iter().skip(first).step_by(step).collect::<Vec<_>>().join(" ")
    };
    format!("--em {} --reference {}", files("EM"), files("OT"))
}
