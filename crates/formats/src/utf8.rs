//! Text as it comes: UTF-8 is checked on the way, a byte order mark left out, and no row of a table
//! without end.

use super::error::FormatError;
use std::io::{self, Read};

/// Bytes that are read at a time.
const BUFFER: usize = 1 << 16;

/// The mark that some programs put before UTF-8 text.
const BYTE_ORDER_MARK: &[u8] = "\u{feff}".as_bytes();

/// Longest row of a table in bytes: a thousand columns of a thousand letters. What is longer is no
/// table, or has a quote that nobody closed.
const MAX_ROW: usize = 1 << 20;

/// Longest character in bytes.
const MAX_CHARACTER: usize = 4;

/// A reader of text: the bytes of another one as long as they are UTF-8, then an error.
pub struct Utf8Reader<R: Read> {
    inner: R,
    /// Checked up to `end`, given out up to `start`; behind `end` up to `filled` the beginning of
    /// a character.
    buffer: Vec<u8>,
    start: usize,
    end: usize,
    filled: usize,
    is_at_start: bool,
    /// Where the checked bytes end, from 1.
    line: usize,
    column: usize,
    /// Where the row begins that is being read, from 1, and how much of it was given out.
    row_line: u64,
    row_bytes: usize,
}

/// A byte that is no text, carried through an [`io::Error`].
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("line {line}, column {column}: found a byte that is not UTF-8, expected text")]
struct NotUtf8 {
    line: usize,
    column: usize,
}

/// A row without end, carried likewise.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("line {line}: found a row of more than {MAX_ROW} bytes")]
struct LongRow {
    line: u64,
}

/// The error behind what a [`Utf8Reader`] gave: a byte that is no text, or the reader's own.
pub fn error_of(error: &io::Error) -> FormatError {
    let inner = error.get_ref();
    if let Some(&NotUtf8 { line, column }) = inner.and_then(|e| e.downcast_ref()) {
        return FormatError::NotUtf8 { line, column };
    }
    if let Some(&LongRow { line }) = inner.and_then(|e| e.downcast_ref()) {
        return FormatError::Line {
            line,
            found: format!("a row of more than {MAX_ROW} bytes"),
            expected: "shorter rows, and an end to each quote".to_owned(),
        };
    }
    FormatError::Unreadable { kind: error.kind(), found: error.to_string() }
}

impl<R: Read> Utf8Reader<R> {
    pub fn new(inner: R) -> Self {
        Self {
            inner,
            buffer: vec![0; BUFFER],
            start: 0,
            end: 0,
            filled: 0,
            is_at_start: true,
            line: 1,
            column: 1,
            row_line: 1,
            row_bytes: 0,
        }
    }

    /// States that what is read from here on is another row, which begins at a line.
    pub fn begin_row(&mut self, line: u64) {
        self.row_line = line;
        self.row_bytes = 0;
    }

    /// Reads on and checks; leaves nothing to give out at the end of the text only.
    fn fill(&mut self) -> io::Result<()> {
        loop {
            self.buffer.copy_within(self.end..self.filled, 0);
            self.filled -= self.end;
            (self.start, self.end) = (0, 0);
            let read = self.inner.read(&mut self.buffer[self.filled..])?;
            self.filled += read;
            // A mark or a character may come in pieces.
            let is_whole = read == 0 || self.filled >= MAX_CHARACTER;
            if is_whole {
                self.check(read == 0)?;
            }
            if read == 0 || self.end > self.start {
                return Ok(());
            }
        }
    }

    /// Moves `end` behind the last whole character.
    fn check(&mut self, is_last: bool) -> io::Result<()> {
        let bytes = &self.buffer[..self.filled];
        self.end = match std::str::from_utf8(bytes) {
            Ok(_) => self.filled,
            Err(error) if error.error_len().is_none() && !is_last => error.valid_up_to(),
            Err(error) => {
                self.advance(error.valid_up_to());
                let (line, column) = (self.line, self.column);
                return Err(io::Error::new(io::ErrorKind::InvalidData, NotUtf8 { line, column }));
            }
        };
        self.advance(self.end);
        if std::mem::take(&mut self.is_at_start)
            && self.buffer[..self.end].starts_with(BYTE_ORDER_MARK)
        {
            self.start = BYTE_ORDER_MARK.len();
        }
        Ok(())
    }

    /// Counts lines and columns over the first bytes of the buffer.
    fn advance(&mut self, count: usize) {
        let bytes = &self.buffer[..count];
        let breaks = bytes.iter().filter(|&&b| b == b'\n').count();
        self.line += breaks;
        self.column = match bytes.iter().rposition(|&b| b == b'\n') {
            Some(last) => count - last,
            None => self.column + count,
        };
    }
}

impl<R: Read> Read for Utf8Reader<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if self.start == self.end {
            self.fill()?;
        }
        if self.row_bytes > MAX_ROW {
            let line = self.row_line;
            return Err(io::Error::new(io::ErrorKind::InvalidData, LongRow { line }));
        }
        let count = out.len().min(self.end - self.start);
        self.row_bytes += count;
        out[..count].copy_from_slice(&self.buffer[self.start..self.start + count]);
        self.start += count;
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
        let long = "1".repeat(MAX_ROW + (1 << 14));
        let quoted = format!("1,\"{}", "2,3\n".repeat(MAX_ROW / 3));
        for (rows, line) in [(&long, 3), (&quoted, 3)] {
            let text = format!("x,y\n1,2\n{rows}");
            let error = Table::parse(text.as_bytes()).unwrap_err().to_string();
            assert_eq!(
                error,
                format!(
                    "line {line}: found a row of more than 1048576 bytes, expected shorter rows, \
                     and an end to each quote"
                )
            );
        }
        let short = format!("x,y\n{}", "1,2\n".repeat(MAX_ROW / 2));
        assert!(Table::parse(short.as_bytes()).is_ok());
        let header = Table::parse(long.as_bytes()).unwrap_err().to_string();
        assert!(header.starts_with("line 1: found a row of more"), "{header}");
    }

    #[test]
    fn a_long_text_comes_through_whole() {
        let text = "länge, 12.5\n".repeat(BUFFER / 7);
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
