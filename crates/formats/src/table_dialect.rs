//! How a table is written: what is between its cells, its decimal mark, and names of columns that
//! are not quite the plain ones.

use super::error::FormatError;
use super::utf8::Utf8Reader;
use std::io::{self, Read};

/// Units that columns of a table have anyway.
const OWN_UNITS: [&str; 5] = ["mm", "millimetres", "millimeters", "1", "-"];

/// Units that they may be marked with, and are not read in.
const OTHER_UNITS: [&str; 17] = [
    "m", "metres", "meters", "cm", "in", "inch", "inches", "ft", "um", "µm", "μm", "nm", "deg",
    "degrees", "°", "rad", "radians",
];

/// What is between the cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Dialect {
    pub separator: u8,
}

/// What is before a number's decimals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DecimalMark {
    Comma,
    Point,
}

/// A column's name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct ColumnName {
    pub written: String,
    /// Small letters, no spaces, without a unit.
    pub plain: String,
    /// The unit that it is marked with, where it is not mm.
    pub unit: Option<String>,
}

impl Dialect {
    /// By the first line: a header's names have none of these letters, so the most frequent one is it.
    pub(super) fn of(head: &[u8]) -> Self {
        let mut counts = [(b',', 0), (b';', 0), (b'\t', 0)];
        let mut is_quoted = false;
        for byte in head {
            is_quoted ^= *byte == b'"';
            if let Some((_, count)) = counts.iter_mut().find(|c| c.0 == *byte && !is_quoted) {
                *count += 1;
            }
        }
        // The first of equals.
        let most = counts.iter().rev().max_by_key(|(_, count)| *count);
        Self { separator: most.map_or(b',', |(separator, _)| *separator) }
    }

    pub(super) fn may_have_decimal_commas(self) -> bool {
        self.separator != b','
    }

    /// The number of a cell, with a decimal comma where commas separate nothing.
    pub(super) fn number(self, cell: &str) -> Option<f64> {
        match self.may_have_decimal_commas() {
            true => decimal(cell),
            false => cell.parse().ok(),
        }
    }
}

impl DecimalMark {
    /// The mark that a cell has, where it has decimals.
    pub(super) fn of(cell: &str) -> Option<Self> {
        cell.bytes().find_map(|byte| match byte {
            b',' => Some(Self::Comma),
            b'.' => Some(Self::Point),
            _ => None,
        })
    }
}

/// A number with a decimal comma or point; with both it is no number.
pub(super) fn decimal(cell: &str) -> Option<f64> {
    match cell.contains('.') {
        true => cell.parse().ok(),
        false => cell.replacen(',', ".", 1).parse().ok(),
    }
}

/// The cells of a line of numbers without a header: apart by semicolons, commas or white space; commas
/// belong to the numbers where each cell has one at most, between digits.
pub(super) fn number_cells(line: &str) -> impl Iterator<Item = &str> + Clone {
    let has_decimal_commas = has_decimal_commas(line);
    let is_between =
        move |c: char| c.is_whitespace() || c == ';' || (c == ',' && !has_decimal_commas);
    line.split(is_between).filter(|cell| !cell.is_empty())
}

/// The first line that is neither empty nor a comment, with its number, and whether its first and its
/// last cell are numbers.
pub(super) fn first_cells(text: &str) -> Option<(u64, &str, [bool; 2])> {
    let mut lines = (1..).zip(text.lines().map(str::trim));
    let (line, first) = lines.find(|(_, line)| !line.is_empty() && !line.starts_with('#'))?;
    let is_number = |cell: Option<&str>| cell.is_some_and(|cell| decimal(cell).is_some());
    let cells = number_cells(first);
    Some((line, first, [is_number(cells.clone().next()), is_number(cells.last())]))
}

/// `1,5;2,5` and `1,5 2` are two numbers each, `1,2,3` and `1, 2` are as many as they have commas and one.
fn has_decimal_commas(line: &str) -> bool {
    let mut cells =
        line.split(|c: char| c.is_whitespace() || c == ';').filter(|cell| !cell.is_empty());
    let is_decimal = |cell: &str| match cell.split_once(',') {
        None => !cell.contains('.') && cell.parse::<f64>().is_ok(),
        Some((whole, rest)) => {
            let digits = rest.split(['e', 'E']).next().unwrap_or("");
            !whole.is_empty()
                && !digits.is_empty()
                && digits.bytes().all(|b| b.is_ascii_digit())
                && decimal(cell).is_some()
        }
    };
    line.contains(',') && cells.clone().count() > 1 && cells.all(is_decimal)
}

/// Whether each quote that begins a cell closes on its line, before the next separator. With a quote that
/// stays open, rows would become text of one cell.
///
/// # Errors
/// Names the line of any other quote.
pub(super) fn check_quotes(line: u64, content: &[u8], separator: u8) -> Result<(), FormatError> {
    let is_end = |byte: &u8| [separator, b'\r', b'\n'].contains(byte);
    let wrong = |at: usize, found: &str| {
        let found = format!("a quote at byte {} {found}", at + 1);
        Err(FormatError::line(line, found, "quotes around whole cells, each cell on one line"))
    };
    let mut at = 0;
    while let Some(cell) = content.get(at..).filter(|cell| !cell.is_empty()) {
        let begin = at;
        if cell[0] == b'"' {
            let is_closed = loop {
                at += 1;
                match content[at..] {
                    [b'"', b'"', ..] => at += 1,
                    [b'"', ..] => break true,
                    [] | [b'\r' | b'\n', ..] => break false,
                    _ => {}
                }
            };
            if !is_closed {
                return wrong(begin, "that does not close on this line");
            }
            at += 1;
            at += content[at..].iter().take_while(|byte| **byte == b' ').count();
            if content.get(at).is_some_and(|byte| !is_end(byte)) {
                return wrong(begin, "that closes within its cell");
            }
        }
        at += content[at..].iter().take_while(|byte| !is_end(byte)).count() + 1;
    }
    Ok(())
}

