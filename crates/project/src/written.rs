//! What commands wrote, by its content: a file that nobody has changed since is replaced without
//! `--overwrite`. The list is in the state folder, so that it holds for files of any format.

use super::stamps::Fnv1a;
use super::state::{create_private_folder, state_folder};
use super::write::{Lock, write_bytes};
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Write};
use std::path::Path;

const LIST: &str = "written";
const LOCK: &str = "written.lock";

/// The list is cut to its newer half where it is longer: some 20,000 files.
const LONGEST_BYTES: u64 = 1 << 20;

/// Length and hash of a file's bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Content {
    length: u64,
    hash: u64,
}

impl Content {
    /// Of a file that is read in parts: tables may be large.
    fn of(file: &Path) -> io::Result<Self> {
        let mut reader = File::open(file)?;
        let (mut length, mut hash) = (0, Fnv1a::default());
        let mut part = vec![0; 1 << 16];
        loop {
            match reader.read(&mut part)? {
                0 => return Ok(Self { length, hash: hash.value() }),
                count => {
                    length += count as u64;
                    hash.add(&part[..count]);
                }
            }
        }
    }

    fn line(self) -> String {
        format!("{} {:016x}", self.length, self.hash)
    }
}

/// Whether a command wrote what the file holds. Without a state folder nothing is known.
pub(super) fn is_as_written(file: &Path) -> bool {
    let (Ok(content), Some(folder)) = (Content::of(file), state_folder()) else {
        return false;
    };
    is_listed(&folder, content)
}

/// Remembers what a command wrote. What cannot be remembered needs `--overwrite` later.
pub(super) fn remember(file: &Path) {
    if let (Ok(content), Some(folder)) = (Content::of(file), state_folder()) {
        let _ = add(&folder, content);
    }
}

fn is_listed(folder: &Path, content: Content) -> bool {
    let list = fs::read(folder.join(LIST)).unwrap_or_default();
    let line = content.line();
    list.split(|byte| *byte == b'\n').any(|own| own == line.as_bytes())
}

fn add(folder: &Path, content: Content) -> io::Result<()> {
    create_private_folder(folder).map_err(io::Error::other)?;
    if is_listed(folder, content) {
        return Ok(());
    }
    // Held only while one line is written.
    let _lock = Lock::wait_for(&folder.join(LOCK)).map_err(io::Error::other)?;
    let file = folder.join(LIST);
    if fs::metadata(&file).is_ok_and(|found| found.len() > LONGEST_BYTES) {
        let list = String::from_utf8_lossy(&fs::read(&file)?).into_owned();
        let newer: Vec<&str> = list.lines().skip(list.lines().count() / 2).collect();
        write_bytes(&file, (newer.join("\n") + "\n").as_bytes()).map_err(io::Error::other)?;
    }
    let mut list = OpenOptions::new().create(true).append(true).open(&file)?;
    // In one piece, after whatever an interrupted line left.
    list.write_all(format!("\n{}\n", content.line()).as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn content_is_known_until_it_is_changed() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("table.csv");
        let state = folder.path().join("not/yet");
        fs::write(&file, "x,y\n1,2\n").unwrap();
        let content = Content::of(&file).unwrap();
        assert!(!is_listed(&state, content));
        add(&state, content).unwrap();
        add(&state, content).unwrap();
        assert!(is_listed(&state, content));
        let list = fs::read_to_string(state.join(LIST)).unwrap();
        assert_eq!(list.lines().filter(|line| !line.is_empty()).count(), 1);
        // A byte more, a byte less, another byte.
        for changed in ["x,y\n1,2\n\n", "x,y\n1,2", "x,y\n1,3\n"] {
            fs::write(&file, changed).unwrap();
            assert!(!is_listed(&state, Content::of(&file).unwrap()), "{changed:?}");
        }
    }

    #[test]
    fn a_damaged_list_keeps_its_other_lines() {
        let state = tempfile::tempdir().unwrap();
        let content = |number: u64| Content { length: number, hash: number };
        fs::write(state.path().join(LIST), b"1 0000000000000001\n\xff\xfe\n2 00000000").unwrap();
        add(state.path(), content(3)).unwrap();
        for (number, is_known) in [(1, true), (2, false), (3, true)] {
            assert_eq!(is_listed(state.path(), content(number)), is_known, "{number}");
        }
    }

    #[test]
    fn a_long_list_keeps_its_newer_half() {
        let state = tempfile::tempdir().unwrap();
        let content = |number: u64| Content { length: number, hash: number };
        let lines: Vec<String> = (0..60_000).map(|number| content(number).line()).collect();
        fs::write(state.path().join(LIST), lines.join("\n") + "\n").unwrap();
        add(state.path(), content(100_000)).unwrap();
        for (number, is_known) in [(0, false), (59_999, true), (100_000, true)] {
            assert_eq!(is_listed(state.path(), content(number)), is_known, "{number}");
        }
        let length = fs::metadata(state.path().join(LIST)).unwrap().len();
        assert!(length < LONGEST_BYTES, "{length}");
    }
}
