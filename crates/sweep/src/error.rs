//! What can be wrong with a sweep's folder and its files.

use parquet::errors::ParquetError;
use std::io;
use std::path::{Path, PathBuf};
use trackwright_project::StoreError;
use trackwright_task::Cancelled;

/// Why a sweep, or what is read of it, fails.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    #[error(transparent)]
    Store(#[from] StoreError),
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    #[error("{}: {doing}: {cause}{}", file.display(), advice(cause))]
    Io { file: PathBuf, doing: &'static str, cause: io::Error },
    #[error("{}: found the rows of another plan, expected those of this one: a plan whose files or numbers changed needs another folder", file.display())]
    OtherPlan { file: PathBuf },
    #[error("{}: found no sweep, expected a folder that `sweep` wrote or a table that `sweep merge` wrote, whole and with its checksum", file.display())]
    NoSweep { file: PathBuf },
    #[error("{}: is damaged: its checksum is not that of its bytes", file.display())]
    Damaged { file: PathBuf },
    #[error("{}: is a file of the sweep itself, expected another name for the merged rows", file.display())]
    Own { file: PathBuf },
    #[error(
        "{what} is {found:?}, expected text without control characters: a script of the cluster contains it"
    )]
    Unquotable { what: &'static str, found: String },
    #[error("{}: is not as `sweep --submit` wrote it, expected no such file: rename or remove it", file.display())]
    OtherScript { file: PathBuf },
    #[error("part {part} of {parts} of this sweep is being computed by another worker")]
    Taken { part: u64, parts: u64 },
    #[error("{found:?} is no part, expected K/N with K from 1 to N, such as 3/8")]
    Part { found: String },
    #[error("{}: {cause}", file.display())]
    Parquet { file: PathBuf, cause: ParquetError },
    #[error("rows {from} to {} are missing; `trackwright sweep` with the same plan and folder computes them", to - 1)]
    Gap { from: u64, to: u64 },
    #[error("{} and {} both have row {row}: remove one of them", first.display(), second.display())]
    Twice { first: PathBuf, second: PathBuf, row: u64 },
    #[error(
        "sbatch cannot be started: {cause}; --submit slurm works on a machine of a Slurm cluster"
    )]
    NoCluster { cause: io::Error },
    #[error("the cluster refuses the job: {words}")]
    Refused { words: String },
    #[error("{}: found no column {name}, expected one of {known}", file.display())]
    NoColumn { file: PathBuf, name: String, known: String },
}

fn advice(cause: &io::Error) -> &'static str {
    match cause.kind() {
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
            "; the shards that are written stay, and the same command goes on from them"
        }
        _ => "",
    }
}

/// What was being done to a file when it failed.
pub(crate) fn io_error(file: &Path, doing: &'static str) -> impl FnOnce(io::Error) -> SweepError {
    move |cause| SweepError::Io { file: file.to_owned(), doing, cause }
}

pub(crate) fn parquet_error(file: &Path) -> impl FnOnce(ParquetError) -> SweepError {
    move |cause| match cause {
        // A full disk is one, whoever finds it.
        ParquetError::External(cause) => match cause.downcast::<io::Error>() {
            Ok(cause) => {
                SweepError::Io { file: file.to_owned(), doing: "cannot be written", cause: *cause }
            }
            Err(cause) => {
                SweepError::Parquet { file: file.to_owned(), cause: ParquetError::External(cause) }
            }
        },
        cause => SweepError::Parquet { file: file.to_owned(), cause },
    }
}
