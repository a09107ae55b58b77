//! A sweep's folder: which rows are there, which are missing, and who computes which.
//!
//! ```text
//! plan.sweep.ron                       the plan, with the folder that its files are relative to
//! rows-000000000000-000000004096.parquet  a shard: rows from the first number to below the second
//! locks/part-3-of-8                    held by the worker that computes that part
//! locks/commit                         held while a shard gets its name, a part is taken, or files are removed
//! ```

use super::error::{SweepError, io_error};
use super::shard::{self, Footer};
use super::sweep::Sweep;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::ErrorKind;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use trackwright_formats::sweep_plan;

const PLAN: &str = "plan.sweep.ron";
const LOCKS: &str = "locks";

/// What the names of plans begin with while they are written.
const PLAN_DRAFT: &str = ".plan-";

/// What a cluster gets is in this one.
pub(crate) const SLURM: &str = "slurm";

/// Whether a file is the plan that `sweep` wrote into a folder.
pub(crate) fn is_plan_of(file: &Path, folder: &Path) -> bool {
    file == Folder::plan_of(folder)
}

/// One of the equal parts that a sweep's rows are computed in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// From 1.
    pub number: u64,
    pub of: u64,
}

impl Part {
    pub const WHOLE: Self = Self { number: 1, of: 1 };

    /// Its rows, of so many.
    pub fn rows(self, all: u64) -> Range<u64> {
        let end = |parts: u64| (u128::from(all) * u128::from(parts) / u128::from(self.of)) as u64;
        end(self.number - 1)..end(self.number)
    }
}

impl FromStr for Part {
    type Err = SweepError;

    fn from_str(text: &str) -> Result<Self, SweepError> {
        let read = || {
            let (number, of) = text.split_once('/')?;
            let part = Self { number: number.trim().parse().ok()?, of: of.trim().parse().ok()? };
            (1..=part.of).contains(&part.number).then_some(part)
        };
        read().ok_or_else(|| SweepError::Part { found: text.to_owned() })
    }
}

/// A folder that a sweep's shards are in.
#[derive(Clone, Debug)]
pub struct Folder {
    path: PathBuf,
    hash: String,
}

/// Which rows of a sweep are there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Coverage {
    /// The shards, by their first row.
    pub shards: Vec<(Range<u64>, PathBuf)>,
    /// Files of the folder with the name of a shard that are none: damaged, or cut short.
    pub torn: Vec<PathBuf>,
}

impl Coverage {
    /// Rows that are there.
    pub fn rows(&self) -> u64 {
        self.shards.iter().map(|(rows, _)| rows.end - rows.start).sum()
    }

    /// The rows of a range that are missing.
    pub fn missing(&self, range: Range<u64>) -> Vec<Range<u64>> {
        let mut missing = Vec::new();
        let mut at = range.start;
        for (rows, _) in &self.shards {
            if rows.end <= at {
                continue;
            }
            if rows.start >= range.end {
                break;
            }
            if rows.start > at {
                missing.push(at..rows.start);
            }
            at = rows.end;
        }
        if at < range.end {
            missing.push(at..range.end);
        }
        missing
    }
}

impl Folder {
    /// Opens a folder for a sweep; makes it where it is not there.
    ///
    /// # Errors
    /// [`SweepError::OtherPlan`] where it has the rows of another plan, and what the disk reports.
    pub fn open(path: &Path, sweep: &Sweep) -> Result<Self, SweepError> {
        let locks = path.join(LOCKS);
        fs::create_dir_all(&locks).map_err(io_error(&locks, "cannot be made"))?;
        let folder = Self { path: path.to_owned(), hash: sweep.hash().to_owned() };
        // One shard is enough here: whoever uses the rows reads them all.
        let whole = folder.named_shards()?.into_iter().find_map(|(_, file)| {
            let footer = shard::footer(&file).ok()?;
            Some((footer.hash, file))
        });
        if let Some((_, file)) = whole.filter(|(hash, _)| *hash != folder.hash) {
            return Err(SweepError::OtherPlan { file });
        }
        let plan = path.join(PLAN);
        let text = sweep_plan::write(sweep.plan());
        let _commit = folder.lock_commit()?;
        // Without a row the plan may be another one by now.
        let is_there = fs::read(&plan).is_ok_and(|found| found == text.as_bytes());
        if !is_there && (!plan.exists() || folder.named_shards()?.is_empty()) {
            let mut draft = new_file(path, PLAN_DRAFT)?;
            std::io::Write::write_all(&mut draft, text.as_bytes())
                .map_err(io_error(&plan, "cannot be written"))?;
            draft
                .persist(&plan)
                .map_err(|error| io_error(&plan, "cannot be written")(error.error))?;
        }
        Ok(folder)
    }

