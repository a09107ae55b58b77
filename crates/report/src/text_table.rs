//! Tables as text: every column as wide as its widest cell.

use std::borrow::Cow;
use trackwright_formats::printable::printable;

/// The lines of a table, columns two spaces apart: so many from the left are text, flush left, the
/// others numbers, flush right. What a terminal would obey is escaped.
///
/// ```
/// use trackwright_report::text_table::columns;
/// let rows = [["pose", "mm"], ["a", "12.5"]].map(|row| row.map(str::to_owned).to_vec());
/// assert_eq!(columns(&rows, 1), ["pose    mm", "a     12.5"]);
/// ```
pub fn columns(rows: &[Vec<String>], left: usize) -> Vec<String> {
    lines(rows, |column| column >= left)
}

/// [`columns`], with the columns that are flush right named.
pub fn lines(rows: &[Vec<String>], is_right: impl Fn(usize) -> bool) -> Vec<String> {
    let rows: Vec<Vec<Cow<str>>> =
        rows.iter().map(|row| row.iter().map(|cell| printable(cell)).collect()).collect();
    let count = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| {
        let cells = rows.iter().filter_map(|row| row.get(column));
        cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..count).map(width).collect();
    let line = |row: &Vec<Cow<str>>| {
        let cells = row.iter().zip(&widths).enumerate();
        let padded = cells.map(|(column, (cell, &width))| match is_right(column) {
            true => format!("{cell:>width$}"),
            false => format!("{cell:<width$}"),
        });
        padded.collect::<Vec<_>>().join("  ").trim_end().to_owned()
    };
    rows.iter().map(line).collect()
}
