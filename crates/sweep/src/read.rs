//! Reads a sweep's rows, column by column as they are needed.

use super::error::{SweepError, io_error, parquet_error};
use super::folder::{is_plan_of, named_shards};
use super::shard::{Footer, footer};
use super::table::{COUNTS, DESIGN, MOTION, PROBLEM, ROOM, ROW, UNIT, about};
use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, UInt64Type};
use arrow_array::{Array, ArrayRef, RecordBatch};
use arrow_schema::{DataType, SchemaRef};
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::{
    ArrowReaderMetadata, ArrowReaderOptions, ParquetRecordBatchReaderBuilder, RowSelection,
};
use parquet::file::metadata::PageIndexPolicy;
use std::fs::File;
use std::ops::Range;
use std::path::{Path, PathBuf};
use trackwright_task::{CancelToken, Cancelled};

/// The rows of a merged file or of a folder's shards.
#[derive(Clone, Debug)]
pub struct SweepTable {
    path: PathBuf,
    files: Vec<TableFile>,
    schema: SchemaRef,
    plan: String,
    hash: String,
    planned: u64,
}

#[derive(Clone, Debug)]
struct TableFile {
    path: PathBuf,
    rows: u64,
    metadata: ArrowReaderMetadata,
}

/// A column's name, and the unit of its numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    pub name: String,
    /// Nothing of what has none.
    pub unit: String,
    /// What it holds; nothing where the name is enough.
    pub about: &'static str,
    /// Whether it holds numbers.
    pub is_number: bool,
    /// Whether it holds texts; neither, where it holds yes and no.
    pub is_text: bool,
}

/// What a row has in a column.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    Nothing,
    Number(f64),
    Text(String),
}

