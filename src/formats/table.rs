//! CSV tables with a header: columns by name, errors by line.

use super::error::{FormatError, text};
use super::number;
use super::utf8::{self, Utf8Reader};
use crate::geometry::pose::{Pose, pose_from_parts};
use csv::StringRecord;
use nalgebra::Vector3;
use std::io::Read;

/// How far a quaternion's length may be from 1.
const UNIT_TOLERANCE: f64 = 1e-3;

/// A table that has been split into cells. Columns nobody asks for are ignored.
#[derive(Clone, Debug)]
pub struct Table {
    header: Header,
    records: Vec<StringRecord>,
}

/// A table that is split into cells row by row, so that it is never in memory as a whole.
pub struct TableReader<R: Read> {
    header: Header,
    reader: csv::Reader<Utf8Reader<R>>,
    record: StringRecord,
    has_rows: bool,
}

/// The names of a table's columns.
#[derive(Clone, Debug)]
pub struct Header(Vec<String>);

/// A column's name and its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Column {
    name: &'static str,
    index: usize,
}

/// One row and where it stands.
#[derive(Clone, Copy, Debug)]
pub struct Row<'a> {
    line: u64,
    record: &'a StringRecord,
}

/// Three columns of a position and, where there are any, four of a quaternion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseColumns {
    pub position: [Column; 3],
    pub rotation: Option<[Column; 4]>,
}

impl Table {
    /// Splits a table into cells.
    ///
    /// # Errors
    /// Text that is no table, rows of different lengths, or no rows.
    pub fn parse(bytes: &[u8]) -> Result<Self, FormatError> {
        // A byte that is no text is named before anything else.
        text(bytes)?;
        let mut reader = TableReader::new(bytes)?;
        let mut records = Vec::new();
        while reader.next_record()? {
            records.push(reader.record.clone());
        }
        Ok(Self {
            header: reader.header,
            records,
        })
    }

    pub fn has(&self, name: &str) -> bool {
        self.header.has(name)
    }

    /// See [`Header::columns`].
    ///
    /// # Errors
    /// As there.
    pub fn columns<const N: usize>(
        &self,
        names: [&'static str; N],
        expected: &'static str,
    ) -> Result<[Column; N], FormatError> {
        self.header.columns(names, expected)
    }

    /// The rows, at least one.
    ///
    /// # Errors
    /// [`FormatError::NoRows`].
    pub fn rows(&self) -> Result<impl Iterator<Item = Row<'_>>, FormatError> {
        if self.records.is_empty() {
            return Err(FormatError::NoRows);
        }
        Ok(self.records.iter().map(Row::of))
    }
}

impl<R: Read> TableReader<R> {
    /// Reads the header.
    ///
    /// # Errors
    /// Text that is no table, or what the reader says.
    pub fn new(reader: R) -> Result<Self, FormatError> {
        let mut reader = csv::ReaderBuilder::new()
            .flexible(true)
            .trim(csv::Trim::All)
            .from_reader(Utf8Reader::new(reader));
        let header = match reader.headers() {
            Ok(header) => Header(header.iter().map(str::to_owned).collect()),
            Err(error) => return Err(error_of(error)),
        };
        Ok(Self {
            header,
            reader,
            record: StringRecord::new(),
            has_rows: false,
        })
    }

    pub fn header(&self) -> &Header {
        &self.header
    }

    /// The next row; `None` after the last.
    ///
    /// # Errors
    /// Text that is no table, a row of another length than the header, or no rows at all.
    pub fn next_row(&mut self) -> Result<Option<Row<'_>>, FormatError> {
        if self.next_record()? {
            self.has_rows = true;
            return Ok(Some(Row::of(&self.record)));
        }
        match self.has_rows {
            true => Ok(None),
            false => Err(FormatError::NoRows),
        }
    }

    fn next_record(&mut self) -> Result<bool, FormatError> {
        let line = self.reader.position().line();
        self.reader.get_mut().begin_row(line);
        let is_there = self
            .reader
            .read_record(&mut self.record)
            .map_err(error_of)?;
        if is_there && self.record.len() != self.header.0.len() {
            return Err(FormatError::Line {
                line: line_of(&self.record),
                found: format!("{} cells", self.record.len()),
                expected: format!("{}, as in line 1", self.header.0.len()),
            });
        }
        Ok(is_there)
    }
}

