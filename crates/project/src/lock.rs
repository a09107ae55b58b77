//! Locks between processes, which the system lets go of however their holder ends.

use super::error::StoreError;
use super::file_id::is_still;
use std::fs::{File, OpenOptions, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

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

    /// Locks a file that is going to be replaced by another of its name, once whoever else replaces it
    /// is done; `None` where there is no such file.
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