impl SweepTable {
    /// The files that the rows are in.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.files.iter().map(|file| file.path.as_path())
    }

    /// Opens a folder of shards, by itself or by the plan's file in it, or a merged file; reads no row
    /// yet.
    ///
    /// # Errors
    /// Files that are cut short or are none of a sweep, and shards of several plans.
    pub fn open(path: &Path) -> Result<Self, SweepError> {
        let folder = match path.parent() {
            Some(folder) if is_plan_of(path, folder) => match folder.as_os_str().is_empty() {
                true => Path::new("."),
                false => folder,
            },
            _ => path,
        };
        let files = match folder.is_dir() {
            true => named_shards(folder)?.into_iter().map(|(_, file)| file).collect(),
            false => vec![path.to_owned()],
        };
        let mut opened = Vec::with_capacity(files.len());
        let mut first: Option<Footer> = None;
        for file in files {
            let found = footer(&file)?;
            match &first {
                Some(first) if first.hash != found.hash => {
                    return Err(SweepError::OtherPlan { file });
                }
                Some(_) => {}
                None => first = Some(found),
            }
            let handle = File::open(&file).map_err(io_error(&file, "cannot be opened"))?;
            // Where pages begin: a few rows are then read without those before them.
            let options =
                ArrowReaderOptions::new().with_offset_index_policy(PageIndexPolicy::Optional);
            let metadata =
                ArrowReaderMetadata::load(&handle, options).map_err(parquet_error(&file))?;
            let rows =
                metadata.metadata().file_metadata().num_rows().try_into().unwrap_or_default();
            opened.push(TableFile { path: file, rows, metadata });
        }
        let (Some(first), Some(file)) = (first, opened.first()) else {
            return Err(SweepError::NoSweep { file: path.to_owned() });
        };
        let schema = file.metadata.schema().clone();
        Ok(Self {
            path: folder.to_owned(),
            files: opened,
            schema,
            plan: first.plan,
            hash: first.hash,
            planned: first.all,
        })
    }

    /// The folder of the shards, or the merged file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Number of rows.
    pub fn rows(&self) -> u64 {
        self.files.iter().map(|file| file.rows).sum()
    }

    /// Number of rows of the whole sweep, of which some may be missing.
    pub fn planned(&self) -> u64 {
        self.planned
    }

    /// The plan, as a file with absolute paths.
    pub fn plan(&self) -> &str {
        &self.plan
    }

    /// Of the plan that the rows are of.
    pub fn hash(&self) -> &str {
        &self.hash
    }

    /// All columns, in order.
    pub fn columns(&self) -> Vec<Column> {
        let fields = self.schema.fields().iter();
        fields
            .map(|field| Column {
                name: field.name().clone(),
                unit: field.metadata().get(UNIT).cloned().unwrap_or_default(),
                about: about(field.name()),
                is_number: matches!(field.data_type(), DataType::Float64 | DataType::UInt64),
                is_text: *field.data_type() == DataType::Utf8,
            })
            .collect()
    }

    /// All columns as a person compares rows: the row's number, its figures, the numbers that vary, then what
    /// it is of.
    pub fn columns_to_compare(&self) -> Vec<Column> {
        let varied = self.parameters();
        let rank = |column: &Column| match column.name.as_str() {
            ROW => 0,
            DESIGN | ROOM | MOTION => 3,
            PROBLEM => 5,
            name if COUNTS.contains(&name) => 4,
            _ if varied.contains(&column.name) => 2,
            _ => 1,
        };
        let mut columns = self.columns();
        columns.sort_by_key(rank);
        columns
    }

    /// The columns of the numbers that vary: those between the motion's and the counts'.
    pub fn parameters(&self) -> Vec<String> {
        let names = self.schema.fields().iter().map(|field| field.name());
        let behind = names.skip_while(|name| *name != MOTION).skip(1);
        behind.take_while(|name| *name != COUNTS[0]).cloned().collect()
    }

    /// A column's numbers, NaN where there is none.
    ///
    /// # Errors
    /// A column that is not there or holds no numbers, and what the disk reports.
    pub fn numbers(&self, name: &str) -> Result<Vec<f64>, SweepError> {
        self.numbers_until(name, &CancelToken::default())
    }

    pub(crate) fn numbers_until(
        &self,
        name: &str,
        cancel: &CancelToken,
    ) -> Result<Vec<f64>, SweepError> {
        let all = 0..self.rows();
        let mut numbers = Vec::with_capacity(all.end as usize);
        self.read(&[name], std::slice::from_ref(&all), cancel, &mut |batch| {
            append_numbers(batch.column(0), &mut numbers);
        })?;
        Ok(numbers)
    }

    /// A column's texts; nothing of a column that holds others.
    pub(crate) fn texts_until(
        &self,
        name: &str,
        cancel: &CancelToken,
    ) -> Result<Vec<String>, SweepError> {
        let all = 0..self.rows();
        let mut texts = Vec::new();
        self.read(&[name], std::slice::from_ref(&all), cancel, &mut |batch| {
            append_texts(batch.column(0), &mut texts);
        })?;
        Ok(texts)
    }

    /// Some rows as texts, a column each: what a table shows of them.
    ///
    /// # Errors
    /// As [`numbers`](Self::numbers).
    pub fn texts(&self, names: &[&str], rows: Range<u64>) -> Result<Vec<Vec<String>>, SweepError> {
        let mut columns = vec![Vec::new(); names.len()];
        let cancel = CancelToken::default();
        self.read(names, std::slice::from_ref(&rows), &cancel, &mut |batch| {
            for (k, name) in names.iter().enumerate() {
                if let Some(column) = batch.column_by_name(name) {
                    append_texts(column, &mut columns[k]);
                }
            }
        })?;
        Ok(columns)
    }

    /// The cells of some columns of rows at any places of the table, a column each; the rows are in the
    /// order in which they are wanted. Only the pages that hold them are read.
    ///
    /// # Errors
    /// As [`numbers`](Self::numbers), and where it is cancelled.
    pub fn cells(
        &self,
        names: &[&str],
        rows: &[u64],
        cancel: &CancelToken,
    ) -> Result<Vec<Vec<Cell>>, SweepError> {
        let mut ascending = rows.to_vec();
        ascending.sort_unstable();
        ascending.dedup();
        let mut ranges: Vec<Range<u64>> = Vec::new();
        for row in &ascending {
            match ranges.last_mut() {
                Some(range) if range.end == *row => range.end += 1,
                _ => ranges.push(*row..*row + 1),
            }
        }
        let mut read = vec![Vec::with_capacity(ascending.len()); names.len()];
        self.read(names, &ranges, cancel, &mut |batch| {
            for (k, name) in names.iter().enumerate() {
                if let Some(column) = batch.column_by_name(name) {
                    append_cells(column, &mut read[k]);
                }
            }
        })?;
        let cell = |column: &Vec<Cell>, row: &u64| {
            let at = ascending.binary_search(row).ok();
            at.and_then(|at| column.get(at).cloned()).unwrap_or(Cell::Nothing)
        };
        Ok(read.iter().map(|column| rows.iter().map(|row| cell(column, row)).collect()).collect())
    }

    /// Reads some columns of some rows in order, batch by batch; the ranges ascend.
    fn read(
        &self,
        names: &[&str],
        ranges: &[Range<u64>],
        cancel: &CancelToken,
        each: &mut dyn FnMut(&RecordBatch),
    ) -> Result<(), SweepError> {
        let mut roots = Vec::with_capacity(names.len());
        for name in names {
            let known = || {
                self.columns().into_iter().map(|column| column.name).collect::<Vec<_>>().join(", ")
            };
            let index = self.schema.index_of(name).map_err(|_| SweepError::NoColumn {
                file: self.path.clone(),
                name: (*name).to_owned(),
                known: known(),
            })?;
            roots.push(index);
        }
        let mut before = 0;
        for file in &self.files {
            let own = before..before + file.rows;
            before = own.end;
            let wanted = ranges.iter().filter_map(|rows| {
                let common = rows.start.max(own.start)..rows.end.min(own.end);
                let within = common.start.saturating_sub(own.start) as usize
                    ..common.end.saturating_sub(own.start) as usize;
                (!common.is_empty()).then_some(within)
            });
            let wanted: Vec<Range<usize>> = wanted.collect();
            if wanted.is_empty() {
                continue;
            }
            let handle =
                File::open(&file.path).map_err(io_error(&file.path, "cannot be opened"))?;
            let builder =
                ParquetRecordBatchReaderBuilder::new_with_metadata(handle, file.metadata.clone());
            let mask = ProjectionMask::roots(builder.parquet_schema(), roots.iter().copied());
            let selection =
                RowSelection::from_consecutive_ranges(wanted.into_iter(), file.rows as usize);
            let reader = builder
                .with_projection(mask)
                .with_row_selection(selection)
                .build()
                .map_err(parquet_error(&file.path))?;
            for batch in reader {
                if cancel.is_cancelled() {
                    return Err(Cancelled.into());
                }
                each(&batch.map_err(|cause| parquet_error(&file.path)(cause.into()))?);
            }
        }
        Ok(())
    }
}

