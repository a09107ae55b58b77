//! How far a sweep is.

use super::error::SweepError;
use super::folder::Folder;
use super::slurm;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;
use trackwright_result::{Row, Section, count, data, text, with_separators};

/// Which rows of a sweep's folder are there, and what a cluster is doing about the others.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Status {
    /// Rows of the plan.
    pub rows: u64,
    pub rows_there: u64,
    pub shards: usize,
    /// Files that are damaged or cut short.
    pub torn: usize,
    pub missing: Vec<Range<u64>>,
    /// Tasks of Slurm that wait or run, by their state.
    pub tasks: BTreeMap<String, usize>,
}

impl Status {
    /// Which rows are there.
    pub fn section(&self) -> Section {
        let rows = |count: u64| with_separators(count as usize);
        let missing: Vec<[u64; 2]> = self.missing.iter().map(|gap| [gap.start, gap.end]).collect();
        let gap = missing.first().map(|[from, to]| format!("{} to {}", rows(*from), rows(to - 1)));
        let tasks = self
            .tasks
            .iter()
            .map(|(state, tasks)| count("", format!("tasks {}", state.to_lowercase()), *tasks));
        Section::of([
            rows_there(self.rows_there, self.rows),
            data("rows_there", self.rows_there),
            data("rows", self.rows),
            count("shards", "shards", self.shards),
            count("torn", "files damaged or cut short", self.torn).shown_if(self.torn > 0),
            text("", "first missing rows", gap.unwrap_or_default()).shown_if(!missing.is_empty()),
            data("missing", missing),
            data("slurm", &self.tasks),
        ])
        .with_all(tasks)
    }
}

/// How many rows there are, for people.
pub(super) fn rows_there(there: u64, all: u64) -> Row {
    let [there, all] = [there, all].map(|rows| with_separators(rows as usize));
    text("", "rows there", format!("{there} of {all}"))
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
