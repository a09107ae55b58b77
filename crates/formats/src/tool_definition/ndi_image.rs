//! The bytes of an NDI image: little-endian fields, and their sum.

use crate::error::FormatError;
use std::ops::{Deref, DerefMut};

/// The sum that an image names and the one that its bytes have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Checksum {
    pub stored: u32,
    pub computed: u32,
}

/// What becomes of an image whose checksum does not match.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OnMismatch {
    Refuse,
    /// It is read as it is; [`NdiRom::checksum`](super::NdiRom::checksum) still reports it.
    Accept,
}

/// The bytes of an image, and what follows them in its file.
///
/// Offsets are those of the formats' tables, and so within the image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Image {
    pub bytes: Vec<u8>,
    pub trailing: Vec<u8>,
}

/// Where an image states what a tool is as a whole.
pub(super) struct IdentityAt {
    pub sub_type: usize,
    pub main_type: usize,
    pub revision: usize,
    pub serial: usize,
    pub manufacturer: usize,
    pub part_number: usize,
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

impl Image {
    /// An image of zeros.
    pub(super) fn zeros(size: usize) -> Self {
        Self { bytes: vec![0; size], trailing: Vec::new() }
    }

    /// The image that a file begins with, and the bytes behind it.
    pub(super) fn read(
        bytes: &[u8],
        size: usize,
        expected: &'static str,
    ) -> Result<Self, FormatError> {
        match bytes.split_at_checked(size) {
            Some((image, trailing)) => {
                Ok(Self { bytes: image.to_vec(), trailing: trailing.to_vec() })
            }
            None => {
                let found = format!("{} bytes", bytes.len());
                Err(FormatError::field("length", found, expected))
            }
        }
    }

    pub(super) fn f32(&self, at: usize) -> f32 {
        f32::from_bits(self.u32(at))
    }

    pub(super) fn u32(&self, at: usize) -> u32 {
        u32::from_le_bytes(std::array::from_fn(|i| self.bytes[at + i]))
    }

    pub(super) fn u16(&self, at: usize) -> u16 {
        u16::from_le_bytes([self.bytes[at], self.bytes[at + 1]])
    }

    pub(super) fn vector(&self, at: usize) -> [f32; 3] {
        std::array::from_fn(|i| self.f32(at + 4 * i))
    }

    pub(super) fn put(&mut self, at: usize, bytes: &[u8]) {
        self.bytes[at..at + bytes.len()].copy_from_slice(bytes);
    }

    pub(super) fn put_vector(&mut self, at: usize, vector: [f32; 3]) {
        for (i, value) in vector.into_iter().enumerate() {
            self.put(at + 4 * i, &value.to_le_bytes());
        }
    }

    /// A text that ends with its field or at the first NUL; what is not ASCII is shown as �.
    pub(super) fn text(&self, at: usize, room: usize) -> String {
        let letters = self.bytes[at..at + room].iter().take_while(|b| **b != 0);
        let letter = |b: &u8| match b {
            b' '..=b'~' => char::from(*b),
            _ => char::REPLACEMENT_CHARACTER,
        };
        letters.map(letter).collect()
    }
}

impl Deref for Image {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &self.bytes
    }
}

impl DerefMut for Image {
    fn deref_mut(&mut self) -> &mut [u8] {
        &mut self.bytes
    }
}

/// The sum of bytes.
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
