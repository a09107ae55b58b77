//! Where test data is: what the repository holds, and third-party sets outside it.

use std::path::{Path, PathBuf};

/// A file or folder of `tests/data`.
pub fn own(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(path)
}

/// A path in the third-party data folder named by `TRACKWRIGHT_DATA`, or `None` with a word why
/// the test is skipped. Where the variable is set the path has to exist.
#[expect(clippy::print_stderr, reason = "a skipped test says so")]
pub fn third_party(path: &str) -> Option<PathBuf> {
    let Some(root) = std::env::var_os("TRACKWRIGHT_DATA") else {
        eprintln!("skipped: TRACKWRIGHT_DATA names no folder with {path}");
        return None;
    };
    let full = Path::new(&root).join(path);
    assert!(full.exists(), "TRACKWRIGHT_DATA has no {path}");
    Some(full)
}
