//! Tables with a header: columns by name, errors by line, as programs and spreadsheets write them.

use super::error::{FormatError, text};
use super::table_dialect::{ColumnName, DecimalMark, Dialect, first_line};
use super::utf8::{self, Utf8Reader};
use csv::StringRecord;
use nalgebra::{UnitQuaternion, Vector3};
use std::array::from_fn;
use std::cell::Cell;
use std::io::{self, Cursor, Read};
use trackwright_geometry::number;
use trackwright_geometry::pose::{Pose, pose_from_parts};

/// How far a quaternion's length may be from 1.
const UNIT_TOLERANCE: f64 = 1e-3;

/// What the names of a pose's columns end in.
pub const POSE: [&str; 7] = ["x", "y", "z", "qw", "qx", "qy", "qz"];

/// A table that is split into cells row by row, so that it is never in memory as a whole. Columns
/// that are not requested are ignored.
pub struct Table<R: Read> {
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

/// One row and where it stands.
#[derive(Clone, Copy, Debug)]
pub struct Row<'a> {
    line: u64,
    record: &'a StringRecord,
    header: &'a Header,
    marks: &'a Marks,
}

/// Three columns of a position and, where there are any, four of a quaternion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseColumns {
    pub position: [usize; 3],
    pub rotation: Option<[usize; 4]>,
}

impl<'a> Table<&'a [u8]> {
    /// Reads the header of a table that is in memory.
    ///
    /// # Errors
    /// Text that is no table.
    pub fn parse(bytes: &'a [u8]) -> Result<Self, FormatError> {
        // A byte that is no text is named before anything else.
        text(bytes)?;
        Self::new(bytes)
    }
}

impl<R: Read> Table<R> {
    /// Reads the header.
    ///
    /// # Errors
    /// Text that is no table, or an error of the reader.
    pub fn new(reader: R) -> Result<Self, FormatError> {
        let mut text = Utf8Reader::new(reader);
        let head = first_line(&mut text).map_err(|error| utf8::error_of(&error))?;
        let dialect = Dialect::of(&head);
        text.begin_rows(dialect.separator)?;
        let mut reader = csv::ReaderBuilder::new()
            .flexible(true)
            .delimiter(dialect.separator)
            .trim(csv::Trim::All)
            .from_reader(Cursor::new(head).chain(text));
        let header = match reader.headers() {
            Ok(header) => Header(header.iter().map(ColumnName::parse).collect()),
            Err(error) => return Err(error_of(error)),
        };
        let marks = Marks { dialect, seen: Cell::new(None) };
        Ok(Self { header, reader, record: StringRecord::new(), has_rows: false, marks })
    }

    pub fn header(&self) -> &Header {
        &self.header
    }

    /// The next row; `None` after the last.
    ///
    /// # Errors
    /// Text that is no table, a row of another length than the header, or no rows at all.
    pub fn next_row(&mut self) -> Result<Option<Row<'_>>, FormatError> {
        if !self.reader.read_record(&mut self.record).map_err(error_of)? {
            return if self.has_rows { Ok(None) } else { Err(FormatError::NoRows) };
        }
        self.has_rows = true;
        let line = self.record.position().map_or(0, csv::Position::line);
        let (found, expected) = (self.record.len(), self.header.0.len());
        if found != expected {
            let advice = match self.marks.dialect.separator == b',' && found > expected {
                true => " (with decimal commas, semicolons between cells)",
                false => "",
            };
            let expected = format!("{expected}, as in line 1{advice}");
            return Err(FormatError::line(line, format!("{found} cells"), expected));
        }
        Ok(Some(Row { line, record: &self.record, header: &self.header, marks: &self.marks }))
    }

    /// What `read` makes of each row, at least one.
    ///
    /// # Errors
    /// Those of [`Self::next_row`] and of `read`.
    pub fn read<T>(
        mut self,
        read: impl Fn(&Row) -> Result<T, FormatError>,
    ) -> Result<Vec<T>, FormatError> {
        let mut all = Vec::new();
        while let Some(row) = self.next_row()? {
            all.push(read(&row)?);
        }
        Ok(all)
    }
}

