//! Keywords of calls that have many: each is taken by its name, and none may be left over.

use crate::choices::one_of;
use crate::errors::{Done, TrackwrightError};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::cell::RefCell;

/// The keywords of a call. One that is `None` counts as not given.
pub struct Keywords<'a, 'py> {
    given: Option<&'a Bound<'py, PyDict>>,
    known: RefCell<Vec<&'static str>>,
}

impl<'a, 'py> Keywords<'a, 'py> {
    pub fn of(given: Option<&'a Bound<'py, PyDict>>) -> Self {
        Self { given, known: RefCell::default() }
    }

    /// A keyword's object, where it is given.
    ///
    /// # Errors
    /// Python's own.
    pub fn object(&self, name: &'static str) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.known.borrow_mut().push(name);
        let found = self.given.map(|given| given.get_item(name)).transpose()?.flatten();
        Ok(found.filter(|value| !value.is_none()))
    }

    /// A keyword's value, where it is given.
    ///
    /// # Errors
    /// One of another type.
    pub fn value<T>(&self, name: &'static str) -> Done<Option<T>>
    where
        T: for<'b> FromPyObject<'b, 'py, Error: Into<PyErr>>,
    {
        let Some(found) = self.object(name)? else { return Ok(None) };
        let refused = |_| {
            let text = format!("{name}: found {found}, which is not what is expected of it");
            TrackwrightError::new_err(text)
        };
        let value = found.extract::<T>().map_err(Into::into);
        Ok(Some(value.map_err(refused)?))
    }

    /// One of a few values by its name, or the first of them.
    ///
    /// # Errors
    /// Another name.
    pub fn one_of<T: Clone>(&self, name: &'static str, known: &[(&str, T)]) -> Done<T> {
        match self.value::<String>(name)? {
            Some(found) => Ok(one_of(name, &found, known)?),
            None => Ok(known[0].1.clone()),
        }
    }

    /// Whether a switch is on.
    ///
    /// # Errors
    /// What is neither true nor false.
    pub fn flag(&self, name: &'static str, default: bool) -> Done<bool> {
        Ok(self.value(name)?.unwrap_or(default))
    }

    /// A finite number in its range.
    ///
    /// # Errors
    /// Another number.
    pub fn number(
        &self,
        name: &'static str,
        expected: &str,
        is_fine: fn(f64) -> bool,
    ) -> Done<Option<f64>> {
        let value: Option<f64> = self.value(name)?;
        match value {
            Some(found) if !(found.is_finite() && is_fine(found)) => {
                let text = format!("{name}: found {found}, expected {expected}");
                Err(TrackwrightError::new_err(text).into())
            }
            value => Ok(value),
        }
    }

    /// Refuses keywords that nothing has looked for.
    ///
    /// # Errors
    /// Such a keyword.
    pub fn finish(self) -> Done<()> {
        for (name, _) in self.given.into_iter().flatten() {
            let name: String = name.extract()?;
            if !self.known.borrow().contains(&name.as_str()) {
                let text = format!("found an unexpected keyword argument {name:?}");
                return Err(PyTypeError::new_err(text).into());
            }
        }
        Ok(())
    }
}
