//! Writes whole files or nothing: an interrupted write leaves the old file. Files that others may be
//! saving too are replaced under a lock, and with a copy of what would be lost.

use super::error::StoreError;
use super::paths::{absolute, folder_of, free_name, is_still};
use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use trackwright_formats::signature::holds_more_than_written;

/// What the names of temporary files begin with.
const TEMPORARY: &str = ".trackwright-";

/// Tries to make a temporary file that nobody removes while it is made. One is all but always enough.
const TEMPORARY_ATTEMPTS: usize = 16;

/// Writes a file of the program's own over what was there, whole or not at all, and removes what
/// interrupted writes left in its folder.
pub(super) fn write_bytes(file: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    remove_leftovers(&folder_of(file));
    let draft = Draft::write(file, |out| out.write_all(bytes));
    draft.and_then(Draft::place).map_err(|cause| write_error(file, cause))
}

/// Whether a file can be written at a place: its folder is there and takes new files. Nothing is
/// left there.
///
/// # Errors
/// [`StoreError::Write`] with what stands in the way.
pub fn check_place(file: &Path) -> Result<(), StoreError> {
    let real = file.canonicalize().unwrap_or_else(|_| file.to_owned());
    if fs::metadata(&real).is_ok_and(|found| !found.is_file()) {
        return Ok(());
    }
    Temporary::next_to(&real, ".tmp").map(drop).map_err(|cause| write_error(file, cause))
}

pub(super) fn write_error(file: &Path, cause: io::Error) -> StoreError {
    StoreError::Write { file: file.to_owned(), cause }
}

/// Links from one to the next at most, as systems have it.
const MOST_LINKS: usize = 40;

/// Where a name leads to by its links, whether a file is there or not; a stream of this process stays one.
fn followed(file: &Path) -> io::Result<PathBuf> {
    let mut file = file.to_owned();
    for _ in 0..MOST_LINKS {
        if is_own_stream(&file) {
            return Ok(file);
        }
        match fs::read_link(&file) {
            Ok(target) => file = folder_of(&file).join(target),
            Err(_) => return Ok(file.canonicalize().unwrap_or(file)),
        }
    }
    Err(io::Error::other("the link leads to itself"))
}

/// Names of the standard output, then of the standard error.
const STREAMS: [&str; 6] =
    ["/dev/stdout", "/dev/fd/1", "/proc/self/fd/1", "/dev/stderr", "/dev/fd/2", "/proc/self/fd/2"];

/// Whether a name is of an open file of this process, such as its standard output.
pub(super) fn is_own_stream(file: &Path) -> bool {
    let folders = ["/dev/fd", "/proc/self/fd"];
    STREAMS.iter().any(|stream| file == Path::new(stream))
        || folders.iter().any(|folder| file.starts_with(folder))
}

/// A whole file beside the one that it replaces; what is no plain file was written to as it is.
#[derive(Debug)]
pub(super) struct Draft {
    /// Links followed: a link stays a link.
    file: PathBuf,
    /// `None` for what is no plain file.
    temporary: Option<Temporary>,
}

