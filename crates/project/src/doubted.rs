//! What was read from a table, and what is suspected of it: nobody gets the one without the other.

use super::error::StoreError;
use super::place::Place;
use super::read::read;
use std::path::{Path, PathBuf};
use trackwright_calibration::doubts::Suspicion;
use trackwright_formats::FormatError;

/// The content of a table. It is taken by saying what is to happen with suspicions.
#[derive(Clone, Debug, PartialEq)]
#[must_use]
pub struct Doubted<T> {
    content: T,
    pub file: PathBuf,
    /// Those beyond doubt first.
    pub suspicions: Vec<Suspicion>,
}

impl<T> Doubted<T> {
    pub fn new(content: T, file: &Path, mut suspicions: Vec<Suspicion>) -> Self {
        suspicions.sort_by_key(|suspicion| !suspicion.is_beyond_doubt());
        Self { content, file: file.to_owned(), suspicions }
    }

    /// The content, with each suspicion handed on.
    ///
    /// # Errors
    /// [`StoreError::Doubted`] where one is beyond doubt and the table is not meant to be as it is.
    pub fn take(
        self,
        is_meant: bool,
        mut suspected: impl FnMut(&Path, &Suspicion),
    ) -> Result<T, StoreError> {
        let certain = self.suspicions.first().filter(|s| s.is_beyond_doubt());
        if let Some(suspicion) = certain.filter(|_| !is_meant) {
            return Err(StoreError::Doubted {
                file: self.file,
                suspicion: Box::new(suspicion.clone()),
            });
        }
        for suspicion in &self.suspicions {
            suspected(&self.file, suspicion);
        }
        Ok(self.content)
    }

    /// With what the content shows beside something else.
    pub fn and(mut self, more: impl FnOnce(&T) -> Option<Suspicion>) -> Self {
        self.suspicions.extend(more(&self.content));
        self.suspicions.sort_by_key(|suspicion| !suspicion.is_beyond_doubt());
        self
    }

    /// The content, whatever is suspected.
    pub fn as_it_stands(self) -> T {
        self.content
    }
}

/// Reads a file and parses it; see [`read`].
pub(super) fn read_doubted<T>(
    file: &Path,
    expected: &'static str,
    parse: impl FnOnce(&[u8]) -> Result<T, FormatError>,
    doubts: impl FnOnce(&T) -> Vec<Suspicion>,
) -> Result<Doubted<T>, StoreError> {
    let content = read(Place::Disk, file, expected, parse)?;
    let suspicions = doubts(&content);
    Ok(Doubted::new(content, file, suspicions))
}
