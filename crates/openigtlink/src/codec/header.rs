//! The 58 bytes before every body, and the checksum of the body.

use super::bytes::{EncodeError, Reader, put_text, text_of};
use crc::{CRC_64_ECMA_182, Crc, Table};
use std::time::Duration;

pub const HEADER_BYTES: usize = 58;

/// The longest name of a device, or of a tool in a list of tracking data.
pub const NAME_BYTES: usize = 20;

/// The longest name of a message's type.
const KIND_BYTES: usize = 12;

/// ECMA-182: nothing reflected, nothing inverted.
const CHECKSUM: Crc<u64, Table<1>> = Crc::<u64, Table<1>>::new(&CRC_64_ECMA_182);

pub fn checksum(body: &[u8]) -> u64 {
    CHECKSUM.checksum(body)
}

/// Seconds since the beginning of 1970 in units of 2⁻³² s; zero where the sender states none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Timestamp(pub u64);

impl Timestamp {
    pub const NONE: Self = Self(0);

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

/// Why 58 bytes are no header. Only where the device's name is wrong is it known where the next
/// message begins.
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
    /// # Errors
    /// See [`HeaderError`].
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
