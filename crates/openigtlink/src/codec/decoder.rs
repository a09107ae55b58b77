//! Messages out of a stream of bytes that may be anything.

use super::body::{BodyError, longest_content};
use super::header::{HEADER_BYTES, Header, HeaderError, Version, checksum};
use super::metadata::{Extension, MAX_METADATA_BYTES};
use super::{Content, Message};

/// The longest body of an unknown type that is passed over: 4096 x 4096 pixels of 16 bits.
pub const MAX_SKIPPED_BYTES: u64 = 32 << 20;

/// The longest body that a message of a type may announce. What announces more has lost where messages
/// begin, or would keep everything after it from being received: the stream is ended.
pub fn longest_body(kind: &str, version: Version) -> u64 {
    let metadata = match version {
        Version::One => 0,
        Version::Two => MAX_METADATA_BYTES,
    };
    longest_content(kind).map_or(MAX_SKIPPED_BYTES, |content| content + metadata)
}

/// What came of a header and its body.
#[derive(Clone, Debug, PartialEq)]
pub enum Decoded {
    /// Of a known type.
    Message(Message),
    /// Of an unknown type, or too long to be of use: passed over as it arrives.
    Skipped { kind: String, device: String, body_bytes: u64 },
}

/// What a stream has instead of a message.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DecodeError {
    #[error("not OpenIGTLink, or its beginning is lost: {0}")]
    Header(#[from] HeaderError),
    /// Of a device without a name where that is no text.
    #[error(
        "{kind} of {device:?}: found a body of {found} bytes announced, expected {limit} at most"
    )]
    TooLong { kind: String, device: String, found: u64, limit: u64 },
    /// The message is passed over; the next one is found.
    #[error(
        "{kind}: found a device name \"{}\", expected UTF-8 without control characters",
        .device.escape_ascii()
    )]
    Name { kind: String, device: Vec<u8> },
    #[error(
        "{kind} of {device:?}: found checksum {found:016x}, expected {expected:016x}, that of its body"
    )]
    Checksum { kind: String, device: String, found: u64, expected: u64 },
    #[error("{kind} of {device:?}: {problem}")]
    Body { kind: String, device: String, problem: BodyError },
}

impl DecodeError {
    /// Whether no message that follows can be found: the stream is to be closed.
    pub fn ends_the_stream(&self) -> bool {
        matches!(self, Self::Header(_) | Self::TooLong { .. })
    }
}

enum State {
    Header,
    Body(Header),
    Skipping {
        bytes_left: u64,
    },
    /// Whatever comes is thrown away.
    Lost,
}

/// Takes bytes as they arrive and gives messages as they are whole.
///
/// It keeps one header or the part of one body that has arrived, and allocates for that only:
/// never more than `max_body_bytes`, twice while its buffer grows.
pub struct Decoder {
    state: State,
    pub(super) kept: Vec<u8>,
    max_body_bytes: usize,
}

impl Decoder {
    /// Longer bodies than `max_body_bytes` are skipped.
    pub fn new(max_body_bytes: usize) -> Self {
        Self { state: State::Header, kept: Vec::new(), max_body_bytes }
    }

    /// Takes bytes from the front of `arrived` until a message is whole, and gives what it is;
    /// `None` once all are taken. After an error that [ends the stream](DecodeError::ends_the_stream)
    /// nothing more comes.
    pub fn next(&mut self, arrived: &mut &[u8]) -> Option<Result<Decoded, DecodeError>> {
        loop {
            match std::mem::replace(&mut self.state, State::Lost) {
                State::Lost => {
                    *arrived = &[];
                    return None;
                }
                State::Skipping { bytes_left } => {
                    let taken =
                        arrived.len().min(usize::try_from(bytes_left).unwrap_or(usize::MAX));
                    *arrived = arrived.get(taken..).unwrap_or_default();
                    let bytes_left = bytes_left - taken as u64;
                    if bytes_left > 0 {
                        self.state = State::Skipping { bytes_left };
                        return None;
                    }
                    self.state = State::Header;
                }
                State::Header => {
                    if !self.fill(HEADER_BYTES, arrived) {
                        self.state = State::Header;
                        return None;
                    }
                    match self.header() {
                        Ok(header) => {
                            if let Some(skipped) = self.enter(header) {
                                return Some(Ok(skipped));
                            }
                        }
                        Err(error) => return Some(Err(error)),
                    }
                }
                State::Body(header) => {
                    // No more than `max_body_bytes`, see `enter`.
                    let wanted = usize::try_from(header.body_bytes).unwrap_or(usize::MAX);
                    if !self.fill(wanted, arrived) {
                        self.state = State::Body(header);
                        return None;
                    }
                    let decoded = message(&header, &self.kept);
                    self.kept.clear();
                    self.state = State::Header;
                    return Some(decoded.map(Decoded::Message));
                }
            }
        }
    }

