//! What headers of version 2 add to a body: a number for the message, and keys with values.

use super::body::BodyError;
use super::header::{EncodeError, Reader, counted};

/// Bytes of the extended header.
const EXTENDED_BYTES: u16 = 12;

/// Bytes of an entry in the metadata's own header.
const ENTRY_BYTES: usize = 8;

/// Longest metadata of a message, with the extended header: a few values for each of some tools.
pub const MAX_METADATA_BYTES: u64 = 64 * 1024;

/// Most entries: a message that is sent on has room for a few more in a header of 64 KB.
const MAX_ENTRIES: u16 = 1024;

/// The number by which US-ASCII goes.
const ASCII: u16 = 3;

/// The number and the metadata of a message of protocol 3.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Extension {
    pub message_id: u32,
    pub metadata: Vec<MetadataEntry>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MetadataEntry {
    pub key: String,
    /// The character set by its number in the list of IANA; 3 is US-ASCII, 106 UTF-8.
    pub encoding: u16,
    pub value: Vec<u8>,
}

impl MetadataEntry {
    /// An entry of US-ASCII.
    pub fn text(key: &str, value: &str) -> Self {
        Self { key: key.to_owned(), encoding: ASCII, value: value.as_bytes().to_vec() }
    }
}

impl Extension {
    /// The value of a key, where it is there and is text.
    pub fn get(&self, key: &str) -> Option<&str> {
        let entry = self.metadata.iter().find(|entry| entry.key == key)?;
        std::str::from_utf8(&entry.value).ok()
    }

    /// Replaces the value of a key, or adds it.
    pub fn set(&mut self, key: &str, value: &str) {
        let entry = MetadataEntry::text(key, value);
        match self.metadata.iter_mut().find(|entry| entry.key == key) {
            Some(found) => *found = entry,
            None => self.metadata.push(entry),
        }
    }

    /// A body of version 2, split into its metadata and its content.
    pub fn decode(body: &[u8]) -> Result<(Self, &[u8]), BodyError> {
        let mut reader = Reader(body);
        let cut = || BodyError::Extension {
            found: format!("{} bytes", body.len()),
            expected: "12 at least".to_owned(),
        };
        let mut numbers = || Some((reader.u16()?, reader.u16()?, reader.u32()?, reader.u32()?));
        let (extended_bytes, header_bytes, values_bytes, message_id) = numbers().ok_or_else(cut)?;
        if extended_bytes < EXTENDED_BYTES {
            return Err(BodyError::Extension {
                found: format!("an extended header of {extended_bytes} bytes"),
                expected: "12 at least".to_owned(),
            });
        }
        // What later versions add to the extended header is not looked at.
        let around = u64::from(extended_bytes) + u64::from(header_bytes) + u64::from(values_bytes);
        let too_long = || BodyError::Extension {
            found: format!("an extended header and metadata of {around} bytes"),
            expected: format!("no more than the body's {}", body.len()),
        };
        let content_bytes = (body.len() as u64).checked_sub(around).ok_or_else(too_long)?;
        let mut parts = Reader(body);
        let mut part = |bytes: u64| parts.take(usize::try_from(bytes).ok()?);
        let mut parts = || {
            part(extended_bytes.into())?;
            Some((part(content_bytes)?, part(header_bytes.into())?, part(values_bytes.into())?))
        };
        let (content, header, values) = parts().ok_or_else(too_long)?;
        let extension = Self { message_id, metadata: decode_metadata(header, values)? };
        Ok((extension, content))
    }

    /// Writes a body: the extended header, the content, and the metadata.
    pub fn encode_around(&self, content: &[u8], out: &mut Vec<u8>) -> Result<(), EncodeError> {
        const FIELD: &str = "metadata";
        let entries: u16 = counted(self.metadata.len(), FIELD, u16::MAX.into())?;
        let header_bytes = 2 + ENTRY_BYTES * self.metadata.len();
        let values_bytes: usize =
            self.metadata.iter().map(|entry| entry.key.len() + entry.value.len()).sum();
        let header_size: u16 = counted(header_bytes, FIELD, u16::MAX.into())?;
        let values_size: u32 = counted(values_bytes, FIELD, u32::MAX as usize)?;
        out.extend_from_slice(&EXTENDED_BYTES.to_be_bytes());
        out.extend_from_slice(&header_size.to_be_bytes());
        out.extend_from_slice(&values_size.to_be_bytes());
        out.extend_from_slice(&self.message_id.to_be_bytes());
        out.extend_from_slice(content);
        out.extend_from_slice(&entries.to_be_bytes());
        for entry in &self.metadata {
            let key: u16 = counted(entry.key.len(), FIELD, u16::MAX.into())?;
            let value: u32 = counted(entry.value.len(), FIELD, u32::MAX as usize)?;
            out.extend_from_slice(&key.to_be_bytes());
            out.extend_from_slice(&entry.encoding.to_be_bytes());
            out.extend_from_slice(&value.to_be_bytes());
        }
        for entry in &self.metadata {
            out.extend_from_slice(entry.key.as_bytes());
            out.extend_from_slice(&entry.value);
        }
        Ok(())
    }
}

fn decode_metadata(header: &[u8], values: &[u8]) -> Result<Vec<MetadataEntry>, BodyError> {
    // Some senders leave the count of no entries out.
    if header.is_empty() {
        return Ok(Vec::new());
    }
    let mut header = Reader(header);
    let mut values = Reader(values);
    let count = header.u16().unwrap_or(0);
    if count > MAX_ENTRIES {
        return Err(BodyError::Extension {
            found: format!("{count} entries of metadata"),
            expected: format!("{MAX_ENTRIES} at most"),
        });
    }
    let mut entries = Vec::new();
    for index in 0..count {
        let entry = |header: &mut Reader, values: &mut Reader| {
            let (key, encoding, value) = (header.u16()?, header.u16()?, header.u32()?);
            let key = values.take(key.into())?;
            let value = values.take(usize::try_from(value).ok()?)?;
            Some(MetadataEntry {
                key: std::str::from_utf8(key).ok()?.to_owned(),
                encoding,
                value: value.to_vec(),
            })
        };
        let Some(entry) = entry(&mut header, &mut values) else {
            return Err(BodyError::Extension {
                found: format!("metadata that end in entry {}", index + 1),
                expected: format!("{count} entries with keys in UTF-8"),
            });
        };
        entries.push(entry);
    }
    Ok(entries)
}
