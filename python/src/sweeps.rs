//! Sweeps: a plan's rows computed in parts, merged, and read as arrays.

use crate::errors::Done;
use crate::long_work;
use crate::tables::warn_of;
use crate::values::to_python;
use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use std::cell::RefCell;
use std::path::PathBuf;
use trackwright_project::Files;
use trackwright_sweep::{self as sweep, Folder, Part, merge, run, status};

/// A plan of many designs in many rooms, with all that it refers to.
#[pyclass(frozen, module = "trackwright")]
pub struct Sweep(sweep::Sweep);

#[pymethods]
impl Sweep {
    /// Opens a plan (`*.sweep.ron`) with the designs, rooms and poses that it names.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> Done<Self> {
        let found = long_work::run(py, |_| Ok(sweep::Sweep::open(&path)?))?;
        let each = found.problems().into_iter();
        let notes = each.map(|problem| format!("{problem}; all its rows will state it"));
        warn_of(py, notes.collect())?;
        Ok(Self(found))
    }

    /// Number of rows: points, rooms and motions of each design.
    #[getter]
    fn rows(&self) -> u64 {
        self.0.rows()
    }

    /// Computes the rows of a part that are missing, and writes them into a folder: as `trackwright sweep`.
    ///
    /// shard: the part's number, from 1, and how many parts there are. progress: called by the thread that
    /// calls, some times a second, with the part of the rows that is there, 0 to 1; an exception of it ends
    /// the work. Rows that are computed when the work ends are written before. The result is what the command
    /// prints with `--format json`, without the time.
    #[pyo3(signature = (folder, *, shard = (1, 1), progress = None))]
    fn compute<'py>(
        &self,
        py: Python<'py>,
        folder: PathBuf,
        shard: (i64, i64),
        progress: Option<&Bound<'py, PyAny>>,
    ) -> Done<Bound<'py, PyAny>> {
        let part: Part = format!("{}/{}", shard.0, shard.1).parse()?;
        let (report, notes) = long_work::run_with_progress(py, progress, |task| {
            let folder = Folder::open(&folder, &self.0)?;
            let notes = RefCell::new(Vec::new());
            let note = |text: &str| notes.borrow_mut().push(text.to_owned());
            let report = run(&self.0, &folder, part, task, &note)?;
            Ok((report, notes.into_inner()))
        })?;
        warn_of(py, notes)?;
        Ok(to_python(py, &report.section(None).to_json())?)
    }

    fn __repr__(&self) -> String {
        format!("<trackwright.Sweep of {} rows>", self.0.rows())
    }
}

/// Which rows of a sweep's folder are there: as `trackwright sweep status --format json` prints it.
#[pyfunction]
pub fn sweep_status(py: Python<'_>, folder: PathBuf) -> Done<Bound<'_, PyAny>> {
    let status = long_work::run(py, |_| Ok(status(&folder)?))?;
    Ok(to_python(py, &status.section().to_json())?)
}

/// Writes all rows of a sweep's folder to one file (`*.parquet`), in order: as `trackwright sweep merge`, and
/// with the same bytes.
///
/// progress as for Sweep.compute. A file that is not the merge of the same plan is written over only with overwrite=True.
#[pyfunction]
#[pyo3(signature = (folder, path, *, overwrite = false, progress = None))]
pub fn merge_sweep<'py>(
    py: Python<'py>,
    folder: PathBuf,
    path: PathBuf,
    overwrite: bool,
    progress: Option<&Bound<'py, PyAny>>,
) -> Done<Bound<'py, PyAny>> {
    let report = long_work::run_with_progress(py, progress, |task| {
        let files = Files::overwriting(overwrite);
        let output = files.output(&path)?;
        let (sweep, folder) = Folder::existing(&folder)?;
        sweep.inputs().iter().try_for_each(|file| files.input(file))?;
        Ok(merge(&sweep, &folder, &output, task)?)
    })?;
    Ok(to_python(py, &report.section(&path).to_json())?)
}

/// The rows of a sweep, read column by column as they are needed.
#[pyclass(frozen, module = "trackwright")]
pub struct SweepTable(sweep::SweepTable);

#[pymethods]
impl SweepTable {
    /// Opens a merged file, or a folder with the rows that are there; reads no row yet.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> Done<Self> {
        Ok(Self(long_work::run(py, |_| Ok(sweep::SweepTable::open(&path)?))?))
    }

    /// Number of rows.
    #[getter]
    fn rows(&self) -> u64 {
        self.0.rows()
    }

    /// The names of the columns, in order, each with the unit of its numbers: "mm", "deg", or nothing.
    #[getter]
    fn columns<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let columns = PyDict::new(py);
        for column in self.0.columns() {
            columns.set_item(column.name, column.unit)?;
        }
        Ok(columns)
    }

    /// The names of the columns of what varies.
    #[getter]
    fn parameters(&self) -> Vec<String> {
        self.0.parameters()
    }

    /// A column, shape (rows,): numbers as floats, not a number where there is none; texts as objects, empty
    /// where there is none; `requirement_met` as 1, 0 or not a number.
    fn __getitem__<'py>(&self, py: Python<'py>, name: &str) -> Done<Bound<'py, PyAny>> {
        let is_text = |column: &sweep::Column| column.name == name && column.is_text;
        if !self.0.columns().iter().any(is_text) {
            let numbers = long_work::run(py, |_| Ok(self.0.numbers(name)?))?;
            return Ok(numbers.into_pyarray(py).into_any());
        }
        let texts = long_work::run(py, |_| Ok(self.0.texts(&[name], 0..self.0.rows())?))?;
        let texts = PyList::new(py, texts.into_iter().next().unwrap_or_default())?;
        Ok(py.import("numpy")?.call_method1("array", (texts, "object"))?)
    }

    fn __repr__(&self) -> String {
        format!("<trackwright.SweepTable of {} rows>", self.0.rows())
    }
}
