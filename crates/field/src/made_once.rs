//! A value that is made when it is first wanted, by parallel work.

use std::sync::OnceLock;

/// The value of a cell, made without the cell being held: a thread that waits for the rest of its parallel work
/// may take up other work of its pool that wants the same value, and would then wait for itself. At worst the
/// value is made more than once.
pub(crate) fn made_once<T>(cell: &OnceLock<T>, make: impl FnOnce() -> T) -> &T {
    if let Some(value) = cell.get() {
        return value;
    }
    let made = make();
    cell.get_or_init(|| made)
}
