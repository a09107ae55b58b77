//! Numbers and texts of fixed width, read from a body and written to one.

/// What a field of a message cannot hold.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum EncodeError {
    #[error("{field} {text:?} has {found} bytes, the message's field holds {limit}")]
    TooLong { field: &'static str, text: String, found: usize, limit: usize },
    #[error("{field}: {found}, the message's field holds {limit} at most")]
    TooMany { field: &'static str, found: usize, limit: usize },
}

/// A count as a field of the message has it.
pub fn counted<T: TryFrom<usize>>(
    found: usize,
    field: &'static str,
    limit: usize,
) -> Result<T, EncodeError> {
    T::try_from(found).map_err(|_| EncodeError::TooMany { field, found, limit })
}

/// Writes a text of fixed width, filled with zeros.
pub fn put_text(
    out: &mut Vec<u8>,
    text: &str,
    width: usize,
    field: &'static str,
) -> Result<(), EncodeError> {
    if text.len() > width {
        return Err(EncodeError::TooLong {
            field,
            text: text.chars().take(60).collect(),
            found: text.len(),
            limit: width,
        });
    }
    out.extend_from_slice(text.as_bytes());
    out.resize(out.len() + width - text.len(), 0);
    Ok(())
}

pub fn put_floats(out: &mut Vec<u8>, values: &[f32]) {
    for value in values {
        out.extend_from_slice(&value.to_be_bytes());
    }
}

/// The text before the first zero; `None` where it is not UTF-8 or has control characters.
pub fn text_of(bytes: &[u8]) -> Option<String> {
    let end = bytes.iter().position(|&b| b == 0).unwrap_or(bytes.len());
    let text = std::str::from_utf8(bytes.get(..end)?).ok()?;
    (!text.chars().any(char::is_control)).then(|| text.to_owned())
}

/// What is left to read; every read that finds too little gives `None`.
pub struct Reader<'a>(pub &'a [u8]);

impl<'a> Reader<'a> {
    pub fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    pub fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.take(N)?.try_into().ok()
    }

    pub fn u16(&mut self) -> Option<u16> {
        self.array().map(u16::from_be_bytes)
    }

    pub fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_be_bytes)
    }

    pub fn i64(&mut self) -> Option<i64> {
        self.array().map(i64::from_be_bytes)
    }

    pub fn floats<const N: usize>(&mut self) -> Option<[f32; N]> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = f32::from_be_bytes(self.array()?);
        }
        Some(values)
    }
}
