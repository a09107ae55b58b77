//! The 58 bytes before every body, the checksum of the body, and how numbers and texts of fixed width
//! are read and written.

use crc::{CRC_64_ECMA_182, Crc, Table};
use std::time::Duration;

pub const HEADER_BYTES: usize = 58;

/// The longest name of a device, or of a tool in a list of tracking data.
pub const NAME_BYTES: usize = 20;

/// The longest name of a message's type.
const KIND_BYTES: usize = 12;

/// ECMA-182: nothing reflected, nothing inverted.
const CHECKSUM: Crc<u64, Table<1>> = Crc::<u64, Table<1>>::new(&CRC_64_ECMA_182);

/// The CRC of a body.
pub fn checksum(body: &[u8]) -> u64 {
    CHECKSUM.checksum(body)
}

/// Seconds since the beginning of 1970 in units of 2⁻³² s; zero where the sender states none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Timestamp(pub u64);

impl Timestamp {
    pub const NONE: Self = Self(0);

    /// From a time since 1970.
    pub fn from_unix(since_epoch: Duration) -> Self {
        let fraction = (u64::from(since_epoch.subsec_nanos()) << 32) / 1_000_000_000;
        // 32 bits of seconds last until 2106.
        Self((since_epoch.as_secs() << 32) | fraction)
    }

    /// The time of this machine's clock.
    pub fn now() -> Self {
        // A clock before 1970 is no time.
        Self::from_unix(
            std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap_or_default(),
        )
    }

    /// Whether the sender states a time.
    pub fn is_stated(self) -> bool {
        self != Self::NONE
    }

    /// Seconds since 1970, to 0.3 µs in this century.
    pub fn seconds(self) -> f64 {
        self.0 as f64 / 2.0_f64.powi(32)
    }

    /// Seconds from an earlier timestamp to this one; negative where it is a later one.
    pub fn seconds_since(self, earlier: Self) -> f64 {
        (i128::from(self.0) - i128::from(earlier.0)) as f64 / 2.0_f64.powi(32)
    }
}

/// Of the header: 1 stands for protocols 1 and 2, 2 for protocol 3.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Version {
    One,
    Two,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Header {
    pub version: Version,
    /// The message's type, as `TRANSFORM`.
    pub kind: String,
    pub device: String,
    pub timestamp: Timestamp,
    pub body_bytes: u64,
    pub checksum: u64,
}

#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum HeaderError {
    #[error(
        "found header version {0}, expected that of an OpenIGTLink message: 1 (protocols 1 and 2) or 2 (protocol 3)"
    )]
    Version(u16),
    #[error(
        "found a message type that begins \"{}\", expected a word of capital letters, digits and underscores",
        .0.escape_ascii()
    )]
    Kind(Vec<u8>),
    #[error(
        "{kind}: found a device name \"{}\", expected UTF-8 without control characters",
        .device.escape_ascii()
    )]
    Device { kind: String, device: Vec<u8>, body_bytes: u64 },
}

impl Header {
    /// Reads a header.
    pub fn decode(bytes: &[u8; HEADER_BYTES]) -> Result<Self, HeaderError> {
        let mut reader = Reader(bytes);
        let version = match reader.u16() {
            Some(1) => Version::One,
            Some(2) => Version::Two,
            found => return Err(HeaderError::Version(found.unwrap_or(0))),
        };
        let kind_bytes = reader.take(KIND_BYTES).unwrap_or_default();
        let is_of_a_word =
            |c: char| c.is_ascii_uppercase() || c.is_ascii_digit() || matches!(c, '_' | '-');
        let kind = text_of(kind_bytes)
            .filter(|kind| !kind.is_empty() && kind.chars().all(is_of_a_word))
            .ok_or_else(|| HeaderError::Kind(kind_bytes.to_vec()))?;
        let device_bytes = reader.take(NAME_BYTES).unwrap_or_default();
        let mut number = || reader.array().map_or(0, u64::from_be_bytes);
        let (timestamp, body_bytes, checksum) = (Timestamp(number()), number(), number());
        let Some(device) = text_of(device_bytes) else {
            let end = device_bytes.iter().position(|&byte| byte == 0);
            let named = device_bytes.get(..end.unwrap_or(NAME_BYTES));
            return Err(HeaderError::Device {
                kind,
                device: named.unwrap_or_default().to_vec(),
                body_bytes,
            });
        };
        Ok(Self { version, kind, device, timestamp, body_bytes, checksum })
    }

    /// # Errors
    /// A name that is too long.
    pub fn encode(&self, out: &mut Vec<u8>) -> Result<(), EncodeError> {
        let version: u16 = match self.version {
            Version::One => 1,
            Version::Two => 2,
        };
        out.extend_from_slice(&version.to_be_bytes());
        put_text(out, &self.kind, KIND_BYTES, "message type")?;
        put_text(out, &self.device, NAME_BYTES, "device name")?;
        for number in [self.timestamp.0, self.body_bytes, self.checksum] {
            out.extend_from_slice(&number.to_be_bytes());
        }
        Ok(())
    }
}

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
