//! Recovery: what is unsaved outlasts a crash.
//!
//! A session holds a lock for as long as it lives and keeps one recovery file, which it replaces
//! now and then and removes when nothing is unsaved. The system lets go of the lock however the
//! process ends, so that a recovery file whose lock is free is what a crash left over.
//!
//! ```text
//! SESSION.lock                   locked by the session that made it
//! SESSION.NAME.recovery.ron      its document; NAME is the design file's
//! ```

use super::builtin;
use super::error::StoreError;
use super::meshes::{Meshes, WhichMeshes};
use super::paths::{file_name, files_ending};
use super::read::{Kind, Storage, read};
use super::reader::{Reader, home};
use super::room_metal::refresh_metal;
use super::stamps::Stamps;
use super::state::create_private_folder;
use super::world::World;
use super::write::{Lock, write_bytes, write_error};
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};
use trackwright_design::{Design, Document, Origin, View};
use trackwright_formats::recovery_file::{self, RecoveryFile, RecoveryOrigin};

const LOCK_EXTENSION: &str = ".lock";
const RECOVERY_EXTENSION: &str = ".recovery.ron";

/// Letters of a design's name that go into a file's.
const MAX_NAME: usize = 40;

/// Tries to make a lock that nobody tidies away while it is made. One is all but always enough.
const LOCK_ATTEMPTS: usize = 16;

/// This session's recovery file.
///
/// Dropping it keeps the file, which then is a leftover: whoever ends without a word, by a panic
/// for one, loses nothing. [`clear`](Self::clear) is the word.
#[derive(Debug)]
pub struct Recovery {
    folder: PathBuf,
    session: String,
    lock: Lock,
    written: Option<(PathBuf, Snapshot)>,
}

/// What of a world is recovered: cheap to take, and to be written by any thread.
#[derive(Clone, Debug)]
pub struct Snapshot {
    design: Arc<Design>,
    view: View,
    origin: Origin,
    is_dirty: bool,
    stamps: Stamps,
}

/// What a session left that ended badly. It is this process's alone while it is held.
#[derive(Debug)]
pub struct Leftover {
    file: PathBuf,
    lock: Lock,
    content: Result<RecoveryFile, StoreError>,
}

impl Recovery {
    /// Begins a session with recovery files in a folder, which is made if it has to be.
    pub fn start(folder: &Path) -> Result<Self, StoreError> {
        create_private_folder(folder)?;
        remove_stale_locks(folder);
        for _ in 0..LOCK_ATTEMPTS {
            let (handle, file) = tempfile::Builder::new()
                .prefix(&format!("{}-", std::process::id()))
                .suffix(LOCK_EXTENSION)
                .tempfile_in(folder)
                .map_err(|cause| write_error(folder, cause))?
                .keep()
                .map_err(|error| write_error(folder, error.error))?;
            // Another session that starts may tidy it away before it is locked.
            if let Some(lock) = Lock::take_open(handle, &file)?
                && file.exists()
            {
                return Ok(Self {
                    folder: folder.to_owned(),
                    session: session_of(&file),
                    lock,
                    written: None,
                });
            }
        }
        Err(StoreError::Lock { file: folder.to_owned(), cause: io::ErrorKind::WouldBlock.into() })
    }

    /// Writes what a crash must not lose, in the place of what was written before; whether
    /// anything had changed since.
    ///
    /// The file is on the disk when this returns, by `fsync` of the file and its folder: a crash
    /// of the whole machine is one that recovery is for, and without it a file system may have
    /// the new name and not yet what is in it. That takes some milliseconds; an editor calls this
    /// off the thread that draws.
    ///
    /// # Errors
    /// [`StoreError::Write`]; what was written before is then untouched.
    pub fn write(&mut self, snapshot: &Snapshot) -> Result<bool, StoreError> {
        if self.written.as_ref().is_some_and(|(_, s)| s.is_same(snapshot)) {
            return Ok(false);
        }
        let name = plain_name(&snapshot.origin);
        let file = self.folder.join(format!("{}.{name}{RECOVERY_EXTENSION}", self.session));
        let text = recovery_file::write(&snapshot.to_file());
        write_bytes(&file, text.as_bytes())?;
        let before = self.written.replace((file.clone(), snapshot.clone()));
        match before {
            // Another document was opened, or the document saved under another name.
            Some((old_file, _)) if old_file != file => remove(&old_file).map(|()| true),
            _ => Ok(true),
        }
    }

    /// States that nothing is unsaved: removes the file until the next [`write`](Self::write).
    pub fn clear(&mut self) -> Result<(), StoreError> {
        if let Some((file, _)) = &self.written {
            remove(file)?;
        }
        self.written = None;
        Ok(())
    }
}

impl Drop for Recovery {
    fn drop(&mut self) {
        if self.written.is_none() {
            // One that stays is tidied away by the next session.
            let _ = fs::remove_file(self.lock.file());
        }
    }
}

impl Snapshot {
    /// What is unsaved of a world.
    pub fn of(world: &World) -> Self {
        let document = &world.document;
        Self {
            design: document.shared_design(),
            view: document.own_view().clone(),
            origin: document.origin().clone(),
            is_dirty: document.is_dirty(),
            stamps: world.stamps.clone(),
        }
    }

    fn is_same(&self, other: &Self) -> bool {
        let is_same_design =
            Arc::ptr_eq(&self.design, &other.design) || self.design == other.design;
        is_same_design
            && self.view == other.view
            && self.origin == other.origin
            && self.is_dirty == other.is_dirty
            && self.stamps == other.stamps
    }

