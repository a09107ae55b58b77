//! What an NDI image says of a tool as a whole: which one it is, who made it, what it is for. Both
//! kinds of image say the same, each at places of its own.

use super::image::{fits, put_text, text_of};
use super::serial::SerialWord;

/// Longest name of a manufacturer.
const MANUFACTURER_ROOM: usize = 12;

/// Longest part number.
const PART_NUMBER_ROOM: usize = 20;

/// Where an image has it.
pub(super) struct IdentityAt {
    pub sub_type: usize,
    pub main_type: usize,
    pub revision: usize,
    pub serial: usize,
    pub manufacturer: usize,
    pub part_number: usize,
}

/// Places are those of the formats' tables, and so within the image.
impl IdentityAt {
    pub fn revision(&self, image: &[u8]) -> u16 {
        u16::from_le_bytes([image[self.revision], image[self.revision + 1]])
    }

    pub fn serial(&self, image: &[u8]) -> SerialWord {
        SerialWord(std::array::from_fn(|i| image[self.serial + i]))
    }

    pub fn manufacturer(&self, image: &[u8]) -> String {
        text_of(&image[self.manufacturer..self.manufacturer + MANUFACTURER_ROOM])
    }

    pub fn part_number(&self, image: &[u8]) -> String {
        text_of(&image[self.part_number..self.part_number + PART_NUMBER_ROOM])
    }

    /// Whether it did: not for what is too long or no ASCII.
    pub fn set_part_number(&self, image: &mut [u8], text: &str) -> bool {
        let is_fitting = fits(text, PART_NUMBER_ROOM);
        if is_fitting {
            put_text(image, self.part_number, PART_NUMBER_ROOM, text);
        }
        is_fitting
    }
}
