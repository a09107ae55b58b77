//! Where a glTF file's numbers are: in its binary chunk, or in its JSON as base64.

use super::error::GltfError;
use data_encoding::BASE64;
use gltf::buffer::Source;
use std::borrow::Cow;

/// Longest name of a file that an error quotes.
const MAX_QUOTE: usize = 80;

/// The bytes of each buffer of a file, in its order, or why there are none: a mesh need not use it.
pub(super) struct Buffers<'a>(Vec<Result<Cow<'a, [u8]>, GltfError>>);

impl<'a> Buffers<'a> {
    /// `blob` is the binary chunk, which a buffer without a name means.
    pub(super) fn of(file: &gltf::Document, blob: &'a [u8]) -> Self {
        let buffers = file.buffers().map(|buffer| match buffer.source() {
            Source::Bin => Ok(Cow::Borrowed(blob)),
            Source::Uri(uri) => inline(uri, buffer.index()).map(Cow::Owned),
        });
        Self(buffers.collect())
    }

    /// # Errors
    /// [`GltfError::ExternalBuffer`] for what is in another file, [`GltfError::Base64`].
    pub(super) fn bytes(&self, buffer: usize) -> Result<&[u8], GltfError> {
        match self.0.get(buffer) {
            Some(Ok(bytes)) => Ok(bytes),
            Some(Err(error)) => Err(error.clone()),
            None => Ok(&[]),
        }
    }
}

/// The bytes of a data URI (RFC 2397) in base64, which is all that glTF has.
fn inline(uri: &str, buffer: usize) -> Result<Vec<u8>, GltfError> {
    let has_scheme = uri.get(..5).is_some_and(|s| s.eq_ignore_ascii_case("data:"));
    if !has_scheme {
        return Err(GltfError::ExternalBuffer {
            buffer,
            file: uri.chars().take(MAX_QUOTE).collect(),
        });
    }
    let encoded = uri.split_once(";base64,").map(|(_, encoded)| encoded);
    let encoded = encoded.ok_or_else(|| GltfError::Base64 {
        buffer,
        found: "a data URI without \";base64,\"".to_owned(),
    })?;
    BASE64
        .decode(encoded.as_bytes())
        .map_err(|error| GltfError::Base64 { buffer, found: error.to_string() })
}