impl Draft {
    pub(super) fn write(
        file: &Path,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> io::Result<Self> {
        let file = followed(file)?;
        let before = fs::metadata(&file).ok();
        let is_stream = is_own_stream(&file);
        if is_stream || before.as_ref().is_some_and(|m| !m.is_file()) {
            // What a shell has put at a stream's place is written on where the others are.
            let open: Box<dyn Write> = match STREAMS.iter().position(|own| file == Path::new(own)) {
                Some(k) if k < 3 => Box::new(io::stdout()),
                Some(_) => Box::new(io::stderr()),
                None => Box::new(File::options().write(true).append(is_stream).open(&file)?),
            };
            let mut out = BufWriter::new(open);
            write(&mut out)?;
            out.flush()?;
            return Ok(Self { file, temporary: None });
        }
        // Renaming would replace it all the same.
        if before.as_ref().is_some_and(|before| before.permissions().readonly()) {
            return Err(io::ErrorKind::PermissionDenied.into());
        }
        let temporary = Temporary::next_to(&file, ".tmp")?;
        let mut out = BufWriter::new(&temporary.handle);
        write(&mut out)?;
        out.flush()?;
        drop(out);
        if let Some(before) = before {
            temporary.handle.set_permissions(before.permissions())?;
        }
        temporary.handle.sync_all()?;
        Ok(Self { file, temporary: Some(temporary) })
    }

    /// What is to take the file's place.
    pub(super) fn temporary(&self) -> Option<&Path> {
        self.temporary.as_ref().map(|temporary| &*temporary.path)
    }

    /// Whether the file that it is to replace holds the same already.
    pub(super) fn is_there_already(&self) -> io::Result<bool> {
        let Some(temporary) = &self.temporary else {
            return Ok(false);
        };
        let Ok(there) = fs::metadata(&self.file) else {
            return Ok(false);
        };
        let is_as_long = there.len() == temporary.handle.metadata()?.len();
        Ok(is_as_long && fs::read(&self.file)? == fs::read(&temporary.path)?)
    }

    /// Replaces the file.
    pub(super) fn place(self) -> io::Result<()> {
        if let Some(temporary) = self.temporary {
            temporary.path.persist(&self.file).map_err(|e| e.error)?;
            sync_folder(&folder_of(&self.file));
        }
        Ok(())
    }

    /// Becomes the file, which must not be there.
    pub(super) fn place_new(self) -> io::Result<()> {
        if let Some(temporary) = self.temporary {
            let placed = temporary.path.persist_noclobber(&self.file);
            placed.map_err(|e| e.error)?;
            sync_folder(&folder_of(&self.file));
        }
        Ok(())
    }
}

/// A file beside another, to take its place once it is whole. It is locked for as long as it is
/// written, so that one whose lock is free is what an interrupted write left.
#[derive(Debug)]
pub(super) struct Temporary {
    pub(super) handle: File,
    pub(super) path: tempfile::TempPath,
}

impl Temporary {
    pub(super) fn next_to(file: &Path, suffix: &str) -> io::Result<Self> {
        let mut builder = tempfile::Builder::new();
        builder.prefix(TEMPORARY).suffix(suffix);
        // The mode that any new file gets; the umask is taken off it. A temporary file's own is 0600.
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            builder.permissions(fs::Permissions::from_mode(0o666));
        }
        for _ in 0..TEMPORARY_ATTEMPTS {
            let (handle, path) = builder.tempfile_in(folder_of(file))?.into_parts();
            // Where files cannot be locked nobody removes them either.
            let is_taken = matches!(handle.try_lock(), Err(fs::TryLockError::WouldBlock));
            if !is_taken && path.exists() {
                return Ok(Self { handle, path });
            }
        }
        Err(io::ErrorKind::WouldBlock.into())
    }
}

/// Removes the temporary files of a folder that nobody writes any more.
pub(super) fn remove_leftovers(folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let is_temporary = entry.file_name().to_string_lossy().starts_with(TEMPORARY);
        // No link, no pipe.
        if !is_temporary || !entry.file_type().is_ok_and(|kind| kind.is_file()) {
            continue;
        }
        let Ok(handle) = File::open(entry.path()) else {
            continue;
        };
        if let Ok(Some(lock)) = Lock::take_open(handle, &entry.path()) {
            let _ = fs::remove_file(lock.file());
        }
    }
}

/// Removes what an interrupted write of a file left beside it; the file stays as it is.
pub fn remove_interrupted(file: &Path) {
    // Written where links lead to.
    let real = file.canonicalize().unwrap_or_else(|_| file.to_owned());
    remove_leftovers(&folder_of(&real));
}

/// Makes the new name outlast a power cut, where the file system can.
fn sync_folder(folder: &Path) {
    if cfg!(unix) {
        let _ = File::open(folder).and_then(|folder| folder.sync_all());
    }
}

/// What the name of a file's former version ends in.
const FORMER: &str = ".old";

