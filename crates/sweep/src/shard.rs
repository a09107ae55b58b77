//! One Parquet file of rows, written batch by batch so that memory stays flat.

use super::checksum;
use super::error::{SweepError, io_error, parquet_error};
use super::folder::{Folder, Part};
use super::sweep::{Row, Sweep};
use super::table::{ROW, batch, schema};
use arrow_schema::{DataType, SchemaRef};
use parquet::arrow::ArrowWriter;
use parquet::basic::{Compression, Encoding};
use parquet::file::metadata::{KeyValue, ParquetMetaData, ParquetMetaDataReader};
use parquet::file::properties::WriterProperties;
use parquet::schema::types::ColumnPath;
use std::fs::File;
use std::ops::Range;
use std::path::Path;
use tempfile::NamedTempFile;
use trackwright_formats::sweep_plan;

/// Rows that are compressed together: some megabytes.
pub(crate) const GROUP_ROWS: usize = 1 << 16;

/// Keys of a footer.
const HASH: &str = "trackwright.plan_sha256";
const VERSION: &str = "trackwright.version";
const PLAN: &str = "trackwright.plan";
const FIRST: &str = "trackwright.first_row";
const COUNT: &str = "trackwright.rows";
const UNITS: &str = "trackwright.units";

/// A shard in the making.
pub(crate) struct ShardWriter<'a> {
    sweep: &'a Sweep,
    folder: &'a Folder,
    schema: SchemaRef,
    draft: NamedTempFile,
    writer: ArrowWriter<File>,
    rows: Range<u64>,
}

/// What a file's footer states.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Footer {
    pub hash: String,
    pub rows: Range<u64>,
    /// The plan, with the folder that its files are relative to.
    pub plan: String,
    /// Rows of the whole sweep.
    pub all: u64,
}

impl<'a> ShardWriter<'a> {
    /// A file for the rows from `first` on.
    pub fn new(
        sweep: &'a Sweep,
        folder: &'a Folder,
        part: Part,
        first: u64,
    ) -> Result<Self, SweepError> {
        let draft = folder.draft(part)?;
        let file = draft.path().to_owned();
        let schema = schema(sweep.plan());
        let handle = draft.as_file().try_clone().map_err(io_error(&file, "cannot be opened"))?;
        let writer = ArrowWriter::try_new(handle, schema.clone(), Some(properties(&schema)))
            .map_err(parquet_error(&file))?;
        Ok(Self { sweep, folder, schema, draft, writer, rows: first..first })
    }

    /// Adds rows that follow those that it has.
    pub fn add(&mut self, rows: &[Row]) -> Result<(), SweepError> {
        let file = self.draft.path().to_owned();
        let added = batch(self.sweep, &self.schema, self.rows.end, rows)
            .map_err(|cause| parquet_error(&file)(cause.into()))?;
        self.writer.write(&added).map_err(parquet_error(&file))?;
        self.rows.end += rows.len() as u64;
        Ok(())
    }

    /// Writes the footer and gives the file its name; whether it did: not where another worker was first.
    pub fn finish(mut self) -> Result<bool, SweepError> {
        let file = self.draft.path().to_owned();
        let footer = Footer {
            hash: self.sweep.hash().to_owned(),
            rows: self.rows.clone(),
            plan: sweep_plan::write(self.sweep.plan()),
            all: self.sweep.rows(),
        };
        footer.finish(self.writer, &self.schema, &file, self.draft.as_file_mut())?;
        self.folder.commit(self.draft, &self.rows)
    }

    pub fn rows(&self) -> &Range<u64> {
        &self.rows
    }
}

impl Footer {
    /// Ends what `written` holds with this footer and the checksum; it is on the disk then.
    pub fn finish(
        &self,
        mut writer: ArrowWriter<File>,
        schema: &SchemaRef,
        file: &Path,
        written: &mut File,
    ) -> Result<(), SweepError> {
        let entries = self.entries(schema).into_iter().chain([checksum::entry()]);
        entries.for_each(|entry| writer.append_key_value_metadata(entry));
        // `into_inner` would lose which error of the system it was.
        writer.close().map_err(parquet_error(file))?;
        let done = checksum::write(written).and_then(|()| written.sync_all());
        done.map_err(io_error(file, "cannot be written"))
    }

    fn entries(&self, schema: &SchemaRef) -> Vec<KeyValue> {
        let units = schema.fields().iter().filter_map(|field| {
            Some(format!("{:?}:{:?}", field.name(), field.metadata().get(super::table::UNIT)?))
        });
        let units: Vec<String> = units.collect();
        let entry = |key: &str, value: String| KeyValue::new(key.to_owned(), value);
        vec![
            entry(HASH, self.hash.clone()),
            entry(VERSION, env!("CARGO_PKG_VERSION").to_owned()),
            entry(PLAN, self.plan.clone()),
            entry(FIRST, self.rows.start.to_string()),
            entry(COUNT, self.all.to_string()),
            // For readers that show a file's entries but not those of its columns.
            entry(UNITS, format!("{{{}}}", units.join(","))),
        ]
    }

    /// Of a file's metadata; `None` where it is none of a sweep.
    pub fn of(metadata: &ParquetMetaData) -> Option<Self> {
        let entries = metadata.file_metadata().key_value_metadata()?;
        let value = |key: &str| entries.iter().find(|entry| entry.key == key)?.value.clone();
        let first: u64 = value(FIRST)?.parse().ok()?;
        let rows = u64::try_from(metadata.file_metadata().num_rows()).ok()?;
        Some(Self {
            hash: value(HASH)?,
            rows: first..first.checked_add(rows)?,
            plan: value(PLAN)?,
            all: value(COUNT)?.parse().ok()?,
        })
    }
}

/// How columns are stored; the same for shards and for what is merged of them.
pub(crate) fn properties(schema: &SchemaRef) -> WriterProperties {
    let mut properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_max_row_group_row_count(Some(GROUP_ROWS))
        .set_created_by(format!("trackwright {}", env!("CARGO_PKG_VERSION")));
    // Row numbers and figures all differ: a dictionary of them would be as large as they are.
    for field in schema.fields() {
        let column = || ColumnPath::from(field.name().as_str());
        let encoding = match field.data_type() {
            DataType::UInt64 if field.name() == ROW => Encoding::DELTA_BINARY_PACKED,
            DataType::Float64 if field.is_nullable() => Encoding::BYTE_STREAM_SPLIT,
            _ => continue,
        };
        properties = properties
            .set_column_dictionary_enabled(column(), false)
            .set_column_encoding(column(), encoding);
    }
    properties.build()
}

/// What a file's footer states, once the bytes of the whole file are those that were written.
///
/// # Errors
/// A file that cannot be read, is damaged or cut short, or is none of a sweep.
pub(crate) fn footer(file: &Path) -> Result<Footer, SweepError> {
    checksum::verify(file)?;
    let opened = File::open(file).map_err(io_error(file, "cannot be opened"))?;
    let metadata =
        ParquetMetaDataReader::new().parse_and_finish(&opened).map_err(parquet_error(file))?;
    Footer::of(&metadata).ok_or_else(|| SweepError::NoSweep { file: file.to_owned() })
}
