//! The word in an NDI image that is both its serial number and the day it was made.

/// Four bytes: a number within the day (10 bits), the day of the year (9), the month (4) and the
/// year since 1900 (9). NDI prints it as one little-endian number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SerialWord(pub [u8; 4]);

/// A day of the Gregorian calendar.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CalendarDate {
    pub year: u16,
    /// 1 to 12.
    pub month: u8,
    /// 1 to 31.
    pub day: u8,
}

const FIRST_YEAR: u16 = 1900;
/// Nine bits of years.
const YEARS: u16 = 512;
/// Ten bits of numbers.
const NUMBERS: u16 = 1024;

impl SerialWord {
    /// The word of the `sequence`-th tool of a day; `None` for what has no place in it.
    pub fn new(sequence: u16, date: CalendarDate) -> Option<Self> {
        let years = date.year.checked_sub(FIRST_YEAR).filter(|y| *y < YEARS)?;
        if sequence >= NUMBERS {
            return None;
        }
        let day = date.day_of_year()? - 1;
        let month = u16::from(date.month) - 1;
        Some(Self([
            low_byte(sequence),
            low_byte((sequence >> 8) | (day & 63) << 2),
            low_byte((day >> 6) | month << 3 | (years & 1) << 7),
            low_byte(years >> 1),
        ]))
    }

    /// As NDI prints it, in hexadecimal.
    pub fn number(self) -> u32 {
        u32::from_le_bytes(self.0)
    }

    /// Which tool of its day it is.
    pub fn sequence(self) -> u16 {
        u16::from(self.0[0]) | u16::from(self.0[1] & 3) << 8
    }

    /// The day; `None` where the year has no such day, or it lies in another month than the word
    /// says.
    pub fn date(self) -> Option<CalendarDate> {
        let [_, b1, b2, b3] = self.0.map(u16::from);
        let year = FIRST_YEAR + 2 * b3 + (b2 >> 7);
        let mut day = (b2 & 7) << 6 | b1 >> 2;
        for month in 1..=12_u8 {
            let days = u16::from(days_of_month(year, month));
            if day < days {
                let is_named = u16::from(month) == (b2 >> 3 & 15) + 1;
                return is_named.then_some(CalendarDate { year, month, day: low_byte(day + 1) });
            }
            day -= days;
        }
        None
    }
}

impl std::fmt::Display for SerialWord {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:08X}", self.number())
    }
}

impl CalendarDate {
    /// Counted from 1; `None` for a day that the calendar does not have.
    fn day_of_year(self) -> Option<u16> {
        let is_day = (1..=12).contains(&self.month)
            && (1..=days_of_month(self.year, self.month)).contains(&self.day);
        let before = (1..self.month).map(|m| u16::from(days_of_month(self.year, m)));
        is_day.then(|| before.sum::<u16>() + u16::from(self.day))
    }
}

impl std::fmt::Display for CalendarDate {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}-{:02}-{:02}", self.year, self.month, self.day)
    }
}

fn days_of_month(year: u16, month: u8) -> u8 {
    let is_leap = year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
    match month {
        2 if is_leap => 29,
        2 => 28,
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    }
}

fn low_byte(value: u16) -> u8 {
    value.to_le_bytes()[0]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn words_of_real_tools_are_the_days_they_were_made() {
        // NDI's own passive probe, and its Mini 6DOF sensor.
        for (bytes, number, date) in [
            ([0x03, 0x14, 0x80, 0x34], "34801403", "2005-01-06"),
            ([0x00, 0x10, 0x91, 0x37], "37911000", "2011-03-10"),
        ] {
            let word = SerialWord(bytes);
            assert_eq!(word.to_string(), number);
            assert_eq!(word.date().unwrap().to_string(), date);
        }
        assert_eq!(SerialWord([0x03, 0x14, 0x80, 0x34]).sequence(), 3);
        // Day 366 (5 * 64 + 45, from 0) of a year that has 365, and a January day that calls itself a February one.
        assert_eq!(SerialWord([0, 45 << 2, 0x80 | 11 << 3 | 5, 50]).date(), None);
        assert_eq!(SerialWord([0, 0, 1 << 3, 50]).date(), None);
    }

    proptest! {
        #[test]
        fn any_tool_of_any_day_has_its_own_word(
            sequence in 0..NUMBERS, year in FIRST_YEAR..FIRST_YEAR + YEARS, month in 1..=12_u8, day in 1..=31_u8,
        ) {
            let date = CalendarDate { year, month, day };
            match SerialWord::new(sequence, date) {
                None => prop_assert!(day > days_of_month(year, month)),
                Some(word) => {
                    prop_assert_eq!(word.date(), Some(date));
                    prop_assert_eq!(word.sequence(), sequence);
                }
            }
        }
    }
}