/// A file that held comments, which its new version lacks.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{}: comments are not kept; the file as it was is {}",
    file.display(), former.display()
)]
pub struct KeptFile {
    pub file: PathBuf,
    /// The file as it was.
    pub former: PathBuf,
}

/// Locks the files that are there, so that nobody else saves them between the look at what they hold
/// and their replacement. In one order everywhere, so that nobody waits for each other.
pub(super) fn lock_all(texts: &[(PathBuf, String)]) -> Result<BTreeMap<PathBuf, Lock>, StoreError> {
    let files: BTreeSet<PathBuf> = texts.iter().map(|(file, _)| absolute(file)).collect();
    let mut locks = BTreeMap::new();
    for file in files {
        if let Some(lock) = Lock::for_replacing(&file)? {
            locks.insert(file, lock);
        }
    }
    Ok(locks)
}

/// Writes a file; one that was not there must not have appeared meanwhile.
pub(super) fn replace(file: &Path, bytes: &[u8], was_there: bool) -> Result<(), StoreError> {
    remove_leftovers(&folder_of(file));
    let draft = Draft::write(file, |out| out.write_all(bytes));
    let placed = draft.and_then(|draft| match was_there {
        true => draft.place(),
        false => draft.place_new(),
    });
    placed.map_err(|cause| match cause.kind() {
        io::ErrorKind::AlreadyExists => StoreError::ChangedOnDisk { file: file.to_owned() },
        _ => write_error(file, cause),
    })
}

/// Copies a file of which something is lost when it is written anew.
pub(super) fn keep_former(file: &Path) -> Result<Option<KeptFile>, StoreError> {
    let Ok(bytes) = fs::read(file) else {
        return Ok(None);
    };
    if !holds_more_than_written(&bytes) {
        return Ok(None);
    }
    let mut former = file.as_os_str().to_owned();
    former.push(FORMER);
    let former = free_name(Path::new(&former), |path| !path.exists());
    write_bytes(&former, &bytes)?;
    Ok(Some(KeptFile { file: file.to_owned(), former }))
}

/// A locked file. What is locked is the file itself and not its name.
#[derive(Debug)]
pub(super) struct Lock {
    handle: File,
    file: PathBuf,
}

impl Lock {
    /// Locks a file, which is made if it has to be; `None` while somebody else has it locked.
    pub(super) fn take(file: &Path) -> Result<Option<Self>, StoreError> {
        let handle = options().open(file).map_err(|e| lock_error(file, e))?;
        Self::take_open(handle, file)
    }

    /// Locks an open file; `None` while somebody else has it locked.
    pub(super) fn take_open(handle: File, file: &Path) -> Result<Option<Self>, StoreError> {
        match handle.try_lock() {
            Ok(()) => Ok(Some(Self { handle, file: file.to_owned() })),
            Err(TryLockError::WouldBlock) => Ok(None),
            Err(TryLockError::Error(cause)) => Err(lock_error(file, cause)),
        }
    }

    /// Locks a file, which is made if it has to be, once whoever has it locked is done.
    pub(super) fn wait_for(file: &Path) -> Result<Self, StoreError> {
        let lock = |handle: File| handle.lock().map(|()| handle);
        let handle = options().open(file).and_then(lock);
        Ok(Self { handle: handle.map_err(|e| lock_error(file, e))?, file: file.to_owned() })
    }

    /// Locks a file that is going to be replaced, once others are done; `None` where there is none.
    pub(super) fn for_replacing(file: &Path) -> Result<Option<Self>, StoreError> {
        loop {
            let handle = match File::open(file) {
                Ok(handle) => handle,
                Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
                Err(error) => return Err(lock_error(file, error)),
            };
            // There a lock would keep this program itself from reading.
            if cfg!(unix) {
                handle.lock().map_err(|e| lock_error(file, e))?;
            }
            // The lock is on the file that was there; its name may lead to a newer one by now.
            if is_still(&handle, file).map_err(|e| lock_error(file, e))? {
                return Ok(Some(Self { handle, file: file.to_owned() }));
            }
        }
    }

