//! OpenIGTLink messages, between bytes and types: headers of versions 1 (protocols 1 and 2) and 2
//! (protocol 3), what a tracker sends and receives, and a decoder for streams of any bytes.
//!
//! Source: the OpenIGTLink protocol's own description, versions 1 to 3, and its test vectors. All
//! numbers are big-endian, lengths are in mm. Nothing here knows a socket.
//!
//! The crate `openigtlink-rust` (0.4.1) does not replace this: it keeps metadata as a map from text to
//! text, so that their order and character sets are lost and the test vectors with metadata are not
//! encoded to the same bytes.

mod body;
mod decoder;
mod header;
mod metadata;
mod poses;
#[cfg(test)]
mod tests;

pub use body::{
    BodyError, Content, Point, Position, QuaternionElement, StartTracking, Status, StatusCode,
    Text, TrackingElement,
};
pub use decoder::{DecodeError, Decoded, Decoder, MAX_SKIPPED_BYTES, longest_body};
pub use header::{EncodeError, HEADER_BYTES, Header, HeaderError, NAME_BYTES, Timestamp, Version};
pub use metadata::{Extension, MetadataEntry};
pub use poses::{MAX_OFF, Matrix, NotAPose, Orientation, ToolKind};

/// The port that OpenIGTLink servers listen on by default.
pub const DEFAULT_PORT: u16 = 18944;

/// One message.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    /// Whose it is: of a transform, the tool's name. 20 bytes of UTF-8 at most.
    pub device: String,
    pub timestamp: Timestamp,
    pub content: Content,
    /// What headers of version 2 add; a message without it has a header of version 1.
    pub extension: Option<Extension>,
}

impl Message {
    /// A message with a header of version 1, which every receiver reads.
    pub fn new(device: impl Into<String>, timestamp: Timestamp, content: Content) -> Self {
        Self { device: device.into(), timestamp, content, extension: None }
    }

    /// The bytes to send; an error for names, texts and lists that are too long.
    pub fn encode(&self) -> Result<Vec<u8>, EncodeError> {
        let mut body = Vec::with_capacity(128);
        match &self.extension {
            None => self.content.encode(&mut body)?,
            Some(extension) => {
                let mut content = Vec::with_capacity(64);
                self.content.encode(&mut content)?;
                extension.encode_around(&content, &mut body)?;
            }
        }
        let header = Header {
            version: match self.extension {
                None => Version::One,
                Some(_) => Version::Two,
            },
            kind: self.content.kind().to_owned(),
            device: self.device.clone(),
            timestamp: self.timestamp,
            body_bytes: body.len() as u64,
            checksum: header::checksum(&body),
        };
        let mut message = Vec::with_capacity(HEADER_BYTES + body.len());
        header.encode(&mut message)?;
        message.extend_from_slice(&body);
        Ok(message)
    }
}
