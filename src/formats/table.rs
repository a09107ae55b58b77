//! CSV tables with a header: columns by name, errors by line.

use super::error::{FormatError, text};
use super::number;
use crate::geometry::pose::{Pose, pose_from_parts};
use csv::StringRecord;
use nalgebra::Vector3;

/// How far a quaternion's length may be from 1.
const UNIT_TOLERANCE: f64 = 1e-3;

/// A table that has been split into cells. Columns nobody asks for are ignored.
#[derive(Clone, Debug)]
pub struct Table {
    header: Vec<String>,
    records: Vec<StringRecord>,
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
        let mut reader = csv::ReaderBuilder::new()
            .flexible(true)
            .trim(csv::Trim::All)
            .from_reader(text(bytes)?.as_bytes());
        let header: Vec<String> = reader
            .headers()
            .map_err(|error| csv_error(&error))?
            .iter()
            .map(str::to_owned)
            .collect();
        let mut records = Vec::new();
        for record in reader.records() {
            let record = record.map_err(|error| csv_error(&error))?;
            if record.len() != header.len() {
                return Err(FormatError::Line {
                    line: line_of(&record),
                    found: format!("{} cells", record.len()),
                    expected: format!("{}, as in line 1", header.len()),
                });
            }
            records.push(record);
        }
        Ok(Self { header, records })
    }

    pub fn has(&self, name: &str) -> bool {
        self.header.iter().any(|column| column == name)
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
            let mut places = (0..self.header.len()).filter(|&i| self.header[i] == column.name);
            column.index = places.next().unwrap_or_default();
            if places.next().is_some() {
                return Err(FormatError::RepeatedColumn(column.name));
            }
        }
        Ok(columns)
    }

    /// The rows, at least one.
    ///
    /// # Errors
    /// [`FormatError::NoRows`].
    pub fn rows(&self) -> Result<impl Iterator<Item = Row<'_>>, FormatError> {
        if self.records.is_empty() {
            return Err(FormatError::NoRows);
        }
        Ok(self.records.iter().map(|record| Row {
            line: line_of(record),
            record,
        }))
    }
}

impl Row<'_> {
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

/// The text is UTF-8 and rows may have any length, so that hardly anything can go wrong here.
fn csv_error(error: &csv::Error) -> FormatError {
    FormatError::Line {
        line: error.position().map_or(1, csv::Position::line),
        found: error.to_string(),
        expected: "comma-separated values".to_owned(),
    }
}