    pub(super) fn file(&self) -> &Path {
        &self.file
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // Closing alone is too late where another thread is starting a process, which has every
        // open file until it has become its own program.
        let _ = self.handle.unlock();
    }
}

fn options() -> OpenOptions {
    let mut options = File::options();
    options.create(true).truncate(false).write(true);
    options
}

fn lock_error(file: &Path, cause: io::Error) -> StoreError {
    StoreError::Lock { file: file.to_owned(), cause }
}

#[cfg(test)]
mod tests {
    use super::super::{open_builtin_without_meshes, open_design_without_meshes, save, save_as};
    use super::*;
    use crate::tests::files;
    use std::thread;
    use trackwright_design::Edit;

    #[test]
    fn leftovers_of_interrupted_writes_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.csv");
        for name in [".trackwright-a.tmp", ".trackwright-b.mp4", ".trackwrong"] {
            fs::write(folder.path().join(name), "half a li").unwrap();
        }
        write_bytes(&file, b"whole").unwrap();
        assert_eq!(files(folder.path()), [".trackwrong", "a.csv"]);
    }

    #[test]
    fn a_temporary_file_in_use_is_no_leftover() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.csv");
        let in_use = Temporary::next_to(&file, ".tmp").unwrap();
        write_bytes(&file, b"whole").unwrap();
        assert!(in_use.path.exists());
        drop(in_use);
        assert_eq!(files(folder.path()), ["a.csv"]);
    }

    #[test]
    fn an_interrupted_write_leaves_the_old_file() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.csv");
        for file in [&file, &folder.path().join(".trackwright-a.tmp")] {
            fs::write(file, "old").unwrap();
        }
        remove_interrupted(&file);
        assert_eq!(files(folder.path()), ["a.csv"]);
    }

    #[test]
    fn a_failed_write_leaves_the_old_file() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.csv");
        write_bytes(&file, b"old").unwrap();
        let failed = Draft::write(&file, |out| {
            out.write_all(b"ne")?;
            Err(io::ErrorKind::StorageFull.into())
        });
        assert_eq!(failed.unwrap_err().kind(), io::ErrorKind::StorageFull);
        assert_eq!(fs::read(&file).unwrap(), b"old");
        assert_eq!(files(folder.path()), ["a.csv"]);
    }

    /// Saves of each of two threads; more with `TRACKWRIGHT_RUNS`.
    fn saves() -> usize {
        let runs = std::env::var("TRACKWRIGHT_RUNS");
        runs.map_or(40, |runs| runs.parse().unwrap())
    }

    /// Adds a letter to a design's name, as often as it takes to be the one who saves.
    fn add_letter(file: &Path, letter: char) {
        loop {
            let mut world = open_design_without_meshes(file).unwrap();
            let name = format!("{}{letter}", world.document.design().name);
            world.document.apply(Edit::SetName(name)).unwrap();
            match save(&mut world) {
                Ok(_) => return,
                Err(StoreError::ChangedOnDisk { .. }) => {}
                Err(error) => panic!("{error}"),
            }
        }
    }

    #[test]
    fn no_save_of_two_at_once_is_lost() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.design.ron");
        let mut world = open_builtin_without_meshes("pointer-on-head").unwrap();
        world.document.apply(Edit::SetName("n".into())).unwrap();
        save_as(&mut world, &file).unwrap();
        thread::scope(|scope| {
            for letter in ['a', 'b'] {
                let file = &file;
                scope.spawn(move || (0..saves()).for_each(|_| add_letter(file, letter)));
            }
        });
        let world = open_design_without_meshes(&file).unwrap();
        let name = &world.document.design().name;
        let count = |letter| name.chars().filter(|c| *c == letter).count();
        assert_eq!((count('a'), count('b')), (saves(), saves()));
    }

    #[test]
    fn a_file_that_appears_meanwhile_is_not_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a");
        fs::write(&file, "theirs").unwrap();
        let error = replace(&file, b"mine", false).unwrap_err();
        assert!(matches!(error, StoreError::ChangedOnDisk { .. }), "{error}");
        assert_eq!(fs::read(&file).unwrap(), b"theirs");
    }
}
