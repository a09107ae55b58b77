//! A day of the calendar, as decisions are dated: `2005-10-26`.

use std::fmt;
use std::str::FromStr;
use time::{Date, Month, OffsetDateTime};

/// A day of the years 0 to 9999, which ISO 8601 writes with ten characters.
///
/// ```
/// use trackwright_design::Day;
///
/// let day: Day = "2005-10-26".parse()?;
/// assert_eq!(day.to_string(), "2005-10-26");
/// assert!("2005-02-30".parse::<Day>().is_err());
/// # Ok::<(), trackwright_design::NoDay>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Day(Date);

/// A text that is no day.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no day of the calendar")]
pub struct NoDay;

impl Day {
    /// The day in Greenwich so many seconds after 1970 began; `None` outside the years 0 to 9999.
    pub fn of_unix_seconds(seconds: i64) -> Option<Self> {
        let date = OffsetDateTime::from_unix_timestamp(seconds).ok()?.date();
        (0..=9999).contains(&date.year()).then_some(Self(date))
    }
}

impl FromStr for Day {
    type Err = NoDay;

    /// Ten characters, nothing around them.
    fn from_str(text: &str) -> Result<Self, NoDay> {
        let bytes: &[u8; 10] = text.as_bytes().try_into().map_err(|_| NoDay)?;
        let [a, b, c, d, b'-', e, f, b'-', g, h] = bytes else {
            return Err(NoDay);
        };
        let number = |digits: &[&u8]| {
            digits.iter().try_fold(0u16, |sum, digit| {
                let value = digit.is_ascii_digit().then(|| *digit - b'0')?;
                Some(10 * sum + u16::from(value))
            })
        };
        let year = number(&[a, b, c, d]).ok_or(NoDay)?;
        let month = number(&[e, f]).and_then(|m| u8::try_from(m).ok());
        let month = month.and_then(|m| Month::try_from(m).ok()).ok_or(NoDay)?;
        let day = number(&[g, h]).and_then(|d| u8::try_from(d).ok());
        let date = Date::from_calendar_date(i32::from(year), month, day.ok_or(NoDay)?);
        date.map(Self).map_err(|_| NoDay)
    }
}

impl fmt::Display for Day {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let date = self.0;
        let (year, month) = (date.year(), u8::from(date.month()));
        write!(f, "{year:04}-{month:02}-{:02}", date.day())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn what_is_no_day_is_none() {
        for text in [
            "",
            "2005-10-6",
            "2005-02-29",
            "2005-13-01",
            "2005-00-01",
            "2005-10-00",
            "+005-10-26",
            "2005/10/26",
            "2005-10-26 ",
            "20\u{fc}5-10-2",
            "12005-10-2",
        ] {
            assert_eq!(text.parse::<Day>(), Err(NoDay), "{text}");
        }
        assert_eq!("2004-02-29".parse::<Day>().unwrap().to_string(), "2004-02-29");
        assert_eq!(Day::of_unix_seconds(0).unwrap().to_string(), "1970-01-01");
        assert_eq!(Day::of_unix_seconds(i64::MAX), None);
    }

    proptest! {
        #[test]
        fn every_day_reads_back(seconds in -62_167_219_200_i64..253_402_300_800) {
            let day = Day::of_unix_seconds(seconds).unwrap();
            prop_assert_eq!(day.to_string().parse(), Ok(day));
        }
    }
}
