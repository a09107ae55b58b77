//! The corpora of the fuzz targets, whole and cut at every byte: a disk that was full, a copy that was
//! broken off and a program that was killed all leave files that end anywhere.

use super::targets::{TARGETS, Target};
use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

/// What a file of the corpus begins with in its name where nothing can be read from it.
const REFUSED: &str = "refused-";

/// Longest file of a corpus. Each is read as often as it has bytes, so that time grows with the square.
const MAX_BYTES: usize = 4096;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus")
}

fn names(folder: &Path) -> BTreeSet<String> {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let name = |entry: std::io::Result<std::fs::DirEntry>| entry.unwrap().file_name();
    entries.map(|e| name(e).into_string().unwrap()).collect()
}

/// What a target makes of bytes; a panic is reported with the source of the bytes.
fn read(target: &Target, bytes: &[u8], from: &dyn Fn() -> String) -> bool {
    let caught = catch_unwind(AssertUnwindSafe(|| (target.read)(bytes)));
    caught.unwrap_or_else(|_| panic!("{} fails on {}", target.name, from()))
}

fn replay(target: &Target) {
    let folder = folder().join(target.name);
    for name in names(&folder) {
        let bytes = std::fs::read(folder.join(&name)).unwrap();
        assert!(bytes.len() <= MAX_BYTES, "{name}: {} bytes", bytes.len());
        let is_read = read(target, &bytes, &|| name.clone());
        assert_eq!(
            is_read,
            !name.starts_with(REFUSED),
            "{}: whether anything is read from {name}",
            target.name
        );
        // Spaces at the end are missed by nobody.
        let length = bytes.trim_ascii_end().len();
        for cut in 0..bytes.len() {
            let from = || format!("{name} cut at {cut}");
            let is_read = read(target, &bytes[..cut], &from);
            if target.states_its_end && cut < length {
                assert!(!is_read, "{}: {} is read", target.name, from());
            }
        }
    }
}

#[test]
fn targets_hold_on_their_corpora_cut_anywhere() {
    // What one thread takes from the end of the list, no other does.
    let left = std::sync::Mutex::new(TARGETS.to_vec());
    let next = || left.lock().unwrap().pop();
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                while let Some(target) = next() {
                    replay(&target);
                }
            });
        }
    });
}

#[test]
fn every_corpus_has_a_target_and_a_program() {
    let expected: BTreeSet<String> = TARGETS.iter().map(|t| t.name.to_owned()).collect();
    assert_eq!(names(&folder()), expected);
    let programs = names(&folder().join("../fuzz_targets"));
    let expected: BTreeSet<String> = expected.iter().map(|name| format!("{name}.rs")).collect();
    assert_eq!(programs, expected);
}