fn append_numbers(column: &ArrayRef, out: &mut Vec<f64>) {
    match column.data_type() {
        DataType::Float64 => {
            out.extend(column.as_primitive::<Float64Type>().iter().map(|v| v.unwrap_or(f64::NAN)));
        }
        DataType::UInt64 => {
            let values = column.as_primitive::<UInt64Type>();
            out.extend(values.iter().map(|v| v.map_or(f64::NAN, |v| v as f64)));
        }
        DataType::Boolean => {
            let values = column.as_boolean();
            out.extend(values.iter().map(|v| v.map_or(f64::NAN, f64::from)));
        }
        _ => out.extend(std::iter::repeat_n(f64::NAN, column.len())),
    }
}

fn append_texts(column: &ArrayRef, out: &mut Vec<String>) {
    match column.data_type() {
        DataType::Utf8 => {
            let texts = column.as_string::<i32>();
            out.extend(texts.iter().map(|text| text.unwrap_or_default().to_owned()));
        }
        DataType::Boolean => {
            let word = |value: Option<bool>| match value {
                Some(true) => "yes",
                Some(false) => "no",
                None => "",
            };
            out.extend(column.as_boolean().iter().map(|value| word(value).to_owned()));
        }
        DataType::UInt64 => {
            let counts = column.as_primitive::<UInt64Type>();
            out.extend(counts.iter().map(|count| count.map(|c| c.to_string()).unwrap_or_default()));
        }
        _ => {
            let mut numbers = Vec::new();
            append_numbers(column, &mut numbers);
            let text = |v: f64| if v.is_nan() { String::new() } else { v.to_string() };
            out.extend(numbers.into_iter().map(text));
        }
    }
}

fn append_cells(column: &ArrayRef, out: &mut Vec<Cell>) {
    match column.data_type() {
        DataType::Float64 | DataType::UInt64 => {
            let mut numbers = Vec::new();
            append_numbers(column, &mut numbers);
            let cell = |v: f64| if v.is_nan() { Cell::Nothing } else { Cell::Number(v) };
            out.extend(numbers.into_iter().map(cell));
        }
        _ => {
            let mut texts = Vec::new();
            append_texts(column, &mut texts);
            let cell = |text: String| match text.as_str() {
                "" => Cell::Nothing,
                _ => Cell::Text(text),
            };
            out.extend(texts.into_iter().map(cell));
        }
    }
}
