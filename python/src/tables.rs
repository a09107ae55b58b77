//! Tables that come in: a file, or columns that are in memory.

use crate::arrays::{ArrayError, floats, rotation};
use crate::errors::{Done, TrackwrightError, warn};
use nalgebra::{Point3, Vector3};
use numpy::PyReadonlyArrayDyn;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use std::path::{Path, PathBuf};
use trackwright_calibration::doubts::Suspicion;
use trackwright_formats::groups::GroupColumn;
use trackwright_formats::table::POSE;
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_project::{Doubted, StoreError};

/// Where a table is.
pub enum Table<'py> {
    File(PathBuf),
    Memory(Columns<'py>),
}

impl<'py> Table<'py> {
    /// A path, or what can be taken as columns.
    ///
    /// # Errors
    /// What is no table.
    pub fn of(given: &Bound<'py, PyAny>) -> Done<Self> {
        if given.is_instance_of::<PyString>() || given.hasattr("__fspath__")? {
            return Ok(Self::File(given.extract()?));
        }
        let py = given.py();
        let columns = py.import("trackwright._tables")?.call_method1("columns", (given,))?;
        let columns = columns.cast_into::<PyDict>().map_err(PyErr::from)?;
        Ok(Self::Memory(Columns { columns }))
    }
}

/// Why columns are not the table that they have to be. Rows are counted from 0, as Python counts.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ColumnsError {
    #[error("table: found no column {}, expected {expected}", missing.join(", "))]
    Missing { missing: Vec<String>, expected: &'static str },
    #[error("table: found no column {0:?}, expected one that states which rows belong together")]
    NoGroups(String),
    #[error("table, row {row}: {column} is empty, expected the name of the row's group")]
    EmptyLabel { column: String, row: usize },
}

/// Columns of one length by their names.
pub struct Columns<'py> {
    columns: Bound<'py, PyDict>,
}

/// Columns of numbers; of poses seven, or three of a position alone.
pub struct NumberColumns<'py>(Vec<(String, PyReadonlyArrayDyn<'py, f64>)>);

impl<'py> Columns<'py> {
    pub fn has(&self, name: &str) -> Done<bool> {
        Ok(self.columns.contains(name)?)
    }

    /// Whether any column of a pose is there, by what the names of these begin with.
    pub fn has_pose(&self, begin: &str) -> Done<bool> {
        let mut has = false;
        for end in POSE {
            has |= self.has(&format!("{begin}{end}"))?;
        }
        Ok(has)
    }

