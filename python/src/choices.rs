//! Options with a few named values, by the names that the command line has for them.

use crate::errors::TrackwrightError;
use pyo3::prelude::*;
use trackwright_design::BodyRole;
use trackwright_field::OutsidePolicy;

/// One of a few values, by its name.
///
/// # Errors
/// Another name.
pub fn one_of<T: Clone>(option: &str, name: &str, known: &[(&str, T)]) -> PyResult<T> {
    match known.iter().find(|(own, _)| *own == name) {
        Some((_, value)) => Ok(value.clone()),
        None => {
            let names: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
            let expected = names.join(", ");
            let text = format!("{option}: found {name:?}, expected one of {expected}");
            Err(TrackwrightError::new_err(text))
        }
    }
}

/// What happens to positions outside the model's box.
///
/// # Errors
/// Another name.
pub fn outside_policy(name: &str) -> PyResult<OutsidePolicy> {
    let known = [
        ("clamp", OutsidePolicy::Clamp),
        ("extrapolate", OutsidePolicy::Extrapolate),
        ("reject", OutsidePolicy::Reject),
    ];
    one_of("outside", name, &known)
}

/// One of a design's bodies.
///
/// # Errors
/// Another name.
pub fn body_role(name: &str) -> PyResult<BodyRole> {
    one_of("body", name, &[("tool", BodyRole::Tool), ("crf", BodyRole::Crf)])
}
