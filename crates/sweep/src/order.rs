//! The order of a table's rows by one of its columns.

use super::error::SweepError;
use super::read::SweepTable;
use rayon::prelude::*;
use std::cmp::Ordering;
use std::collections::BTreeSet;
use trackwright_task::{CancelToken, Cancelled};

/// Which of two rows goes first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Direction {
    /// The smallest first; texts by their letters.
    #[default]
    Ascending,
    Descending,
}

impl Direction {
    pub fn other(self) -> Self {
        match self {
            Self::Ascending => Self::Descending,
            Self::Descending => Self::Ascending,
        }
    }
}

impl SweepTable {
    /// The rows' places in the table, in the order of a column. Rows that have nothing there are last in
    /// both directions; of equal rows the one that is first in the table goes first.
    ///
    /// # Errors
    /// As [`numbers`](Self::numbers), and where it is cancelled.
    pub fn sorted_rows(
        &self,
        column: &str,
        direction: Direction,
        cancel: &CancelToken,
    ) -> Result<Vec<u64>, SweepError> {
        let is_text = self.columns().iter().any(|own| own.name == column && own.is_text);
        let keys = match is_text {
            false => self.numbers_until(column, cancel)?,
            true => ranks(&self.texts_until(column, cancel)?),
        };
        if cancel.is_cancelled() {
            return Err(Cancelled.into());
        }
        Ok(sorted(&keys, direction))
    }
}

/// Places of texts in their order; NaN of empty ones.
fn ranks(texts: &[String]) -> Vec<f64> {
    let distinct: BTreeSet<&str> = texts.iter().map(String::as_str).collect();
    let distinct: Vec<&str> = distinct.into_iter().collect();
    let rank = |text: &String| match text.as_str() {
        "" => f64::NAN,
        text => distinct.partition_point(|other| *other < text) as f64,
    };
    texts.par_iter().map(rank).collect()
}

fn sorted(keys: &[f64], direction: Direction) -> Vec<u64> {
    let mut rows: Vec<(f64, u64)> = keys.iter().copied().zip(0..).collect();
    rows.par_sort_unstable_by(|(a, a_row), (b, b_row)| {
        let keys = match (a.is_nan(), b.is_nan(), direction) {
            (false, false, Direction::Ascending) => a.partial_cmp(b).unwrap_or(Ordering::Equal),
            (false, false, Direction::Descending) => b.partial_cmp(a).unwrap_or(Ordering::Equal),
            (a_is_nan, b_is_nan, _) => a_is_nan.cmp(&b_is_nan),
        };
        keys.then(a_row.cmp(b_row))
    });
    rows.into_iter().map(|(_, row)| row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_without_a_number_are_last() {
        let keys = [2.0, f64::NAN, -1.0, 2.0, 0.0, -0.0, f64::NAN];
        assert_eq!(sorted(&keys, Direction::Ascending), [2, 4, 5, 0, 3, 1, 6]);
        assert_eq!(sorted(&keys, Direction::Descending), [0, 3, 4, 5, 2, 1, 6]);
        assert!(sorted(&[], Direction::Ascending).is_empty());
    }

    #[test]
    fn texts_have_the_order_of_their_letters() {
        let texts = ["room b", "", "room a", "room b"].map(str::to_owned);
        let ranks = ranks(&texts);
        assert_eq!(sorted(&ranks, Direction::Ascending), [2, 0, 3, 1]);
        assert_eq!(sorted(&ranks, Direction::Descending), [0, 3, 2, 1]);
    }
}
