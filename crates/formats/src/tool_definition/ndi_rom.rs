//! What both kinds of NDI images have in common.

use super::identity::IdentityAt;
use super::image::Checksum;
use super::{EmRom, OpticalRom, SerialWord, ndi_em, ndi_optical};
use trackwright_simulation::body::{RigidBody, Sensor};

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

    /// The image, and where it says what the tool is.
    fn identity(&self) -> (&[u8], &'static IdentityAt) {
        match self {
            Self::Optical(rom) => (rom.image(), &ndi_optical::IDENTITY),
            Self::Em(rom) => (rom.image(), &ndi_em::IDENTITY),
        }
    }

    pub fn manufacturer(&self) -> String {
        let (image, at) = self.identity();
        at.manufacturer(image)
    }

    pub fn part_number(&self) -> String {
        let (image, at) = self.identity();
        at.part_number(image)
    }

    /// Whether it did: not for what is too long or no ASCII.
    pub(super) fn set_part_number(&mut self, text: &str) -> bool {
        let (_, at) = self.identity();
        at.set_part_number(either!(self, rom => rom.image_mut()), text)
    }

    pub fn serial(&self) -> SerialWord {
        let (image, at) = self.identity();
        at.serial(image)
    }

    /// What it is for: 1 a reference, 2 a probe, …
    pub fn main_type(&self) -> u8 {
        let (image, at) = self.identity();
        image[at.main_type]
    }

    /// 0 removable tip, 1 fixed tip, 2 undefined.
    pub fn sub_type(&self) -> u8 {
        let (image, at) = self.identity();
        image[at.sub_type]
    }

    pub fn revision(&self) -> u16 {
        let (image, at) = self.identity();
        at.revision(image)
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
        format!("{:02X}-{}-{}", self.main_type(), self.serial(), self.part_number())
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
