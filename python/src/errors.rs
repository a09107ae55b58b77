//! What goes wrong, as Python exceptions with the text that the command line prints.

use pyo3::PyTypeInfo;
use pyo3::create_exception;
use pyo3::exceptions::{
    PyFileNotFoundError, PyIsADirectoryError, PyOSError, PyPermissionError, PyUserWarning,
    PyValueError,
};
use pyo3::prelude::*;
use std::ffi::CString;
use std::fmt;
use std::io;
use trackwright_formats::printable::printable_lines;
use trackwright_project::StoreError;
use trackwright_sweep::SweepError;

create_exception!(
    trackwright,
    TrackwrightError,
    PyValueError,
    "Input that cannot be used, with the text that the command line prints."
);
create_exception!(
    trackwright,
    TrackwrightWarning,
    PyUserWarning,
    "What is to be known of a result that is there all the same, with the text that the command line prints."
);

/// What stops a call: an error of a library, with context, or an exception that is there already.
#[derive(Debug)]
pub struct Failure(anyhow::Error);

/// What calls return.
pub type Done<T> = Result<T, Failure>;

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:#}", self.0)
    }
}

impl<E: Into<anyhow::Error>> From<E> for Failure {
    fn from(error: E) -> Self {
        Self(error.into())
    }
}

impl From<Failure> for PyErr {
    fn from(Failure(error): Failure) -> Self {
        let error = match error.downcast::<Self>() {
            Ok(exception) => return exception,
            Err(error) => error,
        };
        let text = printable_lines(&format!("{error:#}")).into_owned();
        match file_problem(&error) {
            None => TrackwrightError::new_err(text),
            Some(io::ErrorKind::NotFound) => PyFileNotFoundError::new_err(text),
            Some(io::ErrorKind::PermissionDenied) => PyPermissionError::new_err(text),
            Some(io::ErrorKind::IsADirectory) => PyIsADirectoryError::new_err(text),
            Some(_) => PyOSError::new_err(text),
        }
    }
}

/// What the system had against a file, where it is that which went wrong.
fn file_problem(error: &anyhow::Error) -> Option<io::ErrorKind> {
    let of_store = |error: &StoreError| match error {
        StoreError::Read { cause, .. }
        | StoreError::Write { cause, .. }
        | StoreError::Lock { cause, .. } => Some(cause.kind()),
        _ => None,
    };
    error.chain().find_map(|cause| match cause.downcast_ref::<SweepError>() {
        Some(SweepError::Store(error)) => of_store(error),
        Some(SweepError::Io { cause, .. }) => Some(cause.kind()),
        _ => of_store(cause.downcast_ref()?),
    })
}

/// Issues a [`TrackwrightWarning`].
///
/// # Errors
/// The warning itself, where warnings are made exceptions.
pub fn warn(py: Python<'_>, text: &str) -> PyResult<()> {
    // A text with a zero in it is escaped like any other that nobody could see.
    let text = CString::new(printable_lines(text).into_owned())?;
    PyErr::warn(py, TrackwrightWarning::type_object(py).as_any(), &text, 1)
}
