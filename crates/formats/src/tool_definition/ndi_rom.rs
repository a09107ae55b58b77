//! What both kinds of NDI images have in common: which tool it is, who made it and when.

use super::ndi_em::EmRom;
use super::ndi_image::{Checksum, IdentityAt, Image};
use super::ndi_optical::OpticalRom;
use time::Date;
use trackwright_simulation::body::{RigidBody, Sensor};

/// Name of a body whose image names neither a part nor a manufacturer.
const NAMELESS: &str = "tool";

/// Longest name of a manufacturer.
const MANUFACTURER_ROOM: usize = 12;

/// Longest part number.
const PART_NUMBER_ROOM: usize = 20;

const FIRST_YEAR: u16 = 1900;

/// An NDI image of either kind.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NdiRom {
    Optical(OpticalRom),
    Em(EmRom),
}

/// The word that is both a serial number and the day a tool was made. Four bytes: a number within the
/// day (10 bits), the day of the year (9), the month (4) and the year since 1900 (9). NDI prints it as
/// one little-endian number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SerialWord(pub [u8; 4]);

impl SerialWord {
    /// As NDI prints it, in hexadecimal.
    pub fn number(self) -> u32 {
        u32::from_le_bytes(self.0)
    }

    /// The day; `None` where the year has no such day, or it lies in another month than the word
    /// states.
    pub fn date(self) -> Option<Date> {
        let [_, b1, b2, b3] = self.0.map(u16::from);
        let year = FIRST_YEAR + 2 * b3 + (b2 >> 7);
        let day = (b2 & 7) << 6 | b1 >> 2;
        let date = Date::from_ordinal_date(i32::from(year), day + 1).ok()?;
        (u16::from(u8::from(date.month())) == (b2 >> 3 & 15) + 1).then_some(date)
    }
}

impl std::fmt::Display for SerialWord {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:08X}", self.number())
    }
}

impl NdiRom {
    /// The image, and where it states what the tool is.
    fn image(&self) -> (&Image, &'static IdentityAt) {
        match self {
            Self::Optical(rom) => (&rom.image, &OpticalRom::IDENTITY),
            Self::Em(rom) => (&rom.image, &EmRom::IDENTITY),
        }
    }

    /// The whole file.
    pub fn write(&self) -> Vec<u8> {
        let (image, _) = self.image();
        [&image.bytes[..], &image.trailing].concat()
    }

    /// What follows the image in its file.
    pub fn trailing(&self) -> &[u8] {
        &self.image().0.trailing
    }

    /// The sum that the image names and that of its bytes.
    pub fn checksum(&self) -> Checksum {
        match self {
            Self::Optical(rom) => rom.checksum(),
            Self::Em(rom) => rom.checksum(),
        }
    }

    pub(super) fn set_checksum(&mut self) {
        match self {
            Self::Optical(rom) => rom.set_checksum(),
            Self::Em(rom) => rom.set_checksum(),
        }
    }

    pub fn manufacturer(&self) -> String {
        let (image, at) = self.image();
        image.text(at.manufacturer, MANUFACTURER_ROOM)
    }

    pub fn part_number(&self) -> String {
        let (image, at) = self.image();
        image.text(at.part_number, PART_NUMBER_ROOM)
    }

    /// Writes a part number; whether it did: not for what is too long or no ASCII.
    pub(super) fn set_part_number(&mut self, text: &str) -> bool {
        let is_ascii = text.bytes().all(|b| matches!(b, b' '..=b'~'));
        let is_fitting = text.len() <= PART_NUMBER_ROOM && is_ascii;
        if is_fitting {
            let mut field = [0; PART_NUMBER_ROOM];
            field[..text.len()].copy_from_slice(text.as_bytes());
            match self {
                Self::Optical(rom) => rom.image.put(OpticalRom::IDENTITY.part_number, &field),
                Self::Em(rom) => rom.image.put(EmRom::IDENTITY.part_number, &field),
            }
        }
        is_fitting
    }

    pub fn serial(&self) -> SerialWord {
        let (image, at) = self.image();
        SerialWord(std::array::from_fn(|i| image[at.serial + i]))
    }

    /// What it is for: 1 a reference, 2 a probe, …
    pub fn main_type(&self) -> u8 {
        let (image, at) = self.image();
        image[at.main_type]
    }

    /// 0 removable tip, 1 fixed tip, 2 undefined.
    pub fn sub_type(&self) -> u8 {
        let (image, at) = self.image();
        image[at.sub_type]
    }

    pub fn revision(&self) -> u16 {
        let (image, at) = self.image();
        image.u16(at.revision)
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

    /// How sawNDITracker distinguishes tools: main type, serial number and part number.
    pub fn unique_id(&self) -> String {
        format!("{:02X}-{}-{}", self.main_type(), self.serial(), self.part_number())
    }

    /// The body's name: the part number, or who made it.
    pub(super) fn name(&self) -> String {
        let names = [self.part_number(), self.manufacturer()].map(|text| text.trim().to_owned());
        names.into_iter().find(|text| !text.is_empty()).unwrap_or_else(|| NAMELESS.to_owned())
    }

    pub(super) fn sensors(&self) -> Vec<Sensor> {
        match self {
            Self::Optical(rom) => rom.sensors(),
            Self::Em(rom) => rom.sensors(),
        }
    }

    /// The body of its sensors; the tip of a coil tool is the origin.
    pub(super) fn to_body(&self) -> RigidBody {
        let tip_in_body = match self {
            Self::Optical(_) => None,
            Self::Em(_) => Some(nalgebra::Point3::origin()),
        };
        RigidBody { name: self.name(), tip_in_body, sensors: self.sensors() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use time::{Duration, Month};

    #[test]
    fn serial_words_of_real_tools_are_their_days() {
        // NDI's own passive probe, and its Mini 6DOF sensor.
        for (bytes, number, date) in [
            ([0x03, 0x14, 0x80, 0x34], "34801403", "2005-01-06"),
            ([0x00, 0x10, 0x91, 0x37], "37911000", "2011-03-10"),
        ] {
            let word = SerialWord(bytes);
            assert_eq!(word.to_string(), number);
            assert_eq!(word.date().unwrap().to_string(), date);
        }
        // Day 366 (5 * 64 + 45, from 0) of a year that has 365, and a January day that calls itself
        // a February one.
        assert_eq!(SerialWord([0, 45 << 2, 0x80 | 11 << 3 | 5, 50]).date(), None);
        assert_eq!(SerialWord([0, 0, 1 << 3, 50]).date(), None);
    }

    proptest! {
        #[test]
        fn any_day_is_read_whatever_the_number(days in 0..187_000_i64, number in 0..1024_u16) {
            let first = Date::from_calendar_date(i32::from(FIRST_YEAR), Month::January, 1).unwrap();
            let date = first + Duration::days(days);
            let (years, day) = (date.year() as u16 - FIRST_YEAR, date.ordinal() - 1);
            let month = u16::from(u8::from(date.month())) - 1;
            let word = [
                number,
                number >> 8 | (day & 63) << 2,
                day >> 6 | month << 3 | (years & 1) << 7,
                years >> 1,
            ];
            let word = SerialWord(word.map(|bits| bits.to_le_bytes()[0]));
            prop_assert_eq!(word.date(), Some(date));
        }
    }
}
