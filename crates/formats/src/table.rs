//! Tables with a header: columns by name, errors by line, as programs and spreadsheets write them.

use super::error::{FormatError, text};
use super::table_dialect::{ColumnName, DecimalMark, Dialect, first_line};
use super::utf8::{self, Utf8Reader};
use csv::StringRecord;
use nalgebra::Vector3;
use std::cell::Cell;
use std::io::{self, Cursor, Read};
use trackwright_geometry::number;
use trackwright_geometry::pose::{Pose, pose_from_parts};

/// How far a quaternion's length may be from 1.
const UNIT_TOLERANCE: f64 = 1e-3;

/// A table that has been split into cells. Columns nobody asks for are ignored.
#[derive(Clone, Debug)]
pub struct Table {
    header: Header,
    records: Vec<StringRecord>,
    marks: Marks,
}

/// A table that is split into cells row by row, so that it is never in memory as a whole.
pub struct TableReader<R: Read> {
    header: Header,
    reader: csv::Reader<io::Chain<Cursor<Vec<u8>>, Utf8Reader<R>>>,
    record: StringRecord,
    has_rows: bool,
    marks: Marks,
}

/// The names of a table's columns.
#[derive(Clone, Debug)]
pub struct Header(Vec<ColumnName>);

/// How decimals are written, as far as it is known.
#[derive(Clone, Debug)]
struct Marks {
    dialect: Dialect,
    seen: Cell<Option<DecimalMark>>,
}

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
    marks: &'a Marks,
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
        Ok(Self { header: reader.header, records, marks: reader.marks })
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
        Ok(self.records.iter().map(|record| Row::of(record, &self.marks)))
    }
}

impl<R: Read> TableReader<R> {
    /// Reads the header.
    ///
    /// # Errors
    /// Text that is no table, or what the reader says.
    pub fn new(reader: R) -> Result<Self, FormatError> {
        let mut text = Utf8Reader::new(reader);
        let head = first_line(&mut text).map_err(|error| utf8::error_of(&error))?;
        let dialect = Dialect::of(&head);
        let mut reader = csv::ReaderBuilder::new()
            .flexible(true)
            .delimiter(dialect.separator)
            .trim(csv::Trim::All)
            .from_reader(Cursor::new(head).chain(text));
        let header = match reader.headers() {
            Ok(header) => Header(header.iter().map(ColumnName::parse).collect()),
            Err(error) => return Err(error_of(error)),
        };
        Ok(Self {
            header,
            reader,
            record: StringRecord::new(),
            has_rows: false,
            marks: Marks { dialect, seen: Cell::new(None) },
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
            return Ok(Some(Row::of(&self.record, &self.marks)));
        }
        match self.has_rows {
            true => Ok(None),
            false => Err(FormatError::NoRows),
        }
    }

    fn next_record(&mut self) -> Result<bool, FormatError> {
        let line = self.reader.position().line();
        self.reader.get_mut().get_mut().1.begin_row(line);
        let is_there = self.reader.read_record(&mut self.record).map_err(error_of)?;
        if is_there && self.record.len() != self.header.0.len() {
            let (found, expected) = (self.record.len(), self.header.0.len());
            let is_doubled = self.marks.dialect.separator == b',' && found > expected;
            return Err(FormatError::Line {
                line: line_of(&self.record),
                found: format!("{found} cells"),
                expected: match is_doubled {
                    true => format!(
                        "{expected}, as in line 1 (with decimal commas, semicolons between cells)"
                    ),
                    false => format!("{expected}, as in line 1"),
                },
            });
        }
        Ok(is_there)
    }
}

impl Header {
    pub fn has(&self, name: &str) -> bool {
        self.places(name).next().is_some()
    }

    /// Columns of this name: as it is written, else but for capitals, spaces and a unit.
    fn places<'a>(&'a self, name: &'a str) -> impl Iterator<Item = usize> + 'a {
        let is_written = self.0.iter().any(|column| column.written == name);
        (0..self.0.len()).filter(move |&i| match is_written {
            true => self.0[i].written == name,
            false => self.0[i].plain == name,
        })
    }

    /// The place of the one column of a name.
    ///
    /// # Errors
    /// None such, or several.
    pub fn place(&self, name: &str) -> Result<usize, FormatError> {
        let mut places = self.places(name);
        let wrong = |found: &str| FormatError::Line {
            line: 1,
            found: format!("{found} column {name:?}"),
            expected: "one column that says which rows belong together".to_owned(),
        };
        match (places.next(), places.next()) {
            (Some(index), None) => Ok(index),
            (None, _) => Err(wrong("no")),
            (Some(_), Some(_)) => Err(wrong("twice the")),
        }
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
            let is_number = |column: &ColumnName| {
                let cell = column.written.replacen(',', ".", 1);
                cell.parse::<f64>().is_ok()
            };
            if self.0.len() > 1 && self.0.iter().all(is_number) {
                return Err(FormatError::NoHeader { expected });
            }
            return Err(FormatError::MissingColumns { missing, expected });
        }
        let mut columns = names.map(|name| Column { name, index: 0 });
        for column in &mut columns {
            let mut places = self.places(column.name);
            column.index = places.next().unwrap_or_default();
            if places.next().is_some() {
                return Err(FormatError::RepeatedColumn(column.name));
            }
            let ColumnName { written, unit, .. } = &self.0[column.index];
            if let Some(unit) = unit {
                return Err(FormatError::Unit { column: written.clone(), unit: unit.clone() });
            }
        }
        Ok(columns)
    }
}

impl<'a> Row<'a> {
    fn of(record: &'a StringRecord, marks: &'a Marks) -> Self {
        Self { line: line_of(record), record, marks }
    }

    /// Where the row begins.
    pub fn line(&self) -> u64 {
        self.line
    }

    /// What stands in a cell.
    pub fn cell(&self, index: usize) -> &'a str {
        self.record.get(index).unwrap_or_default()
    }

    /// The finite number of a cell.
    ///
    /// # Errors
    /// Names line and column of anything else.
    pub fn number(&self, column: Column) -> Result<f64, FormatError> {
        let cell = self.cell(column.index);
        let mark = DecimalMark::of(cell);
        if mark.is_some() && self.marks.dialect.may_have_decimal_commas() {
            let other = self.marks.seen.get().filter(|seen| mark != Some(*seen));
            if other.is_some() {
                return Err(self.cell_error(
                    column.name,
                    format!("{cell:?}"),
                    "the decimal mark of the rows before, a comma or a point",
                ));
            }
            self.marks.seen.set(mark);
        }
        match self.marks.dialect.number(cell) {
            Some(value) if value.is_finite() => Ok(value),
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
                    match length > 2.0 {
                        true => "1 within 0.001: a unit quaternion, no angles",
                        false => "1 within 0.001",
                    },
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
        FormatError::Cell { line: self.line, field: field.to_owned(), found, expected }
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
            expected: "cells with a comma, a semicolon or a tab between them".to_owned(),
        },
    }
}
