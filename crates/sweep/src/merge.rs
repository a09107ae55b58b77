//! All rows of a sweep in one file, in order.

use super::error::{SweepError, io_error, parquet_error};
use super::folder::{Coverage, Folder};
use super::shard::{Footer, GROUP_ROWS, footer, properties};
use super::sweep::Sweep;
use super::table::schema;
use arrow_array::RecordBatch;
use arrow_select::concat::concat_batches;
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use std::fs::File;
use std::io::Seek;
use std::path::Path;
use trackwright_formats::sweep_plan;
use trackwright_project::Output;
use trackwright_result::{Section, data, with_separators};
use trackwright_task::Task;

/// Rows that are written at once. A file's pages depend on it: it is the same however the shards are cut.
const STEP: usize = 1 << 12;

/// What was merged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MergeReport {
    pub rows: u64,
    pub shards: usize,
    pub bytes: u64,
}

impl MergeReport {
    /// What was merged into a file.
    pub fn section(&self, file: &Path) -> Section {
        let line = format!(
            "{}: {} rows of {} shards, {:.1} bytes a row",
            file.display(),
            with_separators(self.rows as usize),
            with_separators(self.shards),
            self.bytes as f64 / self.rows.max(1) as f64
        );
        Section::of([
            data("rows", self.rows),
            data("shards", self.shards),
            data("bytes", self.bytes),
        ])
        .with(line)
    }
}

/// Writes all rows of a folder to one file, whose bytes do not depend on how the rows were sharded.
///
/// # Errors
/// A file of the sweep itself, or one that may not be replaced; rows that are missing or there twice, a shard of another plan, and what the disk
/// reports; nothing is written then.
pub fn merge(
    sweep: &Sweep,
    folder: &Folder,
    output: &Output<'_>,
    task: &Task,
) -> Result<MergeReport, SweepError> {
    let file = output.file();
    folder.expect_not_own(file)?;
    match is_merge_of(sweep, file) {
        true => output.is_written(),
        false => output.expect_own()?,
    }
    let coverage = folder.coverage()?;
    check(&coverage, sweep.rows())?;
    // Without a name nothing of it is left, however the process ends.
    let mut draft = tempfile::tempfile_in(folder.path())
        .map_err(io_error(folder.path(), "cannot be written to"))?;
    let schema = schema(sweep.plan());
    let handle = draft.try_clone().map_err(io_error(file, "cannot be opened"))?;
    let mut writer = ArrowWriter::try_new(handle, schema.clone(), Some(properties(&schema)))
        .map_err(parquet_error(file))?;
    let mut waiting: Option<RecordBatch> = None;
    let mut done = 0_u64;
    for (rows, shard) in &coverage.shards {
        let opened = File::open(shard).map_err(io_error(shard, "cannot be opened"))?;
        let reader = ParquetRecordBatchReaderBuilder::try_new(opened)
            .and_then(|builder| builder.with_batch_size(GROUP_ROWS).build())
            .map_err(parquet_error(shard))?;
        for read in reader {
            let read = read.map_err(|cause| parquet_error(shard)(cause.into()))?;
            // Readers give columns their metadata back in another order.
            let read = RecordBatch::try_new(schema.clone(), read.columns().to_vec())
                .map_err(|cause| parquet_error(shard)(cause.into()))?;
            let whole = match waiting.take() {
                None => read,
                Some(before) => concat_batches(&schema, [&before, &read])
                    .map_err(|cause| parquet_error(shard)(cause.into()))?,
            };
            let mut at = 0;
            while whole.num_rows() - at >= STEP {
                writer.write(&whole.slice(at, STEP)).map_err(parquet_error(file))?;
                at += STEP;
            }
            waiting = Some(whole.slice(at, whole.num_rows() - at));
        }
        done += rows.end - rows.start;
        task.step(done as usize, sweep.rows() as usize)?;
    }
    if let Some(rest) = waiting.filter(|rest| rest.num_rows() > 0) {
        writer.write(&rest).map_err(parquet_error(file))?;
    }
    let footer = Footer {
        hash: sweep.hash().to_owned(),
        rows: 0..sweep.rows(),
        plan: sweep_plan::write(sweep.plan()),
        all: sweep.rows(),
    };
    footer.finish(writer, &schema, file, &mut draft)?;
    let bytes = draft.metadata().map_err(io_error(file, "cannot be read"))?.len();
    output.write(|out| {
        draft.rewind()?;
        std::io::copy(&mut draft, out).map(drop)
    })?;
    folder.remove_leftovers(None)?;
    Ok(MergeReport { rows: sweep.rows(), shards: coverage.shards.len(), bytes })
}

/// Whether a file has the merged rows of this sweep, and nothing else: it may be written over.
pub fn is_merge_of(sweep: &Sweep, file: &Path) -> bool {
    // Opening a pipe would wait for whoever writes to it.
    file.is_file()
        && footer(file)
            .is_ok_and(|found| found.hash == sweep.hash() && found.rows == (0..sweep.rows()))
}

/// Whether every row is there once.
fn check(coverage: &Coverage, all: u64) -> Result<(), SweepError> {
    for pair in coverage.shards.windows(2) {
        let [(first_rows, first), (second_rows, second)] = pair else {
            continue;
        };
        if second_rows.start < first_rows.end {
            return Err(SweepError::Twice {
                first: first.clone(),
                second: second.clone(),
                row: second_rows.start,
            });
        }
    }
    match coverage.missing(0..all).into_iter().next() {
        Some(gap) => match coverage.torn.first() {
            Some(file) => Err(SweepError::Damaged { file: file.clone() }),
            None => Err(SweepError::Gap { from: gap.start, to: gap.end }),
        },
        None => Ok(()),
    }
}
