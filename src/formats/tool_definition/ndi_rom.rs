//! What both kinds of NDI images have in common.

use super::image::Checksum;
use super::{EmRom, OpticalRom, SerialWord};
use crate::tracking::body::{RigidBody, Sensor};

/// Name of a body whose image names neither a part nor a manufacturer.
const NAMELESS: &str = "tool";

/// An NDI image of either kind.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NdiRom {
    Optical(OpticalRom),
    Em(EmRom),
}

/// Calls the same method of either kind.
macro_rules! either {
    ($rom:expr, $inner:ident => $call:expr) => {
        match $rom {
            NdiRom::Optical($inner) => $call,
            NdiRom::Em($inner) => $call,
        }
    };
}

impl NdiRom {
    /// The whole file.
    pub fn write(&self) -> Vec<u8> {
        either!(self, rom => rom.write())
    }

    pub fn checksum(&self) -> Checksum {
        either!(self, rom => rom.checksum())
    }

    pub(super) fn set_checksum(&mut self) {
        either!(self, rom => rom.set_checksum());
    }

    /// What follows the image in its file.
    pub fn trailing(&self) -> &[u8] {
        either!(self, rom => rom.trailing())
    }

    pub fn manufacturer(&self) -> String {
        either!(self, rom => rom.manufacturer())
    }

    pub fn part_number(&self) -> String {
        either!(self, rom => rom.part_number())
    }

    /// Whether it did: not for what is too long or no ASCII.
    pub(super) fn set_part_number(&mut self, text: &str) -> bool {
        either!(self, rom => rom.set_part_number(text))
    }

    pub fn part_number_room(&self) -> usize {
        match self {
            Self::Optical(_) => OpticalRom::PART_NUMBER_ROOM,
            Self::Em(_) => EmRom::PART_NUMBER_ROOM,
        }
    }

    pub fn serial(&self) -> SerialWord {
        either!(self, rom => rom.serial())
    }

    pub fn main_type(&self) -> u8 {
        either!(self, rom => rom.main_type())
    }

    pub fn sub_type(&self) -> u8 {
        either!(self, rom => rom.sub_type())
    }

    pub fn revision(&self) -> u16 {
        either!(self, rom => rom.revision())
    }

    /// What the main type is called.
    pub fn main_type_name(&self) -> &'static str {
        match self.main_type() {
            0 => "unknown",
            1 => "reference",
            2 => "probe",
            3 => "button box",
            4 => "user defined",
            5 => "microscope",
            7 => "calibration block",
            8 => "docking station",
            9 => "isolation box",
            10 => "C-arm tracker",
            11 => "catheter",
            12 => "GPIO",
            14 => "scan reference",
            _ => "not known here",
        }
    }

    /// What the sub type is called.
    pub fn sub_type_name(&self) -> &'static str {
        match self.sub_type() {
            0 => "removable tip",
            1 => "fixed tip",
            2 => "undefined",
            _ => "not known here",
        }
    }

    /// How sawNDITracker tells tools apart: main type, serial number and part number.
    pub fn unique_id(&self) -> String {
        format!(
            "{:02X}-{}-{}",
            self.main_type(),
            self.serial(),
            self.part_number()
        )
    }

    /// The body's name: the part number, or who made it.
    pub(super) fn name(&self) -> String {
        [self.part_number(), self.manufacturer()]
            .into_iter()
            .map(|text| text.trim().to_owned())
            .find(|text| !text.is_empty())
            .unwrap_or_else(|| NAMELESS.to_owned())
    }

    pub(super) fn sensors(&self) -> Vec<Sensor> {
        either!(self, rom => rom.sensors())
    }

    pub(super) fn to_body(&self) -> RigidBody {
        either!(self, rom => rom.to_body(self.name()))
    }
}
