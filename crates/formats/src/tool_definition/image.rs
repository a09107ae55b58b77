//! What images of NDI tools have in common: little-endian fields, padded texts, a sum of bytes.

use super::super::error::FormatError;
use super::OnMismatch;

/// The sum that an image names and the one that its bytes have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Checksum {
    pub stored: u32,
    pub computed: u32,
}

impl Checksum {
    pub fn matches(self) -> bool {
        self.stored == self.computed
    }

    pub(super) fn check(self, on_mismatch: OnMismatch) -> Result<(), FormatError> {
        if self.matches() || on_mismatch == OnMismatch::Accept {
            return Ok(());
        }
        Err(FormatError::Checksum { stored: self.stored, computed: self.computed })
    }
}

/// The image that a file begins with, and the bytes behind it.
pub(super) fn split<const N: usize>(
    bytes: &[u8],
    expected: &'static str,
) -> Result<(Box<[u8; N]>, Vec<u8>), FormatError> {
    let Some((image, trailing)) = bytes.split_first_chunk::<N>() else {
        let found = format!("{} bytes", bytes.len());
        return Err(FormatError::field("length", found, expected));
    };
    Ok((Box::new(*image), trailing.to_vec()))
}

/// Offsets are those of the formats' tables, and so within the image.
pub(super) fn f32_at<const N: usize>(image: &[u8; N], at: usize) -> f32 {
    f32::from_bits(u32_at(image, at))
}

pub(super) fn u32_at<const N: usize>(image: &[u8; N], at: usize) -> u32 {
    u32::from_le_bytes(std::array::from_fn(|i| image[at + i]))
}

pub(super) fn u16_at<const N: usize>(image: &[u8; N], at: usize) -> u16 {
    u16::from_le_bytes([image[at], image[at + 1]])
}

pub(super) fn put<const N: usize>(image: &mut [u8; N], at: usize, bytes: &[u8]) {
    image[at..at + bytes.len()].copy_from_slice(bytes);
}

pub(super) fn vector_at<const N: usize>(image: &[u8; N], at: usize) -> [f32; 3] {
    std::array::from_fn(|i| f32_at(image, at + 4 * i))
}

pub(super) fn put_vector<const N: usize>(image: &mut [u8; N], at: usize, vector: [f32; 3]) {
    for (i, value) in vector.into_iter().enumerate() {
        put(image, at + 4 * i, &value.to_le_bytes());
    }
}

/// A text that ends with its field or at the first NUL; what is not ASCII is shown as �.
pub(super) fn text_of(field: &[u8]) -> String {
    let end = field.iter().position(|b| *b == 0).unwrap_or(field.len());
    let letter = |b: &u8| match b {
        b' '..=b'~' => char::from(*b),
        _ => char::REPLACEMENT_CHARACTER,
    };
    field[..end].iter().map(letter).collect()
}

/// Whether a text can stand in a field of so many bytes.
pub(super) fn fits(text: &str, room: usize) -> bool {
    text.len() <= room && text.bytes().all(|b| matches!(b, b' '..=b'~'))
}

/// The text and NULs up to the end of the field; the text has to fit.
pub(super) fn put_text(image: &mut [u8], at: usize, room: usize, text: &str) {
    image[at..at + room].fill(0);
    for (byte, letter) in image[at..at + room].iter_mut().zip(text.bytes()) {
        *byte = letter;
    }
}

pub(super) fn sum(bytes: &[u8]) -> u32 {
    bytes.iter().map(|b| u32::from(*b)).sum()
}

/// Refuses what is no number where one is needed.
pub(super) fn check_finite(field: &str, values: &[f32]) -> Result<(), FormatError> {
    if values.iter().all(|v| v.is_finite()) {
        return Ok(());
    }
    let values: Vec<_> = values.iter().map(f32::to_string).collect();
    let found = format!("({})", values.join(", "));
    Err(FormatError::field(field, found, "finite numbers"))
}
