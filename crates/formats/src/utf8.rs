//! Text as it comes: UTF-8 is checked on the way, a byte order mark left out, no line of a table is
//! without end, and each quote closes on its line.

use super::error::FormatError;
use super::table_dialect::check_quotes;
use std::io::{self, BufRead, BufReader, Read};

/// The mark that some programs put before UTF-8 text.
const BYTE_ORDER_MARK: &[u8] = "\u{feff}".as_bytes();

/// Longest line of a table in bytes: a thousand columns of a thousand letters. What is longer is no
/// table.
const MAX_ROW: usize = 1 << 20;

/// A reader of text, line by line: the bytes of another one as long as they are UTF-8, then an error.
pub struct Utf8Reader<R: Read> {
    inner: BufReader<R>,
    /// The line that is given out, and how much of it was.
    content: Vec<u8>,
    given: usize,
    /// Its number, from 1.
    line: usize,
    /// What is between the cells of a table.
    separator: Option<u8>,
}

/// What a text cannot hold, carried through an [`io::Error`].
fn wrong(error: FormatError) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, error)
}

/// The error behind what a [`Utf8Reader`] gave: what is wrong with the text, or the reader's own.
pub fn error_of(error: &io::Error) -> FormatError {
    match error.get_ref().and_then(|inner| inner.downcast_ref::<FormatError>()) {
        Some(wrong) => wrong.clone(),
        None => FormatError::Unreadable { kind: error.kind(), found: error.to_string() },
    }
}

impl<R: Read> Utf8Reader<R> {
    pub fn new(inner: R) -> Self {
        let inner = BufReader::new(inner);
        Self { inner, content: Vec::new(), given: 0, line: 0, separator: None }
    }

    /// States that the line that was given out, and those after it, are rows with this between their
    /// cells: from here on their quotes are checked.
    ///
    /// # Errors
    /// A quote of this line that does not close on it.
    pub fn begin_rows(&mut self, separator: u8) -> Result<(), FormatError> {
        self.separator = Some(separator);
        check_quotes(self.line as u64, &self.content, separator)
    }

    /// Checks the next line, or what there is of one that is too long; nothing at the end of the text.
    fn next_line(&mut self) -> io::Result<()> {
        self.content.clear();
        let most = MAX_ROW as u64 + 1;
        self.inner.by_ref().take(most).read_until(b'\n', &mut self.content)?;
        self.line += 1;
        if let Err(error) = std::str::from_utf8(&self.content)
            && (self.content.len() <= MAX_ROW || error.error_len().is_some())
        {
            let column = 1 + error.valid_up_to();
            return Err(wrong(FormatError::NotUtf8 { line: self.line, column }));
        }
        if self.content.len() > MAX_ROW {
            let found = format!("a row of more than {MAX_ROW} bytes");
            return Err(wrong(FormatError::line(self.line as u64, found, "shorter rows")));
        }
        if let Some(separator) = self.separator {
            check_quotes(self.line as u64, &self.content, separator).map_err(wrong)?;
        }
        let is_marked = self.line == 1 && self.content.starts_with(BYTE_ORDER_MARK);
        self.given = if is_marked { BYTE_ORDER_MARK.len() } else { 0 };
        Ok(())
    }

    /// The rest of the line that is given out, else the next one; empty at the end of the text.
    ///
    /// # Errors
    /// A byte that is no text, a row that is too long, or the reader's own.
    pub fn rest_of_line(&mut self) -> io::Result<&[u8]> {
        if self.given == self.content.len() {
            self.next_line()?;
        }
        Ok(&self.content[std::mem::replace(&mut self.given, self.content.len())..])
    }
}

impl<R: Read> Read for Utf8Reader<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if self.given == self.content.len() {
            self.next_line()?;
        }
        let count = out.len().min(self.content.len() - self.given);
        out[..count].copy_from_slice(&self.content[self.given..self.given + count]);
        self.given += count;
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::super::error::text;
    use super::*;
    use proptest::prelude::*;

    /// Gives a few bytes at a time.
    struct Trickle<'a>(&'a [u8], usize);

    impl Read for Trickle<'_> {
        fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
            let count = self.1.min(out.len()).min(self.0.len());
            out[..count].copy_from_slice(&self.0[..count]);
            self.0 = &self.0[count..];
            Ok(count)
        }
    }

    fn read(bytes: &[u8], step: usize) -> Result<String, FormatError> {
        let mut out = Vec::new();
        match Utf8Reader::new(Trickle(bytes, step)).read_to_end(&mut out) {
            Ok(_) => Ok(String::from_utf8(out).unwrap()),
            Err(error) => Err(error_of(&error)),
        }
    }

    #[test]
    fn a_row_without_end_is_refused_where_it_begins() {
        use crate::table::Table;
        let rows_of = |text: &str| Table::parse(text.as_bytes())?.read(|_| Ok(()));
        let long = "1".repeat(MAX_ROW + (1 << 14));
        let error = rows_of(&format!("x,y\n1,2\n{long}")).unwrap_err().to_string();
        assert_eq!(error, "line 3: found a row of more than 1048576 bytes, expected shorter rows");
        let short = format!("x,y\n{}", "1,2\n".repeat(MAX_ROW / 2));
        assert!(rows_of(&short).is_ok());
        let header = rows_of(&long).unwrap_err().to_string();
        assert!(header.starts_with("line 1: found a row of more"), "{header}");
    }

    #[test]
    fn a_long_text_comes_through_whole() {
        let text = "länge, 12.5\n".repeat((1 << 16) / 7);
        assert_eq!(read(text.as_bytes(), usize::MAX).unwrap(), text);
        assert_eq!(read(text.as_bytes(), 4099).unwrap(), text);
        let marked = format!("\u{feff}{text}");
        assert_eq!(read(marked.as_bytes(), 1).unwrap(), text);
    }

    proptest! {
        #[test]
        fn what_comes_in_pieces_is_what_the_whole_is(
            start in prop::collection::vec(prop::sample::select(
                b"a\n,\xc3\xa4\xef\xbb\xbf\xf0\x9f\x98\x80\xff".to_vec()), 0..40),
            step in 1..9_usize,
        ) {
            let whole = text(&start).map(str::to_owned);
            prop_assert_eq!(read(&start, step), whole);
        }
    }
}
