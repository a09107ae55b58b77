//! What files were when they were read or written, and whether they still are.

use super::error::StoreError;
use super::paths::in_real_folder;
use super::read::{ReadFailure, Storage};
use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use trackwright_formats::recovery_file::FileStamp;

/// How long after a file's own time another write may still leave it with that time: the
/// coarsest clock of a file system in use is FAT's, with steps of 2 s.
const CLOCK_STEP: Duration = Duration::from_secs(2);

/// What became of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileChange {
    /// Its content is another one.
    Content,
    /// It is gone, or cannot be read any more.
    Gone,
}

/// What files were when they were read or written, each by its folder's real place and its name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Stamps(BTreeMap<PathBuf, FileStamp>);

impl Stamps {
    /// Remembers a file by the bytes that were just read from it or written to it.
    ///
    /// Its time is read afterwards. Should somebody have written in between, then so shortly
    /// ago that the content is compared as well.
    pub(super) fn take(&mut self, file: &Path, bytes: &[u8]) {
        let modified = fs::metadata(file).and_then(|m| m.modified());
        let stamp = FileStamp {
            length: bytes.len() as u64,
            modified_ns: modified.map_or(0, nanoseconds),
            taken_ns: nanoseconds(SystemTime::now()),
            hash: fnv1a(bytes),
        };
        self.0.insert(in_real_folder(file), stamp);
    }

    pub(super) fn forget(&mut self, file: &Path) {
        self.0.remove(&in_real_folder(file));
    }

    /// Adds what others know; theirs counts.
    pub(super) fn extend(&mut self, others: Self) {
        self.0.extend(others.0);
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = (&PathBuf, &FileStamp)> {
        self.0.iter()
    }

    pub(super) fn from_pairs(pairs: impl IntoIterator<Item = (PathBuf, FileStamp)>) -> Self {
        Self(pairs.into_iter().collect())
    }

    /// # Errors
    /// [`StoreError::ChangedOnDisk`] where writing the file would lose what somebody else wrote.
    pub(super) fn check_unchanged(&self, file: &Path) -> Result<(), StoreError> {
        match self.change_of(file) {
            Some(FileChange::Content) => Err(StoreError::ChangedOnDisk { file: file.to_owned() }),
            // What is gone is not lost by being written again.
            Some(FileChange::Gone) | None => Ok(()),
        }
    }

    /// Whether a file was read or written.
    pub(super) fn knows(&self, file: &Path) -> bool {
        self.0.contains_key(&in_real_folder(file))
    }

    /// Whether a file was read and is what it was then.
    pub(super) fn is_unchanged(&self, file: &Path) -> bool {
        self.knows(file) && self.change_of(file).is_none()
    }

    pub(super) fn change_of(&self, file: &Path) -> Option<FileChange> {
        let stamp = self.0.get(&in_real_folder(file))?;
        match differs(file, stamp) {
            Ok(false) => None,
            Ok(true) => Some(FileChange::Content),
            Err(_) => Some(FileChange::Gone),
        }
    }
}

fn differs(file: &Path, stamp: &FileStamp) -> io::Result<bool> {
    let metadata = fs::metadata(file)?;
    if metadata.len() != stamp.length {
        return Ok(true);
    }
    let modified_ns = metadata.modified().map_or(0, nanoseconds);
    let is_old = stamp.modified_ns.saturating_add(CLOCK_STEP.as_nanos() as u64) < stamp.taken_ns;
    if modified_ns == stamp.modified_ns && is_old && modified_ns != 0 {
        return Ok(false);
    }
    match Storage::Disk.read(file, "a file") {
        Ok(bytes) => Ok(fnv1a(&bytes) != stamp.hash),
        Err(ReadFailure::Io(error)) => Err(error),
        // It was no larger when it was read.
        Err(ReadFailure::TooLarge) => Ok(true),
    }
}

/// Since 1970, in 64 bits until 2554; earlier times are 0.
fn nanoseconds(time: SystemTime) -> u64 {
    let since = time.duration_since(UNIX_EPOCH).unwrap_or_default();
    u64::try_from(since.as_nanos()).unwrap_or(u64::MAX)
}

/// FNV-1a, 64 bits: recovery files keep it, so that it has to be the same in every version of
/// this program. It detects accidental changes; nobody forges these files.
fn fnv1a(bytes: &[u8]) -> u64 {
    let mut hash = Fnv1a::default();
    hash.add(bytes);
    hash.value()
}

/// The same of bytes that come in parts.
pub(super) struct Fnv1a(u64);

impl Default for Fnv1a {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Fnv1a {
    pub(super) fn add(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    pub(super) fn value(&self) -> u64 {
        self.0
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use std::fs::File;

    /// Changes one byte and nothing else, not even the file's time.
    pub fn change_secretly(file: &Path) {
        let time = fs::metadata(file).unwrap().modified().unwrap();
        let mut bytes = fs::read(file).unwrap();
        let last = bytes.last_mut().unwrap();
        *last ^= 1;
        fs::write(file, bytes).unwrap();
        let file = File::options().write(true).open(file).unwrap();
        file.set_modified(time).unwrap();
    }

    #[test]
    fn an_old_file_is_known_by_length_and_time() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("old");
        fs::write(&file, "abc").unwrap();
        let handle = File::options().write(true).open(&file).unwrap();
        handle.set_modified(SystemTime::now() - 2 * CLOCK_STEP).unwrap();
        let mut stamps = Stamps::default();
        stamps.take(&file, b"abc");
        change_secretly(&file);
        assert_eq!(stamps.change_of(&file), None);
    }
}
