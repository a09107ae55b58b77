//! How far a sweep is.

use super::error::SweepError;
use super::folder::Folder;
use super::slurm;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

/// Which rows of a sweep's folder are there, and what a cluster is doing about the others.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Status {
    /// Rows of the plan.
    pub rows: u64,
    pub rows_there: u64,
    pub shards: usize,
    /// Files that were cut short.
    pub torn: usize,
    pub missing: Vec<Range<u64>>,
    /// Tasks of Slurm that wait or run, by their state.
    pub tasks: BTreeMap<String, usize>,
}

/// Reads where a folder stands.
///
/// # Errors
/// A folder that is none of a sweep, files that cannot be read.
pub fn status(folder: &Path) -> Result<Status, SweepError> {
    let (sweep, folder) = Folder::existing(folder)?;
    let coverage = folder.coverage()?;
    let mut tasks = BTreeMap::new();
    for (_, state) in slurm::queue(&folder)?.tasks {
        *tasks.entry(state).or_default() += 1;
    }
    Ok(Status {
        rows: sweep.rows(),
        rows_there: coverage.rows(),
        shards: coverage.shards.len(),
        torn: coverage.torn.len(),
        missing: coverage.missing(0..sweep.rows()),
        tasks,
    })
}
