//! Which files of an open design were changed by somebody else since they were read or written.

use super::error::StoreError;
use super::open::{World, home};
use super::place::{Place, ReadFailure, absolute};
use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use trackwright_design::{BodyRole, Origin};
use trackwright_formats::recovery_file::FileStamp;

/// How long after a file's own time another write may still leave it with that time: the
/// coarsest clock of a file system in use is FAT's, with steps of 2 s.
const CLOCK_STEP: Duration = Duration::from_secs(2);

/// A file of the design that is not what it was when this program last read or wrote it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChangedFile {
    pub file: PathBuf,
    pub part: WatchedPart,
    pub change: FileChange,
}

/// What a file is to the design.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WatchedPart {
    Design,
    Environment,
    Body(BodyRole),
    Mesh(BodyRole),
    /// A mesh of it.
    Anatomy,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileChange {
    /// Its content is another one.
    Content,
    /// It is gone, or cannot be read any more.
    Gone,
}

impl std::fmt::Display for WatchedPart {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Design => f.write_str("design"),
            Self::Environment => f.write_str("environment"),
            Self::Body(role) => write!(f, "{role}"),
            Self::Mesh(role) => write!(f, "{role} mesh"),
            Self::Anatomy => f.write_str("anatomy"),
        }
    }
}

/// The files of the design that differ from what was read or written. A file whose time was
/// touched but not its content is none of them.
///
/// Looks at length and time of each file, and at its content only where those leave a doubt.
pub fn changes(world: &World) -> Vec<ChangedFile> {
    watched_files(world)
        .into_iter()
        .filter_map(|(part, file)| {
            let change = world.stamps.change_of(&file)?;
            Some(ChangedFile { file, part, change })
        })
        .collect()
}

/// States that what the files hold now was seen, and may be written over by the next Save.
pub fn accept_changes(world: &mut World) {
    for changed in changes(world) {
        match Place::Disk.read(&changed.file, "a file") {
            Ok(bytes) => world.stamps.take(&changed.file, &bytes),
            Err(_) => world.stamps.forget(&changed.file),
        }
    }
}

/// The disk's files that the design is made of now.
pub(super) fn watched_files(world: &World) -> Vec<(WatchedPart, PathBuf)> {
    let document = &world.document;
    let design = document.design();
    let Ok((place, own_file)) = home(document.origin()) else {
        return Vec::new();
    };
    let mut files = Vec::new();
    if let Origin::File(file) = document.origin() {
        files.push((WatchedPart::Design, file.clone()));
    }
    let environment = place.resolve(&own_file, &design.environment);
    files.push((WatchedPart::Environment, environment));
    for (role, body) in design.bodies() {
        let file = place.resolve(&own_file, &body.reference);
        if let Some(mesh) = &body.mesh {
            files.push((WatchedPart::Mesh(role), place.resolve(&file, &mesh.file)));
        }
        files.push((WatchedPart::Body(role), file));
    }
    for anatomy in &design.anatomy {
        let file = place.resolve(&own_file, &anatomy.mesh.file);
        // Several may show one file.
        if files.iter().all(|(_, other)| *other != file) {
            files.push((WatchedPart::Anatomy, file));
        }
    }
    files.retain(|(_, file)| place == Place::Disk || file.is_absolute());
    files
}

/// What files were when they were read or written, each by its folder's real place and its name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Stamps(BTreeMap<PathBuf, FileStamp>);

impl Stamps {
    /// Remembers a file by the bytes that were just read from it or written to it.
    ///
    /// Its time is asked for afterwards. Should somebody have written in between, then so shortly
    /// ago that the content is compared as well.
    pub(super) fn take(&mut self, file: &Path, bytes: &[u8]) {
        let modified = fs::metadata(file).and_then(|m| m.modified());
        let stamp = FileStamp {
            length: bytes.len() as u64,
            modified_ns: modified.map_or(0, nanoseconds),
            taken_ns: nanoseconds(SystemTime::now()),
            hash: fnv1a(bytes),
        };
        self.0.insert(key(file), stamp);
    }

    pub(super) fn forget(&mut self, file: &Path) {
        self.0.remove(&key(file));
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
        self.0.contains_key(&key(file))
    }

    /// Whether a file was read and is what it was then.
    pub(super) fn is_unchanged(&self, file: &Path) -> bool {
        self.knows(file) && self.change_of(file).is_none()
    }

