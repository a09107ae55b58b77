//! The day that a result is dated by.

use std::time::{SystemTime, UNIX_EPOCH};
use trackwright_design::Day;

/// Set by whoever wants the same bytes again: seconds since 1970 that stand for today.
const DATE_VARIABLE: &str = "SOURCE_DATE_EPOCH";

/// A variable that holds no day.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{DATE_VARIABLE}: found {found:?}, expected seconds since 1970, within the years 0 to 9999"
)]
pub struct NoToday {
    pub found: String,
}

/// Today in Greenwich, or the day that stands for it.
///
/// # Errors
/// See [`NoToday`].
pub fn today() -> Result<Day, NoToday> {
    let text = match std::env::var(DATE_VARIABLE) {
        Ok(text) => text,
        Err(_) => SystemTime::now()
            .duration_since(UNIX_EPOCH)
            .map_or(0, |since| since.as_secs())
            .to_string(),
    };
    let seconds = text.trim().parse().ok();
    seconds.and_then(Day::of_unix_seconds).ok_or(NoToday { found: text })
}