    /// Whether the stream may end here without having lost anything.
    pub fn is_between_messages(&self) -> bool {
        matches!(self.state, State::Header) && self.kept.is_empty()
    }

    /// Keeps arrived bytes until there are as many as wanted.
    fn fill(&mut self, wanted: usize, arrived: &mut &[u8]) -> bool {
        let taken = arrived.len().min(wanted.saturating_sub(self.kept.len()));
        if let Some((now, later)) = arrived.split_at_checked(taken) {
            self.kept.extend_from_slice(now);
            *arrived = later;
        }
        self.kept.len() == wanted
    }

    fn header(&mut self) -> Result<Header, DecodeError> {
        let mut bytes = [0; HEADER_BYTES];
        for (byte, kept) in bytes.iter_mut().zip(self.kept.drain(..)) {
            *byte = kept;
        }
        match Header::decode(&bytes) {
            Ok(header) => {
                let limit = longest_body(&header.kind, header.version);
                within(limit, &header.kind, &header.device, header.body_bytes)?;
                Ok(header)
            }
            Err(HeaderError::Device { kind, device, body_bytes }) => {
                // The longer limit: whatever it is, it is passed over.
                within(longest_body(&kind, Version::Two), &kind, "", body_bytes)?;
                self.state = State::Skipping { bytes_left: body_bytes };
                Err(DecodeError::Name { kind, device })
            }
            Err(error) => Err(error.into()),
        }
    }

    /// Decides what happens to the body.
    fn enter(&mut self, header: Header) -> Option<Decoded> {
        let is_short = header.body_bytes <= self.max_body_bytes as u64;
        if is_short && longest_content(&header.kind).is_some() {
            self.state = State::Body(header);
            return None;
        }
        self.state = State::Skipping { bytes_left: header.body_bytes };
        Some(Decoded::Skipped {
            kind: header.kind,
            device: header.device,
            body_bytes: header.body_bytes,
        })
    }
}

fn within(limit: u64, kind: &str, device: &str, found: u64) -> Result<(), DecodeError> {
    if found <= limit {
        return Ok(());
    }
    Err(DecodeError::TooLong { kind: kind.to_owned(), device: device.to_owned(), found, limit })
}

fn message(header: &Header, body: &[u8]) -> Result<Message, DecodeError> {
    let (kind, device) = (|| header.kind.clone(), || header.device.clone());
    let expected = checksum(body);
    if header.checksum != expected {
        return Err(DecodeError::Checksum {
            kind: kind(),
            device: device(),
            found: header.checksum,
            expected,
        });
    }
    let wrong = |problem| DecodeError::Body { kind: kind(), device: device(), problem };
    let (extension, content) = match header.version {
        Version::One => (None, body),
        Version::Two => {
            let (extension, content) = Extension::decode(body).map_err(wrong)?;
            (Some(extension), content)
        }
    };
    let unknown = || Err(BodyError::Length { found: content.len(), expected: "a known type" });
    let content = Content::decode(&header.kind, content).unwrap_or_else(unknown);
    Ok(Message {
        device: device(),
        timestamp: header.timestamp,
        content: content.map_err(wrong)?,
        extension,
    })
}