    /// Opens a folder that `sweep` wrote, with the sweep that it is of.
    ///
    /// # Errors
    /// [`SweepError::NoSweep`] for any other folder, and as [`open`](Self::open).
    pub fn existing(path: &Path) -> Result<(Sweep, Self), SweepError> {
        if !path.join(LOCKS).is_dir() {
            return Err(SweepError::NoSweep { file: path.to_owned() });
        }
        let sweep = Sweep::open(&path.join(PLAN))?;
        let folder = Self::open(path, &sweep)?;
        Ok((sweep, folder))
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The plan that a folder is of.
    pub fn plan_of(path: &Path) -> PathBuf {
        path.join(PLAN)
    }

    /// Which rows are there, as far as files that are whole have them.
    ///
    /// # Errors
    /// What the disk reports; a shard of another plan.
    pub fn coverage(&self) -> Result<Coverage, SweepError> {
        self.coverage_of(&(0..u64::MAX))
    }

    /// The same of the files with any rows of a range: each is read whole.
    pub(crate) fn coverage_of(&self, range: &Range<u64>) -> Result<Coverage, SweepError> {
        let mut coverage = Coverage { shards: Vec::new(), torn: Vec::new() };
        let shards = self.named_shards()?.into_iter();
        let has_any = |rows: &Range<u64>| rows.start < range.end && range.start < rows.end;
        for (rows, file) in shards.filter(|(rows, _)| has_any(rows)) {
            match shard::footer(&file) {
                Ok(Footer { hash, .. }) if hash != self.hash => {
                    return Err(SweepError::OtherPlan { file });
                }
                Ok(footer) if footer.rows == rows => coverage.shards.push((rows, file)),
                // What cannot be read may be whole.
                Err(SweepError::Io { cause, doing, .. }) if cause.kind() != ErrorKind::NotFound => {
                    return Err(SweepError::Io { file, doing, cause });
                }
                _ => coverage.torn.push(file),
            }
        }
        Ok(coverage)
    }

    /// Holds a part until what is returned is dropped, or the process ends however it may.
    ///
    /// # Errors
    /// [`SweepError::Taken`] where another worker holds it.
    pub fn hold(&self, part: Part) -> Result<File, SweepError> {
        let _commit = self.lock_commit()?;
        self.try_hold(part)?.ok_or(SweepError::Taken { part: part.number, parts: part.of })
    }

    /// `None` where another worker holds the part. Whoever calls this has the lock `commit`, so that nobody
    /// finds a part held that is only looked at.
    fn try_hold(&self, part: Part) -> Result<Option<File>, SweepError> {
        let file = self.path.join(LOCKS).join(format!("part-{}-of-{}", part.number, part.of));
        let handle = open_lock(&file)?;
        match handle.try_lock() {
            Ok(()) => Ok(Some(handle)),
            Err(TryLockError::WouldBlock) => Ok(None),
            Err(TryLockError::Error(cause)) => Err(io_error(&file, "cannot be locked")(cause)),
        }
    }

    fn lock_commit(&self) -> Result<File, SweepError> {
        let file = self.path.join(LOCKS).join("commit");
        let lock = open_lock(&file)?;
        lock.lock().map_err(io_error(&file, "cannot be locked"))?;
        Ok(lock)
    }

    /// Removes what workers left that have ended: drafts of parts that nobody holds, but for who calls this.
    pub(crate) fn remove_leftovers(&self, held: Option<Part>) -> Result<(), SweepError> {
        let _commit = self.lock_commit()?;
        for entry in fs::read_dir(&self.path).map_err(io_error(&self.path, "cannot be read"))? {
            let entry = entry.map_err(io_error(&self.path, "cannot be read"))?;
            let name = entry.file_name();
            let name = name.to_string_lossy();
            // Plans are written under this lock.
            if name.starts_with(PLAN_DRAFT) && name.ends_with(".tmp") {
                remove(&entry.path())?;
            }
            let Some(part) = part_of_draft(&name) else {
                continue;
            };
            // Held until the draft is removed.
            let free = self.try_hold(part)?;
            if free.is_some() || held == Some(part) {
                remove(&entry.path())?;
            }
        }
        Ok(())
    }

    /// Removes a file with the name of a shard, if it is none: another worker may have made it anew.
    pub(crate) fn remove_torn(&self, file: &Path) -> Result<(), SweepError> {
        let _commit = self.lock_commit()?;
        let named = rows_of(&file.file_name().unwrap_or_default().to_string_lossy());
        match shard::footer(file) {
            Ok(footer) if named == Some(footer.rows.clone()) => Ok(()),
            Err(error @ SweepError::Io { .. }) if file.exists() => Err(error),
            _ => remove(file),
        }
    }

    /// Whether merged rows may be written to a file: to no plan or shard, of whatever sweep, and to nothing
    /// in this one's own folders.
    pub(crate) fn expect_not_own(&self, file: &Path) -> Result<(), SweepError> {
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        let parent = file.parent().filter(|parent| !parent.as_os_str().is_empty());
        let place = |path: &Path| fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        let parent = place(parent.unwrap_or(Path::new(".")));
        let own = [LOCKS, SLURM].map(|name| place(&self.path).join(name));
        let is_own = own.iter().any(|folder| parent.starts_with(folder));
        let is_plan = name.ends_with(".sweep.ron");
        match is_own || is_plan || rows_of(&name).is_some() || part_of_draft(&name).is_some() {
            true => Err(SweepError::Own { file: file.to_owned() }),
            false => Ok(()),
        }
    }

    /// A new file for the rows of a part that has no shard's name yet.
    pub(crate) fn draft(&self, part: Part) -> Result<tempfile::NamedTempFile, SweepError> {
        new_file(&self.path, &draft_prefix(part))
    }

    /// Gives a whole file the name of its rows; whether it did: not where another worker was first with any
    /// of them.
    pub(crate) fn commit(
        &self,
        draft: tempfile::NamedTempFile,
        rows: &Range<u64>,
    ) -> Result<bool, SweepError> {
        let file = self.path.join(name_of(rows));
        let _commit = self.lock_commit()?;
        let is_overlapping =
            |(other, _): &(Range<u64>, PathBuf)| other.start < rows.end && rows.start < other.end;
        if self.named_shards()?.iter().any(is_overlapping) {
            return Ok(false);
        }
        let handle = draft
            .persist_noclobber(&file)
            .map_err(|error| io_error(&file, "cannot be written")(error.error))?;
        handle.sync_all().map_err(io_error(&file, "cannot be written"))?;
        // The name too is on the disk before anyone relies on it.
        let folder = File::open(&self.path).and_then(|folder| folder.sync_all());
        folder.map_err(io_error(&self.path, "cannot be written to"))?;
        Ok(true)
    }

    /// Rows that are there by the names of files, which are not read.
    pub(crate) fn named_rows(&self) -> Result<u64, SweepError> {
        Ok(self.named_shards()?.into_iter().map(|(rows, _)| rows.end - rows.start).sum())
    }

    /// The files with the names of shards, by their first row.
    fn named_shards(&self) -> Result<Vec<(Range<u64>, PathBuf)>, SweepError> {
        named_shards(&self.path)
    }
}

/// The files of a folder with the names of shards, by their first row.
pub(crate) fn named_shards(path: &Path) -> Result<Vec<(Range<u64>, PathBuf)>, SweepError> {
    let mut found = Vec::new();
    for entry in fs::read_dir(path).map_err(io_error(path, "cannot be read"))? {
        let entry = entry.map_err(io_error(path, "cannot be read"))?;
        if let Some(rows) = rows_of(&entry.file_name().to_string_lossy()) {
            found.push((rows, entry.path()));
        }
    }
    found.sort_by_key(|(rows, _)| (rows.start, rows.end));
    Ok(found)
}

fn draft_prefix(part: Part) -> String {
    format!(".part-{}-of-{}-", part.number, part.of)
}

/// The part that a file without a shard's name is of.
fn part_of_draft(name: &str) -> Option<Part> {
    let (number, rest) = name.strip_prefix(".part-")?.strip_suffix(".tmp")?.split_once("-of-")?;
    let of = rest.split_once('-')?.0;
    format!("{number}/{of}").parse().ok()
}

/// Removes a file that may have been removed meanwhile.
fn remove(file: &Path) -> Result<(), SweepError> {
    match fs::remove_file(file) {
        Err(cause) if cause.kind() != ErrorKind::NotFound => {
            Err(io_error(file, "cannot be removed")(cause))
        }
        _ => Ok(()),
    }
}

/// A file without its final name, which is removed where it gets none. Others may read it, as far as the user
/// lets them read new files.
pub(crate) fn new_file(folder: &Path, prefix: &str) -> Result<tempfile::NamedTempFile, SweepError> {
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let made = builder.prefix(prefix).suffix(".tmp").tempfile_in(folder);
    made.map_err(io_error(folder, "cannot be written to"))
}

fn open_lock(file: &Path) -> Result<File, SweepError> {
    let opened = OpenOptions::new().create(true).truncate(false).write(true).open(file);
    opened.map_err(io_error(file, "cannot be opened"))
}

fn name_of(rows: &Range<u64>) -> String {
    format!("rows-{:012}-{:012}.parquet", rows.start, rows.end)
}

fn rows_of(name: &str) -> Option<Range<u64>> {
    let (start, end) = name.strip_prefix("rows-")?.strip_suffix(".parquet")?.split_once('-')?;
    let rows = start.parse().ok()?..end.parse().ok()?;
    (rows.start < rows.end && name == name_of(&rows)).then_some(rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_have_every_row_once() {
        for (all, of) in [(0, 3), (1, 3), (10, 3), (7, 64), (1_000_000_000, 7)] {
            let mut at = 0;
            for number in 1..=of {
                let rows = Part { number, of }.rows(all);
                assert_eq!(rows.start, at);
                assert!(rows.end - rows.start <= all / of + 1);
                at = rows.end;
            }
            assert_eq!(at, all);
        }
        for text in ["", "0/3", "4/3", "a/b", "1", "1/0", "-1/3"] {
            assert!(text.parse::<Part>().is_err(), "{text}");
        }
        assert_eq!("3/8".parse::<Part>().unwrap(), Part { number: 3, of: 8 });
    }

    #[test]
    fn missing_rows_are_those_of_no_shard() {
        let shard = |rows: Range<u64>| (rows, PathBuf::new());
        let coverage =
            Coverage { shards: vec![shard(2..5), shard(5..6), shard(9..12)], torn: vec![] };
        let missing = |rows| {
            let ranges = coverage.missing(rows);
            ranges.iter().map(|gap| [gap.start, gap.end]).collect::<Vec<_>>()
        };
        assert_eq!(missing(0..12), [[0, 2], [6, 9]]);
        assert_eq!(missing(3..10), [[6, 9]]);
        assert_eq!(missing(10..20), [[12, 20]]);
        assert!(missing(2..6).is_empty());
        assert_eq!(coverage.rows(), 7);
    }

    #[test]
    fn names_of_shards_read_back() {
        let name = name_of(&(5..70));
        assert_eq!(rows_of(&name), Some(5..70));
        for other in
            ["rows-5-70.parquet", "rows-000000000070-000000000005.parquet", "rows.parquet", ""]
        {
            assert_eq!(rows_of(other), None, "{other}");
        }
    }
}