    /// Columns of numbers.
    ///
    /// # Errors
    /// Names all that are missing.
    fn numbers(&self, names: &[String], expected: &'static str) -> Done<NumberColumns<'py>> {
        let mut found = Vec::with_capacity(names.len());
        let mut missing = Vec::new();
        for name in names {
            match self.columns.get_item(name)? {
                None => missing.push(name.clone()),
                Some(column) => {
                    let what = format!("table, column {name}");
                    found.push((name.clone(), floats(&column, &what)?));
                }
            }
        }
        if !missing.is_empty() {
            return Err(ColumnsError::Missing { missing, expected }.into());
        }
        Ok(NumberColumns(found))
    }

    /// One column of numbers.
    ///
    /// # Errors
    /// A name that is missing.
    pub fn number_column(&self, name: &str, expected: &'static str) -> Done<NumberColumns<'py>> {
        self.numbers(&[name.to_owned()], expected)
    }

    /// The columns of poses.
    ///
    /// # Errors
    /// Names all that are missing.
    pub fn poses(&self, begin: &str, expected: &'static str) -> Done<NumberColumns<'py>> {
        self.numbers(&POSE.map(|end| format!("{begin}{end}")), expected)
    }

    /// The columns of positions.
    ///
    /// # Errors
    /// Names all that are missing.
    pub fn positions(&self, begin: &str, expected: &'static str) -> Done<NumberColumns<'py>> {
        let names: Vec<String> = POSE[..3].iter().map(|end| format!("{begin}{end}")).collect();
        self.numbers(&names, expected)
    }

    /// The text of a column, where it is there.
    ///
    /// # Errors
    /// Empty cells.
    pub fn labels(&self, name: &str) -> Done<Option<GroupColumn>> {
        let Some(column) = self.columns.get_item(name)? else {
            return Ok(None);
        };
        let mut labels = Vec::new();
        for (row, cell) in column.call_method0("tolist")?.try_iter()?.enumerate() {
            let label = cell?.str()?.to_string_lossy().trim().to_owned();
            if label.is_empty() {
                return Err(ColumnsError::EmptyLabel { column: name.to_owned(), row }.into());
            }
            labels.push(label);
        }
        Ok(Some(GroupColumn { name: name.to_owned(), labels }))
    }
}

impl NumberColumns<'_> {
    /// How many rows there are.
    ///
    /// # Errors
    /// No rows at all.
    pub fn rows(&self) -> Result<usize, ArrayError> {
        match self.0.first().map_or(0, |(_, column)| column.as_array().len()) {
            0 => Err(ArrayError::NoRows { what: "table".to_owned() }),
            rows => Ok(rows),
        }
    }

    /// The number of a cell.
    ///
    /// # Errors
    /// One that is not finite.
    pub fn number(&self, column: usize, row: usize) -> Result<f64, ArrayError> {
        let (name, values) = &self.0[column];
        match values.as_array()[[row]] {
            value if value.is_finite() => Ok(value),
            found => Err(ArrayError::Number {
                what: format!("table, column {name}"),
                row,
                found,
                expected: "a finite number",
            }),
        }
    }

    /// The point of a row, mm.
    ///
    /// # Errors
    /// Numbers that are not finite.
    pub fn point(&self, row: usize) -> Result<Point3<f64>, ArrayError> {
        let number = |column| self.number(column, row);
        Ok(Point3::new(number(0)?, number(1)?, number(2)?))
    }

    /// The pose of a row; not turned where there are positions alone.
    ///
    /// # Errors
    /// Numbers that are not finite, a quaternion that is not of unit length.
    pub fn pose(&self, row: usize) -> Result<Pose, ArrayError> {
        let position: Vector3<f64> = self.point(row)?.coords;
        if self.0.len() == 3 {
            return Ok(Pose::translation(position.x, position.y, position.z));
        }
        let number = |column| self.number(column, row);
        let quaternion = [number(3)?, number(4)?, number(5)?, number(6)?];
        let what = format!("table, columns {} … {}", self.0[3].0, self.0[6].0);
        Ok(pose_from_parts(position, rotation(quaternion, &what, row)?))
    }

    /// The poses of all rows.
    ///
    /// # Errors
    /// Those of [`Self::pose`], and no rows.
    pub fn all(&self) -> Result<Vec<Pose>, ArrayError> {
        (0..self.rows()?).map(|row| self.pose(row)).collect()
    }
}

/// Content that was in memory, with what is suspected of it.
pub fn of_memory<T>(content: T, what: &str, suspicions: Vec<Suspicion>) -> Doubted<T> {
    Doubted::new(content, Path::new(what), suspicions)
}

/// What there is to be known of a table that was taken.
pub type Notes = Vec<String>;

/// A table's content; what is suspected of it is noted.
///
/// # Errors
/// A table that is beyond doubt not what it is read as.
pub fn take<T>(table: Doubted<T>, as_is: bool, notes: &mut Notes) -> Done<T> {
    let taken = table.take(as_is, |file, suspicion| {
        notes.push(format!("{}: {suspicion}", file.display()));
    });
    taken.map_err(|error| match error {
        StoreError::Doubted { .. } => {
            let text = format!("{error}; as_is=True takes the table as it stands");
            TrackwrightError::new_err(text).into()
        }
        error => error.into(),
    })
}

/// Issues what was noted as warnings.
///
/// # Errors
/// A warning that is made an exception.
pub fn warn_of(py: Python<'_>, notes: Notes) -> PyResult<()> {
    notes.iter().try_for_each(|note| warn(py, note))
}