    fn to_file(&self) -> RecoveryFile {
        let now = SystemTime::now().duration_since(UNIX_EPOCH);
        RecoveryFile {
            written_unix_ms: now.map_or(0, |t| u64::try_from(t.as_millis()).unwrap_or(u64::MAX)),
            process: std::process::id(),
            is_dirty: self.is_dirty,
            origin: match &self.origin {
                Origin::BuiltIn(name) => RecoveryOrigin::BuiltIn((*name).to_owned()),
                // Whoever recovers it may work in another folder.
                Origin::File(file) => {
                    RecoveryOrigin::File(std::path::absolute(file).unwrap_or_else(|_| file.clone()))
                }
            },
            design: Design::clone(&self.design),
            view: self.view.clone(),
            stamps: self.stamps.iter().map(|(k, v)| (k.clone(), *v)).collect(),
        }
    }
}

/// What sessions left that ended badly, the newest first; broken files last, none of them
/// touched. Sessions that live, and leftovers that another process holds, are not among them.
///
/// # Errors
/// [`StoreError::Read`] or [`StoreError::Lock`]. A folder that is not there holds nothing.
pub fn leftovers(folder: &Path) -> Result<Vec<Leftover>, StoreError> {
    let mut found = Vec::new();
    for file in files_of(folder, RECOVERY_EXTENSION)? {
        let Some(lock) = Lock::take(&folder.join(session_of(&file) + LOCK_EXTENSION))? else {
            continue;
        };
        if !file.exists() {
            // Another process has dealt with it since it was listed.
            let _ = fs::remove_file(lock.file());
            continue;
        }
        found.push(Leftover { content: read_recovery(&file), file, lock });
    }
    let age = |leftover: &Leftover| {
        let content = leftover.content.as_ref().ok();
        std::cmp::Reverse(content.map(|c| c.written_unix_ms))
    };
    found.sort_by_key(age);
    Ok(found)
}

impl Leftover {
    /// The recovery file.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// What is in it, or why it cannot be used.
    pub fn content(&self) -> Result<&RecoveryFile, &StoreError> {
        self.content.as_ref()
    }

    /// Opens it as it was left, unsaved, to be saved where it came from. Environment and meshes
    /// are read from there; what cannot be read of the design's own files counts as changed.
    ///
    /// The file stays until [`discard`](Self::discard): after the new session has written its own
    /// is the time for that.
    ///
    /// # Errors
    /// See [`StoreError`]; nothing is lost by one.
    pub fn open(&self) -> Result<World, StoreError> {
        let content = read_recovery(&self.file)?;
        let origin = match content.origin {
            RecoveryOrigin::BuiltIn(name) => Origin::BuiltIn(builtin::design_file(&name)?.0),
            RecoveryOrigin::File(file) => Origin::File(file),
        };
        let (storage, own_file) = home(&origin)?;
        let saved = Reader::new(storage).design_in_room(&own_file).ok();
        let mut reader = Reader::new(storage);
        let mut design = content.design;
        let environment_file = storage.resolve(&own_file, &design.environment);
        design.room_metal = reader.metal_with_surfaces(&environment_file, design.room_metal)?;
        let document = Document::recovered(design, content.view, origin, saved);
        let design = document.design();
        let bare = reader.room(&own_file, &design.environment)?.bare;
        // A window waits for it.
        let meshes = Meshes::read(&mut reader, &own_file, design, WhichMeshes::Small);
        let mut world = World::with_meshes(document, bare, meshes);
        // What was left in the middle of a drag may have no solution: it is a problem of the world.
        let _ = refresh_metal(&mut world);
        // Of design and bodies, what the session knew: what was changed since is then reported.
        world.stamps = Stamps::from_pairs(content.stamps);
        world.stamps.extend(reader.stamps);
        Ok(world)
    }

    /// Removes it for good.
    pub fn discard(self) -> Result<(), StoreError> {
        remove(&self.file)?;
        // Last, so that it is never missing while there is something to guard.
        remove(self.lock.file())
    }
}

fn read_recovery(file: &Path) -> Result<RecoveryFile, StoreError> {
    read(Storage::Disk, file, Kind::RECOVERY, recovery_file::parse)
}

/// Removes locks of sessions that left nothing. One that is held is no such lock, nor one that
/// cannot be looked at.
fn remove_stale_locks(folder: &Path) {
    let recovery_files = files_of(folder, RECOVERY_EXTENSION).unwrap_or_default();
    for lock_file in files_of(folder, LOCK_EXTENSION).unwrap_or_default() {
        let session = session_of(&lock_file);
        let is_needed = recovery_files.iter().any(|file| session_of(file) == session);
        let Ok(handle) = File::options().write(true).open(&lock_file) else {
            continue;
        };
        if !is_needed && let Ok(Some(lock)) = Lock::take_open(handle, &lock_file) {
            let _ = fs::remove_file(lock.file());
        }
    }
}

/// The files of a folder whose names end so, in order; none where there is no folder.
fn files_of(folder: &Path, extension: &str) -> Result<Vec<PathBuf>, StoreError> {
    match files_ending(folder, extension) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Vec::new()),
        files => files.map_err(|cause| StoreError::Read {
            file: folder.to_owned(),
            expected: "a folder of recovery files",
            cause,
        }),
    }
}

fn session_of(file: &Path) -> String {
    file_name(file).split('.').next().unwrap_or_default().to_owned()
}

/// A document's name as part of a file's: letters, digits and hyphens.
fn plain_name(origin: &Origin) -> String {
    let name = match origin {
        Origin::BuiltIn(name) => (*name).to_owned(),
        Origin::File(file) => session_of(file),
    };
    let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '-' };
    name.chars().take(MAX_NAME).map(plain).collect()
}

fn remove(file: &Path) -> Result<(), StoreError> {
    match fs::remove_file(file) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(write_error(file, error)),
        _ => Ok(()),
    }
}