impl Header {
    pub fn has(&self, name: &str) -> bool {
        self.0.iter().any(|column| column == name)
    }

    /// The columns of these names.
    ///
    /// # Errors
    /// Names all that are missing, and what was expected; or one that is there twice.
    pub fn columns<const N: usize>(
        &self,
        names: [&'static str; N],
        expected: &'static str,
    ) -> Result<[Column; N], FormatError> {
        let missing: Vec<_> = names.into_iter().filter(|name| !self.has(name)).collect();
        if !missing.is_empty() {
            return Err(FormatError::MissingColumns { missing, expected });
        }
        let mut columns = names.map(|name| Column { name, index: 0 });
        for column in &mut columns {
            let mut places = (0..self.0.len()).filter(|&i| self.0[i] == column.name);
            column.index = places.next().unwrap_or_default();
            if places.next().is_some() {
                return Err(FormatError::RepeatedColumn(column.name));
            }
        }
        Ok(columns)
    }
}

impl<'a> Row<'a> {
    fn of(record: &'a StringRecord) -> Self {
        Self {
            line: line_of(record),
            record,
        }
    }

    /// The finite number of a cell.
    ///
    /// # Errors
    /// Names line and column of anything else.
    pub fn number(&self, column: Column) -> Result<f64, FormatError> {
        let cell = self.record.get(column.index).unwrap_or_default();
        match cell.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(self.cell_error(
                column.name,
                match cell {
                    "" => "empty".to_owned(),
                    _ => format!("{cell:?}"),
                },
                "a finite number",
            )),
        }
    }

    /// A pose; the rotation is none where there are no columns for it.
    ///
    /// # Errors
    /// A cell that is no number, or a quaternion whose length is not 1.
    pub fn pose(&self, columns: &PoseColumns) -> Result<Pose, FormatError> {
        let [x, y, z] = self.numbers(&columns.position)?;
        let position = Vector3::new(x, y, z);
        let Some(rotation_columns) = &columns.rotation else {
            return Ok(Pose::translation(x, y, z));
        };
        let quaternion = self.numbers(rotation_columns)?;
        let length = quaternion.iter().map(|v| v * v).sum::<f64>().sqrt();
        let is_unit = (length - 1.0).abs() <= UNIT_TOLERANCE;
        match number::rotation(quaternion).filter(|_| is_unit) {
            Some(rotation) => Ok(pose_from_parts(position, rotation)),
            None => {
                let [w, .., z] = rotation_columns;
                Err(self.cell_error(
                    &format!("length of the quaternion {} … {}", w.name, z.name),
                    length.to_string(),
                    "1 within 0.001",
                ))
            }
        }
    }

    fn numbers<const N: usize>(&self, columns: &[Column; N]) -> Result<[f64; N], FormatError> {
        let mut values = [0.0; N];
        for (value, &column) in values.iter_mut().zip(columns) {
            *value = self.number(column)?;
        }
        Ok(values)
    }

    fn cell_error(&self, field: &str, found: String, expected: &'static str) -> FormatError {
        FormatError::Cell {
            line: self.line,
            field: field.to_owned(),
            found,
            expected,
        }
    }
}

fn line_of(record: &StringRecord) -> u64 {
    record.position().map_or(0, csv::Position::line)
}

/// The text is UTF-8 and rows may have any length, so that beside the reader's own failures hardly
/// anything can go wrong here.
fn error_of(error: csv::Error) -> FormatError {
    let line = error.position().map_or(1, csv::Position::line);
    let found = error.to_string();
    match error.into_kind() {
        csv::ErrorKind::Io(cause) => utf8::error_of(&cause),
        _ => FormatError::Line {
            line,
            found,
            expected: "comma-separated values".to_owned(),
        },
    }
}