impl Header {
    /// Whether there is a column of this name.
    pub fn has(&self, name: &str) -> bool {
        self.places(name).next().is_some()
    }

    /// Columns of this name, but for capitals, spaces and mm; where the name itself is there, one in another
    /// unit is a column of its own.
    fn places<'a>(&'a self, name: &'a str) -> impl Iterator<Item = usize> + 'a {
        let is_written = self.0.iter().any(|column| column.written == name);
        let is_it = move |column: &ColumnName| {
            column.written == name || column.plain == name && !(is_written && column.unit.is_some())
        };
        (0..self.0.len()).filter(move |&i| is_it(&self.0[i]))
    }

    /// The place of the one column of a name.
    ///
    /// # Errors
    /// None such, or several.
    pub fn place(&self, name: &str) -> Result<usize, FormatError> {
        let mut places = self.places(name);
        let wrong = |found: &str| {
            let expected = "one column that states which rows belong together";
            FormatError::line(1, format!("{found} column {name:?}"), expected)
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
    pub fn columns<N: AsRef<str>>(
        &self,
        names: &[N],
        expected: &'static str,
    ) -> Result<Vec<usize>, FormatError> {
        let names = names.iter().map(AsRef::as_ref);
        let missing: Vec<_> = names.clone().filter(|name| !self.has(name)).collect();
        if !missing.is_empty() {
            let is_number = |column: &ColumnName| {
                let cell = column.written.replacen(',', ".", 1);
                cell.parse::<f64>().is_ok()
            };
            if self.0.len() > 1 && self.0.iter().all(is_number) {
                return Err(FormatError::NoHeader { expected });
            }
            let missing = missing.into_iter().map(str::to_owned).collect();
            return Err(FormatError::MissingColumns { missing, expected });
        }
        let column = |name: &str| {
            let mut places = self.places(name);
            let index = places.next().unwrap_or_default();
            if places.next().is_some() {
                return Err(FormatError::RepeatedColumn(name.to_owned()));
            }
            let ColumnName { written, unit, .. } = &self.0[index];
            match unit {
                Some(unit) => {
                    Err(FormatError::Unit { column: written.clone(), unit: unit.clone() })
                }
                None => Ok(index),
            }
        };
        names.map(column).collect()
    }

    /// Whether any column of a pose is there, by what the names of these begin with.
    pub fn has_pose(&self, begin: &str) -> bool {
        POSE.iter().any(|end| self.has(&format!("{begin}{end}")))
    }

    /// The columns of a whole pose.
    ///
    /// # Errors
    /// As [`Self::columns`].
    pub fn pose(&self, begin: &str, expected: &'static str) -> Result<PoseColumns, FormatError> {
        let columns = self.columns(&POSE.map(|end| format!("{begin}{end}")), expected)?;
        let rotation = Some(from_fn(|k| columns[3 + k]));
        Ok(PoseColumns { position: from_fn(|k| columns[k]), rotation })
    }

    /// The columns of several poses, which may all be positions alone.
    ///
    /// # Errors
    /// As [`Self::columns`]; rotations are there for all or for none.
    pub fn poses<const N: usize>(
        &self,
        begins: [&str; N],
        expected: &'static str,
        expected_rotations: &'static str,
    ) -> Result<[PoseColumns; N], FormatError> {
        let names = |ends: &[&str]| -> Vec<String> {
            let each = begins.iter().flat_map(|begin| ends.iter().map(move |end| (begin, end)));
            each.map(|(begin, end)| format!("{begin}{end}")).collect()
        };
        let positions = self.columns(&names(&POSE[..3]), expected)?;
        let rotations = names(&POSE[3..]);
        let rotations = match rotations.iter().any(|name| self.has(name)) {
            true => Some(self.columns(&rotations, expected_rotations)?),
            false => None,
        };
        Ok(from_fn(|i| PoseColumns {
            position: from_fn(|k| positions[3 * i + k]),
            rotation: rotations.as_ref().map(|columns| from_fn(|k| columns[4 * i + k])),
        }))
    }
}

/// What is computed of larger ones is no number any more, or none that a file of the program may have.
const LARGEST_COORDINATE: f64 = 1e12;

impl<'a> Row<'a> {
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
    pub fn number(&self, column: usize) -> Result<f64, FormatError> {
        let cell = self.cell(column);
        let wrong = |found: String, expected| {
            Err(FormatError::cell(self.line, self.name(column), found, expected))
        };
        let mark = DecimalMark::of(cell);
        if mark.is_some() && self.marks.dialect.may_have_decimal_commas() {
            let other = self.marks.seen.get().filter(|seen| mark != Some(*seen));
            if other.is_some() {
                let expected = "the decimal mark of the rows before, a comma or a point";
                return wrong(format!("{cell:?}"), expected);
            }
            self.marks.seen.set(mark);
        }
        match self.marks.dialect.number(cell) {
            Some(value) if value.is_finite() => Ok(value),
            _ if cell.is_empty() => wrong("empty".to_owned(), "a finite number"),
            _ => wrong(format!("{cell:?}"), "a finite number"),
        }
    }

    /// What the program calls a column.
    fn name(&self, column: usize) -> &'a str {
        &self.header.0[column].plain
    }

    /// A pose; the rotation is none where there are no columns for it.
    ///
    /// # Errors
    /// A cell that is no number, or a quaternion whose length is not 1.
    pub fn pose(&self, columns: &PoseColumns) -> Result<Pose, FormatError> {
        let [x, y, z] = self.numbers(&columns.position)?;
        let position = Vector3::new(x, y, z);
        if let Some(k) = (0..3).find(|&k| position[k].abs() > LARGEST_COORDINATE) {
            let (name, found) = (self.name(columns.position[k]), format!("{:e}", position[k]));
            return Err(FormatError::cell(self.line, name, found, "a number up to 1e12"));
        }
        let Some(rotation_columns) = &columns.rotation else {
            return Ok(Pose::translation(x, y, z));
        };
        let quaternion = self.numbers(rotation_columns)?;
        match unit_rotation(quaternion) {
            Ok(rotation) => Ok(pose_from_parts(position, rotation)),
            Err(NotUnit { length, expected }) => {
                let [w, .., z] = rotation_columns.map(|column| self.name(column));
                let field = format!("length of the quaternion {w} … {z}");
                Err(FormatError::cell(self.line, field, length.to_string(), expected))
            }
        }
    }

    fn numbers<const N: usize>(&self, columns: &[usize; N]) -> Result<[f64; N], FormatError> {
        let mut values = [0.0; N];
        for (value, &column) in values.iter_mut().zip(columns) {
            *value = self.number(column)?;
        }
        Ok(values)
    }
}

/// A quaternion that is not of unit length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NotUnit {
    pub length: f64,
    pub expected: &'static str,
}

/// The rotation of a quaternion, scalar first, as a table has it: of unit length but for the digits
/// that were written.
///
/// # Errors
/// Another length.
pub fn unit_rotation(quaternion: [f64; 4]) -> Result<UnitQuaternion<f64>, NotUnit> {
    let length = quaternion.iter().map(|v| v * v).sum::<f64>().sqrt();
    let is_unit = (length - 1.0).abs() <= UNIT_TOLERANCE;
    number::rotation(quaternion).filter(|_| is_unit).ok_or(NotUnit {
        length,
        expected: match length > 2.0 {
            true => "1 within 0.001: a unit quaternion, no angles",
            false => "1 within 0.001",
        },
    })
}

/// The text is UTF-8 and rows may have any length, so that beside the reader's own failures hardly
/// anything can go wrong here.
fn error_of(error: csv::Error) -> FormatError {
    let line = error.position().map_or(1, csv::Position::line);
    let found = error.to_string();
    match error.into_kind() {
        csv::ErrorKind::Io(cause) => utf8::error_of(&cause),
        _ => {
            FormatError::line(line, found, "cells with a comma, a semicolon or a tab between them")
        }
    }
}
