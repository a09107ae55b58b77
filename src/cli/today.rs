//! The day that a result is dated by.

use crate::design::Day;
use anyhow::anyhow;
use std::time::{SystemTime, UNIX_EPOCH};

/// Set by whoever wants the same bytes again: seconds since 1970 that stand for today.
const DATE_VARIABLE: &str = "SOURCE_DATE_EPOCH";

/// Today, or the day that stands for it.
///
/// # Errors
/// A variable that holds no day.
pub fn today() -> anyhow::Result<Day> {
    let seconds = match std::env::var(DATE_VARIABLE) {
        Err(_) => SystemTime::now()
            .duration_since(UNIX_EPOCH)
            .map_or(0, |since| since.as_secs() as i64),
        Ok(text) => text
            .trim()
            .parse()
            .map_err(|_| anyhow!("{DATE_VARIABLE}: found {text:?}, expected seconds since 1970"))?,
    };
    Day::of_unix_seconds(seconds).ok_or_else(|| {
        anyhow!("{DATE_VARIABLE}: found {seconds}, expected a time of the years 0 to 9999")
    })
}
