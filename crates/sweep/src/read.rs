//! Reads a sweep's rows, column by column as they are needed.

use super::error::{SweepError, io_error, parquet_error};
use super::folder::named_shards;
use super::shard::{Footer, footer};
use super::table::{COUNTS, MOTION, UNIT};
use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, UInt64Type};
use arrow_array::{Array, ArrayRef, RecordBatch};
use arrow_schema::{DataType, SchemaRef};
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::{
    ArrowReaderMetadata, ParquetRecordBatchReaderBuilder, RowSelection, RowSelector,
};
use std::fs::File;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// The rows of a merged file or of a folder's shards.
#[derive(Clone, Debug)]
pub struct SweepTable {
    path: PathBuf,
    files: Vec<TableFile>,
    schema: SchemaRef,
    plan: String,
    hash: String,
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
    /// Whether it holds numbers.
    pub is_number: bool,
    /// Whether it holds texts; neither, where it holds yes and no.
    pub is_text: bool,
}

impl SweepTable {
    /// Opens a folder of shards or a merged file; reads no row yet.
    ///
    /// # Errors
    /// Files that are cut short or are none of a sweep, and shards of several plans.
    pub fn open(path: &Path) -> Result<Self, SweepError> {
        let files = match path.is_dir() {
            true => named_shards(path)?.into_iter().map(|(_, file)| file).collect(),
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
            let metadata = ArrowReaderMetadata::load(&handle, Default::default())
                .map_err(parquet_error(&file))?;
            let rows =
                metadata.metadata().file_metadata().num_rows().try_into().unwrap_or_default();
            opened.push(TableFile { path: file, rows, metadata });
        }
        let (Some(first), Some(file)) = (first, opened.first()) else {
            return Err(SweepError::NoSweep { file: path.to_owned() });
        };
        let schema = file.metadata.schema().clone();
        Ok(Self {
            path: path.to_owned(),
            files: opened,
            schema,
            plan: first.plan,
            hash: first.hash,
        })
    }

    /// Number of rows.
    pub fn rows(&self) -> u64 {
        self.files.iter().map(|file| file.rows).sum()
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
                is_number: matches!(field.data_type(), DataType::Float64 | DataType::UInt64),
                is_text: *field.data_type() == DataType::Utf8,
            })
            .collect()
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
        let mut numbers = Vec::with_capacity(self.rows() as usize);
        self.read(&[name], 0..self.rows(), &mut |batch| {
            append_numbers(batch.column(0), &mut numbers);
        })?;
        Ok(numbers)
    }

    /// Some rows as texts, a column each: what a table shows of them.
    ///
    /// # Errors
    /// As [`numbers`](Self::numbers).
    pub fn texts(&self, names: &[&str], rows: Range<u64>) -> Result<Vec<Vec<String>>, SweepError> {
        let mut columns = vec![Vec::new(); names.len()];
        self.read(names, rows, &mut |batch| {
            for (k, name) in names.iter().enumerate() {
                if let Some(column) = batch.column_by_name(name) {
                    append_texts(column, &mut columns[k]);
                }
            }
        })?;
        Ok(columns)
    }

    /// Reads some columns of some rows in order, batch by batch.
    fn read(
        &self,
        names: &[&str],
        rows: Range<u64>,
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
            let wanted = rows.start.max(own.start)..rows.end.min(own.end);
            if wanted.is_empty() {
                continue;
            }
            let handle =
                File::open(&file.path).map_err(io_error(&file.path, "cannot be opened"))?;
            let builder =
                ParquetRecordBatchReaderBuilder::new_with_metadata(handle, file.metadata.clone());
            let mask = ProjectionMask::roots(builder.parquet_schema(), roots.iter().copied());
            let selection = RowSelection::from(vec![
                RowSelector::skip((wanted.start - own.start) as usize),
                RowSelector::select((wanted.end - wanted.start) as usize),
            ]);
            let reader = builder
                .with_projection(mask)
                .with_row_selection(selection)
                .build()
                .map_err(parquet_error(&file.path))?;
            for batch in reader {
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
