//! Computes the rows of a part that are missing, shard after shard.

use super::error::SweepError;
use super::folder::{Folder, Part};
use super::shard::ShardWriter;
use super::status::rows_there;
use super::sweep::{Row, Sweep};
use rayon::prelude::*;
use std::ops::Range;
use std::time::{Duration, Instant};
use trackwright_result::{Section, count, data, number};
use trackwright_task::{Cancelled, Task};

/// How long the threads compute before they wait for each other: long beside the wait, short beside a
/// shard.
const BATCH: Duration = Duration::from_millis(400);

/// Most rows of a batch: they are in memory together.
const MOST_IN_BATCH: u64 = 1 << 14;

/// What a worker did.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RunReport {
    /// Rows of the part that were there.
    pub kept: u64,
    /// Rows that were computed and written.
    pub computed: u64,
    /// Rows that were computed without figures.
    pub problems: u64,
    /// Rows that another worker had written meanwhile.
    pub dropped: u64,
    pub shards: u64,
    /// Files that were damaged or cut short, and are made anew.
    pub torn: u64,
    /// Rows that the folder has now, of all parts, by the names of its files.
    pub rows_there: u64,
    /// Rows of the plan.
    pub rows: u64,
}

impl RunReport {
    /// What was done in so many seconds.
    pub fn section(&self, seconds: Option<f64>) -> Section {
        let of = |key, label, rows: u64| count(key, label, rows as usize);
        let speed = seconds.map(|seconds| self.computed as f64 / seconds);
        Section::of([
            of("computed", "rows computed", self.computed),
            of("kept", "rows kept", self.kept),
            of("shards", "shards written", self.shards),
            of("problems", "rows without figures", self.problems).shown_if(self.problems > 0),
            of("dropped", "rows that another worker had written", self.dropped)
                .shown_if(self.dropped > 0),
            number("", "rows a second", speed, 1, "").shown_if(self.computed > 0),
            rows_there(self.rows_there, self.rows),
            data("rows_there", self.rows_there),
            data("rows", self.rows),
            data("torn", self.torn),
        ])
        .with_all(seconds.map(|seconds| data("seconds", seconds)))
    }
}

/// Computes what is missing of a part. `note` gets what a person has to know.
///
/// Where the task is cancelled the rows that are computed by then are written before it returns.
///
/// # Errors
/// See [`SweepError`]; what was written stays.
pub fn run(
    sweep: &Sweep,
    folder: &Folder,
    part: Part,
    task: &Task,
    note: &dyn Fn(&str),
) -> Result<RunReport, SweepError> {
    let _held = folder.hold(part)?;
    folder.remove_leftovers(Some(part))?;
    let range = part.rows(sweep.rows());
    let coverage = folder.coverage_of(&range)?;
    let mut report = RunReport { rows: sweep.rows(), ..RunReport::default() };
    for file in &coverage.torn {
        note(&format!("{}: is damaged or cut short, and is made anew", file.display()));
        folder.remove_torn(file)?;
        report.torn += 1;
    }
    let missing = coverage.missing(range.clone());
    let all = range.end - range.start;
    report.kept = all - missing.iter().map(|rows| rows.end - rows.start).sum::<u64>();
    let mut worker = Worker { sweep, folder, part, task, all, report, batch: 1 };
    for rows in missing {
        worker.compute(rows)?;
    }
    let rows_there = folder.named_rows()?;
    Ok(RunReport { rows_there, ..worker.report })
}

struct Worker<'a> {
    sweep: &'a Sweep,
    folder: &'a Folder,
    part: Part,
    task: &'a Task,
    /// Rows of the part.
    all: u64,
    report: RunReport,
    /// Rows that take about [`BATCH`].
    batch: u64,
}

impl Worker<'_> {
    fn compute(&mut self, rows: Range<u64>) -> Result<(), SweepError> {
        let seconds = Duration::from_secs_f64(self.sweep.plan().shard_seconds);
        let mut at = rows.start;
        while at < rows.end {
            let started = Instant::now();
            let mut shard = ShardWriter::new(self.sweep, self.folder, self.part, at)?;
            let mut problems = 0;
            let mut stopped = Ok(());
            while at < rows.end && started.elapsed() < seconds {
                if self.task.cancel.is_cancelled() {
                    stopped = Err(Cancelled);
                    break;
                }
                let waiting = shard.rows().end - shard.rows().start;
                match self.rows(at..rows.end.min(at + self.batch), waiting) {
                    Ok(found) => {
                        problems += found.iter().filter(|row| row.study.is_err()).count() as u64;
                        shard.add(&found)?;
                        at += found.len() as u64;
                    }
                    Err(cancelled) => {
                        stopped = Err(cancelled);
                        break;
                    }
                }
            }
            let count = shard.rows().end - shard.rows().start;
            if count > 0 {
                match shard.finish()? {
                    true => {
                        self.report.computed += count;
                        self.report.problems += problems;
                        self.report.shards += 1;
                    }
                    false => self.report.dropped += count,
                }
            }
            stopped?;
        }
        Ok(())
    }

    /// Rows, each on one core. So many are waiting for their shard to be whole.
    fn rows(&mut self, rows: Range<u64>, waiting: u64) -> Result<Vec<Row>, Cancelled> {
        let count = rows.end - rows.start;
        let started = Instant::now();
        let cancel = &self.task.cancel;
        let found: Result<Vec<Row>, Cancelled> =
            rows.clone().into_par_iter().map(|row| self.sweep.row(row, cancel)).collect();
        let found = found?;
        let RunReport { kept, computed, dropped, .. } = self.report;
        let done = kept + computed + dropped + waiting + count;
        // A task that is cancelled here keeps these rows, and stops before the next ones.
        let _ = self.task.step(done.min(self.all) as usize, self.all as usize);
        let part = BATCH.as_secs_f64() / started.elapsed().as_secs_f64().max(1e-6);
        let fitting = (count as f64 * part) as u64;
        self.batch = fitting.clamp(1, 2 * self.batch.max(count)).min(MOST_IN_BATCH);
        Ok(found)
    }
}