/// The cells of a line with commas between them, some of them in quotes.
///
/// # Errors
/// As [`check_quotes`].
pub(super) fn quoted_cells(line: u64, content: &str) -> Result<csv::StringRecord, FormatError> {
    check_quotes(line, content.as_bytes(), b',')?;
    cut_cells(line, content)
}

/// The same of a line that may be cut within quotes.
///
/// # Errors
/// None that a line of text is known to give; they name the line.
pub(super) fn cut_cells(line: u64, content: &str) -> Result<csv::StringRecord, FormatError> {
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .buffer_capacity(content.len() + 1)
        .from_reader(content.as_bytes());
    let mut record = csv::StringRecord::new();
    match reader.read_record(&mut record) {
        Ok(_) => Ok(record),
        Err(error) => {
            let expected = "a row of cells with commas between them";
            Err(FormatError::line(line, error.to_string(), expected))
        }
    }
}

impl ColumnName {
    pub(super) fn parse(written: &str) -> Self {
        let lower = written.trim().to_lowercase();
        let (name, marked) = match split_unit(&lower) {
            Some((name, unit)) => (name, Some(unit)),
            None => (lower.as_str(), None),
        };
        let is_own = |unit: &str| OWN_UNITS.contains(&unit) || unit.is_empty();
        Self {
            written: written.to_owned(),
            plain: name.trim().replace([' ', '-', '.'], "_"),
            unit: marked.filter(|unit| !is_own(unit)).map(str::to_owned),
        }
    }
}

/// `x (m)` is x in m, `x_mm` x in mm; `x (tracker)` is a name.
fn split_unit(name: &str) -> Option<(&str, &str)> {
    let is_unit =
        |unit: &str| OWN_UNITS.contains(&unit) || OTHER_UNITS.contains(&unit) || unit.is_empty();
    for (open, close) in [('(', ')'), ('[', ']')] {
        if let Some((name, unit)) = name.strip_suffix(close).and_then(|name| name.rsplit_once(open))
            && is_unit(unit.trim())
        {
            return Some((name, unit.trim()));
        }
    }
    // `ideal_m` may be any name, `ideal_mm` is a length.
    let name = name.strip_suffix("_mm").or_else(|| name.strip_suffix(" mm"))?;
    Some((name, "mm"))
}

/// The first line with its end, and not more; a spreadsheet's own line about the separator, before it,
/// becomes an empty one, so that lines keep their numbers.
pub(super) fn first_line<R: Read>(reader: &mut Utf8Reader<R>) -> io::Result<Vec<u8>> {
    let mut first = line(reader)?;
    let is_about_separator = first.get(..4).is_some_and(|head| head.eq_ignore_ascii_case(b"sep="));
    if is_about_separator {
        first = vec![b'\n'];
        first.extend(line(reader)?);
    }
    Ok(first)
}

fn line<R: Read>(reader: &mut Utf8Reader<R>) -> io::Result<Vec<u8>> {
    let mut all = Vec::new();
    loop {
        let next = reader.rest_of_line()?;
        all.extend_from_slice(next);
        // Empty lines before the header are none of it.
        if next.is_empty() || !next.trim_ascii().is_empty() {
            return Ok(all);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_line_shows_what_separates() {
        let of = |head: &str| Dialect::of(head.as_bytes()).separator as char;
        assert_eq!(of("x,y,z\n"), ',');
        assert_eq!(of("x;y;z"), ';');
        assert_eq!(of("x\ty\tz"), '\t');
        assert_eq!(of("\"a;b;c\",y"), ',');
        assert_eq!(of("x"), ',');
    }

    #[test]
    fn column_names_ignore_case_spaces_and_units() {
        for (written, plain, unit) in [
            ("ideal_x", "ideal_x", None),
            (" Ideal X ", "ideal_x", None),
            ("ideal_x (mm)", "ideal_x", None),
            ("X[mm]", "x", None),
            ("x_mm", "x", None),
            ("x (m)", "x", Some("m")),
            ("x [inch]", "x", Some("inch")),
            ("x (tracker)", "x_(tracker)", None),
            ("item_m", "item_m", None),
        ] {
            let found = ColumnName::parse(written);
            assert_eq!((found.plain.as_str(), found.unit.as_deref()), (plain, unit));
        }
    }

    #[test]
    fn decimal_commas_are_distinguished_from_separators() {
        let cells =
            |line| number_cells(line).map(|cell| decimal(cell).unwrap()).collect::<Vec<_>>();
        assert_eq!(cells("1,5;2,5;-3,25"), [1.5, 2.5, -3.25]);
        assert_eq!(cells("1,5 2 3,0e2"), [1.5, 2.0, 300.0]);
        assert_eq!(cells("1, 2; 3"), [1.0, 2.0, 3.0]);
        assert_eq!(cells("1,2,3"), [1.0, 2.0, 3.0]);
        assert_eq!(cells("1.5,2.5 3"), [1.5, 2.5, 3.0]);
    }
}
