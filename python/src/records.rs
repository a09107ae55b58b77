//! Record arrays: tables that go out to Python, a named column a field, without a copy.

use crate::errors::Done;
use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// A column's type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Field {
    Float,
    Count,
    Flag,
}

/// A table that is filled row by row. Every cell has 8 bytes, so that its memory can be given to NumPy
/// as it is.
pub struct Records<const N: usize> {
    fields: [(&'static str, Field); N],
    words: Vec<u64>,
}

/// A cell's content.
#[derive(Clone, Copy, Debug)]
pub enum Cell {
    Float(f64),
    Count(usize),
    Flag(bool),
}

impl Cell {
    /// A number, or not a number where none is known.
    pub fn known(value: Option<f64>) -> Self {
        Self::Float(value.unwrap_or(f64::NAN))
    }

    /// The eight bytes of the cell; a flag is the first of them.
    fn word(self) -> u64 {
        match self {
            Self::Float(value) => value.to_bits(),
            Self::Count(value) => value as u64,
            Self::Flag(value) => u64::from_ne_bytes([u8::from(value), 0, 0, 0, 0, 0, 0, 0]),
        }
    }
}

impl<const N: usize> Records<N> {
    pub fn new(fields: [(&'static str, Field); N], rows: usize) -> Self {
        Self { fields, words: Vec::with_capacity(N * rows) }
    }

    /// Adds a row, its cells in the order of the fields.
    pub fn push(&mut self, row: [Cell; N]) {
        self.words.extend(row.map(Cell::word));
    }

    /// The record array.
    ///
    /// # Errors
    /// Python's own, such as of no memory.
    pub fn into_numpy(self, py: Python<'_>) -> Done<Bound<'_, PyAny>> {
        let numpy = py.import("numpy")?;
        let (names, formats): (Vec<_>, Vec<_>) = self
            .fields
            .iter()
            .map(|(name, field)| {
                let format = match field {
                    Field::Float => "f8",
                    Field::Count => "i8",
                    Field::Flag => "?",
                };
                (*name, format)
            })
            .unzip();
        let layout = PyDict::new(py);
        layout.set_item("names", names)?;
        layout.set_item("formats", formats)?;
        layout.set_item("offsets", (0..N).map(|k| 8 * k).collect::<Vec<_>>())?;
        layout.set_item("itemsize", 8 * N)?;
        let dtype = numpy.call_method1("dtype", (layout,))?;
        let array = self.words.into_pyarray(py);
        let records = array.call_method1("view", (dtype,))?;
        Ok(records.call_method1("view", (numpy.getattr("recarray")?,))?)
    }
}