    fn change_of(&self, file: &Path) -> Option<FileChange> {
        let stamp = self.0.get(&key(file))?;
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
    match Place::Disk.read(file, "a file") {
        Ok(bytes) => Ok(fnv1a(&bytes) != stamp.hash),
        Err(ReadFailure::Io(error)) => Err(error),
        // It was no larger when it was read.
        Err(ReadFailure::TooLarge) => Ok(true),
    }
}

/// The file's name in its folder's real place, which is the same whether or not the file exists.
fn key(file: &Path) -> PathBuf {
    match (file.parent(), file.file_name()) {
        (Some(folder), Some(name)) if folder == Path::new("") => {
            absolute(Path::new(".")).join(name)
        }
        (Some(folder), Some(name)) => absolute(folder).join(name),
        _ => absolute(file),
    }
}

/// Since 1970, in 64 bits until 2554; earlier times are 0.
fn nanoseconds(time: SystemTime) -> u64 {
    let since = time.duration_since(UNIX_EPOCH).unwrap_or_default();
    u64::try_from(since.as_nanos()).unwrap_or(u64::MAX)
}

/// FNV-1a, 64 bits: recovery files keep it, so that it has to be the same in every version of
/// this program. It tells an accident from no change; nobody forges these files.
fn fnv1a(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

#[cfg(test)]
mod tests {
    use super::super::{open_builtin, open_design, save, save_as, save_with_copies};
    use super::*;
    use std::fs::File;
    use trackwright_design::Edit;

    fn saved_world() -> (tempfile::TempDir, World) {
        let folder = tempfile::tempdir().unwrap();
        let mut world = open_builtin("pointer-on-head").unwrap();
        save_as(&mut world, &folder.path().join("a.design.ron")).unwrap();
        (folder, world)
    }

    fn found(world: &World) -> Vec<(WatchedPart, FileChange)> {
        changes(world).into_iter().map(|c| (c.part, c.change)).collect()
    }

    /// Changes one byte and nothing else, not even the file's time.
    fn change_secretly(file: &Path) {
        let time = fs::metadata(file).unwrap().modified().unwrap();
        let mut bytes = fs::read(file).unwrap();
        let last = bytes.last_mut().unwrap();
        *last ^= 1;
        fs::write(file, bytes).unwrap();
        let file = File::options().write(true).open(file).unwrap();
        file.set_modified(time).unwrap();
    }

    #[test]
    fn what_somebody_else_changed_is_named_and_what_was_only_touched_is_not() {
        let (folder, world) = saved_world();
        let opened = open_design(&folder.path().join("a.design.ron")).unwrap();
        assert_eq!((found(&world), found(&opened)), (vec![], vec![]));
        let body = folder.path().join("pointer.body.ron");
        let touched = File::options().write(true).open(&body).unwrap();
        touched.set_modified(UNIX_EPOCH).unwrap();
        assert_eq!(found(&world), []);
        // Just written: equal length and time are no proof yet.
        change_secretly(&folder.path().join("operating-table.env.ron"));
        fs::write(folder.path().join("pointer.glb"), "").unwrap();
        fs::remove_file(folder.path().join("head-crf.body.ron")).unwrap();
        for world in [world, opened] {
            assert_eq!(
                found(&world),
                [
                    (WatchedPart::Environment, FileChange::Content),
                    (WatchedPart::Mesh(BodyRole::Tool), FileChange::Content),
                    (WatchedPart::Body(BodyRole::Crf), FileChange::Gone),
                ]
            );
        }
    }

    #[test]
    fn a_file_of_old_is_known_by_its_length_and_time_alone() {
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

    #[test]
    fn what_somebody_else_wrote_is_not_written_over_unless_that_is_said() {
        let (folder, mut world) = saved_world();
        let file = folder.path().join("a.design.ron");
        let theirs = fs::read_to_string(&file).unwrap() + "// theirs\n";
        world.document.apply(Edit::SetName("Mine".into())).unwrap();
        fs::write(&file, &theirs).unwrap();
        for save in [save, save_with_copies] {
            let error = save(&mut world).unwrap_err();
            assert!(matches!(error, StoreError::ChangedOnDisk { .. }), "{error}");
            assert!(world.document.is_dirty());
            assert_eq!(fs::read_to_string(&file).unwrap(), theirs);
        }
        accept_changes(&mut world);
        assert_eq!(found(&world), []);
        assert_eq!(save(&mut world).unwrap().written, std::slice::from_ref(&file));
        assert_eq!(found(&world), []);
        // A file that is gone stands in nobody's way.
        fs::remove_file(&file).unwrap();
        world.document.apply(Edit::SetName("Again".into())).unwrap();
        assert_eq!(found(&world), [(WatchedPart::Design, FileChange::Gone)]);
        save(&mut world).unwrap();
        assert_eq!(found(&world), []);
    }

    #[test]
    fn a_design_that_moved_watches_the_files_it_left_behind() {
        let (folder, mut world) = saved_world();
        let elsewhere = folder.path().join("deep");
        fs::create_dir(&elsewhere).unwrap();
        save_as(&mut world, &elsewhere.join("b.design.ron")).unwrap();
        assert_eq!(found(&world), []);
        fs::write(folder.path().join("head-crf.glb"), "").unwrap();
        let mesh = WatchedPart::Mesh(BodyRole::Crf);
        assert_eq!(found(&world), [(mesh, FileChange::Content)]);
    }
}
