//! What a computation found, as every class for a result shows it.

use crate::errors::{Done, TrackwrightError};
use crate::tables::{Notes, warn_of};
use crate::values::to_python;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use trackwright_formats::printable::printable_lines;
use trackwright_report::section_html::section_html;
use trackwright_report::section_text::section_text;
use trackwright_result::{Refusal, Remedy, Section};

/// A result: its figures, and as a person reads them.
#[pyclass(frozen, subclass, module = "trackwright")]
pub struct Found {
    section: Section,
    /// Made when they are first read: loops read them often, or never.
    figures: PyOnceLock<Py<PyAny>>,
}

impl Found {
    /// A result, whose notes become warnings after those of what it was made from.
    ///
    /// # Errors
    /// A warning, where warnings are made exceptions.
    pub fn new(py: Python<'_>, section: Section, mut notes: Notes) -> PyResult<Self> {
        notes.extend(section.notes.iter().map(|note| note.sentence(Remedy::as_keyword)));
        warn_of(py, notes)?;
        Ok(Self { section, figures: PyOnceLock::new() })
    }
}

#[pymethods]
impl Found {
    /// The figures, as the program prints them with --format json.
    #[getter]
    fn figures(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let made = || to_python(py, &self.section.to_json()).map(Bound::unbind);
        Ok(self.figures.get_or_try_init(py, made)?.clone_ref(py))
    }

    fn __str__(&self) -> String {
        printable_lines(&section_text(&self.section)).into_owned()
    }

    fn _repr_html_(&self) -> String {
        section_html(&self.section).into_string()
    }
}

/// Why there is no result, with the keyword that lifts the refusal.
///
/// # Errors
/// Always that.
pub fn refuse<T>(what: &str, error: &impl Refusal) -> Done<T> {
    let text = format!("{what}: {}", error.with_remedy(Remedy::as_keyword));
    Err(TrackwrightError::new_err(text).into())
}
